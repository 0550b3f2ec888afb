//! Response curves and noise of the cameras, from gray fields at known relative times (Rump et al. 2008, section 4.3).
//!
//! A field tells one point of the curve of every channel. Between the points stands `c0 + c1 (x + b)^g`, a power with a toe, and
//! what that leaves is smoothed as in Debevec & Malik 1997: least squares with a penalty on second differences over
//! log (x + b), the stiffest that stays within the noise of the points. Where the dome reaches into darkness the curve goes on
//! below x = 0, so that noise about black keeps its mean.
//!
//! The noise comes from photon transfer: the variance of linear light is `read^2 + shot x`.

use super::field::Field;
use super::smooth_curve::SmoothCurve;
use crate::color::ResponseCurve;
use crate::error::{Error, Result};
use crate::measure::{Images, Rig, Shot};
use serde::{Deserialize, Serialize};

/// Knots of a curve: straight pieces are off by 2e-5 of the light.
const KNOTS: usize = 256;
/// A field with more saturated pixels than this is not used: those of its noise are cut off.
const MAX_SATURATED: f64 = 1e-3;
/// Fewest fields that are not saturated: the numbers of the power with a toe.
const MIN_FIELDS: usize = 4;
/// Rounds of weights of the photon transfer line.
const ROUNDS: usize = 8;

/// What a camera says of light, and its noise.
///
/// Light is relative: 1 is where the first channel saturates at the lowest sensitivity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraResponse {
    /// Linear light of the knots, ascending; below 0 where the camera tells such noise from black.
    pub light: Vec<f64>,
    /// What red, green, blue say there, 0 to 1, never falling.
    pub says: Vec<[f64; 3]>,
    /// Light at which each channel saturates.
    pub saturation: [f64; 3],
    /// The largest light that a field showed unsaturated; above, the curve is extrapolated.
    pub measured_to: f64,
    /// Root mean square distance of the fields from the curve, and its expectation from their noise.
    pub rms: [[f64; 2]; 3],
    /// Noise at the lowest sensitivity.
    pub noise: SensorNoise,
    /// Pixels that stay dark or bright whatever the light, ascending.
    pub broken_pixels: Vec<u32>,
    /// Why gray fields could not be read, one each.
    #[serde(default)]
    pub unread: Vec<String>,
}

/// Variance of linear light x of a pixel, a channel each: `read^2 + shot x`, quantization apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorNoise {
    /// Standard deviation in darkness.
    pub read: [f64; 3],
    /// Light of one electron.
    pub shot: [f64; 3],
}

/// The step between two values of a pixel; 0 if values are continuous (a white level below 2).
pub fn quantum(rig: &Rig) -> f64 {
    if rig.white_level >= 2.0 { 1.0 / rig.white_level } else { 0.0 }
}

impl CameraResponse {
    /// Measures a camera; one picture in memory at a time.
    ///
    /// # Errors
    /// Fewer than four fields that can be read and are not saturated; fields that do not grow with the time.
    pub fn measure(images: &dyn Images, camera: usize) -> Result<Self> {
        let quantum = quantum(images.rig());
        let series = &images.rig().response_series;
        let mut channels: [Vec<(f64, Field)>; 3] = Default::default();
        let (mut hot, mut dead, mut unread) = (None, Vec::new(), Vec::new());
        for (step, time) in series.iter().enumerate() {
            let picture = match images.picture(Shot::Response { camera, step }) {
                Ok(picture) => picture,
                Err(e) => {
                    unread.push(e.to_string());
                    continue;
                }
            };
            for (c, channel) in channels.iter_mut().enumerate() {
                let Some(field) =
                    Field::measure(&picture, c, quantum).filter(|f| f.saturated <= MAX_SATURATED)
                else {
                    continue;
                };
                // Hot pixels show in the darkest field, dead ones in the brightest.
                hot.get_or_insert_with(|| field.broken(&picture, c, 1.0, quantum));
                dead = field.broken(&picture, c, -1.0, quantum);
                channel.push((*time, field));
            }
        }
        if let Some(few) = channels.iter().map(Vec::len).min().filter(|n| *n < MIN_FIELDS) {
            let found = unread.first().map_or(few.to_string(), |e| format!("{few} ({e})"));
            let place = format!("camera {camera}");
            return Err(Error::invalid(place, "gray fields that are not saturated", found, "at least 4"));
        }
        let mut broken_pixels: Vec<u32> = hot.into_iter().flatten().chain(dead).collect();
        broken_pixels.sort_unstable();
        broken_pixels.dedup();
        let response = Self::of_fields(&channels, broken_pixels);
        let response = response.map_err(|e| e.within(format!("camera {camera}")))?;
        Ok(Self { unread, ..response })
    }

