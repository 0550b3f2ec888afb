//! Flakes under wide lights: a few directions and what they keep of the fluctuation, against thousands of directions of the same
//! model.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::brdf::fresnel::transmitted;
use carpaint::brdf::{ClearCoat, ColorTable};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{BoxRule, LevelStatistics, cluster_levels};
use carpaint::fit::{FlakeOptions, SliceMean, SmoothFit, fit_flakes};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice, Paint};
use carpaint::render::{
    Disc, FlakeDraws, Geometry, Random, RenderPaint, Surface, disc_radiance, shade, surroundings_sparkle,
};
use carpaint::report::{ChainOptions, run_chain};
use carpaint::scene::{Environment, Softbox};
use carpaint::simulate::optics::film_optics::PaintOptics;
use carpaint::simulate::sparkle::{Masking, SparkleView};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};
use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;
use std::sync::OnceLock;

/// Angular radii, degrees, and how many directions a brute-force integral takes.
const RADII: [(f32, u32); 7] =
    [(0.25, 16), (0.5, 16), (1.0, 32), (2.0, 64), (5.0, 128), (10.0, 256), (30.0, 512)];

/// Places that are looked at.
const TEXELS: u32 = 700;

/// A lobe of flakes over a dim ground: a texel's brightness by a number in (0, 1).
fn synthetic(brightness: impl Fn(f32, f32) -> f32 + Sync, knots: Option<Knots>) -> RenderPaint {
    let grid = AngleGrid::triangle(12).unwrap();
    let (size, texel_mm) = ([64, 64], 0.02);
    let texture = |slice: usize| {
        let (theta_h, _) = grid.angles(slice);
        let gain = (-(theta_h / 0.25) * (theta_h / 0.25)).exp() as f32;
        let texel = |k: u32| {
            let [a, b, ..] = pcg4d([k, 1, 2, 3]).map(unit);
            [gain * brightness(a, b); 3]
        };
        Ok((0..64 * 64).map(texel).collect())
    };
    let levels = cluster_levels(grid.len(), texture, size, 50, BoxRule::MomentMatched, &|| ()).unwrap();
    let level = |(k, level): (usize, LevelStatistics)| FlakeLevel {
        pitch_mm: level.pitch_texels * texel_mm * f64::from(1u32 << k),
        slices: level.slices,
    };
    let flakes = Flakes {
        grid,
        missing: MissingSlice::Zero,
        size,
        texel_mm,
        levels: levels.into_iter().enumerate().map(level).collect(),
        inverse_cdf_steps: 500,
        knots,
    };
    let paint = Paint {
        coat: ClearCoat::NONE,
        diffuse: 0.05,
        lobes: Vec::new(),
        colors: ColorTable::white(),
        flakes: Some(flakes),
        provenance: serde_json::Value::Null,
    };
    RenderPaint::new(&paint).unwrap()
}

const KNOTS: Knots = Knots { spacing: 0.09, compression: 4.0 };

fn simulated(name: &str) -> RenderPaint {
    let path = format!("{}/fixtures/compositions/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let composition = Composition::read(path.as_ref()).unwrap();
    let options = ChainOptions { bins: 12, size: 64, texel_mm: None, seed: 1 };
    let paint = run_chain(name, &composition, &options, |_, _| || ()).unwrap().paint;
    RenderPaint::new(&paint).unwrap()
}

fn paints() -> &'static [(&'static str, RenderPaint)] {
    static PAINTS: OnceLock<Vec<(&str, RenderPaint)>> = OnceLock::new();
    PAINTS.get_or_init(|| {
        // A sum of many flakes, and one texel in a hundred.
        let dense = |a: f32, b: f32| 0.3 * (a + b) + 0.3 * (a * 7.0).fract();
        let sparse = |a: f32, b: f32| if a < 0.01 { 5.0 + 10.0 * b } else { 0.0 };
        vec![
            ("dense", synthetic(dense, Some(KNOTS))),
            ("sparse", synthetic(sparse, Some(KNOTS))),
            ("silver", simulated("silver_metallic")),
            ("pearl", simulated("pearl_200nm")),
        ]
    })
}

