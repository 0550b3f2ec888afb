//! Sparkles against independent numbers, explicit flakes and their own laws.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

// The helpers of tests are tests too.

mod common;

use carpaint::math::half_difference::spherical;
use carpaint::simulate::composition::Composition;
use carpaint::simulate::optics::film_optics::PaintOptics;
use carpaint::simulate::optics::geometry::Geometry;
use carpaint::simulate::optics::orientation::Orientation;
use carpaint::simulate::sparkle::brute_force::BruteForce;
use carpaint::simulate::sparkle::count::CountRule;
use carpaint::simulate::sparkle::visibility;
use carpaint::simulate::sparkle::{
    Arrival, Combination, Light, Masking, Medium, Pixel, PixelSparkles, SparkleGeometry, SparkleModel,
    SparkleView,
};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Poisson};
use rand_pcg::Pcg64;
use serde_json::Value;
use std::f64::consts::PI;

const SUN: f64 = 0.00465;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// A film of perfect mirror flakes of 20 um.
fn silver(sigma_deg: f64, area_density: f64, spread: f64) -> PaintOptics {
    optics(&format!(
        "[substrate]\nalbedo = 0.1\n[[film]]\nthickness_um = 15\nindex = 1.5\n[[film.flakes]]\n\
         area_density = {area_density}\ndiameter_um = 20\ndiameter_spread = {spread}\nsigma_deg = {sigma_deg}\n\
         flake_lifetime_deg = 0\nmirror = {{ reflectance = 0.8 }}\n"
    ))
}

/// A film of mirrors with measured tilts.
fn tilted(tilts: &str) -> PaintOptics {
    optics(&format!(
        "[substrate]\nalbedo = 0.1\n[[film]]\nthickness_um = 15\nindex = 1.5\n[[film.flakes]]\n\
         area_density = 1\ndiameter_um = 20\ntilts = {tilts}\nflake_lifetime_deg = 0\n\
         mirror = {{ reflectance = 0.8 }}\n"
    ))
}

/// Two films of different index, three kinds of flakes, colored.
fn three_kinds() -> PaintOptics {
    optics(
        "[substrate]\nalbedo = 0.1\n[[film]]\nthickness_um = 15\nindex = 1.6\nabsorption_per_mm = 10\n\
         [[film.flakes]]\narea_density = 0.6\ndiameter_um = 20\nsigma_deg = 8\nflake_lifetime_deg = 0\n\
         mirror = { reflectance = 0.8 }\n\
         [[film]]\nthickness_um = 15\nindex = 1.5\nabsorption_per_mm = [[380, 40], [780, 2]]\n\
         [[film.flakes]]\narea_density = 0.5\ndiameter_um = 15\nsigma_deg = 12\nflake_lifetime_deg = 0\n\
         mirror = { reflectance = [[380, 0.2], [780, 0.7]], transmittance = 0.3 }\n\
         [[film.flakes]]\narea_density = 0.4\ndiameter_um = 30\nsigma_deg = 6\nflake_lifetime_deg = 0\n\
         stack = [{ material = \"TiO2\", thickness_nm = 60 }, { material = \"mica\", thickness_nm = 300 }]\n",
    )
}

fn optics(text: &str) -> PaintOptics {
    PaintOptics::new(&Composition::parse(text).unwrap()).unwrap()
}

/// Directions in the plane of incidence, mirror side positive, degrees.
fn plane(theta_i: f64, theta_o: f64) -> (DVec3, DVec3) {
    (spherical(theta_i.to_radians(), 0.0), spherical(theta_o.to_radians(), PI))
}

/// Mean and variance of draws, each with its standard error.
fn moments(draws: &[f64]) -> [(f64, f64); 2] {
    let n = draws.len() as f64;
    let mean = draws.iter().sum::<f64>() / n;
    let central = |p: i32| draws.iter().map(|d| (d - mean).powi(p)).sum::<f64>() / n;
    let (variance, fourth) = (central(2), central(4));
    [(mean, (variance / n).sqrt()), (variance, ((fourth - variance * variance) / n).sqrt())]
}

