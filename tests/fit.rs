//! Readers of measured tables, and the fit: known lobes come back, real paints are fitted, bad files are refused.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::brdf::cook_torrance::brightness;
use carpaint::brdf::{ClearCoat, Lobe, LobeGeometry, NeuralBrdf, TabulatedBrdf, read_measured, read_nbrdf};
use carpaint::fit::{Aspecular, FitOptions, FitReport, SmoothFit, fit_smooth};
use carpaint::math::half_difference::{HalfDifference, spherical};
use carpaint::simulate::{Composition, Model, ModelKind, ModelOptions};
use glam::DVec3;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

fn fit(table: &TabulatedBrdf, options: &FitOptions) -> (SmoothFit, FitReport) {
    fit_smooth(table, options, &|| ()).expect("fits")
}

fn print(name: &str, report: &FitReport) {
    println!(
        "{name}: eq. 7 {:.4} (colored {:.4}, gloss {:?}, energy {:?}), gloss ends at {:.1} deg, dE {:.2}/{:.2}, with gloss {:.2}/{:.2}",
        report.error,
        report.colored_error,
        report.gloss_error,
        report.gloss_energy,
        report.gloss_end_deg,
        report.delta_e_2000.mean,
        report.delta_e_2000.q95,
        report.delta_e_2000_with_gloss.mean,
        report.delta_e_2000_with_gloss.q95,
    );
    println!("  {:?}", report.samples);
    println!("  diffuse {:.5} {:?} gloss {:?}", report.diffuse, report.lobes, report.coat.gloss);
    for a in &report.aspecular {
        println!(
            "  {:3}: dE2000 {:.2} dE76 {:.2} (reciprocity {:.2?}) measured {:.4?} fitted {:.4?}",
            a.aspecular_deg,
            a.delta_e_2000,
            a.delta_e_76,
            a.reciprocity_delta_e_2000,
            a.measured_rgb,
            a.fitted_rgb
        );
    }
    println!("  starts {:?}", report.starts);
}

/// A color that flips from blue to green, as a function of theta_h and theta_i.
fn flip(wi: DVec3, wo: DVec3) -> DVec3 {
    let a = HalfDifference::of(wi, wo);
    DVec3::new(0.4 + 0.3 * a.theta_h, 0.8 + 0.5 * a.theta_i, 1.6 - 0.4 * a.theta_h - 0.3 * a.theta_i)
}

fn lobe(coefficient: f64, roughness: f64, f0: f64) -> Lobe {
    Lobe { coefficient, roughness, f0 }
}

#[test]
fn no_cell_of_a_simulated_table_is_taken_for_a_filling() {
    let mut looks_filled = 0;
    for sigma in [2, 4, 8] {
        let text = format!(
            "substrate = {{ albedo = 0.5 }}\n[[film]]\nthickness_um = 15\nindex = 1.5\n[[film.flakes]]\n\
             area_density = 1\ndiameter_um = 20\nsigma_deg = {sigma}\nmirror = {{ reflectance = 0.6 }}\n"
        );
        let fast = ModelOptions { kind: ModelKind::Fast, ..ModelOptions::default() };
        let model = Model::new(&Composition::parse(&text).unwrap(), fast).unwrap();
        let table = TabulatedBrdf::from_fn(30, 60, |wi, wo| model.brdf_rgb(wi, wo)).unwrap();
        let options = FitOptions { lobes: 1, starts: 1, filled: false, ..FitOptions::default() };
        let (_, report) = fit(&table, &options);
        assert_eq!((report.samples.repeated, report.samples.used), (0, 30 * 30 * 60));
        assert_eq!(serde_json::to_value(&report).unwrap()["options"]["filled"], false);
        let (_, report) = fit(&table, &FitOptions { filled: true, ..options });
        println!("sigma {sigma}: {:?}", report.samples);
        looks_filled += report.samples.repeated;
    }
    // Far from the mirror direction the fast model has shade alone, which azimuth does not change.
    assert!(looks_filled > 1000, "{looks_filled}");
}

