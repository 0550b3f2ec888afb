//! Goniochromatic inks as files and programs: spectra to an ink, an ink to a paint, and every refusal.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::brdf::instrument::Reading;
use carpaint::brdf::{Bands, BrdfSample, Ink, LobeGeometry, SampleSet, multi_angle_text};
use carpaint::color::Wavelengths;
use carpaint::paint::Paint;
use folder::Folder;
use std::f64::consts::PI;
use std::path::Path;

const INCIDENCES: [f64; 7] = [20.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0];

fn ink() -> Ink {
    let grid = Wavelengths::even(21).unwrap();
    let wave = |k: usize, a: f64| (0.3 * k as f64 + a).sin();
    let rho = (0..21).map(|k| 0.5 + 0.45 * wave(k, 0.3)).collect();
    let c = (0..21).map(|k| 2.5 + 3.5 * wave(k, 2.0)).collect();
    Ink::new("truth", 0.19, grid, rho, c).unwrap()
}

/// In-plane spectra of an ink as a table, every value times what `off` says of incidence and row.
fn spectra(ink: &Ink, off: impl Fn(f64, usize) -> f64) -> String {
    let mut set = SampleSet::new(Bands::Wavelengths(ink.wavelengths().nm().to_vec())).unwrap();
    for incidence in INCIDENCES {
        for aspecular in -8..=30 {
            let Ok(reading) = Reading::new(incidence, 2.5 * f64::from(aspecular)) else { continue };
            let (wi, wo) = reading.directions();
            let factor = off(incidence, set.len());
            let values: Vec<f64> = ink.brdf(&LobeGeometry::of(wi, wo)).iter().map(|f| f * factor).collect();
            set.push(BrdfSample::new(wi, wo, 1.0), &values).unwrap();
        }
    }
    multi_angle_text(&set, "made by a test").unwrap()
}

fn write(folder: &Folder, name: &str, text: &str) {
    std::fs::write(folder.path(name), text).unwrap();
}

#[test]
fn spectra_give_back_the_ink() {
    let f = Folder::new(&["fit"]);
    let truth = ink();
    write(&f, "red.csv", &spectra(&truth, |_, _| 1.0));
    let said = f.json(&["red.csv", "-o", "red.ink.json", "--json"]);
    let found = Ink::read(&f.path("red.ink.json")).unwrap();
    assert_eq!(found.name(), "red");
    // Files have twelve digits and more; the fit adds nothing to speak of.
    assert!((found.roughness() / 0.19 - 1.0).abs() < 1e-8);
    for band in 0..21 {
        let (a, b) = (found.at(band), truth.at(band));
        assert!((a.reflectance / b.reflectance - 1.0).abs() < 1e-8 && (a.growth - b.growth).abs() < 1e-8);
        assert_eq!(said["bands"][band]["rho"], a.reflectance);
    }
    assert!(said["error"].as_f64().unwrap() < 1e-8 && said["alpha_spread"].as_f64().unwrap() < 1e-8);
    assert_eq!(said["incidences"].as_array().unwrap().len(), 7);
    assert!(
        f.succeed(&["red.csv", "-o", "b.ink.json"]).contains("alpha 0.19000, spread over incidences 0.00 %")
    );
}

/// Readings in any unit over those of a white reference of 99 %; one incidence spoilt and left out.
#[test]
fn white_is_divided_out_and_incidences_are_left_out() {
    let f = Folder::new(&["fit"]);
    let truth = ink();
    let lamp = |incidence: f64| 40.0 + incidence;
    let spoilt = |incidence: f64| if incidence == 70.0 { 1.5 } else { 1.0 };
    write(&f, "raw.csv", &spectra(&truth, |incidence, _| lamp(incidence) * spoilt(incidence)));
    let header: String = truth.wavelengths().nm().iter().map(|nm| format!(",{nm}")).collect();
    let row = |incidence: &f64| {
        let cell = format!(",{}", 0.99 * lamp(*incidence));
        format!("{incidence},0{}\n", cell.repeat(21))
    };
    let white: String = INCIDENCES.iter().map(row).collect();
    write(&f, "white.csv", &format!("theta_i,theta_o{header}\n{white}"));
    f.succeed(&["raw.csv", "-o", "ink.ink.json", "--white", "white.csv", "--leave-out", "70"]);
    let found = Ink::read(&f.path("ink.ink.json")).unwrap();
    for band in 0..21 {
        assert!((found.at(band).reflectance / truth.at(band).reflectance - 1.0).abs() < 1e-8);
    }
    f.succeed(&[
        "raw.csv",
        "-o",
        "half.ink.json",
        "--white",
        "white.csv",
        "--white-reflectance",
        "0.495",
        "--leave-out",
        "70",
    ]);
    let half = Ink::read(&f.path("half.ink.json")).unwrap();
    assert!((half.at(3).reflectance / truth.at(3).reflectance - 0.5).abs() < 1e-8);
    f.fail(
        &["raw.csv", "-o", "x.ink.json", "--leave-out", "71"],
        &["raw.csv", "incidence to leave out: found 71"],
    );
    write(&f, "one.csv", &format!("theta_i,theta_o{header}\n{}", row(&20.0)));
    f.fail(
        &["raw.csv", "-o", "x.ink.json", "--white", "one.csv"],
        &["one.csv", "reading of white: found none"],
    );
}

