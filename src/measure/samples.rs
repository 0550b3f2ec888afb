//! From pictures to samples of the homogeneous BRDF (Rump et al. 2008, section 5.1.1).
//!
//! Two sets, because a fit of everything at once loses the gloss. The first, for diffuse and glitter: pairs chosen evenly over the
//! hemispheres of views and lights, and in each of them means over square patches, whose side grows with theta_H from a few texels
//! to many, since glitter changes fastest about the mirror direction and noise of flakes counts most far from it; patches that may
//! see the mirrored flash are left out. The second, for the gloss: pictures in which the mirrored flash is found where
//! calibration says, and in them patches of 4 x 4 texels of a picture of 700 about it.
//!
//! Departure: weights. A mean of a logarithm over noisy patches is no logarithm of a mean, so that patches smaller than some ten
//! lit flakes would darken the fit; the sides are options. A highlight broader than the flash is taken too, though it has no place.

use super::blemishes::{Blemishes, Cells, Contrast};
use super::highlight::{Mirrored, find_mirrored};
use super::{PairGeometry, Sheet};
use crate::brdf::{Bands, BrdfSample, SampleSet};
use crate::error::{Error, Result};
use crate::math::hash::pcg4d;
use crate::parallel::TryMap;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Side of the cells of directions over which pairs are spread, radians: 15 degrees.
const CELL: f64 = FRAC_PI_2 / 6.0;
/// A patch whose mirrored eye passes the flash window by less than this many of its half diagonals may see it.
const MARGIN: f64 = 1.5;
/// A calibration is accurate if the highlight is found within this many of its half diagonals of its place.
const CLOSE: f64 = 0.25;
/// How far about the mirrored window the second set reaches, half diagonals.
const AROUND: f64 = 0.7;

/// Pictures ready to be sampled: geometry known, light linear.
pub trait Pairs: Sync {
    /// Number of cameras; each has a flash.
    fn cameras(&self) -> usize;
    /// Eye and light of a pair; `None` if one of them is not calibrated.
    fn geometry(&self, camera: usize, light: usize) -> Option<PairGeometry>;
    /// Columns and rows of a picture.
    fn size(&self) -> [usize; 2];
    /// Radiance per unit intensity of the flash, 1/mm^2, row-major; pixels that are not known are no numbers.
    ///
    /// # Errors
    /// The picture is missing, damaged or contradicts itself.
    fn radiance(&self, camera: usize, light: usize) -> Result<Vec<[f32; 3]>>;
}

/// How pictures are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SamplingOptions {
    /// Samples of the first set, about, 100 to 1,000,000.
    pub samples: usize,
    /// Samples of the second set, about, 0 to 20,000.
    pub gloss_samples: usize,
    /// Pairs that are looked at for the first set, at most.
    pub pairs: usize,
    /// Sides of the patches at theta_H = 0 and at its greatest, as shares of the sample's width. Rump et al. 2008: 7 and 70 of 700
    /// pixels, on a sample of 66 mm; on one of 17 mm patches of a hundredth hold a few flakes, and the fit of their logarithms is
    /// 5 Delta-E too dark about the mirror direction, where a sixteenth leaves 1.5.
    pub patch: [f64; 2],
    /// Side of the patches of the second set as a share of the sample's width; Rump et al. 2008: 4 of 700.
    pub gloss_patch: f64,
    /// Seed of the choice among pairs.
    pub seed: u32,
}

impl Default for SamplingOptions {
    fn default() -> Self {
        Self {
            samples: 20_000,
            gloss_samples: 4000,
            pairs: 1000,
            patch: [0.06, 0.1],
            gloss_patch: 4.0 / 700.0,
            seed: 1,
        }
    }
}

/// What was taken from the pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Extraction {
    /// For diffuse and glitter.
    pub base: SampleSet,
    /// For the gloss; empty where no picture shows it.
    pub gloss: SampleSet,
    /// What was looked at and what was left out.
    pub report: ExtractionReport,
}

/// What was looked at and what was left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExtractionReport {
    /// Pairs looked at.
    pub pairs: usize,
    /// The check of Fig. 7, a pair each.
    pub highlights: Vec<HighlightCheck>,
    /// Pairs left out, with the reason.
    pub left_out: Vec<String>,
    /// Places of the panel that are not like the others: no sample touches them.
    pub blemishes: Blemishes,
    /// Samples not taken for that.
    pub blemished: usize,
}

