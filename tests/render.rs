//! Claims of the renderer: energy, reciprocity, agreement with the f64 functions, flakes that keep their mean and do not
//! pump, the same bits on any number of threads, hostile input, a golden picture.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::brdf::cook_torrance::brightness;
use carpaint::brdf::fresnel::dielectric;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe, LobeGeometry};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{BoxRule, cluster_levels};
use carpaint::file::write_picture_exr;
use carpaint::math::half_difference::{HalfDifference, spherical};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::math::quadrature::gauss_legendre;
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice, Paint};
use carpaint::render::{
    Options, Picture, PictureDifference, Random, RenderFlakes, RenderPaint, Surface, ToneMap, render, shade,
};
use carpaint::scene::{
    Bodies, Camera, DirectionalLight, Environment, Light, Object, PointLight, Scene, Shape, SpotLight, Up,
};
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

fn lobe(coefficient: f64, roughness: f64, f0: f64) -> Lobe {
    Lobe { coefficient, roughness, f0 }
}

/// A paint that is nothing but diffuse.
fn diffuse(albedo: f64) -> Paint {
    Paint {
        coat: ClearCoat::NONE,
        diffuse: albedo,
        lobes: Vec::new(),
        colors: ColorTable::white(),
        flakes: None,
        provenance: serde_json::Value::Null,
    }
}

/// "Silver metallic" of Rump et al. 2008, Table 1, its lobes at half strength (errata: as printed it reflects more than
/// it receives), with a color table and the gloss lobe.
fn silver(coat: ClearCoat) -> Paint {
    let chi = [[0.9, 0.8, 0.7], [0.5, 0.6, 0.9], [1.1, 1.0, 0.8], [0.7, 0.7, 0.7]];
    Paint {
        coat,
        diffuse: 0.0359,
        lobes: vec![
            lobe(0.0837, 1.29319, 0.442487),
            lobe(0.1132, 0.453529, 0.558767),
            lobe(0.1453, 0.227447, 0.807962),
        ],
        colors: ColorTable::new([2, 2], chi.to_vec(), vec![true; 4]).unwrap(),
        ..diffuse(0.0)
    }
}

fn measured_coat() -> ClearCoat {
    ClearCoat { gloss: Some(lobe(0.2, 0.002, 0.0942766)), ..ClearCoat::NONE }
}

/// Flakes of a synthetic texture: a few bright texels on a dark ground, dimmer as the half vector leaves the normal.
fn flakes() -> Flakes {
    let grid = AngleGrid::triangle(9).unwrap();
    let (size, texel_mm) = ([64, 64], 0.02);
    let texture = |slice: usize| {
        let (theta_h, _) = grid.angles(slice);
        let gain = 4.0 * (-(theta_h / 0.35) * (theta_h / 0.35)).exp() as f32;
        let texel = |k: u32| {
            let [chance, height, ..] = pcg4d([k, 1, 2, 3]).map(unit);
            let height = if chance < 0.06 { 0.3 + height } else { 0.0 };
            [gain * (height - 0.048), gain * 0.9 * (height - 0.048), gain * 0.7 * (height - 0.048)]
        };
        Ok((0..64 * 64).map(texel).collect())
    };
    let levels = cluster_levels(grid.len(), texture, size, 50, BoxRule::MomentMatched, &|| ()).unwrap();
    let level = |(k, level): (usize, carpaint::cluster::LevelStatistics)| FlakeLevel {
        pitch_mm: level.pitch_texels * texel_mm * f64::from(1u32 << k),
        slices: level.slices,
    };
    let levels = levels.into_iter().enumerate().map(level).collect();
    let missing = MissingSlice::Zero;
    Flakes { grid, missing, size, texel_mm, levels, inverse_cdf_steps: 500, knots: None }
}

fn prepared(paint: &Paint) -> RenderPaint {
    RenderPaint::new(paint).unwrap()
}

/// A panel in front of the camera, seen at `theta` radians from its normal, lit as given.
fn panel_scene(theta: f64, environment: Environment, lights: Vec<Light>) -> Scene {
    Scene {
        size: [1, 1],
        camera: Camera {
            position_mm: [0.0, -100.0, 0.0],
            target_mm: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            vertical_fov_deg: 1.0,
        },
        shape: Shape::Panel { size_mm: [1000.0; 2], normal: [theta.sin(), -theta.cos(), 0.0] },
        environment,
        lights,
        ..Scene::default()
    }
}

fn constant(radiance: [f64; 3]) -> Environment {
    Environment::Constant { radiance }
}

fn pixel(scene: &Scene, paint: &Paint, options: &Options) -> DVec3 {
    let picture = render(scene, &[prepared(paint)], options, &|| ()).unwrap();
    assert_eq!(picture.size, [1, 1]);
    DVec3::from(picture.pixels[0].map(f64::from))
}

/// BRDF in f64 from the functions of `brdf`, no flakes.
fn reference(paint: &Paint, wi: DVec3, wo: DVec3) -> DVec3 {
    let (i, o) = (paint.coat.inner(wi), paint.coat.inner(wo));
    let angles = HalfDifference::of(i, o);
    let chi = DVec3::from(paint.colors.sample(angles.theta_h as f32, angles.theta_i as f32).map(f64::from));
    let base = chi * brightness(paint.diffuse, &paint.lobes, &LobeGeometry::of(i, o));
    let gloss = paint.coat.gloss.map_or(0.0, |lobe| lobe.eval(&LobeGeometry::of(wi, wo)));
    base * paint.coat.transmittance(wi.z, wo.z) + gloss
}