/// What the flakes of places far apart draw, of a footprint of these sides.
fn draws(paint: &RenderPaint, footprint: [Vec2; 2]) -> Vec<FlakeDraws> {
    let flakes = paint.flakes.as_ref().unwrap();
    let place = |k: u32| Vec2::new((k % 64) as f32, (k / 64) as f32) * 7.3;
    (0..TEXELS)
        .map(|k| {
            flakes.draws(&Surface { chart: 2, uv_mm: place(k), footprint, seed: 5, random: Random::Hash })
        })
        .collect()
}

fn texel(side: f32) -> [Vec2; 2] {
    [Vec2::X * side, Vec2::Y * side]
}

fn luminance(rgb: Vec3) -> f64 {
    f64::from(rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722)))
}

/// Directions spread evenly over a disc, each with its share of the irradiance of a surface that faces it.
fn directions(disc: &Disc, count: u32) -> Vec<(Vec3, f32)> {
    let (across, up) = disc.direction.any_orthonormal_pair();
    (0..count)
        .map(|k| {
            // Vogel's spiral.
            let radius = ((k as f32 + 0.5) / count as f32).sqrt() * disc.sine;
            let at = Vec2::from_angle(k as f32 * 2.399_963) * radius;
            let along = (1.0 - at.length_squared()).sqrt();
            let wi = across * at.x + up * at.y + disc.direction * along;
            (wi, wi.z.max(0.0) / (along * count as f32))
        })
        .collect()
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt())
}

/// What of texels few directions and many show.
struct Compared {
    contrast: [f64; 2],
    /// Of the means, less 1.
    off: f64,
    /// Standard error of the mean, over the mean.
    error: f64,
    correlation: f64,
}

fn compared(few: &[f64], many: &[f64]) -> Compared {
    let (a, b) = (moments(few), moments(many));
    let products = few.iter().zip(many).map(|(x, y)| (x - a.0) * (y - b.0)).sum::<f64>() / few.len() as f64;
    Compared {
        contrast: [a.1 / a.0, b.1 / b.0],
        off: a.0 / b.0 - 1.0,
        error: b.1 / b.0 / (many.len() as f64).sqrt(),
        correlation: products / (a.1 * b.1),
    }
}

fn under_disc(paint: &RenderPaint, draws: &[FlakeDraws], disc: &Disc, wo: Vec3, count: u32) -> Compared {
    let directions = directions(disc, count);
    let values = draws.par_iter().map(|draws| {
        let few = luminance(disc_radiance(paint, Some(draws), disc, wo, 0.0));
        let many = directions
            .iter()
            .fold(Vec3::ZERO, |sum, (wi, weight)| sum + shade(paint, Some(draws), *wi, wo, 0.0) * *weight);
        (few, luminance(many))
    });
    let (few, many): (Vec<f64>, Vec<f64>) = values.unzip();
    compared(&few, &many)
}

fn polar(degrees: f32, azimuth: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    (Vec2::from_angle(azimuth.to_radians()) * sin).extend(cos)
}

/// Prints what was compared; `bar`: how far contrasts may be apart.
fn check(what: &str, c: &Compared, bar: f64) {
    let ratio = c.contrast[0] / c.contrast[1];
    println!(
        "{what:40} contrast {:.4} of {:.4}: {ratio:.3}, mean {:+.4} +- {:.4}, correlation {:.3}",
        c.contrast[0], c.contrast[1], c.off, c.error, c.correlation
    );
    assert!((ratio - 1.0).abs() < bar, "{what}: {:?}", c.contrast);
    // Both see the same texels: the chance of these is the most that may lie between.
    assert!(c.off.abs() < 2.0 * c.error + 0.005, "{what}: {} +- {}", c.off, c.error);
}

#[test]
fn contrast_under_a_disc_is_that_of_all_its_directions() {
    let pairs = [
        (polar(8.0, 0.0), polar(20.0, 180.0)),
        (polar(50.0, 0.0), polar(55.0, 160.0)),
        (polar(20.0, 0.0), polar(20.0, 60.0)),
    ];
    for (name, paint) in paints() {
        for (k, (wi, wo)) in pairs.into_iter().enumerate() {
            // A texel, and a pixel between two levels whose footprint has several taps.
            let footprint = if k == 1 { [Vec2::X * 0.12, Vec2::Y * 0.04] } else { texel(0.01) };
            let draws = draws(paint, footprint);
            for (radius, count) in RADII {
                let disc = Disc { direction: wi, sine: radius.to_radians().sin() };
                let c = under_disc(paint, &draws, &disc, wo, count);
                check(&format!("{name}, pair {k}, {radius} degrees"), &c, 0.1);
            }
        }
    }
}

