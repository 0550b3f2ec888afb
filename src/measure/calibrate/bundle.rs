//! Step I: one lens and all poses at the least reprojection error (Zhang 2000, section 3.2; Rump et al. 2008, section 4.1).
//!
//! Levenberg-Marquardt over focal length, principal point, k1, k2 of the common lens and six numbers a camera. Cameras share the
//! lens alone, so that the normal equations are an arrow: `[A, B_i; B_i^T, C_i]`. The lens comes from `A - sum B_i C_i^-1 B_i^T`
//! (Schur's complement), the cameras one by one after it: time grows with the number of cameras, not with its cube.
//! The inverse of the same arrow is the covariance.

use crate::math::projection::{Intrinsics, Pose};
use glam::{DMat3, DQuat, DVec2, DVec3};
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

/// Numbers of a lens: focal length, principal point, k1, k2.
pub const LENS: usize = 5;
/// Numbers of a pose: its turn (vector in the camera's frame), its position.
const POSE: usize = 6;
/// Most steps; from the closed form some ten suffice.
const MAX_STEPS: usize = 100;
/// Damping at the start, and beyond which no step is smaller.
const DAMPING: [f64; 2] = [1e-4, 1e12];
/// The descent ends where a step changes the error by less than this share twice.
const CONVERGED: f64 = 1e-12;

/// An outlier is this many times farther off than the median: 4.7 standard deviations of a coordinate, one diode in 60,000.
const OUTLIER_MEDIANS: f64 = 4.0;
/// And at least this far, pixels: with exact data the median is rounding.
const MIN_OUTLIER_PX: f64 = 0.02;

type Lens = SVector<f64, LENS>;
type PoseStep = SVector<f64, POSE>;

/// What a camera saw of the plate.
#[derive(Debug, Clone)]
pub struct View {
    /// Places on the plate and the pixels where they are seen.
    pub seen: Vec<(DVec2, DVec2)>,
    /// Its pose.
    pub pose: Pose,
    /// One over the variance of a pixel coordinate.
    pub weight: f64,
}

/// Lens and views; the first `lens_numbers` numbers of the lens (3 to 5) are sought.
#[derive(Debug, Clone)]
pub struct Bundle {
    /// The common lens.
    pub lens: Intrinsics,
    /// The cameras.
    pub views: Vec<View>,
    /// Numbers of the lens that are sought.
    pub lens_numbers: usize,
}

/// Covariances, in units of the weights.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// Of the lens.
    pub lens: SMatrix<f64, LENS, LENS>,
    /// Of each pose: turn in radians about the camera's axes, position in millimetres.
    pub poses: Vec<SMatrix<f64, POSE, POSE>>,
}

/// Normal equations of one view.
struct Block {
    lens: SMatrix<f64, LENS, LENS>,
    mixed: SMatrix<f64, LENS, POSE>,
    pose: SMatrix<f64, POSE, POSE>,
    lens_side: Lens,
    pose_side: PoseStep,
}

/// Pixel of a point of the plate, and its derivatives by lens and pose.
pub struct Derivatives {
    /// The pixel.
    pub pixel: DVec2,
    /// By focal length, principal point, k1, k2.
    pub by_lens: SMatrix<f64, 2, LENS>,
    by_pose: SMatrix<f64, 2, POSE>,
}

/// Pixel and derivatives; `None` unless the point lies in front.
pub fn derivatives(lens: &Intrinsics, pose: &Pose, on_plate: DVec2) -> Option<Derivatives> {
    let local = pose.local(on_plate.extend(0.0));
    let pixel = lens.pixel(local)?;
    let plane = local.truncate() / local.z;
    let (f, [k1, k2]) = (lens.focal_px, lens.distortion);
    let r2 = plane.length_squared();
    let stretch = 1.0 + r2 * (k1 + r2 * k2);
    let mut by_lens = SMatrix::<f64, 2, LENS>::zeros();
    for axis in 0..2 {
        by_lens[(axis, 0)] = stretch * plane[axis];
        by_lens[(axis, 1 + axis)] = 1.0;
        by_lens[(axis, 3)] = f * r2 * plane[axis];
        by_lens[(axis, 4)] = f * r2 * r2 * plane[axis];
    }
    let slope = 2.0 * (k1 + 2.0 * r2 * k2);
    let by_local = |moved: DVec3| {
        let change = (moved.truncate() - plane * moved.z) / local.z;
        f * (stretch * change + slope * plane.dot(change) * plane)
    };
    let turn = DMat3::from_quat(pose.rotation);
    let moves = [DVec3::X, DVec3::Y, DVec3::Z];
    let moves = moves.map(|axis| axis.cross(local)).into_iter().chain(moves.map(|axis| -(turn * axis)));
    let mut by_pose = SMatrix::<f64, 2, POSE>::zeros();
    for (k, moved) in moves.enumerate() {
        let change = by_local(moved);
        (by_pose[(0, k)], by_pose[(1, k)]) = (change.x, change.y);
    }
    Some(Derivatives { pixel, by_lens, by_pose })
}