/// Pairs of directions all over the hemisphere, some at the mirror direction to within the gloss lobe.
fn directions() -> impl Iterator<Item = (DVec3, DVec3)> {
    (0..4000u32).map(|k| {
        let [a, b, c, d] = pcg4d([k, 9, 9, 9]).map(|bits| f64::from(unit(bits)));
        let wi = spherical(FRAC_PI_2 * a * 0.99, TAU * b);
        let wo = if k % 3 == 0 {
            let half = spherical(0.004 * c, TAU * d);
            half * (2.0 * half.dot(wi)) - wi
        } else {
            spherical(FRAC_PI_2 * c * 0.99, TAU * d)
        };
        (wi, wo)
    })
}

const OPTIONS: Options = Options { samples: 4, directions: 64, seed: 7, flakes: true, random: Random::Hash };

#[test]
fn a_white_diffuser_in_a_white_room_is_white() {
    for theta in [0.0, 0.7, 1.4] {
        let seen = pixel(&panel_scene(theta, constant([1.0, 0.5, 0.0]), vec![]), &diffuse(1.0), &OPTIONS);
        // The cosine law is its exact density: only f32 rounding of 256 directions is left.
        assert!((seen - DVec3::new(1.0, 0.5, 0.0)).abs().max_element() < 1e-5, "{theta}: {seen}");
    }
}

#[test]
fn a_white_diffuser_facing_a_lamp_shows_its_irradiance_over_pi() {
    let light =
        DirectionalLight { direction: [0.0, -3.0, 0.0], irradiance: [PI, 1.0, 0.0], angular_radius_deg: 0.5 };
    let seen = pixel(&panel_scene(0.0, constant([0.0; 3]), vec![light.into()]), &diffuse(1.0), &OPTIONS);
    assert!((seen - DVec3::new(1.0, 1.0 / PI, 0.0)).abs().max_element() < 1e-6, "{seen}");
}

#[test]
fn a_standing_lamp_lights_each_point_by_its_distance_and_angle() {
    let position = DVec3::new(20.0, -60.0, 15.0);
    let lamp = PointLight { position_mm: position.to_array(), irradiance: [PI; 3], radius_mm: 2.0 };
    let mut scene = panel_scene(0.0, constant([0.0; 3]), vec![Light::Point(lamp)]);
    scene.camera.vertical_fov_deg = 0.01;
    for (x, z) in [(0.0, 0.0), (20.0, 15.0), (-30.0, 10.0)] {
        // A pixel of 0.017 mm: over it the radiance changes by 1e-3.
        scene.camera.position_mm = [x, -100.0, z];
        scene.camera.target_mm = [x, 0.0, z];
        let way = position - DVec3::new(x, 0.0, z);
        let expected = position.length_squared() / way.length_squared() * (-way.y / way.length());
        let seen = pixel(&scene, &diffuse(1.0), &OPTIONS);
        assert!((seen / expected - 1.0).abs().max_element() < 1e-3, "{seen} {expected}");
    }
    let spot = SpotLight { lamp, target_mm: [20.0, 0.0, 15.0], cone_deg: 15.0, edge_deg: 5.0 };
    scene.lights = vec![Light::Spot(spot)];
    // 50 mm beside a target 60 mm away: 40 degrees from the axis.
    assert_eq!(pixel(&scene, &diffuse(1.0), &OPTIONS), DVec3::ZERO);
}

#[test]
fn a_mirror_coat_reflects_its_fresnel_share() {
    for theta in [0.0, 0.6, 1.2] {
        let coat = ClearCoat { mirror: 0.8, ..ClearCoat::ideal(1.5, false) };
        let scene = panel_scene(theta, constant([2.0, 1.0, 0.25]), vec![]);
        let seen = pixel(&scene, &Paint { coat, ..diffuse(0.0) }, &Options { samples: 1, ..OPTIONS });
        let share = 0.8 * dielectric(theta.cos(), 1.5);
        // f32 cosines and Fresnel's formula: a few units of 6e-8, magnified by its slope at grazing.
        let error = (seen / (DVec3::new(2.0, 1.0, 0.25) * share) - 1.0).abs().max_element();
        assert!(error < 3e-6, "{theta}: {error}");
    }
}

#[test]
fn surroundings_agree_with_quadrature() {
    for (coat, theta) in [
        (ClearCoat::NONE, 0.2),
        (ClearCoat::NONE, 1.2),
        (ClearCoat::ideal(1.5, false), 0.8),
        (ClearCoat { mirror: 0.0, ..ClearCoat::ideal(1.5, true) }, 0.8),
    ] {
        let paint = silver(coat);
        let wo = spherical(theta, 0.0);
        let mut exact = DVec3::splat(coat.mirror * dielectric(theta.cos(), coat.ior));
        for (polar, weight) in gauss_legendre(120, 0.0, FRAC_PI_2) {
            for k in 0..240 {
                let wi = spherical(polar, TAU * (f64::from(k) + 0.5) / 240.0);
                exact += reference(&paint, wi, wo) * (weight * polar.sin() * polar.cos() * TAU / 240.0);
            }
        }
        let options = Options { samples: 16, directions: 256, ..OPTIONS };
        let seen = pixel(&panel_scene(theta, constant([1.0; 3]), vec![]), &paint, &options);
        // 4096 low-discrepancy directions of a mixture whose weights vary by a factor of a few.
        assert!(((seen - exact) / exact).abs().max_element() < 4e-3, "{coat:?}: {seen} {exact}");
    }
}

