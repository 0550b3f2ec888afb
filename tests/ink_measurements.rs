//! Measurements of inks, from the simulated print to the averaged spectra, with the program itself.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::brdf::instrument::Reading;
use carpaint::brdf::{DeviationNeighbors, Goniospectra, read_samples};
use carpaint::color::{Spectrum, wavelength_nm};
use carpaint::simulate::{Composition, Goniospectrometer, Model, ModelOptions};
use common::carpaint;
use folder::Folder;
use glam::DVec3;
use std::f64::consts::PI;

const BLUE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/inks/blue_flat.toml");

fn prints() -> Folder {
    Folder::new(&["simulate"])
}

fn model(name: &str) -> Model {
    let path = format!("{}/fixtures/inks/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let composition = Composition::read(path.as_ref()).unwrap();
    assert_eq!(composition.warnings().unwrap(), [""; 0], "{name}");
    Model::new(&composition, ModelOptions::default()).unwrap()
}

/// BRDF of light mirrored at an angle, degrees.
fn mirrored(model: &Model, theta: f64) -> Spectrum {
    let (wi, wo) = Reading::between(theta, theta).unwrap().directions();
    model.brdf(wi, wo)
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let f = prints();
    let written = ["1", "8"].map(|threads| {
        let name = format!("{threads}.csv");
        let mut command = carpaint();
        command.current_dir(f.path("")).env("RAYON_NUM_THREADS", threads);
        command.args(["simulate", BLUE, "--spectra", &name, "--incidence", "20,62.5", "--repeats", "3"]);
        assert!(command.status().unwrap().success());
        std::fs::read_to_string(f.path(&name)).unwrap()
    });
    assert_eq!(written[0], written[1]);
    // 81 geometries at 20 degrees; at 62.5 from -42 to 80, and the mirror direction.
    assert_eq!(written[0].lines().filter(|line| line.starts_with(['2', '6'])).count(), 3 * (81 + 124));
    f.succeed(&[BLUE, "--spectra", "7.csv", "--incidence", "20,62.5", "--repeats", "3", "--seed", "7"]);
    assert_ne!(std::fs::read_to_string(f.path("7.csv")).unwrap(), written[0]);
}

#[test]
fn noise_has_the_size_asked_for_and_no_noise_is_the_model() {
    let f = prints();
    f.succeed(&[BLUE, "--spectra", "noisy.csv", "--incidence", "45"]);
    f.succeed(&[BLUE, "--spectra", "exact.csv", "--incidence", "45", "--noise", "0", "--repeats", "4"]);
    let [noisy, exact] = ["noisy.csv", "exact.csv"].map(|name| Goniospectra::read(&f.path(name)).unwrap());
    let count = noisy.spectra().len() as f64;
    assert_eq!(count, 106.0);
    let squares: f64 = noisy.spectra().iter().map(|row| row.deviation.unwrap().powi(2)).sum();
    // 106 geometries of 41 wavelengths with 9 degrees of freedom: 0.36 % of 1 % is one standard error; four of them.
    assert!(((squares / count).sqrt() / 0.01 - 1.0).abs() < 0.0145, "{}", (squares / count).sqrt());
    assert!(noisy.spectra().iter().all(|row| row.repeats == 10));
    let model = model("blue_flat");
    let (mut sum, mut sum_squares) = (0.0, 0.0);
    for (row, noisy) in exact.spectra().iter().zip(noisy.spectra()) {
        let (wi, wo) = row.reading.directions();
        let brdf = model.brdf(wi, wo).0;
        // Equal readings have no spread but that of adding and dividing.
        assert!(row.repeats == 4 && row.deviation.unwrap() < 1e-15, "{row:?}");
        for (k, expected) in brdf.iter().enumerate() {
            assert!((row.mean[k] / expected - 1.0).abs() < 1e-12, "{:?}", row.reading);
            let error = noisy.mean[k] / expected - 1.0;
            sum += error;
            sum_squares += error * error;
        }
    }
    // The means of ten: a tenth of the variance, no bias. 4346 of them: 1.1 % is a standard error of their spread; four of them.
    let number = count * 41.0;
    assert!(((sum_squares / number / 1e-5).sqrt() - 1.0).abs() < 0.043, "{}", sum_squares / number);
    assert!((sum / number).abs() < 4.0 * (1e-5 / number).sqrt(), "{}", sum / number);
    // The table is one of the readings that fits take.
    let samples = read_samples(&f.path("noisy.csv")).unwrap().samples;
    assert_eq!(samples.len(), 1060);
}

#[test]
fn the_measurement_of_a_white_sample_is_its_own_reference() {
    let f = prints();
    f.succeed(&[BLUE, "--spectra", "ink.csv", "--incidence", "30,50", "--noise", "0", "--repeats", "2"]);
    let path = f.path("ink.csv");
    let over = Goniospectra::read_over_white(&path, &path, 0.99).unwrap();
    for row in over.spectra() {
        // One division of equals and one by pi.
        assert!(row.mean.iter().all(|f| (PI * f - 0.99).abs() < 1e-15), "{row:?}");
    }
    assert_eq!(over.without(&[50.0]).unwrap().incidences(), [30.0]);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let f = prints();
    for (arguments, words) in [
        (&["--spectra", "a.txt"][..], &["--spectra: name: found a.txt", ".csv"][..]),
        (&["--spectra", "no/a.csv"], &["no/a.csv"]),
        (&["--incidence", "20"], &["--spectra"]),
        (
            &["--spectra", "a.csv", "--incidence", "5"],
            &["--spectra: incidence, degrees: found 5, expected 10 to 85"],
        ),
        (&["--spectra", "a.csv", "--incidence", "90"], &["found 90"]),
        (&["--spectra", "a.csv", "--incidence", "20,nan"], &["found NaN"]),
        (&["--spectra", "a.csv", "--incidence", "20,x"], &["invalid value 'x'"]),
        (&["--spectra", "a.csv", "--incidence", "20,20"], &["found 20 twice, expected each once"]),
        (&["--spectra", "a.csv", "--repeats", "0"], &["repeats: found 0, expected 1 to 1000"]),
        (&["--spectra", "a.csv", "--repeats", "500"], &["readings, repeats counted", "1 to 65536"]),
        (&["--spectra", "a.csv", "--noise", "-1"], &["noise: found -1, expected 0 to 0.5"]),
        (&["--spectra", "a.csv", "--brdf", "a.csv"], &["output named twice"]),
    ] {
        f.fail(&[&[BLUE][..], arguments].concat(), words);
    }
}

/// Linear sRGB of what is mirrored at an angle, the largest channel 1.
fn color(model: &Model, theta: f64) -> DVec3 {
    let rgb = mirrored(model, theta).linear_rgb();
    rgb / rgb.max_element()
}

/// Brushed inks look as they are called, change color with the angle, and mirror far more than inks mixed into binder.
#[test]
fn inks_are_red_green_and_blue_by_interference() {
    for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let [flat, mixed] = ["flat", "mixed"].map(|kind| model(&format!("{name}_{kind}")));
        let (steep, flat_angle) = (color(&flat, 20.0), color(&flat, 65.0));
        println!("{name}: 20 deg {steep:.3}, 45 deg {:.3}, 65 deg {flat_angle:.3}", color(&flat, 45.0));
        println!("{name} mixed: 20 deg {:.3}, 65 deg {:.3}", color(&mixed, 20.0), color(&mixed, 65.0));
        for theta in [20.0, 45.0, 65.0] {
            let spectrum = mirrored(&flat, theta).0;
            let peak = |a: &usize| {
                (*a == 0 || spectrum[*a - 1] < spectrum[*a]) && (*a == 40 || spectrum[*a + 1] < spectrum[*a])
            };
            let peaks: Vec<String> = (0..41)
                .filter(peak)
                .map(|a| format!("{} nm {:.3}", wavelength_nm(a), PI * spectrum[a]))
                .collect();
            let least = spectrum.iter().fold(f64::MAX, |a, b| a.min(*b));
            println!("  {theta}: {peaks:?}, least {:.3}", PI * least);
        }
        // The named channel is the largest by a third at the least.
        for other in [(k + 1) % 3, (k + 2) % 3] {
            assert!(steep[other] < 0.75 && steep[k] == 1.0, "{name}: {steep}");
        }
        assert!((steep - flat_angle).length() > 0.3, "{name}: {steep} {flat_angle}");
        let mean = |model: &Model| mirrored(model, 20.0).0.iter().sum::<f64>();
        assert!(mean(&flat) > 5.0 * mean(&mixed), "{name}: {} {}", mean(&flat), mean(&mixed));
    }
}

