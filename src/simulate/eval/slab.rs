//! `carpaint eval slab`: plane slabs of particles, from rows of reference numbers.
//!
//! Light that is not scattered, or once, is taken from its formulas (eqs 13 and 20 as corrected, through the layers above
//! and below); only the rest, which has no peak as sharp as the phase function, comes from the nodes.

use crate::brdf::fresnel::dielectric;
use crate::color::Spectrum;
use crate::error::{Error, Result};
use crate::parallel::TryMap;
use crate::simulate::models::transfer::film::{FilmTransfer, attenuation};
use crate::simulate::models::transfer::ground::lambertian;
use crate::simulate::models::transfer::kernel::{Extent, Kernel, SIDES, Side};
use crate::simulate::models::transfer::layer::Layer;
use crate::simulate::models::transfer::nodes::{Direction, Nodes};
use crate::simulate::models::transfer::operator::Operator;
use crate::simulate::models::transfer::phase_kernel::PhaseKernel;
use crate::simulate::optics::pigment::{Phase, PigmentOptics};
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::f64::consts::PI;

/// Fewest nodes a hemisphere.
const LEAST_NODES: usize = 40;
/// Nodes for a peak of the width 1 - |g|: n nodes take degrees below 2 n of the phase function, which fall like |g|^degree,
/// to exp(-12) at the end.
const NODES: f64 = 6.0;
/// Fewest azimuth modes, and the share of light scattered twice, which falls like |g|^(2 m), that ends them.
const LEAST_MODES: f64 = 16.0;
const NEGLIGIBLE: f64 = 1e-9;
/// Largest |g|: 120 nodes and 202 modes.
const LARGEST_G: f64 = 0.95;
/// Scattering thickness of the first layer.
const THINNESS: f64 = 1e-3;
/// Thickest slab, and thickest one where all but `LEAST_ABSORPTION` of the extinction is scattering: there rounding of the
/// energy grows with the thickness.
const THICKEST: f64 = 1e9;
const THICKEST_LOSSLESS: f64 = 1e6;
const LEAST_ABSORPTION: f64 = 1e-9;

/// One homogeneous slab: optical thickness, albedo of single scattering, phase function.
struct Medium {
    thickness: f64,
    pigment: PigmentOptics,
}

impl Medium {
    fn new(albedo: f64, thickness: f64, phase: Phase) -> Result<Self> {
        ranged("albedo", albedo, 0.0, 1.0)?;
        let thickest = if albedo > 1.0 - LEAST_ABSORPTION { THICKEST_LOSSLESS } else { THICKEST };
        ranged("b", thickness, 0.0, thickest)?;
        let pigment = PigmentOptics {
            scattering: Spectrum::constant(albedo * thickness),
            extinction: Spectrum::constant(thickness),
            phase,
        };
        Ok(Self { thickness, pigment })
    }

    fn henyey_greenstein(g: f64) -> Result<Phase> {
        ranged("g", g, -LARGEST_G, LARGEST_G)?;
        Ok(Phase::HenyeyGreenstein(Spectrum::constant(g)))
    }

    fn asymmetry(&self) -> f64 {
        self.pigment.phase.asymmetry(0).abs()
    }

    /// Nodes a hemisphere.
    fn nodes(&self) -> usize {
        LEAST_NODES.max((NODES / (1.0 - self.asymmetry())).ceil() as usize)
    }

    /// Azimuth modes of light scattered twice or more.
    fn modes(&self) -> usize {
        (0.5 * NEGLIGIBLE.ln() / self.asymmetry().ln()).max(LEAST_MODES) as usize
    }

    /// `exp(-b/cos)` between two smooth boundaries, both of this reflectance: what comes back unscattered, and what passes.
    fn unscattered(&self, cos: f64, reflectance: f64) -> [f64; 2] {
        let through = (-self.thickness / cos).exp();
        let bounced = through * reflectance;
        let passed = (1.0 - reflectance).powi(2) * through / (1.0 - bounced * bounced);
        [reflectance + bounced * passed, passed]
    }