#[test]
fn a_studio_is_seen_alike_by_few_and_many_directions() {
    let mut scene = Scene { size: [12, 16], ..Scene::default() };
    scene.camera.vertical_fov_deg = 9.0;
    let paint = [prepared(&silver(ClearCoat::ideal(1.5, false)))];
    let many = render(&scene, &paint, &Options { samples: 8, directions: 1024, ..OPTIONS }, &|| ()).unwrap();
    let few = render(&scene, &paint, &Options::default(), &|| ()).unwrap();
    let errors = many.pixels.iter().zip(&few.pixels).map(|(a, b)| f64::from((a[1] - b[1]).abs() / a[1]));
    let (largest, squares) = errors.fold((0.0, 0.0), |(m, s), e| (f64::max(m, e), s + e * e));
    let typical = (squares / many.pixels.len() as f64).sqrt();
    // 384 directions a pixel, half of them towards the soft boxes: measured .061 and .017.
    assert!(largest < 0.08 && typical < 0.025, "{largest} {typical}");
}

#[test]
fn shading_in_f32_agrees_with_f64() {
    let refracting = ClearCoat { gloss: measured_coat().gloss, ..ClearCoat::ideal(1.5, true) };
    for paint in [silver(measured_coat()), silver(refracting), diffuse(0.5)] {
        let fast = prepared(&paint);
        for (wi, wo) in directions().filter(|(wi, wo)| wi.z > 0.01 && wo.z > 0.01) {
            let (wi, wo) = (wi.as_vec3(), wo.as_vec3());
            let exact = reference(&paint, wi.as_dvec3(), wo.as_dvec3());
            let seen = shade(&fast, None, wi, wo, 0.0).as_dvec3();
            // Near the mirror direction wi + wo rounds by 6e-8 of 1, that is 3e-5 of the gloss lobe's width 0.002, and an
            // exponent of up to 10 multiplies it.
            let error = (seen - exact).abs().max_element() / exact.max_element();
            assert!(error < 1e-3, "{wi} {wo}: {seen} {exact}");
        }
    }
}

#[test]
fn shading_is_reciprocal() {
    let refracting = ClearCoat { gloss: measured_coat().gloss, ..ClearCoat::ideal(1.5, true) };
    let paint = prepared(&silver(refracting));
    for (wi, wo) in directions() {
        let (wi, wo) = (wi.as_vec3(), wo.as_vec3());
        let (there, back) = (shade(&paint, None, wi, wo, 0.0), shade(&paint, None, wo, wi, 0.0));
        // The same products in another order.
        assert!(
            (there - back).abs().max_element() <= 1e-6 * there.max_element(),
            "{wi} {wo}: {there} {back}"
        );
        if wi.z <= 0.0 || wo.z <= 0.0 {
            assert_eq!(there, Vec3::ZERO);
        }
    }
}

/// Sum over a picture of radiance times solid angle.
fn flux(scene: &Scene, paint: &Paint) -> f64 {
    let picture = render(scene, &[prepared(paint)], &Options { samples: 1, ..OPTIONS }, &|| ()).unwrap();
    let side = 2.0 * (scene.camera.vertical_fov_deg.to_radians() / 2.0).tan() / scene.size[1] as f64;
    let [width, height] = scene.size;
    let mut sum = 0.0;
    for y in 0..height {
        for x in 0..width {
            let offset = |k: usize, n: usize| (k as f64 + 0.5 - n as f64 / 2.0) * side;
            let slant = (1.0 + offset(x, width).powi(2) + offset(y, height).powi(2)).powf(-1.5);
            sum += f64::from(picture.pixels[y * width + x][0]) * side * side * slant;
        }
    }
    sum
}

#[test]
fn a_mirrored_lamp_keeps_its_energy_at_every_resolution() {
    for radius in [0.27, 2.0] {
        for size in [24, 25, 61, 240] {
            let light = DirectionalLight {
                direction: [0.02, -1.0, 0.03],
                irradiance: [1.0; 3],
                angular_radius_deg: radius,
            };
            let mut scene = panel_scene(0.0, constant([0.0; 3]), vec![light.into()]);
            scene.size = [size, size];
            scene.camera.vertical_fov_deg = 16.0;
            let share = flux(&scene, &Paint { coat: ClearCoat::ideal(1.5, false), ..diffuse(0.0) }) / 0.04;
            // Down to one pixel of 0.67 degrees for a disc of 0.54: 16 points with soft edges to find it.
            assert!((share - 1.0).abs() < 0.06, "radius {radius}, {size} pixels: {share}");
        }
    }
}

#[test]
fn a_gloss_lobe_keeps_its_energy_at_every_resolution_and_lamp_size() {
    let mut shares = Vec::new();
    for (radius, size) in [(0.25, 31), (0.25, 200), (1.0, 30), (1.0, 200), (0.25, 801)] {
        let light = DirectionalLight {
            direction: [0.02, -1.0, 0.03],
            irradiance: [1.0; 3],
            angular_radius_deg: radius,
        };
        let mut scene = panel_scene(0.0, constant([0.0; 3]), vec![light.into()]);
        scene.size = [size, size];
        scene.camera.vertical_fov_deg = 16.0;
        shares.push(flux(&scene, &Paint { coat: measured_coat(), ..diffuse(0.0) }));
    }
    // 4 s F0: the lobe is narrow enough for the limit of a mirror.
    let exact = 4.0 * 0.2 * 0.0942766;
    for share in &shares {
        assert!((share / exact - 1.0).abs() < 0.03, "{shares:?} {exact}");
    }
}

