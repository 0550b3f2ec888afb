//! From a composition to a paint: at once by the fast model, then whole, flakes included.

use super::job::Progress;
use crate::brdf::{ClearCoat, ColorTable};
use crate::btf::AngleGrid;
use crate::error::{Error, Result};
use crate::fit::{FitOptions, FlakeOptions, SliceMean, fit_flakes, fit_smooth};
use crate::math::half_difference::directions;
use crate::paint::Paint;
use crate::simulate::models::fast_model::FastModel;
use crate::simulate::{Composition, Model, ModelKind, ModelOptions, SynthesisOptions, synthesize};
use glam::DVec3;
use rayon::prelude::*;
use serde_json::json;
use std::f64::consts::{FRAC_PI_2, PI};

/// Sizes of a simulation that a designer waits for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Angle bins per 90 degrees.
    pub bins: usize,
    /// Columns and rows of a slice, texels.
    pub texels: usize,
    /// Side of a texel, millimetres; none: a mean flake is 1.5 texels wide.
    pub texel_mm: Option<f64>,
}

impl Sizes {
    /// Some seconds on two cores.
    pub const QUICK: Self = Self { bins: 12, texels: 64, texel_mm: None };
}

/// Columns (theta_h) and rows (theta_i) of the table that stands for the smooth part at first: 1.4 degrees, a third of the
/// narrowest lobes of practice.
const PREVIEW_SIDE: usize = 64;
/// Largest angle of that table: at 90 degrees the coat lets nothing through, and what is under it is 0 over 0.
const STEEPEST: f64 = FRAC_PI_2 - 0.01;

/// The mean of a composition's paint without fitting anything: one model evaluation a texel of a color table over a white
/// diffuser, both polar angles equal as in a slice. Its cost does not depend on the scene. The published fast model where it
/// knows the composition, else the one with its terms put back ([`ModelKind::FastCorrected`]).
///
/// # Errors
/// Those of the models.
pub fn preview(composition: &Composition) -> Result<Paint> {
    match FastModel::new(composition) {
        Ok(fast) => {
            let roughness = fast.optics().roughness;
            let coat = match roughness {
                0.0 => ClearCoat::ideal(fast.index(), false),
                sigma => ClearCoat::rough(fast.index(), false, sigma),
            };
            tabulated(coat, "fast", |wi, wo| fast.brdf_rgb(wi, wo))
        }
        Err(Error::Unsupported(_)) => {
            let options = ModelOptions { kind: ModelKind::FastCorrected, ..ModelOptions::default() };
            let model = Model::new(composition, options)?;
            tabulated(model.coat(), "fast-corrected", |wi, wo| model.brdf_rgb(wi, wo))
        }
        Err(e) => Err(e),
    }
}

/// A paint that is a table of what is seen under its coat.
fn tabulated(coat: ClearCoat, model: &str, brdf: impl Fn(DVec3, DVec3) -> DVec3 + Sync) -> Result<Paint> {
    let angle = |k: usize| (FRAC_PI_2 * k as f64 / (PREVIEW_SIDE - 1) as f64).min(STEEPEST);
    let texel = |k: usize| {
        let (wi, wo) = directions(angle(k % PREVIEW_SIDE), angle(k / PREVIEW_SIDE), FRAC_PI_2);
        (brdf(wi, wo) / coat.transmittance(wi.z, wo.z)).as_vec3().to_array()
    };
    let texels: Vec<[f32; 3]> = (0..PREVIEW_SIDE * PREVIEW_SIDE).into_par_iter().map(texel).collect();
    let measured = vec![true; texels.len()];
    Ok(Paint {
        coat,
        // chi a / pi with a = pi.
        diffuse: PI,
        lobes: Vec::new(),
        colors: ColorTable::new([PREVIEW_SIDE; 2], texels, measured)?,
        flakes: None,
        provenance: json!({ "made": "preview", "model": model, "carpaint": env!("CARGO_PKG_VERSION") }),
    })
}

/// The whole chain: model, slices, fit, statistics.
///
/// # Errors
/// Those of the stages.
pub fn simulated(name: &str, composition: &Composition, sizes: Sizes, progress: &Progress) -> Result<Paint> {
    let model = {
        let _tick = progress.begin(&format!("{name}: solving"), 1);
        Model::new(composition, ModelOptions::default())?
    };
    let options = SynthesisOptions {
        size: [sizes.texels; 2],
        texel_mm: sizes.texel_mm,
        ..SynthesisOptions::new(AngleGrid::triangle(sizes.bins)?)
    };
    let btf = {
        let tick = progress.begin(&format!("{name}: simulating flakes"), options.grid.len());
        synthesize(&model, &options, &tick)?
    };
    let fit_options = FitOptions { coat: Some(btf.coat), filled: false, ..FitOptions::default() };
    let (smooth, report) = {
        let tick = progress.begin(&format!("{name}: fitting"), fit_options.ticks());
        fit_smooth(&btf.smooth, &fit_options, &tick)?
    };
    let tick = progress.begin(&format!("{name}: reducing slices"), btf.grid.len());
    let flakes = fit_flakes(&btf, &smooth, SliceMean::Residual, &FlakeOptions::default(), &tick)?;
    Ok(smooth.into_paint(Some(flakes), btf.provenance.clone(), &report))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{RenderPaint, shade};
    use crate::simulate::instrument::MULTI_ANGLE;

    /// The preview against its own model at the instruments' angles: what is left is the table's step and that it knows no
    /// azimuth of the difference.
    #[test]
    fn the_preview_is_its_model_up_to_the_table() {
        let composition =
            Composition::parse(include_str!("../../fixtures/compositions/silver_metallic.toml")).unwrap();
        let paint = RenderPaint::new(&preview(&composition).unwrap()).unwrap();
        let fast = FastModel::new(&composition).unwrap();
        for reading in MULTI_ANGLE {
            let (wi, wo) = reading.directions();
            let (table, model) =
                (shade(&paint, None, wi.as_vec3(), wo.as_vec3(), 0.0), fast.brdf_rgb(wi, wo));
            // Flakes tilted by 6 degrees in steps of 1.4; absorption along unequal paths at 110 degrees.
            let difference = (table.as_dvec3() - model).length() / model.length();
            assert!(difference < 0.1, "{reading:?}: {table} {model}");
        }
    }

    #[test]
    fn compositions_of_several_films_have_a_preview_too() {
        let composition =
            Composition::parse(include_str!("../../fixtures/compositions/three_layers.toml")).unwrap();
        preview(&composition).unwrap().validate().unwrap();
    }
}
