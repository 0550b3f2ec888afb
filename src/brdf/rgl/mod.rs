//! Reader of the RGL material database (`.bsdf`; Dupuy & Jakob 2018, An adaptive parameterization for efficient material
//! acquisition and rendering), isotropic materials, RGB and spectral.
//!
//! A measurement is a microfacet model times what that misses, stored where the model sends light:
//! `f = S(W(u_m)) D(u_m) / (4 sigma(u_i) cos theta_o)`. u is the square of polar angle and azimuth, `theta = u_x^2 pi/2`,
//! `phi = (2 u_y - 1) pi` (of the microfacet normal m: from the incident azimuth on); D (`ndf`) and sigma are bilinear, W is the
//! warp by the density `vndf` of visible normals, S (`rgb` or `spectra`) is bilinear on W's image; between angles of
//! incidence `vndf` and S are linear. `luminance` serves sampling alone, `valid` is not looked at. As Mitsuba 3 and pbrt-v4
//! understand the files, whose `measured` materials also give values times the cosine of theta_o where they do not divide by it.

mod tensor;
mod warp;

pub(super) use tensor::MAGIC;

use super::measurement::{Counts, Measurement};
use super::reciprocity::median_difference;
use super::sample_set::{Bands, BrdfSample, SampleSet};
use crate::error::{Error, Result};
use crate::math::half_difference::spherical;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;
use tensor::{Tensor, TensorFile};
use warp::{Density, Mixed, cell};

/// An isotropic material of the RGL database.
pub struct RglBrdf {
    bands: Bands,
    /// Angles of incidence, radians, ascending.
    theta_i: Vec<f64>,
    ndf: Tensor,
    sigma: Tensor,
    /// One an angle of incidence.
    vndf: Vec<Density>,
    /// S: angles of incidence x bands x rows x columns.
    values: Tensor,
    /// Whether S is to be multiplied by the microfacet model.
    has_jacobian: bool,
}

/// Reads an RGL file: a sample at every node of it. See [`RglBrdf::read`].
///
/// # Errors
/// As [`RglBrdf::read`]; no usable node.
pub fn read_rgl(path: &Path) -> Result<Measurement> {
    RglBrdf::read(path)?.measurement().map_err(|e| e.in_file(path))
}

impl RglBrdf {
    /// Most numbers in S; the files of RGL have up to two millions if they are isotropic.
    const MAX_VALUES: usize = 1 << 24;

    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, is no tensor file or is cut off; fields that are missing, of another type or shape, or hold
    /// numbers that are none or out of range; too many numbers; an anisotropic material (not supported).
    pub fn read(path: &Path) -> Result<Self> {
        TensorFile::open(path).and_then(|mut file| Self::of(&mut file)).map_err(|e| e.in_file(path))
    }

    fn of(file: &mut TensorFile) -> Result<Self> {
        let azimuths: usize = file.shape("phi_i")?.iter().product();
        if azimuths == 0 {
            return Err(Error::invalid("field phi_i", "incident azimuths", 0, "1"));
        }
        // Two are one, turned all the way round.
        if azimuths > 2 {
            return Err(Error::unsupported("", "incident azimuths", azimuths, "1 (an isotropic material)"));
        }
        let is_rgb = file.has("rgb");
        let name = if is_rgb { "rgb" } else { "spectra" };
        let numbers = file.shape(name)?.iter().fold(1usize, |n, side| n.saturating_mul(*side));
        if numbers > Self::MAX_VALUES {
            return Err(Error::invalid(format!("field {name}"), "numbers", numbers, "up to 16777216"));
        }
        let bands = if is_rgb {
            Bands::Rgb
        } else {
            let nm = file.f32("wavelengths")?.values.iter().map(|nm| f64::from(*nm)).collect();
            SampleSet::new(Bands::Wavelengths(nm))?.bands().clone()
        };
        let theta_i = angles(&file.f32("theta_i")?)?;
        let values = file.f32(name)?;
        check_shape(name, &values, &[azimuths, theta_i.len(), bands.len()])?;
        let vndf = file.f32("vndf")?;
        check_shape("vndf", &vndf, &[azimuths, theta_i.len()])?;
        check_range("vndf", &vndf)?;
        let (ndf, sigma) = (file.f32("ndf")?, file.f32("sigma")?);
        for (name, tensor) in [("ndf", &ndf), ("sigma", &sigma)] {
            check_shape(name, tensor, &[])?;
            check_range(name, tensor)?;
        }
        let size = [vndf.shape[3], vndf.shape[2]];
        let densities = vndf.values.chunks_exact(size[0] * size[1]).take(theta_i.len());
        let vndf = densities.map(|slice| Density::new(size, slice)).collect();
        let has_jacobian = file.u8("jacobian")?.first().is_some_and(|flag| *flag != 0);
        Ok(Self { bands, theta_i, ndf, sigma, vndf, values, has_jacobian })
    }