impl View {
    /// Reprojection errors, pixels; infinite for points behind the camera.
    pub fn residuals<'a>(&'a self, lens: &'a Intrinsics) -> impl Iterator<Item = DVec2> + 'a {
        let behind = DVec2::splat(f64::INFINITY);
        self.seen.iter().map(move |(led, pixel)| {
            lens.pixel(self.pose.local(led.extend(0.0))).map_or(behind, |p| *pixel - p)
        })
    }

    /// Variance of a pixel coordinate, from the residuals of a fit of `numbers` numbers.
    pub fn variance(&self, lens: &Intrinsics, numbers: usize) -> f64 {
        let freedom = (2 * self.seen.len()).saturating_sub(numbers).max(1);
        self.residuals(lens).map(DVec2::length_squared).sum::<f64>() / freedom as f64
    }

    /// Root mean square distance of what is seen from what should be, pixels.
    pub fn rms_px(&self, lens: &Intrinsics) -> f64 {
        (self.residuals(lens).map(DVec2::length_squared).sum::<f64>() / self.seen.len().max(1) as f64).sqrt()
    }

    /// Drops what lies far from where it should be, by the median of all: hot pixels and reflections.
    pub fn drop_outliers(&mut self, lens: &Intrinsics) {
        let mut distances: Vec<f64> = self.residuals(lens).map(DVec2::length).collect();
        let mut kept = distances.clone().into_iter();
        distances.sort_by(f64::total_cmp);
        let median = distances.get(distances.len() / 2).copied().unwrap_or_default();
        let limit = (OUTLIER_MEDIANS * median).max(MIN_OUTLIER_PX);
        self.seen.retain(|_| kept.next().is_some_and(|d| d <= limit));
    }

    fn error(&self, lens: &Intrinsics) -> f64 {
        self.weight * self.residuals(lens).map(DVec2::length_squared).sum::<f64>()
    }

    fn block(&self, lens: &Intrinsics, lens_numbers: usize) -> Block {
        let mut block = Block {
            lens: SMatrix::zeros(),
            mixed: SMatrix::zeros(),
            pose: SMatrix::zeros(),
            lens_side: Lens::zeros(),
            pose_side: PoseStep::zeros(),
        };
        for (led, pixel) in &self.seen {
            let Some(mut at) = derivatives(lens, &self.pose, *led) else { continue };
            (lens_numbers..LENS).for_each(|k| at.by_lens.column_mut(k).fill(0.0));
            let residual = *pixel - at.pixel;
            let residual = SVector::<f64, 2>::new(residual.x, residual.y);
            block.lens += self.weight * at.by_lens.transpose() * at.by_lens;
            block.mixed += self.weight * at.by_lens.transpose() * at.by_pose;
            block.pose += self.weight * at.by_pose.transpose() * at.by_pose;
            block.lens_side += self.weight * at.by_lens.transpose() * residual;
            block.pose_side += self.weight * at.by_pose.transpose() * residual;
        }
        block
    }
}

impl Bundle {
    /// Brings lens and poses to the least error.
    pub fn descend(&mut self) {
        let [mut damping, limit] = DAMPING;
        let (mut error, mut still) = (self.error(), 0);
        for _ in 0..MAX_STEPS {
            let blocks = self.blocks();
            let next = loop {
                let tried = self.stepped(&blocks, damping).map(|bundle| (bundle.error(), bundle));
                match tried {
                    Some((less, bundle)) if less <= error => break Some((less, bundle)),
                    _ if damping > limit => break None,
                    _ => damping *= 10.0,
                }
            };
            let Some((less, bundle)) = next else { return };
            still = if error - less <= CONVERGED * error { still + 1 } else { 0 };
            *self = bundle;
            error = less;
            if still == 2 {
                return;
            }
            damping = (damping * 0.1).max(1e-12);
        }
    }