    /// The kernel on the nodes of a medium of this index, and the slab without boundaries.
    fn transfer(&self, nodes: &Nodes, index: f64, modes: usize) -> Result<(Kernel, FilmTransfer)> {
        let directions = nodes.directions(index);
        let phase = PhaseKernel::new(&self.pigment, modes, &[0]);
        let extent = Extent { nodes: directions.len(), modes, bands: 1 };
        let kernel =
            Kernel::new(extent, |i, j, sums| phase.add(directions[i], directions[j], extent, &[0], sums))?;
        let absorption = vec![self.thickness - self.pigment.scattering.0[0]; directions.len()];
        let film = FilmTransfer::new(nodes, index, &kernel, 0, &absorption, THINNESS);
        Ok((kernel, film))
    }
}

/// Evaluates a row. Fluxes: albedo, b, g, n, and the angles (degrees outside) as keys of `collimated`. Kernels: `case` with
/// `layers` (top to bottom: a, b, kind `HG` with g or `Rayleigh`) and the albedo `rho` of a Lambertian ground; `mu`, `mu0`,
/// `phi_deg` where the usual axes are not meant.
///
/// # Errors
/// A field that is missing or outside its range.
pub fn eval_slab(row: &Value) -> Result<Value> {
    if row.get("case").is_some() { kernels(row) } else { fluxes(row) }
}

fn fluxes(row: &Value) -> Result<Value> {
    let (index, g) = (ranged("n", number(row, "n")?, 1.0, 4.0)?, number(row, "g")?);
    let medium = Medium::new(number(row, "albedo")?, number(row, "b")?, Medium::henyey_greenstein(g)?)?;
    let empty = Map::new();
    let asked = row.get("collimated").and_then(Value::as_object).unwrap_or(&empty);
    let mut probes = vec![1.0];
    for angle in asked.keys() {
        let degrees = angle.parse::<f64>().unwrap_or(f64::NAN);
        probes.push(ranged("collimated: angle", degrees, 0.0, 89.99)?.to_radians().cos());
    }
    let nodes = Nodes::new(&[index], medium.nodes(), &probes);
    let (kernel, film) = medium.transfer(&nodes, index, 1)?;
    let surface = Layer::boundary(&nodes, 1.0, index);
    let slab = surface.on(&film.layer(&kernel, 0, 0)?)?.on(&surface.turned())?;

    let weights = nodes.weights();
    let outside = nodes.count(1.0);
    let amplitude: Vec<f64> = weights[..outside].iter().map(|g| g.sqrt()).collect();
    let total = |operator: &Operator| -> Vec<f64> {
        operator.before(&amplitude).iter().zip(&amplitude).map(|(f, a)| f / a).collect()
    };
    let (reflected, transmitted) = (total(&slab.reflect_above), total(&slab.transmit_down));
    let diffuse = |values: &[f64]| -> f64 {
        (0..outside).filter(|k| nodes.is_quadrature(*k)).map(|k| 2.0 * weights[k] * values[k]).sum()
    };
    let inside = nodes.directions(index);
    let normal = nodes.per_panel();
    let mut collimated = Map::new();
    for (k, angle) in asked.keys().enumerate() {
        let probe = normal + 1 + k;
        let [back, on] = medium.unscattered(inside[probe].cos, dielectric(probes[1 + k], index));
        let fields = json!({
            "R_total": reflected[probe],
            "T_total": transmitted[probe],
            "R_unscattered": back,
            "T_unscattered": on,
        });
        collimated.insert(angle.clone(), fields);
    }
    Ok(json!({
        "albedo": row["albedo"], "b": row["b"], "g": row["g"], "n": row["n"],
        "collimated": collimated,
        "URU": diffuse(&reflected), "UTU": diffuse(&transmitted),
        "UR1": reflected[normal], "UT1": transmitted[normal],
    }))
}

/// Layers over a ground, solved: reflection, and the light that goes down onto the ground, between the directions asked for.
struct Kernels<'a> {
    media: &'a [Medium],
    probes: Vec<Direction>,
    /// Scattered more than once: for each mode, both sides.
    rest: Vec<[DMatrix<f64>; 2]>,
    /// For each direction, the share reflected, onto the ground scattered, and unscattered.
    totals: Vec<[f64; 3]>,
}