/// Ten repeats with one percent of noise: the truth lies within the intervals, about as often as they promise.
#[test]
fn intervals_of_noisy_repeats_hold_the_truth() {
    use carpaint::math::hash::{pcg4d, unit};
    let f = Folder::new(&["fit"]);
    let truth = ink();
    // One table after the other: rows of the same geometry are repeats.
    let noise = |repeat: u32, row: usize| {
        let uniform = (0..3).flat_map(|j| pcg4d([repeat, row as u32, j, 9])).map(|b| f64::from(unit(b)));
        1.0 + 0.01 * (uniform.sum::<f64>() - 6.0)
    };
    let mut text = spectra(&truth, |_, row| noise(0, row));
    for repeat in 1..10 {
        let table = spectra(&truth, |_, row| noise(repeat, row));
        let rows = table.lines().skip_while(|line| !line.starts_with(char::is_numeric));
        text.extend(rows.flat_map(|line| [line, "\n"]));
    }
    write(&f, "noisy.csv", &text);
    let said = f.json(&["noisy.csv", "-o", "noisy.ink.json", "--json"]);
    // Of the mean of ten; the same at all wavelengths of a reading, so that the noise is known from five numbers: to a factor of 2.
    let noise = said["noise"].as_f64().unwrap() / (0.01 / 10f64.sqrt());
    assert!((0.4..2.0).contains(&noise), "{noise}");
    let holds = |interval: &serde_json::Value, value: f64| {
        let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
        low <= value && value <= high
    };
    assert!(holds(&said["alpha_interval"], 0.19), "{}", said["alpha_interval"]);
    let all = said["bands"].as_array().unwrap().iter().enumerate();
    let held = all.filter(|(k, band)| holds(&band["c_interval"], truth.growth()[*k])).count();
    // All wavelengths are off together: all or none of them may be out.
    assert!(held == 21, "{held}");
}

#[test]
fn an_ink_becomes_a_paint_that_mixes() {
    let f = Folder::new(&[]);
    let names = ["red", "green"];
    for (k, name) in names.iter().enumerate() {
        let wave = |band: usize| (-((band as f64 - 14.0 + 6.0 * k as f64) / 3.0).powi(2)).exp();
        let grid = Wavelengths::even(21).unwrap();
        let rho = (0..21).map(|band| 0.05 + 0.4 * wave(band)).collect();
        let c = (0..21).map(|band| 2.0 - wave(band)).collect();
        let ink = Ink::new(*name, 0.35, grid, rho, c).unwrap();
        ink.write(&f.path(&format!("{name}.ink.json"))).unwrap();
        let [said, warned] = f.succeed_with_warnings(&[
            "fit",
            &format!("{name}.ink.json"),
            "-o",
            &format!("{name}.paint.exr"),
            "--starts",
            "2",
            "--json",
        ]);
        assert!(warned.contains("exact under D65, under illuminant A off by"), "{warned}");
        let report: serde_json::Value = serde_json::from_str(&said).unwrap();
        // The table has two angles, the ink three: 95 % of the cells stay near.
        let error = report["delta_e_2000"]["mean"].as_f64().unwrap();
        assert!(error < 2.0, "{name}: {error}");
        let paint = Paint::read(&f.path(&format!("{name}.paint.exr"))).unwrap();
        assert_eq!(paint.provenance["source"]["ink"], *name, "{}", paint.provenance);
    }
    f.succeed(&["couple", "red.paint.exr", "green.paint.exr", "-o", "mix.paint.exr"]);
    f.succeed(&["blend", "mix.paint.exr", "--weights", "0.5,0.5", "-o", "half.paint.exr"]);
    let inspected = f.json(&["inspect", "red.ink.json", "--json"]);
    assert_eq!((&inspected["name"], &inspected["wavelengths"]), (&"red".into(), &21.into()));
    f.fail(&["fit", "red.ink.json", "-o", "x.paint.exr", "--ior", "1.5"], &["--ior", "an ink has no coat"]);
}