#[test]
fn flakes_with_zero_statistics_change_no_bit() {
    let mut flakes = flakes();
    for slice in flakes.levels.iter_mut().flat_map(|l| &mut l.slices) {
        slice.offset = [0.0; 3];
        slice.clusters.iter_mut().for_each(|c| (c.min, c.max) = ([0.0; 3], [0.0; 3]));
    }
    let smooth = silver(ClearCoat::ideal(1.5, false));
    let with = Paint { flakes: Some(flakes), ..smooth.clone() };
    let scene = Scene { size: [24, 32], ..Scene::default() };
    let picture = |paint: &Paint| render(&scene, &[prepared(paint)], &OPTIONS, &|| ()).unwrap();
    assert_eq!(picture(&with), picture(&smooth));
}

/// Mean and standard deviation of green Xi over places far apart, and the standard error of the mean.
fn moments(flakes: &RenderFlakes, footprint: [Vec2; 2], theta_h: f32) -> (f64, f64, f64) {
    let n = 60_000u32;
    let (mut sum, mut squares) = (0.0, 0.0);
    for k in 0..n {
        let place = Vec2::new((k % 245) as f32, (k / 245) as f32) * 9.7;
        let surface = Surface { chart: 6, uv_mm: place, footprint, seed: 3, random: Random::Hash };
        let xi = f64::from(flakes.xi(&flakes.draws(&surface), theta_h, 0.3, Vec2::ZERO).y);
        sum += xi;
        squares += xi * xi;
    }
    let mean = sum / f64::from(n);
    let deviation = (squares / f64::from(n) - mean * mean).max(0.0).sqrt();
    (mean, deviation, deviation / f64::from(n).sqrt())
}

#[test]
fn flakes_keep_their_mean_at_every_distance_and_do_not_pump() {
    let mut source = flakes();
    // A mean that is not zero: a residual of the fit.
    for slice in source.levels.iter_mut().flat_map(|l| &mut l.slices) {
        slice.offset[1] += 0.05;
    }
    let flakes = RenderFlakes::new(&source).unwrap();
    let exact = f64::from(flakes.mean(0.1, 0.3).y);
    let mut before = f64::INFINITY;
    let coarsest = 0.02 * (1 << (source.levels.len() - 1)) as f32;
    for step in 0..=28 {
        // Sides of 0.5 to 64 texels, an octave in four steps.
        let side = 0.01 * (f64::from(step) / 4.0).exp2() as f32;
        let (mean, deviation, error) = moments(&flakes, [Vec2::X * side, Vec2::Y * side], 0.1);
        // 29 chances of a fair test to be 4.5 standard errors off; 1e-6 for f32.
        assert!((mean - exact).abs() < 4.5 * error + 1e-6, "side {side}: {mean} {exact} +- {error}");
        // Averages over larger areas are never livelier. A blend of two levels may exceed the rule by 4 % (DESIGN 4.7).
        assert!(deviation < 1.04 * before, "side {side}: {deviation} after {before}");
        if step > 0 && side < coarsest / 2.0 {
            // An octave halves the deviation of independent texels, a quarter of one takes 16 %. On the last octave the
            // texture ends, and the deviation goes to zero.
            assert!(deviation > 0.75 * before, "side {side}: {deviation} after {before}");
        }
        before = deviation;
    }
    assert_eq!(
        moments(&flakes, [Vec2::X * 5.0, Vec2::Y * 5.0], 0.1).1,
        0.0,
        "the coarsest level is the mean"
    );
}

#[test]
fn the_finest_level_has_the_deviation_of_its_source() {
    let source = flakes();
    let flakes = RenderFlakes::new(&source).unwrap();
    let (_, seen, _) = moments(&flakes, [Vec2::X * 0.01, Vec2::Y * 0.01], 0.0);
    // The texture of slice theta_h = 0: 6 % of texels uniform in (0.3, 1.3), times 4 * 0.9; slices of all theta_i agree.
    let (mean, square) = (0.06 * 0.8, 0.06 * (0.64 + 1.0 / 12.0));
    let exact = 3.6 * f64::sqrt(square - mean * mean);
    // 4096 texels, 246 of them bright: 4.5 %; the statistics of 50 boxes: 2 %.
    assert!((seen / exact - 1.0).abs() < 0.08, "{seen} {exact}");
}

#[test]
fn averages_of_fine_draws_are_as_lively_as_coarse_ones() {
    let flakes = RenderFlakes::new(&flakes()).unwrap();
    let xi = |place: Vec2, side: f32| {
        let surface = Surface {
            chart: 6,
            uv_mm: place,
            footprint: [Vec2::X * side, Vec2::Y * side],
            seed: 3,
            random: Random::Hash,
        };
        f64::from(flakes.xi(&flakes.draws(&surface), 0.1, 0.3, Vec2::ZERO).y)
    };
    // Squares of 8 texels, tried at 32 x 32 points of the finest level.
    let (side, points, squares) = (0.16f32, 32, 1200);
    let (mut sum, mut square) = (0.0, 0.0);
    for k in 0..squares {
        let corner = Vec2::new((k % 40) as f32, (k / 40) as f32) * 3.1;
        let total: f64 = (0..points * points)
            .map(|p| {
                xi(
                    corner
                        + Vec2::new((p % points) as f32 + 0.5, (p / points) as f32 + 0.5)
                            * (side / points as f32),
                    0.001,
                )
            })
            .sum();
        let average = total / f64::from(points * points);
        sum += average;
        square += average * average;
    }
    let n = f64::from(squares);
    let averaged = (square / n - (sum / n) * (sum / n)).sqrt();
    let (_, drawn, _) = moments(&flakes, [Vec2::X * side, Vec2::Y * side], 0.1);
    // 1200 averages and the 64 texels of the level in the source: 2 % and 9 % of standard error.
    assert!((averaged / drawn - 1.0).abs() < 0.2, "{averaged} {drawn}");
}

