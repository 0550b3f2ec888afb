//! Pictures of several paints side by side.

use carpaint::error::Result;
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, Random, RenderPaint, ToneMap, render};
use carpaint::scene::Scene;
use std::path::Path;

/// How figures are rendered: time goes with the rays.
pub const OPTIONS: Options =
    Options { samples: 2, directions: 24, seed: 1, flakes: true, random: Random::Hash };

/// The scene of all capsules.
pub fn capsule() -> Scene {
    Scene { size: [144, 320], ..Scene::strip() }
}

/// Each paint in a scene, a picture each.
pub fn each(scene: &Scene, paints: &[Paint], options: &Options) -> Result<Vec<Picture>> {
    let picture = |paint| render(scene, &[RenderPaint::new(paint)?], options, &|| ());
    paints.iter().map(picture).collect()
}

/// Renders capsules in rows of equal length, writes `NAME.png`, and returns them one by one.
pub fn capsules(name: &Path, paints: &[Paint], rows: usize) -> Result<Vec<Picture>> {
    let scene = capsule();
    let tiles = each(&scene, paints, &OPTIONS)?;
    let whole = mosaic(&tiles, paints.len() / rows);
    whole.write(&name.with_added_extension("png"), scene.exposure_stops, &ToneMap::Srgb)?;
    Ok(tiles)
}

/// Pictures of one size in rows of `columns`.
pub fn mosaic(tiles: &[Picture], columns: usize) -> Picture {
    let [width, height] = tiles[0].size;
    let mut whole = Picture { size: [width * columns, 0], pixels: Vec::new() };
    for row in tiles.chunks(columns) {
        for y in 0..height {
            whole.pixels.extend(row.iter().flat_map(|tile| &tile.pixels[y * width..(y + 1) * width]));
        }
        whole.size[1] += height;
    }
    whole
}
