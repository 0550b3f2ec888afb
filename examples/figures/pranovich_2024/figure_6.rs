//! Fig. 6: from a picture to its three halftoned channels, to one texture, to a print.

use super::inks::{fitted, seen};
use super::prints::{image, print};
use crate::{Figure, Finding, pictures};
use carpaint::color::Illuminant;
use carpaint::error::Result;
use carpaint::proof::{Coverage, Halftone, ToneErrors};
use carpaint::render::{InkModel, Options, Paper, Picture, Print, ToneMap, render_print};
use carpaint::scene::{Scene, Shape};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "pranovich-2024-6",
    claim: "dots of each channel cover as much of the paper as its levels ask for, and no two lie on each other",
    draw,
};

/// Pixels along a side of a dot.
const ZOOM: usize = 2;
/// Side of the blocks whose tones are compared, pixels: a divisor of both sides of the picture.
const BLOCK: usize = 20;

fn draw(name: &Path) -> Result<Finding> {
    let (separation, dots) = print(1)?;
    let merged = Picture {
        size: dots.size(),
        pixels: dots.rgb().iter().map(|p| p.map(|c| f32::from(c) / 255.0)).collect(),
    };
    let channel = |c: usize| {
        let only = |p: &[f32; 3]| [0, 1, 2].map(|k| if k == c { p[c] } else { 0.0 });
        Picture { pixels: merged.pixels.iter().map(only).collect(), ..merged }
    };
    let mut tiles: Vec<Picture> =
        [channel(0), channel(1), channel(2), image()?, merged.clone()].iter().map(zoomed).collect();
    tiles.push(proof(&dots)?);
    pictures::mosaic(&tiles, 3).write(&name.with_added_extension("png"), 0.0, &ToneMap::InGamut)?;
    let errors = ToneErrors::of(&separation, &dots, BLOCK)?;
    let off = [0, 1, 2].map(|c| (errors.reached[c] - errors.wished[c]).abs());
    // Reading the texture back refuses dots that lie on each other.
    let is_apart = Halftone::from_rgb(dots.size(), &dots.rgb())? == dots;
    // A block exchanges dots with others along its border, as if at random: the root of their number.
    let exchanged = (4.0 * BLOCK as f64).sqrt() / (BLOCK * BLOCK) as f64;
    Ok(Finding {
        // Of the whole a thousandth is not seen.
        holds: is_apart
            && off.iter().all(|o| *o < 1e-3)
            && errors.largest_of_blocks.iter().all(|o| *o < exchanged),
        says: format!(
            "red, green, blue: wished {:.4?}, covered {:.4?} of the paper, at most {:.3?} apart in blocks of {BLOCK} x \
             {BLOCK}",
            errors.wished, errors.reached, errors.largest_of_blocks
        ),
    })
}

fn zoomed(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    let at = |k: usize| picture.pixels[k / (ZOOM * width) / ZOOM * width + k % (ZOOM * width) / ZOOM];
    Picture {
        size: [ZOOM * width, ZOOM * height],
        pixels: (0..ZOOM * ZOOM * width * height).map(at).collect(),
    }
}

/// The print on a bent sheet, exposed.
fn proof(dots: &Halftone) -> Result<Picture> {
    let [width, height] = dots.size();
    let scene = Scene::proof(Shape::printed("sheet", width as f64 / height as f64)?);
    let scene = Scene { size: [ZOOM * width, ZOOM * height], background: Some([0.0; 3]), ..scene };
    let inks = seen(&fitted()?, InkModel::Goniochromatic, Illuminant::D65)?;
    let print = Print { inks: &inks, coverage: &Coverage::new(dots.clone()), paper: Paper::BLACK };
    let picture = render_print(&scene, &print, &Options::default(), &|| ())?;
    let scale = picture.exposure(Picture::WHITE_SHARE).exp2() as f32;
    Ok(Picture { pixels: picture.pixels.iter().map(|p| p.map(|c| c * scale)).collect(), ..picture })
}
