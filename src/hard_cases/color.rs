//! Lab of light that is next to none, less than none, or brighter than any white.

use super::extended::{Big, big, relative};
use super::{HardCase, decades, larger, worst};
use crate::color::{
    WHITE_XYZ, delta_e_94, lab_from_rgb, lab_from_rgb_f32, lab_from_xyz, rgb_from_lab, rgb_from_lab_f32,
    xyz_from_lab,
};
use glam::DVec3;

pub(super) fn cases() -> Vec<HardCase> {
    vec![near_black(), near_black_f32(), back_from_near_black(), negative(), bright_gray(), equal_hues()]
}

/// The companding function of CIE 15, straight on below the joint, for negative light too.
fn textbook(t: f64) -> f64 {
    let delta = 6.0f64 / 29.0;
    if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
}

/// L* below the joint: `116 (29 / 6)^2 / 3 t`.
fn dark_lightness(t: &Big) -> Big {
    big(116.0 * 29.0 * 29.0) / big(3.0 * 36.0) * t
}

fn near_black() -> HardCase {
    let all = decades(-300..=-3);
    // Colored, so that all three depend on differences.
    let xyz = |t: f64| DVec3::new(0.5 * t, t, 0.25 * t) * WHITE_XYZ;
    let stable = |t: f64| relative(lab_from_xyz(xyz(t), WHITE_XYZ).x, &dark_lightness(&big(t)));
    HardCase {
        name: "lightness of almost no light",
        formula: "L* = 116 f(Y) - 16",
        source: "CIE 15; color::lab_from_xyz",
        arguments: "Y from 1e-300 to 1e-3; f64",
        measure: "relative",
        naive: worst(all.clone(), |t| relative(116.0 * textbook(t) - 16.0, &dark_lightness(&big(t)))),
        stable: worst(all, stable),
        bar: 8.0 * f64::EPSILON,
        why: "the slope, rounded thrice, and two products",
        worse: 1e13,
    }
}

fn near_black_f32() -> HardCase {
    let all: Vec<f32> = (-30..=-3).map(|k| 10f32.powi(k)).collect();
    // The row of luminance sums to 1 within its rounding.
    let truth = |c: f32| dark_lightness(&big(c));
    let naive = |c: f32| {
        let delta = 6.0f32 / 29.0;
        116.0 * (c / (3.0 * delta * delta) + 4.0 / 29.0) - 16.0
    };
    HardCase {
        name: "lightness of almost no light in f32",
        formula: "L* = 116 f(Y) - 16",
        source: "CIE 15; color::lab_from_rgb_f32",
        arguments: "gray from 1e-30 to 1e-3; f32",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |c| relative(lab_from_rgb_f32([c; 3])[0], &truth(c))),
        bar: 8.0 * f64::from(f32::EPSILON),
        why: "a row of three products, the slope, two products",
        worse: 1e5,
    }
}

fn back_from_near_black() -> HardCase {
    let all = decades(-300..=0);
    let truth = |l: f64| big(l) / dark_lightness(&big(1.0));
    let naive = |l: f64| {
        let delta = 6.0f64 / 29.0;
        3.0 * delta * delta * ((l + 16.0) / 116.0 - 4.0 / 29.0)
    };
    let stable = |l: f64| xyz_from_lab(DVec3::new(l, 0.0, 0.0), DVec3::ONE).y;
    HardCase {
        name: "light of almost no lightness",
        formula: "Y = 3 (6/29)^2 ((L* + 16) / 116 - 4/29)",
        source: "CIE 15; color::xyz_from_lab",
        arguments: "L* from 1e-300 to 1; f64",
        measure: "relative",
        naive: worst(all.clone(), |l| relative(naive(l), &truth(l))),
        stable: worst(all, |l| relative(stable(l), &truth(l))),
        bar: 8.0 * f64::EPSILON,
        why: "the slope, rounded thrice, a quotient and a product",
        worse: 1e13,
    }
}

