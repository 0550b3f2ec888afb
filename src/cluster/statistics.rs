//! What is kept of a flake slice.

use super::mean_of_boxes;
use crate::error::{Error, Result};
use glam::DVec3;

/// A cuboid in signed Lab of `pi f` (L* = 100 is the perfect diffuser), in which colors are uniformly distributed, and
/// its probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// Probability of a texel to fall in this cluster, above 0, at most 1.
    pub probability: f64,
    /// Corner with the smallest L, a, b. After extrapolation a component may exceed that of `max`.
    pub min: [f32; 3],
    /// Corner with the largest L, a, b.
    pub max: [f32; 3],
}

/// The clusters of one slice at one level of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct SliceStatistics {
    /// Clusters, probabilities summing to 1, in the order in which one uniform number u runs through them: ascending
    /// lightness of the center for a paint, the order fixed at equal weights for a blend.
    pub clusters: Vec<Cluster>,
    /// Linear Rec.709, 1/sr: what is added to every draw so that the mean of the slice is the source's.
    pub offset: [f32; 3],
}

/// How a cluster's cuboid is laid around the colors of its members.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxRule {
    /// Centerd on the mean, half-width sqrt(3) standard deviations an axis: mean and variance of the members.
    #[default]
    MomentMatched,
    /// The bounding box of the members: the choice of Golla & Klein.
    Bounding,
}

impl Cluster {
    /// Center of the cuboid, signed Lab.
    pub fn center(&self) -> DVec3 {
        0.5 * (DVec3::from(self.min.map(f64::from)) + DVec3::from(self.max.map(f64::from)))
    }
}

impl SliceStatistics {
    /// Most clusters a slice may have.
    pub const MAX_CLUSTERS: usize = 65_535;
    /// Largest absolute value of a corner, Lab units: a thousand times (the largest weight of a blend) the brightest Lab
    /// of a slice, with room to spare, and its color is far from the end of f32.
    pub const MAX_CORNER: f32 = 1e9;
    /// Largest absolute value of an offset or a mean, 1/sr: boxes within [`Self::MAX_CORNER`] have means of up to 1e22.
    pub const MAX_OFFSET: f32 = 1e24;

    /// Mean of the boxes alone, linear Rec.709, 1/sr.
    pub fn box_mean(&self) -> DVec3 {
        mean_of_boxes(&self.clusters)
    }

    /// Mean of everything drawn from these statistics, offset included, linear Rec.709, 1/sr.
    pub fn mean_rgb(&self) -> DVec3 {
        self.box_mean() + DVec3::from_array(self.offset.map(f64::from))
    }

    /// # Errors
    /// No or too many clusters, a probability outside (0, 1], a sum off 1 by more than 1e-9, a corner or an
    /// offset that is not finite or too large for the arithmetic of a renderer.
    pub fn validate(&self) -> Result<()> {
        let n = self.clusters.len();
        if !(1..=Self::MAX_CLUSTERS).contains(&n) {
            return Err(Error::invalid("clusters", "number", n, "1 to 65535"));
        }
        for (k, cluster) in self.clusters.iter().enumerate() {
            let place = || format!("cluster {k}");
            if !(cluster.probability > 0.0 && cluster.probability <= 1.0 + 1e-9) {
                return Err(Error::invalid(place(), "probability", cluster.probability, "above 0, up to 1"));
            }
            Self::check_corners(&[cluster.min, cluster.max]).map_err(|e| e.within(place()))?;
        }
        if !self.offset.iter().all(|c| c.abs() <= Self::MAX_OFFSET) {
            let legal = format!("numbers within +-{:e}", Self::MAX_OFFSET);
            return Err(Error::invalid("", "offset", format!("{:?}", self.offset), legal));
        }
        let sum: f64 = self.clusters.iter().map(|c| c.probability).sum();
        // Far above the rounding of 65,535 terms, far below the smallest texel share that matters.
        if (sum - 1.0).abs() > 1e-9 {
            return Err(Error::invalid("clusters", "sum of probabilities", sum, "1 within 1e-9"));
        }
        Ok(())
    }

    /// Whether a renderer can compute with a box: no component that is no number or beyond [`Self::MAX_CORNER`].
    pub(crate) fn check_corners(corners: &[[f32; 3]; 2]) -> Result<()> {
        if corners.as_flattened().iter().all(|c| c.abs() <= Self::MAX_CORNER) {
            return Ok(());
        }
        let legal = format!("numbers within +-{:e}", Self::MAX_CORNER);
        Err(Error::invalid("", "corners", format!("{:?} {:?}", corners[0], corners[1]), legal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_legal_statistics_have_a_finite_mean() {
        let most = SliceStatistics::MAX_CORNER;
        for [l, a, b] in [[most; 3], [-most, most, most], [most, most, -most], [0.0, -most, most]] {
            let clusters = vec![Cluster { probability: 1.0, min: [l, a, b], max: [-l, a, -b] }];
            let offset = [SliceStatistics::MAX_OFFSET, 0.0, -SliceStatistics::MAX_OFFSET];
            let statistics = SliceStatistics { clusters, offset };
            statistics.validate().unwrap();
            // A blend must be able to bring any mean of boxes to any other with a legal offset.
            assert!(statistics.box_mean().abs().max_element() < 0.5 * f64::from(SliceStatistics::MAX_OFFSET));
            let lab = [l, a, b];
            assert!(crate::color::rgb_from_lab_f32(lab).iter().all(|c| c.is_finite()));
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let good = || SliceStatistics {
            clusters: vec![Cluster { probability: 1.0, min: [0.0; 3], max: [1.0; 3] }],
            offset: [0.0; 3],
        };
        good().validate().unwrap();
        for bad in [f32::NAN, f32::INFINITY, 1.1e9, -f32::MAX] {
            let mut statistics = good();
            statistics.clusters[0].max[1] = bad;
            assert!(statistics.validate().unwrap_err().to_string().starts_with("cluster 0: corners: found"));
        }
        for bad in [f32::NAN, f32::NEG_INFINITY, 1e25] {
            let statistics = SliceStatistics { offset: [0.0, bad, 0.0], ..good() };
            assert!(statistics.validate().unwrap_err().to_string().contains("offset"));
        }
        for bad in [f64::NAN, 0.0, -1.0, 0.5] {
            let mut statistics = good();
            statistics.clusters[0].probability = bad;
            assert!(statistics.validate().is_err(), "{bad}");
        }
    }
}
