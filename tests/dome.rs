//! The virtual dome: what is taken from perfect pictures of it is the model.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::brdf::{BrdfSample, SampleSet};
use carpaint::btf::FlakeSource;
use carpaint::color::luminance;
use carpaint::dome::{Dome, DomeOptions, options::Ring};
use carpaint::fit::{FitOptions, fit_samples};
use carpaint::math::half_difference::directions;
use carpaint::measure::{
    Extraction, Flash, Homogeneous, PairGeometry, Pairs, SamplingOptions, SliceOptions, cut_slices, extract,
};
use carpaint::simulate::{Composition, Model, ModelOptions};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

fn model(preset: &str) -> Model {
    let path = format!("{}/fixtures/compositions/{preset}.toml", env!("CARGO_MANIFEST_DIR"));
    Model::new(&Composition::read(path.as_ref()).unwrap(), ModelOptions::default()).unwrap()
}

/// Seven cameras, pictures of 96 x 96, a pixel 0.27 mm wide; a panel of 10 mm, which mirrors the flashes 2 mm off its middle.
fn small() -> DomeOptions {
    let ring = |cameras, polar_deg, first_azimuth_deg| Ring { cameras, polar_deg, first_azimuth_deg };
    DomeOptions {
        rings: vec![ring(1, 0.0, 0.0), ring(2, 20.0, 45.0), ring(4, 42.0, 10.0)],
        image_px: [96; 2],
        sample_mm: [10.0; 2],
        flash: Flash { offset_mm: [4.0, 0.0], size_mm: [8.0, 6.0], points: [10, 9] },
        ..DomeOptions::default()
    }
}

#[test]
fn samples_of_a_perfect_capture_are_the_model() {
    for preset in ["silver_metallic", "solid_red"] {
        let model = model(preset);
        let dome = Dome::new(&model, &small()).unwrap();
        let options = SamplingOptions { patch: [0.1, 0.1], ..SamplingOptions::default() };
        let Extraction { base, gloss, report } =
            extract(&dome, dome.options().sample_mm, &options, &|| ()).unwrap();
        let errors: Vec<f64> = (base.samples().iter().enumerate())
            .map(|(k, s)| {
                let truth = model.brdf_rgb(s.wi, s.wo) + DVec3::splat(model.gloss(s.wi, s.wo));
                luminance(DVec3::from_slice(base.values(k))) / luminance(truth) - 1.0
            })
            .collect();
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
        println!(
            "{preset}: {count} samples, {mean:+.4} +- {rms:.4}, {} of the gloss, {report:?}",
            gloss.len()
        );
        // Flakes of the same panel are in all pictures; some ten pictures of a few hundred patches are independent. Without
        // flakes what is left is the flash: 0.7 degrees wide, its middle taken for the truth of a gloss of 1 degree, whose peak is
        // lower by (0.7 / 1)^2 / 12 = 4 % under the whole of it.
        assert!(mean.abs() < if preset == "solid_red" { 4e-3 } else { 0.03 }, "{mean}");
        assert!(rms < if preset == "solid_red" { 0.04 } else { 0.2 }, "{rms}");
        assert!(report.left_out.is_empty() && report.blemishes.places_mm.is_empty(), "{report:?}");
        assert!(report.highlights.len() >= 3 && !gloss.is_empty());
        for highlight in &report.highlights {
            // A rough surface's is broader than the panel.
            assert_eq!(highlight.broad, preset == "solid_red", "{highlight:?}");
            assert!(highlight.distance_px.unwrap_or(0.0) < 0.1 * highlight.radius_px, "{highlight:?}");
        }
    }
}

/// The surface's bell is about the mirror direction, the lobe's about the half vector: towards grazing, where a gloss outshines all
/// else, they part, and what is seen near the normal must say how much is mirrored.
#[test]
fn the_gloss_of_a_rough_surface_is_that_near_the_normal() {
    let model = model("solid_red");
    let options = DomeOptions { image_px: [96; 2], ..DomeOptions::default() };
    let dome = Dome::new(&model, &options).unwrap();
    let Extraction { base, gloss, .. } =
        extract(&dome, dome.options().sample_mm, &SamplingOptions::default(), &|| ()).unwrap();
    let options = FitOptions { starts: 4, table_size: [16, 16], ..FitOptions::default() };
    let (smooth, _) = fit_samples(&base, Some(&gloss), &options, &|| ()).unwrap();
    let lobe = smooth.coat.gloss.expect("a gloss");
    println!("{lobe:?}, s F0 {}", lobe.coefficient * lobe.f0);
    // Index 1.5: F0 of 0.04, a quarter of which is s F0. A bell of standard deviation 1 degree about the mirror direction is a
    // roughness of 1 / sqrt(2) degrees about the half vector. The laws differ, and pixels are 0.27 mm wide: some 6 % each; drawing
    // samples without their cosines gives 33 % of s F0 too much, the gloss set alone 24 %.
    assert!((lobe.coefficient * lobe.f0 / 0.01 - 1.0).abs() < 0.15, "{lobe:?}");
    assert!((lobe.roughness / 0.01234 - 1.0).abs() < 0.15, "{lobe:?}");
}

