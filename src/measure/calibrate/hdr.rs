//! One linear picture from the exposures of a pair (Rump et al. 2008, section 4.2).
//!
//! Every exposure says a pixel's light with a variance: of reading, of shots, of rounding. They are averaged with weights one over
//! it. The variance is that of the light which the most sensitive unsaturated exposure says, the same light for all, so that
//! exposures that happen to be low do not get more weight; and whether a pixel is saturated in an exposure is asked of the less
//! sensitive one, so that values are not cut off on one side. Black pixels take part: they say that there is little light.

use super::decoder::Decoder;
use super::exposures::{Camera, Shown, reconcile};
use super::response::{CameraResponse, quantum};
use super::white::WhiteScale;
use crate::error::{Error, Result};
use crate::measure::{Images, Picture, Shot};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Share of saturation above which the next less sensitive exposure rules an exposure out.
const MAX_LIGHT: f64 = 0.9;
/// A pixel with less signal over noise in every channel is black.
const BLACK: f64 = 1.0;

/// Most exposures of a [`Rig`](crate::measure::Rig).
const MAX_EXPOSURES: usize = 16;

/// What is known of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PixelState {
    /// All channels are known.
    Valid,
    /// A channel is saturated in every exposure; the others may be right.
    Saturated,
    /// Nothing stands out of the noise; value and variance are right.
    Black,
    /// No number, or a pixel of the sensor that is broken; values are 0.
    Broken,
}

/// Linear light of a pair of camera and flash.
#[derive(Debug, Clone, PartialEq)]
pub struct HdrPicture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Row-major, top row first: light that saturates the first channel is 1 at an exposure of relative 1, until white balance.
    pub pixels: Vec<[f32; 3]>,
    /// Variance of each number.
    pub variance: Vec<[f32; 3]>,
    /// What is known of each pixel.
    pub mask: Vec<PixelState>,
    /// Relative values of the exposures as estimated; `None` for those left out.
    pub relative: Vec<Option<f64>>,
    /// Decibels, 20 log10 of largest over least: what the exposures can show, from one noise to saturation; what they show here.
    pub range_db: [f64; 2],
    /// The white balance, once it is done.
    pub white: Option<WhiteScale>,
    /// What was left out, and why.
    pub warnings: Vec<String>,
}

/// Merges the exposures of a pair, all of which are in memory meanwhile.
///
/// # Errors
/// No exposure can be read; a response that is no curve.
pub fn merge_exposures(
    images: &dyn Images,
    response: &CameraResponse,
    decoder: &Decoder,
    camera: usize,
    light: usize,
) -> Result<HdrPicture> {
    let rig = images.rig();
    let mut warnings = Vec::new();
    let mut pictures: Vec<(usize, Picture)> = Vec::new();
    for exposure in 0..rig.exposures.len() {
        match images.picture(Shot::Pair { camera, light, exposure }) {
            Ok(picture) if picture.pixels.len() == rig.image_px[0] * rig.image_px[1] => {
                pictures.push((exposure, picture))
            }
            Ok(picture) => warnings.push(format!("exposure {exposure} has {:?} pixels", picture.size)),
            Err(e) => warnings.push(e.to_string()),
        }
    }
    let lowest = rig.exposures.iter().map(|e| e.iso).min().unwrap_or(1).max(1);
    let shown: Vec<Shown<'_>> = pictures
        .iter()
        .map(|(index, picture)| {
            let setting = rig.exposures[*index];
            Shown { index: *index, setting, gain: f64::from(setting.iso) / f64::from(lowest), picture }
        })
        .collect();
    let sensor = Camera { decoder, noise: &response.noise, saturation: response.saturation };
    let reconciled = reconcile(&shown, &sensor);
    let mut kept = reconciled.kept;
    warnings.extend(reconciled.warnings);
    if kept.is_empty() {
        let first = warnings.first().map_or("none", String::as_str);
        let found = match warnings.len() {
            0 | 1 => first.to_owned(),
            n => format!("{first}; and {} more", n - 1),
        };
        return Err(Error::invalid("", "exposures", found, "one that can be read"));
    }
    kept.sort_by(|a, b| a.1.total_cmp(&b.1));
    let merge = Merge { shown: &shown, kept: &kept, sensor: &sensor };
    let mut picture = merge.picture(rig.image_px);
    for k in &response.broken_pixels {
        if let Some(state) = picture.mask.get_mut(*k as usize) {
            (*state, picture.pixels[*k as usize]) = (PixelState::Broken, [0.0; 3]);
        }
    }
    picture.relative = (0..rig.exposures.len())
        .map(|e| kept.iter().find(|(k, _)| shown[*k].index == e).map(|(_, relative)| *relative))
        .collect();
    picture.range_db = [merge.range_db(quantum(rig)), picture.shown_range_db()];
    picture.warnings = warnings;
    Ok(picture)
}