#[test]
fn long_footprints_keep_their_variance() {
    let flakes = RenderFlakes::new(&flakes()).unwrap();
    let (_, round, _) = moments(&flakes, [Vec2::X * 0.16, Vec2::Y * 0.16], 0.1);
    for ratio in [2.0f32, 4.0, 8.0] {
        let (a, b) = (0.16 * ratio.sqrt(), 0.16 / ratio.sqrt());
        let turn = Vec2::from_angle(0.6);
        let (_, long, _) = moments(&flakes, [turn.rotate(Vec2::X) * a, turn.rotate(Vec2::Y) * b], 0.1);
        // The same area holds as many flakes. Taps fall into the same cell now and then, and the lattice is coarser or
        // finer than the short side by up to the pitch.
        assert!((long / round - 1.0).abs() < 0.25, "{ratio}: {long} {round}");
    }
}

#[test]
fn flakes_stay_where_they_are() {
    let flakes = RenderFlakes::new(&flakes()).unwrap();
    let at = |x: f32, seed: u32| {
        let surface = Surface {
            chart: 6,
            uv_mm: Vec2::new(x, -3.0),
            footprint: [Vec2::X * 0.01, Vec2::Y * 0.01],
            seed,
            random: Random::Hash,
        };
        flakes.xi(&flakes.draws(&surface), 0.1, 0.3, Vec2::ZERO)
    };
    // Two places a micrometre apart share a cell of some 30 micrometres more often than not.
    let same = (0..400).filter(|k| at(*k as f32 * 1.7, 1) == at(*k as f32 * 1.7 + 0.001, 1)).count();
    assert!(same > 360, "{same}");
    // Another seed has other flakes: bright in both is 6 % of 6 %.
    let bright = |seed: u32| move |k: &u32| at(*k as f32 * 1.7, seed).x > 1.0;
    let (one, both) =
        ((0..4000).filter(bright(1)).count(), (0..4000).filter(bright(1)).filter(bright(2)).count());
    assert!(one > 150 && both < one / 4, "{one} {both}");
}

#[test]
fn pictures_are_the_same_bits_on_one_thread_and_two() {
    let turning = Flakes { knots: Some(Knots::usual(0.1)), ..flakes() };
    let paint = Paint { flakes: Some(turning), ..silver(measured_coat()) };
    let paints = [prepared(&paint), prepared(&diffuse(0.3))];
    let scene = Scene { size: [20, 24], ..Scene::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &paints, &OPTIONS, &|| ()).unwrap())
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn every_shape_shows_flakes_that_leave_its_mean_alone() {
    let mut flakes = flakes();
    // A texture of few flakes is off zero by chance.
    for slice in flakes.levels.iter_mut().flat_map(|l| &mut l.slices) {
        let mean = slice.mean_rgb().to_array();
        slice.offset.iter_mut().zip(mean).for_each(|(o, m)| *o -= m as f32);
    }
    let paint = Paint { flakes: Some(flakes), ..silver(ClearCoat::ideal(1.5, false)) };
    for name in ["capsule", "sphere", "panel"] {
        let mut scene = Scene { size: [90, 120], shape: Shape::named(name).unwrap(), ..Scene::default() };
        scene.camera.vertical_fov_deg = 6.0;
        let options = Options { samples: 4, directions: 4, ..OPTIONS };
        let picture =
            |flakes| render(&scene, &[prepared(&paint)], &Options { flakes, ..options }, &|| ()).unwrap();
        let (with, without) = (picture(true), picture(false));
        let pairs = with.pixels.iter().zip(&without.pixels).map(|(a, b)| (f64::from(a[1]), f64::from(b[1])));
        let (mut blocks, mut squares, mut smooth) = ([0.0; 9 * 12], 0.0, 0.0);
        for (k, (a, b)) in pairs.enumerate() {
            blocks[k % 90 / 10 + 9 * (k / 900)] += a - b;
            squares += (a - b) * (a - b);
            smooth += b;
        }
        let sum: f64 = blocks.iter().sum();
        let error = blocks.iter().map(|b| b * b).sum::<f64>().sqrt();
        let n = with.pixels.len() as f64;
        assert!((squares / n).sqrt() > 0.01 * smooth / n, "{name}: no sparkle to be seen");
        // Neighbouring pixels share cells of the lattice, blocks of ten by ten hardly: four standard errors of these. A mean of
        // the statistics that is not 0 (f32 offsets) is far below.
        assert!(sum.abs() < 4.0 * error, "{name}: {} +- {} of {}", sum / n, error / n, smooth / n);
    }
}

