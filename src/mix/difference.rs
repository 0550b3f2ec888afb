//! How far two mixes are apart, number by number.

use super::{Mix, MixFlakes, MixSlice};
use crate::paint::difference::{Differences, color_table, layout, note, smooth, structure, texels};

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
    let alike = slices().all(|(a, b)| a.arcs.len() == b.arcs.len() && a.means.len() == b.means.len());
    structure(list, "flakes: arcs or means", alike);
    if !alike {
        return;
    }
    let arcs = || slices().flat_map(|(a, b)| a.arcs.iter().zip(&b.arcs));
    let probability = arcs().map(|(a, b)| (a.probability - b.probability).abs());
    let corners = arcs().map(|(a, b)| texels(a.boxes.as_flattened(), b.boxes.as_flattened()));
    let means = slices().flat_map(|(a, b)| a.means.iter().zip(&b.means));
    let means = means.map(|(a, b)| (*a - *b).abs().max_element());
    note(list, "flakes: probabilities", probability.fold(0.0, f64::max));
    note(list, "flakes: corners, Lab", corners.fold(0.0, f64::max));
    note(list, "flakes: means, 1/sr", means.fold(0.0, f64::max));
}