/// The highlight of a pair: where calibration puts it, and where it was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HighlightCheck {
    /// The camera.
    pub camera: usize,
    /// The camera whose flash it is.
    pub light: usize,
    /// Distance of the two middles, pixels; none if no highlight was found, or one without a place.
    pub distance_px: Option<f64>,
    /// Whether what was found is broader than any mirrored flash: the gloss of a rough surface, or the paint's own glow. It has no
    /// place to speak of, and says nothing of the calibration.
    pub broad: bool,
    /// Half the diagonal of the predicted highlight, pixels: what a distance is to be held against.
    pub radius_px: f64,
}

/// A sample with its color and the middle of its patch, millimetres.
type Patch = (BrdfSample, [f64; 3], DVec2);

/// What one pair gives.
#[derive(Default)]
struct Taken {
    base: Vec<Patch>,
    gloss: Vec<Patch>,
    /// Half of the sides of their patches, millimetres.
    half_mm: [f64; 2],
    contrast: Option<Contrast>,
    highlight: Option<HighlightCheck>,
    left_out: Option<String>,
}

/// Takes both sets of samples. `tick` is called once a pair ([`SamplingOptions::pairs`] at most).
///
/// Pictures that cannot be used are left out and named. The same samples for any number of threads.
///
/// # Errors
/// An option outside its range; no usable pair.
pub fn extract(
    pairs: &dyn Pairs,
    sample_mm: [f64; 2],
    options: &SamplingOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<Extraction> {
    options.validate()?;
    let chosen = choose(pairs, options);
    let mirrored = chosen.iter().filter(|(_, _, g)| Window::on_sample(g, sample_mm).is_some()).count();
    let sampler = Sampler {
        cells: Cells::new(sample_mm),
        pairs,
        options,
        sample_mm,
        largest: chosen.iter().map(|(_, _, g)| g.angles(DVec2::ZERO).theta_h).fold(0.0, f64::max),
        base_each: options.samples.div_ceil(chosen.len().max(1)),
        gloss_each: options.gloss_samples.div_ceil(mirrored.max(1)),
    };
    let mut taken = chosen.par_iter().try_map(|(camera, light, geometry)| {
        let taken = sampler.take(*camera, *light, geometry);
        tick();
        Ok(taken)
    })?;
    let mut base = SampleSet::new(Bands::Rgb)?;
    let mut gloss = SampleSet::new(Bands::Rgb)?;
    let contrasts: Vec<Contrast> = taken.iter_mut().filter_map(|pair| pair.contrast.take()).collect();
    let blemishes = sampler.cells.blemishes(&contrasts);
    let mut report = ExtractionReport {
        pairs: taken.len(),
        highlights: vec![],
        left_out: vec![],
        blemishes,
        blemished: 0,
    };
    for pair in taken {
        for (set, patches, half) in
            [(&mut base, pair.base, pair.half_mm[0]), (&mut gloss, pair.gloss, pair.half_mm[1])]
        {
            for (sample, color, middle) in patches {
                if report.blemishes.touch(middle, DVec2::splat(half)) {
                    report.blemished += 1;
                } else {
                    set.push(sample, &color)?;
                }
            }
        }
        report.highlights.extend(pair.highlight);
        report.left_out.extend(pair.left_out);
    }
    if base.is_empty() {
        let first = report.left_out.first().map_or("no patch is clear", String::as_str);
        let found = format!("none of {} pairs, as {first}", report.pairs);
        return Err(Error::invalid("samples", "usable pictures", found, "at least one"));
    }
    Ok(Extraction { base, gloss, report })
}

impl SamplingOptions {
    /// Checks every number.
    ///
    /// # Errors
    /// One outside its range, named.
    pub fn validate(&self) -> Result<()> {
        let share = |what: &str, value: f64| {
            let legal = 1e-3..=0.5;
            if legal.contains(&value) {
                return Ok(());
            }
            Err(Error::invalid("sampling", what, value, "0.001 to 0.5 of the sample's width"))
        };
        let number = |what: &str, value: usize, legal: std::ops::RangeInclusive<usize>| {
            if legal.contains(&value) {
                return Ok(());
            }
            Err(Error::invalid("sampling", what, value, format!("{} to {}", legal.start(), legal.end())))
        };
        number("samples", self.samples, 100..=1_000_000)?;
        number("gloss samples", self.gloss_samples, 0..=20_000)?;
        number("pairs", self.pairs, 1..=1_000_000)?;
        self.patch.iter().try_for_each(|side| share("patch", *side))?;
        share("gloss patch", self.gloss_patch)
    }
}

/// Pairs spread evenly over the hemispheres of views and lights, in their own order: one of each cell of directions, then a second
/// one, until there are enough.
fn choose(pairs: &dyn Pairs, options: &SamplingOptions) -> Vec<(usize, usize, PairGeometry)> {
    let cell = |w: DVec3| {
        let polar = (w.truncate().length().atan2(w.z) / CELL) as u32;
        // Rings of cells about as wide as they are high.
        let around = (4 * polar).max(1);
        let turn = w.y.atan2(w.x) / std::f64::consts::TAU + 0.5;
        (polar, ((turn * f64::from(around)) as u32).min(around - 1))
    };
    let mut cells: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for camera in 0..pairs.cameras() {
        for light in 0..pairs.cameras() {
            if let Some(geometry) = pairs.geometry(camera, light) {
                let (wi, wo) = geometry.rays(DVec2::ZERO);
                let draw = pcg4d([camera as u32, light as u32, options.seed, 0])[0];
                cells.entry((cell(wi), cell(wo))).or_default().push((draw, camera, light));
            }
        }
    }
    let mut ranked: Vec<_> = cells
        .into_values()
        .flat_map(|mut members| {
            members.sort_unstable();
            members.into_iter().enumerate().map(|(rank, (draw, camera, light))| (rank, draw, camera, light))
        })
        .collect();
    ranked.sort_unstable();
    ranked.truncate(options.pairs);
    let mut chosen: Vec<(usize, usize)> =
        ranked.into_iter().map(|(_, _, camera, light)| (camera, light)).collect();
    chosen.sort_unstable();
    let known = |(camera, light)| Some((camera, light, pairs.geometry(camera, light)?));
    chosen.into_iter().filter_map(known).collect()
}

/// What is the same for all pairs.
struct Sampler<'a> {
    pairs: &'a dyn Pairs,
    options: &'a SamplingOptions,
    sample_mm: [f64; 2],
    /// Greatest theta_H of all pairs.
    largest: f64,
    base_each: usize,
    gloss_each: usize,
    /// In which blemishes are looked for.
    cells: Cells,
}

