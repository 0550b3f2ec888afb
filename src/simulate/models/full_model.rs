//! The full model: all orders of scattering by flakes and pigments between substrate and surface, by adding and doubling.
//!
//! What flakes scatter once is left to its formula ([`PaintOptics::glitter`], exact at every angle); the operators
//! ([`super::transfer`]) give the rest, which is smoother: on the nodes the once scattered light of the same discrete kernels
//! is subtracted, what remains is interpolated in the cosines outside and summed over azimuth modes, and what pigments
//! scatter once is added from its formula.

use super::accuracy::{Accuracy, Settings};
use super::bands::{Classes, SolvedBands};
use super::paint_transfer::PaintTransfer;
use super::transfer::interpolation::{ModeTable, barycentric_weights, cardinal};
use crate::brdf::fresnel::dielectric;
use crate::color::{BANDS, Spectrum};
use crate::error::Result;
use crate::simulate::optics::film_optics::{FilmOptics, FilmView, PaintOptics, mean_attenuation};
use glam::DVec3;

/// The full model of one paint.
#[derive(Debug, Clone)]
pub struct FullModel {
    optics: PaintOptics,
    settings: Settings,
    doublings: u32,
    bands: usize,
    rest: ModeTable,
    /// The same as linear Rec.709.
    rest_rgb: ModeTable,
    shares: Shares,
}

/// Where the light goes that enters the paint, on the nodes outside.
#[derive(Debug, Clone)]
struct Shares {
    cos: Vec<f64>,
    weights: Vec<f64>,
    /// Share of the incident light that enters, and what a node counts in diffuse light.
    entering: Vec<f64>,
    diffuse: Vec<f64>,
    /// For each node, of the light that enters: reflected, into the substrate, into each film.
    of: Vec<[Spectrum; 3]>,
}

/// Where light of a direction, or diffuse light, goes. Sums to 1 at each wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Energy {
    /// Reflected, without the gloss; with what boundaries between films mirror, which the BRDF leaves out like the gloss.
    pub reflected: Spectrum,
    /// The gloss: reflected by the surface itself.
    pub gloss: f64,
    /// Transmitted into the substrate and absorbed there.
    pub substrate: Spectrum,
    /// Absorbed in all films together.
    pub films: Spectrum,
}

impl FullModel {
    /// Solves a paint to an accuracy.
    ///
    /// # Errors
    /// An error target outside its range; layers that are too thick without absorption ([`super::transfer::doubling`]).
    pub fn new(optics: &PaintOptics, accuracy: &Accuracy) -> Result<Self> {
        Self::with_settings(optics, &Settings::choose(optics, accuracy)?)
    }

    /// Solves a paint with given nodes, modes and so on.
    ///
    /// # Errors
    /// As [`FullModel::new`].
    pub fn with_settings(optics: &PaintOptics, settings: &Settings) -> Result<Self> {
        let classes = Classes::new(optics);
        let transfer = PaintTransfer::new(optics, settings, &classes.first)?;
        let SolvedBands { solutions, shares: spread } = settings.bands.solve(optics, &classes, &transfer)?;
        let modes = solutions.iter().map(|s| s.rest.len()).max().unwrap_or(1);
        let cos = transfer.outside();
        let rest = ModeTable::new(cos.clone(), optics.top().index, modes, BANDS, |mode, i, j, band| {
            let shares = spread[band].iter();
            shares.map(|(k, w)| solutions[*k].rest.get(mode).map_or(0.0, |rest| w * rest[(i, j)])).sum()
        });
        let of = (0..cos.len()).map(|i| {
            [0, 1, 2].map(|part| {
                let value =
                    |band: usize| spread[band].iter().map(|(k, w)| w * solutions[*k].shares[i][part]).sum();
                Spectrum(std::array::from_fn(value))
            })
        });
        let index = optics.top().index;
        let shares = Shares {
            weights: barycentric_weights(&cos),
            entering: cos.iter().map(|c| 1.0 - dielectric(*c, index)).collect(),
            diffuse: transfer.diffuse(),
            of: of.collect(),
            cos,
        };
        let doublings = solutions.iter().map(|s| s.doublings).max().unwrap_or(0);
        let bands = solutions.len();
        let rest_rgb = rest.map(|row| {
            Spectrum(std::array::from_fn(|k| row.get(k).copied().unwrap_or(0.0))).linear_rgb().to_array()
        });
        let settings = settings.clone();
        Ok(Self { optics: optics.clone(), settings, doublings, bands, rest, rest_rgb, shares })
    }

    /// What was solved with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Most doublings of any film.
    pub fn doublings(&self) -> u32 {
        self.doublings
    }

    /// How many wavelengths were solved.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The paint.
    pub fn optics(&self) -> &PaintOptics {
        &self.optics
    }

