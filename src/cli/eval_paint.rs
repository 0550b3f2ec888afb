//! `carpaint eval fast` and `carpaint eval sparkle`: two-layer paints of gray mirror flakes, given by numbers.

use super::eval::number;
use crate::color::Spectrum;
use crate::error::{Error, Result};
use crate::math::half_difference::spherical;
use crate::simulate::composition::Composition;
use crate::simulate::models::fast_model::FastModel;
use crate::simulate::models::substrate_return::mean_inner_reflectance;
use crate::simulate::optics::film_optics::PaintOptics;
use crate::simulate::optics::geometry::Geometry;
use crate::simulate::optics::orientation::Orientation;
use crate::simulate::optics::parallel_flakes::{ParallelFlakes, ParallelKind};
use crate::simulate::sparkle::brute_force::BruteForce;
use crate::simulate::sparkle::{Masking, SparkleGeometry, SparkleView};
use crate::simulate::{Accuracy, FullModel};
use glam::DVec3;
use serde_json::{Map, Value, json};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Normals drawn for a sparkle probability: a standard error of 0.15 %.
const SAMPLES: u32 = 1 << 20;
/// Greatest polar angle, degrees: below the horizon, where cosines of both directions divide.
const FLATTEST: f64 = 89.999;

/// A number of a row, 0 where it is missing.
fn number_or_zero(row: &Value, key: &str, legal: RangeInclusive<f64>) -> Result<f64> {
    if row.get(key).is_some() { number(row, key, legal) } else { Ok(0.0) }
}

/// Directions of light and eye; the azimuth is that of travel, 0 on the mirror side.
fn directions(row: &Value) -> Result<(DVec3, DVec3)> {
    let theta = |key| number(row, key, 0.0..=FLATTEST).map(f64::to_radians);
    let phi = number(row, "phi_deg", -360.0..=360.0)?.to_radians();
    Ok((spherical(theta("theta_i_deg")?, 0.0), spherical(theta("theta_o_deg")?, PI - phi)))
}

fn geometry(row: &Value, index: f64) -> Result<Geometry> {
    let (wi, wo) = directions(row)?;
    let found = || Error::invalid("", "directions", "below the horizon", "above it");
    Geometry::new(wi, wo, index).ok_or_else(found)
}

/// Gray mirror flakes over a gray substrate.
struct GrayPaint {
    sigma_deg: f64,
    area_density: f64,
    diameter_um: f64,
    reflectance: f64,
    transmittance: f64,
    thickness_um: f64,
    /// kappa h.
    absorption: f64,
    index: f64,
    albedo: f64,
}

impl GrayPaint {
    fn composition(&self) -> Result<Composition> {
        let per_mm = if self.thickness_um > 0.0 { 1e3 * self.absorption / self.thickness_um } else { 0.0 };
        Composition::parse(&format!(
            "[substrate]\nalbedo = {}\n[[film]]\nthickness_um = {}\nindex = {}\nabsorption_per_mm = {per_mm}\n\
             [[film.flakes]]\narea_density = {}\ndiameter_um = {}\ndiameter_spread = 0\nsigma_deg = {}\n\
             flake_lifetime_deg = 0\nmirror = {{ reflectance = {}, transmittance = {} }}\n",
            self.albedo,
            self.thickness_um,
            self.index,
            self.area_density,
            self.diameter_um,
            self.sigma_deg,
            self.reflectance,
            self.transmittance
        ))
    }
}

