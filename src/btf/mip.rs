//! Mip levels of a slice: box filter (Rump et al. 2008, section 6), in linear RGB, so that the mean is kept.

/// Number of levels of a texture of this size, down to 1 x 1.
pub fn level_count(size: [usize; 2]) -> usize {
    let longest = size[0].max(size[1]).max(1);
    (usize::BITS - (longest - 1).leading_zeros()) as usize + 1
}

/// The next coarser level of a row-major texture: means over 2 x 2 texels; an odd last row or column counts as its own
/// pair with the share of area it has, so that the mean over the texture is exactly kept.
pub fn half(texels: &[[f32; 3]], size: [usize; 2]) -> (Vec<[f32; 3]>, [usize; 2]) {
    let next = size.map(|n| n.div_ceil(2));
    if size.iter().all(|n| n % 2 == 0) {
        return (half_of_even(texels, size[0]), next);
    }
    half_of(|k| texels[k], size)
}

/// As [`half()`], of texels that `texel` gives by their number.
pub fn half_of(texel: impl Fn(usize) -> [f32; 3], size: [usize; 2]) -> (Vec<[f32; 3]>, [usize; 2]) {
    let next = size.map(|n| n.div_ceil(2));
    let columns = overlaps(size[0], next[0]);
    let rows = overlaps(size[1], next[1]);
    let mut out = Vec::with_capacity(next[0] * next[1]);
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0f64; 3];
            for (y, wy) in row {
                for (x, wx) in column {
                    for (s, c) in sum.iter_mut().zip(texel(y * size[0] + x)) {
                        *s += wx * wy * f64::from(c);
                    }
                }
            }
            out.push(sum.map(|s| s as f32));
        }
    }
    (out, next)
}

/// Means over 2 x 2 texels, both sides being even.
fn half_of_even(texels: &[[f32; 3]], columns: usize) -> Vec<[f32; 3]> {
    let sum = |c: usize, [a, b]: &[[f32; 3]; 2]| f64::from(a[c]) + f64::from(b[c]);
    let mut out = Vec::with_capacity(texels.len() / 4);
    for rows in texels.chunks_exact(2 * columns) {
        let (upper, lower) = rows.split_at(columns);
        let pairs = upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0);
        out.extend(pairs.map(|(u, l)| [0, 1, 2].map(|c| (0.25 * (sum(c, u) + sum(c, l))) as f32)));
    }
    out
}

/// For each of `n` target texels the source texels it covers and their shares (summing to 1).
fn overlaps(source: usize, n: usize) -> Vec<Vec<(usize, f64)>> {
    let scale = source as f64 / n as f64;
    (0..n)
        .map(|k| {
            let (from, to) = (k as f64 * scale, (k + 1) as f64 * scale);
            (from as usize..source)
                .map(|x| (x, (to.min((x + 1) as f64) - from.max(x as f64)) / scale))
                .take_while(|(_, share)| *share > 1e-12)
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_end_at_one_texel_and_keep_the_mean() {
        for size in [[8, 8], [6, 10], [5, 3], [1, 7], [1, 1]] {
            let texels: Vec<[f32; 3]> =
                (0..size[0] * size[1]).map(|k| [(k * k % 17) as f32, -(k as f32), 1.0]).collect();
            let mean =
                |t: &[[f32; 3]], c: usize| t.iter().map(|v| f64::from(v[c])).sum::<f64>() / t.len() as f64;
            let (mut level, mut at) = (texels.clone(), size);
            for _ in 1..level_count(size) {
                (level, at) = half(&level, at);
            }
            assert_eq!(at, [1, 1]);
            for c in 0..3 {
                // f32 storage of up to four levels.
                assert!((mean(&level, c) - mean(&texels, c)).abs() < 1e-5, "{size:?}");
            }
        }
    }

    #[test]
    fn even_sides_are_halved_as_any_others() {
        let texels: Vec<[f32; 3]> = (0..24).map(|k| [k as f32, (k * k) as f32, -0.5]).collect();
        let (fast, size) = half(&texels, [6, 4]);
        assert_eq!((size, fast.len()), ([3, 2], 6));
        // Integers up to 23^2: sums of four are exact.
        assert_eq!(fast[4], [17.5, (14 * 14 + 15 * 15 + 20 * 20 + 21 * 21) as f32 / 4.0, -0.5]);
    }
}
