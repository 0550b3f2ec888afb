//! AxF-like car paints as a folder: `axf.json` with the properties of an AxF car paint under their names in its SDK
//! ([`AxfProperties`]), and its textures as EXR files. Anyone with the SDK can write one; `.axf` itself is closed.
//!
//! The model, `(1 - F)(1 - F) [ chi(theta_F, theta_I) (CT_diffuse/pi + sum CT) + flakes / cos ]`, is this program's own, its lobes
//! included (see [`crate::brdf::cook_torrance`]); theta_F is its theta_h. Slices are a signed residual upon the smooth part, with or
//! without the cosine of the light under the coat.
//!
//! As a [`FlakeSource`] a folder gives what that promises: BRDF seen from outside the coat, at outer angles and a phi_d of 90
//! degrees, a slice being its fluctuation about its mean. Under a refracting coat, or with a bin offset, up to four stored slices
//! are mixed for that, bilinearly as the model has it, and what is not there is 0.

mod colors;
mod properties;
mod writer;

pub use colors::ColorSpace;
pub use properties::AxfProperties;
pub use writer::write_axf_folder;

use super::{AngleGrid, FlakeBtf, FlakeSlice, FlakeSource};
use crate::brdf::{ClearCoat, ColorTable, Lobe, TabulatedBrdf, base};
use crate::error::{Error, Result};
use crate::file::read_picture;
use crate::math::half_difference::{HalfDifference, directions};
use crate::parallel::TryMap;
use glam::DVec3;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};

/// The smooth part of an AxF-like paint.
#[derive(Debug, Clone, PartialEq)]
pub struct AxfSmooth {
    /// The clear coat; it mirrors.
    pub coat: ClearCoat,
    /// Diffuse albedo.
    pub diffuse: f64,
    /// Lobes, up to 4.
    pub lobes: Vec<Lobe>,
    /// The color table chi.
    pub colors: ColorTable,
}

impl AxfSmooth {
    /// BRDF under the coat for unit directions under the coat, linear Rec.709, 1/sr.
    fn base(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        base(&self.colors, self.diffuse, &self.lobes, wi, wo)
    }
}

/// An open folder: everything but the slices is read, and these come from their files when they are asked for.
pub struct AxfFolder {
    path: PathBuf,
    properties: AxfProperties,
    smooth: AxfSmooth,
    /// Of the slices in the folder.
    stored: AngleGrid,
    /// Their means.
    means: Vec<DVec3>,
    size: [usize; 2],
    texel_mm: f64,
    grid: AngleGrid,
    table: TabulatedBrdf,
    provenance: Value,
}

impl AxfFolder {
    /// Polar and azimuthal cells of the tabulated smooth part.
    const TABLE: [usize; 2] = [45, 90];

    /// Opens a folder, and reads its slices once, for their means.
    ///
    /// # Errors
    /// A file that is missing, damaged, or of another size than the others; properties that are unknown, missing, out of range or
    /// contradict each other; what is not supported: fewer bins of theta_I than of theta_F, texels that are not square.
    pub fn open(path: &Path) -> Result<Self> {
        let json = path.join(properties::NAME);
        let properties = AxfProperties::read(&json)?;
        let fault = |e: Error| e.in_file(&json);
        let stored = properties.grid().map_err(fault)?;
        let smooth = smooth(path, &properties)?;
        let (size, _) = read_picture(&path.join(&properties.BTFflakes[0]))?;
        let texel_mm = properties.texel_mm(size).map_err(fault)?;
        // Refraction brings outer angles of up to 90 degrees to inner ones within the rows that there are.
        let bins = stored.bins();
        let grid =
            if smooth.coat.refracts { AngleGrid::triangle(bins).map_err(fault)? } else { stored.clone() };
        FlakeBtf::check_size(&grid, size, texel_mm).map_err(fault)?;
        let provenance = json!({ "made": "axf folder", "properties": properties });
        let table = TabulatedBrdf::new(2, 2, vec![[0.0; 3]; 8])?;
        let path = path.to_owned();
        let mut folder = Self {
            path,
            properties,
            smooth,
            stored,
            means: Vec::new(),
            size,
            texel_mm,
            grid,
            table,
            provenance,
        };
        folder.means = (0..folder.stored.len()).into_par_iter().try_map(|k| folder.stored_mean(k))?;
        let [theta, phi] = Self::TABLE;
        folder.table =
            TabulatedBrdf::from_fn(theta, phi, |wi, wo| folder.expectation(wi, wo)).map_err(fault)?;
        Ok(folder)
    }

    /// Where the properties of a folder are.
    pub fn json_path(folder: &Path) -> PathBuf {
        folder.join(properties::NAME)
    }

    /// The smooth part, under the coat as the folder has it.
    pub fn smooth_part(&self) -> &AxfSmooth {
        &self.smooth
    }

    /// The properties.
    pub fn properties(&self) -> &AxfProperties {
        &self.properties
    }

    /// Texels of slice `k` of the folder, linear Rec.709.
    fn stored(&self, k: usize) -> Result<Vec<[f32; 3]>> {
        let path = self.path.join(&self.properties.BTFflakes[k]);
        let (size, mut texels) = read_picture(&path)?;
        if size != self.size {
            let legal = format!("{:?}, as the others", self.size);
            return Err(Error::invalid(path.display().to_string(), "size", format!("{size:?}"), legal));
        }
        self.properties.color_space.convert(&mut texels);
        Ok(texels)
    }

