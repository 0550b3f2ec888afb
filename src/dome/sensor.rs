//! What a sensor says of linear light: shot and read noise, clipping, a response curve, bits.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// ISO speed at which electrons are counted as they come.
const BASE_ISO: f64 = 50.0;
/// Share of the range below black: so that the noise of dark pixels is not cut off.
const PEDESTAL: f64 = 0.004;
/// Where the curve is straight, as a share of the range: gamma alone would be infinitely steep at black.
const TOE: f64 = 0.005;

/// One camera's sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Sensitivity of each channel; 1 is nominal.
    pub gain: [f64; 3],
    /// Response curve of each channel.
    pub response: [Response; 3],
    /// Electrons of a saturated pixel at ISO 50.
    pub full_well: f64,
    /// Noise of reading, electrons.
    pub read_noise: f64,
    /// Factor on both noises.
    pub noise: f64,
    /// Bits of a pixel.
    pub bits: u32,
}

/// From linear light to what a pixel says, both 0 to 1: a power with a straight toe, bent by a cubic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// The power is its inverse.
    pub gamma: f64,
    /// Height of the bend, -0.2 to 0.2: the curve rises everywhere.
    pub bend: f64,
}

impl Response {
    /// What a pixel says of light, 0 = darkness, 1 = saturation; rising, clipped at both ends, above 0 in darkness.
    pub fn respond(&self, light: f64) -> f64 {
        self.curve()(light)
    }

    /// [`Response::respond`] for many pixels.
    fn curve(&self) -> impl Fn(f64) -> f64 + use<> {
        let (exponent, bend) = (1.0 / self.gamma, self.bend);
        let power = move |x: f64| (x + TOE).powf(exponent);
        let [black, white] = [0.0, 1.0].map(power);
        move |light| {
            let x = ((light + PEDESTAL) / (1.0 + PEDESTAL)).clamp(0.0, 1.0);
            let y = (power(x) - black) / (white - black);
            y + bend * y * (1.0 - y) * (1.0 - 2.0 * y)
        }
    }
}

impl Sensor {
    /// What the pixels say of linear light (1 saturates a channel of gain 1 at any ISO speed), in steps of the bits, 0 to 1.
    pub fn expose(&self, light: &[[f64; 3]], iso: u32, seed: u64) -> Vec<[f32; 3]> {
        let amplification = f64::from(iso) / BASE_ISO;
        let electrons = self.full_well / amplification;
        let top = f64::from((1u32 << self.bits) - 1);
        let mut rng = Pcg64::seed_from_u64(seed);
        let curves = self.response.map(|response| response.curve());
        let mut pixel = |light: f64, channel: usize| {
            let light = light * self.gain[channel];
            let deviate: f64 = StandardNormal.sample(&mut rng);
            // Shot noise as a Gaussian: some ten electrons are the least that counts.
            let variance = (light * electrons).max(0.0) + self.read_noise.powi(2);
            let seen = light + self.noise * variance.sqrt() / electrons * deviate;
            ((curves[channel](seen) * top).round() / top) as f32
        };
        light.iter().map(|rgb| [0, 1, 2].map(|c| pixel(rgb[c], c))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor(noise: f64) -> Sensor {
        let response = [Response { gamma: 1.9, bend: 0.1 }; 3];
        Sensor { gain: [1.0, 0.9, 1.1], response, full_well: 20_000.0, read_noise: 5.0, noise, bits: 12 }
    }

    #[test]
    fn curves_rise_from_black_to_white() {
        for bend in [-0.2, 0.0, 0.2] {
            let curve = Response { gamma: 2.1, bend };
            let values: Vec<f64> = (-10..=1010).map(|k| curve.respond(f64::from(k) * 1e-3)).collect();
            assert!(values.windows(2).all(|pair| pair[1] >= pair[0]), "{bend}");
            assert_eq!(values[0], 0.0);
            assert!((values[1020] - 1.0).abs() < 1e-12 && curve.respond(0.0) > 0.0);
        }
    }

    #[test]
    fn noise_is_that_of_the_electrons() {
        let (light, iso) = (0.02, 400);
        let n = 20_000;
        let pixels = sensor(1.0).expose(&vec![[light; 3]; n], iso, 7);
        let straight = sensor(1.0).response[0];
        // Back through the curve's slope at the mean.
        let slope = (straight.respond(light + 1e-4) - straight.respond(light - 1e-4)) / 2e-4;
        let mean = pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / n as f64;
        let variance = pixels.iter().map(|p| (f64::from(p[0]) - mean).powi(2)).sum::<f64>() / n as f64;
        let expected = (light * 2500.0 + 25.0) / 2500f64.powi(2) * slope * slope;
        // Four standard errors of a variance, and 2 % for the curve's bend over the noise.
        let tolerance = 4.0 * (2.0 / n as f64).sqrt() + 0.02;
        assert!((variance / expected - 1.0).abs() < tolerance, "{variance} {expected}");
        let quiet = sensor(0.0).expose(&[[light; 3]], iso, 7);
        assert_eq!(quiet, sensor(0.0).expose(&[[light; 3]], iso, 8));
        assert!(sensor(0.0).expose(&[[5.0; 3]], iso, 7)[0].iter().all(|v| *v == 1.0), "saturated");
    }
}
