//! Synthetic flake slices: explicit discs with an angular lobe on a torus, their mean taken off.

use carpaint::math::hash::{pcg4d, unit};

/// Side of the slices, texels.
pub const SIDE: usize = 128;

/// A population of flakes.
#[derive(Clone, Copy)]
pub struct Flakes {
    pub name: &'static str,
    /// Flakes a texel.
    pub density: f64,
    /// Value of a flake in the mirror direction, 1/sr.
    pub peak: f64,
    /// Tilt of flake normals over the half-width of the lobe.
    pub tilt: f64,
    /// Color of the flakes at one and the other end of their range.
    pub colors: [[f64; 3]; 2],
}

/// Dense, medium and sparse paint: from many dim flakes a texel to a few bright ones a slice.
pub const DENSE: Flakes =
    Flakes { name: "dense", density: 1.0, peak: 0.6, tilt: 1.0, colors: [[0.5, 0.7, 1.0], [0.3, 0.4, 1.0]] };
pub const MEDIUM: Flakes = Flakes {
    name: "medium",
    density: 0.12,
    peak: 3.0,
    tilt: 2.0,
    colors: [[1.0, 0.8, 0.5], [0.9, 0.5, 0.3]],
};
pub const SPARSE: Flakes = Flakes {
    name: "sparse",
    density: 0.02,
    peak: 30.0,
    tilt: 4.0,
    colors: [[1.0, 1.0, 0.9], [0.3, 1.0, 0.6]],
};
pub const ALL: [Flakes; 3] = [DENSE, MEDIUM, SPARSE];

/// One slice of `side * side` texels.
pub fn slice(flakes: Flakes, side: usize, seed: u32) -> Vec<[f32; 3]> {
    let count = (flakes.density * (side * side) as f64) as u32;
    let mut texels = vec![[0.0f64; 3]; side * side];
    for k in 0..count {
        let random = |stream: u32| pcg4d([k, stream, 77, seed]).map(|bits| f64::from(unit(bits)));
        let [x, y, size, hue] = random(0);
        let [tilt, ..] = random(1);
        // Rayleigh tilt (a Gaussian normal) through a Gaussian lobe, both in units of the lobe's standard deviation.
        let value = flakes.peak * tilt.powf(flakes.tilt * flakes.tilt);
        let radius = 0.75 * (0.6 + 0.8 * size);
        let color = [0, 1, 2].map(|c| flakes.colors[0][c] * (1.0 - hue) + flakes.colors[1][c] * hue);
        splat(&mut texels, side, [x, y].map(|v| v * side as f64), radius, color.map(|c| c * value));
    }
    let n = texels.len() as f64;
    let mean = [0, 1, 2].map(|c| texels.iter().map(|t| t[c]).sum::<f64>() / n);
    texels.iter().map(|t| [0, 1, 2].map(|c| (t[c] - mean[c]) as f32)).collect()
}

/// Adds a disc, by the share of 4 x 4 points in each texel that it covers.
fn splat(texels: &mut [[f64; 3]], side: usize, center: [f64; 2], radius: f64, value: [f64; 3]) {
    let first = center.map(|c| (c - radius).floor() as i64);
    let last = center.map(|c| (c + radius).floor() as i64);
    for row in first[1]..=last[1] {
        for column in first[0]..=last[0] {
            let inside = (0..16).filter(|k| {
                let dx = column as f64 + (f64::from(k % 4) + 0.5) / 4.0 - center[0];
                let dy = row as f64 + (f64::from(k / 4) + 0.5) / 4.0 - center[1];
                dx * dx + dy * dy < radius * radius
            });
            let share = inside.count() as f64 / 16.0;
            let wrap = |k: i64| k.rem_euclid(side as i64) as usize;
            let texel = &mut texels[wrap(row) * side + wrap(column)];
            for c in 0..3 {
                texel[c] += share * value[c];
            }
        }
    }
}