/// A ball before a wall, and a capsule that hides a part of both, in paints 1, 0 and 2.
fn three_objects() -> Vec<Object> {
    let at = |shape, position_mm, paint| Object { shape, position_mm, paint, ..Object::default() };
    vec![
        at(Shape::Sphere { radius_mm: 15.0 }, [-8.0, -20.0, 0.0], 1),
        at(Shape::Panel { size_mm: [60.0, 60.0], normal: [0.0, -1.0, 0.1] }, [0.0, 10.0, 0.0], 0),
        Object { tilt_deg: [10.0, 50.0], ..at(Shape::default(), [15.0, -30.0, 5.0], 2) },
    ]
}

#[test]
fn an_object_alone_is_the_shape_in_its_tile() {
    let paint = [prepared(&Paint { flakes: Some(flakes()), ..silver(measured_coat()) })];
    let scene = Scene { size: [20, 24], ..Scene::default() };
    let alone = Scene { objects: vec![Object::default()], ..scene.clone() };
    let picture = |scene| render(scene, &paint, &OPTIONS, &|| ()).unwrap();
    assert_eq!(picture(&scene), picture(&alone));
}

#[test]
fn pictures_hang_on_the_paint_that_is_worn_and_not_on_its_number() {
    let paint = prepared(&Paint { flakes: Some(flakes()), ..silver(measured_coat()) });
    let scene = Scene { size: [30, 24], objects: three_objects(), ..Scene::default() };
    let mut same = scene.clone();
    same.objects.iter_mut().for_each(|object| object.paint = 0);
    let several = render(&scene, &[(); 3].map(|()| paint.clone()), &OPTIONS, &|| ()).unwrap();
    assert_eq!(several, render(&same, std::slice::from_ref(&paint), &OPTIONS, &|| ()).unwrap());
    assert_eq!(several.size, scene.size);
    let error = render(&scene, &[paint.clone(), paint], &OPTIONS, &|| ()).unwrap_err().to_string();
    assert_eq!(error, "scene: object 2: paint: found 2, expected 0 to 1, as many as there are paints");
}

#[test]
fn objects_camera_and_lamps_moved_together_show_the_same() {
    let paints =
        [0.2, 0.5, 0.9].map(|albedo| prepared(&Paint { diffuse: albedo, ..silver(measured_coat()) }));
    // A quarter turn, so that what is turned can be written down.
    let turned = |[x, y, z]: [f64; 3]| [-y, x, z];
    let moved = |p: [f64; 3]| (DVec3::from(turned(p)) + DVec3::new(50.0, -20.0, 10.0)).to_array();
    let lamp = DirectionalLight::default();
    let here = Scene {
        size: [60, 48],
        objects: three_objects(),
        environment: constant([0.3, 0.4, 0.5]),
        lights: vec![lamp.into()],
        ..Scene::default()
    };
    let camera = Camera {
        position_mm: moved(here.camera.position_mm),
        target_mm: moved(here.camera.target_mm),
        ..here.camera
    };
    let place = |object: &Object| Object {
        position_mm: moved(object.position_mm),
        turn_deg: object.turn_deg + 90.0,
        ..object.clone()
    };
    let there = Scene {
        camera,
        objects: here.objects.iter().map(place).collect(),
        lights: vec![DirectionalLight { direction: turned(lamp.direction), ..lamp }.into()],
        ..here.clone()
    };
    let [a, b] = [&here, &there].map(|scene| render(scene, &paints, &OPTIONS, &|| ()).unwrap());
    let differ = |(a, b): &(&[f32; 3], &[f32; 3])| {
        let (a, b) = (Vec3::from(**a), Vec3::from(**b));
        // f32 directions in the local frame.
        (a - b).abs().max_element() > 1e-4 * a.max_element()
    };
    let count = a.pixels.iter().zip(&b.pixels).filter(differ).count();
    // A ray along the edge of something may pass on either side of it.
    assert!(count <= 3, "{count} of {} pixels differ", a.pixels.len());
}

#[test]
fn objects_keep_the_light_of_lamps_from_each_other() {
    let light =
        DirectionalLight { direction: [0.0, -1.0, 1.0], irradiance: [PI; 3], angular_radius_deg: 0.5 };
    let mut scene = panel_scene(0.0, constant([0.0; 3]), vec![light.into()]);
    let lit = pixel(&scene, &diffuse(1.0), &OPTIONS);
    assert!((lit - 0.5f64.sqrt()).abs().max_element() < 1e-6, "{lit}");
    let wall = Object { shape: scene.shape.clone(), ..Object::default() };
    let ball =
        |position_mm| Object { shape: Shape::Sphere { radius_mm: 5.0 }, position_mm, ..Object::default() };
    for (position, expected) in
        [([0.0, -50.0, 50.0], DVec3::ZERO), ([0.0, -50.0, 60.0], lit), ([0.0, 50.0, -50.0], lit)]
    {
        scene.objects = vec![wall.clone(), ball(position)];
        assert_eq!(pixel(&scene, &diffuse(1.0), &OPTIONS), expected, "{position:?}");
    }
    // A lamp nearer than the ball that stands behind it.
    let lamp = |irradiance| PointLight { position_mm: [0.0, -40.0, 40.0], irradiance, radius_mm: 1.0 };
    scene.lights = vec![Light::Point(lamp([PI; 3]))];
    scene.objects = vec![wall, ball([0.0, -50.0, 50.0])];
    assert!(pixel(&scene, &diffuse(1.0), &OPTIONS).min_element() > 0.5);
}

/// A picture file of one radiance everywhere, or of what `texel` says.
fn panorama(folder: &Path, size: [usize; 2], texel: impl Fn(usize) -> [f32; 3]) -> Environment {
    let path = folder.join(format!("{}x{}.exr", size[0], size[1]));
    write_picture_exr(&path, size, &(0..size[0] * size[1]).map(texel).collect::<Vec<_>>()).unwrap();
    Environment::Image { path, turn_deg: 0.0, scale: 1.0 }
}

