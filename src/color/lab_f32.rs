//! Signed Lab in f32, without a branch and without a library function: sums, products, quotients and bit patterns
//! only, so that every machine, and a shader, computes the same.

use super::rgb::{RGB_FROM_XYZ, WHITE_XYZ, XYZ_FROM_RGB};

const DELTA: f32 = 6.0 / 29.0;
/// The companding function at zero.
const ZERO: f32 = 4.0 / 29.0;
/// Slope of the inverse companding function on its straight part.
const SLOPE: f32 = 3.0 * DELTA * DELTA;

/// XYZ over the white from linear RGB; rows.
const RELATIVE_FROM_RGB: [[f32; 3]; 3] = {
    let (r, g, b, white) = (XYZ_FROM_RGB.x_axis, XYZ_FROM_RGB.y_axis, XYZ_FROM_RGB.z_axis, WHITE_XYZ);
    [
        [(r.x / white.x) as f32, (g.x / white.x) as f32, (b.x / white.x) as f32],
        [(r.y / white.y) as f32, (g.y / white.y) as f32, (b.y / white.y) as f32],
        [(r.z / white.z) as f32, (g.z / white.z) as f32, (b.z / white.z) as f32],
    ]
};

/// Linear RGB from XYZ over the white; rows.
const RGB_FROM_RELATIVE: [[f32; 3]; 3] = {
    let (x, y, z, white) = (RGB_FROM_XYZ.x_axis, RGB_FROM_XYZ.y_axis, RGB_FROM_XYZ.z_axis, WHITE_XYZ);
    [
        [(x.x * white.x) as f32, (y.x * white.y) as f32, (z.x * white.z) as f32],
        [(x.y * white.x) as f32, (y.y * white.y) as f32, (z.y * white.z) as f32],
        [(x.z * white.x) as f32, (y.z * white.y) as f32, (z.z * white.z) as f32],
    ]
};

