//! Colors along u, ready for shading: one look-up, no box, no Lab.

use super::{Sampler, color};
use crate::cluster::{SliceStatistics, mean_of_boxes};
use crate::error::{Error, Result};
use crate::math::hash::{pcg4d, unit};
use glam::DVec3;
use half::f16;

/// Q(u) of one slice in equal steps: linear Rec.709, 1/sr, half floats, gain and offset included. One row of a texture u x
/// slice x level; six bytes a step.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantileRow {
    colors: Vec<[f16; 3]>,
}

impl QuantileRow {
    /// Most steps.
    pub const MAX_STEPS: usize = 65_535;

    /// The expectation of the color over each of `steps` equal parts of (0, 1) and over the boxes: the mean is kept, the spread
    /// inside of boxes is lost, and so is the spread of all clusters that share a step. Bands between clusters are not drawn.
    ///
    /// # Errors
    /// Steps outside 1-65,535; a slice that was left out.
    pub fn expected(statistics: &SliceStatistics, steps: usize) -> Result<Self> {
        check(statistics, steps)?;
        let mut sums = vec![DVec3::ZERO; steps];
        let total: f64 = statistics.clusters.iter().map(|c| c.probability).sum();
        let mut start = 0.0;
        for cluster in &statistics.clusters {
            let end = start + cluster.probability / total * steps as f64;
            let mean = mean_of_boxes(std::slice::from_ref(cluster)) / cluster.probability;
            for (step, sum) in sums.iter_mut().enumerate().take(end.ceil() as usize).skip(start as usize) {
                *sum += (end.min(step as f64 + 1.0) - start.max(step as f64)).max(0.0) * mean;
            }
            start = end;
        }
        let gain = DVec3::from_array(statistics.gain.map(f64::from));
        let offset = DVec3::from_array(statistics.offset.map(f64::from));
        Ok(Self { colors: sums.into_iter().map(|sum| narrow(sum * gain + offset)).collect() })
    }

    /// One draw for the middle of each of `steps` equal parts of (0, 1), from the box found there; the draws are then shifted to
    /// the mean of the slice. The spread is kept, as well as so many draws can.
    ///
    /// # Errors
    /// Steps outside 1-65,535; a slice that was left out.
    pub fn realized(statistics: &SliceStatistics, steps: usize, seed: u32) -> Result<Self> {
        check(statistics, steps)?;
        let sampler = Sampler::exact(statistics)?;
        let draws: Vec<DVec3> = (0..steps)
            .map(|step| {
                let [_, r0, r1, r2] = pcg4d([step as u32, 0, 0, seed]).map(unit);
                let u = ((step as f64 + 0.5) / steps as f64) as f32;
                DVec3::from_array(color(statistics, &sampler, u, [r0, r1, r2]).map(f64::from))
            })
            .collect();
        let shift = statistics.mean_rgb() - draws.iter().sum::<DVec3>() / steps as f64;
        Ok(Self { colors: draws.into_iter().map(|draw| narrow(draw + shift)).collect() })
    }

    /// The color at u; u in (0, 1), values outside count as the nearest inside.
    #[inline]
    pub fn lookup(&self, u: f32) -> [f32; 3] {
        let step = (u * self.colors.len() as f32) as usize;
        self.colors[step.min(self.colors.len() - 1)].map(f32::from)
    }

    /// The color of each step.
    pub fn colors(&self) -> &[[f16; 3]] {
        &self.colors
    }
}

fn check(statistics: &SliceStatistics, steps: usize) -> Result<()> {
    if !(1..=QuantileRow::MAX_STEPS).contains(&steps) {
        return Err(Error::invalid("quantile row", "steps", steps, "1 to 65535"));
    }
    if statistics.is_left_out() {
        return Err(Error::invalid("quantile row", "clusters", 0, "1 or more"));
    }
    Ok(())
}

/// To half floats; what is too large becomes the largest.
fn narrow(color: DVec3) -> [f16; 3] {
    let most = f64::from(f16::MAX);
    color.to_array().map(|c| f16::from_f64(c.clamp(-most, most)))
}
