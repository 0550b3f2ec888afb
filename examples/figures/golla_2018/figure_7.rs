//! Fig. 7: a capsule that is moved among three others, and a car, in the paint that their distances give.

use super::{BLUE, BROWN, GRAY};
use crate::paints::{mix, simulated};
use crate::{Figure, Finding, pictures};
use carpaint::cluster::SliceStatistics;
use carpaint::color::{delta_e_76, lab_from_rgb};
use carpaint::error::Result;
use carpaint::fit::SmoothFit;
use carpaint::math::half_difference::spherical;
use carpaint::mix::{Mix, distance_weights};
use carpaint::paint::Paint;
use carpaint::render::{RenderPaint, ToneMap, render};
use carpaint::scene::Scene;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-7",
    claim: "the moved capsule has a sample's paint where it meets the sample, and changes smoothly on the way",
    draw,
};

/// Which object of the scene is moved; before it come the samples.
const MOVED: usize = 3;

fn draw(name: &Path) -> Result<Finding> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes/demo.toml");
    let mut scene = Scene { size: [640, 360], ..Scene::read(&path)? };
    let place = |k: usize| DVec3::from(scene.objects[k].position_mm).truncate();
    let samples = [0, 1, 2].map(place);
    let desk = Desk { mix: mix([BLUE, BROWN, GRAY])?, samples };
    let paints = [BLUE, BROWN, GRAY].map(simulated);
    let paints = paints.into_iter().collect::<Result<Vec<_>>>()?;
    let mut tiles = Vec::new();
    // Beside each sample, and in their middle.
    for at in [[-42.0, 12.0], [14.0, 34.0], [42.0, 12.0], [0.0, 16.0]] {
        scene.objects[MOVED].position_mm = [at[0], at[1], 0.0];
        let moved = desk.paint(at.into())?;
        let all = paints.iter().map(AsRef::as_ref).chain([&moved]).map(RenderPaint::new);
        tiles.push(render(&scene, &all.collect::<Result<Vec<_>>>()?, &pictures::OPTIONS, &|| ())?);
    }
    let whole = pictures::mosaic(&tiles, 2);
    whole.write(&name.with_added_extension("png"), scene.exposure_stops, &ToneMap::Srgb)?;
    let off = samples.iter().zip(&paints).map(|(at, paint)| Ok(difference(&desk.paint(*at)?, paint)));
    let off = off.collect::<Result<Vec<[f64; 2]>>>()?;
    let [smooth, flakes] = [0, 1].map(|k| off.iter().map(|off| off[k]).fold(0.0, f64::max));
    let [coarse, fine] = [desk.largest_step(24)?, desk.largest_step(96)?];
    let rest = desk.largest_rest(96)?;
    Ok(Finding {
        // Single precision is some 1e-7. Four times the frames leave a step a fourth of its size where the path has no jump; twice that is allowed.
        holds: smooth < 1e-4 && flakes < 1e-4 && rest < 1e-12 && fine < 0.5 * coarse,
        says: format!(
            "at the samples the smooth part is off by Delta-E 1976 {smooth:.0e} and flakes' mean by {flakes:.0e} / sr; weights sum to 1 within {rest:.0e}; on a path through all samples the color \
             moves by Delta-E 1976 {coarse:.2} a frame at most in 24 frames and {fine:.2} in 96"
        ),
    })
}

/// Samples that stand somewhere.
struct Desk {
    mix: Mix,
    samples: [DVec2; 3],
}

impl Desk {
    fn weights(&self, at: DVec2) -> Result<Vec<f64>> {
        distance_weights(&self.samples.map(|sample| sample.distance(at)))
    }

    fn paint(&self, at: DVec2) -> Result<Paint> {
        self.mix.blend(&self.weights(at)?)
    }

    /// Places from the first sample by the second to the third.
    fn path(&self, frames: usize) -> impl Iterator<Item = DVec2> {
        (0..=frames).map(move |k| {
            let t = 2.0 * k as f64 / frames as f64;
            let leg = (t as usize).min(1);
            self.samples[leg].lerp(self.samples[leg + 1], t - leg as f64)
        })
    }

    /// Largest change of color from a frame to the next, Delta-E 1976.
    fn largest_step(&self, frames: usize) -> Result<f64> {
        let colors =
            self.path(frames).map(|at| Ok(color(&self.paint(at)?, 25.0))).collect::<Result<Vec<_>>>()?;
        Ok(colors.windows(2).map(|pair| delta_e_76(pair[0], pair[1])).fold(0.0, f64::max))
    }

    /// Largest difference of the sum of the weights from 1.
    fn largest_rest(&self, frames: usize) -> Result<f64> {
        let rests = self.path(frames).map(|at| Ok((self.weights(at)?.iter().sum::<f64>() - 1.0).abs()));
        rests.collect::<Result<Vec<_>>>().map(|rests| rests.into_iter().fold(0.0, f64::max))
    }
}

/// Largest difference of the smooth parts, Delta-E 1976, and of what flakes add in the mean of a slice, linear RGB, 1/sr.
fn difference(found: &Paint, sample: &Paint) -> [f64; 2] {
    let smooth = [15.0, 25.0, 45.0, 75.0, 110.0].map(|at| delta_e_76(color(found, at), color(sample, at)));
    let slices = |paint: &Paint| -> Vec<DVec3> {
        let levels = paint.flakes.iter().flat_map(|flakes| &flakes.levels);
        levels.flat_map(|level| &level.slices).map(SliceStatistics::mean_rgb).collect()
    };
    let slices = slices(found).into_iter().zip(slices(sample)).map(|(a, b)| (a - b).abs().max_element());
    [smooth.into_iter().fold(0.0, f64::max), slices.fold(0.0, f64::max)]
}

/// Lab of the smooth part at an angle from the mirror direction, degrees, light at 45 degrees.
fn color(paint: &Paint, aspecular: f64) -> DVec3 {
    let wo = spherical((45.0 - aspecular).to_radians(), PI);
    lab_from_rgb(PI * SmoothFit::from(paint).eval(spherical(FRAC_PI_4, 0.0), wo))
}
