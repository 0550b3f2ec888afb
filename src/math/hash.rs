//! Counter-based random numbers: the same bits on any thread, on CPU and GPU.
//!
//! `pcg4d` is the four-dimensional hash of Jarzynski & Olano 2020, "Hash Functions for GPU Rendering"
//! (JCGT 9(3)), integer arithmetic only.

/// Hashes four words to four words, each uniform.
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = v.map(|n| n.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if round == 0 {
            [x, y, z, w] = [x, y, z, w].map(|n| n ^ (n >> 16));
        }
    }
    [x, y, z, w]
}

/// The open unit interval: 24 bits, centerd, never 0 or 1, exact in f32.
pub fn unit(bits: u32) -> f32 {
    // Odd multiples of 2^-24: 23 random bits and the centring half step.
    ((bits >> 9) * 2 + 1) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_interval_is_open() {
        assert!(unit(0) > 0.0);
        assert!(unit(u32::MAX) < 1.0);
    }

    #[test]
    fn hashes_of_neighbours_are_uncorrelated() {
        let n = 1 << 16;
        let draw = |i: u32| f64::from(unit(pcg4d([i, 7, 0, 3])[0])) - 0.5;
        let variance: f64 = (0..n).map(|i| draw(i) * draw(i)).sum::<f64>() / f64::from(n);
        let covariance: f64 = (0..n).map(|i| draw(i) * draw(i + 1)).sum::<f64>() / f64::from(n);
        // Four standard errors of 65,536 draws: variance 1/12 +- 0.0745/256, covariance 0 +- (1/12)/256.
        assert!((variance - 1.0 / 12.0).abs() < 4.0 * 0.0745 / 256.0);
        assert!(covariance.abs() < 4.0 / 12.0 / 256.0);
    }
}
