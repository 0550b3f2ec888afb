//! A small dome in memory, for tests: pictures rendered when they are asked for.

use super::super::{Exposure, Flash, Images, PairGeometry, Picture, Rig, Shot, WhiteTarget};
use crate::error::Result;
use crate::math::hash::{pcg4d, unit};
use crate::math::normal_f32::probit;
use crate::math::projection::{Intrinsics, Pose, Projection};
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::PI;

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

/// A normal number from a hash.
pub fn normal(words: [u32; 4]) -> f64 {
    f64::from(probit(unit(pcg4d(words)[0])))
}

impl SyntheticDome {
    pub fn new(number: usize) -> Self {
        let image_px = [256, 256];
        let (focal_wide_px, focal_zoom_px) = (2300.0, 6900.0);
        let wide = Intrinsics { focal_px: 2340.0, center_px: [131.0, 126.5], distortion: [-0.3, 0.0] };
        let draw = |k: usize, j: u32| normal([k as u32, j, 77, 5]);
        let cameras: Vec<Projection> = (0..number)
            .map(|k| {
                let z = 1.0 - 0.75 * (k as f64 + 0.02) / number as f64;
                let (radius, turn) = ((1.0 - z * z).sqrt(), 2.399_963 * k as f64);
                let place = 650.0 * DVec3::new(radius * turn.cos(), radius * turn.sin(), z);
                let pose = Pose::looking_at(place, DVec3::ZERO, if z > 0.99 { DVec3::Y } else { DVec3::Z });
                let intrinsics = Intrinsics {
                    focal_px: 7000.0 + 20.0 * draw(k, 6),
                    center_px: [131.0 + 2.0 * draw(k, 7), 126.5 + 2.0 * draw(k, 8)],
                    distortion: [0.0; 2],
                };
                Projection { intrinsics, pose }
            })
            .collect();
        // Nominal poses are a third of a degree and two millimeters off.
        let off = |(k, camera): (usize, &Projection)| {
            let n = |j| DVec3::new(draw(k, j), draw(k, j + 1), draw(k, j + 2));
            let turn = DQuat::from_scaled_axis(0.3f64.to_radians() * n(0));
            Pose {
                position_mm: camera.pose.position_mm + 2.0 / 3f64.sqrt() * n(3),
                rotation: (turn * camera.pose.rotation).normalize(),
            }
        };
        let nominal = cameras.iter().enumerate().map(off).collect();
        let leds_mm =
            (0..121).map(|k| [f64::from(k % 11) * 5.0 - 25.0, f64::from(k / 11) * 5.0 - 25.0]).collect();
        let exposure = |flash_quantity, iso, relative| Exposure { flash_quantity, iso, relative };
        let target =
            |x: f64, y: f64, reflectance| WhiteTarget { center_mm: [x, y], side_mm: 2.4, reflectance };
        let rig = Rig {
            image_px,
            white_level: 4095.0,
            cameras: nominal,
            focal_wide_px,
            focal_zoom_px,
            flash: Flash { offset_mm: [0.0, 40.0], size_mm: [30.0, 12.0], points: [4, 2] },
            exposures: vec![
                exposure(2, 50, 1.0 / 256.0),
                exposure(1, 50, 1.0 / 16.0),
                exposure(0, 50, 1.0),
                exposure(0, 400, 8.0),
            ],
            response_series: std::iter::once(1e-6).chain((-11..=1).map(|k| 2f64.powi(k))).collect(),
            white_targets: vec![
                target(-10.0, 0.0, 0.023),
                target(10.0, 0.0, 0.15),
                target(0.0, -9.3, 0.5),
                target(0.0, 9.3, 0.969),
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
        // A power with a straight toe, a little above 0 in darkness, and bent.
        let power = |x: f64| (x + 0.004).powf(gamma) - 0.004f64.powf(gamma);
        let y = power(((x + 0.004) / 1.004).clamp(0.0, 1.0)) / power(1.0);
        y + 0.06 * y * (1.0 - y) * (1.2 - y)
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

    fn picture_of(&self, camera: usize, gain: f64, shot: u32, light: impl Fn(DVec2) -> [f64; 3]) -> Picture {
        let size = self.rig.image_px;
        let pixel = |k: usize| {
            let place = DVec2::new((k % size[0]) as f64 + 0.5, (k / size[0]) as f64 + 0.5);
            let light = light(place);
            [0, 1, 2].map(|c| self.sense(camera, light[c], gain, c, [k as u32, shot]))
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
        self.picture_of(camera, 1.0, shot, |p| [light[p.y as usize * size[0] + p.x as usize]; 3])
    }

    pub fn projection_wide(&self, camera: usize) -> Projection {
        Projection { intrinsics: self.wide, pose: self.cameras[camera].pose }
    }

    /// Light that a nominal exposure of relative 1 collects, for radiance per flash intensity.
    pub const WHITE: f64 = 0.1 * PI * 650.0 * 650.0;

    /// Sensitivity of a camera times color of a flash.
    pub fn scale(&self, camera: usize, light: usize, c: usize) -> f64 {
        let wave = |k: usize| 1.0 + 0.05 * (1.7 * k as f64 + c as f64).sin();
        Self::WHITE * wave(camera) * wave(light + 50)
    }

    /// Energy of a flash over nominal, for one exposure.
    pub fn energy(light: usize, exposure: usize) -> f64 {
        1.0 + 0.02 * (light as f64 + 2.0 * exposure as f64).sin()
    }

    /// True radiance per flash intensity, 1/mm^2: targets, and a sample whose BRDF spans four decades from side to side with a
    /// highlight in its middle.
    pub fn radiance(&self, camera: usize, light: usize, pixel: DVec2) -> [f64; 3] {
        let Some(at) = self.cameras[camera].on_plane(pixel, 0.0) else { return [0.0; 3] };
        let pair = PairGeometry::new(self.cameras[camera], &self.rig.flash, &self.cameras[light].pose);
        let place = at.truncate();
        let is_on =
            |t: &&WhiteTarget| (place - DVec2::from(t.center_mm)).abs().max_element() <= 0.5 * t.side_mm;
        let target = self.rig.white_targets.iter().find(is_on);
        let [x, y] = [place.x / self.rig.sample_mm[0], place.y / self.rig.sample_mm[1]];
        let bump = 500.0 * (-(x * x + y * y) * 400.0).exp();
        let sample = |c: usize| 10f64.powf(4.0 * x - 1.5 - 0.2 * c as f64) + bump;
        let on_sample = x.abs().max(y.abs()) <= 0.5;
        let irradiance = pair.irradiance(place, |_| 1.0);
        let f = |c: usize| if on_sample { sample(c) } else { 0.002 };
        [0, 1, 2].map(|c| irradiance * target.map_or_else(|| f(c), |t| t.reflectance / PI))
    }

    fn pair(&self, camera: usize, light: usize, exposure: usize) -> Picture {
        let setting = self.rig.exposures[exposure];
        let factor = setting.relative * Self::energy(light, exposure);
        let gain = f64::from(setting.iso) / 50.0;
        let shot = 1000 + 100 * light as u32 + exposure as u32;
        let scale = [0, 1, 2].map(|c| factor * self.scale(camera, light, c));
        self.picture_of(camera, gain, shot, |pixel| {
            let radiance = self.radiance(camera, light, pixel);
            [0, 1, 2].map(|c| scale[c] * radiance[c])
        })
    }

    pub fn honest(&self, shot: Shot) -> Result<Picture> {
        Ok(match shot {
            Shot::LedsWide { camera } => self.diodes(camera, &self.projection_wide(camera), 1.0, 1),
            Shot::LedsZoom { camera } => self.diodes(camera, &self.cameras[camera], 1.6, 2),
            Shot::Response { camera, step } => {
                let light = 0.6 * self.rig.response_series[step];
                let sensitivity = [1.0, 0.95, 1.05];
                self.picture_of(camera, 1.0, 10 + step as u32, |_| sensitivity.map(|s| light * s))
            }
            Shot::Pair { camera, light, exposure } => self.pair(camera, light, exposure),
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
