//! Synthesized flake slices against the model they are drawn from, and the ready compositions.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

// The helpers of tests are tests too.

mod common;

use carpaint::Result;
use carpaint::btf::{AngleGrid, FlakeBtf};
use carpaint::color::{Spectrum, lab_from_rgb, luminance};
use carpaint::math::half_difference::{directions, spherical};
use carpaint::simulate::composition::Film;
use carpaint::simulate::{
    Composition, Model, ModelOptions, Reading, Synthesis, SynthesisOptions, phi_d_error,
};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// One or more kinds of gray flakes, `area_density` each.
fn paint(kinds: usize, area_density: f64, sigma_deg: f64, lobe_deg: f64) -> Composition {
    let kind = format!(
        "[[film.flakes]]\narea_density = {area_density}\ndiameter_um = 20\ndiameter_spread = 0.4\nsigma_deg = {sigma_deg}\n\
         flake_lifetime_deg = {lobe_deg}\nmirror = {{ reflectance = 0.6, transmittance = 0.2 }}\n"
    );
    let film =
        "[substrate]\nalbedo = 0.3\n[[film]]\nthickness_um = 15\nindex = 1.5\nabsorption_per_mm = 10\n";
    Composition::parse(&format!("{film}{}", kind.repeat(kinds))).unwrap()
}

/// The usual model.
fn model(paint: &Composition) -> Model {
    Model::new(paint, ModelOptions::default()).unwrap()
}

/// Flakes over the usual model.
fn synthesize(paint: &Composition, options: &SynthesisOptions) -> Result<FlakeBtf> {
    carpaint::simulate::synthesize(&model(paint), options, &|| ())
}

fn options(bins: usize, side: usize, seed: u64) -> SynthesisOptions {
    SynthesisOptions { size: [side; 2], seed, ..SynthesisOptions::new(AngleGrid::triangle(bins).unwrap()) }
}

/// Blocks of texels a side: flakes are 1.5 texels wide, so that means over blocks of 32 x 32 are all but independent.
const BLOCK: usize = 32;

/// Mean luminance of a slice's fluctuation less `shift`, in standard errors from the means of its blocks.
fn block_z(btf: &FlakeBtf, slice: usize, shift: f64) -> f64 {
    let side = btf.size[0] / BLOCK;
    let mut means = vec![0.0; side * side];
    for (k, texel) in btf.slices[slice].fluctuation.iter().enumerate() {
        let (x, y) = (k % btf.size[0] / BLOCK, k / btf.size[0] / BLOCK);
        means[y * side + x] += luminance(DVec3::from(texel.map(f64::from))) / (BLOCK * BLOCK) as f64;
    }
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - shift) / (variance / n).sqrt()
}

/// Checks that the slice means of two seeds are `expected(slice)` away from the model's, within their standard errors.
fn assert_means(paint: &Composition, expected: impl Fn(&FlakeBtf, usize) -> f64) {
    let runs = [1, 2].map(|seed| synthesize(paint, &options(6, 512, seed)).unwrap());
    let grid = &runs[0].grid;
    let mut chi2 = 0.0;
    for slice in 0..grid.len() {
        let (theta_h, theta_i) = grid.bins_of(slice);
        // From 60 degrees on (35 inside) few blocks hold a flake that is seen: far from normal.
        if theta_h > 3 {
            continue;
        }
        let z = runs.each_ref().map(|btf| block_z(btf, slice, expected(btf, slice)));
        // 512 blocks, nearly normal: five standard errors over 18 slices is one false alarm in 10^5.
        assert!((z[0] + z[1]).abs() / 2f64.sqrt() < 5.0, "theta_h {theta_h} theta_i {theta_i}: {z:?}");
        if theta_i == 0 {
            chi2 += z[0] * z[0] + z[1] * z[1];
        }
    }
    // Slices 15 degrees of theta_h apart (10 inside) show different flakes, seeds always do: eight independent squares of a
    // normal variable, whose sum lies in here with probability 0.998.
    println!("chi-square of eight slice means: {chi2:.1}");
    assert!((0.857..26.1).contains(&chi2), "{chi2}");
}

