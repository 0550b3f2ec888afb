//! `carpaint simulate` as a program: every output, and every refusal.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::Paint;
use carpaint::brdf::TabulatedBrdf;
use carpaint::color::{BANDS, lab_from_rgb};
use carpaint::math::half_difference::spherical;
use carpaint::simulate::{Composition, Model, ModelOptions, Reading, flop_index};
use folder::Folder;
use serde_json::Value;
use std::f64::consts::PI;

const BLUE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/blue_metallic.toml");
const SILVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/silver_metallic.toml");

fn simulations() -> Folder {
    Folder::new(&["simulate"])
}

fn model(path: &str) -> Model {
    Model::new(&Composition::read(path.as_ref()).unwrap(), ModelOptions::default()).unwrap()
}

#[test]
fn instruments_read_what_the_model_says() {
    let f = simulations();
    let printed = f.json(&[BLUE, "--json", "--at", "45:-15,15,25,45,75,110;15:15"]);
    let (model, readings) = (model(BLUE), printed["at"]["readings"].as_array().unwrap());
    let asked = Reading::parse_list("45:-15,15,25,45,75,110;15:15").unwrap();
    assert_eq!(readings.len(), asked.len());
    let mut lightness = Vec::new();
    for (row, reading) in readings.iter().zip(asked) {
        let (wi, wo) = reading.directions();
        let spectrum: Vec<f64> =
            row["spectrum"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let expected = model.brdf(wi, wo).0.map(|v| PI * v);
        assert_eq!(spectrum, expected);
        let lab: [f64; 3] = serde_json::from_value(row["lab"].clone()).unwrap();
        let difference = lab_from_rgb(PI * model.brdf_rgb(wi, wo)) - glam(lab);
        // A product in another order.
        assert!(difference.length() < 1e-9, "{lab:?}");
        lightness.push(lab[0]);
    }
    let flop = flop_index([lightness[1], lightness[3], lightness[5]]).unwrap();
    assert_eq!(printed["at"]["flop_index"], flop);
    assert_eq!(printed["at"]["wavelengths_nm"].as_array().unwrap().len(), BANDS);
    // 45 degrees onto index 1.5: the textbook's 5 %.
    let surface = printed["at"]["readings"][0]["surface_reflectance"].as_f64().unwrap();
    assert!((surface - 0.0502).abs() < 1e-4, "{surface}");
    // For people: the row of fixtures/README.md.
    let text = f.succeed(&[BLUE, "--at", "45:15,45,110"]);
    assert!(text.contains("68.92     8.83   -52.05") && text.contains("flop index"), "{text}");
    // Without its three angles there is no flop index.
    assert!(f.json(&[BLUE, "--json", "--at", "45:15,45"])["at"]["flop_index"].is_null());
}

#[test]
fn rough_surfaces_gleam_and_crowded_films_are_noted() {
    let f = simulations();
    let text = std::fs::read_to_string(BLUE).unwrap();
    std::fs::write(f.path("rough.toml"), format!("{text}\n[surface]\nroughness_deg = 4\n")).unwrap();
    let gloss = |arguments: &[&str]| {
        let printed = f.json(&[arguments, &["--json", "--at", "45:0,15"]].concat());
        [0, 1].map(|k| printed["at"]["readings"][k]["gloss"].as_f64().unwrap())
    };
    // A mirror's gloss is in no direction but its own, where it is no number.
    assert_eq!(gloss(&[BLUE]), [0.0; 2]);
    let [peak, side] = gloss(&["rough.toml"]);
    let law = carpaint::simulate::models::gloss::Gloss::new(1.5, 4f64.to_radians()).unwrap();
    let expected = [0.0, 15.0].map(|deg| {
        let (wi, wo) = Reading::new(45.0, deg).unwrap().directions();
        PI * law.brdf(wi, wo)
    });
    assert_eq!([peak, side], expected);
    assert!(peak > 1.0 && side < 0.01 * peak, "{peak} {side}");
    assert!(f.succeed(&["rough.toml", "--at", "45:0"]).contains(&format!("{peak:.4}")));

    let crowded = text.replace("area_density = 0.5", "area_density = 9");
    std::fs::write(f.path("crowded.toml"), crowded).unwrap();
    let out = f.run(&["crowded.toml", "--json", "--at", "45:15"]);
    let printed: Value = serde_json::from_slice(&out.stdout).unwrap();
    let note = printed["warnings"][0].as_str().unwrap();
    assert!(note.contains("film[0]") && String::from_utf8_lossy(&out.stderr).contains(note), "{note}");
    assert!(f.json(&[SILVER, "--json", "--at", "45:15"])["warnings"].as_array().unwrap().is_empty());
}

fn glam(v: [f64; 3]) -> glam::DVec3 {
    v.into()
}

#[test]
fn spectra_come_as_csv() {
    let f = simulations();
    f.succeed(&[BLUE, "--brdf", "blue.csv"]);
    let (model, text) = (model(BLUE), std::fs::read_to_string(f.path("blue.csv")).unwrap());
    let (header, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let header = header.concat();
    for word in ["1/sr", "cosine_included=false", "gloss_included=false", "degrees", "mirror"] {
        assert!(header.contains(word), "{header}");
    }
    let names: Vec<&str> = rows[0].split(',').collect();
    assert_eq!(names[..4], ["theta_i", "theta_o", "phi", "380"]);
    assert_eq!((names.len(), names[names.len() - 1]), (3 + BANDS, "780"));
    assert_eq!(rows.len() - 1, 18 * 18 * 19);
    for row in rows[1..].iter().step_by(97) {
        let values: Vec<f64> = row.split(',').map(|v| v.parse().unwrap()).collect();
        let [theta_i, theta_o, phi] = [0, 1, 2].map(|k| values[k].to_radians());
        let exact = model.brdf(spherical(theta_i, 0.0), spherical(theta_o, phi));
        for (printed, exact) in values[3..].iter().zip(exact.0) {
            // Seven digits.
            assert!((printed - exact).abs() <= 6e-7 * exact, "{row}");
        }
    }
}

#[test]
fn tables_and_paints_are_what_other_commands_read() {
    let f = simulations();
    let summary = f.json(&[SILVER, "--brdf", "s.mbsdf", "--brdf", "S.Paint.EXR", "--json", "--seed", "3"]);
    assert_eq!(summary["brdf"], serde_json::json!(["s.mbsdf", "S.Paint.EXR"]));
    let table = TabulatedBrdf::read_mbsdf(&f.path("s.mbsdf")).unwrap();
    assert_eq!(table.resolution(), [45, 90]);
    let model = model(SILVER);
    for (i, o, a) in [(0, 0, 0), (20, 22, 89), (44, 3, 40)] {
        let (wi, wo) = table.directions(i, o, a);
        // The table holds f32.
        assert!((table.cell(i, o, a) / model.brdf_rgb(wi, wo) - 1.0).abs().max_element() < 1e-7);
    }
    // Written again it has the same bytes.
    table.write_mbsdf(&f.path("again.mbsdf")).unwrap();
    assert!(std::fs::read(f.path("s.mbsdf")).unwrap() == std::fs::read(f.path("again.mbsdf")).unwrap());
    let paint = Paint::read(&f.path("S.Paint.EXR")).unwrap();
    assert!(paint.flakes.is_none() && paint.coat.ior == 1.5);
    let fit = carpaint::fit::SmoothFit::from(&paint);
    for aspecular in [15.0, 25.0, 45.0, 75.0, 110.0] {
        let (wi, wo) = Reading::new(45.0, aspecular).unwrap().directions();
        let [a, b] = [fit.eval(wi, wo), model.brdf_rgb(wi, wo)].map(|f| lab_from_rgb(PI * f));
        // What `validate` allows the fit of a preset.
        assert!(carpaint::color::delta_e_2000(a, b) < 0.5, "{aspecular}: {a} {b}");
    }
}

#[test]
fn the_drawing_is_one_of_layers_and_flop() {
    let f = simulations();
    let text = std::fs::read_to_string(BLUE).unwrap();
    let title = text.replace("title = \"blue metallic\"", r#"title = "a<b> & \"c\" \u0001 \u00df""#);
    // No flakes, no thickness; nothing of a title.
    let bare = "substrate = { albedo = 0.5 }\nfilm = [{ thickness_um = 0, index = 1.5 }]\n";
    let thick =
        "title = \"thick\"\nsubstrate = { albedo = 0 }\nfilm = [{ thickness_um = 1000, index = 1 }]\n";
    for (name, recipe, shown) in [
        ("blue", &text[..], "blue metallic"),
        ("title", &title, "a<b> & \"c\"   \u{df}"),
        ("bare", bare, "paint"),
        ("thick", thick, "thick"),
    ] {
        let (toml, svg) = (format!("{name}.toml"), format!("{name}.svg"));
        std::fs::write(f.path(&toml), recipe).unwrap();
        f.succeed(&[&toml, "--svg", &svg]);
        let text = std::fs::read_to_string(f.path(&svg)).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "svg");
        let words: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
        assert_eq!(words.iter().find(|word| !word.trim().is_empty()), Some(&shown));
        for word in ["film", "substrate", "flop"] {
            assert!(words.iter().any(|text| text.contains(word)), "{name}: {word}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
        let count = |tag: &str| document.descendants().filter(|node| node.has_tag_name(tag)).count();
        // Five readings; the curve and the lines to the words.
        assert!(count("circle") >= 5 && count("polyline") >= 2, "{name}");
        // The same drawing again.
        f.succeed(&[&toml, "--svg", "again.svg"]);
        assert_eq!(std::fs::read_to_string(f.path("again.svg")).unwrap(), text);
    }
}

#[test]
fn the_summary_says_what_a_btf_cost_and_how_good_it_is() {
    let f = simulations();
    let small = ["--bins", "4", "--rows", "4,2", "--size", "32", "--texel-um", "20"];
    let arguments = [&[BLUE, "-o", "b.btf.exr", "--json", "--parallax"], &small[..]].concat();
    let summary = f.json(&arguments);
    assert_eq!(summary["slices"], 6);
    assert_eq!(summary["model"], "full");
    assert_eq!(summary["bytes"], std::fs::metadata(f.path("b.btf.exr")).unwrap().len());
    assert_eq!(summary["check"]["phi_d"]["rows"].as_array().unwrap().len(), 4);
    assert_eq!(summary["check"]["parallax"]["rows"].as_array().unwrap().len(), 2);
    assert!(summary["btf_seconds"].as_f64().unwrap() <= summary["seconds"].as_f64().unwrap());
    if cfg!(target_os = "linux") {
        assert!(summary["peak_mib"].as_f64().unwrap() > 1.0);
    }
    // The same file from the same seed, on any number of threads.
    let first = std::fs::read(f.path("b.btf.exr")).unwrap();
    for (threads, seed, same) in [("1", "1", true), ("3", "1", true), ("2", "2", false)] {
        let out = common::carpaint()
            .current_dir(f.path(""))
            .env("RAYON_NUM_THREADS", threads)
            .arg("simulate")
            .args(&arguments)
            .args(["--seed", seed])
            .output()
            .unwrap();
        assert!(out.status.success());
        assert_eq!(std::fs::read(f.path("b.btf.exr")).unwrap() == first, same, "{threads} {seed}");
    }
    // For people, with the tables.
    let text = f.succeed(&[&[BLUE, "-o", "b.btf.exr", "--verbose", "--parallax"], &small[..]].concat());
    for word in ["6 slices of 32 x 32", "rms z", "theta_h", "parallax", "theta_i"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn the_full_model_keeps_account_of_all_light() {
    let f = simulations();
    let printed = f.json(&[BLUE, "--model", "full", "--tolerance", "0.05", "--energy=30", "--json"]);
    assert_eq!((&printed["model"], &printed["energy"]["incidence_deg"]), (&"full".into(), &30.0.into()));
    let share = |key: &str, k: usize| printed["energy"][key][k].as_f64().unwrap();
    for k in 0..BANDS {
        let sum = ["reflected", "to_substrate", "absorbed"].map(|key| share(key, k)).iter().sum::<f64>();
        // What is absorbed is the rest: rounding.
        assert!((sum + printed["energy"]["gloss"].as_f64().unwrap() - 1.0).abs() < 1e-12, "{k}");
        assert!(share("reflected", k) > 0.0 && share("to_substrate", k) > 0.0 && share("absorbed", k) > 0.0);
    }
    f.fail(&[BLUE, "--model", "fast", "--energy"], &["full"]);
}

#[test]
fn bad_requests_are_refused_before_work() {
    let f = simulations();
    std::fs::create_dir(f.path("folder.csv")).unwrap();
    std::fs::copy(BLUE, f.path("recipe.csv")).unwrap();
    for (arguments, word) in [
        (&[BLUE][..], "--output, --brdf, --at, --spectra, --energy, --svg"),
        (&[BLUE, "--at", "45"], "--at: group: found \"45\""),
        (&[BLUE, "--at", ""], "--at"),
        (&[BLUE, "--at", "45:15,x"], "\"x\""),
        (&[BLUE, "--at", "-5:15"], "incidence"),
        (&[BLUE, "--at", "45:200"], "below 135"),
        (&[BLUE, "--brdf", "x.exr"], ".csv, .mbsdf or .paint.exr"),
        (&[BLUE, "--brdf", "x.csv", "--brdf", "./x.csv"], "named twice"),
        (&[BLUE, "-o", "x.exr"], "ends in .btf.exr"),
        (&[BLUE, "--svg", "x.toml"], "ends in .svg"),
        (&["recipe.csv", "--brdf", "./recipe.csv"], "place of the recipe"),
        (&["none.toml", "--model", "fast", "--energy"], "--energy: --model: found fast"),
        (&[BLUE, "--energy=90"], "below 90"),
        (&[BLUE, "--energy=x"], "invalid value"),
        (&[BLUE, "--svg", "x.svg", "--tolerance", "0"], "tolerance: found 0"),
        (&[BLUE, "--svg", "x.svg", "--model", "slow"], "fast-corrected"),
        (&[BLUE, "--svg", "x.svg", "--parallax"], "--output"),
        (&[BLUE, "-o", "x.btf.exr", "--bins", "4", "--rows", "5"], "--rows"),
        (&["none.toml", "--svg", "x.svg"], "none.toml"),
        // The composition does not exist: had any work begun, the message would be about it.
        (&["none.toml", "--svg", "no/such/x.svg"], "no/such/x.svg"),
        (&["none.toml", "--brdf", "folder.csv"], "a folder"),
        (&["none.toml", "-o", "no/x.btf.exr", "--at", "45:15"], "no/x.btf.exr"),
    ] {
        f.fail(arguments, &[word]);
    }
}
