//! What the figures of Golla & Klein 2018 show, in numbers.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::color::lab_from_rgb;
use carpaint::fit::SmoothFit;
use carpaint::math::half_difference::spherical;
use carpaint::mix::{CoupleOptions, couple};
use carpaint::paint::Paint;
use carpaint::report::{ChainOptions, run_chain};
use carpaint::simulate::Composition;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;

fn simulated(preset: &str) -> Paint {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{preset}.toml"));
    let sizes = ChainOptions { bins: 6, size: 16, texel_mm: Some(0.02), seed: 1 };
    run_chain(preset, &Composition::read(&path).unwrap(), &sizes, |_, _| || ()).unwrap().paint
}

/// a, b of the paint at an aspecular angle, degrees, light at 45 degrees.
fn chroma(paint: &Paint, aspecular: f64) -> DVec2 {
    let wo = spherical((aspecular - 45.0).to_radians(), 0.0);
    let lab = lab_from_rgb(PI * SmoothFit::from(paint).eval(spherical(FRAC_PI_4, 0.0), wo));
    DVec2::new(lab.y, lab.z)
}

#[test]
fn the_flip_flop_weakens_steadily_towards_gray() {
    let (flip_flop, gray) = (simulated("green_blue_flip_flop"), simulated("silver_metallic"));
    let named = [("flip-flop".to_owned(), &flip_flop), ("gray".to_owned(), &gray)];
    let (mix, _) = couple(&named, &CoupleOptions::default(), &|| ()).unwrap();
    let apart: Vec<f64> = [0.0, 0.25, 0.5, 0.75, 1.0]
        .map(|w| {
            let paint = mix.blend(&[1.0 - w, w]).unwrap();
            chroma(&paint, 15.0).distance(chroma(&paint, 110.0))
        })
        .into();
    // Fig. 6: a strong change of hue at one end, next to none at the other, and less with every step between.
    assert!(apart[0] > 20.0 && apart[4] < 5.0, "{apart:?}");
    assert!(apart.windows(2).all(|pair| pair[1] < pair[0] - 1.0), "{apart:?}");
    // What it flips to near the highlight is a green-blue.
    let near = chroma(&flip_flop, 15.0);
    assert!(near.x < -10.0 && near.y < 0.0, "{near}");
}
