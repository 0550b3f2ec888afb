//! A film on the nodes, at one wavelength: thin layer, then doubling.
//!
//! With `tau_j = x_j / cos_j` the optical thickness of the film along node j and K its kernel, a layer of the share s of its
//! thickness scatters once
//!
//! `R_1 = K / (cos cos') int_0^s exp(-(tau + tau') z) dz`, `T_1 = K / (cos cos') int_0^s exp(-tau z - tau' (s - z)) dz`,
//!
//! exactly, at grazing angles too: eq. 11 with its clipped angles is not needed. Grazing light is lost within any layer, so
//! that the error of single scattering falls hardly faster than s; light scattered twice is therefore added,
//! `s^2 a K g(tau s) K a` with the exact path between the two events, `g(t) = (t - 1 + exp(-t))/t^2`, and the mean attenuation
//! `a` before and after. What scatters three times goes on in the direct beam, so that no light is lost. The error, of third
//! order in s, is taken out by extrapolation from two thin layers: `(4 D(s/2) - D(s))/3` (Richardson). The thinness of
//! eq. 15, there a bound for h times the extinction, is a bound for the scattering thickness of the layer, which governs
//! that error.
//!
//! Extinction is what closes the energy: `x_j` = absorption + all that the discrete kernel scatters out of node j. The
//! integral over an onward peak narrower than the nodes is so taken as not scattered.

use super::doubling::Slab;
use super::kernel::{Kernel, SIDES, Side};
use super::layer::Layer;
use super::nodes::{Direction, Nodes};
use super::operator::Operator;
use crate::error::Result;
use crate::simulate::optics::film_optics::mean_attenuation;
use nalgebra::DMatrix;

/// Most doublings: an optical thickness of 1e9 from layers of 1e-3.
const MAX_DOUBLINGS: u32 = 40;

/// A film at one wavelength.
#[derive(Debug, Clone)]
pub struct FilmTransfer {
    /// `sqrt(g) / (eta cos)`: kernel to operator, without attenuation.
    scale: Vec<f64>,
    cos: Vec<f64>,
    /// `sqrt(g)`.
    amplitude: Vec<f64>,
    /// Extinction x and what of it is scattering, both along the normal.
    extinction: Vec<f64>,
    scattering: Vec<f64>,
    doublings: u32,
    /// The thin layers of the whole start and of half of it.
    starts: [Start; 2],
}

/// What all modes of a thin layer share.
#[derive(Debug, Clone)]
struct Start {
    beam: Vec<f64>,
    /// For each side, what multiplies the kernel where light is scattered once.
    once: [DMatrix<f64>; 2],
    /// `s a`.
    ends: Vec<f64>,
    /// `g`.
    between: Vec<f64>,
}

impl FilmTransfer {
    /// A film of index `index` whose kernel is number `band` of `kernel`; `absorption` is `kappa h` and the like, without
    /// 1/cos, for each node. The first layer has a scattering thickness of at most `thinness`.
    pub fn new(
        nodes: &Nodes,
        index: f64,
        kernel: &Kernel,
        band: usize,
        absorption: &[f64],
        thinness: f64,
    ) -> Self {
        let directions: Vec<Direction> = nodes.directions(index);
        let weights = nodes.weights();
        let cos: Vec<f64> = directions.iter().map(|d| d.cos).collect();
        let amplitude: Vec<f64> = weights.iter().take(cos.len()).map(|g| g.sqrt()).collect();
        let scale: Vec<f64> = amplitude.iter().zip(&cos).map(|(a, c)| a / (index * c)).collect();
        let (back, on) =
            (kernel.matrix(Side::Reflection, 0, band), kernel.matrix(Side::Transmission, 0, band));
        let both = &back + &on;
        let n = cos.len();
        let scattering: Vec<f64> =
            (0..n).map(|j| (0..n).map(|i| both[(i, j)] * scale[i].powi(2) * cos[i]).sum()).collect();
        let extinction: Vec<f64> = scattering.iter().zip(absorption).map(|(s, a)| s + a).collect();
        let thickest = scattering.iter().copied().fold(0.0, f64::max);
        let doublings = (thickest / thinness).log2().ceil().clamp(0.0, f64::from(MAX_DOUBLINGS)) as u32;
        let mut film = Self {
            scale,
            cos,
            amplitude,
            extinction,
            scattering,
            doublings,
            starts: [Start::empty(), Start::empty()],
        };
        let share = (-f64::from(doublings)).exp2();
        let scatter = film.scatter(&back, &on);
        film.starts = [share, 0.5 * share].map(|share| film.start(share, &scatter));
        film
    }

