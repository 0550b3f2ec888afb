//! `carpaint fit` of measurements as a program: what each option does, what is refused, and bad data of every kind.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::Paint;
use carpaint::brdf::cook_torrance::brightness;
use carpaint::brdf::instrument::Reading;
use carpaint::brdf::{ClearCoat, Lobe, LobeGeometry, TabulatedBrdf};
use carpaint::math::hash::{pcg4d, unit};
use folder::Folder;
use glam::DVec3;

/// Cells of the small tables: polar angles and azimuths.
const CELLS: [usize; 2] = [14, 20];
const DIFFUSE: f64 = 0.03;
const WIDE: Lobe = Lobe { coefficient: 0.08, roughness: 0.5, f0: 0.4 };
const NARROW: Lobe = Lobe { coefficient: 0.1, roughness: 0.2, f0: 0.6 };

fn fits() -> Folder {
    Folder::new(&["fit", "-o", "x.paint.exr"])
}

/// Writes a table of a BRDF.
fn table(f: &Folder, name: &str, brdf: impl Fn(DVec3, DVec3) -> DVec3 + Sync) {
    TabulatedBrdf::from_fn(CELLS[0], CELLS[1], brdf).unwrap().write_mbsdf(&f.path(name)).unwrap();
}

fn write(f: &Folder, name: &str, text: &str) {
    std::fs::write(f.path(name), text).unwrap();
}

fn fitted(f: &Folder, arguments: &[&str]) -> serde_json::Value {
    f.json(&[arguments, &["--json"]].concat())
}