#[test]
fn known_lobes_and_colors_come_back() {
    let lobes = [lobe(0.08, 0.45, 0.4), lobe(0.1, 0.15, 0.6)];
    let table = TabulatedBrdf::from_fn(45, 90, |wi, wo| {
        flip(wi, wo) * brightness(0.03, &lobes, &LobeGeometry::of(wi, wo))
    })
    .unwrap();
    let (_, report) = fit(&table, &FitOptions { lobes: 2, ..FitOptions::default() });
    print("two lobes", &report);
    // The intensity of `flip` varies by a factor 2, which two lobes cannot follow; chi does.
    assert!(report.colored_error < 0.02, "{}", report.colored_error);
    assert!(report.gloss_end_deg == 0.0);
    assert!(report.delta_e_2000.mean < 0.2 && report.delta_e_2000.q95 < 0.5);
    for a in &report.aspecular {
        assert!(a.delta_e_2000 < 0.5, "{a:?}");
    }
}

#[test]
fn colorless_lobes_come_back_with_their_parameters() {
    let lobes = [lobe(0.08, 0.5, 0.4), lobe(0.1, 0.15, 0.6)];
    let table = TabulatedBrdf::from_fn(45, 90, |wi, wo| {
        DVec3::splat(brightness(0.03, &lobes, &LobeGeometry::of(wi, wo)))
    })
    .unwrap();
    let (fitted, report) = fit(&table, &FitOptions { lobes: 2, ..FitOptions::default() });
    print("colorless", &report);
    assert!(report.error < 1e-3, "{}", report.error);
    assert!((fitted.diffuse / 0.03 - 1.0).abs() < 0.01);
    for (found, truth) in fitted.lobes.iter().zip(&lobes) {
        assert!((found.roughness / truth.roughness - 1.0).abs() < 0.01, "{found:?}");
        assert!(
            (found.f0 * found.coefficient / (truth.f0 * truth.coefficient) - 1.0).abs() < 0.02,
            "{found:?}"
        );
    }
}

#[test]
fn a_gloss_lobe_is_found_apart() {
    let lobes = [lobe(0.05, 0.5, 0.4), lobe(0.05, 0.25, 0.6)];
    let gloss = lobe(0.15, 0.03, 0.05);
    let table = TabulatedBrdf::from_fn(45, 90, |wi, wo| {
        let g = LobeGeometry::of(wi, wo);
        flip(wi, wo) * brightness(0.03, &lobes, &g) + DVec3::splat(gloss.eval(&g))
    })
    .unwrap();
    let (fitted, report) = fit(&table, &FitOptions { lobes: 2, ..FitOptions::default() });
    print("gloss", &report);
    let found = fitted.coat.gloss.expect("gloss");
    // The colored base below the peak is extrapolated; it makes a few per cent of the peak's foot.
    assert!((found.roughness / gloss.roughness - 1.0).abs() < 0.05, "{found:?}");
    assert!((found.f0 * found.coefficient / (gloss.f0 * gloss.coefficient) - 1.0).abs() < 0.1, "{found:?}");
    assert!(report.delta_e_2000.mean < 0.5);
}

#[test]
fn an_ideal_coat_is_divided_out() {
    let lobes = [lobe(0.06, 0.4, 0.4)];
    for refracts in [false, true] {
        let coat = ClearCoat::ideal(1.5, refracts);
        let table = TabulatedBrdf::from_fn(45, 90, |wi, wo| {
            let g = LobeGeometry::of(coat.inner(wi), coat.inner(wo));
            DVec3::new(0.9, 0.5, 0.2) * brightness(0.05, &lobes, &g) * coat.transmittance(wi.z, wo.z)
        })
        .unwrap();
        let options = FitOptions { lobes: 1, coat: Some(coat), ..FitOptions::default() };
        let (fitted, report) = fit(&table, &options);
        print("ideal coat", &report);
        assert_eq!(fitted.coat, coat);
        assert!(report.error < 1e-3, "{}", report.error);
        assert!((fitted.lobes[0].roughness / 0.4 - 1.0).abs() < 0.01);
        assert!(report.delta_e_2000.q95 < 0.2 && report.aspecular.iter().all(|a| a.delta_e_2000 < 0.2));
    }
}