    /// Weighted sum of squares.
    pub fn error(&self) -> f64 {
        self.views.iter().map(|view| view.error(&self.lens)).sum()
    }

    fn blocks(&self) -> Vec<Block> {
        self.views.par_iter().map(|view| view.block(&self.lens, self.lens_numbers)).collect()
    }

    /// Schur's complement of the poses and its right side, damped; `None` where a view does not determine its pose.
    fn reduced(
        &self,
        blocks: &[Block],
        damping: f64,
    ) -> Option<(SMatrix<f64, LENS, LENS>, Lens, Vec<Inverse>)> {
        let (mut lens, mut side) = (SMatrix::<f64, LENS, LENS>::zeros(), Lens::zeros());
        let mut inverses = Vec::with_capacity(blocks.len());
        for block in blocks {
            lens += damped(block.lens, damping);
            side += block.lens_side;
            let inverse = damped(block.pose, damping).cholesky()?.inverse();
            let gain = block.mixed * inverse;
            lens -= gain * block.mixed.transpose();
            side -= gain * block.pose_side;
            inverses.push(Inverse { pose: inverse, gain });
        }
        (self.lens_numbers..LENS).for_each(|k| lens[(k, k)] = 1.0);
        Some((lens, side, inverses))
    }

    fn stepped(&self, blocks: &[Block], damping: f64) -> Option<Self> {
        let (lens, side, inverses) = self.reduced(blocks, damping)?;
        let step = lens.cholesky()?.solve(&side);
        let mut next = self.clone();
        next.lens = moved_lens(&self.lens, &step);
        for ((view, block), inverse) in next.views.iter_mut().zip(blocks).zip(&inverses) {
            let step = inverse.pose * block.pose_side - inverse.gain.transpose() * step;
            let turn = DQuat::from_scaled_axis(DVec3::new(step[0], step[1], step[2]));
            view.pose.rotation = (turn * view.pose.rotation).normalize();
            view.pose.position_mm += DVec3::new(step[3], step[4], step[5]);
        }
        (next.lens.focal_px > 0.0).then_some(next)
    }

    /// Covariances at the least error; `None` where the views do not determine lens and poses.
    pub fn covariance(&self) -> Option<Covariance> {
        let (lens, _, inverses) = self.reduced(&self.blocks(), 0.0)?;
        let mut lens = lens.cholesky()?.inverse();
        (self.lens_numbers..LENS).for_each(|k| lens[(k, k)] = 0.0);
        let poses = inverses.iter().map(|i| i.pose + i.gain.transpose() * lens * i.gain).collect();
        Some(Covariance { lens, poses })
    }
}

/// `C^-1` and `B C^-1` of a view.
struct Inverse {
    pose: SMatrix<f64, POSE, POSE>,
    gain: SMatrix<f64, LENS, POSE>,
}

fn damped<const N: usize>(mut matrix: SMatrix<f64, N, N>, damping: f64) -> SMatrix<f64, N, N> {
    (0..N).for_each(|k| matrix[(k, k)] *= 1.0 + damping);
    matrix
}

/// A lens moved by a step of its numbers.
pub fn moved_lens(lens: &Intrinsics, step: &SVector<f64, LENS>) -> Intrinsics {
    Intrinsics {
        focal_px: lens.focal_px + step[0],
        center_px: [lens.center_px[0] + step[1], lens.center_px[1] + step[2]],
        distortion: [lens.distortion[0] + step[3], lens.distortion[1] + step[4]],
    }
}

#[cfg(test)]
mod tests {
    use super::super::homography::homography;
    use super::super::synthetic::{SyntheticDome, normal};
    use super::super::zhang;
    use super::*;