fn negative() -> HardCase {
    let colors = [0.15, 1.0, 1e5]
        .into_iter()
        .flat_map(|c| [DVec3::new(c, 0.0, 0.0), DVec3::new(0.2, 0.5, 1.0) * c, DVec3::splat(c)]);
    let all: Vec<DVec3> = colors.collect();
    let naive = |c: DVec3| {
        let lightness = |c: DVec3| 116.0 * textbook(crate::color::luminance(c)) - 16.0;
        (lightness(-c) + lightness(c)).abs() / lightness(c)
    };
    let stable = |c: DVec3| {
        let lab = lab_from_rgb(c);
        let odd = (lab_from_rgb(-c) + lab).length() / lab.length();
        larger(odd, (rgb_from_lab(-lab) + c).length() / c.length())
    };
    HardCase {
        name: "residuals darker than black, and HDR",
        formula: "f(t) = t / (3 (6/29)^2) + 4/29 for all t below (6/29)^3",
        source: "Golla & Klein 2018, section 3.2, whose residuals are signed; color::lab_from_rgb",
        arguments: "minus 0.15, 1 and 1e5, colored and gray; f64",
        measure: "Lab(-c) = -Lab(c), and back: off by, relative",
        naive: worst(all.clone(), naive),
        stable: worst(all, stable),
        bar: 128.0 * f64::EPSILON,
        why: "cubes of what a * and b * share with L *, and a matrix whose inverse has entries of up to 3",
        worse: 1e10,
    }
}

fn bright_gray() -> HardCase {
    let all = [1.0f32, 1e3, 1e5];
    // IEC 61966-2-1 as printed: a matrix of four digits, a white of five.
    let naive = |c: f32| {
        let x = (0.4124 + 0.3576 + 0.1805) * c / 0.950_47;
        let y = (0.2126 + 0.7152 + 0.0722) * c;
        let z = (0.0193 + 0.1192 + 0.9505) * c / 1.088_83;
        let [x, y, z] = [x, y, z].map(|t: f32| t.powf(1.0 / 3.0));
        f64::from((500.0 * (x - y)).hypot(200.0 * (y - z)))
    };
    let stable = |c: f32| {
        let [_, a, b] = lab_from_rgb_f32([c; 3]);
        let back = rgb_from_lab_f32(lab_from_rgb_f32([c; 3]))[1];
        larger(a.hypot(b).into(), (back / c - 1.0).abs().into())
    };
    HardCase {
        name: "gray of 1e5 stays gray",
        formula: "a* = 500 (f(X / X_n) - f(Y / Y_n))",
        source: "CIE 15, IEC 61966-2-1; color::lab_from_rgb_f32",
        arguments: "gray 1, 1e3, 1e5; f32",
        measure: "chroma, Delta-E, where 0 is due",
        naive: worst(all, naive),
        stable: worst(all, stable),
        bar: 2e-3,
        why: "rows of the matrix that differ by a unit in the last place: 500 * 46 / 3 * 1.2e-7, twice",
        worse: 100.0,
    }
}

fn equal_hues() -> HardCase {
    let pair = |k: i32| {
        let (angle, chroma) = (0.1 * f64::from(k), 0.3 * f64::from(k));
        let at = |c: f64| DVec3::new(50.0, c * angle.cos(), c * angle.sin());
        (at(chroma), at(1.7 * chroma))
    };
    let due = |k: i32| 0.7 * 0.3 * f64::from(k) / (1.0 + 0.045 * 0.3 * f64::from(k));
    let naive = |k| {
        let (a, b) = pair(k);
        let chroma = a.y.hypot(a.z) - b.y.hypot(b.z);
        let hue = ((a.y - b.y).powi(2) + (a.z - b.z).powi(2) - chroma * chroma).sqrt();
        hue / (1.0 + 0.015 * a.y.hypot(a.z))
    };
    HardCase {
        name: "hue difference of equal hues",
        formula: "Delta-H = sqrt(Delta-a^2 + Delta-b^2 - Delta-C^2)",
        source: "CIE 1994; color::delta_e_94",
        arguments: "399 pairs of one hue, chroma 0.3 to 200; f64",
        measure: "Delta-E beside that of chroma alone, relative",
        naive: worst(1..400, naive),
        stable: worst(1..400, |k| (delta_e_94(pair(k).0, pair(k).1) / due(k) - 1.0).abs()),
        bar: 1e-14,
        why: "what the difference leaves is a rounding of squares, under a root with one of them",
        worse: 1e3,
    }
}
