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
    ///
    /// None: the slice was left out, as no view of the scene that it was computed for reaches it. It cannot be drawn from.
    pub clusters: Vec<Cluster>,
    /// Half-width in u of the band about the upper end of each cluster in which its color goes over, linearly in RGB, into
    /// that of the next, as [`super::Ramp`] says (the narrowest of an arc counts for all of it); 0: no band, and the next
    /// cluster begins an arc of its own. A threshold
    /// that moves with the weights of a blend then fades texels instead of switching them. Empty: no bands, as in every
    /// paint that is not a blend. The mean of the draws is the same with and without.
    pub fades: Vec<f32>,
    /// What every color drawn from a box is multiplied with, a channel each, before the offset: 1 but in blends that keep
    /// the contrast. 0 or more.
    pub gain: [f32; 3],
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

    /// Most clusters that bands link: one a paint of a mix.
    pub const MAX_LINKED: usize = 8;
    /// Largest gain.
    pub const MAX_GAIN: f32 = 1e3;

    /// Clusters as they are drawn, without gain and bands.
    pub fn new(clusters: Vec<Cluster>, offset: [f32; 3]) -> Self {
        Self { clusters, fades: Vec::new(), gain: [1.0; 3], offset }
    }

    /// A slice that was left out.
    pub fn left_out() -> Self {
        Self::new(Vec::new(), [0.0; 3])
    }

    /// Whether the slice was left out.
    pub fn is_left_out(&self) -> bool {
        self.clusters.is_empty()
    }

    /// Mean of the boxes alone, linear Rec.709, 1/sr.
    pub fn box_mean(&self) -> DVec3 {
        mean_of_boxes(&self.clusters)
    }

    /// Mean of everything drawn from these statistics, gain and offset included, linear Rec.709, 1/sr.
    pub fn mean_rgb(&self) -> DVec3 {
        self.box_mean() * DVec3::from_array(self.gain.map(f64::from))
            + DVec3::from_array(self.offset.map(f64::from))
    }

    /// # Errors
    /// Too many clusters, a probability outside (0, 1], a sum off 1 by more than 1e-9, a corner, gain or
    /// offset that is not finite or too large for the arithmetic of a renderer, bands that do not fit the clusters.
    pub fn validate(&self) -> Result<()> {
        let n = self.clusters.len();
        if n > Self::MAX_CLUSTERS {
            return Err(Error::invalid("clusters", "number", n, "0 to 65535"));
        }
        if !self.fades.is_empty() && self.fades.len() != n {
            return Err(Error::invalid("fades", "number", self.fades.len(), format!("0 or {n}")));
        }
        let linked = self.fades.split(|f| *f == 0.0).map(<[f32]>::len).max().unwrap_or(0);
        if linked >= Self::MAX_LINKED {
            let legal = format!("0 to {}", Self::MAX_LINKED - 1);
            return Err(Error::invalid("fades", "bands in a row", linked, legal));
        }
        if let Some(bad) = self.fades.iter().find(|f| !(0.0..=0.5).contains(*f)) {
            return Err(Error::invalid("fades", "half-width", bad, "0 to 0.5"));
        }
        if !self.gain.iter().all(|g| (0.0..=Self::MAX_GAIN).contains(g)) {
            let legal = format!("0 to {}", Self::MAX_GAIN);
            return Err(Error::invalid("", "gain", format!("{:?}", self.gain), legal));
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
        if self.is_left_out() {
            return Ok(());
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
            let statistics = SliceStatistics::new(clusters, offset);
            statistics.validate().unwrap();
            // A blend must be able to bring any mean of boxes to any other with a legal offset.
            assert!(statistics.box_mean().abs().max_element() < 0.5 * f64::from(SliceStatistics::MAX_OFFSET));
            let lab = [l, a, b];
            assert!(crate::color::rgb_from_lab_f32(lab).iter().all(|c| c.is_finite()));
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let good = || {
            let clusters = vec![Cluster { probability: 1.0, min: [0.0; 3], max: [1.0; 3] }];
            SliceStatistics::new(clusters, [0.0; 3])
        };
        good().validate().unwrap();
        SliceStatistics::left_out().validate().unwrap();
        for bad in [f32::NAN, -0.1, 1.1e3] {
            let statistics = SliceStatistics { gain: [1.0, bad, 1.0], ..good() };
            assert!(statistics.validate().unwrap_err().to_string().contains("gain"));
        }
        for bad in [vec![f32::NAN], vec![-0.1], vec![0.6], vec![0.0; 2]] {
            let statistics = SliceStatistics { fades: bad, ..good() };
            assert!(statistics.validate().unwrap_err().to_string().starts_with("fades: "));
        }
        let cluster = Cluster { probability: 1.0 / 16.0, min: [0.0; 3], max: [1.0; 3] };
        let linked = |bands: usize| SliceStatistics {
            fades: (0..16).map(|k| if k < bands { 0.01 } else { 0.0 }).collect(),
            ..SliceStatistics::new(vec![cluster; 16], [0.0; 3])
        };
        linked(7).validate().unwrap();
        assert!(linked(8).validate().unwrap_err().to_string().contains("bands in a row: found 8"));
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