/// The paints of Rump et al. 2008, Table 1, gloss included.
#[test]
fn published_paints_are_fitted_back() {
    let Some(reference) = common::reference_json("oracles/07_cook_torrance.json") else { return };
    for set in reference["sets"].as_array().expect("sets") {
        let lobes: Vec<Lobe> = serde_json::from_value::<Vec<[f64; 3]>>(set["lobes"].clone())
            .expect("lobes")
            .into_iter()
            .map(|[s, a, f]| lobe(s, a, f))
            .collect();
        let kd = set["kd"].as_f64().expect("kd");
        let table = TabulatedBrdf::from_fn(45, 90, |wi, wo| {
            DVec3::splat(brightness(kd, &lobes, &LobeGeometry::of(wi, wo)))
        })
        .unwrap();
        let (_, report) = fit(&table, &FitOptions { lobes: lobes.len() - 1, ..FitOptions::default() });
        print(set["name"].as_str().expect("name"), &report);
        assert!(report.error < 0.01, "{}", report.error);
        assert!(report.aspecular.iter().all(|a| a.delta_e_2000 < 0.5));
        assert!(report.delta_e_2000.q95 < 0.5);
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let table = TabulatedBrdf::from_fn(20, 30, |wi, wo| {
        let g = LobeGeometry::of(wi, wo);
        flip(wi, wo) * brightness(0.03, &[lobe(0.08, 0.45, 0.4)], &g)
            + DVec3::splat(lobe(0.1, 0.04, 0.05).eval(&g))
    })
    .unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
        pool.install(|| fit(&table, &FitOptions::default()))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn ticks_stay_below_what_is_announced() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let lobes = [lobe(0.08, 0.45, 0.4)];
    let table = TabulatedBrdf::from_fn(12, 16, |wi, wo| {
        let g = LobeGeometry::of(wi, wo);
        DVec3::splat(brightness(0.03, &lobes, &g) + lobe(0.1, 0.05, 0.05).eval(&g))
    })
    .unwrap();
    let options = FitOptions { starts: 3, lobes: 1, ..FitOptions::default() };
    let ticks = AtomicUsize::new(0);
    fit_smooth(&table, &options, &|| {
        ticks.fetch_add(1, Ordering::Relaxed);
    })
    .expect("fits");
    let ticks = ticks.into_inner();
    assert!(ticks > options.starts && ticks <= options.ticks(), "{ticks} of {}", options.ticks());
}

#[test]
fn the_smallest_tables_are_fitted() {
    for (theta, phi) in [(2, 2), (3, 2), (2, 5)] {
        let table =
            TabulatedBrdf::from_fn(theta, phi, |wi, wo| flip(wi, wo) * (0.1 + wi.dot(wo).abs())).unwrap();
        let (fitted, report) = fit(&table, &FitOptions::default());
        assert!(report.error.is_finite() && fitted.eval(DVec3::Z, DVec3::Z).is_finite());
    }
}

#[test]
fn bad_options_and_black_tables_are_refused() {
    let table = TabulatedBrdf::from_fn(8, 8, |wi, _| DVec3::splat(wi.z)).unwrap();
    let default = FitOptions::default();
    for (options, word) in [
        (FitOptions { lobes: 0, ..default.clone() }, "lobes"),
        (FitOptions { lobes: 4, ..default.clone() }, "lobes"),
        (FitOptions { starts: 0, ..default.clone() }, "starts"),
        (FitOptions { table_size: [1, 64], ..default.clone() }, "color table"),
        (FitOptions { coat: Some(ClearCoat::ideal(0.5, false)), ..default.clone() }, "ior"),
    ] {
        let message = fit_smooth(&table, &options, &|| ()).expect_err("refused").to_string();
        assert!(message.contains(word), "{message}");
    }
    let black = TabulatedBrdf::from_fn(8, 8, |_, _| DVec3::ZERO).unwrap();
    assert!(fit_smooth(&black, &default, &|| ()).expect_err("refused").to_string().contains("positive"));
}

/// What Bagher et al. 2012 reached with SGD, by their own measure, red, green and blue; of materials that they fitted.
fn sgd(material: &str) -> Option<String> {
    let text =
        std::fs::read_to_string(common::reference("data/tables/merl_sgd_bagher2012.tsv")?).expect("reads");
    let row = text.lines().map(|line| line.split('\t').collect::<Vec<_>>()).find(|row| row[0] == material)?;
    Some(row[row.len() - 3..].join(" "))
}

/// One line of the comparison of measured materials: errors of the logarithm, and color differences at the instrument's angles.
fn line(material: &str, report: &FitReport) {
    let angles: Vec<String> =
        report.aspecular.iter().map(|a| format!("{:.0}:{:.2}", a.aspecular_deg, a.delta_e_2000)).collect();
    println!(
        "{material:<22} | log {:.3} colored {:.3} gloss {} | dE mean {:.2} 95 % {:.2} | dE at {} | chi {:.3}, phi_d {:.3} | SGD {}",
        report.error,
        report.colored_error,
        report.gloss_error.map_or("-".to_owned(), |e| format!("{e:.3}")),
        report.delta_e_2000.mean,
        report.delta_e_2000.q95,
        angles.join(" "),
        report.color.all,
        report.color.azimuth,
        sgd(material).unwrap_or("-".to_owned()),
    );
}

/// A table and how far its color may be off at -15, 15, 25, 45, 75, 110 degrees.
fn real(name: &str, file: &str, bars: [f64; 6], error: f64, mean: f64) {
    let Some(path) = common::reference(file) else { return };
    let (_, report) = fit(&read_measured(&path).expect("reads"), &FitOptions::default());
    line(name, &report);
    assert!(report.coat.gloss.is_some());
    // The measured peak has a flat top, the lobe has none: eq. 7, which weighs the peak's foot as much, leaves a tenth out.
    assert!(report.gloss_energy.is_some_and(|e| e > 0.85 && e < 1.1), "{:?}", report.gloss_energy);
    // Measured 0.48 and 0.47; with the plateaus near the normal in, they were 0.57 and 1.01.
    assert!(report.gloss_error.is_some_and(|e| e < 0.55), "{:?}", report.gloss_error);
    assert!(report.samples.repeated > 65_000);
    assert!(report.error < error, "{}", report.error);
    assert!(report.delta_e_2000.mean < mean, "{:?}", report.delta_e_2000);
    for (a, bar) in report.aspecular.iter().zip(bars) {
        assert!(a.delta_e_2000 < bar, "{a:?}");
    }
}

// Bars: measured values and a fifth. They are the table's own scatter: exchanging light and eye moves it as much.
#[test]
fn the_measured_blue_paint() {
    real("blue", "data/mbsdf/carpaint_blue.mbsdf", [9.0, 3.7, 2.3, 1.5, 1.0, 1.6], 0.145, 4.1);
}

#[test]
fn the_measured_green_paint() {
    real("green", "data/mbsdf/carpaint_green.mbsdf", [9.0, 1.0, 4.7, 5.6, 11.7, 3.3], 0.183, 7.9);
}

#[test]
fn neural_materials_are_read_and_fitted() {
    let Some(folder) = common::reference("data/nbrdf") else { return };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("lists").map(|e| e.expect("entry").path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "f32"));
    files.sort();
    assert_eq!(files.len(), 11);
    for file in files {
        // A network's table is computed, not filled.
        let options = FitOptions { starts: 3, filled: false, ..FitOptions::default() };
        let (_, report) = fit(&read_measured(&file).expect("reads"), &options);
        line(&file.file_stem().expect("name").to_string_lossy(), &report);
        // Measured, and a fifth: the worst of ten is the gold paint on average (1.93), the blue one at 25 degrees (2.55).
        // The agat is the exception: its network drops from a flat blue to black at the sample's edge.
        let agat = file.ends_with("cc_blue_agat_rgb.f32");
        let (mean, single) = if agat { (4.7, 6.2) } else { (2.4, 3.1) };
        assert!(report.error < 0.6 && report.delta_e_2000.mean < mean, "{:?}", report.delta_e_2000);
        // At -15 degrees the agat's eye lies beyond that edge, and others' gloss still shows (red, 3.5).
        let bar = |a: &Aspecular| match (a.aspecular_deg < 0.0, agat) {
            (true, true) => f64::INFINITY,
            (true, false) => 4.2,
            _ => single,
        };
        assert!(report.aspecular.iter().all(|a| a.delta_e_2000 < bar(a)), "{:?}", report.aspecular);
    }
}

