//! `DOME.toml`: what stands where.

use crate::check::range;
use crate::error::{Error, Result};
use crate::measure::{Exposure, Flash, WhiteTarget};
use serde::{Deserialize, Serialize};

/// A virtual dome. Every key may be left out: the default has 21 cameras and pictures of 256 x 256, the paper's is
/// `fixtures/domes/paper.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DomeOptions {
    /// The cameras, ring by ring.
    pub rings: Vec<Ring>,
    /// Radius of the hemisphere, millimetres, 10 to 1e5.
    pub radius_mm: f64,
    /// How far a camera stands off its place on the ring, degrees along both angles, 0 to 5: it spreads the directions.
    pub scatter_deg: f64,
    /// Columns and rows of a picture, 32 to 4096.
    pub image_px: [usize; 2],
    /// Width of what a picture shows of the sample's plane seen from straight above, millimetres, 1 to 1000.
    pub field_mm: f64,
    /// Focal length of the measurement over that without zoom, 1 to 20.
    pub zoom: f64,
    /// Width and height of the sample, millimetres.
    pub sample_mm: [f64; 2],
    /// The flash of every camera.
    pub flash: Flash,
    /// The exposures of every pair.
    pub exposures: Vec<Exposure>,
    /// What the perfect diffuser gives a sensor at the exposure of relative 1 under the flash straight above, 1 = saturated; 1e-6
    /// to 1e3.
    pub white: f64,
    /// White targets beside the sample.
    pub white_targets: Vec<WhiteTarget>,
    /// Columns and rows of the plate of diodes, 2 to 100.
    pub leds: [usize; 2],
    /// Their distance, millimetres.
    pub led_pitch_mm: f64,
    /// Electrons of a saturated pixel at ISO 50, 100 to 1e7.
    pub full_well: f64,
    /// Noise of reading a pixel, electrons, 0 to 1000.
    pub read_noise: f64,
    /// Bits of a pixel, 8 to 16.
    pub bits: u32,
    /// Factor on all noise: of sensors, and of the flashes' energy; 0 to 100.
    pub noise: f64,
    /// Standard deviation of the energy of a flash from shot to shot, as a share, 0 to 0.2.
    pub flash_spread: f64,
    /// How far the nominal poses are off the true ones: millimetres along each axis, 0 to 20.
    pub pose_error_mm: f64,
    /// The same about each axis, degrees, 0 to 2.
    pub pose_error_deg: f64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Cameras at one polar angle, evenly around.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ring {
    /// How many, 1 to 200; even numbers stand in opposite pairs, which see each other's flash mirrored.
    pub cameras: usize,
    /// From the normal, degrees, 0 to 85.
    pub polar_deg: f64,
    /// Azimuth of the first, degrees.
    #[serde(default)]
    pub first_azimuth_deg: f64,
}

impl Default for DomeOptions {
    fn default() -> Self {
        let ring = |cameras, polar_deg, first_azimuth_deg| Ring { cameras, polar_deg, first_azimuth_deg };
        let exposure = |flash_quantity, iso, relative| Exposure { flash_quantity, iso, relative };
        let target = |x, y, reflectance| WhiteTarget { center_mm: [x, y], side_mm: 2.4, reflectance };
        Self {
            rings: vec![
                ring(1, 0.0, 0.0),
                ring(2, 16.0, 45.0),
                ring(2, 24.0, 135.0),
                ring(2, 36.0, 10.0),
                ring(2, 42.0, 70.0),
                ring(2, 48.0, 130.0),
                ring(2, 58.0, 0.0),
                ring(2, 62.0, 36.0),
                ring(2, 66.0, 72.0),
                ring(2, 70.0, 108.0),
                ring(2, 75.0, 144.0),
            ],
            radius_mm: 650.0,
            scatter_deg: 0.7,
            image_px: [256; 2],
            field_mm: 26.0,
            zoom: 3.0,
            sample_mm: [17.0; 2],
            flash: Flash { offset_mm: [9.0, 0.0], size_mm: [10.0, 7.0], points: [10, 9] },
            exposures: vec![
                exposure(2, 50, 1.0 / 256.0),
                exposure(1, 50, 1.0 / 16.0),
                exposure(0, 50, 1.0),
                exposure(0, 400, 8.0),
            ],
            white: 0.06,
            white_targets: vec![
                target(-10.4, 0.0, 0.023),
                target(10.4, 0.0, 0.14),
                target(0.0, -10.4, 0.5),
                target(0.0, 10.4, 0.969),
            ],
            leds: [11, 11],
            led_pitch_mm: 5.0,
            full_well: 40_000.0,
            read_noise: 4.0,
            bits: 12,
            noise: 1.0,
            flash_spread: 0.01,
            pose_error_mm: 2.0,
            pose_error_deg: 0.3,
            seed: 1,
        }
    }
}

