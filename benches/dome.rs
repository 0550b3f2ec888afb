//! Round trip of presets through the virtual dome: photographed, calibrated, sampled, fitted and cut into slices, held against the
//! composition, at several times the default noise (Rump et al. 2008, sections 4 and 5).
//!
//! A row a preset and noise: errors of poses and of the light in merged pictures; gloss, coefficient times F0 and roughness;
//! CIEDE2000 of the smooth part at 5, 10 ... 80 degrees (cameras end at 75), light going straight on, and (at noise 1) beneath a coat of the
//! true index that refracts it; flakes against slices synthesized directly (W1 in Delta-E, what two syntheses differ by, contrast).
//!
//! Arguments: parts of names of presets, and factors on the noise (default: all presets; 0, 1, 3). `--dome TOML`: another dome.
//! `--stream N`: pictures are made whenever they are asked for, as if read from disk, so that the peak of memory is that of the
//! chain; N pairs are sampled, and slices are cut in 6 bins (a solid paint has no panel of flakes to keep).
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::brdf::ClearCoat;
use carpaint::dome::{Dome, DomeOptions};
use carpaint::fit::{FitOptions, fit_samples};
use carpaint::measure::calibrate::calibrate;
use carpaint::measure::{Calibrated, Extraction, Images, Pairs, Picture, Rig, Shot, extract};
use carpaint::report::{
    AngleError, CaptureOptions, MeasuredPaint, SliceError, calibration_errors, color_errors, measure_paint,
    peak_memory_mib, radiance_error, slice_errors,
};
use carpaint::simulate::{Composition, Model, ModelOptions};
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::PathBuf;
use std::time::Instant;

/// Index of the clear binders of the presets.
const INDEX: f64 = 1.5;
/// Every so many pairs the light in their pictures is compared.
const STRIDE: usize = 17;

/// All pictures of a dome, in memory: every stage asks for them again.
struct Album<'a> {
    rig: &'a Rig,
    pictures: HashMap<Shot, Picture>,
}

impl<'a> Album<'a> {
    fn of(dome: &'a Dome) -> Self {
        let rig = Images::rig(dome);
        let cameras = 0..rig.cameras.len();
        let mut shots = Vec::new();
        for camera in cameras.clone() {
            shots.extend([Shot::LedsWide { camera }, Shot::LedsZoom { camera }]);
            shots.extend((0..rig.response_series.len()).map(|step| Shot::Response { camera, step }));
        }
        let singles = shots.into_par_iter().map(|shot| (shot, dome.picture(shot).expect("a picture")));
        let pairs: Vec<(usize, usize)> =
            cameras.clone().flat_map(|camera| cameras.clone().map(move |light| (camera, light))).collect();
        let exposures = pairs.into_par_iter().flat_map_iter(|(camera, light)| {
            let shot = move |exposure| Shot::Pair { camera, light, exposure };
            dome.pair(camera, light).into_iter().enumerate().map(move |(k, picture)| (shot(k), picture))
        });
        Self { rig, pictures: singles.chain(exposures).collect() }
    }
}

impl Images for Album<'_> {
    fn rig(&self) -> &Rig {
        self.rig
    }

    fn picture(&self, shot: Shot) -> carpaint::Result<Picture> {
        Ok(self.pictures[&shot].clone())
    }
}

/// Seconds since the last call.
fn lap(start: &mut Instant) -> f64 {
    std::mem::replace(start, Instant::now()).elapsed().as_secs_f64()
}

fn colors(errors: &[AngleError]) -> String {
    errors.iter().map(|e| format!("{:5.2}", e.mean)).collect::<Vec<_>>().join(" ")
}

/// The same samples beneath a coat of the true index.
fn refracting(pairs: &dyn Pairs, options: &CaptureOptions, rig: &Rig, model: &Model) -> String {
    let Extraction { base, gloss, .. } =
        extract(pairs, rig.sample_mm, &options.sampling, &|| ()).expect("samples");
    let coat = Some(ClearCoat { ior: INDEX, refracts: true, ..ClearCoat::NONE });
    let gloss = (!gloss.is_empty()).then_some(&gloss);
    let (smooth, report) =
        fit_samples(&base, gloss, &FitOptions { coat, ..options.fit.clone() }, &|| ()).expect("a fit");
    format!(
        "E {:.3} chi {:.3} | {}",
        report.error,
        report.colored_error,
        colors(&color_errors(&smooth, model))
    )
}