#[test]
fn slices_keep_the_energy_of_the_pictures() {
    let model = model("silver_metallic");
    let dome = Dome::new(&model, &small()).unwrap();
    let base = |wi: DVec3, wo: DVec3| model.brdf_rgb(wi, wo);
    let smooth = Homogeneous { base: &base, gloss: &|wi, wo| model.gloss(wi, wo) };
    let Extraction { report, .. } =
        extract(&dome, dome.options().sample_mm, &SamplingOptions::default(), &|| ()).unwrap();
    let options = SliceOptions { bins: 6, ..SliceOptions::new(0.27) };
    let (btf, cut) =
        cut_slices(&dome, dome.options().sample_mm, &smooth, &report.blemishes, &options, &|| ()).unwrap();
    println!("{cut:?}");
    assert_eq!((btf.size, cut.slices), ([18, 18], btf.grid().len()));
    for k in 0..btf.grid().len() {
        let slice = btf.slice(k).unwrap();
        let texels = slice.fluctuation.iter().map(|t| luminance(DVec3::from(t.map(f64::from))));
        let (sum, squares) = texels.fold((0.0, 0.0), |(s, q), l| (s + l, q + l * l));
        let count = slice.fluctuation.len() as f64;
        let error = (squares / count).sqrt() / count.sqrt();
        // f32 texels.
        assert!((sum / count).abs() < 1e-5 * (squares / count).sqrt(), "slice {k} fluctuates about zero");
        let (theta_h, theta_i) = btf.grid().angles(k);
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let residual = luminance(DVec3::from(slice.expectation) - base(wi, wo));
        // What the explicit flakes of a square differ from their expectation by: five standard errors, texels a little dependent
        // and neighbors weighed unevenly.
        assert!(residual.abs() < 5.0 * 1.5 * error, "slice {k}: {residual} +- {error}");
    }
}

/// A dome whose panel has a dark scratch along y.
struct Scratched<'a>(&'a Dome<'a>);

impl Scratched<'_> {
    const X_MM: f64 = 3.0;
    const HALF_MM: f64 = 0.5;
}

impl Pairs for Scratched<'_> {
    fn cameras(&self) -> usize {
        self.0.cameras()
    }
    fn geometry(&self, camera: usize, light: usize) -> Option<PairGeometry> {
        self.0.geometry(camera, light)
    }
    fn size(&self) -> [usize; 2] {
        self.0.size()
    }
    fn radiance(&self, camera: usize, light: usize) -> carpaint::Result<Vec<[f32; 3]>> {
        let mut pixels = Pairs::radiance(self.0, camera, light)?;
        let (columns, seen) = (self.size()[0], self.geometry(camera, light).unwrap().camera);
        for (k, pixel) in pixels.iter_mut().enumerate() {
            let at = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
            let place = seen.on_plane(at, 0.0).unwrap();
            if (place.x - Self::X_MM).abs() < Self::HALF_MM {
                *pixel = pixel.map(|c| 0.4 * c);
            }
        }
        Ok(pixels)
    }
}

#[test]
fn a_scratch_is_found_and_left_out() {
    let model = model("silver_metallic");
    let dome = Dome::new(&model, &small()).unwrap();
    let sample_mm = dome.options().sample_mm;
    let options = SamplingOptions { patch: [0.05, 0.1], ..SamplingOptions::default() };
    let scratched = Scratched(&dome);
    let Extraction { base, report, .. } = extract(&scratched, sample_mm, &options, &|| ()).unwrap();
    println!("{} cells, {} samples left out", report.blemishes.places_mm.len(), report.blemished);
    // Cells are 0.7 mm wide: at least one of every row across the sample.
    assert!(report.blemishes.places_mm.len() >= 14 && report.blemished > 0, "{:?}", report.blemishes);
    for place in &report.blemishes.places_mm {
        // Neighbors of a dark cell are as bright as theirs, but for the median of those at the edge.
        assert!((place[0] - Scratched::X_MM).abs() < 1.1 + Scratched::HALF_MM, "{place:?}");
    }
    let whole = extract(&dome, sample_mm, &options, &|| ()).unwrap().base;
    let mean = |set: &SampleSet| {
        let error = |(k, s): (usize, &BrdfSample)| {
            luminance(DVec3::from_slice(set.values(k))) / luminance(model.brdf_rgb(s.wi, s.wo)) - 1.0
        };
        set.samples().iter().enumerate().map(error).sum::<f64>() / set.len() as f64
    };
    // A scratch of 1 in 10 mm that takes 60 % would darken the mean by 6 %.
    assert!((mean(&base) - mean(&whole)).abs() < 0.02, "{} {}", mean(&base), mean(&whole));
    let base = |wi: DVec3, wo: DVec3| model.brdf_rgb(wi, wo);
    let smooth = Homogeneous { base: &base, gloss: &|wi, wo| model.gloss(wi, wo) };
    let cut = SliceOptions { bins: 6, share: 0.3, ..SliceOptions::new(0.27) };
    let (btf, _) = cut_slices(&scratched, sample_mm, &smooth, &report.blemishes, &cut, &|| ()).unwrap();
    assert!(!btf.slices.is_empty());
}