#[test]
fn a_uniform_panorama_is_a_constant_environment() {
    let folder = tempfile::tempdir().unwrap();
    let image = panorama(folder.path(), [8, 4], |_| [0.5, 0.4, 0.3]);
    // The tables hold f32.
    let plain = constant([0.5f32, 0.4, 0.3].map(f64::from));
    let coat = ClearCoat { gloss: measured_coat().gloss, mirror: 0.5, ..ClearCoat::ideal(1.5, false) };
    let options = Options { samples: 1, directions: 4096, ..OPTIONS };
    for theta in [0.1, 1.2] {
        for coat in [coat, ClearCoat { mirror: 1.0, ..ClearCoat::ideal(1.5, true) }] {
            let seen = |environment| pixel(&panel_scene(theta, environment, vec![]), &silver(coat), &options);
            let (a, b) = (seen(image.clone()), seen(plain.clone()));
            // Half of the directions are spread over the sphere: 2048 points of a lattice see a BRDF with a lobe to a percent.
            assert!((a / b - 1.0).abs().max_element() < 0.01, "{theta}: {a} {b}");
        }
    }
    // What is seen beyond has no integral.
    let scene = Scene { size: [4, 4], objects: vec![], ..panel_scene(0.0, image, vec![]) };
    let scene = Scene { camera: Camera { target_mm: [0.0, -200.0, 0.0], ..scene.camera }, ..scene };
    let picture = render(&scene, &[prepared(&diffuse(0.5))], &OPTIONS, &|| ()).unwrap();
    assert!(picture.pixels.iter().all(|p| *p == [0.5, 0.4, 0.3]));
}

#[test]
fn a_bright_texel_lights_like_a_lamp() {
    let folder = tempfile::tempdir().unwrap();
    // Half a column right of the middle of the picture and half a row above the horizon; bilinear, it is a tent.
    let (width, height) = (128, 64);
    let image = panorama(folder.path(), [width, height], |k| [f32::from(k == 31 * width + 64) * 1e5; 3]);
    let (turn, rise) = (PI / width as f64, 0.5 * PI / height as f64);
    let towards = DVec3::new(turn.sin() * rise.cos(), turn.cos() * rise.cos(), rise.sin());
    // Of a texel, but for the tent's bend of sin over two rows, some 1e-3.
    let solid_angle = 2.0 * PI / width as f64 * (PI / height as f64) * rise.cos();
    let lamp = DirectionalLight {
        direction: towards.to_array(),
        irradiance: [1e5 * solid_angle; 3],
        angular_radius_deg: 0.5,
    };
    // Seen from behind the lamp: the panel faces the middle of the picture.
    let mut scene = panel_scene(0.0, constant([0.0; 3]), vec![lamp.into()]);
    scene.camera.position_mm = [0.0, 100.0, 0.0];
    scene.shape = Shape::Panel { size_mm: [1000.0; 2], normal: [0.3, 1.0, 0.2] };
    let lit = pixel(&scene, &diffuse(1.0), &OPTIONS);
    let shone = Scene { environment: image, lights: vec![], ..scene };
    let seen = pixel(&shone, &diffuse(1.0), &Options { directions: 1024, ..OPTIONS });
    // Over the tent's 8 degrees the cosine bends by a thousandth; 2048 points find it.
    assert!((seen / lit - 1.0).abs().max_element() < 0.01, "{seen} {lit}");
}

#[test]
fn measured_panoramas_are_read_and_their_light_is_found() {
    for name in ["studio", "sunset", "esplanade"] {
        let Some(path) = common::reference(&format!("data/hdr/{name}.exr")) else { return };
        let image = Environment::Image { path, turn_deg: 30.0, scale: 0.5 };
        let surroundings = image.surroundings().unwrap();
        let light = |n: usize| {
            let at = |k: usize| (k as f32 + 0.5) / n as f32;
            let seen = |k: usize| {
                let direction = surroundings.sample([at(k % n), at(k / n)]);
                let light = surroundings.radiance(direction) / surroundings.density(direction);
                f64::from(light.dot(Vec3::new(0.2126, 0.7152, 0.0722)))
            };
            (0..n * n).map(seen).sum::<f64>() / (n * n) as f64
        };
        // The luminance of the whole sphere, by which directions are chosen: with few as with many. Within a texel of a sun's edge
        // it varies tenfold.
        let (few, many) = (light(64), light(400));
        assert!((few / many - 1.0).abs() < 0.05, "{name}: {few} {many}");
        let scene = Scene { size: [12, 16], environment: image, ..Scene::default() };
        let picture = render(&scene, &[prepared(&silver(measured_coat()))], &OPTIONS, &|| ()).unwrap();
        assert!(picture.pixels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
    }
}

#[test]
fn a_white_body_of_triangles_in_a_white_room_is_not_to_be_seen() {
    let ring = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes/ring.obj");
    let ring = Shape::Mesh { path: ring, length_mm: Some(40.0), up: Up::Z };
    for shape in [ring, Shape::named("speed-shape").unwrap()] {
        let object = Object { shape, tilt_deg: [60.0, 10.0], ..Object::default() };
        let (environment, lights) = (constant([1.0; 3]), Vec::new());
        let scene = Scene { size: [60, 80], objects: vec![object], environment, lights, ..Scene::default() };
        let seen = |albedo: f64| render(&scene, &[prepared(&diffuse(albedo))], &OPTIONS, &|| ()).unwrap();
        // The cosine law is its exact density: nothing but rounding is left, at silhouettes and in hollows, too.
        assert!(seen(1.0).pixels.iter().flatten().all(|c| (c - 1.0).abs() < 1e-5));
        let covered = seen(0.0).pixels.iter().filter(|p| **p == [0.0; 3]).count();
        assert!((500..4000).contains(&covered), "{covered}");
    }
}

#[test]
fn meshes_are_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3").unwrap();
    let mut scene = Scene {
        shape: Shape::Mesh { path: path.clone(), length_mm: None, up: Up::Z },
        objects: Vec::new(),
        ..Scene::default()
    };
    let first = Bodies::new(&scene).unwrap();
    std::fs::remove_file(&path).unwrap();
    scene.objects =
        vec![Object { shape: scene.shape.clone(), position_mm: [0.0, 5.0, 0.0], ..Object::default() }];
    let moved = first.changed(&scene).unwrap();
    let distance = |bodies: &Bodies| bodies.intersect(DVec3::Y * -10.0, DVec3::Y).map(|hit| hit.distance);
    // The middle of the box is on the longest side.
    assert_eq!([distance(&first), distance(&moved)], [Some(10.0), Some(15.0)]);
    assert!(Bodies::new(&scene).unwrap_err().to_string().contains("a.obj"));
}

