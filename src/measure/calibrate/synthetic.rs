//! A small dome in memory, for tests: pictures rendered when they are asked for.

use super::super::{Exposure, Flash, Images, Picture, Rig, Shot, WhiteTarget};
use crate::error::{Error, Result};
use crate::math::hash::{pcg4d, unit};
use crate::math::projection::{Intrinsics, Pose, Projection};
use glam::{DQuat, DVec2, DVec3};

/// Truth and rig.
pub struct SyntheticDome {
    pub rig: Rig,
    pub wide: Intrinsics,
    pub cameras: Vec<Projection>,
    /// Standard deviation of the noise of linear light where it is 0, and electrons of light 1.
    pub read: f64,
    pub electrons: f64,
    /// Rounded to this many levels; 0 for none.
    pub levels: f64,
    pub seed: u32,
    /// Says instead of its picture.
    pub instead: fn(&SyntheticDome, Shot) -> Option<Result<Picture>>,
    /// Light of a diode over full.
    pub diode: f64,
}

/// Four-sigma normal numbers from a hash: the sum of 12 uniform ones.
pub fn normal(words: [u32; 4]) -> f64 {
    let sum: f64 = (0..3)
        .flat_map(|k| pcg4d([words[0], words[1], words[2], words[3].wrapping_mul(3).wrapping_add(k)]))
        .map(|bits| f64::from(unit(bits)))
        .sum();
    sum - 6.0
}

impl SyntheticDome {
    pub fn new(number: usize) -> Self {
        let image_px = [256, 256];
        let (focal_wide_px, focal_zoom_px) = (2300.0, 6900.0);
        let nominal: Vec<Pose> = (0..number)
            .map(|k| {
                let z = 1.0 - 0.75 * (k as f64 + 0.02) / number as f64;
                let (radius, turn) = ((1.0 - z * z).sqrt(), 2.399_963 * k as f64);
                let place = 650.0 * DVec3::new(radius * turn.cos(), radius * turn.sin(), z);
                Pose::looking_at(place, DVec3::ZERO, if z > 0.99 { DVec3::Y } else { DVec3::Z })
            })
            .collect();
        let wide = Intrinsics { focal_px: 2340.0, center_px: [131.0, 126.5], distortion: [-0.3, 0.0] };
        let cameras = nominal
            .iter()
            .zip(0u32..)
            .map(|(pose, k)| {
                let n = |j: u32| normal([k, j, 77, 5]);
                let turn = DQuat::from_scaled_axis(0.3f64.to_radians() * DVec3::new(n(0), n(1), n(2)));
                let pose = Pose {
                    position_mm: pose.position_mm + 2.0 / 3f64.sqrt() * DVec3::new(n(3), n(4), n(5)),
                    rotation: (turn * pose.rotation).normalize(),
                };
                let intrinsics = Intrinsics {
                    focal_px: 7000.0 + 20.0 * n(6),
                    center_px: [131.0 + 2.0 * n(7), 126.5 + 2.0 * n(8)],
                    distortion: [0.0; 2],
                };
                Projection { intrinsics, pose }
            })
            .collect();
        let leds_mm =
            (0..121).map(|k| [f64::from(k % 11) * 5.0 - 25.0, f64::from(k / 11) * 5.0 - 25.0]).collect();
        let exposure = |flash_quantity, iso, relative| Exposure { flash_quantity, iso, relative };
        let target =
            |x: f64, y: f64, reflectance| WhiteTarget { center_mm: [x, y], side_mm: 3.0, reflectance };
        let rig = Rig {
            image_px,
            white_level: 4095.0,
            cameras: nominal,
            focal_wide_px,
            focal_zoom_px,
            flash: Flash { offset_mm: [0.0, 40.0], size_mm: [30.0, 12.0], points: [15, 6] },
            exposures: vec![
                exposure(2, 50, 1.0 / 256.0),
                exposure(1, 50, 1.0 / 16.0),
                exposure(0, 50, 1.0),
                exposure(0, 400, 8.0),
            ],
            response_series: (-18..=3).map(|k| 2f64.powf(0.5 * f64::from(k))).collect(),
            white_targets: vec![
                target(-9.0, 9.5, 0.023),
                target(-3.0, 9.5, 0.15),
                target(3.0, 9.5, 0.5),
                target(9.0, 9.5, 0.969),
            ],
            leds_mm,
            sample_mm: [17.0, 15.0],
        };
        Self {
            rig,
            wide,
            cameras,
            read: 0.0,
            electrons: f64::INFINITY,
            levels: 0.0,
            seed: 1,
            instead: |_, _| None,
            diode: 0.6,
        }
    }