    fn of_fields(channels: &[Vec<(f64, Field)>; 3], broken_pixels: Vec<u32>) -> Result<Self> {
        let mut curves = Vec::with_capacity(3);
        for (name, fields) in ["red", "green", "blue"].into_iter().zip(channels) {
            let points: Vec<[f64; 3]> = fields.iter().map(|(t, f)| [*t, f.level, f.level_error]).collect();
            curves.push(SmoothCurve::fit(&points).map_err(|e| e.within(name))?);
        }
        let first = curves.iter().map(SmoothCurve::saturation).fold(f64::INFINITY, f64::min);
        let toe = curves.iter().map(|c| c.toe).fold(f64::INFINITY, f64::min);
        let light: Vec<f64> = knots(toe / first);
        let mut says: Vec<[f64; 3]> =
            light.iter().map(|x| [0, 1, 2].map(|c| curves[c].says(x * first))).collect();
        for k in 1..says.len() {
            says[k] = [0, 1, 2].map(|c| says[k][c].clamp(says[k - 1][c], 1.0));
        }
        let last = channels.iter().flatten().map(|(t, _)| *t).fold(0.0, f64::max);
        let noises = [0, 1, 2].map(|c| photon_transfer(&channels[c], &curves[c]));
        Ok(Self {
            light,
            says,
            saturation: [0, 1, 2].map(|c| curves[c].saturation() / first),
            measured_to: last / first,
            rms: [0, 1, 2].map(|c| curves[c].rms),
            noise: SensorNoise {
                read: noises.map(|[read_square, _]| read_square.sqrt() / first),
                shot: noises.map(|[_, shot]| shot / first),
            },
            broken_pixels,
            unread: Vec::new(),
        })
    }

    /// The curve for tone mapping: from darkness to saturation.
    ///
    /// # Errors
    /// Numbers that are no curve, which a file may hold.
    pub fn curve(&self) -> Result<ResponseCurve> {
        let from = self.light.partition_point(|x| *x < 0.0).min(self.says.len());
        ResponseCurve::from_knots(&self.light[from..], &self.says[from..])
    }

    /// Checks what a file may hold.
    ///
    /// # Errors
    /// Knots that do not ascend, responses outside 0 to 1 or falling, noise that is negative or no number.
    pub fn validate(&self) -> Result<()> {
        let least = self.light.first().copied().unwrap_or_default();
        let above: Vec<f64> = self.light.iter().map(|x| x - least).collect();
        ResponseCurve::from_knots(&above, &self.says)?;
        self.curve()?;
        let numbers = [self.saturation, self.noise.read, self.noise.shot];
        match numbers.iter().flatten().find(|n| !(0.0..=1e12).contains(*n)) {
            Some(n) => Err(Error::invalid("response", "saturation or noise", n, "0 to 1e12")),
            None => Ok(()),
        }
    }
}

/// Knots evenly over log (x + toe), from a little below darkness to a little beyond saturation, 0 among them.
fn knots(toe: f64) -> Vec<f64> {
    let (from, to) = ((0.25 * toe).ln(), (2.0 + toe).ln());
    let at = |k: usize| (from + (to - from) * k as f64 / (KNOTS - 1) as f64).exp() - toe;
    let mut light: Vec<f64> = (0..KNOTS).map(at).collect();
    let zero = light.partition_point(|x| *x < 0.0);
    light[zero] = 0.0;
    light
}

