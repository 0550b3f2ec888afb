//! All scatterers of a film on its nodes, and what it absorbs there.

use super::flake_kernel::FlakeKernel;
use super::kernel::{Extent, Kernel};
use super::nodes::Direction;
use super::phase_kernel::PhaseKernel;
use crate::color::BANDS;
use crate::error::Result;
use crate::simulate::optics::film_optics::{FilmOptics, KindOptics};
use crate::simulate::optics::flake_optics::FlakeOptics;
use crate::simulate::optics::orientation::{FlakeLobe, HalfVectorDensity};
use rayon::prelude::*;

/// How finely kernels are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Azimuth modes, m = 0 included.
    pub modes: usize,
    /// P is left out below this share of its peak.
    pub cutoff: f64,
    /// Fewest azimuths between two breaks of P.
    pub azimuths: usize,
    /// Flakes of a narrower P than this, radians, are widened to it: the nodes do not hold narrower ones.
    pub least_width: f64,
}

/// The kernel of a film for these directions and bands.
///
/// # Errors
/// As [`PhaseKernel::add`] and [`HalfVectorDensity::new`].
pub fn film_kernel(
    film: &FilmOptics,
    directions: &[Direction],
    bands: &[usize],
    resolution: Resolution,
) -> Result<Kernel> {
    let Resolution { modes, cutoff, azimuths, least_width } = resolution;
    let kinds = film.kinds.iter().filter(|kind| kind.area_density > 0.0);
    let flakes = kinds
        .map(|kind| Ok(FlakeKernel::new(kind, at_least(kind, least_width)?, cutoff, azimuths, modes)))
        .collect::<Result<Vec<_>>>()?;
    let pigments: Vec<_> = film.pigments.iter().map(|kind| PhaseKernel::new(kind, modes, bands)).collect();
    let extent = Extent { nodes: directions.len(), modes, bands: bands.len() };
    Kernel::new(extent, |i, j, sums| {
        let (a, b) = (directions[i], directions[j]);
        flakes.iter().for_each(|kind| kind.add(a, b, extent, bands, sums));
        pigments.iter().try_for_each(|kind| kind.add(a, b, extent, bands, sums))
    })
}

/// P of a kind, spread by a lobe of the least width where it has narrower features.
fn at_least(kind: &KindOptics, width: f64) -> Result<HalfVectorDensity> {
    if kind.density.width() < width {
        // From a Gaussian's width to that at half its maximum.
        let lobe = FlakeLobe::new((8.0 * std::f64::consts::LN_2).sqrt() * width);
        HalfVectorDensity::new(kind.orientation.clone(), Some(lobe))
    } else {
        Ok(kind.density.clone())
    }
}

/// What a film absorbs from light along each direction, per band (outer) and direction, along the normal: binder, pigments
/// and `D<S>h <(1 - r_p - t_p) |cos alpha|>`.
pub fn film_absorption(film: &FilmOptics, directions: &[Direction], bands: &[usize]) -> Vec<Vec<f64>> {
    let each: Vec<Vec<f64>> = directions
        .par_iter()
        .map(|direction| {
            let mut sum: Vec<f64> = bands.iter().map(|k| film.absorption.0[*k]).collect();
            for pigment in &film.pigments {
                for (s, k) in sum.iter_mut().zip(bands) {
                    *s += (pigment.extinction.0[*k] - pigment.scattering.0[*k]).max(0.0);
                }
            }
            film.kinds.iter().for_each(|kind| add_absorption(kind, *direction, bands, &mut sum));
            sum
        })
        .collect();
    (0..bands.len()).map(|band| each.iter().map(|row| row[band]).collect()).collect()
}

fn add_absorption(kind: &KindOptics, direction: Direction, bands: &[usize], sum: &mut [f64]) {
    let theta = direction.sin.atan2(direction.cos);
    let mut area = 0.0;
    let rays = |add: &mut dyn FnMut(f64, f64)| kind.density.projected_average(theta, add);
    rays(&mut |_, weight| area += weight);
    let kept: [f64; BANDS] = match &kind.optics {
        FlakeOptics::Mirror(mirror) => {
            std::array::from_fn(|k| area * (mirror.reflectance.0[k] + mirror.transmittance.0[k]))
        }
        FlakeOptics::Stack { reflectance, transmittance, .. } => {
            let [r, t] = [reflectance, transmittance].map(|table| table.weighted_sum(rays));
            std::array::from_fn(|k| r[k] + t[k])
        }
    };
    for (s, k) in sum.iter_mut().zip(bands) {
        // Tables are good to 1e-9: no absorption may come out below zero.
        *s += kind.area_density * (area - kept[*k]).max(0.0);
    }
}
