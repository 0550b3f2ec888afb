//! Adding and doubling: mirrors that nearly close the light in, layers without loss, layers without end.

use super::extended::{big, relative, squared};
use super::{HardCase, decades, worst};
use crate::error::{Error, Result};
use crate::simulate::eval_slab;
use crate::simulate::models::transfer::doubling::Slab;
use nalgebra::DMatrix;
use serde_json::{Value, json};

pub(super) fn cases() -> Result<Vec<HardCase>> {
    Ok(vec![near_singular(), conservative()?, thick()?])
}

fn near_singular() -> HardCase {
    // What isn't reflected passes or, half of it, is lost.
    let steps = decades(-15..=-1).into_iter().flat_map(|e| [e, 1.3 * e, 3.7 * e]);
    let all: Vec<(f64, f64)> = steps.flat_map(|e| [(1.0 - e, e), (1.0 - e, 0.5 * e)]).collect();
    let truth = |(r, t): (f64, f64)| squared(&big(t)) / (big(1.0) - squared(&big(r)));
    let naive = |(r, t): (f64, f64)| t * t / (1.0 - r * r);
    let stable = |(r, t): (f64, f64)| {
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        let doubled = Slab { reflection: one(r), transmission: one(t) }.doubled();
        doubled.map_or(f64::NAN, |slab| slab.transmission[(0, 0)])
    };
    HardCase {
        name: "light between two nearly perfect mirrors",
        formula: "T (1 - R R)^-1 T",
        source: "Ershov et al. 2001, eq. 6; simulate::models::transfer::doubling",
        arguments: "1 - R from 1e-15 to 0.1; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |c| relative(stable(c), &truth(c))),
        bar: 4.0 * f64::EPSILON,
        why: "1 - R and 1 + R are exact near R = 1; two products and a sum",
        worse: 1e5,
    }
}

/// Reflectance and transmittance of a slab of isotropic scatterers for light along its normal.
fn slab(albedo: f64, thickness: f64) -> Result<[f64; 2]> {
    let row = eval_slab(&json!({ "albedo": albedo, "b": thickness, "g": 0.0, "n": 1.0 }))?;
    let number = |key: &str| {
        row.get(key).and_then(Value::as_f64).ok_or_else(|| Error::invalid("slab", key, "nothing", "a number"))
    };
    Ok([number("UR1")?, number("UT1")?])
}

/// The same by two fluxes, in hyperbolic functions (Kubelka 1948).
fn kubelka(absorption: f64, scattering: f64) -> [f64; 2] {
    let a = 1.0 + absorption / scattering;
    let b = (a * a - 1.0).sqrt();
    let (sinh, cosh) = ((b * scattering).sinh(), (b * scattering).cosh());
    [1.0 / (a + b * cosh / sinh), b / (a * sinh + b * cosh)]
}

fn conservative() -> Result<HardCase> {
    let all = [1.0, 1e3, 1e6];
    let solved = all.map(|b| slab(1.0, b)).into_iter().collect::<Result<Vec<_>>>()?;
    let lost = |[r, t]: [f64; 2]| (r + t - 1.0).abs();
    Ok(HardCase {
        name: "a slab that loses no light",
        formula: "T = b / (a sinh(b S) + b cosh(b S)), b^2 = a^2 - 1 = 0",
        source: "Kubelka 1948; simulate::eval_slab by adding and doubling",
        arguments: "albedo 1, optical thickness 1, 1e3, 1e6; f64",
        measure: "R + T = 1, off by",
        naive: worst(all, |b| lost(kubelka(0.0, b))),
        stable: worst(solved, lost),
        bar: 2e-7,
        why: "a rounding of R + T in the first layer, thickness 1e-3, is a loss of 1e-13 at each of 1e6 mean free paths",
        worse: 1e3,
    })
}

fn thick() -> Result<HardCase> {
    let (albedo, all) = (0.9, [1e4, 1e6, 1e9]);
    let [end, _] = slab(albedo, 1e3)?;
    let solved = all.map(|b| slab(albedo, b)).into_iter().collect::<Result<Vec<_>>>()?;
    let two_fluxes = |b: f64| kubelka((1.0 - albedo) * b, albedo * b)[0];
    Ok(HardCase {
        name: "a slab without end",
        formula: "R = 1 / (a + b cosh(b S) / sinh(b S))",
        source: "Kubelka 1948; simulate::eval_slab by adding and doubling",
        arguments: "albedo 0.9, optical thickness 1e4, 1e6, 1e9 beside 1e3; f64",
        measure: "relative to the shorter one",
        naive: worst(all, |b| (two_fluxes(b) / two_fluxes(1e2) - 1.0).abs()),
        stable: worst(solved, |[r, _]| (r / end - 1.0).abs()),
        bar: 1e-9,
        why: "first layers of different thickness, up to 1e-3, whose error is of third order",
        worse: 1e3,
    })
}
