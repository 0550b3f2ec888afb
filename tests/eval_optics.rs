//! `carpaint eval thin-film|mie|fresnel`: reference rows in, the same numbers out.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use serde_json::{Value, json};

fn eval(kind: &str, file: &std::path::Path) -> Value {
    let out = common::carpaint().args(["eval", kind]).arg(file).arg("--json").output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

fn eval_row(kind: &str, row: &Value) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("row.json");
    std::fs::write(&file, row.to_string()).unwrap();
    eval(kind, &file)
}

/// Largest difference over `scale` of theirs, of all numbers in fields that both have, and how many there are.
fn compare(ours: &Value, theirs: &Value, scale: &dyn Fn(f64) -> f64) -> (f64, usize) {
    let join = |a: (f64, usize), b: (f64, usize)| (a.0.max(b.0), a.1 + b.1);
    match (ours, theirs) {
        (Value::Object(ours), Value::Object(theirs)) => ours
            .iter()
            .filter_map(|(key, value)| Some(compare(value, theirs.get(key)?, scale)))
            .fold((0.0, 0), join),
        (Value::Array(ours), Value::Array(theirs)) => {
            assert_eq!(ours.len(), theirs.len());
            ours.iter().zip(theirs).map(|(a, b)| compare(a, b, scale)).fold((0.0, 0), join)
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            let error = (a - b).abs() / scale(b);
            assert!(!error.is_nan());
            (error, 1)
        }
        (a, b) => {
            assert_eq!(a, b);
            (0.0, 0)
        }
    }
}

#[test]
fn thin_films_are_those_of_the_oracle() {
    let Some(file) = common::reference("oracles/02_thin_film.json") else { return };
    let oracle = common::reference_json("oracles/02_thin_film.json").unwrap();
    let (error, count) = compare(&eval("thin-film", &file), &oracle, &|_| 1.0);
    println!("thin films: {error:e} of {count} numbers");
    assert_eq!(count, 7 * 6 * 18 * 41);
    // The target; the reference is good to 1e-13 and printed to 1e-12.
    assert!(error < 1e-9, "{error:e}");
    // A row alone, at its own angles and wavelengths.
    let case = &oracle["cases"][4];
    let row = json!({
        "name": case["name"], "n_list": case["n_list"], "d_list_nm": case["d_list_nm"],
        "angle_deg": [85], "wavelength_nm": [780, 380],
    });
    let one = eval_row("thin-film", &row);
    for (k, j) in [(0, 40), (1, 0)] {
        let error = one["T_p"][0][k].as_f64().unwrap() - case["T_p"][17][j].as_f64().unwrap();
        assert!(error.abs() < 1e-9, "{error:e}");
    }
}

#[test]
fn spheres_are_those_of_the_oracle() {
    let Some(file) = common::reference("oracles/03_mie.json") else { return };
    let oracle = common::reference_json("oracles/03_mie.json").unwrap();
    // Relative, but for differences of large numbers: amplitudes next to a zero, absorption of a clear sphere.
    let (error, count) = compare(&eval("mie", &file), &oracle, &|x| x.abs().max(1e-6));
    println!("spheres: {error:e} of {count} numbers");
    assert_eq!(count, 11 * (7 + 19 * 5));
    assert!(error < 1e-8, "{error:e}");
}

#[test]
fn boundaries_are_those_of_the_oracle() {
    let Some(file) = common::reference("oracles/04_fresnel.json") else { return };
    let oracle = common::reference_json("oracles/04_fresnel.json").unwrap();
    let (error, count) = compare(&eval("fresnel", &file), &oracle, &|_| 1.0);
    println!("boundaries: {error:e} of {count} numbers");
    assert_eq!(count, 2 * 3 * 30 + 15 * 5);
    assert!(error < 1e-10, "{error:e}");
    let row = eval_row("fresnel", &json!({"eta": 1.5, "angle_deg": [0, 56.3]}));
    assert!((row["R_p"][0].as_f64().unwrap() - 0.04).abs() < 1e-15 && row["F_internal"].is_number(), "{row}");
}

#[test]
fn bad_rows_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("row.json");
    for (kind, row, word) in [
        ("thin-film", json!({"n_list": [1.5, 2.5], "d_list_nm": [null]}), "lengths"),
        ("thin-film", json!({"n_list": [1.5, "TiO", 1.5], "d_list_nm": [null, 3, null]}), "TiO2"),
        ("thin-film", json!({"n_list": [[1.5, 0.1], 1.5], "d_list_nm": [null, null]}), "does not absorb"),
        ("thin-film", json!({"n_list": [1.5, 2, 1.5], "d_list_nm": [null, -3, null]}), "0 or more"),
        ("mie", json!({"x": 1e9, "m_re": 1.5}), "1e-4 to 1e4"),
        ("mie", json!({"x": 1}), "m_re"),
        ("fresnel", json!({"eta": 0.5}), "1 to 4"),
        ("fresnel", json!({"eta": 1.5, "angle_deg": [90.1]}), "0 to 90"),
        (
            "thin-film",
            json!({"n_list": [1, 2], "d_list_nm": [null, null], "angle_deg": [0, -1]}),
            "angle_deg: found -1",
        ),
        ("thin-film", json!({"n_list": [1, 2], "d_list_nm": [null, null], "wavelength_nm": [0]}), "above 0"),
        // Rows without the field that tells most.
        ("thin-film", json!({"d_list_nm": [null]}), "n_list"),
        ("mie", json!({"m_re": 1.5}), "x: found null"),
        ("fast", json!({"points": []}), "params"),
        (
            "sparkle",
            json!({"sigma_deg": 9, "eta": 1.5, "theta_i_deg": 0, "theta_o_deg": 0, "phi_deg": 0}),
            "neither Delta_deg nor D_per_cm3",
        ),
        (
            "fast",
            json!({
                "params": {"sigma_deg": 9, "DSh": 1, "rp": 0.5, "tp": 0, "eta": 1.5, "rs": 0}, "points": {"a": 1}
            }),
            "a list",
        ),
        (
            "fast",
            json!({"params": {"sigma_deg": 0, "DSh": 1, "rp": 0.5, "tp": 0, "eta": 1.5, "rs": 0}}),
            "0.1 to 89.9",
        ),
    ] {
        std::fs::write(&file, row.to_string()).unwrap();
        let out = common::carpaint().args(["eval", kind]).arg(&file).output().unwrap();
        let error = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{row}: {error}");
        assert!(error.contains(word), "{row}: {error}");
    }
}