#[test]
fn probabilities_and_statistics_equal_the_oracle() {
    let Some(oracle) = common::reference_json("oracles/08_sparkles.json") else { return };
    let directions = |row: &Value| {
        let angle = |name: &str| number(&row[name]).to_radians();
        let wo = spherical(angle("theta_o_deg"), PI - angle("phi_deg"));
        (spherical(angle("theta_i_deg"), 0.0), wo)
    };
    for row in oracle["probability"].as_array().unwrap() {
        let (wi, wo) = directions(row);
        let (index, light_radius) = (number(&row["eta"]), number(&row["Delta_deg"]).to_radians());
        let g = Geometry::new(wi, wo, index).unwrap();
        let sparkle = SparkleGeometry { geometry: g, index, transmission: g.transmission, light_radius };
        let orientation = Orientation::new(number(&row["sigma_deg"]).to_radians());
        let ours = orientation.density(g.beta) * sparkle.normals();
        assert!((ours / number(&row["src_eta2"]) - 1.0).abs() < 1e-12, "{row}");
        let (counted, error) =
            BruteForce::new(wi, wo, index, light_radius).probability(&orientation, 400_000, 1);
        let theirs = number(&row["prob_mc"]);
        // Two Monte Carlo runs: four standard errors of their difference.
        assert!(
            (counted - theirs).abs() < 4.0 * error.hypot(number(&row["prob_se"])),
            "{counted} {error} {row}"
        );
        assert!(error < 3e-3 * counted, "{error} {row}");
    }
    for row in oracle["statistics"].as_array().unwrap() {
        let p = |name: &str| number(&row[name]);
        let um2 = 1e8;
        let (area_um2, diameter) = (p("pixel_area_cm2") * um2, 2.0 * (p("S_cm2") * um2 / PI).sqrt());
        let area_density = p("D_per_cm3") * p("S_cm2") * p("H_cm");
        let paint = optics(&format!(
            "[substrate]\nalbedo = 0\n[[film]]\nthickness_um = {}\nindex = {}\n[[film.flakes]]\n\
             area_density = {area_density}\ndiameter_um = {diameter}\ndiameter_spread = 0\nsigma_deg = {}\n\
             flake_lifetime_deg = 0\nmirror = {{ reflectance = {}, transmittance = {} }}\n",
            p("H_cm") * 1e4,
            p("eta"),
            p("sigma_deg"),
            p("rp"),
            p("tp")
        ));
        let (wi, wo) = directions(row);
        let view = SparkleView::new(&paint, wi, wo, p("Delta_rad"), Masking::Dimmed);
        for (ours, name) in [
            (view.mean_count(area_um2), "mean_N_source_side"),
            (view.kinds()[0].brightness[0] / area_um2, "sparkle_luminance_over_I_at_z0_source_side"),
            (view.mean().0[0], "mean_L_over_I"),
            (paint.glitter(wi, wo).0[0], "brdf_36"),
            (view.variance(area_um2).0[0], "var_L_over_I2_source_side"),
        ] {
            // Formulas to rounding; the oracle's extinction to 1e-9.
            assert!((ours / p(name) - 1.0).abs() < 1e-9, "{name}: {ours} {}", p(name));
        }
    }
}

#[test]
fn the_mean_is_the_glitter_of_eq_36_with_either_masking() {
    let paint = three_kinds();
    for (i, o) in [(0.0, 0.0), (45.0, 30.0), (60.0, 0.0), (70.0, -20.0), (89.9, 85.0)] {
        let (wi, wo) = plane(i, o);
        let glitter = paint.glitter(wi, wo);
        let views = [Masking::Dimmed, Masking::Hidden].map(|m| SparkleView::new(&paint, wi, wo, SUN, m));
        for view in &views {
            for (ours, glitter) in view.mean().0.iter().zip(&glitter.0) {
                // The same formula in another order.
                assert!((ours / glitter - 1.0).abs() < 1e-12, "{i} {o}: {ours} {glitter}");
            }
        }
        let [dimmed, hidden] = views;
        assert!(hidden.mean_count(1.0) < dimmed.mean_count(1.0), "{i} {o}");
        // Whole sparkles of the same mean vary more: in luminance, about which numbers go.
        let green = 17;
        assert!(hidden.variance(1.0).0[green] > dimmed.variance(1.0).0[green], "{i} {o}");
    }
}