/// Surroundings, named.
fn surroundings() -> Vec<(&'static str, Environment)> {
    let gradient =
        |softbox| Environment::Studio { ground: [0.05; 3], horizon: [0.2; 3], zenith: [0.5; 3], softbox };
    let softbox =
        |direction, size_deg, edge_deg, radiance| Softbox { direction, size_deg, edge_deg, radiance };
    vec![
        ("constant", Environment::Constant { radiance: [1.0; 3] }),
        ("sky", gradient(Vec::new())),
        ("studio", Environment::default()),
        ("small box", gradient(vec![softbox([0.3, -0.9, 0.2], [3.0; 2], 0.5, [300.0; 3])])),
        (
            "two boxes",
            gradient(vec![
                softbox([0.5, -0.8, 0.2], [10.0; 2], 1.0, [20.0; 3]),
                softbox([-0.4, -0.8, 0.3], [25.0, 8.0], 3.0, [10.0; 3]),
            ]),
        ),
        ("many lamps", gradient(many_lamps())),
    ]
}

/// Forty lamps of a few degrees all over the upper half, some a hundred times as bright as others.
fn many_lamps() -> Vec<Softbox> {
    let lamp = |k: u32| {
        let [a, b, c, d] = pcg4d([k, 5, 6, 7]).map(unit).map(f64::from);
        let (sin, cos) = (std::f64::consts::TAU * a).sin_cos();
        Softbox {
            direction: [sin, cos, 1.5 * b],
            size_deg: [2.0 + 3.0 * c; 2],
            edge_deg: 0.5,
            radiance: [3.0 * 100f64.powf(d); 3],
        }
    };
    (0..40).map(lamp).collect()
}

fn under_surroundings(
    paint: &RenderPaint,
    draws: &[FlakeDraws],
    environment: &Environment,
    to_world: &Mat3,
    wo: Vec3,
    count: u32,
) -> Compared {
    let light = environment.surroundings().unwrap();
    // A surface frame turned about the normal.
    let to_surface = Mat3::from_rotation_z(0.7) * to_world.transpose();
    let turn = Mat3::from_rotation_z(0.7);
    let sky = Disc { direction: Vec3::Z, sine: 1.0 };
    // By the cosine law and towards lamps, weighted by the density of both.
    let towards_lamps = (0..if light.has_lamps() { count } else { 0 }).map(|k| {
        let golden = unit(k.wrapping_mul(2_654_435_769));
        to_world.transpose() * light.sample([(k as f32 + 0.5) / count as f32, golden])
    });
    let all = directions(&sky, count).into_iter().map(|(wi, _)| wi).chain(towards_lamps);
    let lit: Vec<(Vec3, Vec3)> = all
        .filter(|wi| wi.z > 0.0)
        .map(|wi| {
            let density = wi.z / PI + if light.has_lamps() { light.density(*to_world * wi) } else { 0.0 };
            (turn * wi, light.radiance(*to_world * wi) * (wi.z / (density * count as f32)))
        })
        .collect();
    let statistics = paint.flakes.as_ref().unwrap();
    let smooth = lit.iter().fold(Vec3::ZERO, |sum, (wi, light)| {
        let g = Geometry::of(paint.coat.inner(*wi), paint.coat.inner(turn * wo));
        let mean = statistics.mean(g.theta_h, g.theta_i)
            * transmitted(wi.z, paint.coat.ior)
            * transmitted(wo.z, paint.coat.ior);
        sum + (shade(paint, None, *wi, turn * wo, 0.0) + mean) * *light
    });
    let values = draws.par_iter().map(|draws| {
        let few = surroundings_sparkle(paint, draws, &light, [to_world, &to_surface], wo);
        let many = lit.iter().fold(Vec3::ZERO, |sum, (wi, light)| {
            sum + shade(paint, Some(draws), *wi, turn * wo, 0.0) * *light
        });
        (luminance(few + smooth), luminance(many))
    });
    let (few, many): (Vec<f64>, Vec<f64>) = values.unzip();
    compared(&few, &many)
}

