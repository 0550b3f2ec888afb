//! Pigments as scatterers: `K = D sigma_sc h g(cos(Theta))` per steradian (eqs 12, 13 corrected), by real FFT in azimuth.
//!
//! `cos(Theta) = -+cos cos' + sin sin' cos(phi)`, minus backwards: the scattering angle, not the gamma of eq. 14.

use super::kernel::{Extent, SIDES, Side};
use super::nodes::Direction;
use crate::error::{Error, Result};
use crate::simulate::optics::pigment::{Phase, PigmentOptics};
use realfft::{RealFftPlanner, RealToComplex};
use std::f64::consts::PI;
use std::sync::Arc;

/// Fewest and most azimuths of a transform.
const AZIMUTHS: std::ops::RangeInclusive<usize> = 64..=2048;

/// Transforms the phase function of one kind of pigments.
pub struct PhaseKernel<'a> {
    pigment: &'a PigmentOptics,
    transform: Arc<dyn RealToComplex<f64>>,
    /// The bands with one phase function each, and for all bands which of those.
    distinct: (Vec<usize>, Vec<usize>),
}

impl<'a> PhaseKernel<'a> {
    /// Prepares a kind of pigments, for `modes` azimuth modes at these bands.
    pub fn new(pigment: &'a PigmentOptics, modes: usize, bands: &[usize]) -> Self {
        // Samples beyond twice the highest mode keep aliases of a smooth phase function out; a sharp one decays like g^m.
        let decay = bands.iter().map(|band| pigment.phase.asymmetry(*band).abs()).fold(0.0, f64::max);
        let needed = modes as f64 + 30.0 / -(decay.clamp(1e-3, 0.999)).ln();
        let n = (needed as usize).next_power_of_two().clamp(*AZIMUTHS.start(), *AZIMUTHS.end());
        Self {
            pigment,
            transform: RealFftPlanner::new().plan_fft_forward(n.max((2 * modes).next_power_of_two())),
            distinct: distinct(&pigment.phase, bands),
        }
    }

    /// Adds the modes of a pair of directions, for these bands, to `sums` (side, mode, band).
    ///
    /// # Errors
    /// The transform refuses its buffers: never.
    pub fn add(
        &self,
        a: Direction,
        b: Direction,
        extent: Extent,
        bands: &[usize],
        sums: &mut [f64],
    ) -> Result<()> {
        let (firsts, which) = &self.distinct;
        let mut samples = self.transform.make_input_vec();
        let mut series = self.transform.make_output_vec();
        let n = samples.len();
        for (side, sums) in SIDES.into_iter().zip(sums.chunks_exact_mut(extent.modes * extent.bands)) {
            let vertical = if side == Side::Reflection { -a.cos * b.cos } else { a.cos * b.cos };
            for (group, band) in firsts.iter().enumerate() {
                for (k, sample) in samples.iter_mut().enumerate() {
                    let phi = 2.0 * PI * k as f64 / n as f64;
                    let cos = (vertical + a.sin * b.sin * phi.cos()).clamp(-1.0, 1.0);
                    *sample = self.pigment.phase.eval(cos, *band);
                }
                self.transform
                    .process(&mut samples, &mut series)
                    .map_err(|e| Error::unsupported("azimuth series", "transform", e, "buffers that fit"))?;
                for (row, mode) in sums.chunks_exact_mut(extent.bands).zip(&series) {
                    let scale = 2.0 * PI / n as f64 * mode.re;
                    for ((sum, k), g) in row.iter_mut().zip(bands).zip(which) {
                        if *g == group {
                            *sum += scale * self.pigment.scattering.0[*k];
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// Bands with one phase function each, and for all bands which of those.
fn distinct(phase: &Phase, bands: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let mut firsts: Vec<usize> = Vec::new();
    let mut which = Vec::new();
    for band in bands {
        let group = firsts.iter().position(|first| phase.alike(*first, *band)).unwrap_or(firsts.len());
        if group == firsts.len() {
            firsts.push(*band);
        }
        which.push(group);
    }
    (firsts, which)
}