#[test]
fn numbers_are_those_of_1999() {
    let paint = silver(8.0, 1.0, 0.3);
    let (wi, wo) = plane(40.0, 30.0);
    let g = Geometry::new(wi, wo, 1.5).unwrap();
    let film = paint.top();
    let (kind, x) = (&film.kinds[0], film.optical_thickness(&g)[0]);
    // Eqs 5, 6 with P of 1999, which lacks the 2 pi, and the light's radius inside.
    let radius = SUN / 1.5 * (wi.z / g.cos_inside[0]).sqrt();
    let per_area = kind.area_density / kind.areas.mean_um2;
    let five = per_area * 2.0 * PI * kind.orientation.density(g.beta) * radius * radius / (8.0 * g.cos_alpha);
    let six = five * -(-x).exp_m1() / x;
    let count = |masking| SparkleView::new(&paint, wi, wo, SUN, masking).mean_count(1.0);
    assert!((count(Masking::Dimmed) / five - 1.0).abs() < 1e-12);
    // The luminance of a gray spectrum is its value, up to the rounding of the sum.
    assert!((count(Masking::Hidden) / six - 1.0).abs() < 1e-12, "{} {six}", count(Masking::Hidden));
}

#[test]
fn draws_have_the_mean_and_the_variance_of_the_formulas() {
    let paint = three_kinds();
    let (wi, wo) = plane(45.0, 30.0);
    for masking in [Masking::Dimmed, Masking::Hidden] {
        let view = SparkleView::new(&paint, wi, wo, SUN, masking);
        // From one sparkle in ten pixels to more than are drawn one by one.
        for (count, n) in [(0.1, 40_000), (3.0, 40_000), (30_000.0, 1000)] {
            let area = count / view.mean_count(1.0);
            let mut rng = Pcg64::seed_from_u64(17);
            let draws: Vec<_> = (0..n).map(|_| view.sample(area, &mut rng)).collect();
            for band in [0, 17, 40] {
                let values: Vec<f64> = draws.iter().map(|d| d.0[band]).collect();
                let [mean, variance] = moments(&values);
                // Four standard errors.
                assert!((mean.0 - view.mean().0[band]).abs() < 4.0 * mean.1, "{masking:?} {count} {band}");
                let expected = view.variance(area).0[band];
                assert!((variance.0 - expected).abs() < 4.0 * variance.1, "{masking:?} {count} {band}");
            }
        }
    }
}

