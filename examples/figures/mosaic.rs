//! Figures of several pictures, and what they are of.

use carpaint::error::Result;
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, RenderPaint, ToneMap, render};
use carpaint::scene::{Camera, Object, Scene, Shape};
use std::path::Path;

/// A car-like body in the default studio.
pub fn car() -> Scene {
    let shape = Shape::SpeedShape { length_mm: 60.0 };
    Scene {
        size: [400, 220],
        camera: Camera { position_mm: [0.0, -220.0, 70.0], vertical_fov_deg: 8.6, ..Camera::default() },
        objects: vec![Object { shape, turn_deg: -24.0, ..Object::default() }],
        ..Scene::default()
    }
}

/// A paint in a scene.
pub fn tile(scene: &Scene, paint: &Paint) -> Result<Picture> {
    tile_with(scene, paint, &quick())
}

/// Fewer directions to the surroundings than usual: these are wide and smooth.
pub fn quick() -> Options {
    Options { directions: 16, ..Options::default() }
}

/// The same with options.
pub fn tile_with(scene: &Scene, paint: &Paint, options: &Options) -> Result<Picture> {
    render(scene, &[RenderPaint::new(paint)?], options, &|| ())
}

/// Pictures of one height, left to right.
pub fn beside(tiles: &[Picture]) -> Picture {
    let height = tiles.first().map_or(0, |tile| tile.size[1]);
    let row = |y: usize| tiles.iter().flat_map(move |t| &t.pixels[y * t.size[0]..(y + 1) * t.size[0]]);
    let pixels = (0..height).flat_map(row).copied().collect();
    Picture { size: [tiles.iter().map(|tile| tile.size[0]).sum(), height], pixels }
}

/// Pictures of one width, top to bottom.
pub fn below(rows: &[Picture]) -> Picture {
    let width = rows.first().map_or(0, |row| row.size[0]);
    let height = rows.iter().map(|row| row.size[1]).sum();
    Picture { size: [width, height], pixels: rows.iter().flat_map(|row| &row.pixels).copied().collect() }
}

/// The picture, radiance times 2^`stops`.
pub fn exposed(picture: Picture, stops: f64) -> Picture {
    let scale = stops.exp2() as f32;
    Picture { pixels: picture.pixels.iter().map(|p| p.map(|c| c * scale)).collect(), ..picture }
}

/// Writes `NAME.png`, radiance 1 white.
pub fn write(name: &Path, picture: &Picture) -> Result<()> {
    picture.write(&name.with_added_extension("png"), 0.0, &ToneMap::InGamut)
}
