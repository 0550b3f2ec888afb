//! Small paints, mixes and flake BTFs, of noise: whatever a file of them can hold is in them.
#![allow(dead_code)]

use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe, TabulatedBrdf};
use carpaint::btf::{AngleGrid, FlakeBtf, FlakeSlice};
use carpaint::cluster::{BoxRule, cluster_levels};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::mix::{CoupleOptions, Mix, couple};
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice};
use serde_json::json;

pub const KNOTS: Knots = Knots { spacing: 0.1, compression: 7.0 };
pub const SIZE: [usize; 2] = [4, 4];

pub fn grid() -> AngleGrid {
    AngleGrid::triangle(3).unwrap()
}

/// Noise about zero, an f32 an index.
fn noise(k: usize, seed: u32) -> f32 {
    unit(pcg4d([k as u32, seed, 3, 4])[0]) - 0.5
}

pub fn texels(n: usize, seed: u32) -> Vec<[f32; 3]> {
    (0..n).map(|k| [0, 1, 2].map(|c| noise(3 * k + c, seed))).collect()
}

pub fn btf() -> FlakeBtf {
    FlakeBtf {
        grid: grid(),
        size: SIZE,
        texel_mm: 0.02,
        slices: (0..grid().len() as u32)
            .map(|k| FlakeSlice { fluctuation: texels(16, k), expectation: [0.1, 0.2, 1.0 / 3.0] })
            .collect(),
        smooth: TabulatedBrdf::new(2, 3, texels(12, 90)).unwrap(),
        coat: ClearCoat::ideal(1.5, false),
        provenance: json!({ "name": "Blau \u{1F697}" }),
    }
}

pub fn paint(seed: u32) -> Paint {
    let slice = |k: usize| Ok(texels(16, seed + k as u32));
    let levels = cluster_levels(grid().len(), slice, SIZE, 5, BoxRule::MomentMatched, &|| ()).unwrap();
    Paint {
        coat: ClearCoat {
            ior: 1.5,
            refracts: false,
            mirror: 0.5,
            gloss: Some(Lobe { coefficient: 0.2, roughness: 0.004, f0: 0.05 }),
        },
        diffuse: 1.0 / 3.0,
        lobes: vec![Lobe { coefficient: 0.1, roughness: 0.3, f0: 0.5 }; 2],
        colors: ColorTable::new([2, 3], texels(6, seed + 50), vec![true, false, true, true, false, true])
            .unwrap(),
        flakes: Some(Flakes {
            grid: grid(),
            missing: MissingSlice::Nearest,
            size: SIZE,
            texel_mm: 0.02,
            levels: levels
                .into_iter()
                .map(|l| FlakeLevel { pitch_mm: 0.02 * l.pitch_texels, slices: l.slices })
                .collect(),
            inverse_cdf_steps: 20,
            knots: Some(KNOTS),
        }),
        provenance: json!({ "seed": seed }),
    }
}

pub fn mix() -> Mix {
    let (a, b) = (paint(1), paint(200));
    couple(&[("a".to_owned(), &a), ("b".to_owned(), &b)], &CoupleOptions::default(), &|| ()).unwrap().0
}
