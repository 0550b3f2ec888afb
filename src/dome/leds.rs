//! Pictures for calibration: diodes in the dark, and gray fields.

use super::DomeOptions;
use super::stand::Stand;
use crate::math::projection::Projection;
use glam::DVec2;

/// Radius of a diode's spot, millimetres on the plate and at least pixels (the blur of a lens).
const SPOT: [f64; 2] = [0.35, 0.9];
/// Light of a spot's middle, 1 = saturated.
const PEAK: f64 = 0.5;
/// Light of the gray field at a relative time of 1.
const FIELD: f64 = 0.6;

/// Linear light of a picture of the diodes, 0 in between.
pub(super) fn leds(options: &DomeOptions, stand: &Stand, camera: usize, zoomed: bool) -> Vec<[f64; 3]> {
    let truth = stand.truth.cameras[camera];
    let intrinsics = if zoomed { truth.intrinsics } else { stand.truth.wide };
    let projection = Projection { intrinsics, ..truth };
    let size = options.image_px;
    let mut light = vec![[0.0; 3]; size[0] * size[1]];
    let distance = truth.pose.position_mm.length();
    let sigma = (SPOT[0] * intrinsics.focal_px / distance).max(SPOT[1]);
    for led in &stand.rig.leds_mm {
        if let Some(center) = projection.pixel(DVec2::from(*led).extend(0.0)) {
            add_spot(&mut light, size, center, sigma);
        }
    }
    light
}

/// Adds a round Gaussian spot.
fn add_spot(light: &mut [[f64; 3]], size: [usize; 2], center: DVec2, sigma: f64) {
    let reach = 4.0 * sigma;
    let bounds = |axis: usize| {
        let clamp = |x: f64| x.clamp(0.0, size[axis] as f64) as usize;
        clamp((center[axis] - reach).floor())..clamp((center[axis] + reach).ceil())
    };
    for row in bounds(1) {
        for column in bounds(0) {
            let offset = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - center;
            let value = PEAK * (-0.5 * offset.length_squared() / (sigma * sigma)).exp();
            light[row * size[0] + column].iter_mut().for_each(|c| *c += value);
        }
    }
}

/// Linear light of the gray field at a step of the series.
pub(super) fn gray_field(options: &DomeOptions, stand: &Stand, step: usize) -> Vec<[f64; 3]> {
    let light = FIELD * stand.rig.response_series[step];
    vec![[light; 3]; options.image_px[0] * options.image_px[1]]
}
