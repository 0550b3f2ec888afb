//! Cook-Torrance lobes against independent numbers, and the renderer's f32 against f64.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::brdf::{Lobe, LobeGeometry};
use carpaint::fit::{albedo, eval_cook_torrance_set};
use carpaint::math::half_difference::{HalfDifference, directions, spherical};
use serde_json::{Value, json};

/// Largest relative difference of two JSON numbers or lists of them.
fn difference(ours: &Value, theirs: &Value) -> f64 {
    match (ours, theirs) {
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len());
            a.iter().zip(b).map(|(a, b)| difference(a, b)).fold(0.0, f64::max)
        }
        _ => {
            let (a, b) = (ours.as_f64().expect("number"), theirs.as_f64().expect("number"));
            // Below 1e-290 the exponential has lost digits to gradual underflow, ours as theirs.
            let error =
                if b.abs() < 1e-290 { f64::from(u8::from(a.abs() > 1e-289)) } else { (a / b - 1.0).abs() };
            // A maximum does not see it.
            assert!(!error.is_nan(), "{a} {b}");
            error
        }
    }
}

#[test]
fn the_published_lobes_have_the_reference_values() {
    let Some(reference) = common::reference_json("oracles/07_cook_torrance.json") else { return };
    for set in reference["sets"].as_array().expect("sets") {
        let strip = |rows: &Value, keys: &[&str]| -> Value {
            rows.as_array()
                .expect("rows")
                .iter()
                .map(|r| keys.iter().map(|k| (k.to_string(), r[k].clone())).collect::<Value>())
                .collect()
        };
        let input = json!({
            "kd": set["kd"],
            "lobes": set["lobes"],
            "albedo": strip(&set["albedo"], &["theta_i_deg"]),
            "points": strip(&set["points"], &["theta_i", "theta_o", "dphi"]),
        });
        let output = eval_cook_torrance_set(&input).expect("evaluates");
        let mut worst = [0.0f64; 2];
        let rows = |value: &Value, key: &str| value[key].as_array().expect("rows").clone();
        for (ours, theirs) in rows(&output, "points").iter().zip(&rows(set, "points")) {
            for key in ["f_total", "f_lobes", "D", "F", "G"] {
                worst[0] = worst[0].max(difference(&ours[key], &theirs[key]));
            }
        }
        for (ours, theirs) in rows(&output, "albedo").iter().zip(&rows(set, "albedo")) {
            for key in ["albedo_diffuse", "albedo_lobes", "albedo_total"] {
                worst[1] = worst[1].max(difference(&ours[key], &theirs[key]));
            }
        }
        println!("{}: points {:.1e}, albedo {:.1e}", set["name"], worst[0], worst[1]);
        // Closed form on both sides; an exponent of up to 600 multiplies the rounding of the half vector.
        assert!(worst[0] < 1e-12, "{} points: {:e}", set["name"], worst[0]);
        // The reference albedos are good to 4e-8 of the total, as it says itself; small lobes have more relative error.
        assert!(worst[1] < 1e-6, "{} albedo: {:e}", set["name"], worst[1]);
    }
}

#[test]
fn narrow_and_wide_lobes_have_consistent_albedos() {
    // At normal incidence, as roughness goes to 0: the integral of D h_z dh = pi, d wo = 4 (h.i) dh, so the albedo is 4 s F0 (1 + O(roughness^2)).
    for roughness in [1e-3, 3e-3, 1e-2] {
        let lobe = Lobe { coefficient: 0.2, roughness, f0: 0.04 };
        let found = albedo(&lobe, 0.0);
        assert!(
            (found / (4.0 * 0.2 * 0.04) - 1.0).abs() < 3.0 * roughness * roughness + 1e-9,
            "{roughness}: {found}"
        );
    }
}

#[test]
fn inputs_out_of_range_are_named() {
    let good = json!({"kd": 0.1, "lobes": [[0.1, 0.2, 0.3]], "points": [{"theta_i": 0.1, "theta_o": 0.2, "dphi": 3.0}]});
    assert!(eval_cook_torrance_set(&good).is_ok());
    for (pointer, bad, word) in [
        ("/kd", json!("x"), "kd"),
        ("/points/0/theta_i", json!(-1e-9), "points 0: theta_i"),
        ("/points/0/theta_o", json!(std::f64::consts::FRAC_PI_2), "below pi/2"),
        ("/points/0/theta_o", json!(f64::NAN), "points 0: theta_o"),
        ("/lobes/0/1", json!(-0.2), "roughness"),
        ("/lobes/0", json!([1.0, 2.0]), "lobes 0"),
        ("/points/0/dphi", Value::Null, "points 0: dphi"),
    ] {
        let mut set = good.clone();
        *set.pointer_mut(pointer).expect("there") = bad;
        let message = eval_cook_torrance_set(&set).expect_err("refused").to_string();
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn f32_follows_f64_at_the_peak_of_a_gloss_lobe() {
    // tan^2 is handed over rather than recomputed from an f32 cosine. What is left: f32 rounding (6e-8) of tan^2 times
    // the exponent tan^2/alpha^2 <= 9, and a dozen operations.
    let mut worst = 0.0f64;
    for roughness in [0.003, 0.01, 0.1, 0.5] {
        for theta_i in [0.0, 0.4, 0.9, 1.3] {
            for k in 0..=30 {
                let theta_h = (0.1 * f64::from(k) * roughness).atan();
                let (wi, wo) = directions(theta_h, theta_i, 1.0);
                if wi.z < 0.05 || wo.z < 0.05 {
                    continue;
                }
                let wide = LobeGeometry::of(wi, wo);
                let narrow = LobeGeometry {
                    tan2_h: wide.tan2_h as f32,
                    cos_h: wide.cos_h as f32,
                    cos_i: wide.cos_i as f32,
                    cos_o: wide.cos_o as f32,
                    cos_d: wide.cos_d as f32,
                };
                let lobe = Lobe { coefficient: 0.2, roughness, f0: 0.05 };
                let small = Lobe { coefficient: 0.2f32, roughness: roughness as f32, f0: 0.05f32 };
                let (exact, found) = (lobe.eval(&wide), f64::from(small.eval(&narrow)));
                let error = (found / exact - 1.0).abs();
                assert!(!error.is_nan(), "{found} {exact}");
                worst = worst.max(error);
            }
        }
    }
    println!("f32 against f64: {worst:.1e}");
    assert!(worst < 5e-6, "{worst:e}");
}

#[test]
fn lobes_are_reciprocal() {
    let lobe = Lobe { coefficient: 0.2, roughness: 0.3, f0: 0.1 };
    for (a, b, phi) in [(0.1, 1.2, 0.4), (0.7, 0.7, 2.0), (1.5, 0.2, 3.1)] {
        let (wi, wo) = (spherical(a, 0.0), spherical(b, phi));
        let (there, back) = (lobe.eval(&LobeGeometry::of(wi, wo)), lobe.eval(&LobeGeometry::of(wo, wi)));
        assert!((there / back - 1.0).abs() < 1e-13);
        assert!((HalfDifference::of(wi, wo).theta_i - HalfDifference::of(wo, wi).theta_i).abs() < 1e-15);
    }
}
