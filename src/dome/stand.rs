//! The true dome, and what a measurement is told of it.

use super::DomeOptions;
use super::sensor::{Response, Sensor};
use crate::error::Result;
use crate::math::half_difference::spherical;
use crate::math::hash::pcg4d;
use crate::math::projection::{Intrinsics, Pose, Projection};
use crate::measure::Rig;
use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal, StandardNormal};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// Standard deviation of a camera's gain and a flash's color, a channel, as a share.
const COLOR_SPREAD: f64 = 0.03;
/// Standard deviation of where a camera points, millimetres on the sample.
const AIM_MM: f64 = 0.4;
/// Standard deviation of focal lengths at zoom, as a share, and of the principal point, as a share of the picture.
const LENS_SPREAD: [f64; 2] = [0.004, 0.006];
/// Mean radial distortion k1 and its spread; lenses of compact cameras have barrels of some per cent at the corners.
const DISTORTION: [f64; 2] = [-0.15, 0.05];
/// Relative times of the response series: darkness, then doubling, closer near saturation, the last beyond it.
const SERIES: [f64; 16] = [
    1e-6,
    1.0 / 2048.0,
    1.0 / 1024.0,
    1.0 / 512.0,
    1.0 / 256.0,
    1.0 / 128.0,
    1.0 / 64.0,
    1.0 / 32.0,
    1.0 / 16.0,
    1.0 / 8.0,
    1.0 / 4.0,
    1.0 / 2.0,
    0.75,
    1.0,
    1.5,
    2.0,
];

/// A dome as it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Stand {
    /// Nominal numbers: what a capture says of itself.
    pub rig: Rig,
    /// The true ones.
    pub truth: Truth,
}

/// What calibration has to find.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// The lens of all cameras without zoom.
    pub wide: Intrinsics,
    /// The cameras at the zoom of the measurement.
    pub cameras: Vec<Projection>,
    /// The sensors.
    pub sensors: Vec<Sensor>,
    /// Color of the flashes, linear, a camera each; 1 is nominal.
    pub flash_color: Vec<[f64; 3]>,
}

impl Stand {
    /// Sets a dome up.
    ///
    /// # Errors
    /// As [`DomeOptions::validate`] and [`Rig::validate`].
    pub fn new(options: &DomeOptions) -> Result<Self> {
        options.validate()?;
        let focal_zoom_px = options.image_px[0] as f64 * options.radius_mm / options.field_mm;
        let focal_wide_px = focal_zoom_px / options.zoom;
        let wide = Intrinsics {
            distortion: [DISTORTION[0], 0.0],
            ..Intrinsics::pinhole(focal_wide_px * 1.01, options.image_px)
        };
        let places: Vec<(f64, f64)> = options
            .rings
            .iter()
            .flat_map(|ring| {
                let turn = 360.0 / ring.cameras as f64;
                (0..ring.cameras).map(move |k| (ring.polar_deg, ring.first_azimuth_deg + turn * k as f64))
            })
            .collect();
        let mut truth = Truth { wide, cameras: vec![], sensors: vec![], flash_color: vec![] };
        let mut nominal = Vec::with_capacity(places.len());
        for (k, (polar, azimuth)) in places.into_iter().enumerate() {
            let mut draws = Draws::new(options.seed, k);
            let lens = draws.lens(options, focal_zoom_px);
            let pose = draws.pose(options, polar, azimuth);
            truth.cameras.push(Projection { intrinsics: lens, pose });
            truth.sensors.push(draws.sensor(options));
            truth.flash_color.push(draws.color());
            nominal.push(draws.nominal(options, &pose));
        }
        let rig = Rig {
            image_px: options.image_px,
            white_level: f64::from((1u32 << options.bits) - 1),
            cameras: nominal,
            focal_wide_px,
            focal_zoom_px,
            flash: options.flash,
            exposures: options.exposures.clone(),
            response_series: SERIES.to_vec(),
            white_targets: options.white_targets.clone(),
            leds_mm: led_plate(options),
            sample_mm: options.sample_mm,
        };
        rig.validate()?;
        Ok(Self { rig, truth })
    }
}

