//! How far two mixes are apart, number by number.

use super::{Mix, MixFlakes, MixSlice};
use crate::paint::difference::{Differences, color_table, layout, note, smooth, structure, texels};
use glam::DVec3;

impl Mix {
    /// Largest absolute difference of every group of numbers in which two mixes differ; structures that differ (names too)
    /// count infinity. Provenance and gaps, which say where the numbers came from, do not count.
    pub fn differences(&self, other: &Self) -> Differences {
        let mut list = Vec::new();
        structure(&mut list, "number of paints", self.constituents.len() == other.constituents.len());
        for (a, b) in self.constituents.iter().zip(&other.constituents) {
            let place = format!("{}: ", a.name);
            structure(&mut list, format!("{place}name"), a.name == b.name);
            smooth(&mut list, &place, (&a.coat, a.diffuse, &a.lobes), (&b.coat, b.diffuse, &b.lobes));
            color_table(&mut list, &place, &a.colors, &b.colors);
        }
        structure(
            &mut list,
            "path, cost or threshold",
            (self.path, self.cost, self.threshold) == (other.path, other.cost, other.threshold),
        );
        match (&self.flakes, &other.flakes) {
            (Some(a), Some(b)) => flakes(&mut list, a, b),
            (a, b) => structure(&mut list, "flakes in one only", a.is_some() == b.is_some()),
        }
        list
    }
}

fn flakes(list: &mut Differences, a: &MixFlakes, b: &MixFlakes) {
    if !layout(list, &a.layout(), &b.layout()) {
        return;
    }
    fn rows(flakes: &MixFlakes) -> impl Iterator<Item = &MixSlice> {
        flakes.levels.iter().flat_map(|l| &l.slices)
    }
    let slices = || rows(a).zip(rows(b));
    let alike = slices().all(|(a, b)| a.groups == b.groups && a.boxes.len() == b.boxes.len());
    structure(list, "flakes: arcs or groups", alike);
    if !alike {
        return;
    }
    let probabilities = slices().flat_map(|(a, b)| a.probabilities.iter().zip(&b.probabilities));
    let boxes = slices().flat_map(|(a, b)| a.boxes.iter().zip(&b.boxes));
    let corners = boxes.map(|(a, b)| texels(a.as_flattened(), b.as_flattened()));
    let gains = slices().map(|(a, b)| texels(&a.gains, &b.gains));
    let largest = |pairs: &mut dyn Iterator<Item = (DVec3, DVec3)>| {
        pairs.map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f64::max)
    };
    let means = &mut slices().flat_map(|(a, b)| a.means.iter().copied().zip(b.means.iter().copied()));
    note(list, "flakes: probabilities", probabilities.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
    note(list, "flakes: corners, Lab", corners.fold(0.0, f64::max));
    note(list, "flakes: means, 1/sr", largest(means));
    let deviations =
        &mut slices().flat_map(|(a, b)| a.deviations.iter().copied().zip(b.deviations.iter().copied()));
    note(list, "flakes: deviations, 1/sr", largest(deviations));
    note(list, "flakes: gains", gains.fold(0.0, f64::max));
}