/// Two colorless lobes and a diffuse term.
fn gray(wi: DVec3, wo: DVec3) -> DVec3 {
    DVec3::splat(brightness(DIFFUSE, &[WIDE, NARROW], &LobeGeometry::of(wi, wo)))
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

#[test]
fn every_optimizer_gives_the_lobes_back() {
    let f = fits();
    table(&f, "gray.mbsdf", gray);
    for optimizer in ["sr1", "levenberg-marquardt", "trust-region-reflective"] {
        let report = fitted(&f, &["gray.mbsdf", "--lobes", "2", "--starts", "4", "--optimizer", optimizer]);
        assert_eq!(report["options"]["optimizer"], optimizer);
        // Exact but for 32-bit cells; the knee of the starts rounds off what is below it, and SR1 stops in the kinks of eq. 7.
        assert!(number(&report["error"]) < 2e-3, "{optimizer}: {}", report["error"]);
        for (lobe, truth) in report["lobes"].as_array().unwrap().iter().zip([WIDE, NARROW]) {
            let roughness = number(&lobe["roughness"]) / truth.roughness;
            assert!((roughness - 1.0).abs() < 0.02, "{optimizer}: {lobe}");
        }
        let paint = Paint::read(&f.path("x.paint.exr")).unwrap();
        assert_eq!(paint.lobes.len(), 2);
        assert!(paint.flakes.is_none() && paint.coat == ClearCoat::NONE);
    }
}

#[test]
fn as_many_lobes_are_taken_as_noisy_data_ask_for() {
    let f = fits();
    // Noise of 5 %, reciprocal or not: every cell its own.
    let noise = |w: DVec3, v: DVec3| {
        let bits = |x: f64| x.to_bits() as u32 ^ (x.to_bits() >> 32) as u32;
        let draw = pcg4d([bits(w.x), bits(v.x), bits(v.y), 7]);
        1.0 + 0.05 * (f64::from(unit(draw[0])) + f64::from(unit(draw[1])) - 1.0) * 6f64.sqrt()
    };
    table(&f, "one.mbsdf", |wi, wo| {
        DVec3::splat(brightness(DIFFUSE, &[WIDE], &LobeGeometry::of(wi, wo)) * noise(wi, wo))
    });
    table(&f, "two.mbsdf", |wi, wo| gray(wi, wo) * noise(wi, wo));
    for (table, truth) in [("one.mbsdf", 1), ("two.mbsdf", 2)] {
        let report = fitted(&f, &[table, "--lobes", "auto", "--starts", "3"]);
        assert_eq!(report["lobes"].as_array().unwrap().len(), truth, "{}", report["choices"]);
        let choices = report["choices"].as_array().unwrap();
        let tried: Vec<_> = choices.iter().map(|c| c["lobes"].as_u64().unwrap()).collect();
        assert_eq!(tried, [3, 2, 1]);
        let least = choices.iter().min_by(|a, b| number(&a["criterion"]).total_cmp(&number(&b["criterion"])));
        assert_eq!(least.unwrap()["lobes"], truth as u64);
    }
    let said = f.succeed(&["two.mbsdf", "--lobes", "auto", "--starts", "3"]);
    assert!(said.contains("lobes tried") && said.contains("taken 2"), "{said}");
}

#[test]
fn a_refracting_coat_is_held_against_a_straight_one() {
    let f = fits();
    let coat = ClearCoat::ideal(1.5, true);
    table(&f, "coated.mbsdf", |wi, wo| gray(coat.inner(wi), coat.inner(wo)) * coat.transmittance(wi.z, wo.z));
    let coated = ["coated.mbsdf", "--lobes", "2", "--ior", "1.5"];
    let report = fitted(&f, &[&coated[..], &["--refract"]].concat());
    let straight = &report["without_refraction"];
    // The one is the truth; light that goes straight on sees other angles of the flakes.
    assert!(number(&report["error"]) < 1e-3, "{}", report["error"]);
    assert!(number(&straight["error"]) > 10.0 * number(&report["error"]), "{straight}");
    assert_eq!(Paint::read(&f.path("x.paint.exr")).unwrap().coat, coat);
    let said = f.succeed(&[&coated[..], &["--refract"]].concat());
    assert!(said.contains("\nrefracted ") && said.contains("\nstraight "), "{said}");
    // Without the option nothing refracts, and the errors are those of the comparison.
    let report = fitted(&f, &coated);
    assert!(report["without_refraction"].is_null());
    assert_eq!(report["error"], straight["error"]);
    assert_eq!(Paint::read(&f.path("x.paint.exr")).unwrap().coat, ClearCoat::ideal(1.5, false));
}

#[test]
fn the_drawing_holds_data_and_fit() {
    let f = fits();
    table(&f, "a<b>&c.mbsdf", |wi, wo| {
        let dim = gray(wi, wo) * 1e-7;
        // A table's negative cells lie on the edge.
        if wi.z > 0.98 { -dim } else { dim }
    });
    write(
        &f,
        "readings.csv",
        "geometry,R,G,B\n45as15,0.9,0.8,0.7\n45as45,0.3,0.3,0.2\n45as110,0.1,0.1,0.1\n",
    );
    for (input, points) in [("a<b>&c.mbsdf", CELLS[0] * CELLS[0] * CELLS[1]), ("readings.csv", 3)] {
        let arguments = [input, "--lobes", "1", "--svg", "fit.svg"];
        f.succeed(&arguments);
        let text = std::fs::read_to_string(f.path("fit.svg")).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        assert_eq!(root.tag_name().name(), "svg");
        let words: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
        let title = input.split('.').next().unwrap();
        for word in [title, "data", "fit", "1/sr", "angle between half vector and normal", "90°", "mean |ln"]
        {
            assert!(words.iter().any(|text| text.contains(word)), "{input}: no {word}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"), "{input}");
        // Numbers of an axis are short enough for the room left of it.
        assert!(words.iter().all(|word| word.len() < 8 || word.parse::<f64>().is_err()), "{words:?}");
        let circles: Vec<_> = document.descendants().filter(|node| node.has_tag_name("circle")).collect();
        // One each in the legend; at most 3,000 are drawn.
        assert_eq!(circles.len(), 2 * (points.min(3000) + 1), "{input}");
        let size = |name: &str| root.attribute(name).unwrap().parse::<f64>().unwrap();
        let inside = |node: &roxmltree::Node, name: &str, most: f64| {
            (0.0..=most).contains(&node.attribute(name).unwrap().parse::<f64>().unwrap())
        };
        assert!(circles.iter().all(|c| inside(c, "cx", size("width")) && inside(c, "cy", size("height"))));
        f.succeed(&arguments);
        assert_eq!(std::fs::read_to_string(f.path("fit.svg")).unwrap(), text, "the same drawing again");
    }
}

#[test]
fn wrong_values_are_named_with_what_is_legal() {
    let f = fits();
    table(&f, "gray.mbsdf", gray);
    let cases: &[(&[&str], &[&str])] = &[
        (&["--lobes", "0"], &["lobes", "found 0", "1 to 3"]),
        (&["--lobes", "4"], &["lobes", "found 4", "1 to 3"]),
        (&["--lobes", "many"], &["--lobes", "many", "1 to 3, or auto"]),
        (&["--optimizer", "newton"], &["newton", "sr1, levenberg-marquardt, trust-region-reflective"]),
        (&["--starts", "0"], &["starts", "found 0", "1 to 1000"]),
        (&["--starts", "1001"], &["starts", "found 1001", "1 to 1000"]),
        (&["--seed", "-1"], &["--seed", "-1"]),
        (&["--refract"], &["--ior"]),
        (&["--ior", "0.5"], &["ior", "found 0.5"]),
        (&["--ior", "-1.5", "--refract"], &["ior", "found -1.5"]),
        (&["--ior", "nan"], &["ior", "found NaN"]),
        (&["--svg", "fit.png"], &["--svg", "fit.png", ".svg"]),
        (&["--svg", "none/fit.svg"], &["none"]),
        (&["--btf", "a.btf.exr"], &["--btf", "a capture folder"]),
        (&["--sha256", "none.txt"], &["none.txt"]),
    ];
    for (arguments, words) in cases {
        f.fail(&[&["gray.mbsdf"], *arguments].concat(), words);
    }
}

#[test]
fn bad_tables_are_refused_or_warned_of() {
    let f = fits();
    table(&f, "black.mbsdf", |_, _| DVec3::ZERO);
    f.fail(&["black.mbsdf"], &["found no positive intensity", "light in at least one"]);
    table(&f, "below.mbsdf", |wi, wo| -gray(wi, wo));
    f.fail(&["below.mbsdf"], &["found no positive intensity"]);
    table(&f, "gray.mbsdf", gray);
    let good = std::fs::read(f.path("gray.mbsdf")).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let at = good.len() - 4 * 3 * 5;
        let bytes = [&good[..at], &bad.to_le_bytes(), &good[at + 4..]].concat();
        std::fs::write(f.path("nan.mbsdf"), bytes).unwrap();
        f.fail(&["nan.mbsdf"], &["nan.mbsdf", "theta_in 13, theta_out 13, phi 15"]);
    }

    let [_, warnings] = f.succeed_with_warnings(&["gray.mbsdf", "--lobes", "1"]);
    assert!(!warnings.contains("warning"), "{warnings}");
    table(&f, "lopsided.mbsdf", |wi, wo| if wi.z < wo.z { 3.0 * gray(wi, wo) } else { gray(wi, wo) });
    let [_, warnings] = f.succeed_with_warnings(&["lopsided.mbsdf", "--lobes", "1"]);
    // Of 3 and 1 the difference is 2, the mean 2.
    assert!(
        warnings.contains("not reciprocal: with light and eye exchanged values differ by 100 %"),
        "{warnings}"
    );
    table(&f, "spotted.mbsdf", |wi, wo| gray(wi, wo) - DVec3::X * if wi.z > 0.99 { 1.0 } else { 0.0 });
    let [_, warnings] = f.succeed_with_warnings(&["spotted.mbsdf", "--lobes", "1"]);
    let first_row = CELLS[0] * CELLS[1];
    let words = format!("{first_row} of {} samples have a negative band", CELLS[0] * first_row);
    assert!(warnings.contains(&words), "{warnings}");
}