    /// How often the first layer is doubled.
    pub fn doublings(&self) -> u32 {
        self.doublings
    }

    /// Extinction that closes the energy, along the normal, for each node.
    pub fn extinction(&self) -> &[f64] {
        &self.extinction
    }

    /// Optical thickness along a node.
    fn thickness(&self, node: usize) -> f64 {
        self.extinction[node] / self.cos[node]
    }

    /// `exp(-tau)` for each node.
    pub fn unscattered(&self) -> Vec<f64> {
        (0..self.cos.len()).map(|k| (-self.thickness(k)).exp()).collect()
    }

    /// The kernel as operators, without attenuation: back and on.
    fn scatter(&self, back: &DMatrix<f64>, on: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
        let n = self.cos.len();
        [back, on].map(|k| DMatrix::from_fn(n, n, |i, j| self.scale[i] * self.scale[j] * k[(i, j)]))
    }

    fn start(&self, share: f64, scatter: &[DMatrix<f64>; 2]) -> Start {
        let n = self.cos.len();
        let tau: Vec<f64> = (0..n).map(|k| self.thickness(k) * share).collect();
        let all = |side| DMatrix::from_fn(n, n, |i, j| share * attenuation(side, [tau[i], tau[j]]));
        let mut start = Start {
            beam: vec![0.0; n],
            once: SIDES.map(all),
            ends: tau.iter().map(|t| share * mean_attenuation(*t)).collect(),
            between: tau.iter().map(|t| mean_overlap(*t)).collect(),
        };
        // What one event takes out of the beam, less what the layer lets out after one or two, is scattered thrice.
        let slab = start.slab(scatter);
        let albedo: Vec<f64> = (0..n)
            .map(|i| if self.extinction[i] > 0.0 { self.scattering[i] / self.extinction[i] } else { 0.0 })
            .collect();
        let beam = (0..n).map(|j| {
            let sum: f64 = (0..n)
                .map(|i| {
                    let scattered = scatter[0][(i, j)] + scatter[1][(i, j)];
                    let out = scatter[0][(i, j)] * start.once[0][(i, j)]
                        + scatter[1][(i, j)] * start.once[1][(i, j)];
                    let twice = slab.reflection[(i, j)] + slab.transmission[(i, j)] - out;
                    self.amplitude[i] * (albedo[i] * (start.ends[j] * scattered - out) - twice)
                })
                .sum();
            (-tau[j]).exp() + sum / self.amplitude[j]
        });
        start.beam = beam.collect();
        start
    }

