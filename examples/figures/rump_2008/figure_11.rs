//! Fig. 11: three materials, specular blue, flip-flop and silver, in two surroundings, each picture with its own exposure.

use super::{FLIP_FLOP, sunny};
use crate::mosaic::{below, beside, exposed, quick, write};
use crate::panel::luminances;
use crate::{Figure, Finding, paints};
use carpaint::error::Result;
use carpaint::render::{Options, Picture, RenderPaint, render};
use carpaint::scene::{Camera, Environment, Scene, Shape};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-11",
    claim: "the density of flakes increases from left to right, and in direct sunlight all of them sparkle more than without",
    draw,
};

const PRESETS: [&str; 3] = ["blue_metallic", FLIP_FLOP, "silver_metallic"];
/// Share of the pixels that an exposure shows as white.
const WHITE: f64 = 0.015;

fn draw(name: &Path) -> Result<Finding> {
    let (environment, sun) = sunny();
    let scenes = [overcast(), Scene { environment, lights: vec![sun], ..overcast() }];
    let (mut rows, mut sparkle, mut density) = (Vec::new(), Vec::new(), Vec::new());
    for scene in &scenes {
        let mut tiles = Vec::new();
        for preset in PRESETS {
            let paint = RenderPaint::new(&*paints::simulated(preset)?)?;
            let picture = |flakes: bool| {
                let options = Options { flakes, samples: 4, ..quick() };
                render(scene, std::slice::from_ref(&paint), &options, &|| ())
            };
            let whole = picture(true)?;
            sparkle.push(deviation(&whole, &picture(false)?));
            let stops = whole.exposure(WHITE);
            tiles.push(exposed(whole, stops));
        }
        rows.push(beside(&tiles));
    }
    write(name, &below(&rows))?;
    for preset in PRESETS {
        let films = paints::composition(preset)?.films;
        density.push(films.iter().flat_map(|film| &film.flakes).map(|kind| kind.area_density).sum::<f64>());
    }
    let (cloudy, sun) = sparkle.split_at(PRESETS.len());
    Ok(Finding {
        holds: density.windows(2).all(|pair| pair[0] < pair[1]) && cloudy.iter().zip(sun).all(|(c, s)| s > c),
        says: format!(
            "area of flakes over area of paint {density:.2?}; the flakes' standard deviation over the picture's mean {cloudy:.3?} overcast, {sun:.3?} in the sun"
        ),
    })
}

/// Standard deviation of what flakes add to a picture, over its mean luminance.
fn deviation(with: &Picture, without: &Picture) -> f64 {
    let (with, without) = (luminances(with), luminances(without));
    let squares: f64 = with.iter().zip(&without).map(|(a, b)| (a - b).powi(2)).sum();
    let mean = without.iter().sum::<f64>() / without.len() as f64;
    (squares / with.len() as f64).sqrt() / mean
}

/// A ball under clouds.
fn overcast() -> Scene {
    Scene {
        size: [260, 260],
        camera: Camera { position_mm: [0.0, -220.0, 40.0], vertical_fov_deg: 12.6, ..Camera::default() },
        shape: Shape::Sphere { radius_mm: 22.0 },
        environment: Environment::Studio {
            ground: [0.16, 0.15, 0.13],
            horizon: [0.55, 0.57, 0.6],
            zenith: [1.0, 1.0, 1.05],
            softbox: Vec::new(),
        },
        lights: Vec::new(),
        ..Scene::default()
    }
}