/// How much brighter eq. 36 with P itself is at a slice than with the lobe.
fn without_lobe(paint: &Composition) -> impl Fn(&FlakeBtf, usize) -> f64 + use<> {
    let mut mirrors = paint.clone();
    mirrors.films[0].flakes.iter_mut().for_each(|kind| kind.flake_lifetime_deg = 0.0);
    let models = [&mirrors, paint].map(model);
    move |btf, slice| {
        let (theta_h, theta_i) = btf.grid.angles(slice);
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let [limit, ours] = models.each_ref().map(|m| luminance(m.glitter(wi, wo).linear_rgb()));
        limit - ours
    }
}

#[test]
fn texels_average_to_the_glitter_with_the_lobe() {
    // Inside, lobes are narrower by the index of 1.5.
    let paint = paint(1, 1.0, 10.0, 9.75);
    assert_means(&paint, |_, _| 0.0);
    // The test sees the lobe: without it the model is 7 % brighter at the peak, far outside the standard error.
    let btf = synthesize(&paint, &options(1, 512, 1)).unwrap();
    let z = block_z(&btf, 0, without_lobe(&paint)(&btf, 0));
    assert!(z < -5.0, "{z}");
}

#[test]
fn as_the_lobe_vanishes_texels_average_to_eq_36_itself() {
    // Inside, a lobe of 2.5 degrees has a width of 1.06: the convolution differs from P by (1.06 / 15)^2 times a curvature of order 1.
    // Narrower ones agree better but are seen too rarely for a normal mean (the limit itself is a test of orientation).
    let narrow = paint(1, 1.0, 15.0, 3.75);
    assert_means(&narrow, without_lobe(&narrow));
}

#[test]
fn two_kinds_of_half_the_density_are_one() {
    let (one, two) = (paint(1, 1.0, 15.0, 9.75), paint(2, 0.5, 15.0, 9.75));
    let [a, b] = [&one, &two].map(model);
    for (theta_i, theta_o) in [(0.0, 0.1), (0.8, 0.7), (1.4, 0.2)] {
        let (wi, wo) = (spherical(theta_i, 0.0), spherical(theta_o, 3.0));
        let (a, b) = (a.brdf_rgb(wi, wo), b.brdf_rgb(wi, wo));
        // Sums in another order.
        assert!((a - b).length() < 1e-12 * a.length(), "{a} {b}");
    }
    assert_means(&two, |_, _| 0.0);
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let paint = paint(2, 0.4, 15.0, 6.5);
    let run = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| synthesize(&paint, &options(4, 32, seed)).unwrap())
    };
    let one = run(1, 7);
    // Not assert_eq: it would print both.
    assert!(one == run(2, 7));
    let other = run(2, 8);
    assert!(one.smooth == other.smooth);
    assert!(one.slices[0].fluctuation != other.slices[0].fluctuation);
}

#[test]
fn a_slice_alone_has_the_bits_it_has_in_company() {
    let paint = paint(2, 0.4, 15.0, 6.5);
    for parallax in [false, true] {
        let options = SynthesisOptions { parallax, ..options(4, 32, 7) };
        let (all, model) = (synthesize(&paint, &options).unwrap(), model(&paint));
        let alone = Synthesis::new(&model, &options).unwrap();
        // Backwards, and on a grid that ends early.
        assert!((0..all.grid.len()).rev().all(|k| alone.slice(k) == all.slices[k]));
        let fewer = SynthesisOptions { grid: AngleGrid::new(4, vec![4, 1]).unwrap(), ..options.clone() };
        let fewer = Synthesis::new(&model, &fewer).unwrap();
        assert!((0..5).all(|k| fewer.slice(k) == all.slices[k]));
    }
}