    fn stored_mean(&self, k: usize) -> Result<DVec3> {
        let texels = self.stored(k)?;
        Ok(mean(&texels))
    }

    /// For outer directions: the stored slices to be mixed, weighed to what is seen from outside.
    fn taps(&self, wi: DVec3, wo: DVec3) -> Vec<(usize, f64)> {
        let coat = &self.smooth.coat;
        let (inner_i, inner_o) = (coat.inner(wi), coat.inner(wo));
        let angles = HalfDifference::of(inner_i, inner_o);
        let cosine = if self.properties.cosine_included { inner_i.z } else { 1.0 };
        let seen = coat.transmittance(wi.z, wo.z) / cosine;
        let bin = |theta: f64| {
            // Angles that are those of a bin up to rounding are that bin's, alone.
            let position = theta / FRAC_PI_2 * self.stored.bins() as f64 + self.properties.bin_offset;
            let rounded = position.round();
            let position = if (position - rounded).abs() < 1e-9 { rounded } else { position };
            (position as usize, position.fract())
        };
        let ((h, part_h), (i, part_i)) = (bin(angles.theta_h), bin(angles.theta_i));
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().filter_map(|(dh, di)| {
            let part = |d: usize, part: f64| if d == 0 { 1.0 - part } else { part };
            Some((self.stored.slice(h + dh, i + di)?, seen * part(dh, part_h) * part(di, part_i)))
        });
        corners.filter(|(_, weight)| *weight != 0.0).collect()
    }

    /// Smooth part and mean of the flakes, seen from outside.
    fn expectation(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        let coat = &self.smooth.coat;
        let base = self.smooth.base(coat.inner(wi), coat.inner(wo)) * coat.transmittance(wi.z, wo.z);
        self.taps(wi, wo).into_iter().fold(base, |sum, (k, weight)| sum + self.means[k] * weight)
    }
}

impl FlakeSource for AxfFolder {
    fn grid(&self) -> &AngleGrid {
        &self.grid
    }
    fn size(&self) -> [usize; 2] {
        self.size
    }
    fn texel_mm(&self) -> f64 {
        self.texel_mm
    }
    fn smooth(&self) -> &TabulatedBrdf {
        &self.table
    }
    fn coat(&self) -> ClearCoat {
        // Angles are outer ones here.
        ClearCoat { refracts: false, ..self.smooth.coat }
    }
    fn provenance(&self) -> &Value {
        &self.provenance
    }
    fn slice(&self, k: usize) -> Result<Cow<'_, FlakeSlice>> {
        if k >= self.grid.len() {
            return Err(Error::invalid("slice", "number", k, format!("below {}", self.grid.len())));
        }
        let (theta_h, theta_i) = self.grid.angles(k);
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let mut sum = vec![DVec3::ZERO; self.size[0] * self.size[1]];
        for (stored, weight) in self.taps(wi, wo) {
            let mean = self.means[stored];
            let texels = self.stored(stored)?;
            sum.iter_mut()
                .zip(texels)
                .for_each(|(s, t)| *s += (DVec3::from(t.map(f64::from)) - mean) * weight);
        }
        let fluctuation = sum.into_iter().map(|s| s.as_vec3().to_array()).collect();
        let slice = FlakeSlice { fluctuation, expectation: self.expectation(wi, wo).to_array() };
        slice.validate(self.size).map_err(|e| e.within(format!("slice {k}")).in_file(&self.path))?;
        Ok(Cow::Owned(slice))
    }
}

fn mean(texels: &[[f32; 3]]) -> DVec3 {
    texels.iter().map(|t| DVec3::from(t.map(f64::from))).sum::<DVec3>() / texels.len() as f64
}

fn smooth(folder: &Path, properties: &AxfProperties) -> Result<AxfSmooth> {
    let path = folder.join(&properties.BRDFcolors);
    let (size, mut texels) = read_picture(&path)?;
    properties.color_space.convert(&mut texels);
    let colors = colors::table(size, texels).map_err(|e| e.in_file(&path))?;
    let AxfProperties { CT_coeffs, CT_F0s, CT_spreads, CT_diffuse, IOR, .. } = properties;
    let parameters = CT_coeffs.iter().zip(CT_spreads).zip(CT_F0s);
    let lobe = |((coefficient, roughness), f0): ((&f64, &f64), &f64)| Lobe {
        coefficient: *coefficient,
        roughness: *roughness,
        f0: *f0,
    };
    let lobes: Vec<Lobe> = parameters.map(lobe).collect();
    let coat = ClearCoat::ideal(*IOR, properties.cc_no_refraction == 0 && *IOR > 1.0);
    let check = || {
        coat.validate()?;
        if !(-1e6..=1e6).contains(CT_diffuse) {
            return Err(Error::invalid("", "CT_diffuse", CT_diffuse, "-1e6 to 1e6"));
        }
        lobes
            .iter()
            .enumerate()
            .try_for_each(|(k, lobe)| lobe.validate().map_err(|e| e.within(format!("lobe {k}"))))
    };
    check().map_err(|e| e.in_file(&folder.join(properties::NAME)))?;
    Ok(AxfSmooth { coat, diffuse: *CT_diffuse, lobes, colors })
}
