//! A flake BTF with a smooth part as an AxF-like folder.

use super::{AxfProperties, AxfSmooth, ColorSpace, properties};
use crate::btf::FlakeSource;
use crate::error::{Error, Result};
use crate::file::{write_picture_exr, write_text};
use crate::math::half_difference::directions;
use crate::parallel::TryMap;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// Entries of the slice table in AxF files.
const LUT: usize = 64;

/// Writes a BTF into an existing folder, slices as the signed residual upon `smooth` under its coat, without the cosine; `axf.json`
/// comes last. [`super::AxfFolder`] reads it.
///
/// # Errors
/// A refracting coat or a gloss lobe (not supported); more than 63 rows of slices; those of the source and the file system.
pub fn write_axf_folder(btf: &dyn FlakeSource, smooth: &AxfSmooth, folder: &Path) -> Result<()> {
    if smooth.coat.refracts || smooth.coat.gloss.is_some() {
        let found = if smooth.coat.refracts { "refracting" } else { "a gloss lobe" };
        return Err(Error::unsupported(
            "AxF folder",
            "coat",
            found,
            "one that neither refracts nor has a gloss lobe",
        ));
    }
    let rows = btf.grid().rows();
    if rows.len() >= LUT {
        return Err(Error::invalid("AxF folder", "rows (theta_i)", rows.len(), "up to 63"));
    }
    let name = |k: usize| format!("BTFflakes_{k:04}.exr");
    let slice = |k: usize| write_picture_exr(&folder.join(name(k)), btf.size(), &residual(btf, smooth, k)?);
    (0..btf.grid().len()).into_par_iter().try_map(slice)?;
    let colors = "BRDFcolors.exr";
    write_picture_exr(&folder.join(colors), smooth.colors.size(), smooth.colors.texels())?;
    let mut lut: Vec<usize> =
        [0].into_iter().chain(rows.iter().scan(0, |sum, n| Some(step(sum, *n)))).collect();
    lut.resize(LUT, 0);
    let of = |value: fn(&crate::brdf::Lobe) -> f64| smooth.lobes.iter().map(value).collect();
    let properties = AxfProperties {
        num_thetaF: btf.grid().bins(),
        num_thetaI: btf.grid().bins(),
        max_thetaI: rows.len(),
        thetaFI_sliceLUT: lut,
        CT_coeffs: of(|lobe| lobe.coefficient),
        CT_F0s: of(|lobe| lobe.f0),
        CT_spreads: of(|lobe| lobe.roughness),
        CT_diffuse: smooth.diffuse,
        IOR: smooth.coat.ior,
        cc_no_refraction: 1,
        BRDFcolors: colors.to_owned(),
        BTFflakes: (0..btf.grid().len()).map(name).collect(),
        size_mm: btf.size().map(|n| n as f64 * btf.texel_mm()),
        cosine_included: false,
        bin_offset: 0.0,
        color_space: ColorSpace::Srgb,
    };
    let path = folder.join(properties::NAME);
    let text = serde_json::to_string_pretty(&properties);
    write_text(&path, &text.map_err(|e| Error::invalid(path.display().to_string(), "properties", e, "JSON"))?)
}

fn step(sum: &mut usize, n: usize) -> usize {
    *sum += n;
    *sum
}

/// Texels of slice `k` less the smooth part, under the coat.
fn residual(btf: &dyn FlakeSource, smooth: &AxfSmooth, k: usize) -> Result<Vec<[f32; 3]>> {
    let (theta_h, theta_i) = btf.grid().angles(k);
    let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
    let transmittance = smooth.coat.transmittance(wi.z, wo.z);
    let slice = btf.slice(k)?;
    let rest = DVec3::from(slice.expectation) / transmittance - smooth.base(wi, wo);
    let texel = |t: &[f32; 3]| (DVec3::from(t.map(f64::from)) / transmittance + rest).as_vec3().to_array();
    Ok(slice.fluctuation.iter().map(texel).collect())
}