#[test]
fn readings_below_the_horizon_or_without_a_number_are_refused() {
    let f = fits();
    let head = "incidence,aspecular,R,G,B\n45,15,0.9,0.8,0.7\n";
    for (row, words) in [
        ("45,140,0.1,0.1,0.1", ["line 3", "aspecular angle", "found 140"]),
        ("45,-45,0.1,0.1,0.1", ["line 3", "aspecular angle", "above -45 and below 135"]),
        ("90,45,0.1,0.1,0.1", ["line 3", "incidence", "found 90"]),
        ("45,45,0.1,nan,0.1", ["line 3", "column 4", "found \"nan\""]),
        ("45,45,0.1,0.1", ["line 3", "4", "5"]),
    ] {
        write(&f, "readings.csv", &format!("{head}{row}\n"));
        f.fail(&["readings.csv"], &[&["readings.csv"], &words[..]].concat());
    }
    write(&f, "readings.csv", "incidence,aspecular,R,G,B\n");
    f.fail(&["readings.csv"], &["readings.csv", "usable samples"]);
    write(&f, "readings.csv", "incidence,aspecular,R,G,B\n45,15,0,0,0\n");
    f.fail(&["readings.csv"], &["no positive intensity"]);
}

#[test]
fn readings_of_an_instrument_are_met_to_less_than_an_eye_sees() {
    let f = fits();
    let mut text = "incidence,aspecular,R,G,B\n".to_owned();
    for aspecular in [-15.0, 15.0, 25.0, 45.0, 75.0, 110.0] {
        let (wi, wo) = Reading::new(45.0, aspecular).unwrap().directions();
        let [r, g, b] = (std::f64::consts::PI * gray(wi, wo) * DVec3::new(0.8, 1.0, 1.2)).to_array();
        text += &format!("45,{aspecular},{r},{g},{b}\n");
    }
    write(&f, "readings.csv", &text);
    let report = fitted(&f, &["readings.csv", "--lobes", "2"]);
    let angles = report["aspecular"].as_array().unwrap();
    assert_eq!(angles.len(), 6);
    for angle in angles {
        // Two lobes and a diffuse term pass through six readings of such, and each has texels of its own in the color table.
        assert!(number(&angle["delta_e_2000"]) < 0.5, "{angle}");
    }
}
