//! Step II: the lens of one camera at the zoom of the measurement, its pose held (Rump et al. 2008, section 4.1).
//!
//! Focal length and principal point, and k1 where the diodes in view determine it: at zoom they lie so near the axis that it
//! mostly moves them by less than the noise, and then it stays 0.

use super::bundle::{LENS, View, derivatives, moved_lens};
use crate::math::projection::Intrinsics;
use nalgebra::{DMatrix, DVector, SVector};

/// Gauss-Newton steps; the model is linear but for the distortion.
const STEPS: usize = 8;
/// A distortion below this many of its standard errors is not told from none.
pub const SIGNIFICANT: f64 = 3.0;

/// A lens and how well it is known.
#[derive(Debug, Clone, Copy)]
pub struct ZoomLens {
    /// The lens.
    pub lens: Intrinsics,
    /// Standard error of its focal length, pixels.
    pub focal_error_px: f64,
}

/// The lens of a view whose pose is known, from a start on; `None` where the view does not determine it.
pub fn fit_lens(view: &View, start: Intrinsics) -> Option<ZoomLens> {
    let start = Intrinsics { distortion: [0.0; 2], ..start };
    let (plain, errors) = descend(view, start, 3)?;
    let bent = descend(view, plain, 4).filter(|(lens, errors)| {
        lens.distortion[0].abs() > SIGNIFICANT * errors[3] * view.variance(lens, 4).sqrt()
    });
    let (lens, errors) = bent.unwrap_or((plain, errors));
    Some(ZoomLens { lens, focal_error_px: errors[0] * view.variance(&lens, 4).sqrt() })
}

/// The best lens, and standard errors for pixel coordinates of unit variance.
fn descend(view: &View, start: Intrinsics, numbers: usize) -> Option<(Intrinsics, [f64; LENS])> {
    let (mut lens, mut errors) = (start, [0.0; LENS]);
    if 2 * view.seen.len() <= numbers {
        return None;
    }
    for _ in 0..STEPS {
        let mut normal = DMatrix::zeros(numbers, numbers);
        let mut side = DVector::zeros(numbers);
        for (led, pixel) in &view.seen {
            let at = derivatives(&lens, &view.pose, *led)?;
            let rows = at.by_lens.columns(0, numbers);
            let residual = *pixel - at.pixel;
            normal += rows.transpose() * rows;
            side += rows.transpose() * SVector::<f64, 2>::new(residual.x, residual.y);
        }
        let inverse = normal.cholesky()?.inverse();
        let mut step = SVector::<f64, LENS>::zeros();
        step.rows_mut(0, numbers).copy_from(&(&inverse * side));
        (0..numbers).for_each(|k| errors[k] = inverse[(k, k)].sqrt());
        lens = moved_lens(&lens, &step);
    }
    (lens.focal_px > 0.0 && lens.focal_px.is_finite()).then_some((lens, errors))
}
