//! How much a mix of three and more paints depends on their order.

use crate::cluster::SliceStatistics;
use crate::error::{Error, Result};
use crate::mix::{CoupleOptions, couple};
use crate::paint::Paint;
use crate::parallel::TryMap;
use crate::transport::{Cost, Problem, Solver, solve};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Wasserstein-1 distances between blends at equal weights of the same paints coupled in different orders, of the finest
/// level, Delta-E between centers of boxes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OrderDependence {
    /// Orders compared with the given one.
    pub orders: usize,
    /// Mean over slices and orders.
    pub mean: f64,
    /// Largest of a slice.
    pub largest: f64,
    /// Mean distance of the given order's blend from its first paint, to compare with.
    pub from_first: f64,
}

/// Couples the paints in every order and compares the blends at equal weights.
///
/// # Errors
/// More than five paints (120 orders) or fewer than three; paints of unequal angle grids or numbers of levels; those of
/// [`couple`].
pub fn order_dependence(paints: &[(String, &Paint)], options: &CoupleOptions) -> Result<OrderDependence> {
    let n = paints.len();
    if !(3..=5).contains(&n) {
        return Err(Error::invalid("order", "number of paints", n, "3 to 5"));
    }
    let layout = |p: &Paint| p.flakes.as_ref().map(|f| (f.grid.clone(), f.levels.len()));
    if let Some((name, _)) = paints.iter().find(|p| layout(p.1) != layout(paints[0].1)) {
        let legal = "the grid and levels of the first paint";
        return Err(Error::unsupported(name.clone(), "flakes", "another layout", legal));
    }
    let blend = |order: &[usize]| -> Result<Vec<SliceStatistics>> {
        let ordered: Vec<_> = order.iter().map(|k| paints[*k].clone()).collect();
        let blend = couple(&ordered, options, &|| ())?.0.blend(&vec![1.0 / n as f64; n])?;
        Ok(blend.flakes.and_then(|f| f.levels.into_iter().next()).map_or_else(Vec::new, |l| l.slices))
    };
    let orders = permutations(n);
    let given = blend(&orders[0])?;
    let distances = |other: &[SliceStatistics]| -> Result<Vec<f64>> {
        let pairs = given.iter().zip(other).filter(|(a, b)| !a.is_left_out() && !b.is_left_out());
        pairs.collect::<Vec<_>>().into_par_iter().try_map(|(a, b)| distance(a, b))
    };
    let first = paints[0].1.flakes.as_ref().map_or(&[][..], |f| &f.levels[0].slices);
    let from_first = super::stage::mean(distances(first)?);
    let mut all = Vec::new();
    for order in &orders[1..] {
        all.extend(distances(&blend(order)?)?);
    }
    Ok(OrderDependence {
        orders: orders.len() - 1,
        mean: super::stage::mean(all.iter().copied()),
        largest: super::stage::largest(all),
        from_first,
    })
}

fn distance(a: &SliceStatistics, b: &SliceStatistics) -> Result<f64> {
    let side = |s: &SliceStatistics| -> (Vec<DVec3>, Vec<f64>) {
        s.clusters.iter().map(|c| (c.center(), c.probability)).unzip()
    };
    let ((ca, pa), (cb, pb)) = (side(a), side(b));
    Ok(solve(&Problem::from_centers(&ca, &pa, &cb, &pb, Cost::Euclidean)?, Solver::default())?
        .certificate
        .cost)
}

/// All orders of 0 to n - 1, that one first.
fn permutations(n: usize) -> Vec<Vec<usize>> {
    if n == 0 {
        return vec![Vec::new()];
    }
    let inserted = |shorter: Vec<usize>| {
        (0..n).rev().map(move |place| {
            let mut order = shorter.clone();
            order.insert(place, n - 1);
            order
        })
    };
    permutations(n - 1).into_iter().flat_map(inserted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_tried_once() {
        let orders = permutations(4);
        assert_eq!(orders[0], [0, 1, 2, 3]);
        let different: std::collections::BTreeSet<_> = orders.iter().collect();
        assert_eq!((orders.len(), different.len()), (24, 24));
    }
}
