//! `carpaint eval flake-layer`: a layer of mirror flakes alone, from rows of reference numbers.
//!
//! What is scattered once is taken from its formula (eqs 13 and 20 as corrected), the rest from adding and doubling.
//! At incidence beyond about 80 degrees on narrow flakes (sigma 5 degrees) the error of the rest reaches 1e-4 of the peak, so
//! that `R_adding_doubling` may come out that much below 0 far off the plane of incidence.

use crate::color::Spectrum;
use crate::error::{Error, Result};
use crate::math::quadrature::gauss_legendre;
use crate::parallel::TryMap;
use crate::simulate::composition::{Film, FlakeKind, Mirror};
use crate::simulate::models::transfer::film::{FilmTransfer, attenuation};
use crate::simulate::models::transfer::film_kernel::{Resolution, film_absorption, film_kernel};
use crate::simulate::models::transfer::flake_kernel::Mirroring;
use crate::simulate::models::transfer::interpolation::ModeTable;
use crate::simulate::models::transfer::kernel::{SIDES, Side};
use crate::simulate::models::transfer::layer::Layer;
use crate::simulate::models::transfer::nodes::{Direction, Nodes};
use crate::simulate::models::transfer::operator::Operator;
use crate::simulate::optics::film_optics::{FilmOptics, mean_attenuation};
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI};

/// Nodes of the hemisphere for flakes of a width of 1 degree: totals to 1e-4 of themselves.
const NODES: f64 = 320.0;
/// The same for azimuth modes.
const MODES: f64 = 560.0;
/// Narrowest flakes, degrees.
const LEAST_SIGMA: f64 = 2.0;
/// Scattering thickness of the first layer.
const THINNESS: f64 = 4e-3;
/// Bins of polar angle and of azimuth (folded), as the reference has them.
const BINS: usize = 18;
/// Nodes of a bin, each way.
const BIN_NODES: usize = 8;

/// By how much `r + t = 1` may be missed in decimal fractions.
const ROUNDING: f64 = 1e-12;

/// The layer, solved.
struct FlakeLayer {
    film: FilmOptics,
    /// Scattered more than once, between the nodes: reflection, transmission.
    rest: [ModeTable; 2],
    /// Scattered back more than once, between two of the directions asked for: modes.
    at_probes: Vec<DMatrix<f64>>,
    /// For each of those, the share reflected, transmitted scattered and unscattered.
    totals: Vec<[f64; 3]>,
}

impl FlakeLayer {
    fn new(film: FilmOptics, probes: &[Direction]) -> Result<Self> {
        let sigma =
            film.kinds.iter().map(|kind| kind.density.width()).fold(f64::INFINITY, f64::min).to_degrees();
        let per_width = |n: f64, least: f64| (n / sigma).max(least) as usize;
        let modes = per_width(MODES, 64.0);
        let resolution = Resolution { modes, cutoff: 1e-12, azimuths: 10, least_width: 0.0 };
        let cosines: Vec<f64> = probes.iter().map(|d| d.cos).collect();
        let nodes = Nodes::new(&[], per_width(NODES, 40.0), &cosines);
        let directions = nodes.directions(1.0);
        let kernel = film_kernel(&film, &directions, &[0], resolution)?;
        let absorption = film_absorption(&film, &directions, &[0]);
        let transfer = FilmTransfer::new(&nodes, 1.0, &kernel, 0, &absorption[0], THINNESS);
        let layers = (0..modes).into_par_iter().try_map(|mode| transfer.layer(&kernel, mode, 0))?;

        let amplitude: Vec<f64> = nodes.weights().iter().map(|g| g.sqrt()).collect();
        let rest = |side: Side| -> Vec<DMatrix<f64>> {
            let each = layers.iter().enumerate().map(|(mode, layer)| {
                let once = kernel.matrix(side, mode, 0);
                DMatrix::from_fn(amplitude.len(), amplitude.len(), |i, j| {
                    let all = side_of(layer, side).scattered(i, j) / (amplitude[i] * amplitude[j]);
                    all - transfer.once(side, &once, i, j)
                })
            });
            each.collect()
        };
        let both = SIDES.map(rest);
        let n = nodes.per_panel();
        let cos: Vec<f64> = directions.iter().take(n).map(|d| d.cos).collect();
        let table = |all: &Vec<DMatrix<f64>>| {
            ModeTable::new(cos.clone(), 1.0, modes, 1, |mode, i, j, _| all[mode][(i, j)])
        };
        let scattered = SIDES.map(|side| side_of(&layers[0], side).before(&amplitude));
        let totals = (n..amplitude.len()).map(|k| {
            let direct = layers[0].transmit_down.direct()[k];
            let [back, on] = scattered.each_ref().map(|total| total[k] / amplitude[k]);
            [back, on - direct, direct]
        });
        Ok(Self {
            rest: both.each_ref().map(table),
            at_probes: both[0]
                .iter()
                .map(|all| all.view((n, n), (probes.len(), probes.len())).into_owned())
                .collect(),
            totals: totals.collect(),
            film,
        })
    }

    /// BRDF of light scattered more than once, between two of the directions asked for.
    fn rest_at(&self, i: usize, j: usize, phi: f64) -> f64 {
        let modes = self.at_probes.iter().enumerate();
        modes.map(|(m, all)| all[(i, j)] * (m as f64 * phi).cos() / if m == 0 { 2.0 * PI } else { PI }).sum()
    }

