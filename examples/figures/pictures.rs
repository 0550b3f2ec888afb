//! Pictures of several paints side by side.

use carpaint::error::Result;
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, RenderPaint, ToneMap, render};
use carpaint::scene::Scene;
use std::path::Path;

/// Renders capsules in rows of equal length and writes `NAME.png`.
pub fn capsules(name: &Path, paints: &[Paint], rows: usize) -> Result<()> {
    let scene = Scene { size: [144, 320], ..Scene::strip() };
    let mut whole = Picture { size: [0, 0], pixels: Vec::new() };
    for row in paints.chunks(paints.len() / rows) {
        let ready = row.iter().map(RenderPaint::new).collect::<Result<Vec<_>>>()?;
        let tiles = render(&scene, &ready, &Options::default(), &|| ())?;
        whole.size = [tiles.size[0], whole.size[1] + tiles.size[1]];
        whole.pixels.extend(tiles.pixels);
    }
    whole.write(&name.with_added_extension("png"), scene.exposure_stops, &ToneMap::Srgb)
}
