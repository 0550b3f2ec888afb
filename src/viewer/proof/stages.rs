//! In which steps a picture becomes fine where it takes long.

/// What one step may take while something moves, seconds.
const BUDGET: f64 = 0.05;
/// Pixels of a coarse picture at most, to either side.
const COARSEST: usize = 8;
/// Rays a pixel of a fine picture; the dots under a pixel are averaged in any case, so that these are for edges.
const RAYS: usize = 4;

/// A step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// Pixels to either side that one of the picture stands for.
    pub divisor: usize,
    /// Rays a pixel.
    pub rays: usize,
}

impl Stage {
    /// As fine as it gets.
    pub const LAST: Self = Self { divisor: 1, rays: RAYS };

    /// Size of the picture of a step.
    pub fn size(self, size: [usize; 2]) -> [usize; 2] {
        size.map(|n| n.div_ceil(self.divisor))
    }
}

/// The steps for so many pixels where a ray takes so many seconds.
pub fn stages(pixels: usize, ray: f64) -> Vec<Stage> {
    let one = pixels as f64 * ray;
    if one * RAYS as f64 <= BUDGET {
        return vec![Stage::LAST];
    }
    let divisor = ((one / BUDGET).sqrt().ceil() as usize).clamp(1, COARSEST);
    let mut all = vec![Stage { divisor, rays: 1 }];
    if divisor > 2 {
        all.push(Stage { divisor: 1, rays: 1 });
    }
    all.push(Stage::LAST);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_fast_is_fine_at_once_and_the_first_step_is_within_the_budget() {
        assert_eq!(stages(1000, 1e-6), [Stage::LAST]);
        for (pixels, ray) in [(20_000, 1e-6), (500_000, 1e-6), (500_000, 3e-6), (1_000_000, 1e-9)] {
            let all = stages(pixels, ray);
            assert_eq!(all.last(), Some(&Stage::LAST));
            let first = all[0];
            let area = (first.divisor * first.divisor) as f64;
            assert!(pixels as f64 * ray * first.rays as f64 / area <= BUDGET, "{pixels} {ray}");
            assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
        }
        assert_eq!(stages(1 << 24, 1.0)[0].divisor, COARSEST, "whatever it takes");
    }
}