/// Between the geometries of the paper the neighbors stand for the print itself.
#[test]
fn neighbors_show_the_print_in_and_out_of_the_plane() {
    let model = model("green_flat");
    let settings = Goniospectrometer { noise: 0.0, repeats: 1, ..Goniospectrometer::default() };
    let measured = Goniospectra::new(&settings.measure(&model).unwrap()).unwrap();
    let neighbors = DeviationNeighbors::new(&measured).unwrap();
    let mut errors = [0.0f64; 2];
    for (row, error) in errors.iter_mut().enumerate() {
        let (mut squares, mut all) = (0.0, 0.0);
        for k in 0..400 {
            let (a, b) = (25.0 + f64::from(k % 20) * 2.0, -10.0 + f64::from(k / 20) * 4.0);
            let (wi, mut wo) = Reading::between(a, b).unwrap().directions();
            if row == 1 {
                // Turned out of the plane by 10 degrees.
                wo = DVec3::new(wo.x * 0.1745f64.cos(), wo.x * 0.1745f64.sin(), wo.z);
            }
            for (found, expected) in neighbors.eval(wi, wo).iter().zip(model.brdf(wi, wo).0) {
                squares += (found - expected).powi(2);
                all += expected * expected;
            }
        }
        *error = (squares / all).sqrt();
    }
    println!("neighbors: {errors:?} of the root mean square");
    // Readings are a degree apart in a scan and 5 or 10 between scans, over which reflectance doubles near grazing: a tenth of it is
    // lost in the plane. Out of it the neighbors know the half vector's angle alone.
    assert!(errors[0] < 0.1 && errors[1] < 0.2, "{errors:?}");
}
