//! Which spot is which diode.
//!
//! The expected camera takes spots to the plate, where they differ from the diodes by a shift (turning the camera by a degree
//! moves the picture by several diodes) and, little, by a homography. Shifts are voted for by all pairs of a spot and a diode;
//! the likeliest are refined, each spot with the nearest diode and a homography from all, by turns. The plate is periodic: the
//! shift that names most spots wins, and among equals the smallest.

use super::homography::{apply, homography};
use crate::math::projection::Projection;
use glam::{DMat3, DVec2};
use std::collections::BTreeMap;

/// Bins of the votes per distance of two diodes.
const BINS: f64 = 3.0;
/// Shifts that are looked at closely: all bins of the right one, over which its votes spread where the expected picture is turned
/// or tilted against the true one, and of its neighbors by one diode.
const CANDIDATES: usize = 100;
/// How far the expected camera may point past the plate, as a share of its distance: 2 degrees.
const REACH: f64 = 0.035;
/// From the middle outwards, as a picture that is foreshortened otherwise than expected is right there alone: the share of the
/// spots' radius that is looked at, and how far a spot may lie from its diode, distances of two diodes.
const ROUNDS: [(f64, f64); 9] = [
    (0.0, 0.5),
    (0.0, 0.45),
    (0.35, 0.4),
    (0.5, 0.4),
    (0.7, 0.4),
    (1.0, 0.35),
    (1.0, 0.3),
    (1.0, 0.25),
    (1.0, 0.25),
];
/// Fewest spots looked at: four make a homography, and a grid's middle nine a stable one.
const MIN_MIDDLE: usize = 9;
/// Smallest share of the spots that must be diodes: by chance a sixth lie within 0.25 of one, after a fit up to a half.
const MIN_SHARE: f64 = 0.7;
/// Largest change of lengths and angles from the expected picture: 10 % are 6 degrees of tilt at 30 degrees and 1 at 80.
const MAX_CHANGE: f64 = 0.15;
/// Fewest diodes of a camera: a homography and some to check it.
pub const MIN_DIODES: usize = 8;

/// The plate.
pub struct Plate {
    /// Places of the diodes, millimetres.
    pub leds_mm: Vec<DVec2>,
    /// Distance of neighbors, millimetres.
    pub pitch_mm: f64,
    cells: BTreeMap<[i64; 2], Vec<usize>>,
}

/// The diodes that were found: number and pixel.
pub type Named = Vec<(usize, DVec2)>;

impl Plate {
    /// A plate of diodes; the pitch is the median distance to the nearest neighbor.
    pub fn new(leds_mm: &[[f64; 2]]) -> Self {
        let leds_mm: Vec<DVec2> = leds_mm.iter().copied().map(DVec2::from).collect();
        let nearest = |k: usize| {
            let others = leds_mm.iter().enumerate().filter(|(other, _)| *other != k);
            others.map(|(_, led)| led.distance(leds_mm[k])).fold(f64::INFINITY, f64::min)
        };
        // A thousand tell the pitch.
        let mut distances: Vec<f64> =
            (0..leds_mm.len()).step_by(1 + leds_mm.len() / 1000).map(nearest).collect();
        distances.sort_by(f64::total_cmp);
        let pitch_mm = distances[distances.len() / 2].max(1e-6);
        let mut cells: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for (k, led) in leds_mm.iter().enumerate() {
            cells.entry(cell(*led, pitch_mm)).or_default().push(k);
        }
        Self { leds_mm, pitch_mm, cells }
    }

    /// The diode nearest to a place, if it is within `reach` (at most one) pitches.
    fn nearest(&self, place: DVec2, reach: f64) -> Option<(usize, f64)> {
        let [x, y] = cell(place, self.pitch_mm);
        let around = (-1..=1).flat_map(|v| (-1..=1).map(move |u| [x + u, y + v]));
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        let near = near.map(|k| (*k, self.leds_mm[*k].distance(place)));
        near.filter(|(_, d)| *d <= reach * self.pitch_mm)
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
    }

    /// Names the spots of a camera that should be about where `expected` says.
    ///
    /// `None` unless most of them make a plate that looks about as expected.
    pub fn name(&self, spots_px: &[DVec2], expected: &Projection) -> Option<Named> {
        let on_plate = |pixel: &DVec2| expected.on_plane(*pixel, 0.0).map(|p| (*pixel, p.truncate()));
        let mut seen: Vec<(DVec2, DVec2)> = spots_px.iter().filter_map(on_plate).collect();
        if seen.len() < MIN_DIODES {
            return None;
        }
        let middle = seen.iter().map(|(_, place)| *place).sum::<DVec2>() / seen.len() as f64;
        seen.sort_by(|a, b| a.1.distance(middle).total_cmp(&b.1.distance(middle)));
        let mut best = Named::new();
        for shift in self.shifts(&seen, expected) {
            let named = self.refine(&seen, middle, shift).unwrap_or_default();
            // The first of equals: shifts come from the smallest on.
            if named.len() > best.len() {
                best = named;
            }
            if best.len() == seen.len() {
                break;
            }
        }
        (best.len() >= MIN_DIODES && best.len() as f64 >= MIN_SHARE * spots_px.len() as f64).then_some(best)
    }

