//! What is drawn hangs together as the source does: over angles, between slices and over scales; flakes stay on the surface
//! and go out as the light turns; a random texture repeats and a hash does not.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::brdf::{ClearCoat, ColorTable, projected_half};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{BoxRule, cluster_levels};
use carpaint::fit::{FlakeOptions, Lifetime, SliceMean, SmoothFit, fit_flakes};
use carpaint::math::half_difference::directions;
use carpaint::math::hash::{pcg4d, unit};
use carpaint::math::knots::KnotLattice;
use carpaint::math::normal_f32::cdf;
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice, Paint};
use carpaint::render::{Options, Random, RenderFlakes, RenderPaint, Surface, render};
use carpaint::report::{HalfWidth, half_widths, midway, scales};
use carpaint::scene::{Camera, DirectionalLight, Environment, Scene, Shape};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};
use glam::Vec2;
use std::f64::consts::FRAC_PI_2;

/// Gray flakes over black, one kind.
fn model() -> Model {
    let paint = "substrate = { albedo = 0.0 }\n[[film]]\nthickness_um = 15\nindex = 1.5\n\
        [[film.flakes]]\narea_density = 0.8\ndiameter_um = 16\ndiameter_spread = 0.3\nsigma_deg = 6\n\
        mirror = { reflectance = 0.8 }\n";
    Model::new(&Composition::parse(paint).unwrap(), ModelOptions::default()).unwrap()
}

/// Slices up to a theta_h and theta_i of 33.75 degrees, where most of the light is, 3.75 degrees apart.
fn options() -> SynthesisOptions {
    SynthesisOptions { size: [96; 2], ..SynthesisOptions::new(AngleGrid::new(24, vec![10; 10]).unwrap()) }
}

/// All light of the slices as flakes.
fn fitted(model: &Model, options: &SynthesisOptions) -> Flakes {
    let btf = synthesize(model, options, &|| ()).unwrap();
    let smooth = SmoothFit::from(&nothing(model.coat()));
    fit_flakes(&btf, &smooth, SliceMean::Residual, &FlakeOptions::default(), &|| ()).unwrap()
}

/// A coat over black.
fn nothing(coat: ClearCoat) -> Paint {
    let colors = ColorTable::white();
    Paint { coat, diffuse: 0.0, lobes: vec![], colors, flakes: None, provenance: serde_json::Value::Null }
}

#[test]
fn flakes_go_out_as_fast_and_shine_as_brightly_as_those_simulated() {
    let (model, options) = (model(), options());
    let flakes = fitted(&model, &options);
    let spacing = flakes.knots.unwrap().spacing;
    // About the lobe of 6.5 degrees, by density 0.92 to 1.54 times of it (DESIGN 4.6).
    assert!((0.06..0.16).contains(&spacing), "{spacing}");

    let widths = half_widths(&model, &options, &flakes).unwrap();
    let (strong, weak): (Vec<HalfWidth>, Vec<HalfWidth>) = widths.into_iter().partition(|w| w.strong);
    assert!(strong.len() > 5 && weak.len() > 3);
    for (kind, limit) in [(&strong, 0.1), (&weak, 0.3)] {
        // Few texels say little about widths.
        for w in kind.iter().filter(|w| w.lit_texels > 300.0) {
            assert!((w.ratio() - 1.0).abs() < limit, "{w:?}");
        }
    }

    // Between slices: 0.96 to 1.01 (DESIGN 4.5), and 2 % for 30,000 draws.
    for m in midway(&model, &options, &flakes).unwrap() {
        assert!((0.94..1.04).contains(&(m.drawn / m.source)), "{m:?}");
    }
}

#[test]
fn zooming_and_tilting_do_not_pump() {
    let (model, options) = (model(), options());
    let flakes = fitted(&model, &options);
    let zoom: Vec<(f64, f64)> = [1.0, 1.5, 2.0, 3.0, 4.0, 8.0].map(|side| (side, 1.0)).to_vec();
    let tilt: Vec<(f64, f64)> = [1.0, 2.2, 6.0, 16.0].map(|r: f64| (r.sqrt(), r)).to_vec();
    for footprints in [zoom, tilt] {
        let table = scales(&model, &options, &flakes, &footprints).unwrap();
        for pair in table.windows(2) {
            let step = pair[1].deviation_ratio / pair[0].deviation_ratio;
            assert!((step - 1.0).abs() < 0.05, "{pair:?}");
        }
        for scale in table {
            // Up to a window of a twelfth of the texture: 144 of them, whose deviation is known to 6 %.
            assert!((scale.deviation_ratio - 1.0).abs() < 0.1, "{scale:?}");
            assert!(scale.mean_error.abs() < 4.5 * scale.mean_noise, "{scale:?}");
        }
    }
}

