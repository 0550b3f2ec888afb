//! Pictures: rays a pixel, directions into the surroundings.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::error::Result;
use crate::render::{Options, Picture, PictureDifference, RenderPaint, render};
use crate::scene::Scene;

const SAMPLES: [usize; 6] = [1, 2, 4, 8, 16, 32];
const DIRECTIONS: [usize; 6] = [6, 12, 24, 48, 96, 192];
/// Directions of the truth.
const DIRECTIONS_OF_TRUTH: usize = 1024;

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let paint = [RenderPaint::new(&subject.chain.paint)?];
    let scene = Scene { size: if effort.quick { [45, 60] } else { [90, 120] }, ..Scene::default() };
    let picture = |options: Options| render(&scene, &paint, &options, &|| ());
    let usual = Options { seed: effort.seed, ..Options::default() };
    let flip = |truth: &Picture, found: &Picture| Ok((PictureDifference::of(truth, found)?.flip, None));

    // Without flakes: those that rays see through finer pixels are others, and directions do not change their places.
    let smooth = Options { flakes: false, ..usual };
    let rays = if effort.quick { 128 } else { 512 };
    let truth = picture(Options { samples: rays, ..smooth })?;
    let samples = SAMPLES.map(|samples| {
        let options = Options { samples, ..smooth };
        Trial::new(samples, samples == usual.samples, move || picture(options))
    });
    let head = Head {
        stage: "Rendering",
        knob: "rays a pixel (--samples)",
        error: "mean FLIP, 0 to 1, of the smooth part against 512 rays (128 with --quick)",
        why: "The error falls with the root of the rays and the cost with their number, so that no setting is special: eight leave edges \
              and highlights as an eye sees them at arm's length.",
    };
    let mut curves = vec![curve(head, &samples, *effort, |found| flip(&truth, found))?];

    let truth = picture(Options { directions: DIRECTIONS_OF_TRUTH, ..smooth })?;
    let directions = DIRECTIONS.map(|directions| {
        let options = Options { directions, ..smooth };
        Trial::new(directions, directions == usual.directions, move || picture(options))
    });
    let head = Head {
        stage: "Rendering",
        knob: "directions into the surroundings a ray",
        error: "mean FLIP, 0 to 1, of the smooth part against 1024 directions",
        why: "What eight rays of 48 directions leave is far below what one step of eight bits shows; fewer would show as steps in broad \
              highlights.",
    };
    curves.push(curve(head, &directions, *effort, |found| flip(&truth, found))?);
    Ok(curves)
}
