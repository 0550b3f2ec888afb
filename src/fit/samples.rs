//! The usable cells of a table, or scattered samples.
//!
//! Real tables are filled where the instrument could not reach: beyond the last measured polar angle a row repeats the row
//! before it, and small plateaus of one value stand where light or camera hid the sample. Both are recognized by equal
//! neighbors, with no knowledge of the instrument, and left out. A table computed from a model holds equal neighbors too, which are
//! values: its user says that nothing was filled in.

use super::spectral::rgb_of_bands;
use crate::brdf::{Bands, ClearCoat, LightPoint, LobeGeometry, SampleSet, TabulatedBrdf};
use crate::error::{Error, Result};
use crate::math::half_difference::HalfDifference;
use crate::math::hash::{pcg4d, unit};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Usable samples under a coat.
pub(super) struct Samples<'a> {
    pub coat: ClearCoat,
    pub bands: Bands,
    pub list: Vec<Sample<'a>>,
    /// Sample after sample, band after band.
    pub values: Vec<f64>,
}

/// One usable sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<'a> {
    /// Geometry under the coat, where lobes and chi live.
    pub geometry: LobeGeometry,
    /// Geometry outside, where the gloss lobe lives.
    pub outer: LobeGeometry,
    /// Address in the color table.
    pub angles: HalfDifference,
    /// What the coat lets pass, both ways.
    pub transmittance: f64,
    /// Share of the two spheres of directions, up to a factor.
    pub solid_angle: f64,
    /// Its color, linear Rec.709, 1/sr.
    pub color: DVec3,
    /// Mean over bands, Rump et al. 2008, eqs 3 and 4; negative where the measurement is.
    pub intensity: f64,
    /// Directions outside to the light, or its middle, and to the eye.
    pub wi: DVec3,
    pub wo: DVec3,
    /// Points of an extended light; of a point light none.
    pub lights: &'a [LightPoint],
    /// Whether it belongs to a set taken for the gloss alone.
    pub apart: bool,
}

impl Sample<'_> {
    /// Half-vector angle outside, radians.
    pub fn outer_theta_h(&self) -> f64 {
        self.outer.tan2_h.sqrt().atan()
    }
}

impl Samples<'_> {
    /// The values of sample `k`, one a band.
    pub fn values(&self, k: usize) -> &[f64] {
        let n = self.bands.len();
        &self.values[k * n..(k + 1) * n]
    }

    /// Geometries outside of a sample at every point of its light, each with its share.
    pub fn outside<'b>(&self, s: &'b Sample) -> impl Iterator<Item = (LobeGeometry, f64)> + use<'b> {
        let point = s.lights.is_empty().then_some((s.outer, 1.0));
        let lit = s.lights.iter().map(|light| (LobeGeometry::of(light.direction, s.wo), light.share));
        point.into_iter().chain(lit)
    }

    /// Geometries under the coat at a few points that stand for the light, each with its share times the coat's transmittance.
    pub fn inside(&self, s: &Sample) -> Vec<(LobeGeometry, f64)> {
        if s.lights.is_empty() {
            return vec![(s.geometry, s.transmittance)];
        }
        let inner_o = self.coat.inner(s.wo);
        let above = |light: &LightPoint| light.direction.z > 0.0;
        few(s.lights)
            .into_iter()
            .filter(above)
            .map(|light| {
                let geometry = LobeGeometry::of(self.coat.inner(light.direction), inner_o);
                (geometry, light.share * self.coat.transmittance(light.direction.z, s.wo.z))
            })
            .collect()
    }
}

/// At most four points of light of the same mean and covariance: metallic lobes are wide against a lamp, and so the error is of
/// the fourth order of its width over theirs.
fn few(lights: &[LightPoint]) -> Vec<LightPoint> {
    if lights.len() <= 4 {
        return lights.to_vec();
    }
    let whole: f64 = lights.iter().map(|l| l.share).sum();
    let mean = lights.iter().map(|l| l.direction * l.share).sum::<DVec3>().normalize_or(DVec3::Z);
    let (u, v) = mean.any_orthonormal_pair();
    let [mut uu, mut uv, mut vv] = [0.0; 3];
    for l in lights {
        let (a, b) = (l.direction.dot(u), l.direction.dot(v));
        uu += l.share * a * a / whole;
        uv += l.share * a * b / whole;
        vv += l.share * b * b / whole;
    }
    let (sin, cos) = (0.5 * (2.0 * uv).atan2(uu - vv)).sin_cos();
    let variance = |a: f64, b: f64| (a * a * uu + 2.0 * a * b * uv + b * b * vv).max(0.0);
    let axes = [
        (u * cos + v * sin) * (2.0 * variance(cos, sin)).sqrt(),
        (v * cos - u * sin) * (2.0 * variance(-sin, cos)).sqrt(),
    ];
    let at = |offset: DVec3| LightPoint { direction: (mean + offset).normalize(), share: 0.25 * whole };
    axes.into_iter().flat_map(|axis| [at(axis), at(-axis)]).collect()
}