#[test]
fn a_file_written_slice_by_slice_is_the_one_written_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (model, options) = (model(&paint(2, 0.4, 15.0, 6.5)), options(5, 40, 3));
    let synthesis = Synthesis::new(&model, &options).unwrap();
    let whole = synthesis.run(&|| ()).unwrap();
    whole.write(&at("whole.btf.exr")).unwrap();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let path = at(&format!("{threads}.btf.exr"));
        let provenance = pool.install(|| synthesis.write(&path, &|| ()).unwrap());
        assert_eq!(provenance, whole.provenance);
        assert!(std::fs::read(&path).unwrap() == std::fs::read(at("whole.btf.exr")).unwrap(), "{threads}");
    }
    let read = FlakeBtf::read(&at("1.btf.exr")).unwrap();
    assert!(read.slices == whole.slices && read.smooth == whole.smooth && read.grid == whole.grid);
    // What is missing, wrong or there twice is refused, and no file is left.
    let writer =
        || carpaint::btf::BtfWriter::new(&at("part.btf.exr"), &whole.grid, whole.size, 0.01).unwrap();
    let refused = |outcome: Result<()>, word: &str| {
        let message = outcome.unwrap_err().to_string();
        assert!(message.contains(word) && message.contains("part.btf.exr"), "{message}");
    };
    let part = writer();
    part.slice(2, &whole.slices[2]).unwrap();
    refused(part.slice(2, &whole.slices[2]), "slice_0002");
    refused(part.slice(15, &whole.slices[2]), "below 15");
    let mut bad = whole.slices[3].clone();
    bad.fluctuation[41][1] = f32::NAN;
    refused(part.slice(3, &bad), "texel (1, 1)");
    refused(part.finish(&whole.smooth, whole.coat, &whole.provenance), "found 1, expected 15");
    assert!(!at("part.btf.exr").exists());
}

#[test]
fn parallax_moves_light_and_keeps_it() {
    let paint = paint(1, 1.0, 15.0, 6.5);
    let [flat, deep] = [false, true]
        .map(|parallax| synthesize(&paint, &SynthesisOptions { parallax, ..options(6, 64, 1) }).unwrap());
    let light = |btf: &FlakeBtf, k: usize| -> f64 {
        btf.slices[k].fluctuation.iter().map(|t| f64::from(t[1])).sum::<f64>() / (64.0 * 64.0)
    };
    for k in 0..flat.grid.len() {
        let peak = flat.slices[k].fluctuation.iter().map(|t| f64::from(t[1])).fold(0.0, f64::max);
        // Covered shares and texels are f32.
        assert!((light(&flat, k) - light(&deep, k)).abs() <= 1e-6 * peak, "{k}");
        assert_eq!(flat.slices[k].expectation, deep.slices[k].expectation);
    }
    // Seen along the normal nothing moves.
    assert!(flat.slices[0] == deep.slices[0]);
    assert!(flat.slices[1] != deep.slices[1]);
    assert!(flat.provenance["check"]["parallax"].is_null());
    let error = &deep.provenance["check"]["parallax"];
    println!("parallax: {error}");
    let rows = error["rows"].as_array().unwrap();
    let column = |key: &str| rows.iter().map(|row| row[key].as_f64().unwrap()).collect::<Vec<_>>();
    let (texels, rms) = (column("texels"), column("rms_over_std"));
    assert!(texels[0] == 0.0 && rms[0] == 0.0);
    // theta_h = 0 alone would be 15 um tan(asin(sin(theta_i) / 1.5)) between two flakes half way down, of 13.33 um texels; a
    // tilted half vector adds to the refracted angles, but not to what is apart across it.
    let exact = |theta: f64| 15.0 / (20.0 / 1.5) * (theta.sin() / 1.5).asin().tan();
    for (k, texels) in texels.iter().enumerate().skip(1) {
        let theta = k as f64 * PI / 12.0;
        assert!((exact(theta)..1.2 * exact(theta)).contains(&(texels * (1.0 + 1e-12))), "{theta}: {texels}");
    }
    // The farther apart the images, the less they have in common: never more than nothing.
    assert!(rms.windows(2).all(|pair| pair[0] < pair[1]) && rms[5] < 2f64.sqrt(), "{rms:?}");
}

#[test]
fn expectation_is_the_smooth_brdf_of_the_cell() {
    let paint = paint(1, 0.7, 15.0, 6.5);
    let model = model(&paint);
    let btf = synthesize(&paint, &options(9, 32, 1)).unwrap();
    for (k, slice) in btf.slices.iter().enumerate() {
        let (theta_h, theta_i) = btf.grid.angles(k);
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let f = model.brdf_rgb(wi, wo);
        // The same sum in another order.
        assert!((f - DVec3::from(slice.expectation)).length() <= 1e-13 * f.length(), "{k}");
    }
    let (wi, wo) = btf.smooth.directions(10, 12, 80);
    // The table holds f32.
    assert!((btf.smooth.cell(10, 12, 80) / model.brdf_rgb(wi, wo) - 1.0).abs().max_element() < 1e-6);
    btf.validate().unwrap();
}