    /// BRDF without gloss and without [`PaintOptics::glitter`], 1/sr, for unit directions outside; 0 unless both are above
    /// the horizon.
    pub fn rest(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return Spectrum::constant(0.0);
        }
        let mut sum = self.pigments_once(wi, wo);
        let rest = look_up(&self.rest, wi, wo);
        // Between nodes the interpolant may undershoot where almost nothing is scattered.
        sum.iter_mut().zip(rest).for_each(|(s, r)| *s = (*s + r).max(0.0));
        Spectrum(sum)
    }

    /// [`FullModel::rest`] as linear Rec.709, a dozen times faster.
    pub fn rest_rgb(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return DVec3::ZERO;
        }
        let mut rgb = look_up(&self.rest_rgb, wi, wo).into_iter();
        let rest = DVec3::from_array(std::array::from_fn(|_| rgb.next().unwrap_or(0.0)));
        let pigments = self.optics.films.iter().any(|film| !film.pigments.is_empty());
        if pigments { rest + Spectrum(self.pigments_once(wi, wo)).linear_rgb() } else { rest }
    }

    /// What pigments of all films scatter once.
    fn pigments_once(&self, wi: DVec3, wo: DVec3) -> [f64; BANDS] {
        let mut sum = [0.0; BANDS];
        self.optics.visit(wi, wo, |film, seen| add_pigments(film, seen, &mut sum));
        sum
    }

    /// BRDF without gloss, 1/sr.
    pub fn brdf(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        let (glitter, rest) = (self.optics.glitter(wi, wo), self.rest(wi, wo));
        Spectrum(std::array::from_fn(|k| glitter.0[k] + rest.0[k]))
    }

    /// Where light from polar angle `theta` (outside, radians, 0 to pi/2) goes.
    pub fn energy(&self, theta: f64) -> Energy {
        let cos = theta.cos().max(0.0);
        let shares = &self.shares;
        let gloss = dielectric(cos, self.optics.top().index);
        let counts = cardinal(&shares.cos, &shares.weights, cos);
        shares.energy(gloss, counts.iter().map(|c| c * (1.0 - gloss)))
    }

    /// Where diffuse (Lambertian) light goes.
    pub fn diffuse_energy(&self) -> Energy {
        let both = || self.shares.diffuse.iter().zip(&self.shares.entering);
        let entering: f64 = both().map(|(d, e)| d * e).sum();
        self.shares.energy(1.0 - entering, both().map(|(d, e)| d * e))
    }
}

impl Shares {
    /// The sum over nodes, each with what it counts.
    fn energy(&self, gloss: f64, counts: impl Iterator<Item = f64>) -> Energy {
        let mut sums = [[0.0; BANDS]; 3];
        for (count, parts) in counts.zip(&self.of) {
            for (sum, part) in sums.iter_mut().zip(parts) {
                sum.iter_mut().zip(&part.0).for_each(|(s, p)| *s += count * p);
            }
        }
        let [reflected, substrate, films] = sums.map(Spectrum);
        Energy { reflected, gloss, substrate, films }
    }
}

/// The BRDF of a table between two directions above the horizon.
fn look_up(table: &ModeTable, wi: DVec3, wo: DVec3) -> Vec<f64> {
    let (a, b) = (wi.truncate(), wo.truncate());
    let lengths = a.length() * b.length();
    // Directions of travel: the mirror side is at 0.
    let cos_phi = if lengths > 0.0 { (-a.dot(b) / lengths).clamp(-1.0, 1.0) } else { 1.0 };
    table.sum(&table.series([wi.z.min(1.0), wo.z.min(1.0)]), cos_phi)
}

/// Adds what a film's pigments scatter once: as eq. 36, with `4 D sigma_sc h g(cos Theta)` for `D<S>h r_p P`.
fn add_pigments(film: &FilmOptics, seen: &FilmView, sum: &mut [f64]) {
    if film.pigments.is_empty() {
        return;
    }
    let geometry = &seen.geometry;
    let thickness = film.optical_thickness(geometry);
    let factor = seen.transmission / (film.index.powi(2) * geometry.cos_inside[0] * geometry.cos_inside[1]);
    // Directions point away: the ray turns by pi less the angle between them, which is twice alpha.
    let cos_turn = 1.0 - 2.0 * geometry.cos_alpha * geometry.cos_alpha;
    for (k, s) in sum.iter_mut().enumerate() {
        let scattered: f64 =
            film.pigments.iter().map(|p| p.scattering.0[k] * p.phase.eval(cos_turn, k)).sum();
        *s += factor * (-seen.above[k]).exp() * scattered * mean_attenuation(thickness[k]);
    }
}