    /// What the values are.
    pub fn bands(&self) -> &Bands {
        &self.bands
    }

    /// BRDF for unit directions away from the surface, 1/sr, one value a band; 0 below the horizon. Beyond the first and last
    /// angle of incidence those serve.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Vec<f64> {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return vec![0.0; self.bands.len()];
        }
        let (slice, part) = self.bracket(polar(wi));
        let m = (wi + wo).normalize();
        let turn = azimuth(m) - azimuth(wi);
        let u_m = [(polar(m) / FRAC_PI_2).sqrt(), (turn / TAU + 0.5).rem_euclid(1.0)];
        let at = self.density(slice, part).warp(u_m);
        let factor = self.factor(wi, u_m, wo);
        let value = |slice: usize, band: usize| {
            let plane = slice * self.bands.len() + band;
            let [rows, columns] = [self.values.shape[3], self.values.shape[4]];
            bilinear(&self.values.values[plane * rows * columns..], [columns, rows], at)
        };
        let high = self.next(slice);
        (0..self.bands.len())
            .map(|band| factor * ((1.0 - part) * value(slice, band) + part * value(high, band)))
            .collect()
    }

    /// What S is multiplied by.
    fn factor(&self, wi: DVec3, u_m: [f64; 2], wo: DVec3) -> f64 {
        if !self.has_jacobian {
            return 1.0 / wo.z;
        }
        // Sigma of an isotropic material knows no azimuth: any will do.
        let u_i = [(polar(wi) / FRAC_PI_2).sqrt(), 0.5];
        let of = |tensor: &Tensor, u| bilinear(&tensor.values, [tensor.shape[1], tensor.shape[0]], u);
        of(&self.ndf, u_m) / (4.0 * of(&self.sigma, u_i) * wo.z)
    }

    /// The angle of incidence at or below, and the weight of the next.
    fn bracket(&self, theta: f64) -> (usize, f64) {
        let slice = self.theta_i.partition_point(|t| *t <= theta).saturating_sub(1);
        let (low, high) = (self.theta_i[slice], self.theta_i[self.next(slice)]);
        (slice, if high > low { ((theta - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 })
    }

    fn next(&self, slice: usize) -> usize {
        (slice + 1).min(self.theta_i.len() - 1)
    }

    fn density(&self, slice: usize, part: f64) -> Mixed<'_> {
        Mixed { low: &self.vndf[slice], high: &self.vndf[self.next(slice)], part }
    }

    /// A sample at every node of S, at every angle of incidence of the file: nothing is interpolated but the microfacet model.
    ///
    /// # Errors
    /// No usable node.
    pub fn measurement(&self) -> Result<Measurement> {
        let mut samples = SampleSet::new(self.bands.clone())?;
        let mut counts = Counts::default();
        let [rows, columns] = [self.values.shape[3], self.values.shape[4]];
        let mut values = vec![0.0; self.bands.len()];
        for slice in 0..self.theta_i.len() {
            for node in 0..rows * columns {
                counts.found += 1;
                let (sample, u_m) = self.node(slice, [node % columns, node / columns]);
                if sample.wi.z <= 0.0 || sample.wo.z <= 0.0 {
                    counts.below_horizon += 1;
                    continue;
                }
                let factor = self.factor(sample.wi, u_m, sample.wo);
                for (band, value) in values.iter_mut().enumerate() {
                    let plane = slice * self.bands.len() + band;
                    *value = factor * f64::from(self.values.values[plane * rows * columns + node]);
                }
                if values.iter().all(|v| v.is_finite()) {
                    samples.push(sample, &values)?;
                } else {
                    counts.invalid += 1;
                }
            }
        }
        let reciprocity = self.reciprocity(&samples);
        Measurement::new(samples, counts, reciprocity)
    }

    /// The directions of a node of S, weighed by the solid angles it stands for, and the place of its microfacet normal.
    fn node(&self, slice: usize, [x, y]: [usize; 2]) -> (BrdfSample, [f64; 2]) {
        let [rows, columns] = [self.values.shape[3], self.values.shape[4]];
        let warp = self.density(slice, 0.0);
        let position = |k: f64, n: usize| (k / (n - 1) as f64).clamp(0.0, 1.0);
        let (at_x, at_y) = (position(x as f64, columns), position(y as f64, rows));
        let u_m = warp.unwarp([at_x, at_y]);
        let normal = |u: f64| FRAC_PI_2 * u * u;
        let wi = spherical(self.theta_i[slice], 0.0);
        let m = spherical(normal(u_m[0]), (2.0 * u_m[1] - 1.0) * PI);
        let wo = (2.0 * wi.dot(m) * m - wi).normalize();
        // Half way to the neighbors; d(wo) = 4 (wi . m) d(m).
        let side = |step: f64| warp.unwarp([position(x as f64 + step, columns), at_y])[0];
        let turn = |step: f64| warp.unwarp([at_x, position(y as f64 + step, rows)])[1];
        let normals = (normal(side(-0.5)).cos() - normal(side(0.5)).cos()) * (turn(0.5) - turn(-0.5));
        let weight = (4.0 * wi.dot(m) * normals * self.zone(slice)).max(0.0);
        (BrdfSample::new(wi, wo, weight), u_m)
    }

    /// Share of the hemisphere that an angle of incidence stands for: half way to its neighbors.
    fn zone(&self, slice: usize) -> f64 {
        let half_way = |a: usize, b: usize| (0.5 * (self.theta_i[a] + self.theta_i[b])).cos();
        let upper = if slice == 0 { 1.0 } else { half_way(slice - 1, slice) };
        let lower = if slice + 1 == self.theta_i.len() { 0.0 } else { half_way(slice, slice + 1) };
        upper - lower
    }

    /// Over the samples whose angle of the eye is among the angles of incidence.
    fn reciprocity(&self, samples: &SampleSet) -> Option<f64> {
        let last = *self.theta_i.last()?;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let both_ways = samples.samples().iter().enumerate().filter(|(_, s)| polar(s.wo) <= last);
        median_difference(both_ways.map(|(k, s)| (mean(samples.values(k)), mean(&self.eval(s.wo, s.wi)))))
    }
}