impl Sampler<'_> {
    fn take(&self, camera: usize, light: usize, pair: &PairGeometry) -> Taken {
        let mut taken = Taken::default();
        let pixels = match self.pairs.radiance(camera, light) {
            Ok(pixels) => pixels,
            Err(error) => {
                taken.left_out = Some(format!("camera {camera}, light {light}: {error}"));
                return taken;
            }
        };
        let window = Window::on_sample(pair, self.sample_mm);
        let share = if self.largest > 0.0 { pair.angles(DVec2::ZERO).theta_h / self.largest } else { 0.0 };
        let side = self.options.patch[0] + share * (self.options.patch[1] - self.options.patch[0]);
        taken.half_mm = [side, self.options.gloss_patch].map(|side| 0.5 * side * self.sample_mm[0]);
        let far = |middle: DVec2, half_diagonal: f64| {
            window.as_ref().is_none_or(|window| window.distance(middle) > MARGIN * half_diagonal)
        };
        taken.base = self.patches(&pixels, pair, side, self.base_each, far, false);
        if window.is_none() {
            taken.contrast = Some(self.cells.contrast(&pixels, self.pairs.size(), pair));
        }
        let Some(window) = window.as_ref().filter(|_| self.options.gloss_samples > 0) else { return taken };
        let check = self.check(&pixels, camera, light, window);
        if check.broad || check.distance_px.is_some_and(|distance| distance <= CLOSE * check.radius_px) {
            let about = |middle: DVec2, _: f64| window.distance(middle) <= AROUND * window.radius_mm;
            taken.gloss = self.patches(&pixels, pair, self.options.gloss_patch, self.gloss_each, about, true);
        }
        taken.highlight = Some(check);
        taken
    }

    /// Means over up to `most` of the square patches of a side (a share of the sample's width) that are `wanted` by their middle and
    /// half diagonal, millimetres, spread evenly.
    fn patches(
        &self,
        pixels: &[[f32; 3]],
        pair: &PairGeometry,
        side: f64,
        most: usize,
        wanted: impl Fn(DVec2, f64) -> bool,
        extended: bool,
    ) -> Vec<Patch> {
        let sheet = Sheet::new(self.sample_mm, side * self.sample_mm[0]);
        let half_diagonal = sheet.texel_mm * std::f64::consts::FRAC_1_SQRT_2;
        let middle =
            |k: usize| sheet.place_mm((k % sheet.size[0]) as f64 + 0.5, (k / sheet.size[0]) as f64 + 0.5);
        let inside: Vec<usize> =
            (0..sheet.size[0] * sheet.size[1]).filter(|k| wanted(middle(*k), half_diagonal)).collect();
        // Evenly over the list: the golden section of the plane would be no better on patches that touch.
        let count = most.min(inside.len());
        let spread = (0..count).map(|k| inside[(2 * k + 1) * inside.len() / (2 * count)]);
        spread
            .filter_map(|k| {
                let color = sheet.texel(pixels, self.pairs.size(), pair, k)?;
                let (wi, wo) = pair.rays(middle(k));
                let mut sample = BrdfSample::new(wi, wo, 1.0);
                if extended {
                    sample.lights = pair.lights(middle(k));
                }
                (wi.z > 0.0 && wo.z > 0.0).then_some((sample, color, middle(k)))
            })
            .collect()
    }

    /// The check of Fig. 7.
    fn check(&self, pixels: &[[f32; 3]], camera: usize, light: usize, window: &Window) -> HighlightCheck {
        let found = find_mirrored(pixels, self.pairs.size(), window.area_px);
        let broad = found == Mirrored::Broad;
        let distance_px = match found {
            Mirrored::At(highlight) => Some(highlight.center_px.distance(window.center_px)),
            _ => None,
        };
        HighlightCheck { camera, light, distance_px, broad, radius_px: window.radius_px }
    }
}

