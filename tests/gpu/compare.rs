//! How far pictures of two renderers are apart.
#![allow(dead_code)]

use carpaint::render::Picture;
use glam::{DVec3, Vec3};

/// Largest relative difference of two pixels that agree.
pub const LARGEST: f32 = 1e-3;

/// Largest difference of a component, relative to the largest component; what is darker than 1e-6 is black.
pub fn difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    let (a, b) = (Vec3::from(a), Vec3::from(b));
    assert!(a.is_finite() && b.is_finite(), "{a} {b}");
    (a - b).abs().max_element() / a.abs().max_element().max(b.abs().max_element()).max(1e-6)
}

/// Share of the pixels that differ, and how far the means of the pictures are apart, relative.
pub fn compare(expected: &Picture, seen: &Picture) -> (f64, f64) {
    assert_eq!(expected.size, seen.size);
    let pairs = expected.pixels.iter().zip(&seen.pixels);
    let differ = pairs.filter(|(a, b)| difference(**a, **b) > LARGEST).count();
    let mean = |p: &Picture| p.pixels.iter().map(|p| Vec3::from(*p).as_dvec3()).sum::<DVec3>();
    let off = (mean(expected) - mean(seen)).abs().max_element() / mean(expected).max_element().max(1e-9);
    (differ as f64 / expected.pixels.len() as f64, off)
}