/// What became of the cells of a table, or of scattered samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SampleCounts {
    /// Cells of the table, or samples given.
    pub cells: usize,
    /// Cells of a table left out because they repeat a neighbor.
    pub repeated: usize,
    /// Cells used (a table above a million usable cells is thinned at random to about that many).
    pub used: usize,
    /// Used cells that hold the clear coat's peak.
    pub gloss: usize,
    /// Used cells whose intensity is zero or negative: they enter eq. 7 as zero, and the color table as they are.
    pub not_positive: usize,
    /// Used cells with a negative channel: noise, or a color outside the gamut of Rec.709.
    pub negative_channel: usize,
}

/// How far from a pair of directions a measurement still counts for it, radians.
const NEAR: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Most samples kept.
const LIMIT: usize = 1_000_000;
/// Relative difference of neighbors that repeat each other: plateaus were interpolated, and some three roundings of a 32-bit
/// number apart. The noise of measured ones is a hundred times this and more.
const ROUNDING: f32 = 1e-6;

/// Collects the usable cells of `table` under `coat`: all, or where it may be `filled` those that repeat no neighbor. `gloss`
/// in the counts is left at 0.
pub(super) fn of_table(
    table: &TabulatedBrdf,
    coat: &ClearCoat,
    seed: u32,
    filled: bool,
) -> (Samples<'static>, SampleCounts) {
    let [n, m] = table.resolution();
    let repeated = if filled { repeats(table) } else { vec![false; n * n * m] };
    let usable = repeated.iter().filter(|r| !**r).count();
    let keep = LIMIT as f32 / usable.max(1) as f32;
    let list: Vec<Sample> = (0..n * n)
        .into_par_iter()
        .flat_map_iter(|row| {
            let repeated = &repeated[row * m..(row + 1) * m];
            (0..m).filter(move |k| !repeated[*k] && drawn(row * m + k, seed) < keep).map(move |k| {
                let (wi, wo) = table.directions(row / n, row % n, k);
                let color = table.cell(row / n, row % n, k);
                let weight = wi.truncate().length() * wo.truncate().length();
                Sample { color, intensity: color.element_sum() / 3.0, ..bare(wi, wo, coat, weight) }
            })
        })
        .collect();
    let values = list.iter().flat_map(|s| s.color.to_array()).collect();
    let samples = Samples { coat: *coat, bands: Bands::Rgb, list, values };
    let counts = samples.counts(repeated.len(), repeated.len() - usable);
    (samples, counts)
}

/// Collects scattered samples under `coat`, and those of a set taken for the gloss alone.
///
/// # Errors
/// Sets of different bands; a light whose points are no unit directions with shares that sum to 1.
pub(super) fn of_sets<'a>(
    base: &'a SampleSet,
    gloss: Option<&'a SampleSet>,
    coat: &ClearCoat,
    seed: u32,
) -> Result<(Samples<'a>, SampleCounts)> {
    if let Some(other) = gloss.filter(|gloss| gloss.bands() != base.bands()) {
        return Err(Error::invalid(
            "fit",
            "bands of the gloss",
            format!("{:?}", other.bands()),
            "those of the others",
        ));
    }
    let to_rgb = rgb_of_bands(base.bands())?;
    let mut samples =
        Samples { coat: *coat, bands: base.bands().clone(), list: Vec::new(), values: Vec::new() };
    for (set, apart) in [(Some(base), false), (gloss, true)] {
        let Some(set) = set else { continue };
        let keep = LIMIT as f32 / set.len().max(1) as f32;
        for (k, s) in set.samples().iter().enumerate().filter(|(k, _)| drawn(*k, seed) < keep) {
            check_lights(&s.lights).map_err(|e| e.within(format!("sample {k}")))?;
            let values = set.values(k);
            samples.list.push(Sample {
                color: values.iter().zip(&to_rgb).map(|(value, rgb)| *rgb * *value).sum(),
                intensity: values.iter().sum::<f64>() / values.len() as f64,
                lights: &s.lights,
                apart,
                ..bare(s.wi, s.wo, coat, s.weight)
            });
            samples.values.extend_from_slice(values);
        }
    }
    let counts = samples.counts(base.len() + gloss.map_or(0, SampleSet::len), 0);
    Ok((samples, counts))
}