impl<'a> Kernels<'a> {
    /// `probes` are the cosines to look at.
    fn new(media: &'a [Medium], ground: f64, probes: &[f64]) -> Result<Self> {
        let largest = |count: fn(&Medium) -> usize| media.iter().map(count).max().unwrap_or_default();
        let (n, modes) = (largest(Medium::nodes), largest(Medium::modes));
        let nodes = Nodes::new(&[], n, probes);
        let directions = nodes.directions(1.0);
        let parts = media.iter().map(|m| m.transfer(&nodes, 1.0, modes)).collect::<Result<Vec<_>>>()?;
        let solved = (0..modes).into_par_iter().try_map(|mode| {
            let lower = if mode == 0 {
                lambertian(&nodes, 1.0, ground)
            } else {
                Operator::zero(directions.len(), directions.len())
            };
            stacked(&parts, mode, lower)
        })?;

        let amplitude: Vec<f64> = nodes.weights().iter().map(|g| g.sqrt()).collect();
        let paths = |i: usize, j: usize| -> Vec<[f64; 2]> {
            parts.iter().map(|(_, film)| [i, j].map(|k| film.extinction()[k] / directions[k].cos)).collect()
        };
        let rest = |(mode, pair): (usize, &[Operator; 2])| {
            SIDES.map(|side| {
                let once: Vec<_> = parts.iter().map(|(kernel, _)| kernel.matrix(side, mode, 0)).collect();
                DMatrix::from_fn(probes.len(), probes.len(), |p, q| {
                    let (i, j) = (n + p, n + q);
                    let scattered = once.iter().map(|kernel| kernel[(i, j)]);
                    pair[side as usize].scattered(i, j) / (amplitude[i] * amplitude[j])
                        - single(side, scattered, &paths(i, j)) / (directions[i].cos * directions[j].cos)
                })
            })
        };
        let totals = (n..directions.len()).map(|k| {
            let [reflection, down] = solved[0].each_ref().map(|all| all.before(&amplitude)[k] / amplitude[k]);
            let direct: f64 = media.iter().map(|m| m.unscattered(directions[k].cos, 0.0)[1]).product();
            [reflection, down - direct, direct]
        });
        Ok(Self {
            media,
            totals: totals.collect(),
            rest: solved.iter().enumerate().map(rest).collect(),
            probes: directions[n..].to_vec(),
        })
    }

    /// BRDF, or BTDF without the direct beam, between two probes, 1/sr.
    fn at(&self, side: Side, out: usize, incident: usize, phi: f64) -> f64 {
        let term = |(m, pair): (usize, &[DMatrix<f64>; 2])| {
            pair[side as usize][(out, incident)] * if m == 0 { 0.5 } else { (m as f64 * phi).cos() }
        };
        self.rest.iter().enumerate().map(term).sum::<f64>() / PI + self.once(side, out, incident, phi)
    }

    /// The share of it that is scattered once.
    fn once(&self, side: Side, out: usize, incident: usize, phi: f64) -> f64 {
        let (a, b) = (self.probes[out], self.probes[incident]);
        let vertical = if side == Side::Reflection { -a.cos * b.cos } else { a.cos * b.cos };
        let cos = (vertical + a.sin * b.sin * phi.cos()).clamp(-1.0, 1.0);
        let scattered = self.media.iter().map(|m| m.pigment.scattering.0[0] * m.pigment.phase.eval(cos, 0));
        let paths: Vec<_> = self.media.iter().map(|m| [m.thickness / a.cos, m.thickness / b.cos]).collect();
        single(side, scattered, &paths) / (a.cos * b.cos)
    }
}

/// One mode of the layers, from the bottom up: what they reflect, and the light on the ground through all of them.
fn stacked(parts: &[(Kernel, FilmTransfer)], mode: usize, ground: Operator) -> Result<[Operator; 2]> {
    let (mut reflection, mut down): (_, Option<Operator>) = (ground, None);
    for (kernel, film) in parts.iter().rev() {
        let (above, through) = film.layer(kernel, mode, 0)?.over(&reflection)?;
        (reflection, down) = (above, Some(down.map_or(through.clone(), |down| down.after(&through))));
    }
    let down = down.ok_or_else(|| Error::invalid("", "layers", 0, "one or more"))?;
    Ok([reflection, down])
}