#[test]
fn a_neural_material_has_the_reference_colors() {
    let Some(path) = common::reference("data/nbrdf/blue-metallic-paint.f32") else { return };
    let table = [
        (
            "blue-metallic-paint",
            "0.282 0.264 0.675 | 0.114 0.097 0.258 | 0.029 0.024 0.056 | 0.008 0.007 0.017 | 0.005 0.004 0.009",
        ),
        (
            "silver-metallic-paint",
            "1.268 1.252 1.221 | 0.452 0.450 0.444 | 0.063 0.065 0.067 | 0.015 0.017 0.019 | 0.011 0.013 0.016",
        ),
        (
            "irid_flake_paint1_rgb",
            "0.196 0.156 0.108 | 0.048 0.042 0.046 | 0.000 0.043 0.081 | 0.008 0.008 0.007 | 0.001 0.002 0.003",
        ),
    ];
    for (name, row) in table {
        let material = read_nbrdf(&path.with_file_name(format!("{name}.f32"))).expect("reads");
        for (aspecular, colors) in [15.0f64, 25.0, 45.0, 75.0, 110.0].into_iter().zip(row.split(" | ")) {
            let expected: Vec<f64> = colors.split(' ').map(|c| c.parse().expect("number")).collect();
            let found =
                PI * material.eval(spherical(PI / 4.0, 0.0), spherical((aspecular - 45.0).to_radians(), 0.0));
            // Three digits are given.
            assert!(
                (found - DVec3::from_slice(&expected)).abs().max_element() < 6e-4,
                "{name} {aspecular}: {found}"
            );
        }
    }
}

