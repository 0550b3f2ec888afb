//! The virtual dome: what its cameras see is the model, and what is taken from their pictures is, too.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::dome::{Dome, DomeOptions, options::Ring};
use carpaint::measure::{Extraction, Pairs, SamplingOptions, SliceOptions, cut_slices, extract};
use carpaint::simulate::{Composition, Model, ModelOptions};
use glam::{DVec2, DVec3};

fn model(preset: &str) -> Model {
    let path = format!("{}/fixtures/compositions/{preset}.toml", env!("CARGO_MANIFEST_DIR"));
    Model::new(&Composition::read(path.as_ref()).unwrap(), ModelOptions::default()).unwrap()
}

/// Eleven cameras, pictures of 96 x 96, a pixel 0.27 mm wide.
fn small() -> DomeOptions {
    let ring = |cameras, polar_deg, first_azimuth_deg| Ring { cameras, polar_deg, first_azimuth_deg };
    DomeOptions {
        rings: vec![ring(1, 0.0, 0.0), ring(4, 20.0, 45.0), ring(6, 42.0, 10.0)],
        image_px: [96; 2],
        ..DomeOptions::default()
    }
}

fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

fn taken(dome: &Dome, options: &SamplingOptions) -> Extraction {
    extract(dome, dome.options().sample_mm, options, &|| ()).unwrap()
}

#[test]
fn samples_of_a_perfect_capture_are_the_model() {
    for preset in ["silver_metallic", "solid_red"] {
        let model = model(preset);
        let dome = Dome::new(&model, &small()).unwrap();
        let options = SamplingOptions { patch: [0.1, 0.1], ..SamplingOptions::default() };
        let Extraction { base, gloss, report } = taken(&dome, &options);
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for (k, sample) in base.samples().iter().enumerate() {
            let truth = model.brdf_rgb(sample.wi, sample.wo) + model.gloss(sample.wi, sample.wo);
            let found = DVec3::from_slice(base.values(k));
            let error = luminance(found) / luminance(truth) - 1.0;
            sum += error;
            squares += error * error;
            count += 1.0;
        }
        let (mean, deviation) = (sum / count, (squares / count).sqrt());
        println!("{preset}: {count} samples, mean error {mean:.4}, rms {deviation:.4}, gloss {}", gloss.len());
        println!("  {:?} {:?}", report.highlights, report.left_out);
    }
    panic!();
}

#[test]
fn scratch_slices() {
    let model = model("silver_metallic");
    let dome = Dome::new(&model, &small()).unwrap();
    let smooth = |wi: DVec3, wo: DVec3| model.brdf_rgb(wi, wo);
    let start = std::time::Instant::now();
    let (btf, report) =
        cut_slices(&dome, dome.options().sample_mm, &smooth, &SliceOptions::new(0.27), &|| ()).unwrap();
    println!("{report:?} {:?} {:?}", btf.size, start.elapsed());
    let _ = dome.geometry(0, 0).unwrap().angles(DVec2::ZERO);
    panic!();
}
