//! Paints that between them use all that a shader can do.

use super::paints::{mix_along, paint};
use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{BoxRule, Cluster, LevelStatistics, SliceStatistics, cluster_levels};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::mix::Path;
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice};
use carpaint::render::RenderPaint;
use carpaint::report::{ChainOptions, run_chain};
use carpaint::simulate::Composition;
use std::sync::OnceLock;

/// All of them, named.
pub fn all() -> &'static [(&'static str, RenderPaint)] {
    static PAINTS: OnceLock<Vec<(&'static str, RenderPaint)>> = OnceLock::new();
    PAINTS.get_or_init(|| {
        paints().into_iter().map(|(name, paint)| (name, RenderPaint::new(&paint).unwrap())).collect()
    })
}

fn paints() -> Vec<(&'static str, Paint)> {
    let sparse = textured();
    let flakes = sparse.flakes.clone().unwrap();
    let refracting = Paint {
        coat: ClearCoat { gloss: Some(lobe(0.2, 1e-4, 0.04)), mirror: 0.0, ..ClearCoat::ideal(1.5, true) },
        flakes: Some(Flakes { knots: None, missing: MissingSlice::Nearest, ..flakes }),
        ..textured()
    };
    let blend =
        |path, weights: &[f64]| mix_along(path, &[&paint(1, 50), &paint(2, 50)]).blend(weights).unwrap();
    vec![
        ("sparse flakes that live", sparse.clone()),
        ("refracting, flakes that stay, sharp gloss", refracting),
        ("hybrid blend, bands", blend(Path::Hybrid, &[0.6, 0.4])),
        ("extrapolated blend", blend(Path::default(), &[-0.5, 1.5])),
        ("simulated", simulated()),
        ("one slice, one cluster", one_cluster()),
        ("no flakes", Paint { flakes: None, ..sparse }),
    ]
}

fn simulated() -> Paint {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/silver_metallic.toml");
    let composition = Composition::read(path.as_ref()).unwrap();
    let options = ChainOptions { bins: 6, size: 64, texel_mm: None, seed: 1 };
    run_chain("silver", &composition, &options, |_, _| || ()).unwrap().paint
}

fn lobe(coefficient: f64, roughness: f64, f0: f64) -> Lobe {
    Lobe { coefficient, roughness, f0 }
}

/// Seven levels of a few bright texels on a dark ground, dimmer as the half vector leaves the normal; a short lifetime.
fn textured() -> Paint {
    let grid = AngleGrid::triangle(9).unwrap();
    let (size, texel_mm) = ([64, 64], 0.02);
    let texture = |slice: usize| {
        let (theta_h, _) = grid.angles(slice);
        let gain = 4.0 * (-(theta_h / 0.35) * (theta_h / 0.35)).exp() as f32;
        let texel = |k: u32| {
            let [chance, height, ..] = pcg4d([k, slice as u32, 2, 3]).map(unit);
            let height = if chance < 0.06 { 0.3 + height } else { 0.0 };
            [gain * (height - 0.048), gain * 0.9 * (height - 0.048), gain * 0.7 * (height - 0.048)]
        };
        Ok((0..64 * 64).map(texel).collect())
    };
    let levels = cluster_levels(grid.len(), texture, size, 50, BoxRule::MomentMatched, &|| ()).unwrap();
    let level = |(k, level): (usize, LevelStatistics)| FlakeLevel {
        pitch_mm: level.pitch_texels * texel_mm * f64::from(1u32 << k),
        slices: level.slices,
    };
    let levels = levels.into_iter().enumerate().map(level).collect();
    let chi = [[0.9, 0.8, 0.7], [0.5, 0.6, 0.9], [1.1, 1.0, 0.8], [0.7, 0.7, 0.7]];
    Paint {
        coat: ClearCoat { gloss: Some(lobe(0.2, 0.002, 0.09)), ..ClearCoat::NONE },
        diffuse: 0.0359,
        lobes: vec![lobe(0.08, 1.293, 0.44), lobe(0.11, 0.4535, 0.56), lobe(0.15, 0.227, 0.81)],
        colors: ColorTable::new([2, 2], chi.to_vec(), vec![true; 4]).unwrap(),
        flakes: Some(Flakes {
            grid,
            missing: MissingSlice::Zero,
            size,
            texel_mm,
            levels,
            inverse_cdf_steps: 500,
            knots: Some(Knots { spacing: 0.05, compression: 9.0 }),
        }),
        provenance: serde_json::Value::Null,
    }
}

fn one_cluster() -> Paint {
    let cluster = Cluster { probability: 1.0, min: [20.0, -5.0, 0.0], max: [90.0, 5.0, 3.0] };
    let slice = SliceStatistics { gain: [1.5, 0.5, 2.0], ..SliceStatistics::new(vec![cluster], [-0.1; 3]) };
    Paint {
        flakes: Some(Flakes {
            grid: AngleGrid::triangle(1).unwrap(),
            missing: MissingSlice::Nearest,
            size: [1, 1],
            texel_mm: 0.02,
            levels: vec![FlakeLevel { pitch_mm: 0.02, slices: vec![slice] }],
            inverse_cdf_steps: 500,
            knots: Some(Knots::usual(0.3)),
        }),
        lobes: vec![lobe(0.1, 1e-4, 0.5)],
        ..textured()
    }
}