impl DomeOptions {
    /// Options from the text of a `DOME.toml`.
    ///
    /// # Errors
    /// Not TOML, an unknown key, a value of the wrong kind or outside its range.
    pub fn parse(text: &str) -> Result<Self> {
        let wrong = |e: &dyn std::fmt::Display| Error::invalid("", "dome", e, "the keys of a dome");
        let document = toml::Deserializer::parse(text).map_err(|e| wrong(&e.message()))?;
        let options: Self = serde_path_to_error::deserialize(document)
            .map_err(|e| wrong(&e.inner().message()).within(e.path()))?;
        options.validate()?;
        Ok(options)
    }

    /// Checks every number that [`Rig::validate`](crate::measure::Rig::validate) does not see.
    ///
    /// # Errors
    /// A number outside its range, named.
    pub fn validate(&self) -> Result<()> {
        let cameras: usize = self.rings.iter().map(|ring| ring.cameras).sum();
        range("dome", "number of cameras", cameras, 2..=1000)?;
        for ring in &self.rings {
            range("dome", "rings: cameras", ring.cameras, 1..=200)?;
            range("dome", "rings: polar_deg", ring.polar_deg, 0.0..=85.0)?;
            range("dome", "rings: first_azimuth_deg", ring.first_azimuth_deg, -360.0..=360.0)?;
        }
        self.image_px.iter().try_for_each(|n| range("dome", "image_px", *n, 32..=4096))?;
        self.leds.iter().try_for_each(|n| range("dome", "leds", *n, 2..=100))?;
        range("dome", "bits", self.bits as usize, 8..=16)?;
        for (what, value, legal) in [
            ("radius_mm", self.radius_mm, 10.0..=1e5),
            ("scatter_deg", self.scatter_deg, 0.0..=5.0),
            ("field_mm", self.field_mm, 1.0..=1000.0),
            ("zoom", self.zoom, 1.0..=20.0),
            ("white", self.white, 1e-6..=1e3),
            ("led_pitch_mm", self.led_pitch_mm, 0.1..=100.0),
            ("full_well", self.full_well, 100.0..=1e7),
            ("read_noise", self.read_noise, 0.0..=1000.0),
            ("noise", self.noise, 0.0..=100.0),
            ("flash_spread", self.flash_spread, 0.0..=0.2),
            ("pose_error_mm", self.pose_error_mm, 0.0..=20.0),
            ("pose_error_deg", self.pose_error_deg, 0.0..=2.0),
        ] {
            range("dome", what, value, legal)?;
        }
        self.sample_mm.iter().try_for_each(|side| range("dome", "sample_mm", *side, 0.1..=1000.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_legal_and_faults_are_named() {
        assert_eq!(DomeOptions::parse("").unwrap(), DomeOptions::default());
        for (text, word) in [
            ("radius = 3", "radius"),
            ("radius_mm = 3", "10 to 100000"),
            ("noise = nan", "NaN"),
            ("rings = [{ cameras = 1, polar_deg = 0 }]", "number of cameras"),
            ("rings = [{ cameras = 3, polar_deg = 88 }]", "polar_deg"),
            ("image_px = [256]", "image_px"),
            ("bits = 33", "bits"),
            ("= 3", "dome"),
        ] {
            let message = DomeOptions::parse(text).unwrap_err().to_string();
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}
