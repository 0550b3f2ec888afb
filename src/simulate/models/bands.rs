//! Which wavelengths the full model solves, and how the others come from them.
//!
//! Wavelengths at which a paint is the same are solved once. Of the others, every eighth band is solved and every one at
//! which an input spectrum bends, then the middle between solved neighbors, until a middle is met by linear interpolation;
//! bands between neighbors are interpolated. (What flakes scatter once needs none of this: it is a formula.)

use super::paint_transfer::{BandSolution, PaintTransfer};
use crate::color::{BANDS, Spectrum};
use crate::error::Result;
use crate::parallel::TryMap;
use crate::simulate::optics::film_optics::PaintOptics;
use crate::simulate::optics::flake_optics::FlakeOptics;
use crate::simulate::optics::pigment::Phase;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Bands from one solved first to the next.
const STRIDE: usize = 8;

/// Which wavelengths are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bands {
    /// Each that differs from the others.
    All,
    /// As few as interpolation allows.
    Adaptive {
        /// Largest error of an interpolated value over itself, where tested.
        tolerance: f64,
    },
}

/// The solutions of some bands, and what every band takes of them.
pub struct SolvedBands {
    /// Solutions of different wavelengths.
    pub solutions: Vec<BandSolution>,
    /// For every band, solutions by number and what each counts.
    pub shares: Vec<Vec<(usize, f64)>>,
}

/// Bands that differ, and which of those every band is.
pub struct Classes {
    /// One band of each class.
    pub first: Vec<usize>,
    of: Vec<usize>,
}

impl Classes {
    /// The classes of a paint.
    pub fn new(optics: &PaintOptics) -> Self {
        let inputs = Inputs::new(optics);
        let mut first: Vec<usize> = Vec::new();
        let mut of = Vec::new();
        for band in 0..BANDS {
            let class = first.iter().position(|other| inputs.equal(*other, band)).unwrap_or(first.len());
            if class == first.len() {
                first.push(band);
            }
            of.push(class);
        }
        Self { first, of }
    }
}

impl Bands {
    /// Solves the bands of a paint; `transfer` is of the first bands of `classes`.
    ///
    /// # Errors
    /// As [`PaintTransfer::solve`].
    pub fn solve(
        self,
        optics: &PaintOptics,
        classes: &Classes,
        transfer: &PaintTransfer,
    ) -> Result<SolvedBands> {
        let mut solved = BTreeMap::new();
        let mut known = BTreeSet::new();
        match self {
            Self::All => add(0..BANDS, classes, transfer, &mut known, &mut solved)?,
            Self::Adaptive { tolerance } => {
                let bends = Inputs::new(optics).bends(tolerance);
                let start = (0..BANDS).step_by(STRIDE).chain([BANDS - 1]).chain(bends);
                add(start, classes, transfer, &mut known, &mut solved)?;
                let ends: Vec<usize> = known.iter().copied().collect();
                let mut open: Vec<(usize, usize)> = ends.windows(2).map(|pair| (pair[0], pair[1])).collect();
                loop {
                    open.retain(|(a, b)| b - a > 1);
                    if open.is_empty() {
                        break;
                    }
                    let middles = open.iter().map(|(a, b)| (a + b) / 2);
                    add(middles, classes, transfer, &mut known, &mut solved)?;
                    let halves = |(a, b): (usize, usize)| {
                        let middle = (a + b) / 2;
                        let weight = (middle - a) as f64 / (b - a) as f64;
                        let [x, y, z] = [a, middle, b].map(|k| &solved[&classes.of[k]]);
                        if y.difference(x, z, weight) <= tolerance {
                            vec![]
                        } else {
                            vec![(a, middle), (middle, b)]
                        }
                    };
                    open = open.into_iter().flat_map(halves).collect();
                }
            }
        }
        let number: BTreeMap<usize, usize> =
            solved.keys().enumerate().map(|(n, class)| (*class, n)).collect();
        let of = |band: usize| number[&classes.of[band]];
        let shares = (0..BANDS).map(|band| {
            let below = known.range(..=band).next_back().copied().unwrap_or(band);
            let above = known.range(band..).next().copied().unwrap_or(band);
            if below == above {
                return vec![(of(band), 1.0)];
            }
            let weight = (band - below) as f64 / (above - below) as f64;
            vec![(of(below), 1.0 - weight), (of(above), weight)]
        });
        let shares = shares.collect();
        Ok(SolvedBands { shares, solutions: solved.into_values().collect() })
    }
}

/// Solves bands that are not known yet.
fn add(
    bands: impl Iterator<Item = usize>,
    classes: &Classes,
    transfer: &PaintTransfer,
    known: &mut BTreeSet<usize>,
    solved: &mut BTreeMap<usize, BandSolution>,
) -> Result<()> {
    let bands: BTreeSet<usize> = bands.collect();
    let wanted: BTreeSet<usize> =
        bands.iter().map(|band| classes.of[*band]).filter(|class| !solved.contains_key(class)).collect();
    let wanted: Vec<usize> = wanted.into_iter().collect();
    let new = wanted.par_iter().try_map(|class| transfer.solve(*class))?;
    solved.extend(wanted.into_iter().zip(new));
    known.extend(bands);
    Ok(())
}

/// All that depends on the wavelength.
struct Inputs<'a> {
    spectra: Vec<&'a Spectrum>,
    /// There are flakes or spheres whose interference is no spectrum alone.
    interference: bool,
}

impl<'a> Inputs<'a> {
    fn new(optics: &'a PaintOptics) -> Self {
        let mut spectra = vec![&optics.albedo];
        let mut interference = false;
        for film in &optics.films {
            spectra.push(&film.absorption);
            for kind in film.kinds.iter().filter(|kind| kind.area_density > 0.0) {
                match &kind.optics {
                    FlakeOptics::Mirror(mirror) => {
                        spectra.extend([&mirror.reflectance, &mirror.transmittance])
                    }
                    FlakeOptics::Stack { .. } => interference = true,
                }
            }
            for pigment in &film.pigments {
                spectra.extend([&pigment.scattering, &pigment.extinction]);
                match &pigment.phase {
                    Phase::Rayleigh => {}
                    Phase::HenyeyGreenstein(g) | Phase::Similar(g) => spectra.push(g),
                    Phase::Mie(_) => interference = true,
                }
            }
        }
        Self { spectra, interference }
    }

    fn equal(&self, a: usize, b: usize) -> bool {
        a == b || (!self.interference && self.spectra.iter().all(|s| s.0[a] == s.0[b]))
    }

    /// Bands at which a spectrum bends by more than the tolerance of its greatest value.
    fn bends(&self, tolerance: f64) -> Vec<usize> {
        let bent = |s: &Spectrum, k: usize| {
            let greatest = s.0.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            (s.0[k - 1] - 2.0 * s.0[k] + s.0[k + 1]).abs() > tolerance * greatest
        };
        (1..BANDS - 1).filter(|k| self.spectra.iter().any(|s| bent(s, *k))).collect()
    }
}