#[test]
fn contrast_under_surroundings_is_that_of_all_their_directions() {
    for (name, paint) in paints().iter().filter(|(name, _)| ["sparse", "silver"].contains(name)) {
        let draws = draws(paint, texel(0.01));
        for (kind, environment) in surroundings() {
            for (tilt, view) in [(0.0, 10.0), (0.5, 45.0), (-0.6, 65.0), (4.5, 20.0)] {
                // The normal looks at the camera, turned.
                let to_world = Mat3::from_rotation_z(tilt) * Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y);
                let seen_from = polar(view, 30.0);
                let c = under_surroundings(paint, &draws, &environment, &to_world, seen_from, 1500);
                check(&format!("{name}, {kind}, {view} degrees"), &c, 0.1);
            }
        }
    }
}

/// Gray flakes over black, one kind, of a lobe of 6.5 degrees or without one.
fn flakes_over_black(sigma_deg: f64, lifetime_deg: f64) -> Composition {
    Composition::parse(&format!(
        "substrate = {{ albedo = 0.0 }}\n[[film]]\nthickness_um = 15\nindex = 1.5\n[[film.flakes]]\n\
         area_density = 0.8\ndiameter_um = 16\ndiameter_spread = 0.3\nsigma_deg = {sigma_deg}\n\
         flake_lifetime_deg = {lifetime_deg}\nmirror = {{ reflectance = 0.8 }}\n"
    ))
    .unwrap()
}

/// Squared contrast of independent flakes under a disc, over that under a point if they were mirrors and evenly tilted: in
/// the plane of small tilts inside the film, P and the flakes' lobe normal laws of these deviations, the disc's half vectors of
/// radius `rho` about `middle`. It is `integral P B^2 / (integral P B)^2`, B the mean of the lobe over the disc.
fn spread_of_flakes(sigma: f64, lobe: f64, rho: f64, middle: f64) -> f64 {
    let normal = |square: f64, s: f64| (-0.5 * square / (s * s)).exp() / (2.0 * std::f64::consts::PI * s * s);
    let halves: Vec<[f64; 2]> = (0..128)
        .map(|k| {
            let (radius, turn) = (rho * ((f64::from(k) + 0.5) / 128.0).sqrt(), f64::from(k) * 2.399_963);
            [middle + radius * turn.cos(), radius * turn.sin()]
        })
        .collect();
    let (step, mut first, mut second) = (0.25 * lobe, 0.0, 0.0);
    let reach = (4.0 * sigma / step) as i32;
    for k in -reach..=reach {
        for l in -reach..=reach {
            let [x, y] = [k, l].map(|k| f64::from(k) * step);
            let square = |h: &[f64; 2]| (x - h[0]).powi(2) + (y - h[1]).powi(2);
            let b = halves.iter().map(|h| normal(square(h), lobe)).sum::<f64>() / 128.0;
            let p = normal(x * x + y * y, sigma) * step * step;
            first += p * b;
            second += p * b * b;
        }
    }
    second / (first * first)
}

