//! How much of each texel a disc covers, exactly, on a texture that repeats.

use std::f64::consts::{FRAC_PI_4, PI};

/// Adds to `cover` the texels of a texture of `size` that a disc covers, each with the covered share; the shares sum to the
/// disc's area. Center and radius in texels; texel (0, 0) spans [0, 1) x [0, 1). Texels outside wrap around; a disc wider
/// than the texture lists a texel more than once.
pub fn cover_disc(center: [f64; 2], radius: f64, size: [usize; 2], cover: &mut Vec<(u32, f32)>) {
    if radius <= 0.0 {
        return;
    }
    let first = center.map(|c| (c - radius).floor());
    let count = [0, 1].map(|k| ((center[k] + radius).ceil() - first[k]) as usize);
    let edge = |k: usize, step: usize| (first[k] + step as f64 - center[k]) / radius;
    let texel = |k: usize, step: usize| (first[k] as i64 + step as i64).rem_euclid(size[k] as i64) as usize;
    for row in 0..count[1] {
        let (low, high) = (edge(1, row), edge(1, row + 1));
        let line = texel(1, row) * size[0];
        // Area below the row's upper edge minus that below its lower edge, left of each column edge.
        let mut left = 0.0;
        for column in 0..count[0] {
            let x = edge(0, column + 1);
            let right = quadrant(x, high) - quadrant(x, low);
            let share = (right - left) * radius * radius;
            left = right;
            if share > 0.0 {
                cover.push(((line + texel(0, column)) as u32, share as f32));
            }
        }
    }
}

/// Area of the part of the unit disc with x < a and y < b.
fn quadrant(a: f64, b: f64) -> f64 {
    let (a, b) = (a.clamp(-1.0, 1.0), b.clamp(-1.0, 1.0));
    // x sqrt(1 - x^2) + asin(x): half the area left of x, less pi/4.
    let cap = |x: f64| x * (1.0 - x * x).sqrt() + x.asin();
    if a * a + b * b < 1.0 {
        return a * b + 0.5 * (cap(a) + cap(b)) + FRAC_PI_4;
    }
    // The corner (a, b) lies outside: the disc is cut by one line or by two that do not meet inside it.
    match (a > 0.0, b > 0.0) {
        (true, true) => cap(a) + cap(b),
        (true, false) => cap(b) + 0.5 * PI,
        (false, true) => cap(a) + 0.5 * PI,
        (false, false) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(center: [f64; 2], radius: f64, size: [usize; 2]) -> Vec<f64> {
        let mut cover = Vec::new();
        cover_disc(center, radius, size, &mut cover);
        let mut texels = vec![0.0; size[0] * size[1]];
        cover.iter().for_each(|(k, share)| texels[*k as usize] += f64::from(*share));
        texels
    }

    #[test]
    fn the_area_is_exact_wherever_the_disc_lies() {
        for (center, radius) in
            [([0.1, 0.2], 0.05), ([3.5, 3.5], 0.5), ([0.0, 7.99], 1.3), ([7.9, 0.3], 3.7), ([2.0, 5.0], 11.0)]
        {
            let sum: f64 = texture(center, radius, [8, 6]).iter().sum();
            // Shares are stored in f32.
            assert!((sum / (PI * radius * radius) - 1.0).abs() < 1e-6, "{center:?} {radius}: {sum}");
        }
    }

    #[test]
    fn shares_are_those_of_counted_points() {
        let (center, radius, size) = ([2.3, 0.4], 1.7, [5, 4]);
        let ours = texture(center, radius, size);
        let n = 400;
        for (k, share) in ours.iter().enumerate() {
            let mut inside = 0;
            for point in 0..n * n {
                let x = (k % size[0]) as f64 + (f64::from(point % n) + 0.5) / f64::from(n);
                let y = (k / size[0]) as f64 + (f64::from(point / n) + 0.5) / f64::from(n);
                // The nearest image on the torus: the disc is smaller than half of it.
                let wrap = |d: f64, side: usize| d - side as f64 * (d / side as f64).round();
                let (dx, dy) = (wrap(x - center[0], size[0]), wrap(y - center[1], size[1]));
                inside += i32::from(dx * dx + dy * dy < radius * radius);
            }
            // Boundary cells of a 400 x 400 count: about 400 of 160,000, half of them wrong at worst.
            assert!((f64::from(inside) / f64::from(n * n) - share).abs() < 2e-3, "{k}: {share}");
        }
    }
}