#[test]
fn explicit_flakes_have_the_counts_and_the_luminances() {
    let (index, radius, spread, sigma) = (1.5, 0.5f64.to_radians(), 0.3, 15f64.to_radians());
    let paint = silver(15.0, 1.0, spread);
    let orientation = Orientation::new(sigma);
    for (theta_i, theta_o) in [(60.0, 0.0), (0.0, 60.0), (45.0, 30.0), (75.0, 40.0)] {
        let (wi, wo) = plane(theta_i, theta_o);
        let view = SparkleView::new(&paint, wi, wo, radius, Masking::Dimmed);
        let area = 2.0 / view.mean_count(1.0);
        let kind = &paint.top().kinds[0];
        let flakes = area * kind.area_density / kind.areas.mean_um2;
        let exact = BruteForce::new(wi, wo, index, radius);
        let g = Geometry::new(wi, wo, index).unwrap();
        let x = paint.top().optical_thickness(&g)[0];
        // Flakes of all normals, of which those outside the cap need not be drawn: a Poisson law thins to one.
        let most = orientation.density(0.0);
        let law = Poisson::new(flakes * most * exact.cap_solid_angle()).unwrap();
        let mut rng = Pcg64::seed_from_u64(23);
        let (mut counts, mut luminances) = (Vec::new(), Vec::new());
        for _ in 0..60_000 {
            let candidates: f64 = law.sample(&mut rng);
            let (mut count, mut luminance) = (0.0, 0.0);
            for _ in 0..candidates as u32 {
                let normal = exact.normal(&mut rng);
                let density = orientation.density(normal.truncate().length().atan2(normal.z.abs()));
                if rng.random::<f64>() * most >= density || !exact.mirrors(normal) {
                    continue;
                }
                let flake = kind.areas.mean_um2 * kind.areas.sample(&mut rng);
                // The light's own radiance through the flake's projection along the refracted eye ray.
                let light = 1.0 / (PI * radius * radius * wi.z);
                let shown = flake * exact.cos_alpha(normal) / g.cos_inside[1] / area;
                count += 1.0;
                luminance += light * g.transmission * 0.8 * shown * (-x * rng.random::<f64>()).exp();
            }
            counts.push(count);
            luminances.push(luminance);
        }
        let printed = (wo.z * g.cos_inside[0]) / (wi.z * g.cos_inside[1]);
        let [count, dispersion] = moments(&counts);
        let [mean, variance] = moments(&luminances);
        for (what, found, expected) in [
            ("count", count, 2.0),
            ("variance of the count", dispersion, 2.0),
            ("mean", mean, view.mean().0[0]),
            ("variance", variance, view.variance(area).0[0]),
        ] {
            // Four standard errors, and 0.4 % for P, cosines and attenuation over a light of a degree.
            let legal = 4.0 * found.1 + 4e-3 * expected;
            assert!((found.0 - expected).abs() < legal, "{theta_i} {theta_o} {what}: {found:?} {expected}");
        }
        // The printed form, with the observer's cosines, is refuted where it differs.
        if theta_i != 45.0 {
            assert!((count.0 / (2.0 * printed) - 1.0).abs() > 0.2, "{theta_i} {theta_o}: {printed}");
        }
        println!("{theta_i}/{theta_o}: count {:.4} of 2, as printed {:.3}", count.0, 2.0 * printed);
    }
}

#[test]
fn a_smaller_light_makes_fewer_and_brighter_sparkles_of_the_same_mean() {
    let paint = silver(8.0, 1.0, 0.3);
    let (wi, wo) = plane(40.0, 30.0);
    let view = |radius| SparkleView::new(&paint, wi, wo, radius, Masking::Dimmed);
    for radius in [1e-2, 1e-4, 1e-8] {
        let (one, half) = (view(radius), view(0.5 * radius));
        // Powers of two: exact up to rounding.
        assert!((one.mean_count(1.0) / half.mean_count(1.0) - 4.0).abs() < 1e-12);
        assert!((one.mean().0[9] / half.mean().0[9] - 1.0).abs() < 1e-12);
        assert!((one.variance(1.0).0[9] * 4.0 / half.variance(1.0).0[9] - 1.0).abs() < 1e-12);
    }
    let none = view(0.0);
    assert!(none.kinds().is_empty() && none.variance(1.0).0[9] == 0.0);
}

#[test]
fn no_flakes_no_light_and_grazing_rays_are_harmless() {
    let bare = optics("substrate = { albedo = 0.5 }\nfilm = [{ thickness_um = 15, index = 1.5 }]\n");
    let none = silver(8.0, 0.0, 0.3);
    let paint = silver(8.0, 1.0, 0.3);
    let (wi, wo) = plane(40.0, 30.0);
    let pixel = Pixel { place: [3, 4], area_um2: 1e4 };
    let sun = |direction| Arrival { direction, irradiance: DVec3::ONE, radius: SUN };
    for (paint, wi, wo) in [(&bare, wi, wo), (&none, wi, wo), (&paint, -wi, wo), (&paint, wi, -wo)] {
        let sparkles = SparkleModel::new(paint).pixel(&pixel, 1, wo, &[sun(wi)]);
        assert_eq!((sparkles.drawn, sparkles.mean), (DVec3::ZERO, DVec3::ZERO));
    }
    let model = SparkleModel::new(&paint);
    for theta in [89.9, 89.999_999, 90.0 - 1e-12f64] {
        let (wi, wo) = plane(theta, theta);
        let view = model.view(wi, wo, SUN);
        for value in [view.mean().0[0], view.variance(1e4).0[0], view.mean_count(1e4)] {
            assert!(value.is_finite() && value >= 0.0, "{theta}: {value}");
        }
        let sparkles = model.pixel(&pixel, 1, wo, &[sun(wi)]);
        assert!(sparkles.fluctuation().is_finite(), "{theta}");
    }
}

