//! The depth of flakes: a flake at depth z is seen `z tan(refracted view)` from its place, towards the eye.
//!
//! A slice knows theta_h and theta_i alone, so the azimuth of the view is a convention: texture columns run along the
//! azimuth of the half vector, and the eye is the second of the two directions at phi_d = 90 degrees, whose other horizontal
//! part points along falling rows. What that form cannot hold is measured by the pair with light and eye exchanged, which has
//! the same theta_h and theta_i: each flake is as bright, and shifted to the other side. The light's own path decides on
//! attenuation alone.

use super::slice::Shift;
use crate::btf::AngleGrid;
use crate::color::luminance;
use crate::simulate::optics::film_optics::FilmView;
use glam::{DVec2, DVec3};
use serde::Serialize;

/// How much a slice and the same cell seen from the opposite azimuth differ.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OppositeView {
    /// Mean squared difference of their luminances, texel by texel.
    difference: f64,
    /// Mean variance of both.
    variance: f64,
    /// Distance between the two images of a flake half way down the lowest film, texels.
    distance: f64,
}

/// What the form of the slices cannot hold of the flakes' depth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParallaxError {
    /// Texel-wise rms difference of two views from opposite azimuths over the rms of a slice, all slices together; 0 where
    /// the views agree, the square root of 2 where they have nothing in common.
    pub rms_over_std: f64,
    /// The same over the slices of one theta_i each.
    pub rows: Vec<ParallaxRow>,
}

/// The slices of one theta_i.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParallaxRow {
    /// Angle between half vector and light, degrees.
    pub theta_i_deg: f64,
    /// Mean distance between the two images of a flake half way down the lowest film, texels.
    pub texels: f64,
    /// As [`ParallaxError::rms_over_std`].
    pub rms_over_std: f64,
}

/// The shifts of every film's flakes, topmost first, for an eye at `wo`; `films` are index and thickness, texels, as `views`
/// has them.
pub(super) fn shifts(wo: DVec3, views: &[FilmView], films: &[(f64, f64)]) -> Vec<Shift> {
    let mut above = DVec2::ZERO;
    let shift = |(view, (index, thickness)): (&FilmView, &(f64, f64))| {
        // Refraction keeps the horizontal part of a unit direction times the index.
        let by_depth = wo.truncate() * (thickness / (index * view.geometry.cos_inside[1]));
        let shift = Shift { above, by_depth };
        above += by_depth;
        shift
    };
    views.iter().zip(films).map(shift).collect()
}

impl OppositeView {
    /// Compares both views; `pair` are the lowest film's shifts.
    pub fn new(texels: &[DVec3], opposite: &[DVec3], pair: [Shift; 2]) -> Self {
        let n = texels.len() as f64;
        let moments = |light: &[DVec3]| {
            let (sum, squares) = light.iter().fold((0.0, 0.0), |(sum, squares), t| {
                let l = luminance(*t);
                (sum + l, squares + l * l)
            });
            squares / n - (sum / n).powi(2)
        };
        let square = |(a, b): (&DVec3, &DVec3)| luminance(*a - *b).powi(2);
        let middle = pair.map(|shift| shift.above + 0.5 * shift.by_depth);
        Self {
            difference: texels.iter().zip(opposite).map(square).sum::<f64>() / n,
            variance: 0.5 * (moments(texels) + moments(opposite)),
            distance: (middle[0] - middle[1]).length(),
        }
    }
}

impl ParallaxError {
    /// The errors of all slices of a grid, in its order.
    pub(super) fn new(slices: &[OppositeView], grid: &AngleGrid) -> Self {
        let mut rows = vec![(OppositeView::default(), 0.0); grid.rows().len()];
        let mut total = OppositeView::default();
        for (k, slice) in slices.iter().enumerate() {
            let (row, count) = &mut rows[grid.bins_of(k).1];
            for sum in [row, &mut total] {
                sum.difference += slice.difference;
                sum.variance += slice.variance;
                sum.distance += slice.distance;
            }
            *count += 1.0;
        }
        let relative = |sum: &OppositeView| {
            if sum.variance > 0.0 { (sum.difference / sum.variance).sqrt() } else { 0.0 }
        };
        let row = |(k, (sum, count)): (usize, &(OppositeView, f64))| ParallaxRow {
            theta_i_deg: (k as f64 * grid.width()).to_degrees(),
            texels: sum.distance / count,
            rms_over_std: relative(sum),
        };
        Self { rms_over_std: relative(&total), rows: rows.iter().enumerate().map(row).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use crate::simulate::composition::Composition;
    use crate::simulate::optics::film_optics::PaintOptics;

    #[test]
    fn flakes_are_seen_along_the_refracted_ray() {
        let paint = Composition::parse(
            "substrate = { albedo = 0.5 }\nfilm = [{ thickness_um = 15, index = 1.5 }, { thickness_um = 40, index = 1.4 }]\n",
        )
        .unwrap();
        let optics = PaintOptics::new(&paint).unwrap();
        let wo = spherical(1.1, 0.4);
        let mut views = Vec::new();
        optics.visit(spherical(0.3, 2.0), wo, |_, view| views.push(view.clone()));
        let [top, low] = shifts(wo, &views, &[(1.4, 20.0), (1.5, 7.5)])[..] else { panic!("two films") };
        let along = |index: f64| DVec2::from_angle(0.4) * (1.1f64.sin() / index).asin().tan();
        // Rounding of a few products.
        assert_eq!(top.above, DVec2::ZERO);
        assert!((top.by_depth - 20.0 * along(1.4)).length() < 1e-13);
        assert!((low.above - top.by_depth).length() < 1e-13);
        assert!((low.by_depth - 7.5 * along(1.5)).length() < 1e-13);
    }
}
