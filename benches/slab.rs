//! Fluxes of plane slabs against the peers: Python's iadpython (adding-doubling) and PythonicDISORT (discrete ordinates),
//! where they are installed, in the same run.
//!
//! Light at the normal on Henyey-Greenstein slabs; best of five after one to warm up, one process at a time. The difference
//! is to our total reflectance. iadpython's weights lose their digits beyond some 28 nodes, and its fluxes converge slowly
//! with an index; PythonicDISORT knows no refraction. `CARPAINT_PYTHON` names the interpreter, else it is `python3`.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::simulate::eval_slab;
use serde_json::{Value, json};
use std::process::Command;
use std::time::Instant;

/// Runs with a way to solve a row, as many times as here; prints milliseconds and total reflectance of each row.
const TIMING: &str = r#"
import json, sys, time
def report(solve):
    answers = []
    for row in json.loads(sys.argv[1]):
        reflected, best = solve(row), float("inf")
        for _ in range(5):
            start = time.perf_counter()
            solve(row)
            best = min(best, time.perf_counter() - start)
        answers.append([1e3 * best, float(reflected)])
    print(json.dumps(answers))
"#;

const IAD: &str = r#"
import iadpython
report(lambda row: iadpython.Sample(a=row["albedo"], b=row["b"], g=row["g"], n=row["n"], quad_pts=NODES).rt()[0])
"#;

const DISORT: &str = r#"
import numpy
from PythonicDISORT.pydisort import pydisort
def solve(row):
    moments = row["g"] ** numpy.arange(NODES)
    up = pydisort(row["b"], row["albedo"], NODES, moments, 1.0, 1.0, 0.0, only_flux=True, f_arr=row["g"] ** NODES)[1]
    return up(0)
report(solve)
"#;

struct Peer {
    name: &'static str,
    script: &'static str,
    nodes: u32,
    refracts: bool,
}

const PEERS: [Peer; 4] = [
    Peer { name: "iadpython, 16 nodes", script: IAD, nodes: 16, refracts: true },
    Peer { name: "iadpython, 24 nodes", script: IAD, nodes: 24, refracts: true },
    Peer { name: "PythonicDISORT, 32 streams", script: DISORT, nodes: 32, refracts: false },
    Peer { name: "PythonicDISORT, 128 streams", script: DISORT, nodes: 128, refracts: false },
];

impl Peer {
    /// Milliseconds and total reflectance of each row; none where the peer is not installed or fails.
    fn answers(&self, rows: &[Value]) -> Option<Vec<[f64; 2]>> {
        let python = std::env::var_os("CARPAINT_PYTHON").unwrap_or_else(|| "python3".into());
        let script = format!("{TIMING}NODES = {}{}", self.nodes, self.script);
        let output = Command::new(python).arg("-c").arg(script).arg(json!(rows).to_string()).output().ok()?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            eprintln!("{}: {}", self.name, said.lines().last().unwrap_or("no answer"));
        }
        serde_json::from_slice(&output.stdout).ok()
    }
}

/// Milliseconds and total reflectance.
fn ours(row: &Value) -> [f64; 2] {
    let solve = || eval_slab(row).expect("a legal row")["UR1"].as_f64().expect("a number");
    let reflected = solve();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        solve();
        best = best.min(1e3 * start.elapsed().as_secs_f64());
    }
    [best, reflected]
}

fn print(name: &str, [ms, reflected]: [f64; 2], own: [f64; 2]) {
    println!("  {name:<28} {ms:>9.2} {:>7.2} {reflected:>12.8} {:>9.1e}", ms / own[0], reflected - own[1]);
}

fn main() {
    let rows: Vec<Value> = [(1.0, 1.0), (1.0, 8.0), (1.5, 1.0), (1.5, 8.0)]
        .map(|(n, b)| json!({ "albedo": 0.9, "b": b, "g": 0.875, "n": n }))
        .into();
    let solved: Vec<[f64; 2]> = rows.iter().map(ours).collect();
    let answers: Vec<Option<Vec<[f64; 2]>>> = PEERS
        .iter()
        .map(|peer| {
            let able = |row: &&Value| peer.refracts || row["n"] == 1.0;
            peer.answers(&rows.iter().filter(able).cloned().collect::<Vec<_>>())
        })
        .collect();
    println!("{:<30} {:>9} {:>7} {:>12} {:>9}", "albedo 0.9, g 0.875", "ms", "ratio", "R_total", "diff");
    for (k, (row, own)) in rows.iter().zip(&solved).enumerate() {
        println!("index {}, optical thickness {}", row["n"], row["b"]);
        print("carpaint", *own, *own);
        for (peer, answers) in PEERS.iter().zip(&answers) {
            // Rows without an index come first, so that a peer that does not refract has the first ones.
            if let Some(answer) = answers.as_ref().and_then(|answers| answers.get(k)) {
                print(peer.name, *answer, *own);
            }
        }
    }
    if answers.iter().any(Option::is_none) {
        println!("not installed: pip install iadpython PythonicDISORT");
    }
}