#[test]
fn several_lights_are_independent_and_add() {
    let paint = silver(8.0, 1.0, 0.3);
    let model = SparkleModel::new(&paint);
    let (first, wo) = plane(40.0, 30.0);
    let second = spherical(0.5, 2.0);
    let light = |direction| Arrival { direction, irradiance: DVec3::splat(2.0), radius: SUN };
    let area = 0.5 / model.view(first, wo, SUN).mean_count(1.0);
    let n = 40_000;
    let draw = |lights: &[Arrival], seed: u64| -> Vec<f64> {
        (0..n)
            .map(|k| model.pixel(&Pixel { place: [k % 200, k / 200], area_um2: area }, seed, wo, lights))
            .map(|sparkles| sparkles.fluctuation().y)
            .collect()
    };
    let (one, both) = (draw(&[light(first)], 1), draw(&[light(first), light(second)], 1));
    let other: Vec<f64> = both.iter().zip(&one).map(|(b, a)| b - a).collect();
    let (a, b) = (moments(&one), moments(&other));
    // The fluctuation's mean is 0, and what the second light adds has nothing to do with the first: four standard errors.
    assert!(a[0].0.abs() < 4.0 * a[0].1 && b[0].0.abs() < 4.0 * b[0].1, "{a:?} {b:?}");
    let covariance = one.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / f64::from(n);
    assert!(covariance.abs() < 4.0 * (a[1].0 * b[1].0 / f64::from(n)).sqrt());
    // Nor has another seed, nor a neighbour.
    let reseeded = draw(&[light(first)], 2);
    for other in [reseeded, one.iter().skip(1).copied().collect()] {
        let covariance = one.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / f64::from(n);
        assert!(covariance.abs() < 4.0 * a[1].0 / f64::from(n).sqrt());
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    use rayon::prelude::*;
    let paint = three_kinds();
    let model = SparkleModel::new(&paint);
    let (wi, wo) = plane(40.0, 30.0);
    let light = Arrival { direction: wi, irradiance: DVec3::ONE, radius: SUN };
    let picture = |threads: usize| -> Vec<DVec3> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pixel = |k: u32| Pixel { place: [k % 64, k / 64], area_um2: 4e4 };
        pool.install(|| {
            (0..4096).into_par_iter().map(|k| model.pixel(&pixel(k), 7, wo, &[light]).drawn).collect()
        })
    };
    let one = picture(1);
    assert_eq!(one, picture(3));
    assert!(one.iter().any(|rgb| rgb.y > 0.0));
}

#[test]
fn merged_pixels_have_the_law_of_a_large_one() {
    let paint = silver(8.0, 1.0, 0.3);
    let (wi, wo) = plane(40.0, 30.0);
    let view = SparkleView::new(&paint, wi, wo, SUN, Masking::Dimmed);
    let area = 0.5 / view.mean_count(1.0);
    let mut rng = Pcg64::seed_from_u64(5);
    let n = 50_000;
    let mut draw = |area: f64| view.sample(area, &mut rng).0[0];
    let mut merged: Vec<f64> = (0..n).map(|_| (0..4).map(|_| draw(area)).sum::<f64>() / 4.0).collect();
    let mut large: Vec<f64> = (0..n).map(|_| draw(4.0 * area)).collect();
    merged.sort_by(f64::total_cmp);
    large.sort_by(f64::total_cmp);
    // Largest distance of the distribution functions (Smirnov): 99.9 % quantile 1.95 sqrt(2/n). Over values above 0, where
    // they are continuous, and the share of dark pixels, exp(-2), by itself.
    let below = |sorted: &[f64], x: f64| sorted.partition_point(|v| *v <= x) as f64 / f64::from(n);
    let distance = large.iter().map(|x| (below(&merged, *x) - below(&large, *x)).abs()).fold(0.0, f64::max);
    assert!(distance < 1.95 * (2.0 / f64::from(n)).sqrt(), "{distance}");
    let dark = below(&merged, 0.0);
    let p = (-2f64).exp();
    assert!((dark - p).abs() < 4.0 * (p * (1.0 - p) / f64::from(n)).sqrt(), "{dark} {p}");
    assert!((view.count_law(4.0 * area).probability(0) - p).abs() < 1e-12);
}