struct Merge<'a> {
    shown: &'a [Shown<'a>],
    /// Exposures that agree, places in `shown` with relative values, the least sensitive first.
    kept: &'a [(usize, f64)],
    sensor: &'a Camera<'a>,
}

/// A channel of a pixel in one exposure.
#[derive(Clone, Copy, Default)]
struct Said {
    light: f64,
    relative: f64,
    gain: f64,
    rounding: f64,
}

impl Merge<'_> {
    fn picture(&self, size: [usize; 2]) -> HdrPicture {
        let number = size[0] * size[1];
        let merged: Vec<([f32; 3], [f32; 3], PixelState)> =
            (0..number).into_par_iter().map(|k| self.pixel(k)).collect();
        HdrPicture {
            size,
            pixels: merged.iter().map(|m| m.0).collect(),
            variance: merged.iter().map(|m| m.1).collect(),
            mask: merged.iter().map(|m| m.2).collect(),
            relative: Vec::new(),
            range_db: [0.0; 2],
            white: None,
            warnings: Vec::new(),
        }
    }

    fn pixel(&self, k: usize) -> ([f32; 3], [f32; 3], PixelState) {
        let (mut values, mut variances) = ([0.0; 3], [0.0; 3]);
        let (mut is_black, mut is_full) = (true, false);
        for c in 0..3 {
            match self.channel(k, c) {
                Channel::Known(value, variance) => {
                    (values[c], variances[c]) = (value as f32, variance as f32);
                    is_black &= value < BLACK * variance.sqrt();
                }
                Channel::Full => {
                    values[c] = (self.sensor.saturation[c] / self.kept[0].1) as f32;
                    (variances[c], is_full) = (f32::INFINITY, true);
                }
                Channel::Unknown => return ([0.0; 3], [f32::INFINITY; 3], PixelState::Broken),
            }
        }
        let state = match (is_full, is_black) {
            (true, _) => PixelState::Saturated,
            (_, true) => PixelState::Black,
            _ => PixelState::Valid,
        };
        (values, variances, state)
    }

    fn channel(&self, pixel: usize, c: usize) -> Channel {
        let (mut said, mut count) = ([Said::default(); MAX_EXPOSURES], 0);
        let mut is_full = false;
        for (place, relative) in self.kept.iter().take(MAX_EXPOSURES) {
            let Shown { picture, gain, .. } = self.shown[*place];
            let value = picture.pixels[pixel][c];
            let limit = MAX_LIGHT * self.sensor.saturation[c] / relative;
            if !value.is_finite() {
                continue;
            }
            is_full = self.sensor.decoder.is_full(value)
                || said[..count].last().is_some_and(|s| s.light / s.relative > limit);
            if is_full {
                break;
            }
            let (light, rounding) = self.sensor.decoder.light(value, c);
            said[count] = Said { light, relative: *relative, gain, rounding };
            count += 1;
        }
        let Some(best) = said[..count].last() else {
            return if is_full { Channel::Full } else { Channel::Unknown };
        };
        let scene = best.light / best.relative;
        let (mut sum, mut weights) = (0.0, 0.0);
        for s in &said[..count] {
            let variance = self.sensor.variance(scene * s.relative, s.gain, c) + s.rounding;
            let weight = s.relative * s.relative / variance.max(1e-18);
            sum += weight * s.light / s.relative;
            weights += weight;
        }
        Channel::Known(sum / weights, 1.0 / weights)
    }

    /// From the noise of the most sensitive exposure to saturation of the least sensitive one, the mean of the channels.
    fn range_db(&self, quantum: f64) -> f64 {
        let Some((most, least)) = self.kept.last().zip(self.kept.first()) else { return 0.0 };
        let noise = |c: usize| {
            let black = self.sensor.decoder.value(0.0, c);
            let rounding = if quantum > 0.0 { self.sensor.decoder.light(black, c).1 } else { 0.0 };
            (self.sensor.variance(0.0, self.shown[most.0].gain, c) + rounding).sqrt() / most.1
        };
        let range = |c: usize| self.sensor.saturation[c] / least.1 / noise(c).max(1e-18);
        (0..3).map(|c| 20.0 * range(c).log10()).sum::<f64>() / 3.0
    }
}