#[inline]
fn times(rows: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// Cube root of a number that is not negative, within two units in the last place; anything finite at 0.
#[inline]
fn cube_root(x: f32) -> f32 {
    // A third of the exponent, and of the mantissa as if it were a logarithm: 4 % off at most. Each of Halley's steps
    // cubes the error.
    let mut y = f32::from_bits(x.to_bits() / 3 + 0x2a51_19f2);
    for _ in 0..2 {
        let cube = y * y * y;
        y *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    y
}

/// The companding function of Lab less its value at zero; odd.
#[inline]
fn compand(t: f32) -> f32 {
    let x = t.abs();
    let above = if x > DELTA * DELTA * DELTA { cube_root(x) - ZERO } else { x * (1.0 / SLOPE) };
    above.copysign(t)
}

/// Inverse of [`compand`].
#[inline]
fn expand(f: f32) -> f32 {
    let above = f.abs();
    let root = above + ZERO;
    let x = if above > DELTA - ZERO { root * root * root } else { above * SLOPE };
    x.copysign(f)
}

/// [`super::lab_from_rgb`] in f32. Components up to 1e12.
#[inline]
pub fn lab_from_rgb_f32(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = times(&RELATIVE_FROM_RGB, rgb).map(compand);
    [116.0 * y, 500.0 * (x - y), 200.0 * (y - z)]
}

/// [`lab_from_rgb_f32`] of `scale` times many colors, as planes L, a, b: one loop a step, for vector units.
pub fn lab_planes_f32(rgb: &[[f32; 3]], scale: f32) -> [Vec<f32>; 3] {
    let plane = |row: [f32; 3]| -> Vec<f32> {
        let row = row.map(|c| c * scale);
        rgb.iter().map(|c| row[0] * c[0] + row[1] * c[1] + row[2] * c[2]).map(compand).collect()
    };
    let [mut x, mut y, mut z] = RELATIVE_FROM_RGB.map(plane);
    for ((x, y), z) in x.iter_mut().zip(&mut y).zip(&mut z) {
        [*x, *y, *z] = [116.0 * *y, 500.0 * (*x - *y), 200.0 * (*y - *z)];
    }
    [x, y, z]
}

/// [`super::rgb_from_lab`] in f32: cubes and products only. |L|, |a|, |b| up to 1e12.
#[inline]
pub fn rgb_from_lab_f32(lab: [f32; 3]) -> [f32; 3] {
    let y = lab[0] / 116.0;
    times(&RGB_FROM_RELATIVE, [y + lab[1] / 500.0, y, y - lab[2] / 200.0].map(expand))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{lab_from_rgb, rgb_from_lab};
    use glam::DVec3;
    use proptest::prelude::*;

    fn wide(v: [f32; 3]) -> DVec3 {
        DVec3::from_array(v.map(f64::from))
    }

    /// Signed numbers over eleven decades.
    fn component() -> impl Strategy<Value = f32> {
        (-6.0..5.0f32, any::<bool>()).prop_map(|(e, sign)| if sign { 10f32.powf(e) } else { -10f32.powf(e) })
    }

    proptest! {
        #[test]
        fn lab_agrees_with_f64(r in component(), g in component(), b in component()) {
            let rgb = [r, g, b];
            let exact = lab_from_rgb(wide(rgb));
            let error = (wide(lab_from_rgb_f32(rgb)) - exact).length();
            // XYZ is good to 3 units of 6e-8 of |rgb|. Where it cancels to nearly nothing the slope of Lab is at most
            // 7.787 (500 sqrt 2 + ...): 1e4 in all; elsewhere the cube root shrinks the relative error.
            let cancelled = 3.0 * 6e-8 * wide(rgb).length() * 1e4;
            prop_assert!(error < 1e-6 * exact.length() + cancelled.min(1e-2 * exact.length()) + 1e-6, "{error} {exact}");
        }

        #[test]
        fn rgb_agrees_with_f64(l in -200.0..2000.0f32, a in -200.0..200.0f32, b in -200.0..200.0f32) {
            let lab = [l, a, b];
            let exact = rgb_from_lab(wide(lab));
            // A cube triples the rounding of f, the matrix has terms up to 3 times the largest XYZ, and XYZ may be larger
            // than RGB: 1e-5 of the color.
            let error = (wide(rgb_from_lab_f32(lab)) - exact).length();
            prop_assert!(error < 1e-5 * (exact.length() + 1e-3), "{error} {exact}");
        }

        #[test]
        fn lab_is_inverted(r in -3.0..30.0f32, g in -3.0..30.0f32, b in -3.0..30.0f32) {
            let back = rgb_from_lab_f32(lab_from_rgb_f32([r, g, b]));
            // Lab is stored with 6e-8 of its largest component, which a cube triples.
            prop_assert!((wide(back) - wide([r, g, b])).length() < 1e-5 * (1.0 + wide([r, g, b]).length()));
        }
    }

    #[test]
    fn planes_are_the_same_colors() {
        let colors: Vec<[f32; 3]> =
            (0..50).map(|k| [k as f32 * 0.3, 4.0 - k as f32, 0.01 * k as f32]).collect();
        let [l, a, b] = lab_planes_f32(&colors, 3.0);
        for (k, c) in colors.iter().enumerate() {
            let one = wide(lab_from_rgb_f32(c.map(|c| 3.0 * c)));
            // The factor goes into the matrix: another rounding of XYZ, steepened to 500 * 7.787 near zero.
            assert!((wide([l[k], a[k], b[k]]) - one).length() < 1e-4 * (1.0 + one.length()), "{k}");
        }
    }

    #[test]
    fn cube_roots_of_all_magnitudes() {
        for k in 0..4000 {
            let x = 10f32.powf(-6.0 + 0.0045 * k as f32);
            let exact = f64::from(x).cbrt();
            // Two units in the last place.
            assert!((f64::from(cube_root(x)) / exact - 1.0).abs() < 2.4e-7, "{x}");
        }
        assert!(cube_root(0.0).is_finite());
    }
}