#[test]
fn tables_over_the_cosine_are_as_good_as_they_say() {
    // From the narrowest flakes to the widest, measured tilts with sharp bends and gaps, and interference.
    let mut paints: Vec<PaintOptics> = [0.3, 8.0, 60.0].map(|sigma| silver(sigma, 1.0, 0.3)).into();
    let tilts = [
        "[[0, 100], [1, 0.1], [90, 0]]",
        "[[3, 0], [5, 1], [7, 0]]",
        "[[0, 1], [4, 0], [40, 0], [60, 0.1], [61, 0], [90, 0]]",
        "[[0, 1], [0.3, 2], [90, 1]]",
    ];
    paints.extend(tilts.map(tilted));
    paints.push(three_kinds());
    for paint in &paints {
        let model = SparkleModel::new(paint);
        let (mut density, mut thickness) = (0.0f64, 0.0f64);
        for k in 0..2000 {
            let t = f64::from(k) / 2000.0;
            let (wi, wo) = plane(85.0 * (k as f64 * 0.618).fract(), 85.0 * (2.0 * t - 1.0));
            let exact = SparkleView::new(paint, wi, wo, SUN, Masking::Dimmed);
            let ours = model.view(wi, wo, SUN);
            for kind in exact.kinds() {
                // Kinds are in the same order, but for those the table leaves out.
                let Some(table) = ours.kinds().iter().find(|t| t.areas == kind.areas) else {
                    // Where P is exp(-50) of its peak.
                    assert!(kind.density < 1e-20, "{}", kind.density);
                    continue;
                };
                density = density.max((table.density / kind.density - 1.0).abs());
                for (a, b) in table.thickness.iter().zip(&kind.thickness) {
                    thickness = thickness.max((a / b - 1.0).abs());
                }
            }
        }
        println!("tables over the cosine: P {density:.1e}, optical thickness {thickness:.1e}");
        // As documented.
        assert!(density < 2e-5 && thickness < 1e-5, "{density} {thickness}");
    }
}

#[test]
fn adding_keeps_the_mean_and_the_greatest_brightens() {
    let paint = silver(8.0, 1.0, 0.3);
    let (wi, wo) = plane(45.0, 30.0);
    let view = SparkleView::new(&paint, wi, wo, SUN, Masking::Dimmed);
    let smooth = DVec3::splat(view.mean().0[0]);
    for (count, draws, brighter) in
        [(0.1, 400_000, 0.9), (1.0, 200_000, 0.5), (10.0, 40_000, 0.17), (100.0, 10_000, 0.05)]
    {
        let area = count / view.mean_count(1.0);
        let mut rng = Pcg64::seed_from_u64(3);
        let sparkles: Vec<_> = (0..draws)
            .map(|_| PixelSparkles { drawn: DVec3::splat(view.sample(area, &mut rng).0[0]), mean: smooth })
            .collect();
        let ratio = |rule: Combination| {
            let values: Vec<f64> =
                sparkles.iter().map(|s| rule.apply(smooth, s).y / smooth.y - 1.0).collect();
            moments(&values)[0]
        };
        let (add, greatest) = (ratio(Combination::AddFluctuation), ratio(Combination::Greatest));
        println!("{count} sparkles: adding {add:?}, the greatest {greatest:?}");
        // Four standard errors, and half a percent of rounding in the documented numbers.
        assert!(add.0.abs() < 4.0 * add.1, "{count}: {add:?}");
        assert!((greatest.0 - brighter).abs() < 4.0 * greatest.1 + 0.005, "{count}: {greatest:?}");
    }
}