#[test]
fn a_neural_material_depends_on_the_azimuth_between_only() {
    // Any weights serve: the input is what is turned.
    let weights =
        (0..675u32).map(|k| f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.45).collect();
    let material = NeuralBrdf::new(weights).unwrap();
    let ours = material.eval(spherical(0.7, 0.3), spherical(0.4, 2.0));
    let turned = material.eval(spherical(0.7, 1.4), spherical(0.4, 3.1));
    assert!(ours.max_element() > 0.0);
    assert!((ours / turned - DVec3::ONE).abs().max_element() < 1e-9, "{ours} {turned}");
    assert_eq!(material.eval(spherical(1.6, 0.0), spherical(0.4, 0.0)), DVec3::ZERO);
}

fn mbsdf(kind: u32, theta: u32, phi: u32, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"NVIDIA ARC MBSDF V1\nMBSDF_DATA_REFLECTION=\n".to_vec();
    [kind, theta, phi].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes
}

fn refusal(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("writes");
    let message = read_measured(&path).expect_err("refused").to_string();
    assert!(message.contains(name), "the file is named: {message}");
    message
}

#[test]
fn tables_are_read() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("t.mbsdf");
    let values: Vec<f32> = (0..2 * 2 * 3).map(|k| k as f32).collect();
    std::fs::write(&path, mbsdf(0, 2, 3, &values)).expect("writes");
    let table = read_measured(&path).expect("reads");
    assert_eq!(table.resolution(), [2, 3]);
    assert_eq!(table.cell(1, 0, 2), DVec3::splat(8.0));
    let values: Vec<f32> = (0..2 * 2 * 3 * 3).map(|k| k as f32).collect();
    std::fs::write(&path, mbsdf(1, 2, 3, &values)).expect("writes");
    assert_eq!(read_measured(&path).expect("reads").cell(1, 0, 2), DVec3::new(24.0, 25.0, 26.0));
}

#[test]
fn hostile_files_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let f = folder.path();
    let values = vec![0.5f32; 36];
    let good = mbsdf(1, 2, 3, &values);
    for (name, bytes, words) in [
        ("empty.mbsdf", vec![], "length"),
        ("short.mbsdf", good[..30].to_vec(), "length"),
        ("magic.mbsdf", [b"NVIDIA ARC MBSDF V2\n", &good[20..]].concat(), "first line"),
        ("section.mbsdf", good.iter().map(|b| if *b == b'R' { b'T' } else { *b }).collect(), "line"),
        ("kind.mbsdf", mbsdf(7, 2, 3, &values), "type: found 7"),
        ("huge.mbsdf", mbsdf(1, u32::MAX, u32::MAX, &values), "2 to 720"),
        ("large.mbsdf", mbsdf(1, 720, 720, &values), "found 199 bytes, expected 4478976055 bytes"),
        ("cut.mbsdf", good[..good.len() - 1].to_vec(), "found 198 bytes, expected 199 bytes"),
        ("long.mbsdf", [good.as_slice(), b"x"].concat(), "found 200 bytes, expected 199 bytes"),
        ("cut.f32", vec![0; 2699], "found 2699 bytes, expected 2700 bytes"),
        ("text.txt", b"hello".to_vec(), "mbsdf table"),
    ] {
        let message = refusal(f, name, &bytes);
        assert!(message.contains(words), "{name}: {message}");
    }
    let mut bad = values.clone();
    bad[3 * (3 + 2) + 1] = f32::NAN;
    assert!(refusal(f, "nan.mbsdf", &mbsdf(1, 2, 3, &bad)).contains("theta_in 0, theta_out 1, phi 2"));
    let mut weights = vec![0u8; 2700];
    weights[40..44].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert!(refusal(f, "inf.f32", &weights).contains("number 10"));
    assert!(read_measured(f).expect_err("a folder").to_string().contains("a folder"));
    assert!(read_measured(&f.join("missing")).is_err());
}