enum Channel {
    /// Light and its variance.
    Known(f64, f64),
    /// Saturated everywhere.
    Full,
    /// Nowhere a number.
    Unknown,
}

impl HdrPicture {
    /// Divides by the scale of a white balance: values are radiance per flash intensity after it.
    #[must_use]
    pub fn balanced(mut self, white: WhiteScale) -> Self {
        let divide = |pixels: &mut [[f32; 3]], by: [f64; 3]| {
            let by = by.map(|b| b as f32);
            pixels.par_iter_mut().for_each(|p| (0..3).for_each(|c| p[c] /= by[c]));
        };
        divide(&mut self.pixels, white.scale);
        divide(&mut self.variance, white.scale.map(|s| s * s));
        self.white = Some(white);
        self
    }

    /// The pixels, no numbers where a channel is saturated or the pixel is broken. Row-major.
    pub fn known(&self) -> Vec<[f32; 3]> {
        let is_known = |state: &PixelState| matches!(state, PixelState::Valid | PixelState::Black);
        let pixels = self.pixels.iter().zip(&self.mask);
        pixels.map(|(pixel, state)| if is_known(state) { *pixel } else { [f32::NAN; 3] }).collect()
    }

    /// From the least valid light above its noise to the most.
    fn shown_range_db(&self) -> f64 {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for k in (0..self.pixels.len()).filter(|k| self.mask[*k] == PixelState::Valid) {
            for (value, variance) in self.pixels[k].iter().zip(self.variance[k]) {
                let value = f64::from(*value);
                if value > BLACK * f64::from(variance).sqrt() && value > 0.0 {
                    (least, most) = (least.min(value), most.max(value));
                }
            }
        }
        if most > 0.0 { 20.0 * (most / least).log10() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::SyntheticDome;
    use super::*;
    use glam::DVec2;
    use std::collections::BTreeMap;
    use std::sync::OnceLock;

    fn dome() -> SyntheticDome {
        SyntheticDome { read: 1e-4, electrons: 40_000.0, levels: 4095.0, ..SyntheticDome::new(4) }
    }

    fn try_merged(dome: &SyntheticDome) -> Result<HdrPicture> {
        static RESPONSE: OnceLock<CameraResponse> = OnceLock::new();
        let response = RESPONSE.get_or_init(|| CameraResponse::measure(&self::dome(), 1).unwrap());
        let decoder = Decoder::new(response, quantum(&dome.rig)).unwrap();
        merge_exposures(dome, response, &decoder, 1, 2)
    }

    fn merged(dome: &SyntheticDome) -> HdrPicture {
        try_merged(dome).unwrap()
    }

    /// True light of a pixel, but for the unit.
    fn truth(dome: &SyntheticDome, k: usize, c: usize) -> f64 {
        let pixel = DVec2::new((k % 256) as f64 + 0.5, (k / 256) as f64 + 0.5);
        dome.scale(1, 2, c) * dome.radiance(1, 2, pixel)[c]
    }

    #[test]
    fn merged_light_is_unbiased_and_its_variance_honest() {
        let dome = dome();
        let picture = merged(&dome);
        assert_eq!(picture.warnings, [""; 0]);
        for (e, relative) in picture.relative.iter().enumerate() {
            let real = dome.rig.exposures[e].relative * SyntheticDome::energy(2, e);
            let unit = picture.relative[2].unwrap() / SyntheticDome::energy(2, 2);
            // Response curves, known to parts of a thousand, meet other light in every exposure.
            assert!((relative.unwrap() / (unit * real) - 1.0).abs() < 5e-3, "{e} {relative:?}");
        }
        // From 1/256 to 8 are 66 dB, from 1e-4 to 1, with the noise of ISO 400 and rounding, 61.
        assert!((120.0..132.0).contains(&picture.range_db[0]), "{:?}", picture.range_db);
        assert!((115.0..picture.range_db[0]).contains(&picture.range_db[1]), "{:?}", picture.range_db);
        for c in 0..3 {
            // Half decades of light: errors over their standard deviations, and found over real light.
            let mut bins: BTreeMap<i32, Vec<[f64; 2]>> = BTreeMap::new();
            for k in (0..65_536).filter(|k| picture.mask[*k] == PixelState::Valid) {
                let (real, found) = (truth(&dome, k, c), f64::from(picture.pixels[k][c]));
                let sigma = f64::from(picture.variance[k][c]).sqrt();
                bins.entry((2.0 * real.log10()).floor() as i32)
                    .or_default()
                    .push([found / real, sigma / real]);
            }
            let middle = |bin: &[[f64; 2]]| bin.iter().map(|b| b[0]).sum::<f64>() / bin.len() as f64;
            let unit = middle(&bins[&-4]);
            for (bin, all) in bins.iter().filter(|(bin, all)| **bin > -9 && all.len() > 50) {
                let (n, mean) = (all.len() as f64, middle(all));
                let sigma = all.iter().map(|b| b[1]).sum::<f64>() / n;
                // Four standard errors, and half a percent of response curve.
                assert!(
                    (mean / unit - 1.0).abs() < 4.0 * sigma / n.sqrt() + 5e-3,
                    "{c} {bin}: {mean} {unit}"
                );
                let z = all.iter().map(|b| ((b[0] - mean) / b[1]).powi(2)).sum::<f64>() / n;
                // A variance from n numbers is known to sqrt(2 / n); what is bright has shot noise of less than the bends of the
                // curve between the exposures, which add up to a third of it.
                let bends = if *bin > -3 { 0.6 } else { 0.1 };
                assert!((z - 1.0).abs() < 4.0 * (2.0 / n).sqrt() + bends, "{c} {bin}: {z}");
            }
        }
    }

    #[test]
    fn exposures_that_contradict_the_others_are_left_out() {
        let clean = merged(&dome());
        let dark: fn(&SyntheticDome, Shot) -> Option<Result<Picture>> = |dome, shot| match shot {
            // The flash did not fire: the light of another shot of the least energy.
            Shot::Pair { exposure: 1, camera, light } => {
                let mut picture = dome.honest(Shot::Pair { exposure: 0, camera, light }).unwrap();
                picture.pixels.iter_mut().flatten().for_each(|v| *v = v.min(0.03));
                Some(Ok(picture))
            }
            _ => None,
        };
        let missing: fn(&SyntheticDome, Shot) -> Option<Result<Picture>> = |_, shot| match shot {
            Shot::Pair { exposure: 3, .. } => Some(Err(Error::invalid("", "file", "none", "a picture"))),
            _ => None,
        };
        for (instead, lost, word) in [(dark, 1, "exposure 1 has"), (missing, 3, "file: found none")] {
            let picture = merged(&SyntheticDome { instead, ..dome() });
            assert_eq!(picture.relative.iter().position(Option::is_none), Some(lost));
            assert!(
                picture.warnings.len() == 1 && picture.warnings[0].contains(word),
                "{:?}",
                picture.warnings
            );
            let middle = 128 * 256 + 60;
            let ratio = picture.pixels[middle][1] / clean.pixels[middle][1];
            // Anchors of the unit move with the exposures: energies are 2 % off nominal.
            assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
        }
    }

    #[test]
    fn saturated_black_and_broken_pixels_are_marked() {
        let mut dome = dome();
        dome.instead = |dome, shot| {
            let mut picture = dome.honest(shot).unwrap();
            if let Shot::Pair { exposure, .. } = shot {
                picture.pixels[100] = [1.0; 3];
                picture.pixels[200] = [f32::NAN; 3];
                // One exposure without a number does no harm.
                picture.pixels[128 * 256 + 60][1] =
                    if exposure == 2 { f32::NAN } else { picture.pixels[128 * 256 + 60][1] };
                picture.pixels[300] = [0.0; 3];
            }
            Some(Ok(picture))
        };
        let picture = merged(&dome);
        let states = [100, 200, 300, 128 * 256 + 60].map(|k| picture.mask[k]);
        assert_eq!(states, [PixelState::Saturated, PixelState::Broken, PixelState::Black, PixelState::Valid]);
        let known = picture.known();
        assert!(known[100][0].is_nan() && known[200][0].is_nan() && known[300][0].is_finite());
        dome.instead = |_, shot| match shot {
            Shot::Pair { .. } => Some(Err(Error::invalid("", "file", "none", "a picture"))),
            _ => None,
        };
        let message = try_merged(&dome).unwrap_err().to_string();
        assert!(
            message.contains("file: found none")
                && message.contains("; and 3 more, expected one that can be read"),
            "{message}"
        );
    }
}
