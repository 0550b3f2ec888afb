//! Scattering in a plane slab: ours and others', against a published number.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use super::peers::Peer;
use crate::error::{Error, Result};
use crate::simulate::eval_slab;
use serde_json::json;

/// Total reflectance of a slab of optical thickness 2, albedo 0.9 and Henyey-Greenstein's g = 0.75 under light at the normal, of the
/// index of its surroundings (van de Hulst 1980, table 35), to its last digit.
const REFLECTANCE: f64 = 0.09739;

/// Prahl's adding and doubling in NumPy.
const IAD: &str = r#"
import iadpython
def run():
    sample = iadpython.Sample(a=problem["albedo"], b=problem["b"], g=problem["g"], n=problem["n"], quad_pts=problem["nodes"])
    return [float(sample.rt()[0])]
"#;
const NODES: [(&str, u32); 3] =
    [("iadpython, 8 nodes", 8), ("iadpython, 16 nodes", 16), ("iadpython, 24 nodes", 24)];

pub(super) fn curves(_: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let row = json!({ "albedo": 0.9, "b": 2.0, "g": 0.75, "n": 1.0 });
    let row = &row;
    let own = move || {
        let reflectance = eval_slab(row)?["UR1"].as_f64();
        reflectance.ok_or_else(|| Error::invalid("slab", "total reflectance", "none", "a number"))
    };
    let peers: Vec<Peer> = NODES
        .iter()
        .filter_map(|(name, nodes)| {
            let mut problem = row.clone();
            problem["nodes"] = json!(nodes);
            Peer::start(name, IAD, &problem)
        })
        .collect();
    let others = peers.iter().map(|peer| {
        let run = || {
            let (numbers, time) = peer.run()?;
            Ok((numbers.first().copied().unwrap_or(f64::INFINITY), time))
        };
        Trial::timed(peer.name(), run)
    });
    let trials: Vec<Trial<f64>> =
        std::iter::once(Trial::new("doubling and adding", true, own)).chain(others).collect();
    let head = Head {
        stage: "Simulation",
        knob: "scattering in a slab, beside others",
        error: "total reflectance of a slab of thickness 2, albedo 0.9, g 0.75 against van de Hulst's 0.09739, absolute; his last digit is 1e-5",
        why: "The solver takes as many directions as the phase function needs to nine digits, and its layers hold flakes, too, which \
              the others do not know.",
    };
    let judge = |found: &f64| Ok(((found - REFLECTANCE).abs(), None));
    Ok(vec![curve(head, &trials, *effort, judge)?])
}
