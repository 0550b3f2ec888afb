//! Diodes in a dark picture: bright spots and their middles (Rump et al. 2008, section 4.1).
//!
//! A spot is the connected region around a local maximum that is brighter than the noise and than a share of the maximum. Its
//! middle is sought from there with a Gaussian window of its width that follows it (Bertin's windowed position in SExtractor):
//! nearly as exact as a fit of the profile, and hardly pulled by the places of pixels, as a mean within a hard rim is. What is no single whole diode is rejected: hot pixels, merged or clipped spots, those at the border.

use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Threshold over the noise of the dark background, standard deviations: one pixel in 1e9 of Gaussian noise.
const NOISE_SIGMAS: f32 = 6.0;
/// Threshold as a share of the maximum: a Gaussian spot keeps 78 % of its light above it, and spots 3 of their standard
/// deviations apart stay two.
const PEAK_SHARE: f32 = 0.3;
/// Fewest pixels: a hot pixel has one, two side by side have two.
const MIN_AREA: usize = 3;
/// A spot this many times larger than the median one is two of them, or blooms.
const MAX_AREA_RATIO: f64 = 1.6;
/// Largest share of saturated pixels: a Gaussian spot has it when its peak is cut to a sixth.
const MAX_SATURATED: f64 = 0.6;
/// Steps of the window, and the step after which it stands, pixels.
const WINDOW_STEPS: usize = 30;
const STANDS: f64 = 1e-7;
/// Least standard deviation of the window: a narrower one sees single pixels.
const MIN_WINDOW_PX: f64 = 1.0;
/// Largest share of the picture that a spot may cover.
const MAX_PICTURE_SHARE: usize = 16;

/// The spots of a picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spots {
    /// Middles of the good ones, pixels, from the brightest maximum on.
    pub centers_px: Vec<DVec2>,
    /// How many were rejected.
    pub rejected: Rejected,
}

/// Spots that are no single whole diode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rejected {
    /// Of one or two pixels.
    pub tiny: usize,
    /// Larger than a spot can be, or touching a brighter one.
    pub merged: usize,
    /// Mostly saturated.
    pub saturated: usize,
    /// Cut by the border of the picture.
    pub border: usize,
}

impl std::fmt::Display for Rejected {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { tiny, merged, saturated, border } = self;
        write!(f, "{tiny} tiny, {merged} merged, {saturated} saturated and {border} cut spots")
    }
}

/// A region above its threshold.
struct Region {
    center_px: DVec2,
    area: usize,
}

/// Finds spots in `light` (row-major, linear light of a pixel; NaN counts as dark), whose pixels are saturated at `saturation`.
pub fn find_spots(light: &[f32], size: [usize; 2], saturation: f32) -> Spots {
    let owner = vec![0; light.len()];
    let (background, noise) = background(light);
    let mut search =
        Search { light, size, saturation, background, owner, regions: 0, rejected: Rejected::default() };
    let floor = background + NOISE_SIGMAS * noise;
    let mut peaks: Vec<usize> =
        (0..light.len()).filter(|k| light[*k] > floor && search.is_peak(*k)).collect();
    peaks.sort_by(|a, b| light[*b].total_cmp(&light[*a]).then(a.cmp(b)));
    let mut regions: Vec<Region> = Vec::new();
    for peak in peaks {
        let threshold = floor.max(background + PEAK_SHARE * (light[peak] - background));
        regions.extend(search.region(peak, threshold));
    }
    let mut areas: Vec<usize> = regions.iter().map(|r| r.area).collect();
    areas.sort_unstable();
    let largest = areas.get(areas.len() / 2).map_or(0.0, |median| MAX_AREA_RATIO * *median as f64);
    let mut rejected = search.rejected;
    // A few pixels more or less are noise of small spots.
    regions.retain(|r| r.area as f64 <= largest.max(6.0));
    rejected.merged += areas.len() - regions.len();
    Spots { centers_px: regions.into_iter().map(|r| r.center_px).collect(), rejected }
}

/// Level and standard deviation of the dark: the median, and how far above it 84 % lie (noise below 0 may be cut off).
fn background(light: &[f32]) -> (f32, f32) {
    let mut sorted: Vec<f32> = light.iter().copied().filter(|v| v.is_finite()).collect();
    if sorted.is_empty() {
        return (0.0, 0.0);
    }
    sorted.sort_unstable_by(f32::total_cmp);
    let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64) as usize];
    (at(0.5), at(0.8413) - at(0.5))
}

struct Search<'a> {
    light: &'a [f32],
    size: [usize; 2],
    saturation: f32,
    background: f32,
    /// Number of the region of a pixel, 0 for none.
    owner: Vec<u32>,
    regions: u32,
    rejected: Rejected,
}