    /// Views of the true cameras with noise of `sigma` pixels, poses and lens from the closed form.
    fn bundle(dome: &SyntheticDome, sigma: f64, seed: u32) -> Bundle {
        let noise =
            |camera: usize, led: usize, axis: u32| sigma * normal([seed, camera as u32, led as u32, axis]);
        let seen = |camera: usize| {
            let leds = dome.rig.leds_mm.iter().map(|led| DVec2::from(*led)).enumerate();
            leds.map(|(k, led)| {
                let pixel = dome.projection_wide(camera).pixel(led.extend(0.0)).unwrap();
                (led, pixel + DVec2::new(noise(camera, k, 0), noise(camera, k, 1)))
            })
            .collect::<Vec<_>>()
        };
        let seen: Vec<_> = (0..dome.cameras.len()).map(seen).collect();
        let homographies: Vec<_> = seen.iter().map(|s| homography(s).unwrap()).collect();
        let nominal = Intrinsics::pinhole(dome.rig.focal_wide_px, dome.rig.image_px);
        let lens = zhang::common_lens(&homographies, nominal);
        let views = seen.into_iter().zip(homographies);
        let views = views.map(|(seen, h)| View { seen, pose: zhang::pose(h, &lens).unwrap(), weight: 1.0 });
        let mut bundle = Bundle { lens, views: views.collect(), lens_numbers: 4 };
        bundle.descend();
        bundle
    }

    #[test]
    fn exact_data_give_exact_poses() {
        let dome = SyntheticDome::new(9);
        let found = bundle(&dome, 0.0, 1);
        for (view, truth) in found.views.iter().zip(&dome.cameras) {
            let moved = view.pose.position_mm.distance(truth.pose.position_mm);
            let turned = view.pose.rotation.angle_between(truth.pose.rotation);
            // Rounding of pixels, 1e-13, over the worst condition: a pixel is 650 mm or a radian and a half across.
            assert!(moved < 1e-7 && turned < 1e-7, "{moved:e} {turned:e}");
        }
        assert!((found.lens.focal_px - dome.wide.focal_px).abs() < 1e-7);
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let dome = SyntheticDome::new(5);
        let lens = Intrinsics { distortion: [-0.3, 2.0], ..dome.wide };
        let (pose, led, step) = (dome.cameras[3].pose, DVec2::new(20.0, -15.0), 1e-5);
        let at = derivatives(&lens, &pose, led).unwrap();
        let pixel = |lens: &Intrinsics, pose: &Pose| lens.pixel(pose.local(led.extend(0.0))).unwrap();
        let check = |difference: DVec2, column: [f64; 2]| {
            // Rounding of 1e3 pixels over twice the step, 1e-8, and the third derivative times the step's square.
            assert!(
                (difference / (2.0 * step) - DVec2::from(column)).length() < 1e-6 * (1.0 + column[0].abs())
            );
        };
        for k in 0..LENS {
            let step = Lens::from_fn(|j, _| if j == k { step } else { 0.0 });
            let ends = [1.0, -1.0].map(|sign| pixel(&moved_lens(&lens, &(step * sign)), &pose));
            check(ends[0] - ends[1], [at.by_lens[(0, k)], at.by_lens[(1, k)]]);
        }
        for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let turned = |sign: f64| Pose {
                rotation: DQuat::from_scaled_axis(sign * step * axis) * pose.rotation,
                ..pose
            };
            let moved = |sign: f64| Pose { position_mm: pose.position_mm + sign * step * axis, ..pose };
            check(
                pixel(&lens, &turned(1.0)) - pixel(&lens, &turned(-1.0)),
                [at.by_pose[(0, k)], at.by_pose[(1, k)]],
            );
            check(
                pixel(&lens, &moved(1.0)) - pixel(&lens, &moved(-1.0)),
                [at.by_pose[(0, k + 3)], at.by_pose[(1, k + 3)]],
            );
        }
    }

    /// Errors over the standard errors of the covariance (the Cramer-Rao bound) have variance 1, at both levels of noise.
    #[test]
    fn errors_are_as_large_as_the_bound() {
        let dome = SyntheticDome::new(9);
        for sigma in [0.01, 0.1] {
            let (mut square, mut count) = (0.0, 0.0);
            for seed in 0..12 {
                let mut found = bundle(&dome, sigma, 100 + seed);
                found.views.iter_mut().for_each(|view| view.weight = 1.0 / (sigma * sigma));
                let covariance = found.covariance().unwrap();
                for ((view, truth), c) in found.views.iter().zip(&dome.cameras).zip(&covariance.poses) {
                    let moved = view.pose.position_mm - truth.pose.position_mm;
                    square += (0..3).map(|k| moved[k] * moved[k] / c[(3 + k, 3 + k)]).sum::<f64>();
                    count += 3.0;
                }
            }
            // 12 draws of 9 cameras; through the lens they share, a draw's errors hang together: some 60 independent ones,
            // whose mean square is 1 +- 0.18; three of these.
            assert!((square / count - 1.0f64).abs() < 0.55, "{sigma}: {}", square / count);
        }
    }
}
