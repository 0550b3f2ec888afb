//! From a composition to a flake BTF: explicit flakes, the same in every slice.
//!
//! At a cell of the angle grid, with both outer polar angles equal (phi_d = 90 degrees), flake k adds to each texel it
//! covers
//! `share [1-r][1-r'] r_p(alpha) / (4 eta^2 cos(bar theta) cos(bar theta')) K(n_k, h) exp(-[tau(bar theta) + tau(bar theta')] z_k)`,
//! h the half vector inside the binder and K the flake's angular lobe. With area density `D<S>h`, normals from P and depths
//! uniform in [0, h] the expectation is Ershov 2001, eq. 36, with P convolved with K: the glitter of the smooth model. A
//! slice stores the texel minus that; the smooth BRDF stored beside the slices carries it (DESIGN: who carries the mean).
//!
//! No cell needs clipping: theta_h and theta_i stay below 90 degrees, so that both cosines are positive, and the model
//! diverges at grazing only without a surface (index 1), as 1/cos.

use super::composition::Composition;
use super::fast_model::{FastModel, KindModel};
use super::flakes::Flakes;
use super::geometry::Geometry;
use super::orientation::FlakeLobe;
use super::phi_d::phi_d_error;
use super::piecewise::Piecewise;
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::btf::{AngleGrid, FlakeBtf, FlakeSlice};
use crate::color::{Spectrum, luminance};
use crate::error::{Error, Result};
use crate::math::half_difference::directions;
use crate::math::quadrature::breaks;
use glam::DVec3;
use rayon::prelude::*;
use serde_json::json;
use std::f64::consts::FRAC_PI_2;

/// Polar and azimuthal cells of the smooth table: those of the measured tables in circulation.
const SMOOTH_RESOLUTION: [usize; 2] = [45, 90];
/// Angle bins per 90 degrees that users get without asking: steps of 3.75 degrees, half a flake's lifetime (Golla & Klein 2018
/// name 24 to 30 samples).
pub const DEFAULT_BINS: usize = 24;
/// Width of the mean flake, in texels, where the texel size is not given: resolved, and few texels wasted on it.
const FLAKE_TEXELS: f64 = 1.5;
/// Effective number of flakes above which the mean of a slice is tested: below, its distribution is far from normal.
const TESTED_FLAKES: f64 = 20.0;

/// What to synthesize.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthesisOptions {
    /// Which (theta_h, theta_i), outer angles, get a slice.
    pub grid: AngleGrid,
    /// Columns and rows of a slice, each 1 to 4096.
    pub size: [usize; 2],
    /// Side of a texel, millimetres; by default the mean flake is 1.5 texels wide.
    pub texel_mm: Option<f64>,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl SynthesisOptions {
    /// The grid with slices of 128 x 128, default texels, seed 1.
    pub fn new(grid: AngleGrid) -> Self {
        Self { grid, size: [128, 128], texel_mm: None, seed: 1 }
    }
}

