//! The virtual dome calibrated from its own pictures and held against its truth (Rump et al. 2008, section 4).
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::dome::{Dome, DomeOptions};
use carpaint::measure::Images;
use carpaint::measure::calibrate::{Calibration, CalibrationErrors, CalibrationTruth, PixelState, calibrate};
use carpaint::simulate::{Composition, Model, ModelOptions};

fn model(preset: &str) -> Model {
    let path = format!("{}/fixtures/compositions/{preset}.toml", env!("CARGO_MANIFEST_DIR"));
    Model::new(&Composition::read(path.as_ref()).unwrap(), ModelOptions::default()).unwrap()
}

fn errors(dome: &Dome, found: &Calibration) -> CalibrationErrors {
    let truth = dome.truth();
    let sensor = |camera: usize| &truth.sensors[camera];
    let response = |camera: usize, c: usize, light: f64| {
        sensor(camera).response[c].respond(light * sensor(camera).gain[c])
    };
    let saturation = |camera: usize, c: usize| 1.0 / sensor(camera).gain[c];
    let truth = CalibrationTruth {
        wide: truth.wide,
        cameras: &truth.cameras,
        response: &response,
        saturation: &saturation,
    };
    found.errors_against(&truth, dome.rig())
}

#[test]
fn the_default_dome_is_found_within_its_errors() {
    let model = model("silver_metallic");
    let options = DomeOptions::default();
    let dome = Dome::new(&model, &options).unwrap();
    let found = calibrate(&dome, &|| ()).unwrap();
    assert_eq!(found.geometry.left_out, []);
    let errors = errors(&dome, &found);
    println!("rms {:?}, focal length {:e}", errors.rms, errors.wide_focal);
    for camera in &errors.cameras {
        println!("{camera:?} {:?}", found.geometry.quality[camera.camera].unwrap());
        // Four standard errors of three numbers together; what hides in pose and lens together moves no pixel of the sample.
        assert!(camera.over_expected.iter().all(|z| *z < 4.0), "{camera:?}");
        assert!(camera.sample_px < 0.3, "{camera:?}");
        // Fields an octave apart; beyond the last one, at 0.6 of saturation, the curve is extrapolated.
        assert!(camera.response.iter().all(|error| *error < 5e-3), "{camera:?}");
    }
    let unit = std::f64::consts::PI * options.radius_mm.powi(2);
    for (camera, light) in [(1, 3), (15, 10)] {
        let picture = found.merge(&dome, camera, light).unwrap();
        let truth = dome.radiance(camera, light);
        // What stands out of the noise by ten.
        let is_clear = |k: &usize| picture.pixels[*k][1] > 10.0 * picture.variance[*k][1].sqrt();
        let valid = (0..truth.len()).filter(|k| picture.mask[*k] == PixelState::Valid).filter(is_clear);
        let ratios: Vec<f64> = valid.map(|k| f64::from(picture.pixels[k][1]) * unit / truth[k][1]).collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        println!(
            "{camera} {light}: {} pixels, {mean:.5}, {:?} dB, {:?}",
            ratios.len(),
            picture.range_db,
            picture.warnings
        );
        println!("   {:?} {:?}", picture.relative, picture.white.as_ref().unwrap().targets);
        assert!(ratios.len() > 5_000);
        // Response curves to parts of a thousand, flashes of a percent that differ between the exposures.
        assert!((mean - 1.0).abs() < 0.01, "{camera} {light}: {mean}");
    }
}
