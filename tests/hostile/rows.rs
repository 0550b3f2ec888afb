//! JSON that only the program reads: rows of `eval`, problems of `transport`. Damaged, each in a process of its own whose memory
//! is limited.

use crate::common::carpaint;
use crate::mutation::mutated;
use crate::trial::say;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Damaged rows of each command, and of the one that takes a second for a row.
const INPUTS: usize = 32;
const SLOW_INPUTS: usize = 8;
/// Address space, KiB; the program and its threads take a third of it.
const MEMORY: usize = 2 << 20;
/// A run that takes this long hangs.
const HANGS: Duration = Duration::from_secs(90);

const ROWS: &[(&[&str], &str)] = &[
    (
        &["transport"],
        r#"{"name": "a", "source_centres": [[50, 0, 0], [60, 1, 2]], "target_centres": [[50, 3, 4], [40, -1e1, 0]], "p": [0.25, 0.75], "q": [0.5, 0.5]}"#,
    ),
    (
        &["eval", "transport"],
        r#"[{"source_centres": [[50, 0, 0]], "target_centres": [[50, 3, 4]], "p": [1], "q": [1]}]"#,
    ),
    (
        &["eval", "lobes"],
        r#"{"kd": 0.02, "lobes": [[0.14, 0.85, 0.11], [0.15, 0.003, 0.085]], "albedo": [{"theta_i_deg": 15}], "points": [{"theta_i": 0.5, "theta_o": 0.6, "dphi": 3.14}]}"#,
    ),
    (&["eval", "color"], r#"{"rows": [{"lab1": [50, 2.5, -80], "lab2": [50, 0, -82.7]}]}"#),
    (
        &["eval", "thin-film"],
        r#"{"cases": [{"name": "a", "n_list": [1.5, [2.5, 0.01], "TiO2", 1.5], "d_list_nm": [null, 43, 500, null], "angle_deg": [0, 45], "wavelength_nm": [400, 700]}]}"#,
    ),
    (
        &["eval", "mie"],
        r#"[{"x": 5.5, "m_re": 1.33, "m_im_absorbing_positive": 1e-3, "angle_deg": [0, 90, 180]}]"#,
    ),
    (&["eval", "fresnel"], r#"[{"eta": 1.5, "angle_deg": [0, 30, 89.9]}]"#),
    (
        &["eval", "gonio"],
        r#"[{"theta_i": 0.5, "theta_o": 0.5, "dphi": 3.141592653589793, "alpha": 0.19, "rho": 0.8, "c": 0.5}]"#,
    ),
    (&["eval", "slab"], r#"[{"albedo": 0.9, "b": 1.0, "g": 0.5, "n": 1.0}]"#),
    (
        &["eval", "flake-layer"],
        r#"[{"config": {"name": "A", "sigma_deg": 15.0, "DSh": 0.5, "rp": 0.6, "tp": 0.1}, "theta_i_deg": 30.0}]"#,
    ),
    (
        &["eval", "fast"],
        r#"[{"params": {"sigma_deg": 15, "DSh": 0.5, "rp": 0.6, "tp": 0.4, "eta": 1.5, "rs": 0.5}, "points": [{"theta_i_deg": 15, "theta_o_deg": 30, "phi_deg": 0}]}]"#,
    ),
];

/// Exit code and message of the program on a file, or how it failed.
fn run(words: &[&str], file: &Path) -> Result<(i32, String), String> {
    let script = format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &script])
        .arg(carpaint().get_program())
        .args(words)
        .arg(file)
        .env("RAYON_NUM_THREADS", "1")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > HANGS {
            child.kill().unwrap();
            child.wait().unwrap();
            return Err("hangs".into());
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let out = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    match out.status.code() {
        Some(code @ (0 | 2)) if !said.contains("panicked") => Ok((code, said)),
        _ => Err(format!("{}: {said}", out.status)),
    }
}

#[test]
fn damaged_rows_are_refused_or_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let turn = |turn: usize| {
        let file = folder.path().join(format!("rows-{turn}.json"));
        let (mut refused, mut evaluated, mut faults) = (0, 0, Vec::new());
        for (words, text) in ROWS {
            if turn == 0 {
                std::fs::write(&file, text).unwrap();
                assert_eq!(run(words, &file).unwrap().0, 0, "{words:?}: {:?}", run(words, &file));
            }
            let inputs = if words.ends_with(&["flake-layer"]) { SLOW_INPUTS } else { INPUTS };
            for seed in (turn..inputs).step_by(2) {
                let bytes = mutated(text.as_bytes(), seed as u32);
                std::fs::write(&file, &bytes).unwrap();
                match run(words, &file) {
                    Ok((0, _)) => evaluated += 1,
                    Ok((_, said)) if said.contains(&*file.to_string_lossy()) => refused += 1,
                    found => faults.push(format!("{words:?} {}: {found:?}", String::from_utf8_lossy(&bytes))),
                }
            }
        }
        (refused, evaluated, faults)
    };
    let ((mut refused, mut evaluated, mut faults), other) = std::thread::scope(|scope| {
        let other = scope.spawn(|| turn(1));
        (turn(0), other.join().unwrap())
    });
    refused += other.0;
    evaluated += other.1;
    faults.extend(other.2);
    say(&format!("rows: {refused} refused, {evaluated} evaluated, {} faults", faults.len()));
    assert!(faults.is_empty(), "{faults:#?}");
}