/// Statistics of a simulated flake BTF under lamps of growing size, and the sparkles of Ershov et al. of the same flakes. Theirs
/// are mirrors under a light that is small; what a lobe and a wide light leave of their contrast is an integral over normals.
#[test]
fn contrast_against_the_size_of_a_lamp_is_that_of_single_flakes() {
    let composition = flakes_over_black(6.0, 6.5);
    let model = Model::new(&composition, ModelOptions::default()).unwrap();
    let grid = AngleGrid::new(24, vec![14; 10]).unwrap();
    let btf = synthesize(&model, &SynthesisOptions { size: [128; 2], ..SynthesisOptions::new(grid) }, &|| ());
    let btf = btf.unwrap();
    let black = Paint {
        coat: model.coat(),
        diffuse: 0.0,
        lobes: Vec::new(),
        colors: ColorTable::white(),
        flakes: None,
        provenance: serde_json::Value::Null,
    };
    let smooth = SmoothFit::from(&black);
    let flakes = fit_flakes(&btf, &smooth, SliceMean::Residual, &FlakeOptions::default(), &|| ()).unwrap();
    let texel_mm = flakes.texel_mm as f32;
    let paint = RenderPaint::new(&Paint { flakes: Some(flakes), ..black }).unwrap();

    let (wi, wo) = (polar(4.0, 0.0), polar(12.0, 180.0));
    // A pixel five flakes wide.
    let side = 8.0 * texel_mm;
    let draws = draws(&paint, texel(side));
    let mirrors = PaintOptics::new(&flakes_over_black(6.0, 0.0)).unwrap();
    let small = 1e-3;
    let (to_light, to_eye) = (wi.as_dvec3().normalize(), wo.as_dvec3().normalize());
    let view = SparkleView::new(&mirrors, to_light, to_eye, small, Masking::Dimmed);
    let area_um2 = f64::from(side * 1e3).powi(2);
    let (mean, variance) = (view.mean().0[10], view.variance(area_um2).0[10]);
    // Inside, half vectors of a light turn by a third of it.
    let [sigma, middle] = [6.0f64, 4.0 / 1.5].map(f64::to_radians);
    // A full width at half maximum of sqrt(8 ln 2) deviations.
    let lobe = 6.5f64.to_radians() / 1.5 / (8.0 * std::f64::consts::LN_2).sqrt();
    let at_middle = (-0.5 * (middle / sigma).powi(2)).exp() / (2.0 * std::f64::consts::PI * sigma * sigma);
    let of_mirrors = variance / (mean * mean) * std::f64::consts::PI * (small / 3.0).powi(2) * at_middle;
    for (radius, count) in RADII {
        let disc = Disc { direction: wi, sine: radius.to_radians().sin() };
        let c = under_disc(&paint, &draws, &disc, wo, count);
        let rho = f64::from(disc.sine) / 3.0;
        let exact = (of_mirrors * spread_of_flakes(sigma, lobe, rho, middle)).sqrt();
        let point = (variance / (mean * mean)).sqrt() * small / f64::from(radius.to_radians());
        println!(
            "{radius:5} contrast {:.4}, all directions {:.4}, single flakes {exact:.4}, mirrors {point:.4}, ratio {:.3}",
            c.contrast[0],
            c.contrast[1],
            c.contrast[0] / exact
        );
        // Flakes that the edge of a pixel cuts take 6 % of its deviation, lifetimes that follow two numbers a paint a few more; the
        // texture holds 256 such pixels, whose deviation is known to 5 %.
        assert!((c.contrast[0] / exact - 1.0).abs() < 0.2, "{radius}: {:?} {exact}", c.contrast);
    }
}

#[test]
fn flakes_without_a_lifetime_do_not_average() {
    // u hangs on the place alone: all directions of a wide lamp show the same texel.
    let paint = synthetic(|a, b| if a < 0.1 { 1.0 + b } else { 0.0 }, None);
    let draws = draws(&paint, texel(0.01));
    let contrast = |radius: f32| {
        let disc = Disc { direction: polar(3.0, 0.0), sine: radius.to_radians().sin() };
        under_disc(&paint, &draws, &disc, polar(5.0, 180.0), 256).contrast
    };
    let [narrow, wide] = [contrast(0.3), contrast(10.0)];
    for [few, many] in [narrow, wide] {
        assert!((few / many - 1.0).abs() < 0.02, "{few} {many}");
    }
    // What is left is that amplitudes fall over ten degrees, of light and mean alike.
    assert!(wide[0] > 0.95 * narrow[0], "{wide:?} {narrow:?}");
}

#[test]
fn zero_statistics_leave_nothing() {
    let paint = synthetic(|_, _| 0.0, Some(KNOTS));
    let smooth = paint.clone().without_flakes();
    let light = Environment::default().surroundings().unwrap();
    let to_world = Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y);
    for draws in draws(&paint, texel(0.01)).iter().take(50) {
        let sparkle = surroundings_sparkle(
            &paint,
            draws,
            &light,
            [&to_world, &to_world.transpose()],
            polar(30.0, 20.0),
        );
        assert_eq!(sparkle, Vec3::ZERO);
        for (radius, _) in RADII {
            let disc = Disc { direction: polar(10.0, 0.0), sine: radius.to_radians().sin() };
            let seen = |paint, draws| disc_radiance(paint, draws, &disc, polar(20.0, 180.0), 0.0);
            assert_eq!(seen(&paint, Some(draws)), seen(&smooth, None), "{radius}");
        }
    }
}