#[test]
fn sparkles_fade_with_the_square_of_the_distance_and_texture_with_the_distance() {
    let paint = three_kinds();
    let (wi, wo) = plane(45.0, 30.0);
    let view = SparkleView::new(&paint, wi, wo, SUN, Masking::Dimmed);
    // A minute of arc from half a metre and from ten times as far, micrometres.
    let [near, far] = [5e5, 5e6].map(|distance| visibility::footprint(distance, 2.9e-4, wo.z));
    let ratio = |f: &dyn Fn(f64) -> f64| f(near) / f(far);
    // Powers: rounding.
    assert!((ratio(&|area| visibility::sparkle_luminance(&view, area).0[9]) / 100.0 - 1.0).abs() < 1e-12);
    assert!((ratio(&|area| visibility::texture_contrast(&view, area).0[9]) / 10.0 - 1.0).abs() < 1e-12);
    // Eq. 1 with the energy of a flake and the cone it goes into is the luminance of eq. 35.
    let g = Geometry::new(wi, wo, 1.5).unwrap();
    let sparkle =
        SparkleGeometry { geometry: g, index: 1.5, transmission: g.transmission, light_radius: SUN };
    let seen =
        visibility::visible_luminance(sparkle.energy(0.8, 300.0), sparkle.reflected_cone(), near, wo.z);
    assert!((seen * near / sparkle.luminance(0.8, 300.0) - 1.0).abs() < 1e-12);
}

#[test]
fn a_lamp_far_away_is_a_parallel_light_and_haze_dims_it() {
    let paint = silver(8.0, 1.0, 0.3);
    let model = SparkleModel::new(&paint);
    let (wi, wo) = plane(40.0, 30.0);
    let distance = 1e6;
    let lamp = Light::Point {
        position: wi * distance,
        intensity: DVec3::splat(distance * distance),
        radius: SUN * distance,
    };
    let sun = Light::Parallel { direction: wi, irradiance: DVec3::ONE, radius: SUN };
    let (clear, hazy) = (Medium::default(), Medium { extinction: DVec3::new(0.0, 1e-6, 2e-6) });
    let area_um2 = 10.0 / model.view(wi, wo, SUN).mean_count(1.0);
    let pixel = Pixel { place: [1, 2], area_um2 };
    let shown =
        |light: Light, medium: &Medium| model.pixel(&pixel, 1, wo, &[light.at(DVec3::ZERO, medium).unwrap()]);
    let (near, far, dim) = (shown(sun, &clear), shown(lamp, &clear), shown(lamp, &hazy));
    assert!(near.drawn.y > 0.0);
    // asin of the radius is its third power larger, 4e-6.
    assert!((far.drawn - near.drawn).length() < 1e-4 * near.drawn.length(), "{far:?} {near:?}");
    let transmitted = DVec3::new(1.0, (-1f64).exp(), (-2f64).exp());
    assert!((dim.drawn / far.drawn - transmitted).length() < 1e-12);
}

