//! Scattering kernels of a film on the nodes: cosine series in azimuth, for several wavelengths at once.
//!
//! A kernel is what a film scatters per steradian and, along the path, per thickness of the film (the coefficients of eqs 9,
//! 12, 13 with their misprints corrected, times h); K_m is `int K(phi) cos(m phi) dphi` over the full circle. It is symmetric
//! in its two directions, so that each pair of nodes is held once.

use crate::error::Result;
use crate::parallel::TryMap;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Which way light is scattered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Back to the side it came from.
    Reflection,
    /// Onwards.
    Transmission,
}

/// Both sides.
pub const SIDES: [Side; 2] = [Side::Reflection, Side::Transmission];

/// How much of a kernel is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Nodes of the film.
    pub nodes: usize,
    /// Azimuth modes, m = 0 included.
    pub modes: usize,
    /// Wavelengths.
    pub bands: usize,
}

/// The modes of a kernel, for every pair of nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    extent: Extent,
    /// For each pair (i, j <= i): side, mode, band.
    pairs: Vec<Vec<f64>>,
}

impl Kernel {
    /// Computes a kernel: `add(i, j, sums)` adds what is known of the pair to `sums`, laid out side, mode, band.
    ///
    /// # Errors
    /// Those of `add`.
    pub fn new(extent: Extent, add: impl Fn(usize, usize, &mut [f64]) -> Result<()> + Sync) -> Result<Self> {
        let pairs = (0..extent.nodes * (extent.nodes + 1) / 2).into_par_iter().try_map(|pair| {
            let mut sums = vec![0.0; 2 * extent.modes * extent.bands];
            let (i, j) = unpaired(pair);
            add(i, j, &mut sums)?;
            Ok(sums)
        })?;
        Ok(Self { extent, pairs })
    }

    /// What is held.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// K_m as a symmetric matrix over the nodes.
    pub fn matrix(&self, side: Side, mode: usize, band: usize) -> DMatrix<f64> {
        let Extent { nodes, modes, bands } = self.extent;
        let at = (side as usize * modes + mode) * bands + band;
        let mut matrix = DMatrix::zeros(nodes, nodes);
        for (pair, sums) in self.pairs.iter().enumerate() {
            let (i, j) = unpaired(pair);
            matrix[(i, j)] = sums[at];
            matrix[(j, i)] = sums[at];
        }
        matrix
    }
}

/// The pair (i, j <= i) with index `i (i + 1)/2 + j`.
fn unpaired(pair: usize) -> (usize, usize) {
    let mut i = ((8.0 * pair as f64 + 1.0).sqrt() / 2.0 - 0.5) as usize;
    // The root may round either way.
    while i * (i + 1) / 2 > pair {
        i -= 1;
    }
    while (i + 1) * (i + 2) / 2 <= pair {
        i += 1;
    }
    (i, pair - i * (i + 1) / 2)
}