/// The line `read^2 + shot x` through variances of light: each known to about the same share of itself, so that weights follow
/// the line by turns.
fn photon_transfer(fields: &[(f64, Field)], curve: &SmoothCurve) -> [f64; 2] {
    let points: Vec<[f64; 2]> =
        fields.iter().map(|(t, f)| [*t, f.variance / curve.slope(*t).powi(2)]).collect();
    let mean = points.iter().map(|p| p[1]).sum::<f64>() / points.len() as f64;
    let mut line = [mean, 0.0];
    for _ in 0..ROUNDS {
        let [mut s, mut sx, mut sxx, mut sy, mut sxy] = [0.0; 5];
        for [x, y] in &points {
            let w = (line[0] + line[1] * x).max(1e-3 * mean).max(f64::MIN_POSITIVE).powi(-2);
            [s, sx, sxx, sy, sxy] = [s + w, sx + w * x, sxx + w * x * x, sy + w * y, sxy + w * x * y];
        }
        let determinant = s * sxx - sx * sx;
        let free = [(sxx * sy - sx * sxy) / determinant, (s * sxy - sx * sy) / determinant];
        line = match free {
            [read, shot] if read >= 0.0 && shot >= 0.0 => [read, shot],
            [read, _] if read < 0.0 => [0.0, sxy / sxx],
            // Not finite: no noise at all.
            [_, shot] if shot < 0.0 => [sy / s, 0.0],
            _ => return [0.0; 2],
        };
    }
    line
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::SyntheticDome;
    use super::*;
    use crate::measure::Picture;

    fn dome() -> SyntheticDome {
        SyntheticDome { read: 1e-4, electrons: 40_000.0, levels: 4095.0, ..SyntheticDome::new(3) }
    }

    const SENSITIVITY: [f64; 3] = [1.0, 0.95, 1.05];

    #[test]
    fn curves_are_found_within_their_noise() {
        let dome = dome();
        for camera in 0..2 {
            let found = CameraResponse::measure(&dome, camera).unwrap();
            found.validate().unwrap();
            let curve = found.curve().unwrap();
            for (c, sensitivity) in SENSITIVITY.into_iter().enumerate() {
                let says = |x: f64| dome.response(camera, c, x * sensitivity);
                let scale = curve.exposure(says(0.1), c) / 0.1;
                for k in 0..14 {
                    let x = 0.9 * 0.6f64.powi(k);
                    let off = curve.exposure(says(x), c) / (scale * x) - 1.0;
                    // A level is known to 1e-5, which is 1e-5 of light near black; bends between fields an octave apart are
                    // known to 1e-3 of light, beyond the last one at 0.6 to 1e-2.
                    let tolerance = if x > 0.6 { 1e-2 } else { 1e-3 + 1e-5 / x };
                    assert!(off.abs() < tolerance, "{camera} {c} {x}: {off:e}");
                }
                // Where the first channel saturates the scale has its 1: blue, at 1 / 1.05.
                assert!((scale / 1.05 - 1.0).abs() < 1e-2, "{scale}");
                assert!((found.saturation[c] * sensitivity / 1.05 - 1.0).abs() < 1e-2);
                // 33,000 pairs of 14 fields give a variance to half a percent; steps and slopes take some, too.
                let [read, shot] = [found.noise.read[c], found.noise.shot[c]];
                assert!((read * sensitivity / (scale * 1e-4) - 1.0).abs() < 0.04, "{read}");
                assert!((shot * sensitivity / (scale / 40_000.0) - 1.0).abs() < 0.02, "{shot}");
                // Within the noise, which the fit must not go below, and not far above it.
                assert!(found.rms[c][0] < 2.0 * found.rms[c][1], "{:?}", found.rms[c]);
            }
        }
    }

    #[test]
    fn broken_pixels_are_listed_and_do_no_harm() {
        let mut dome = dome();
        let clean = CameraResponse::measure(&dome, 0).unwrap();
        dome.instead = |dome, shot| {
            let mut picture = dome.honest(shot).unwrap();
            (0..40).for_each(|k| picture.pixels[k * 500] = [1.0; 3]);
            (0..20).for_each(|k| picture.pixels[k * 500 + 100] = [0.0; 3]);
            picture.pixels[7] = [f32::NAN; 3];
            Some(Ok(picture))
        };
        let found = CameraResponse::measure(&dome, 0).unwrap();
        assert_eq!(found.broken_pixels.len(), 61);
        for c in 0..3 {
            assert!((found.noise.read[c] / clean.noise.read[c] - 1.0).abs() < 0.02);
            assert!((found.saturation[c] / clean.saturation[c] - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn series_that_tell_no_curve_are_refused() {
        let message = |instead: fn(&SyntheticDome, Shot) -> Option<Result<Picture>>| {
            let dome = SyntheticDome { instead, ..dome() };
            CameraResponse::measure(&dome, 1).unwrap_err().to_string()
        };
        fn flat(value: f32) -> Option<Result<Picture>> {
            Some(Ok(Picture { size: [256; 2], pixels: vec![[value; 3]; 65_536] }))
        }
        let says = message(|_, _| Some(Err(Error::invalid("", "file", "none", "a picture"))));
        assert!(says.contains("camera 1") && says.contains("0 (file: found none"), "{says}");
        assert!(message(|_, _| flat(1.0)).contains("not saturated: found 0"));
        assert!(message(|_, _| flat(0.3)).contains("red: levels of the gray fields"));
        assert!(message(|_, _| flat(f32::NAN)).contains("found 0"));
        let swapped = |dome: &SyntheticDome, shot: Shot| match shot {
            Shot::Response { camera, step } => Some(dome.honest(Shot::Response { camera, step: 13 - step })),
            _ => None,
        };
        assert!(message(swapped).contains("rising with the time"));
    }
}