/// Light scattered once in layers (top to bottom) of these kernels and optical thicknesses along the way out and the way in.
fn single(side: Side, kernels: impl Iterator<Item = f64>, paths: &[[f64; 2]]) -> f64 {
    let each = kernels.enumerate().map(|(layer, kernel)| {
        let (above, below) = (&paths[..layer], &paths[layer + 1..]);
        let others: f64 = match side {
            Side::Reflection => above.iter().map(|[out, incident]| out + incident).sum(),
            Side::Transmission => {
                above.iter().map(|path| path[1]).sum::<f64>() + below.iter().map(|path| path[0]).sum::<f64>()
            }
        };
        kernel * attenuation(side, paths[layer]) * (-others).exp()
    });
    each.sum()
}

fn kernels(row: &Value) -> Result<Value> {
    let case = &row["case"];
    let layers = case["layers"].as_array().filter(|layers| !layers.is_empty());
    let layers =
        layers.ok_or_else(|| Error::invalid("case.layers", "layers", &case["layers"], "one or more"))?;
    let media = layers.iter().map(medium).collect::<Result<Vec<_>>>()?;
    let ground = ranged("rho", case.get("rho").map_or(Ok(0.0), |_| number(case, "rho"))?, 0.0, 1.0)?;
    let mu = axis(row, "mu", &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])?;
    let mu0 = axis(row, "mu0", &[0.2, 0.5, 0.8, 1.0])?;
    let phi = axis(row, "phi_deg", &[0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0])?;
    let probes: Vec<f64> = mu.iter().chain(&mu0).copied().collect();
    for cosine in &probes {
        ranged("mu", *cosine, 1e-4, 1.0)?;
    }
    let solved = Kernels::new(&media, ground, &probes)?;
    let mut results = Map::new();
    for (k, cosine) in mu0.iter().enumerate() {
        let incident = mu.len() + k;
        let table = |side: Side| -> Vec<Vec<f64>> {
            let line = |i| phi.iter().map(|p| solved.at(side, i, incident, p.to_radians())).collect();
            (0..mu.len()).map(line).collect()
        };
        let [reflected, diffuse, direct] = solved.totals[incident];
        let fields = json!({
            "brdf": table(Side::Reflection),
            "btdf_diffuse": table(Side::Transmission),
            "R_total": reflected,
            "T_diffuse": diffuse,
            "T_direct": direct,
        });
        results.insert(format!("{cosine:?}"), fields);
    }
    Ok(json!({ "case": case, "results_by_mu0": results }))
}

fn medium(layer: &Value) -> Result<Medium> {
    let phase = match layer["kind"].as_str() {
        Some("HG") => Medium::henyey_greenstein(number(layer, "g")?)?,
        Some("Rayleigh") => Phase::Rayleigh,
        _ => return Err(Error::invalid("case.layers", "kind", &layer["kind"], "HG or Rayleigh")),
    };
    Medium::new(number(layer, "a")?, number(layer, "b")?, phase)
}

fn number(row: &Value, key: &str) -> Result<f64> {
    row.get(key)
        .and_then(Value::as_f64)
        .ok_or_else(|| Error::invalid(key, "field", row.get(key).unwrap_or(&Value::Null), "a number"))
}

fn ranged(what: &str, value: f64, from: f64, to: f64) -> Result<f64> {
    if (from..=to).contains(&value) {
        return Ok(value);
    }
    Err(Error::invalid("", what, value, format!("{from} to {to}")))
}

fn axis(row: &Value, key: &str, usual: &[f64]) -> Result<Vec<f64>> {
    let Some(value) = row.get(key) else { return Ok(usual.to_vec()) };
    let list = value.as_array().map(|list| list.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
    list.filter(|list| !list.is_empty()).ok_or_else(|| Error::invalid(key, "field", value, "numbers"))
}