#[test]
fn the_error_of_other_azimuths_is_reported() {
    let grid = AngleGrid::triangle(12).unwrap();
    // Without refraction and without shading between flakes glitter is P / (4 cos cos'): all of it goes with the cosines.
    let thin = Composition {
        films: vec![Film {
            index: 1.0,
            absorption_per_mm: Spectrum::constant(0.0),
            ..paint(1, 1e-7, 10.0, 0.0).films[0].clone()
        }],
        ..paint(1, 1e-7, 10.0, 0.0)
    };
    let error = phi_d_error(&model(&thin), &grid);
    // Optical thickness of 1e-7 over cosines of 0.02 and more.
    assert!(error.without_cosines < 1e-5, "{error:?}");
    assert!(error.plain > 0.01, "{error:?}");
    let usual = paint(1, 1.0, 8.0, 6.5);
    let error = phi_d_error(&model(&usual), &grid);
    println!("phi_d: {error:?}");
    for value in [error.plain, error.without_cosines] {
        assert!(value.is_finite() && value > 0.0 && value < 1.0, "{error:?}");
    }
    // The rows hold the same squares, one theta_h each.
    assert_eq!(error.rows.len(), 12);
    let total = error.rows.iter().map(|row| row.share * row.plain.powi(2)).sum::<f64>().sqrt();
    assert!((total / error.plain - 1.0).abs() < 1e-12, "{total} {error:?}");
    assert!((error.rows.iter().map(|row| row.share).sum::<f64>() - 1.0).abs() < 1e-12);
    let btf = synthesize(&usual, &SynthesisOptions { grid, ..options(12, 32, 1) }).unwrap();
    assert_eq!(btf.provenance["check"]["phi_d"], serde_json::to_value(error).unwrap());
}

#[test]
fn no_flakes_make_flat_slices() {
    let none =
        Composition::parse("substrate = { albedo = 0.5 }\nfilm = [{ thickness_um = 0, index = 1.5 }]\n")
            .unwrap();
    let size = SynthesisOptions { texel_mm: Some(0.01), ..options(3, 8, 1) };
    let btf = synthesize(&none, &size).unwrap();
    assert!(btf.slices.iter().flat_map(|s| &s.fluctuation).all(|t| *t == [0.0; 3]));
    let message = synthesize(&none, &options(3, 8, 1)).unwrap_err().to_string();
    assert!(message.contains("texel size") && message.contains("none given"), "{message}");
    assert_eq!(btf.provenance["check"]["phi_d"]["plain"], 0.0);
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let wide = synthesize(&paint(1, 1.0, 15.0, 6.5), &options(3, 5, 1)).unwrap_err().to_string();
    assert!(wide.contains("diameter_um") && wide.contains("quarter of the texture"), "{wide}");
    let mirror = synthesize(&paint(1, 1.0, 15.0, 0.0), &options(3, 32, 1)).unwrap_err().to_string();
    assert!(mirror.contains("flake_lifetime_deg"), "{mirror}");
    let many = SynthesisOptions { texel_mm: Some(10.0), ..options(3, 512, 1) };
    let many = synthesize(&paint(1, 1.0, 15.0, 6.5), &many).unwrap_err().to_string();
    assert!(many.contains("flakes on the texture"), "{many}");
    // Twelve kinds that fit one by one: 0.8 x 64^2 mm^2 of flakes over 364.4 um^2 each.
    let kinds = SynthesisOptions { texel_mm: Some(0.125), ..options(3, 512, 1) };
    let together = synthesize(&paint(12, 0.8, 15.0, 6.5), &kinds).unwrap_err().to_string();
    assert!(together.contains("all kinds: found 107900466, expected 0 to 10000000"), "{together}");
    let huge = synthesize(&paint(1, 1.0, 15.0, 6.5), &options(90, 4096, 1)).unwrap_err().to_string();
    assert!(huge.contains("4095 slices of 4096 x 4096"), "{huge}");
}