/// Synthesizes the flake BTF of a composition. `tick` is called once a slice.
///
/// The same options give the same bits for any number of threads.
///
/// # Errors
/// As [`Composition::validate`]; flakes without a lobe (`flake_lifetime_deg = 0`), which no texture resolves; more texels
/// than [`FlakeBtf::MAX_TEXELS`]; a texel size that is not positive, or missing while there are no flakes; more than
/// [`Flakes::MAX`] flakes of all kinds together, or too wide ones for the texture ([`Flakes::draw`]).
pub fn synthesize(
    composition: &Composition,
    options: &SynthesisOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<FlakeBtf> {
    let model = FastModel::new(composition)?;
    let texel_mm = texel_size(composition, options)?;
    let kinds = draw_kinds(composition, &model, options, texel_mm)?;
    let slices = (0..options.grid.len())
        .into_par_iter()
        .map(|k| {
            let slice = synthesize_slice(&model, &kinds, options.grid.angles(k), options.size);
            tick();
            slice
        })
        .collect::<Result<Vec<(FlakeSlice, SliceCheck)>>>()?;
    let (slices, checks): (Vec<_>, Vec<_>) = slices.into_iter().unzip();
    let [theta, phi] = SMOOTH_RESOLUTION;
    Ok(FlakeBtf {
        grid: options.grid.clone(),
        size: options.size,
        texel_mm,
        slices,
        smooth: TabulatedBrdf::from_fn(theta, phi, |wi, wo| model.brdf_rgb(wi, wo))?,
        coat: ClearCoat::ideal(model.index(), false),
        provenance: provenance(composition, options, &model, &kinds, &checks),
    })
}

/// Flakes of one kind, with what a slice asks of them.
struct DrawnKind {
    flakes: Flakes,
    lobe: FlakeLobe,
}

fn texel_size(composition: &Composition, options: &SynthesisOptions) -> Result<f64> {
    let texels = options.grid.len().saturating_mul(options.size[0]).saturating_mul(options.size[1]);
    if options.size.iter().any(|n| !(1..=FlakeBtf::MAX_SIDE).contains(n)) || texels > FlakeBtf::MAX_TEXELS {
        let found = format!("{} slices of {} x {}", options.grid.len(), options.size[0], options.size[1]);
        let legal = format!("sides of 1 to {}, {} texels in all", FlakeBtf::MAX_SIDE, FlakeBtf::MAX_TEXELS);
        return Err(Error::invalid("synthesis", "size", found, legal));
    }
    let kinds = &composition.film.flakes;
    let area = composition.area_density();
    let mean_um = kinds.iter().map(|kind| kind.area_density * kind.diameter_um).sum::<f64>() / area;
    let texel_mm = options.texel_mm.unwrap_or(mean_um * 1e-3 / FLAKE_TEXELS);
    if texel_mm > 0.0 && texel_mm.is_finite() {
        return Ok(texel_mm);
    }
    let found = options.texel_mm.map_or("none given".into(), |mm| mm.to_string());
    Err(Error::invalid(
        "synthesis",
        "texel size, mm",
        found,
        "a positive number, which only flakes make optional",
    ))
}

fn draw_kinds(
    composition: &Composition,
    model: &FastModel,
    options: &SynthesisOptions,
    texel_mm: f64,
) -> Result<Vec<DrawnKind>> {
    let texel_um = texel_mm * 1e3;
    let kinds = &composition.film.flakes;
    Flakes::check_number(kinds.iter().map(|kind| Flakes::expected(kind, options.size, texel_um)).sum())?;
    (0u32..)
        .zip(kinds.iter().zip(model.kinds()))
        .map(|(k, (kind, KindModel { orientation, lobe, .. }))| {
            let lobe = lobe.ok_or_else(|| {
                let place = format!("film.flakes[{k}]");
                Error::invalid(
                    place,
                    "flake_lifetime_deg",
                    kind.flake_lifetime_deg,
                    "0.1 to 90 to draw flakes",
                )
            })?;
            Ok(DrawnKind {
                flakes: Flakes::draw(kind, orientation, options.size, texel_um, options.seed, k)?,
                lobe,
            })
        })
        .collect()
}

/// Luminance of a slice's flakes against the model.
struct SliceCheck {
    /// Mean over texels minus expectation, in standard errors.
    z: f64,
    /// (sum of contributions)^2 over sum of squares: how many flakes make the mean.
    effective_flakes: f64,
}

fn synthesize_slice(
    model: &FastModel,
    kinds: &[DrawnKind],
    (theta_h, theta_i): (f64, f64),
    size: [usize; 2],
) -> Result<(FlakeSlice, SliceCheck)> {
    let count = size[0] * size[1];
    let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
    let Some(g) = Geometry::new(wi, wo, model.index()) else {
        // Only by rounding, at 90 degrees: nothing is seen.
        let slice = FlakeSlice { fluctuation: vec![[0.0; 3]; count], expectation: [0.0; 3] };
        return Ok((slice, SliceCheck { z: 0.0, effective_flakes: 0.0 }));
    };
    let mut texels = vec![DVec3::ZERO; count];
    // A compound Poisson sum: the sum of squares estimates its variance without bias.
    let (mut sum, mut squares) = (0.0, 0.0);
    for (k, kind) in kinds.iter().enumerate() {
        let by_depth = color_by_depth(model, k, &g)?;
        let cutoff = kind.lobe.cutoff();
        for (flake, cover) in kind.flakes.iter() {
            if flake.normal.dot(g.half).abs() < cutoff {
                continue;
            }
            let color = DVec3::from(by_depth.eval(flake.depth)) * kind.lobe.density(flake.normal, g.half);
            for (texel, share) in cover {
                texels[*texel as usize] += color * f64::from(*share);
            }
            let light = luminance(color) * flake.area / count as f64;
            sum += light;
            squares += light * light;
        }
    }
    let glitter = model.glitter(&g).linear_rgb();
    let slice = FlakeSlice {
        fluctuation: texels.iter().map(|t| (*t - glitter).as_vec3().to_array()).collect(),
        expectation: (glitter + model.shade(&g).linear_rgb()).to_array(),
    };
    let effective_flakes = if squares > 0.0 { sum * sum / squares } else { 0.0 };
    Ok((slice, SliceCheck { z: (sum - luminance(glitter)) / squares.sqrt(), effective_flakes }))
}

/// Color of a flake of kind `k`, before its lobe, over its depth as a share of the film's thickness.
fn color_by_depth(model: &FastModel, k: usize, g: &Geometry) -> Result<Piecewise<3>> {
    let reflectance = model.kinds()[k].optics.reflectance(g.cos_alpha);
    let thickness = model.optical_thickness(g).0;
    let factor = model.surface_factor(g);
    // A deep pigment takes all light within 1e-6 of the film: panels that double from one absorption length on follow it.
    let steepest = thickness.iter().copied().fold(1.0, f64::max);
    let all = breaks(0.0, 1.0, (0..1000).map(|k| f64::from(k).exp2() / steepest).take_while(|z| *z < 1.0));
    // Below the rounding of an f32 texel.
    Piecewise::fit("color of a flake over its depth", &all, 1e-8, |z| {
        let at = |band: usize| factor * reflectance[band] * (-thickness[band] * z).exp();
        Spectrum(std::array::from_fn(at)).linear_rgb().to_array()
    })
}

fn provenance(
    composition: &Composition,
    options: &SynthesisOptions,
    model: &FastModel,
    kinds: &[DrawnKind],
    checks: &[SliceCheck],
) -> serde_json::Value {
    let tested: Vec<f64> =
        checks.iter().filter(|c| c.effective_flakes >= TESTED_FLAKES).map(|c| c.z).collect();
    let rms = (tested.iter().map(|z| z * z).sum::<f64>() / tested.len() as f64).sqrt();
    json!({
        "tool": "carpaint simulate",
        "version": env!("CARGO_PKG_VERSION"),
        "model": "fast",
        "seed": options.seed,
        "composition": composition,
        "flakes": kinds.iter().map(|kind| kind.flakes.flakes.len()).collect::<Vec<_>>(),
        "check": {
            "what": "luminance of the slice means against the model, in standard errors",
            "slices": tested.len(),
            "rms_z": rms.is_finite().then_some(rms),
            "max_abs_z": tested.iter().fold(0.0f64, |m, z| m.max(z.abs())),
            "phi_d": phi_d_error(model, &options.grid),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_pigment_is_followed_into_the_film() {
        for (kappa, thickness) in
            [("0", 0), ("30", 15), ("1e6", 1000), ("[[380, 0], [500, 1e6], [780, 10]]", 1000)]
        {
            let paint = Composition::parse(&format!(
                "substrate = {{ albedo = 0.5 }}\n[film]\nthickness_um = {thickness}\nindex = 1.5\n\
                 absorption_per_mm = {kappa}\n[[film.flakes]]\narea_density = 0.5\ndiameter_um = 20\nsigma_deg = 6\n\
                 mirror = {{ reflectance = 0.7 }}\n"
            ))
            .unwrap();
            let model = FastModel::new(&paint).unwrap();
            let (wi, wo) = directions(0.1, 1.5, FRAC_PI_2);
            let g = Geometry::new(wi, wo, 1.5).unwrap();
            let table = color_by_depth(&model, 0, &g).unwrap();
            let exact = |z: f64| {
                let at = |x: f64| model.surface_factor(&g) * 0.7 * (-x * z).exp();
                Spectrum(model.optical_thickness(&g).0.map(at)).linear_rgb()
            };
            let peak = exact(0.0).max_element();
            for k in 0..2000 {
                let z = (f64::from(k) / 1999.0).powi(4);
                let error = (DVec3::from(table.eval(z)) - exact(z)).abs().max_element();
                // Ten times the tolerance of the three points tested while tabulating.
                assert!(error < 1e-7 * peak, "{kappa} {z}: {error:e}");
            }
        }
    }
}