    /// The likeliest shifts from where spots seem to be to diodes, the smallest first.
    fn shifts(&self, seen: &[(DVec2, DVec2)], expected: &Projection) -> Vec<DVec2> {
        let pose = expected.pose;
        let distance = pose.position_mm.length();
        let reach = (REACH * distance * distance / pose.position_mm.z).max(self.pitch_mm);
        let bin = self.pitch_mm / BINS;
        let mut votes: BTreeMap<[i64; 2], (usize, DVec2)> = BTreeMap::new();
        for (_, place) in seen {
            for led in self.leds_mm.iter().filter(|led| led.distance_squared(*place) <= reach * reach) {
                let vote = votes.entry(cell(*led - *place, bin)).or_default();
                *vote = (vote.0 + 1, vote.1 + (*led - *place));
            }
        }
        let mut bins: Vec<(usize, DVec2)> = votes.into_values().map(|(n, sum)| (n, sum / n as f64)).collect();
        bins.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.length().total_cmp(&b.1.length())));
        bins.truncate(CANDIDATES);
        let mut shifts: Vec<DVec2> = bins.into_iter().map(|(_, shift)| shift).collect();
        shifts.sort_by(|a, b| a.length().total_cmp(&b.length()));
        shifts
    }

    /// Spots with their diodes, from a shift on; spots come from their middle outwards.
    fn refine(&self, seen: &[(DVec2, DVec2)], middle: DVec2, shift: DVec2) -> Option<Named> {
        let farthest = seen.last()?.1.distance(middle);
        let mut map = DMat3::from_translation(shift);
        let mut named = Named::new();
        for (share, tolerance) in ROUNDS {
            let inside = seen.partition_point(|(_, place)| place.distance(middle) <= share * farthest);
            let seen = &seen[..inside.max(MIN_MIDDLE.min(seen.len()))];
            // One spot a diode: the nearest.
            let mut nearest: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
            for (spot, (_, place)) in seen.iter().enumerate() {
                if let Some((led, distance)) = self.nearest(apply(map, *place)?, tolerance) {
                    let held = nearest.entry(led).or_insert((distance, spot));
                    if distance < held.0 {
                        *held = (distance, spot);
                    }
                }
            }
            let pairs: Vec<_> =
                nearest.iter().map(|(led, (_, k))| (seen[*k].1, self.leds_mm[*led])).collect();
            map = homography(&pairs)?;
            named = nearest.iter().map(|(led, (_, k))| (*led, seen[*k].0)).collect();
        }
        is_about_a_shift(map, middle).then_some(named)
    }
}

/// Whether a homography keeps lengths and angles about the middle of the spots.
fn is_about_a_shift(map: DMat3, middle: DVec2) -> bool {
    let step = 1e-3;
    let axes = [DVec2::X, DVec2::Y].map(|axis| {
        let ends = [apply(map, middle + step * axis), apply(map, middle - step * axis)];
        ends[0].zip(ends[1]).map_or(f64::INFINITY, |(a, b)| ((a - b) / (2.0 * step) - axis).length())
    });
    axes.iter().all(|change| *change <= MAX_CHANGE)
}

fn cell(place: DVec2, side: f64) -> [i64; 2] {
    [(place.x / side).floor() as i64, (place.y / side).floor() as i64]
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::normal;
    use super::*;
    use crate::math::projection::{Intrinsics, Pose};
    use glam::{DQuat, DVec3};

    /// A plate of 20 cm seen from 65 cm at 60 to 80 degrees, expected places off by 2 mm and a third of a degree about each axis: a
    /// row of diodes that is mistaken for the next is a pose off by the pitch, without a trace in the residuals.
    #[test]
    fn no_camera_mistakes_a_row_for_the_next() {
        let leds: Vec<[f64; 2]> =
            (0..121).map(|k| [f64::from(k % 11 - 5) * 19.0, f64::from(k / 11 - 5) * 19.0]).collect();
        let plate = Plate::new(&leds);
        let intrinsics = Intrinsics::pinhole(2300.0, [1024; 2]);
        for k in 0..600u32 {
            let n = |j: u32| DVec3::new(normal([k, j, 3, 1]), normal([k, j, 3, 2]), normal([k, j, 3, 3]));
            let (polar, turn) = (f64::from(60 + k % 21).to_radians(), 2.4 * f64::from(k));
            let place = 650.0 * DVec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
            let pose = Pose::looking_at(place, DVec3::ZERO, if polar < 0.1 { DVec3::Y } else { DVec3::Z });
            let off = DQuat::from_scaled_axis(0.3f64.to_radians() * n(1));
            let expected = Pose {
                position_mm: pose.position_mm + 2.0 * n(2),
                rotation: (off * pose.rotation).normalize(),
            };
            let camera = Projection { intrinsics, pose };
            let spots: Vec<DVec2> =
                plate.leds_mm.iter().map(|led| camera.pixel(led.extend(0.0)).unwrap()).collect();
            let named = plate.name(&spots, &Projection { intrinsics, pose: expected });
            let named = named.unwrap_or_else(|| panic!("{k}: nothing is named"));
            assert_eq!(named.len(), 121, "{k}: {polar}");
            assert!(named.iter().all(|(led, pixel)| *pixel == spots[*led]), "{k}: {polar}");
        }
    }
}