#[test]
fn the_shortcut_of_small_means_keeps_the_mean() {
    // One kind, whose sparkles differ by depth alone, and several.
    for paint in [silver(8.0, 1.0, 0.0), three_kinds()] {
        let (wi, wo) = plane(45.0, 30.0);
        let mut model = SparkleModel::new(&paint);
        let poisson = model.view(wi, wo, SUN);
        model.counts = CountRule::Shortcut;
        let view = model.view(wi, wo, SUN);
        // Below the limit and above it, where each kind by itself may be below.
        for (count, dark) in [(0.09, 0.91), (0.12, (-0.12f64).exp())] {
            let area = count / view.mean_count(1.0);
            let mut rng = Pcg64::seed_from_u64(2);
            let draws: Vec<f64> = (0..200_000).map(|_| view.sample(area, &mut rng).0[0]).collect();
            let [mean, variance] = moments(&draws);
            let (expected, square) = (view.variance(area).0[0], view.mean().0[0].powi(2));
            // Four standard errors each.
            assert!((mean.0 - view.mean().0[0]).abs() < 4.0 * mean.1, "{count}");
            assert!((variance.0 - expected).abs() < 4.0 * variance.1, "{count}: {variance:?} {expected}");
            let zeros = draws.iter().filter(|d| **d == 0.0).count() as f64 / draws.len() as f64;
            assert!(
                (zeros - dark).abs() < 4.0 * (dark * (1.0 - dark) / draws.len() as f64).sqrt(),
                "{zeros}"
            );
            assert!((view.count_law(area).probability(0) - dark).abs() < 1e-12);
            // Never two at once: the variance lacks the square of the mean.
            let lost = if count < 0.1 { square } else { 0.0 };
            assert!((poisson.variance(area).0[0] - lost - expected).abs() < 1e-12 * expected);
        }
    }
}

#[test]
fn flakes_of_different_thickness_have_colors_of_their_own() {
    let paint = optics(
        "[substrate]\nalbedo = 0.1\n[[film]]\nthickness_um = 15\nindex = 1.5\n[[film.flakes]]\n\
         area_density = 0.5\ndiameter_um = 20\ndiameter_spread = 0.3\nsigma_deg = 8\nflake_lifetime_deg = 0\n\
         stack = [{ material = \"TiO2\", thickness_nm = 120, thickness_spread = 0.15 }]\n",
    );
    let (wi, wo) = plane(45.0, 30.0);
    let g = Geometry::new(wi, wo, 1.5).unwrap();
    let flakes = &paint.top().kinds[0].optics;
    let (weights, classes) = (flakes.class_weights(), flakes.class_reflectances(g.cos_alpha));
    let average = |band: usize, power: i32| -> f64 {
        weights.iter().zip(&classes).map(|(w, r)| w * r[band].powi(power)).sum()
    };
    // Mean square over square of the mean: what the mean color alone leaves out.
    let excess = |band: usize| average(band, 2) / average(band, 1).powi(2);
    let widest = (0..41).max_by(|a, b| excess(*a).total_cmp(&excess(*b))).unwrap();
    assert!(excess(widest) > 1.2, "{}", excess(widest));
    for masking in [Masking::Dimmed, Masking::Hidden] {
        let view = SparkleView::new(&paint, wi, wo, SUN, masking);
        let kind = &view.kinds()[0];
        // The mean is the smooth glitter of the mean reflectance: the same formula in another order.
        let glitter = paint.glitter(wi, wo).0;
        assert!(view.mean().0.iter().zip(&glitter).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
        for (count, n) in [(0.1, 40_000), (3.0, 40_000), (30_000.0, 4000)] {
            let area = count / view.mean_count(1.0);
            let mut rng = Pcg64::seed_from_u64(29);
            let draws: Vec<_> = (0..n).map(|_| view.sample(area, &mut rng)).collect();
            for band in [0, 17, 40, widest] {
                let x = 2.0 * kind.thickness[band];
                let depths = if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
                let mean_color =
                    kind.density * kind.areas.mean_square() * kind.brightness[band].powi(2) * depths / area;
                let expected = mean_color * excess(band);
                // The same formula in another order.
                assert!((view.variance(area).0[band] / expected - 1.0).abs() < 1e-12, "{band}");
                let values: Vec<f64> = draws.iter().map(|d| d.0[band]).collect();
                let [mean, variance] = moments(&values);
                // Four standard errors each.
                assert!((mean.0 - view.mean().0[band]).abs() < 4.0 * mean.1, "{masking:?} {count} {band}");
                assert!((variance.0 - expected).abs() < 4.0 * variance.1, "{masking:?} {count} {band}");
                if band == widest {
                    assert!(variance.0 - mean_color > 4.0 * variance.1, "{masking:?} {count}: {variance:?}");
                }
            }
        }
    }
}
