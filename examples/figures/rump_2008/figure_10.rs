//! Fig. 10: texture synthesis by copying random patches, beside plain tiling. Borders are hard, as in the paper, and cut flakes: what
//! that does to the steps of luminance across them is told.

use super::{FLIP_FLOP, enlarged, slice};
use crate::mosaic::{beside, exposed, write};
use crate::panel::mean;
use crate::{Figure, Finding, paints};
use carpaint::color::{lab_from_rgb, luminance};
use carpaint::error::{Error, Result};
use carpaint::rivals::Patches;
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-10",
    claim: "random patches keep the overall impression of the paint, without the repetition of tiles",
    draw,
};

/// How many times the piece is wide and high what is covered.
const TIMES: usize = 3;

type Texture = Vec<[f32; 3]>;

fn draw(name: &Path) -> Result<Finding> {
    let chain = paints::chain(FLIP_FLOP)?;
    let btf = &chain.btf;
    let side = btf.size[0];
    let slice = &btf.slices[slice(btf)];
    let mean_color = slice.expectation;
    let piece: Texture = slice
        .fluctuation
        .iter()
        .map(|texel| std::array::from_fn(|c| texel[c] + mean_color[c] as f32))
        .collect();
    let size = [side * TIMES; 2];
    let place = |k: usize| k / size[0] % side * side + k % size[0] % side;
    let tiled: Texture = (0..size[0] * size[1]).map(|k| piece[place(k)]).collect();
    let patches = Patches::new(btf.size, size, Patches::SIDE, 1)?;
    let made = patches
        .surface(&piece)
        .ok_or_else(|| Error::invalid("figure", "piece", piece.len(), "as large as the slice"))?;
    let shown = beside(&[enlarged(&tiled, size, 1), enlarged(&made, size, 1)]);
    let stops = shown.exposure(0.03);
    write(name, &exposed(shown, stops))?;

    let distance = wasserstein(&tiled, &made);
    let [repeats_tiled, repeats] = [&tiled, &made].map(|t| correlation(t, size[0], side));
    let (within, across) = steps(&made, size[0]);
    Ok(Finding {
        holds: distance < 1.0 && repeats.abs() < 0.1,
        says: format!(
            "W1 of L* to the piece {distance:.2}; correlation at the side of the piece {repeats:.3} (tiles {repeats_tiled:.2}); luminance steps across seams are {:.2} of those within patches",
            across / within
        ),
    })
}

fn y(texel: &[f32; 3]) -> f64 {
    luminance(DVec3::from(texel.map(f64::from)))
}

/// Wasserstein-1 distance of L*: the mean distance of sorted values.
fn wasserstein(a: &Texture, b: &Texture) -> f64 {
    let sorted = |texels: &Texture| {
        let lightness = |t: &[f32; 3]| lab_from_rgb(PI * DVec3::from(t.map(f64::from))).x;
        let mut l: Vec<f64> = texels.iter().map(lightness).collect();
        l.sort_by(f64::total_cmp);
        l
    };
    let apart: Vec<f64> = sorted(a).iter().zip(sorted(b)).map(|(a, b)| (a - b).abs()).collect();
    mean(&apart)
}

/// Correlation of the luminance with that `shift` texels to the right.
fn correlation(texels: &Texture, width: usize, shift: usize) -> f64 {
    let y: Vec<f64> = texels.iter().map(y).collect();
    let own = mean(&y);
    let product = |shift: usize| {
        let rows = y.chunks(width);
        let terms = rows.flat_map(|row| row.iter().zip(&row[shift..]).map(|(a, b)| (a - own) * (b - own)));
        mean(&terms.collect::<Vec<_>>())
    };
    product(shift) / product(0)
}

/// Mean difference of the luminance of neighbors in a row, within patches and across their borders.
fn steps(texels: &Texture, width: usize) -> (f64, f64) {
    let (mut within, mut across) = (Vec::new(), Vec::new());
    for row in texels.chunks(width) {
        for (x, pair) in row.windows(2).enumerate() {
            let list = if (x + 1) % Patches::SIDE == 0 { &mut across } else { &mut within };
            list.push((y(&pair[0]) - y(&pair[1])).abs());
        }
    }
    (mean(&within), mean(&across))
}