fn polar(w: DVec3) -> f64 {
    w.truncate().length().atan2(w.z)
}

fn azimuth(w: DVec3) -> f64 {
    w.y.atan2(w.x)
}

/// Bilinear look-up among `[columns, rows]` nodes on the unit square.
fn bilinear(values: &[f32], [columns, rows]: [usize; 2], [x, y]: [f64; 2]) -> f64 {
    let ((column, s), (row, t)) = (cell(x, columns), cell(y, rows));
    let at = |row: usize, column: usize| f64::from(values[row * columns + column]);
    let across = |row: usize| (1.0 - s) * at(row, column) + s * at(row, column + 1);
    (1.0 - t) * across(row) + t * across(row + 1)
}

/// Angles of incidence.
fn angles(tensor: &Tensor) -> Result<Vec<f64>> {
    let angles: Vec<f64> = tensor.values.iter().map(|t| f64::from(*t)).collect();
    let is_inside = |t: &f64| (0.0..=FRAC_PI_2 + 1e-6).contains(t);
    if angles.is_empty() || !angles.iter().all(is_inside) || angles.windows(2).any(|pair| pair[0] >= pair[1])
    {
        let found = format!("{angles:?}");
        return Err(Error::invalid("field theta_i", "angles", found, "one or more of 0 to pi/2, ascending"));
    }
    Ok(angles)
}

/// A shape of these sides and then rows and columns, 2 or more of each.
fn check_shape(name: &str, tensor: &Tensor, leading: &[usize]) -> Result<()> {
    let (n, shape) = (leading.len(), &tensor.shape);
    if shape.len() == n + 2 && shape[..n] == *leading && shape[n..].iter().all(|side| *side >= 2) {
        return Ok(());
    }
    let legal = format!("{leading:?}, then rows and columns, 2 or more of each");
    Err(Error::invalid(format!("field {name}"), "shape", format!("{shape:?}"), legal))
}

/// Numbers of 0 or more, below 1e30: their sums are numbers, too.
fn check_range(name: &str, tensor: &Tensor) -> Result<()> {
    match tensor.values.iter().position(|v| !(0.0..1e30).contains(v)) {
        None => Ok(()),
        Some(k) => {
            let place = format!("field {name}: number {k}");
            Err(Error::invalid(place, "value", tensor.values[k], "0 to below 1e30"))
        }
    }
}