#[test]
fn a_camera_inside_the_object_sees_black_and_bad_options_are_refused() {
    let mut scene = Scene { size: [8, 8], ..Scene::default() };
    scene.camera.position_mm = [0.0, -1.0, 0.0];
    let paint = [prepared(&diffuse(1.0))];
    let picture = render(&scene, &paint, &OPTIONS, &|| ()).unwrap();
    assert!(picture.pixels.iter().all(|p| *p == [0.0; 3]));
    assert!(render(&scene, &[], &OPTIONS, &|| ()).is_err());
    assert!(render(&scene, &paint, &Options { samples: 0, ..OPTIONS }, &|| ()).is_err());
    assert!(render(&scene, &paint, &Options { directions: 5000, ..OPTIONS }, &|| ()).is_err());
    for random in [Random::Texture(0), Random::Texture(u32::MAX)] {
        assert!(render(&scene, &paint, &Options { random, ..OPTIONS }, &|| ()).is_err());
    }
    let large = Scene { size: [8192, 8192], ..Scene::default() };
    assert!(render(&large, &vec![paint[0].clone(); 2], &OPTIONS, &|| ()).is_err());
}

#[test]
fn extreme_paints_and_views_stay_finite() {
    let hard = [lobe(50.0, 1e-4, 1.0), lobe(-2.0, 100.0, 0.0), lobe(1e-30, 1e-30, 0.5)];
    let coat = ClearCoat { ior: 4.0, refracts: true, mirror: 1.0, gloss: Some(lobe(1.0, 1e-5, 1.0)) };
    let turning = Flakes { knots: Some(Knots::usual(1e-4)), ..flakes() };
    let paint = Paint { coat, lobes: hard.to_vec(), flakes: Some(turning), ..diffuse(1.0) };
    for shape in [Shape::default(), Shape::Panel { size_mm: [1e6; 2], normal: [0.0, -1e-3, 1.0] }] {
        let scene = Scene { size: [40, 50], shape, ..Scene::default() };
        let picture = render(&scene, &[prepared(&paint)], &OPTIONS, &|| ()).unwrap();
        assert!(picture.pixels.iter().flatten().all(|c| c.is_finite()));
    }
}

/// Tiny golden picture: a capsule with everything on.
fn golden_picture() -> Picture {
    let coat = ClearCoat { gloss: measured_coat().gloss, mirror: 0.5, ..ClearCoat::ideal(1.5, false) };
    let paint = Paint { flakes: Some(flakes()), ..silver(coat) };
    let mut scene = Scene { size: [32, 48], ..Scene::strip() };
    scene.camera.vertical_fov_deg = 15.0;
    let paints = [prepared(&paint), prepared(&Paint { diffuse: 0.4, ..paint }).without_flakes()];
    render(&scene, &paints, &Options::default(), &|| ()).unwrap()
}

/// `CARPAINT_BLESS=1` writes it anew; a commit that does is titled `look-changing:`.
#[test]
fn the_golden_picture_has_not_changed() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/golden/capsules.png");
    let picture = golden_picture();
    if std::env::var_os("CARPAINT_BLESS").is_some() {
        picture.write(&path, 0.0, &ToneMap::Srgb).unwrap();
    }
    let bytes = std::fs::metadata(&path).unwrap().len();
    assert!(bytes < 12 * 1024, "golden pictures have a budget of 12 KiB: {bytes}");
    let shown = Picture {
        size: picture.size,
        pixels: picture.encode(0.0, &ToneMap::Srgb).iter().map(|p| p.map(palette_linear)).collect(),
    };
    let difference = PictureDifference::of(&Picture::read(&path).unwrap(), &shown).unwrap();
    // Other mathematics libraries move a value by one step of 8 bits here and there, and at most a draw or two of flakes
    // across a threshold.
    assert!(difference.mean < 2e-4 && difference.delta_e_2000 < 0.05, "{difference:?}");
}

fn palette_linear(code: u8) -> f32 {
    palette::Srgb::new(code, code, code).into_linear::<f32>().red
}