impl Search<'_> {
    /// No neighbor is brighter.
    fn is_peak(&self, k: usize) -> bool {
        let [width, height] = self.size;
        let (x, y) = (k % width, k / width);
        let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
        rows.flat_map(|v| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |u| v * width + u))
            .all(|other| self.light[other].is_nan() || self.light[other] <= self.light[k])
    }

    /// The region about a peak, unless it belongs to a brighter one or is no diode.
    fn region(&mut self, peak: usize, threshold: f32) -> Option<Region> {
        if self.owner[peak] != 0 {
            return None;
        }
        let [width, height] = self.size;
        let (mut pixels, mut next) = (vec![peak], 0);
        let (mut touches, mut at_border) = (false, false);
        self.regions += 1;
        self.owner[peak] = self.regions;
        while next < pixels.len() && pixels.len() <= self.light.len() / MAX_PICTURE_SHARE {
            let k = pixels[next];
            next += 1;
            let (x, y) = (k % width, k / width);
            at_border |= x == 0 || y == 0 || x + 1 == width || y + 1 == height;
            let around = [
                (x > 0, -1),
                (x + 1 < width, 1),
                (y > 0, -(width as isize)),
                (y + 1 < height, width as isize),
            ];
            for (_, step) in around.into_iter().filter(|(inside, _)| *inside) {
                let other = k.wrapping_add_signed(step);
                if self.light[other] > threshold && self.owner[other] == 0 {
                    self.owner[other] = self.regions;
                    pixels.push(other);
                }
                touches |= self.light[other] > threshold && self.owner[other] != self.regions;
            }
        }
        let saturated = pixels.iter().filter(|k| self.light[**k] >= self.saturation).count();
        let whole = next == pixels.len();
        let count = match () {
            () if pixels.len() < MIN_AREA => &mut self.rejected.tiny,
            () if touches || !whole => &mut self.rejected.merged,
            () if at_border => &mut self.rejected.border,
            () if saturated as f64 > MAX_SATURATED * pixels.len() as f64 => &mut self.rejected.saturated,
            () => return Some(self.middle(&pixels, threshold)),
        };
        *count += 1;
        None
    }

    fn middle(&self, pixels: &[usize], threshold: f32) -> Region {
        let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
        for k in pixels {
            let weight = f64::from(self.light[*k] - threshold);
            let place = DVec2::new((k % self.size[0]) as f64, (k / self.size[0]) as f64);
            sum += weight * (place + 0.5);
            weights += weight;
        }
        Region { center_px: self.windowed(sum / weights, pixels.len()), area: pixels.len() }
    }

    /// The middle of a spot of an area from a place near it; that place if there is no middle near it.
    fn windowed(&self, start: DVec2, area: usize) -> DVec2 {
        let reach_of_share = (-2.0 * f64::from(PEAK_SHARE).ln()).sqrt();
        let sigma = ((area as f64 / std::f64::consts::PI).sqrt() / reach_of_share).max(MIN_WINDOW_PX);
        let mut center = start;
        for _ in 0..WINDOW_STEPS {
            let low = (center - 4.0 * sigma).max(DVec2::ZERO);
            let high = center + 4.0 * sigma;
            let [columns, rows] = [0, 1]
                .map(|axis| low[axis] as usize..(high[axis].ceil().max(0.0) as usize).min(self.size[axis]));
            let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
            for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
                let apart = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - center;
                let light = f64::from(self.light[y * self.size[0] + x] - self.background);
                let weight = light * (-0.5 * apart.length_squared() / (sigma * sigma)).exp();
                sum += weight * apart;
                weights += weight;
            }
            // Under a window as wide as the spot the mean moves half as far as the spot is off.
            let step = 2.0 * sum / weights;
            center += step;
            if !center.is_finite() || center.distance(start) > sigma {
                return start;
            }
            if step.length() < STANDS {
                break;
            }
        }
        center
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [64, 48];

    fn picture(spots: &[(DVec2, f64)], sigma: f64) -> Vec<f32> {
        let at = |k: usize| DVec2::new((k % SIZE[0]) as f64 + 0.5, (k / SIZE[0]) as f64 + 0.5);
        let light = |k: usize| {
            spots
                .iter()
                .map(|(p, peak)| peak * (-0.5 * at(k).distance_squared(*p) / (sigma * sigma)).exp())
                .sum::<f64>()
        };
        (0..SIZE[0] * SIZE[1]).map(|k| (light(k) as f32).min(1.0)).collect()
    }

    #[test]
    fn middles_do_not_depend_on_the_places_of_pixels() {
        for sigma in [0.8, 1.0, 1.7] {
            for k in 0..20 {
                let middle = DVec2::new(30.0 + 0.05 * f64::from(k), 20.0 + 0.031 * f64::from(k));
                let found = find_spots(&picture(&[(middle, 0.5)], sigma), SIZE, 1.0).centers_px;
                assert_eq!(found.len(), 1);
                // Spot times window is a Gaussian of 0.6 pixels, whose samples alias by some 1e-3.
                assert!(found[0].distance(middle) < 5e-3, "{sigma}: {} {middle}", found[0]);
            }
        }
    }

    #[test]
    fn what_is_no_single_whole_diode_is_rejected() {
        let at = |x: f64, y: f64, peak: f64| (DVec2::new(x, y), peak);
        let good = [at(10.2, 10.4, 0.6), at(30.0, 12.0, 0.6), at(50.0, 10.0, 0.3), at(20.5, 30.5, 0.5)];
        let bad = [at(0.3, 40.0, 0.6), at(40.0, 30.0, 0.6), at(43.0, 30.0, 0.6), at(55.0, 40.0, 30.0)];
        let mut light = picture(&[&good[..], &bad[..]].concat(), 1.0);
        light[20 * 64 + 5] = 0.9;
        light[40 * 64 + 30] = f32::NAN;
        let found = find_spots(&light, SIZE, 1.0);
        assert_eq!(found.centers_px.len(), good.len(), "{found:?}");
        assert!(good.iter().all(|(p, _)| found.centers_px.iter().any(|f| f.distance(*p) < 0.02)));
        assert_eq!((found.rejected.tiny, found.rejected.border, found.rejected.saturated), (1, 1, 1));
        assert!(found.rejected.merged >= 1, "{:?}", found.rejected);
        assert_eq!(find_spots(&[f32::NAN; 64 * 48], SIZE, 1.0), Spots::default());
        assert_eq!(find_spots(&vec![1.0; 64 * 48], SIZE, 1.0), Spots::default());
    }
}