fn round_trip(name: &str, model: &Model, options: &DomeOptions, stream: Option<usize>) {
    let mut clock = Instant::now();
    let dome = Dome::new(model, options).expect("a dome");
    let album = stream.is_none().then(|| Album::of(&dome));
    let images: &dyn Images = album.as_ref().map_or(&dome, |album| album);
    let rig = images.rig();
    let photographed = lap(&mut clock);
    let found = calibrate(images, &|| ()).expect("a calibration");
    let calibrated = lap(&mut clock);
    let pairs = Calibrated::new(images, &found);
    let mut capture = CaptureOptions::new(rig, FitOptions::default());
    if let Some(count) = stream {
        capture.sampling.pairs = count;
        capture.slices.bins = 6;
    }
    let MeasuredPaint { smooth, btf, extraction, fit, slices } =
        measure_paint(&pairs, rig.sample_mm, &capture, |_, _| || ()).expect("a paint");
    let (measured, memory) = (lap(&mut clock), peak_memory_mib().unwrap_or(f64::NAN));
    let poses = calibration_errors(&found, dome.truth(), rig);
    let light = radiance_error(&pairs, &dome, STRIDE * stream.map_or(1, |_| STRIDE));
    println!(
        "{name} noise {}: poses {:.4} mm {:.5} deg {:.4} px | light {:.2} % ({:.3} % of means) | highlights {} of {}, {} broad, \
         left out {}, blemishes {}",
        options.noise,
        poses.rms[0],
        poses.rms[1],
        poses.rms[2],
        100.0 * light.rms,
        100.0 * light.of_means,
        extraction.highlights.iter().filter(|h| h.distance_px.is_some()).count(),
        extraction.highlights.len(),
        extraction.highlights.iter().filter(|h| h.broad).count(),
        extraction.left_out.len() + slices.left_out.len(),
        extraction.blemishes.places_mm.len(),
    );
    let gloss = smooth.coat.gloss.map_or("none".to_owned(), |lobe| {
        format!("s F0 {:.5} roughness {:.4}", lobe.coefficient * lobe.f0, lobe.roughness)
    });
    println!(
        "  gloss {gloss} (to {:.1} degrees) | diffuse {:.4} | {}",
        fit.gloss_end_deg,
        smooth.diffuse,
        smooth
            .lobes
            .iter()
            .map(|l| format!("s {:.4} m {:.3} F0 {:.4}", l.coefficient, l.roughness, l.f0))
            .collect::<Vec<_>>()
            .join(", ")
    );
    println!(
        "  straight   E {:.3} chi {:.3} | {}",
        fit.error,
        fit.colored_error,
        colors(&color_errors(&smooth, model))
    );
    if options.noise == 1.0 && stream.is_none() {
        println!("  refracting {}", refracting(&pairs, &capture, rig, model));
    }
    let errors = slice_errors(&btf, model, &|| ()).expect("slices");
    let weighed = |f: fn(&SliceError) -> f64| -> f64 { errors.iter().map(|e| e.weight * f(e)).sum() };
    println!(
        "  {} slices: W1 {:.2} ({:.2}), contrast {:.3} | s: photographed {photographed:.0}, calibrated {calibrated:.1}, measured \
         {measured:.1} | {memory:.0} MiB",
        slices.slices,
        weighed(|e| e.wasserstein),
        weighed(|e| e.floor),
        weighed(|e| e.deviation_ratio.unwrap_or(0.0)),
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let mut dome = None;
    let mut stream = None;
    let mut noises = Vec::new();
    let mut wanted = Vec::new();
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--dome" => dome = arguments.next(),
            "--stream" => stream = arguments.next().map(|n| n.parse().expect("a number of pairs")),
            number if number.parse::<f64>().is_ok() => noises.push(number.parse().expect("a number")),
            _ => wanted.push(argument),
        }
    }
    if noises.is_empty() {
        noises = vec![0.0, 1.0, 3.0];
    }
    let base = dome.map_or_else(DomeOptions::default, |path| {
        DomeOptions::parse(&std::fs::read_to_string(path).expect("a file")).expect("a dome")
    });
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions");
    let mut presets: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("presets").map(|entry| entry.expect("a file").path()).collect();
    presets.sort();
    for path in presets {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        if !wanted.is_empty() && !wanted.iter().any(|part| name.contains(part.as_str())) {
            continue;
        }
        let composition = Composition::read(&path).expect("a preset");
        let model = Model::new(&composition, ModelOptions::default()).expect("a model");
        for noise in &noises {
            round_trip(&name, &model, &DomeOptions { noise: *noise, ..base.clone() }, stream);
        }
    }
}
