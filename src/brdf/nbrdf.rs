//! Reader of neural BRDFs: small networks fitted to measured materials (Sztrajman et al. 2021).
//!
//! 675 little-endian f32: `W1[6][21] b1[21] W2[21][21] b2[21] W3[21][3] b3[3]`. Two hidden layers with ReLU; the BRDF is
//! `max(exp(o) - 1, 0)`, linear RGB, 1/sr. They are smooth fits, not measurements: the clear-coat peak is blurred.

use super::TabulatedBrdf;
use super::measured::open;
use crate::error::{Error, Result};
use glam::DVec3;
use std::io::Read;
use std::path::Path;

/// Numbers of the network's layers.
const LAYERS: [usize; 4] = [6, 21, 21, 3];
/// Numbers in a file.
const COUNT: usize = 675;
/// Length of a file.
pub(super) const BYTES: u64 = 4 * COUNT as u64;

/// A BRDF as a network of 6-21-21-3 neurons.
#[derive(Debug, Clone, PartialEq)]
pub struct NeuralBrdf {
    weights: Vec<f64>,
}

/// Reads a neural BRDF.
///
/// # Errors
/// A file that cannot be read, a length other than 2700 bytes, a number that is not finite (its index named).
pub fn read_nbrdf(path: &Path) -> Result<NeuralBrdf> {
    let (mut file, length) = open(path)?;
    if length != BYTES {
        let legal = format!("{BYTES} bytes ({COUNT} numbers)");
        return Err(Error::invalid("neural BRDF", "length", format!("{length} bytes"), legal).in_file(path));
    }
    let mut bytes = Vec::with_capacity(4 * COUNT);
    file.read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    let weights: Vec<f64> =
        bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect();
    NeuralBrdf::new(weights).map_err(|e| e.in_file(path))
}

impl NeuralBrdf {
    /// A network from its 675 numbers, in file order.
    ///
    /// # Errors
    /// Another count, a number that is not finite.
    pub fn new(weights: Vec<f64>) -> Result<Self> {
        if weights.len() != COUNT {
            return Err(Error::invalid("neural BRDF", "count", weights.len(), format!("{COUNT} numbers")));
        }
        if let Some(k) = weights.iter().position(|w| !w.is_finite()) {
            let place = format!("neural BRDF: number {k}");
            return Err(Error::invalid(place, "value", weights[k], "a finite number"));
        }
        Ok(Self { weights })
    }

    /// BRDF for unit directions away from the surface, linear RGB, 1/sr, never negative; 0 below the horizon.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return DVec3::ZERO;
        }
        let h = (wi + wo).normalize();
        let sin_h = h.truncate().length();
        // Azimuth of h turned away; any azimuth serves at the pole.
        let (cos_p, sin_p) = if sin_h > 0.0 { (h.x / sin_h, h.y / sin_h) } else { (1.0, 0.0) };
        let turned = DVec3::new(wi.x * cos_p + wi.y * sin_p, wi.y * cos_p - wi.x * sin_p, wi.z);
        let difference =
            DVec3::new(turned.x * h.z - turned.z * sin_h, turned.y, turned.x * sin_h + turned.z * h.z);
        let mut signal = vec![sin_h, 0.0, h.z, difference.x, difference.y, difference.z];
        let mut rest = self.weights.as_slice();
        for (layer, shape) in LAYERS.windows(2).enumerate() {
            let (matrix, after) = rest.split_at(shape[0] * shape[1]);
            let (bias, after) = after.split_at(shape[1]);
            rest = after;
            let mut output = bias.to_vec();
            for (row, x) in matrix.chunks_exact(shape[1]).zip(&signal) {
                output.iter_mut().zip(row).for_each(|(sum, w)| *sum += w * x);
            }
            if layer + 2 < LAYERS.len() {
                output.iter_mut().for_each(|x| *x = x.max(0.0));
            }
            signal = output;
        }
        DVec3::new(signal[0], signal[1], signal[2]).map(|o| o.exp_m1().max(0.0))
    }

    /// The same BRDF as a table of 45 polar and 90 azimuthal cells.
    ///
    /// # Errors
    /// A network whose values leave the range of f32.
    pub fn table(&self) -> Result<TabulatedBrdf> {
        TabulatedBrdf::from_fn(45, 90, |wi, wo| self.eval(wi, wo))
    }
}