fn check_lights(lights: &[LightPoint]) -> Result<()> {
    if lights.is_empty() {
        return Ok(());
    }
    let good = |l: &LightPoint| (l.direction.length() - 1.0).abs() < 1e-6 && l.share >= 0.0;
    if let Some(bad) = lights.iter().position(|light| !good(light)) {
        let legal = "a unit direction and a share of 0 or more";
        return Err(Error::invalid(
            format!("light point {bad}"),
            "value",
            format!("{:?}", lights[bad]),
            legal,
        ));
    }
    let whole: f64 = lights.iter().map(|l| l.share).sum();
    if (whole - 1.0).abs() < 1e-6 {
        Ok(())
    } else {
        Err(Error::invalid("light", "sum of shares", whole, "1"))
    }
}

impl Samples<'_> {
    /// Mean of the colors measured within 2 degrees of a pair of directions, turned about the normal as may be; gloss included.
    pub fn near(&self, wi: DVec3, wo: DVec3) -> Option<DVec3> {
        let angles = |g: &LobeGeometry| [g.cos_i.acos(), g.cos_o.acos(), 2.0 * g.cos_d.min(1.0).acos()];
        let wanted = angles(&LobeGeometry::of(wi, wo));
        let near = |s: &&Sample| {
            let found = angles(&s.outer);
            found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < NEAR)
        };
        let (mut sum, mut count) = (DVec3::ZERO, 0usize);
        for s in self.list.iter().filter(|s| !s.apart).filter(near) {
            sum += s.color;
            count += 1;
        }
        (count > 0).then(|| sum / count as f64)
    }

    fn counts(&self, cells: usize, repeated: usize) -> SampleCounts {
        let count = |test: fn(&Sample) -> bool| self.list.iter().filter(|s| test(s)).count();
        SampleCounts {
            cells,
            repeated,
            used: self.list.len(),
            gloss: 0,
            not_positive: count(|s| s.intensity <= 0.0),
            negative_channel: self
                .values
                .chunks_exact(self.bands.len())
                .filter(|v| v.iter().any(|v| *v < 0.0))
                .count(),
        }
    }
}

fn drawn(cell: usize, seed: u32) -> f32 {
    unit(pcg4d([cell as u32, (cell as u64 >> 32) as u32, seed, 0])[0])
}

/// A black sample under light from one point.
fn bare(wi: DVec3, wo: DVec3, coat: &ClearCoat, solid_angle: f64) -> Sample<'static> {
    let (inner_i, inner_o) = (coat.inner(wi), coat.inner(wo));
    Sample {
        geometry: LobeGeometry::of(inner_i, inner_o),
        outer: LobeGeometry::of(wi, wo),
        angles: HalfDifference::of(inner_i, inner_o),
        transmittance: coat.transmittance(wi.z, wo.z),
        solid_angle,
        color: DVec3::ZERO,
        intensity: 0.0,
        wi,
        wo,
        lights: &[],
        apart: false,
    }
}

/// Which cells repeat a neighbor but for rounding, and so were filled in. A table of which more than half would go is no filled
/// measurement but a function with plateaus (a matte one, say), and nothing is left out.
fn repeats(table: &TabulatedBrdf) -> Vec<bool> {
    let [n, m] = table.resolution();
    let values = table.values();
    let at = |a: usize, b: usize, k: usize| values[(a * n + b) * m + k];
    let reach_in = reach(n, |a| (0..n).all(|b| (0..m).all(|k| at(a, b, k) == at(a - 1, b, k))));
    let reach_out = reach(n, |b| (0..n).all(|a| (0..m).all(|k| at(a, b, k) == at(a, b - 1, k))));
    let marks: Vec<bool> = (0..n * n * m)
        .into_par_iter()
        .map(|cell| {
            let (a, b, k) = (cell / m / n, cell / m % n, cell % m);
            if a >= reach_in || b >= reach_out {
                return true;
            }
            let value = at(a, b, k);
            // A clipped black is a value, not a filling.
            value != [0.0; 3]
                && ((b > 0 && same(at(a, b - 1, k), value))
                    || (b + 1 < reach_out && same(at(a, b + 1, k), value))
                    || (k > 0 && same(at(a, b, k - 1), value))
                    || (k + 1 < m && same(at(a, b, k + 1), value)))
        })
        .collect();
    let share = marks.iter().filter(|r| **r).count();
    if 2 * share > marks.len() { vec![false; marks.len()] } else { marks }
}

/// Whether two cells are one value but for rounding.
fn same(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= ROUNDING * a.abs().max(b.abs()))
}