#[test]
fn lifetimes_can_be_given_or_left_out() {
    let model = model();
    let grid = AngleGrid::new(24, vec![2]).unwrap();
    let btf = synthesize(&model, &SynthesisOptions { size: [32; 2], ..SynthesisOptions::new(grid) }, &|| ())
        .unwrap();
    let smooth = SmoothFit::from(&nothing(model.coat()));
    let spacing = |lifetime| {
        let options = FlakeOptions { lifetime, ..FlakeOptions::default() };
        fit_flakes(&btf, &smooth, SliceMean::Residual, &options, &|| ()).map(|f| f.knots)
    };
    assert_eq!(spacing(Lifetime::Endless).unwrap(), None);
    assert_eq!(spacing(Lifetime::Fixed(0.2)).unwrap(), Some(Knots::usual(0.2)));
    assert!(spacing(Lifetime::Solve).unwrap().is_some());
    for bad in [f64::NAN, 0.0, -1.0, 11.0] {
        let error = spacing(Lifetime::Fixed(bad)).unwrap_err().to_string();
        assert!(error.contains("knot_spacing"), "{error}");
    }
    // One slice has no neighbour to compare it with.
    let grid = AngleGrid::new(24, vec![1]).unwrap();
    let alone =
        synthesize(&model, &SynthesisOptions { size: [32; 2], ..SynthesisOptions::new(grid) }, &|| ())
            .unwrap();
    let flakes = fit_flakes(&alone, &smooth, SliceMean::Residual, &FlakeOptions::default(), &|| ()).unwrap();
    assert_eq!(flakes.knots, None);
}

#[test]
fn knots_that_drew_the_slices_are_found_again() {
    // Rows of different theta_i: to 30 degrees from the normal, 3.75 degrees apart.
    let grid = AngleGrid::new(24, vec![9; 4]).unwrap();
    let options = SynthesisOptions { size: [256; 2], ..SynthesisOptions::new(grid.clone()) };
    let model = model();
    let mut btf = synthesize(&model, &options, &|| ()).unwrap();
    let smooth = SmoothFit::from(&nothing(model.coat()));
    for compression in [1.0, 9.0] {
        let knots = Knots { spacing: 0.11, compression };
        for (k, slice) in btf.slices.iter_mut().enumerate() {
            let (theta_h, theta_i) = grid.angles(k);
            let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
            let place = knots.map().place(projected_half(wi.as_vec3(), wo.as_vec3()));
            // The farther from the normal, the fewer are lit.
            let dark = 1.0 - 0.25 * (-(theta_h / 0.4).powi(2)).exp() as f32;
            for (t, texel) in (0..).zip(&mut slice.fluctuation) {
                let u = cdf(KnotLattice::new(pcg4d([t, 1, 2, 3])).value(place));
                *texel = [if u > dark { 1.0 + u } else { 0.0 }; 3];
            }
        }
        let options = FlakeOptions::default();
        let found = fit_flakes(&btf, &smooth, SliceMean::Residual, &options, &|| ()).unwrap().knots.unwrap();
        // 65,536 texels, of which a few hundred are lit far out: correlations to within 0.01 to 0.03, by which a compression
        // moves them a unit.
        assert!((found.spacing / knots.spacing - 1.0).abs() < 0.03, "{found:?} for {knots:?}");
        assert!((found.compression - compression).abs() < 1.5, "{found:?} for {knots:?}");
    }
}

/// One texel in ten is bright, at all angles.
fn simple(knots: Option<Knots>) -> Flakes {
    let (size, texel_mm) = ([32, 32], 0.02);
    let texel =
        |k: u32| if unit(pcg4d([k, 1, 2, 3])[0]) < 0.1 { [1.0 + k as f32 * 1e-3; 3] } else { [0.0; 3] };
    let slice = |_| Ok((0..32 * 32).map(texel).collect());
    let levels = cluster_levels(1, slice, size, 50, BoxRule::MomentMatched, &|| ()).unwrap();
    let level = |(k, l): (usize, carpaint::cluster::LevelStatistics)| FlakeLevel {
        pitch_mm: l.pitch_texels * texel_mm * f64::from(1u32 << k),
        slices: l.slices,
    };
    Flakes {
        grid: AngleGrid::new(1, vec![1]).unwrap(),
        missing: MissingSlice::Nearest,
        size,
        texel_mm,
        levels: levels.into_iter().enumerate().map(level).collect(),
        inverse_cdf_steps: 500,
        knots,
    }
}