    /// What a pixel of channel `c` says of linear light.
    pub fn response(&self, camera: usize, c: usize, x: f64) -> f64 {
        let gamma = 1.0 / (1.7 + 0.1 * c as f64 + 0.02 * (camera % 5) as f64);
        // Gamma and a little, 0 to 1.
        let x = x.clamp(0.0, 1.0);
        x.powf(gamma) + 0.08 * x * (1.0 - x)
    }

    /// What the sensor says of light, `gain` over that of the lowest sensitivity; noise by a counter.
    pub fn sense(&self, camera: usize, light: f64, gain: f64, c: usize, counter: [u32; 2]) -> f32 {
        let sigma = (self.read * self.read * gain * gain + light * gain / self.electrons).sqrt();
        let key = self.seed.wrapping_mul(4).wrapping_add(c as u32);
        let noisy = light + sigma * normal([counter[0], counter[1], camera as u32, key]);
        let says = self.response(camera, c, noisy);
        let says = if self.levels > 0.0 { (says * self.levels).round() / self.levels } else { says };
        says as f32
    }

    fn picture_of(
        &self,
        camera: usize,
        gain: f64,
        shot: u32,
        light: impl Fn(DVec2, usize) -> f64,
    ) -> Picture {
        let size = self.rig.image_px;
        let pixel = |k: usize| {
            let place = DVec2::new((k % size[0]) as f64 + 0.5, (k / size[0]) as f64 + 0.5);
            [0, 1, 2].map(|c| self.sense(camera, light(place, c), gain, c, [k as u32, shot]))
        };
        Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() }
    }

    /// Spots a pixel wide, each the integral of a Gaussian over the pixel by its middle.
    fn diodes(&self, camera: usize, view: &Projection, sigma: f64, shot: u32) -> Picture {
        let size = self.rig.image_px;
        let mut light = vec![0.0; size[0] * size[1]];
        for led in &self.rig.leds_mm {
            let Some(at) = view.pixel(DVec2::from(*led).extend(0.0)) else { continue };
            let reach = (6.0 * sigma).ceil();
            for y in (at.y - reach).max(0.0) as usize..((at.y + reach).max(0.0) as usize).min(size[1]) {
                for x in (at.x - reach).max(0.0) as usize..((at.x + reach).max(0.0) as usize).min(size[0]) {
                    let apart = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - at;
                    light[y * size[0] + x] +=
                        self.diode * (-0.5 * apart.length_squared() / (sigma * sigma)).exp();
                }
            }
        }
        self.picture_of(camera, 1.0, shot, |p, _| light[p.y as usize * size[0] + p.x as usize])
    }

    pub fn projection_wide(&self, camera: usize) -> Projection {
        Projection { intrinsics: self.wide, pose: self.cameras[camera].pose }
    }

    pub fn honest(&self, shot: Shot) -> Result<Picture> {
        Ok(match shot {
            Shot::LedsWide { camera } => self.diodes(camera, &self.projection_wide(camera), 1.0, 1),
            Shot::LedsZoom { camera } => self.diodes(camera, &self.cameras[camera], 1.6, 2),
            _ => return Err(Error::invalid("", "picture", shot, "one of this dome")),
        })
    }
}

impl Images for SyntheticDome {
    fn rig(&self) -> &Rig {
        &self.rig
    }

    fn picture(&self, shot: Shot) -> Result<Picture> {
        (self.instead)(self, shot).unwrap_or_else(|| self.honest(shot))
    }
}
