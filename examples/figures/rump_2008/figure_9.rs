//! Fig. 9: a slice before and after the homogeneous part is subtracted.

use super::{FLIP_FLOP, enlarged, passed, slice};
use crate::mosaic::{beside, exposed, write};
use crate::panel::mean;
use crate::{Figure, Finding, paints};
use carpaint::color::luminance;
use carpaint::error::Result;
use carpaint::fit::{SliceMean, SmoothFit, residual};
use glam::DVec3;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-9",
    claim: "after subtraction of the homogeneous part only the flakes are left: fluctuation, and next to no mean",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let chain = paints::chain(FLIP_FLOP)?;
    let (btf, fit) = (&chain.btf, SmoothFit::from(&chain.paint));
    let y = |texel: &[f32; 3]| luminance(DVec3::from(texel.map(f64::from)));
    // Sums over slices of the luminance's mean before, and of mean and deviation after.
    let (mut before, mut left, mut deviation) = (0.0, 0.0, 0.0);
    for k in 0..btf.grid.len() {
        let values: Vec<f64> = residual(btf, &fit, SliceMean::Residual, k)?.iter().map(y).collect();
        let own = mean(&values);
        let squares: Vec<f64> = values.iter().map(|v| (v - own).powi(2)).collect();
        before += luminance(DVec3::from(btf.slices[k].expectation)) / passed(btf, k);
        left += own.abs();
        deviation += mean(&squares).sqrt();
    }

    let k = slice(btf);
    let expectation = btf.slices[k].expectation;
    let whole: Vec<[f32; 3]> = btf.slices[k]
        .fluctuation
        .iter()
        .map(|texel| std::array::from_fn(|c| texel[c] + expectation[c] as f32))
        .collect();
    let through = passed(btf, k) as f32;
    let alone: Vec<[f32; 3]> =
        residual(btf, &fit, SliceMean::Residual, k)?.iter().map(|t| t.map(|c| c * through)).collect();
    let whole = enlarged(&whole, btf.size, 3);
    let stops = whole.exposure(0.03);
    write(name, &exposed(beside(&[whole, enlarged(&alone, btf.size, 3)]), stops))?;
    Ok(Finding {
        // What is left of the mean is the fit's error, for which the report of a chain has this bar, too.
        holds: left < 0.08 * before && left < 0.1 * deviation,
        says: format!(
            "over {} slices the mean left is {:.1} % of the luminance before, and {:.2} of the standard deviation (before | after)",
            btf.grid.len(),
            100.0 * left / before,
            left / deviation
        ),
    })
}