fn surface(uv_mm: Vec2, side: f32, random: Random) -> Surface {
    Surface { chart: 7, uv_mm, footprint: [Vec2::X * side, Vec2::Y * side], seed: 3, random }
}

#[test]
fn a_random_texture_repeats_and_a_hash_does_not() {
    for knots in [None, Some(Knots::usual(0.1))] {
        let source = simple(knots);
        let flakes = RenderFlakes::new(&source).unwrap();
        for (level, side) in [(0, 0.001), (1, 0.04), (2, 0.08)] {
            // Polygonal cells are laid 2.45 % denser.
            let denser = if level == 0 { 1.0245 } else { 1.0 };
            let tile = 16.0 * source.levels[level].pitch_mm as f32 / denser;
            let repeats = |random| {
                let at = |place| flakes.draws(&surface(place, side, random));
                let same = (0..2000u32).filter(|k| {
                    let [x, y, ..] = pcg4d([*k, 8, 8, 8]).map(|bits| 3.0 * (unit(bits) - 0.5));
                    let place = Vec2::new(x, y);
                    at(place) == at(place + Vec2::new(tile, -2.0 * tile))
                });
                same.count()
            };
            // A place at the very edge of a cell may round into the next.
            assert!(repeats(Random::Texture(16)) > 1990, "level {level}");
            assert_eq!(repeats(Random::Hash), 0, "level {level}");
            assert_eq!(repeats(Random::Texture(17)), 0, "level {level}");
        }
    }
}

#[test]
fn flakes_light_up_and_go_out_as_the_half_vector_turns() {
    let flakes = RenderFlakes::new(&simple(Some(Knots::usual(0.1)))).unwrap();
    let draws: Vec<_> = (0..4000)
        .map(|k| flakes.draws(&surface(Vec2::new((k % 64) as f32, (k / 64) as f32), 0.001, Random::Hash)))
        .collect();
    let bright =
        |half: Vec2| -> Vec<bool> { draws.iter().map(|d| flakes.xi(d, 0.0, 0.0, half).x > 0.5).collect() };
    let both = |a: &[bool], b: &[bool]| a.iter().zip(b).filter(|(a, b)| **a && **b).count();
    let first = bright(Vec2::new(0.2, 0.1));
    let lit = both(&first, &first);
    // A tenth, to four standard errors of 4,000 draws and 1,024 texels.
    assert!((240..560).contains(&lit), "{lit}");
    for (turn, least, most) in [(0.002, 0.9, 1.0), (0.05, 0.3, 0.75), (0.5, 0.0, 0.2)] {
        let share = both(&first, &bright(Vec2::new(0.2 + turn, 0.1))) as f64 / lit as f64;
        assert!((least..=most).contains(&share), "{turn}: {share}");
    }
    // Without a lifetime nothing turns.
    let flakes = RenderFlakes::new(&simple(None)).unwrap();
    let draws = flakes.draws(&surface(Vec2::ONE, 0.001, Random::Hash));
    assert_eq!(flakes.xi(&draws, 0.0, 0.0, Vec2::ZERO), flakes.xi(&draws, 0.0, 0.0, Vec2::ONE));
}

#[test]
fn flakes_do_not_turn_with_the_camera() {
    let paint = Paint { flakes: Some(simple(Some(Knots::usual(0.05)))), ..nothing(ClearCoat::NONE) };
    let paint = [RenderPaint::new(&paint).unwrap()];
    let options = Options { samples: 1, directions: 1, ..Options::default() };
    let mut shone = 0;
    for k in 0..80 {
        let light = DirectionalLight {
            direction: [0.3, -1.0, 0.01 * f64::from(k)],
            irradiance: [1.0; 3],
            angular_radius_deg: 0.3,
        };
        let seen = |up: [f64; 3]| {
            let scene = Scene {
                size: [1, 1],
                camera: Camera {
                    position_mm: [30.0, -100.0, 5.0],
                    target_mm: [f64::from(k - 40), 0.0, 2.0],
                    up,
                    vertical_fov_deg: 0.01,
                },
                shape: Shape::Panel { size_mm: [100.0; 2], normal: [0.0, -1.0, 0.0] },
                environment: Environment::Constant { radiance: [0.0; 3] },
                lights: vec![light.into()],
                ..Scene::default()
            };
            render(&scene, &paint, &options, &|| ()).unwrap().pixels[0][1]
        };
        let (upright, rolled) = (seen([0.0, 0.0, 1.0]), seen([1.0, 0.2, 0.6]));
        assert!((upright - rolled).abs() < 1e-3, "{k}: {upright} {rolled}");
        shone += usize::from(upright > 0.1);
    }
    assert!(shone > 0 && shone < 80, "{shone}");
}