/// The flash window as the sample mirrors it.
struct Window {
    /// Middle and half diagonal on the sample, millimetres.
    center_mm: DVec2,
    radius_mm: f64,
    /// Middle, half diagonal and area in the picture, pixels, of the part that lies on the sample.
    center_px: DVec2,
    radius_px: f64,
    area_px: f64,
}

impl Window {
    /// `None` unless it touches the sample.
    fn on_sample(pair: &PairGeometry, sample_mm: [f64; 2]) -> Option<Self> {
        let half = 0.5 * DVec2::from(sample_mm);
        let places: Vec<DVec2> = pair.points_mm.iter().map(|point| pair.mirrored_place(*point)).collect();
        let inside: Vec<DVec2> = places.iter().copied().filter(|p| p.abs().cmple(half).all()).collect();
        let pixel = |place: &DVec2| pair.camera.pixel(place.extend(0.0));
        let seen: Vec<DVec2> = inside.iter().filter_map(pixel).collect();
        if seen.is_empty() {
            return None;
        }
        let middle = |points: &[DVec2]| points.iter().sum::<DVec2>() / points.len() as f64;
        let corners = pair.corners_mm.map(|corner| pair.mirrored_place(corner));
        let reach =
            |points: &[DVec2], from: DVec2| points.iter().map(|p| p.distance(from)).fold(0.0, f64::max);
        let (center_mm, center_px) = (middle(&corners), middle(&seen));
        let corners_px: Vec<DVec2> = corners.iter().filter_map(pixel).collect();
        Some(Self {
            center_mm,
            radius_mm: reach(&corners, center_mm),
            center_px,
            radius_px: reach(&seen, center_px).max(1.0),
            area_px: area(&corners_px) * inside.len() as f64 / places.len() as f64,
        })
    }

    /// How far a place of the sample is from it, millimetres; negative well inside.
    fn distance(&self, place_mm: DVec2) -> f64 {
        place_mm.distance(self.center_mm) - self.radius_mm
    }
}

/// Area of a polygon.
pub(super) fn area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    0.5 * corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs()
}