/// Bright flakes given to a dark paint: its color stays, and no light is taken that is not there.
#[test]
fn flakes_given_to_a_darker_paint_leave_no_holes() {
    let silver = Composition::read(Path::new("fixtures/compositions/silver_metallic.toml")).unwrap();
    let silver_model = Model::new(&silver, ModelOptions::default()).unwrap();
    let grid = carpaint::btf::AngleGrid::triangle(6).unwrap();
    let options = carpaint::simulate::SynthesisOptions {
        size: [64; 2],
        ..carpaint::simulate::SynthesisOptions::new(grid)
    };
    let btf = carpaint::simulate::synthesize(&silver_model, &options, &|| ()).unwrap();
    let dark = SmoothFit {
        coat: ClearCoat::NONE,
        diffuse: 0.02,
        lobes: vec![Lobe { coefficient: 0.004, roughness: 0.3, f0: 0.5 }],
        colors: carpaint::brdf::ColorTable::white(),
        spectral: None,
    };
    for slice in 0..btf.grid.len() {
        let xi = carpaint::fit::residual(&btf, &dark, carpaint::fit::SliceMean::Zero, slice).unwrap();
        let (theta_h, theta_i) = btf.grid.angles(slice);
        let (wi, wo) = carpaint::math::half_difference::directions(theta_h, theta_i, PI / 2.0);
        let base = dark.base(wi, wo).x;
        let values = || xi.as_flattened().iter().map(|x| f64::from(*x));
        let n = (3 * xi.len()) as f64;
        let (mean, square) = (values().sum::<f64>() / n, values().map(|x| x * x).sum::<f64>() / n);
        // f32 texels, 4,096 of them.
        assert!(mean.abs() <= 1e-5 * square.sqrt(), "slice {slice}: {mean}");
        let darkest = values().fold(f64::INFINITY, f64::min);
        // f32 texels near the base.
        assert!(base + darkest >= -1e-6 * base, "slice {slice}: {darkest} under {base}");
    }
}

/// Levels are stored in millimetres: a coarse level drawn on the lattice of the finest would lose its sparkle with distance.
#[test]
fn the_lattice_coarsens_with_the_levels() {
    let silver = Composition::read(Path::new("fixtures/compositions/silver_metallic.toml")).unwrap();
    let silver_model = Model::new(&silver, ModelOptions::default()).unwrap();
    let grid = carpaint::btf::AngleGrid::triangle(3).unwrap();
    let options = carpaint::simulate::SynthesisOptions {
        size: [32; 2],
        ..carpaint::simulate::SynthesisOptions::new(grid)
    };
    let btf = carpaint::simulate::synthesize(&silver_model, &options, &|| ()).unwrap();
    let options = FitOptions { coat: Some(btf.coat), starts: 1, ..FitOptions::default() };
    let (paint, _) = carpaint::fit::fit_btf(&btf, &options, &Default::default(), &|| ()).unwrap();
    let levels = paint.flakes.unwrap().levels;
    assert_eq!(levels.len(), 6);
    for (k, level) in levels.iter().enumerate().take(5) {
        let texels = level.pitch_mm / (btf.texel_mm * f64::from(1u32 << k));
        // An integral range is at least one texel of its level, and flakes 1.5 texels wide make it a few at most.
        assert!((0.999..4.0).contains(&texels), "level {k}: {texels} texels");
    }
}