/// Colors, pi f as Lab, at 45 degrees incidence and an aspecular angle (from the mirror direction towards the light).
fn aspecular(model: &Model, incidence_deg: f64, aspecular_deg: f64) -> DVec3 {
    let (wi, wo) = Reading::new(incidence_deg, aspecular_deg).unwrap().directions();
    lab_from_rgb(model.brdf_rgb(wi, wo) * PI)
}

fn fixture(name: &str) -> Model {
    let path = format!("{}/fixtures/compositions/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    model(&Composition::read(path.as_ref()).unwrap())
}

#[test]
fn the_ready_compositions_look_as_they_are_named() {
    let chroma = |lab: DVec3| lab.y.hypot(lab.z);
    let hue = |lab: DVec3| lab.z.atan2(lab.y).to_degrees().rem_euclid(360.0);
    for name in ["silver_metallic", "blue_metallic", "brown_metallic", "green_blue_flip_flop"] {
        let model = fixture(name);
        let labs = [15.0, 25.0, 45.0, 75.0, 110.0].map(|angle| aspecular(&model, 45.0, angle));
        let (steep, grazing) = (aspecular(&model, 15.0, 15.0), aspecular(&model, 75.0, 15.0));
        // The rows of fixtures/README.md.
        let row = labs.iter().chain([&steep, &grazing]).map(|l| format!("{:.1} {:.1} {:.1}", l.x, l.y, l.z));
        println!("| {name} | {} |", row.collect::<Vec<_>>().join(" | "));
        // Flop: every metallic darkens from near the mirror direction to far from it, by much.
        assert!(labs.windows(2).all(|pair| pair[0].x > pair[1].x), "{name}");
        assert!(labs[0].x - labs[2].x > 25.0, "{name}");
        let (near, face) = (labs[0], labs[2]);
        match name {
            "silver_metallic" => assert!(labs.iter().all(|lab| chroma(*lab) < 2.0)),
            "blue_metallic" => assert!(labs.iter().all(|lab| (255.0..300.0).contains(&hue(*lab)))),
            "brown_metallic" => assert!([near, face].iter().all(|lab| (30.0..75.0).contains(&hue(*lab)))),
            _ => {
                // Steep light shows green, grazing light blue.
                assert!((140.0..185.0).contains(&hue(steep)) && (235.0..290.0).contains(&hue(grazing)));
            }
        }
    }
}

#[test]
fn the_program_writes_a_btf_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("paint.btf.exr");
    let run = |composition: &std::path::Path, more: &[&str]| {
        common::carpaint()
            .arg("simulate")
            .arg(composition)
            .arg("-o")
            .arg(&output)
            .args(["--bins", "4", "--size", "32"])
            .args(more)
            .output()
            .unwrap()
    };
    let good =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/compositions/silver_metallic.toml");
    let done = run(&good, &["--json"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(summary["slices"], 10);
    assert_eq!(summary["bytes"], std::fs::metadata(&output).unwrap().len());
    let read = FlakeBtf::read(&output).unwrap();
    let composition: Composition = serde_json::from_value(read.provenance["composition"].clone()).unwrap();
    let same = synthesize(&Composition::read(&good).unwrap(), &options(4, 32, 1)).unwrap();
    assert!(read.slices.iter().zip(&same.slices).all(|(a, b)| a.fluctuation == b.fluctuation));
    assert!(read.smooth == same.smooth && read.grid == same.grid && read.texel_mm == same.texel_mm);
    // JSON keeps a spectrum to its last digit or two.
    for (a, b) in composition.films[0].flakes.iter().zip(&Composition::read(&good).unwrap().films[0].flakes) {
        let [a, b] = [a, b].map(|kind| kind.mirror.as_ref().unwrap().reflectance.0);
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15));
    }
    std::fs::remove_file(&output).unwrap();
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, "[substrate]\nalbedo = 0.5\ngloss = 1\n").unwrap();
    for (composition, more, word) in [
        (&bad, &[][..], "albedo"),
        (&folder.path().join("none.toml"), &[][..], "none.toml"),
        (&good, &["--texel-um", "-1"][..], "texel"),
    ] {
        let refused = run(composition, more);
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{message}");
        assert!(message.contains(word), "{message}");
        assert!(!output.exists());
    }
}