/// Places of the diodes, row after row, about the origin.
fn led_plate(options: &DomeOptions) -> Vec<[f64; 2]> {
    let [columns, rows] = options.leds;
    let at = |k: usize, n: usize| options.led_pitch_mm * (k as f64 - 0.5 * (n - 1) as f64);
    (0..columns * rows).map(|k| [at(k % columns, columns), at(k / columns, rows)]).collect()
}

/// The random numbers of one camera.
struct Draws(Pcg64);

impl Draws {
    fn new(seed: u64, camera: usize) -> Self {
        let [a, b, ..] = pcg4d([seed as u32, (seed >> 32) as u32, camera as u32, 0x646f_6d65]);
        Self(Pcg64::seed_from_u64(u64::from(a) << 32 | u64::from(b)))
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    fn vector(&mut self, spread: f64) -> DVec3 {
        DVec3::new(self.normal(), self.normal(), self.normal()) * spread
    }

    fn lens(&mut self, options: &DomeOptions, focal_px: f64) -> Intrinsics {
        let pinhole =
            Intrinsics::pinhole(focal_px * (1.0 + LENS_SPREAD[0] * self.normal()), options.image_px);
        let shift = LENS_SPREAD[1] * options.image_px[0] as f64;
        let center_px = pinhole.center_px.map(|c| c + shift * self.normal());
        Intrinsics { center_px, distortion: [DISTORTION[0] + DISTORTION[1] * self.normal(), 0.0], ..pinhole }
    }

    fn pose(&mut self, options: &DomeOptions, polar_deg: f64, azimuth_deg: f64) -> Pose {
        let mut scatter = || (options.scatter_deg * self.normal()).clamp(-5.0, 5.0);
        let (polar, azimuth) = (polar_deg + scatter(), azimuth_deg + scatter());
        let position = options.radius_mm * spherical(polar.to_radians(), azimuth.to_radians());
        let aim = (self.vector(AIM_MM) * DVec3::new(1.0, 1.0, 0.0)).clamp_length_max(3.0 * AIM_MM);
        // Up along rising polar angles, which is defined at the pole too.
        let up = spherical(polar_deg.to_radians() - 1.0, azimuth_deg.to_radians());
        Pose::looking_at(position, aim, up)
    }

    fn nominal(&mut self, options: &DomeOptions, pose: &Pose) -> Pose {
        let turn = self.vector(options.pose_error_deg.to_radians());
        Pose {
            position_mm: pose.position_mm + self.vector(options.pose_error_mm),
            rotation: (DQuat::from_scaled_axis(turn) * pose.rotation).normalize(),
        }
    }

    fn color(&mut self) -> [f64; 3] {
        [(); 3].map(|()| (COLOR_SPREAD * self.normal()).exp())
    }

    fn sensor(&mut self, options: &DomeOptions) -> Sensor {
        Sensor {
            gain: self.color(),
            response: [(); 3].map(|()| Response {
                gamma: 1.9 + 0.08 * self.normal().clamp(-3.0, 3.0),
                bend: 0.03 * self.normal().clamp(-3.0, 3.0),
            }),
            full_well: options.full_well,
            read_noise: options.read_noise,
            noise: options.noise,
            bits: options.bits,
        }
    }
}

/// The true light of one flash at one setting of one shot, relative to nominal.
pub(super) fn flash_energy(options: &DomeOptions, shot: [usize; 3]) -> f64 {
    let [a, b, c, _] = pcg4d([shot[0] as u32, shot[1] as u32, shot[2] as u32, 0x666c_6173]);
    let seed = options.seed ^ (u64::from(a) << 32 | u64::from(b ^ c));
    let spread = options.noise * options.flash_spread;
    let deviate = Normal::new(0.0, 1.0).map_or(0.0, |law| law.sample(&mut Pcg64::seed_from_u64(seed)));
    (spread * deviate).exp()
}