#[test]
fn what_is_no_ink_and_no_spectra_is_refused() {
    let f = Folder::new(&["fit"]);
    let good = spectra(&ink(), |_, _| 1.0);
    write(&f, "good.csv", &good);
    for (name, text, words) in [
        ("order.csv", good.replacen(",380,400,", ",400,380,", 1), &["wavelength"][..]),
        ("um.csv", good.replacen(",380,400,", ",0.38,0.4,", 1), &["nanometre"]),
        ("rgb.csv", "theta_i,theta_o,R,G,B\n20,20,1,1,1\n".into(), &["spectra"]),
        (
            "one.csv",
            "theta_i,theta_o,400,700\n20,20,1,1\n20,21,1,1\n20,22,1,1\n".into(),
            &["angles of incidence: found 1"],
        ),
        (
            "dark.csv",
            "theta_i,theta_o,400,700\n20,20,-1,1\n".into(),
            &["mean reflectance factor at 400 nm: found -1"],
        ),
        (
            "none.csv",
            "theta_i,theta_o,400,700\n20,20,1,1\n20,21,1,1\n20,22,1,1\n30,1,1,1\n30,2,1,1\n30,3,1,1\n".into(),
            &["incidence 30", "mirrored"],
        ),
    ] {
        write(&f, name, &text);
        f.fail(&[name, "-o", "x.ink.json"], &[&[name], words].concat());
    }
    for (arguments, words) in [
        (&["good.csv", "-o", "x.ink.json", "--growth=-200,3"][..], &["-200", "-50 to 50"][..]),
        (&["good.csv", "-o", "x.ink.json", "--growth", "3,1"], &["two ascending numbers"]),
        (&["good.csv", "-o", "x.ink.json", "--ior", "1.5"], &["--ior"]),
        (&["good.csv", "-o", "x.ink.json", "--lobes", "auto"], &["option: found --lobes", "no lobes"]),
        (&["good.csv", "-o", "x.ink.json", "--starts", "2"], &["option: found --starts"]),
        (&["good.csv", "-o", "x.ink.json", "--lifetime", "solve"], &["option: found --lifetime"]),
        (&["good.csv", "-o", "x.ink.json", "--white", "good.csv", "--white-reflectance", "1.5"], &["1.5"]),
        (&["good.csv", "-o", "good.csv"], &["good.csv"]),
        (&["good.csv", "-o", "x.paint.exr", "--leave-out", "70"], &[".ink.json"]),
    ] {
        f.fail(arguments, words);
    }
    write(&f, "bad.ink.json", "{\"kind\": \"carpaint ink\", \"version\": 9}");
    f.fail(&["bad.ink.json", "-o", "x.paint.exr"], &["bad.ink.json", "version: found 9"]);
}

/// The inks that come with the program are what their compositions' spectra give (fixtures/README.md), and have the colors of
/// their names.
#[test]
fn shipped_inks_are_those_of_their_compositions() {
    let f = Folder::new(&[]);
    let fixture = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/inks").join(name);
    for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let composition = fixture(&format!("{name}_flat.toml"));
        let (table, file) = (format!("{name}.csv"), format!("{name}.ink.json"));
        f.succeed(&["simulate", composition.to_str().unwrap(), "--spectra", &table]);
        f.succeed(&["fit", &table, "-o", &file, "--leave-out", "70"]);
        let (made, shipped) = (Ink::read(&f.path(&file)).unwrap(), Ink::read(&fixture(&file)).unwrap());
        assert_eq!((made.name(), made.wavelengths()), (name, shipped.wavelengths()));
        // Other machines round sines and exponentials otherwise, in the last digits.
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + b.abs());
        assert!(same(made.roughness(), shipped.roughness()));
        for band in 0..41 {
            let (a, b) = (made.at(band), shipped.at(band));
            assert!(same(a.reflectance, b.reflectance) && same(a.growth, b.growth), "{name}: {a:?} {b:?}");
        }
        let noise = |ink: &Ink| ink.provenance()["noise"].as_f64().unwrap();
        assert!(same(noise(&made), noise(&shipped)), "{name}: provenance of another fit");
        let at = |deg: f64| {
            let (wi, wo) = Reading::new(deg, 0.0).unwrap().directions();
            shipped.spectrum(&LobeGeometry::of(wi, wo)).linear_rgb() * PI
        };
        let steep = at(20.0).to_array();
        assert!((0..3).all(|c| c == k || steep[c] < 0.8 * steep[k]), "{name}: {steep:?}");
        assert!(at(65.0).element_sum() > 2.0 * at(20.0).element_sum(), "{name} grows");
    }
}