/// Ershov 2001 for a set of parameters: params {sigma_deg, DSh, rp, tp, eta, rs, and kh if the binder absorbs}, points; beside
/// the fast model (AD_ columns) the full solution.
pub(super) fn fast(row: &Value) -> Result<Value> {
    let params = row.get("params").unwrap_or(&Value::Null);
    let p = |key, legal| number(params, key, legal).map_err(|e| e.within("params"));
    let paint = GrayPaint {
        sigma_deg: p("sigma_deg", 0.1..=89.9)?,
        area_density: p("DSh", 0.0..=10.0)?,
        diameter_um: 20.0,
        reflectance: p("rp", 0.0..=1.0)?,
        transmittance: p("tp", 0.0..=1.0)?,
        thickness_um: 10.0,
        absorption: number_or_zero(params, "kh", 0.0..=1e4).map_err(|e| e.within("params"))?,
        index: p("eta", 1.0..=4.0)?,
        albedo: p("rs", 0.0..=1.0)?,
    };
    let points = match row.get("points") {
        None => &[][..],
        Some(Value::Array(points)) => points,
        Some(other) => return Err(Error::invalid("points", "field", other, "a list")),
    };
    let model = FastModel::new(&paint.composition()?)?;
    let solved = Solved::new(&paint)?;
    let kind = ParallelKind {
        orientation: model.kinds()[0].orientation.clone(),
        area_density: paint.area_density,
        reflectance: paint.reflectance,
        transmittance: paint.transmittance,
    };
    let parallel = ParallelFlakes { kinds: vec![kind], index: paint.index, albedo: paint.albedo };
    let optical_thickness = |degrees: f64| {
        let theta = degrees.to_radians();
        model.film().extinction(theta)[0] / theta.cos()
    };
    let by_angle: Map<String, Value> = [0, 20, 40, 60, 80]
        .map(|d| (d.to_string(), json!(optical_thickness(f64::from(d)))))
        .into_iter()
        .collect();
    let points = points.iter().enumerate().map(|(k, point)| {
        fast_point(point, &model, &parallel, &solved).map_err(|e| e.within(format!("points {k}")))
    });
    Ok(json!({
        "params": params,
        "P_norm_C": model.kinds()[0].orientation.density(0.0),
        "F_eta": mean_inner_reflectance(paint.index),
        "tau_h_normal": optical_thickness(0.0),
        "tau_h_by_inbinder_angle": by_angle,
        "tau_h_const_29": parallel.optical_thickness(),
        "twoQ_numeric": model.two_q().0[0],
        "rs_eff_const_30": parallel.effective_albedo(),
        "rs_eff_32": parallel.effective_albedo_as_printed(),
        "AD_total_reflectance_incl_gloss": solved.reflectances(),
        "points": points.collect::<Result<Vec<_>>>()?,
    }))
}

/// The full solution of the same paint, and of it on black.
struct Solved {
    paint: FullModel,
    on_black: FullModel,
}

impl Solved {
    /// Error asked of the full solutions.
    const ERROR: f64 = 1e-5;
    /// Incidences of the reflectances, degrees.
    const INCIDENCES: [u32; 6] = [0, 15, 30, 45, 60, 75];

    fn new(paint: &GrayPaint) -> Result<Self> {
        let mut optics = PaintOptics::new(&paint.composition()?)?;
        let accuracy = Accuracy { error: Self::ERROR };
        let full = FullModel::new(&optics, &accuracy)?;
        if paint.albedo == 0.0 {
            return Ok(Self { on_black: full.clone(), paint: full });
        }
        optics.albedo = Spectrum::constant(0.0);
        Ok(Self { paint: full, on_black: FullModel::new(&optics, &accuracy)? })
    }

    /// Hemispherical reflectance with gloss, by incidence in degrees.
    fn reflectances(&self) -> Map<String, Value> {
        let at = |degrees: u32| {
            let energy = self.paint.energy(f64::from(degrees).to_radians());
            (degrees.to_string(), json!(energy.reflected.0[0] + energy.gloss))
        };
        Self::INCIDENCES.map(at).into_iter().collect()
    }
}

fn fast_point(point: &Value, model: &FastModel, parallel: &ParallelFlakes, solved: &Solved) -> Result<Value> {
    let g = geometry(point, model.index())?;
    let (wi, wo) = directions(point)?;
    Ok(json!({
        "theta_i_deg": point.get("theta_i_deg"),
        "theta_o_deg": point.get("theta_o_deg"),
        "phi_deg": point.get("phi_deg"),
        "glitter_36": model.glitter(&g).0[0],
        "glitter_33_general": parallel.glitter(&g),
        "glitter_33_printed_rp_plus_tp_1": parallel.glitter_as_printed(&g),
        "shade_28": model.shade(&g).0[0],
        "shade_30": parallel.shade(&g),
        "cos_alpha": g.cos_alpha,
        "beta_rad": g.beta,
        "AD_full_brdf_nongloss": solved.paint.brdf(wi, wo).0[0],
        "AD_black_substrate_brdf": solved.on_black.brdf(wi, wo).0[0],
    }))
}

/// What the printed text puts in place of `cos(theta') / cos(bar theta')` over it: the observer's cosines.
fn printed_over_corrected(g: &Geometry) -> f64 {
    g.cos_outside[1] * g.cos_inside[0] / (g.cos_outside[0] * g.cos_inside[1])
}