    /// The film as a layer, in one mode.
    ///
    /// # Errors
    /// As [`Slab::doubled`].
    pub fn layer(&self, kernel: &Kernel, mode: usize, band: usize) -> Result<Layer> {
        let scatter = self.scatter(
            &kernel.matrix(Side::Reflection, mode, band),
            &kernel.matrix(Side::Transmission, mode, band),
        );
        let [whole, half] = self.starts.each_ref().map(|start| start.slab(&scatter));
        let halves = half.doubled()?;
        let extrapolate = |half: DMatrix<f64>, whole: DMatrix<f64>| (half * 4.0 - whole) / 3.0;
        let mut slab = Slab {
            reflection: extrapolate(halves.reflection, whole.reflection),
            transmission: extrapolate(halves.transmission, whole.transmission),
        };
        // The direct beam goes through the same steps, apart from what is scattered back into it.
        let [whole, half] = self.starts.each_ref().map(|start| &start.beam);
        let mut beam: Vec<f64> =
            half.iter().zip(whole).map(|(half, whole)| (4.0 * half * half - whole) / 3.0).collect();
        for _ in 0..self.doublings {
            slab = slab.doubled()?;
            beam.iter_mut().for_each(|b| *b *= *b);
        }
        let n = beam.len();
        let mut dense = slab.transmission;
        beam.iter().enumerate().for_each(|(k, b)| dense[(k, k)] -= b);
        let reflection = Operator::square(vec![0.0; n], slab.reflection);
        Ok(Layer::symmetric(reflection, Operator::square(beam, dense)))
    }

    /// BRDF, inside the film, of what is scattered once to a side, for the mode of the matrix `kernel`.
    pub fn once(&self, side: Side, kernel: &DMatrix<f64>, i: usize, j: usize) -> f64 {
        let paths = [self.thickness(i), self.thickness(j)];
        kernel[(i, j)] / (self.cos[i] * self.cos[j]) * attenuation(side, paths)
    }

    /// What the film takes from light that enters it at each node, as a functional of amplitudes: all less what `layer`, its
    /// layer for m = 0, lets out.
    pub fn absorbed(&self, layer: &Layer) -> Vec<f64> {
        let out = layer.reflect_above.before(&self.amplitude);
        let through = layer.transmit_down.before(&self.amplitude);
        self.amplitude.iter().zip(out.iter().zip(through)).map(|(a, (r, t))| a - r - t).collect()
    }
}

/// Mean over the depth of a scattering event of what the film leaves of light on its way in and out, for these optical
/// thicknesses of the whole film along both: the integrals over z above.
pub fn attenuation(side: Side, [a, b]: [f64; 2]) -> f64 {
    match side {
        Side::Reflection => mean_attenuation(a + b),
        Side::Transmission => (-a.min(b)).exp() * mean_attenuation((a - b).abs()),
    }
}

/// `(t - 1 + exp(-t))/t^2`, t 0 or more: integral of `exp(-t (y - x))` over `0 < x < y < 1`.
pub fn mean_overlap(t: f64) -> f64 {
    // Below 1 the difference loses digits; the terms of `sum (-t)^k / (k + 2)!` fall to 1e-18 of the sum.
    if t < 1.0 {
        (3..=20).rev().fold(1.0, |rest, k| 1.0 - t / f64::from(k) * rest) / 2.0
    } else {
        (t + (-t).exp_m1()) / (t * t)
    }
}

impl Start {
    fn empty() -> Self {
        Self {
            beam: Vec::new(),
            once: [DMatrix::zeros(0, 0), DMatrix::zeros(0, 0)],
            ends: Vec::new(),
            between: Vec::new(),
        }
    }

    /// The layer for a mode with these operators of scattering.
    fn slab(&self, [back, on]: &[DMatrix<f64>; 2]) -> Slab {
        let n = back.nrows();
        let mut reflection = self.once[0].component_mul(back);
        let mut transmission = self.once[1].component_mul(on);
        // Light that is even or odd about the middle stays so.
        for (sign, p) in [(0.5, on + back), (-0.5, on - back)] {
            let mut scaled = p.clone();
            for (mut row, g) in scaled.row_iter_mut().zip(&self.between) {
                row *= *g;
            }
            let twice = p * scaled;
            for j in 0..n {
                for i in 0..n {
                    let value = self.ends[i] * self.ends[j] * twice[(i, j)];
                    reflection[(i, j)] += sign * value;
                    transmission[(i, j)] += 0.5 * value;
                }
            }
        }
        self.beam.iter().enumerate().for_each(|(k, b)| transmission[(k, k)] += b);
        Slab { reflection, transmission }
    }
}
