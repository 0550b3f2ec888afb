//! How far two paints are apart, number by number.

use super::{Flakes, Layout, Paint};
use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::cluster::{Cluster, SliceStatistics};

/// Named differences; what is equal is not listed. Structures that differ count infinity, so that no tolerance accepts them;
/// JSON, which has no infinity, shows null.
pub type Differences = Vec<(String, f64)>;

/// Adds a difference unless it is 0.
pub(crate) fn note(list: &mut Differences, what: impl Into<String>, value: f64) {
    if value != 0.0 {
        list.push((what.into(), value));
    }
}

impl Paint {
    /// Largest absolute difference of every group of numbers in which two paints differ; structures that differ count
    /// infinity.
    /// Clusters with equal boxes count as one, wherever they stand in the row; provenance does not count.
    pub fn differences(&self, other: &Self) -> Differences {
        let mut list = Vec::new();
        smooth(
            &mut list,
            "",
            (&self.coat, self.diffuse, &self.lobes),
            (&other.coat, other.diffuse, &other.lobes),
        );
        color_table(&mut list, "", &self.colors, &other.colors);
        match (&self.flakes, &other.flakes) {
            (Some(a), Some(b)) => flakes(&mut list, a, b),
            (a, b) => structure(&mut list, "flakes in one only", a.is_some() == b.is_some()),
        }
        list
    }
}

/// Adds an infinite difference of structures unless they are equal.
pub(crate) fn structure(list: &mut Differences, what: impl Into<String>, equal: bool) {
    note(list, what, if equal { 0.0 } else { f64::INFINITY });
}

/// Differences of two color tables.
pub(crate) fn color_table(list: &mut Differences, place: &str, a: &ColorTable, b: &ColorTable) {
    structure(list, format!("{place}color table: size"), a.size() == b.size());
    if a.size() == b.size() {
        structure(list, format!("{place}color table: measured texels"), a.measured() == b.measured());
        note(list, format!("{place}color table"), texels(a.texels(), b.texels()));
    }
}

/// Differences of everything in two layouts but the number of slices; whether levels and slices have partners.
pub(crate) fn layout(list: &mut Differences, a: &Layout, b: &Layout) -> bool {
    structure(list, "flakes: angle grid", a.grid == b.grid);
    structure(list, "flakes: slice size", a.size == b.size);
    structure(list, "flakes: steps of the inverse CDF", a.inverse_cdf_steps == b.inverse_cdf_steps);
    structure(list, "flakes: missing slices", a.missing == b.missing);
    structure(list, "flakes: lifetime in one only", a.knots.is_some() == b.knots.is_some());
    let knots = |l: &Layout| l.knots.map_or([0.0; 2], |k| [k.spacing, k.compression]);
    let ([s, c], [t, d]) = (knots(a), knots(b));
    note(list, "flakes: knot spacing", (s - t).abs());
    note(list, "flakes: knot compression", (c - d).abs());
    note(list, "flakes: texel size, mm", (a.texel_mm - b.texel_mm).abs());
    let slices = |l: &Layout| l.levels.iter().map(|level| level.1).collect::<Vec<_>>();
    let alike = slices(a) == slices(b);
    structure(list, "flakes: levels or slices", alike);
    let pitches = a.levels.iter().zip(&b.levels).map(|(a, b)| (a.0 - b.0).abs());
    note(list, "flakes: lattice pitch, mm", pitches.fold(0.0, f64::max));
    alike
}

/// Differences of coat, diffuse and lobes.
pub(crate) fn smooth(
    list: &mut Differences,
    place: &str,
    a: (&ClearCoat, f64, &[Lobe]),
    b: (&ClearCoat, f64, &[Lobe]),
) {
    note(list, format!("{place}coat: index"), (a.0.ior - b.0.ior).abs());
    note(list, format!("{place}coat: mirror"), (a.0.mirror - b.0.mirror).abs());
    structure(list, format!("{place}coat: refraction in one only"), a.0.refracts == b.0.refracts);
    note(list, format!("{place}diffuse"), (a.1 - b.1).abs());
    let gloss = |coat: &ClearCoat| coat.gloss.into_iter().collect::<Vec<_>>();
    note(list, format!("{place}gloss"), lobes(&gloss(a.0), &gloss(b.0)));
    note(list, format!("{place}lobes"), lobes(a.2, b.2));
}

fn lobes(a: &[Lobe], b: &[Lobe]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    let each = |(a, b): (&Lobe, &Lobe)| {
        (a.coefficient - b.coefficient).abs().max((a.roughness - b.roughness).abs()).max((a.f0 - b.f0).abs())
    };
    a.iter().zip(b).map(each).fold(0.0, f64::max)
}

/// Largest difference of two textures; infinity if their sizes differ.
pub(crate) fn texels(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs()).fold(0.0, f64::max)
}

fn flakes(list: &mut Differences, a: &Flakes, b: &Flakes) {
    if !layout(list, &a.layout(), &b.layout()) {
        return;
    }
    let (mut corners, mut probability, mut offset, mut gain, mut bands) =
        (0.0f64, 0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for (a, b) in a.levels.iter().zip(&b.levels) {
        for (a, b) in a.slices.iter().zip(&b.slices) {
            let (c, p) = clusters(a, b);
            corners = corners.max(c);
            probability = probability.max(p);
            offset = offset.max(texels(&[a.offset], &[b.offset]));
            gain = gain.max(texels(&[a.gain], &[b.gain]));
            bands = bands.max(bands_apart(a, b));
        }
    }
    note(list, "flakes: corners, Lab", corners);
    note(list, "flakes: probabilities", probability);
    note(list, "flakes: offsets, 1/sr", offset);
    note(list, "flakes: gains", gain);
    note(list, "flakes: bands between clusters", bands);
}

/// Largest difference of the bands of two rows, in u; infinity if their numbers differ.
fn bands_apart(a: &SliceStatistics, b: &SliceStatistics) -> f64 {
    if a.fades.len() != b.fades.len() {
        return f64::INFINITY;
    }
    a.fades.iter().zip(&b.fades).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
}

/// Largest difference of corners and of probabilities, boxes matched by value.
fn clusters(a: &SliceStatistics, b: &SliceStatistics) -> (f64, f64) {
    let (a, b) = (merged(&a.clusters), merged(&b.clusters));
    if a.len() != b.len() {
        return (f64::INFINITY, f64::INFINITY);
    }
    let pairs = || a.iter().zip(&b);
    let corners = pairs().map(|(a, b)| texels(&[a.min, a.max], &[b.min, b.max])).fold(0.0, f64::max);
    let probability = pairs().map(|(a, b)| (a.probability - b.probability).abs()).fold(0.0, f64::max);
    (corners, probability)
}

/// Clusters with equal boxes made one, in the order of their corners.
fn merged(clusters: &[Cluster]) -> Vec<Cluster> {
    let corners = |c: &Cluster| [c.min, c.max];
    let order = |a: &Cluster, b: &Cluster| {
        let (a, b) = (corners(a), corners(b));
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    let mut sorted = clusters.to_vec();
    sorted.sort_by(order);
    let mut out: Vec<Cluster> = Vec::with_capacity(sorted.len());
    for c in sorted {
        match out.last_mut() {
            Some(last) if corners(last) == corners(&c) => last.probability += c.probability,
            _ => out.push(c),
        }
    }
    out
}