/// Number of rows before the run of repeated rows at the far end of an axis of `n`.
fn reach(n: usize, repeats: impl Fn(usize) -> bool) -> usize {
    (1..n).rev().find(|k| !repeats(*k)).map_or(1, |k| k + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::BrdfSample;
    use crate::math::half_difference::spherical;

    fn wavy(wi: DVec3, wo: DVec3) -> DVec3 {
        DVec3::new(wi.z + 2.0 * wo.z, wi.dot(wo), 0.5 + wi.x * wo.x)
    }

    #[test]
    fn repeated_rows_at_the_ends_are_left_out() {
        let table = TabulatedBrdf::from_fn(10, 12, wavy).unwrap();
        let mut values = table.values().to_vec();
        let row = |a: usize, b: usize| (a * 10 + b) * 12;
        for a in 0..10 {
            for b in 8..10 {
                values.copy_within(row(a, 7)..row(a, 8), row(a, b));
            }
        }
        for a in 7..10 {
            values.copy_within(row(6, 0)..row(7, 0), row(a, 0));
        }
        let filled = TabulatedBrdf::new(10, 12, values).unwrap();
        let (samples, counts) = of_table(&filled, &ClearCoat::NONE, 0, true);
        assert_eq!(counts.used, 7 * 8 * 12);
        assert_eq!(samples.list.len(), counts.used);
        assert_eq!(counts.repeated, 1200 - counts.used);
        assert_eq!(of_table(&filled, &ClearCoat::NONE, 0, false).1.used, 1200);
    }

    #[test]
    fn a_plateau_is_left_out_and_a_matte_table_is_not() {
        let table = TabulatedBrdf::from_fn(10, 12, wavy).unwrap();
        let mut values = table.values().to_vec();
        for b in 2..5 {
            for k in 3..6 {
                // One value but for the last bits, as interpolation leaves it.
                values[(4 * 10 + b) * 12 + k] = [0.7 * (1.0 + k as f32 * f32::EPSILON); 3];
            }
        }
        let filled = TabulatedBrdf::new(10, 12, values).unwrap();
        assert_eq!(of_table(&filled, &ClearCoat::NONE, 0, true).1.repeated, 9);
        let matte = TabulatedBrdf::from_fn(10, 12, |_, _| DVec3::splat(0.2)).unwrap();
        assert_eq!(of_table(&matte, &ClearCoat::NONE, 0, true).1.repeated, 0);
    }

    #[test]
    fn negative_values_are_counted() {
        let table = TabulatedBrdf::from_fn(6, 6, |wi, wo| {
            if wi.z > 0.9 { DVec3::splat(-wo.z) } else { DVec3::new(-0.1, wi.z, wo.z) }
        })
        .unwrap();
        let (samples, counts) = of_table(&table, &ClearCoat::NONE, 0, true);
        assert_eq!(counts.negative_channel, samples.list.len());
        assert!(counts.not_positive > 0 && counts.not_positive < samples.list.len());
    }

    #[test]
    fn few_points_of_light_have_the_moments_of_all() {
        let direction = |k: u32| spherical(0.6 + 0.03 * f64::from(k % 10), 0.2 + 0.02 * f64::from(k / 10));
        let all: Vec<LightPoint> =
            (0..90).map(|k| LightPoint { direction: direction(k), share: 1.0 / 90.0 }).collect();
        let moment = |lights: &[LightPoint], f: &dyn Fn(DVec3) -> f64| -> f64 {
            lights.iter().map(|l| l.share * f(l.direction)).sum()
        };
        let standing = few(&all);
        assert_eq!(standing.len(), 4);
        let far = spherical(0.5, 2.0);
        // Directions lie on a sphere: what the light's width of 0.09 adds in the third order.
        for f in [&|d: DVec3| d.x, &|d: DVec3| d.dot(far), &|d: DVec3| d.dot(far).powi(2)]
            as [&dyn Fn(DVec3) -> f64; 3]
        {
            assert!((moment(&all, f) - moment(&standing, f)).abs() < 3e-4);
        }
        assert_eq!(few(&all[..3]).len(), 3);
    }

    #[test]
    fn lights_and_bands_that_do_not_fit_are_refused() {
        let mut set = SampleSet::new(Bands::Rgb).unwrap();
        let light = LightPoint { direction: DVec3::Z, share: 0.5 };
        let sample = BrdfSample { lights: vec![light], ..BrdfSample::new(DVec3::Z, DVec3::Z, 1.0) };
        set.push(sample, &[1.0; 3]).unwrap();
        let refused = |base: &SampleSet, gloss: Option<&SampleSet>| {
            of_sets(base, gloss, &ClearCoat::NONE, 0).err().map(|e| e.to_string()).unwrap()
        };
        assert!(refused(&set, None).starts_with("sample 0: light: sum of shares"));
        let other = SampleSet::new(Bands::Wavelengths(vec![500.0])).unwrap();
        assert!(refused(&other, Some(&set)).contains("bands of the gloss"));
    }
}