/// Sparkle probabilities (rows with Delta_deg) and statistics of a pixel (rows with D_per_cm3).
pub(super) fn sparkle(row: &Value) -> Result<Value> {
    let index = number(row, "eta", 1.0..=4.0)?;
    let g = geometry(row, index)?;
    let mut out = row.as_object().cloned().unwrap_or_default();
    let columns = if row.get("Delta_deg").is_some() {
        sparkle_probability(row, index, &g)?
    } else if row.get("D_per_cm3").is_some() {
        sparkle_statistics(row, index, &g)?
    } else {
        return Err(Error::invalid("", "row", "neither Delta_deg nor D_per_cm3", "one of the two"));
    };
    out.extend(columns.into_iter().map(|(key, value)| (key.to_owned(), json!(value))));
    Ok(Value::Object(out))
}

fn sparkle_probability(row: &Value, index: f64, g: &Geometry) -> Result<Vec<(&'static str, f64)>> {
    let orientation = Orientation::new(number(row, "sigma_deg", 0.1..=89.9)?.to_radians());
    let light_radius = number(row, "Delta_deg", 1e-6..=10.0)?.to_radians();
    let sparkle = SparkleGeometry { geometry: *g, index, transmission: g.transmission, light_radius };
    let source = orientation.density(g.beta) * sparkle.normals();
    let observer = source * printed_over_corrected(g);
    let (wi, wo) = directions(row)?;
    let (counted, error) = BruteForce::new(wi, wo, index, light_radius).probability(&orientation, SAMPLES, 1);
    Ok(vec![
        ("prob_mc", counted),
        ("prob_se", error),
        ("cos_alpha", g.cos_alpha),
        ("cos_beta", g.half.z),
        ("src_eta2", source),
        ("obs_eta2", observer),
        ("obs_eta1", observer * index),
    ])
}

fn sparkle_statistics(row: &Value, index: f64, g: &Geometry) -> Result<Vec<(&'static str, f64)>> {
    // From centimetres.
    let (um, um2) = (1e4, 1e8);
    let thickness = number(row, "H_cm", 1e-6..=0.1)?;
    let area = number(row, "S_cm2", 1e-12..=7e-3)?;
    let pixel_um2 = um2 * number(row, "pixel_area_cm2", 1e-12..=1e12)?;
    let paint = GrayPaint {
        sigma_deg: number(row, "sigma_deg", 0.1..=89.9)?,
        area_density: number(row, "D_per_cm3", 0.0..=1e15)? * area * thickness,
        diameter_um: um * 2.0 * (area / PI).sqrt(),
        reflectance: number(row, "rp", 0.0..=1.0)?,
        transmittance: number(row, "tp", 0.0..=1.0)?,
        thickness_um: um * thickness,
        absorption: number_or_zero(row, "kappa_per_cm", 0.0..=1e6)? * thickness,
        index,
        albedo: 0.0,
    };
    let light_radius = number(row, "Delta_rad", 1e-8..=0.2)?;
    let model = FastModel::new(&paint.composition()?)?;
    let kind = &model.kinds()[0];
    let sparkle = SparkleGeometry { geometry: *g, index, transmission: g.transmission, light_radius };
    let (wi, wo) = directions(row)?;
    let view = SparkleView::new(model.optics(), wi, wo, light_radius, Masking::Dimmed);
    let brightest = sparkle.luminance(paint.reflectance, kind.areas.mean_um2) / pixel_um2;
    let (count, mean, variance) =
        (view.mean_count(pixel_um2), view.mean().0[0], view.variance(pixel_um2).0[0]);
    let printed = printed_over_corrected(g);
    let tau =
        |side: usize| model.film().extinction(g.theta_inside[side])[0] / (g.cos_inside[side] * thickness);
    Ok(vec![
        ("P_beta", kind.orientation.density(g.beta)),
        ("cos_alpha", g.cos_alpha),
        ("tau_i_per_cm", tau(0)),
        ("tau_o_per_cm", tau(1)),
        ("mean_N_source_side", count),
        ("mean_N_as_printed_eta2", count * printed),
        ("sparkle_luminance_over_I_at_z0_source_side", brightest),
        ("sparkle_luminance_over_I_at_z0_as_printed", brightest / printed),
        ("mean_L_over_I", mean),
        ("mean_L_over_I_printed", mean),
        ("brdf_36", model.glitter(g).0[0]),
        ("var_L_over_I2_source_side", variance),
        ("var_L_over_I2_printed", variance / printed),
    ])
}