    /// Scattered once: kernel at an azimuth difference, over the cosine of the outgoing direction; 1/sr.
    fn once(&self, side: Side, a: Direction, b: Direction, phi: f64) -> f64 {
        let mirror = Mirroring::new(side, a, b, phi);
        let paths = [a, b].map(|d| self.film.extinction(d.sin.atan2(d.cos))[0] / d.cos);
        let kinds = self.film.kinds.iter().map(|kind| {
            0.25 * kind.area_density
                * kind.density.eval(mirror.beta)
                * kind.optics.reflectance(mirror.cos_alpha)[0]
        });
        kinds.sum::<f64>() / (a.cos * b.cos) * attenuation(side, paths)
    }

    /// Shares of the incident energy in the bins.
    fn bins(&self, side: Side, incident: Direction) -> Vec<Vec<f64>> {
        let rest = &self.rest[side as usize];
        let edge = |k: usize, full: f64| full * k as f64 / BINS as f64;
        let row = |k: usize| {
            let mut row = vec![0.0; BINS];
            for (theta, w) in gauss_legendre(BIN_NODES, edge(k, FRAC_PI_2), edge(k + 1, FRAC_PI_2)) {
                let out = direction(theta);
                let series = rest.series([incident.cos, out.cos]);
                for (bin, sum) in row.iter_mut().enumerate() {
                    for (phi, v) in gauss_legendre(BIN_NODES, edge(bin, PI), edge(bin + 1, PI)) {
                        let f = self.once(side, incident, out, phi) + rest.sum(&series, phi.cos())[0];
                        // Folded: both signs of the azimuth.
                        *sum += 2.0 * w * v * out.cos * out.sin * f;
                    }
                }
            }
            row
        };
        (0..BINS).into_par_iter().map(row).collect()
    }
}

fn side_of(layer: &Layer, side: Side) -> &Operator {
    match side {
        Side::Reflection => &layer.reflect_above,
        Side::Transmission => &layer.transmit_down,
    }
}

fn direction(theta: f64) -> Direction {
    Direction { cos: theta.cos(), sin: theta.sin() }
}

/// Evaluates a row: `config` (sigma_deg, DSh, rp, tp), `theta_i_deg`, and the `points` (theta_deg, phi_deg; 0 is the mirror
/// side) at which the kernel BRDF cos(theta) is wanted.
///
/// # Errors
/// A field that is missing or outside its range.
pub fn eval_flake_layer(row: &Value) -> Result<Value> {
    let config = &row["config"];
    let density = number(config, "DSh", 0.0..=10.0)?;
    let (reflectance, transmittance) = (number(config, "rp", 0.0..=1.0)?, number(config, "tp", 0.0..=1.0)?);
    if reflectance + transmittance > 1.0 + ROUNDING {
        return Err(Error::invalid("config", "rp + tp", reflectance + transmittance, "at most 1"));
    }
    let kind = FlakeKind {
        area_density: density,
        diameter_um: 10.0,
        diameter_spread: 0.0,
        sigma_deg: Some(number(config, "sigma_deg", LEAST_SIGMA..=89.9)?),
        tilts: None,
        flake_lifetime_deg: 0.0,
        mirror: Some(Mirror {
            reflectance: Spectrum::constant(reflectance),
            transmittance: Spectrum::constant(transmittance),
        }),
        stack: None,
    };
    let film = Film {
        thickness_um: 1.0,
        index: 1.0,
        absorption_per_mm: Spectrum::constant(0.0),
        flakes: vec![kind],
        pigments: Vec::new(),
    };
    let none = Vec::new();
    let points = row["points"].as_array().unwrap_or(&none);
    let polar = |value: &Value, key: &str| Ok(direction(number(value, key, 0.0..=89.0)?.to_radians()));
    let incident = polar(row, "theta_i_deg")?;
    let mut probes = vec![incident];
    for point in points {
        probes.push(polar(point, "theta_deg")?);
    }
    let layer = FlakeLayer::new(FilmOptics::new(&film)?, &probes)?;
    let points = points.iter().zip(&probes[1..]).enumerate().map(|(k, (point, out))| {
        let phi = number(point, "phi_deg", -360.0..=360.0)?.to_radians();
        let once = layer.once(Side::Reflection, incident, *out, phi);
        let tilted =
            layer.film.kinds[0].density.eval(Mirroring::new(Side::Reflection, incident, *out, phi).beta);
        // Eq. 20 with the extinction of flat flakes along both ways.
        let flat =
            0.25 * density * reflectance * tilted * mean_attenuation(2.0 * density * (1.0 - transmittance));
        Ok(json!({
            "theta_deg": point["theta_deg"],
            "phi_deg": point["phi_deg"],
            "R_adding_doubling": (once + layer.rest_at(1 + k, 0, phi)) * out.cos,
            "R_single_scatter_eq20": once * out.cos,
            "R_single_scatter_const_tau": flat / incident.cos,
        }))
    });
    let [reflected, transmitted, direct] = layer.totals[0];
    let exact = layer.film.extinction(incident.sin.atan2(incident.cos))[0];
    Ok(json!({
        "config": config,
        "theta_i_deg": row["theta_i_deg"],
        "P_norm_C": layer.film.kinds[0].density.eval(0.0),
        "R_total_ad": reflected,
        "T_diffuse_ad": transmitted,
        "T_direct_ad": direct,
        "T_direct_exact": (-exact / incident.cos).exp(),
        "points": points.collect::<Result<Vec<_>>>()?,
        "bin_fraction_ad": layer.bins(Side::Reflection, incident),
        "bin_T_diffuse": layer.bins(Side::Transmission, incident),
    }))
}

fn number(row: &Value, key: &str, legal: std::ops::RangeInclusive<f64>) -> Result<f64> {
    let value = row.get(key).and_then(Value::as_f64).filter(|value| legal.contains(value));
    value.ok_or_else(|| {
        let found = row.get(key).unwrap_or(&Value::Null);
        Error::invalid("", key, found, format!("{} to {}", legal.start(), legal.end()))
    })
}
