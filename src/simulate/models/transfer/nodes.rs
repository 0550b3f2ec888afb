//! Nodes in the transverse wavenumber, shared by all films.
//!
//! Panels lie between the sorted indices of air and films. In the panel below index H the variable is
//! `c = sqrt(H^2 - kappa^2)`: at its end kappa = H light in the medium of index H grazes, and the Fresnel reflectance from
//! denser media has its square-root singularity, which is linear in c. Gauss-Legendre in c, `kappa dkappa = c dc`.

use crate::math::quadrature::gauss_legendre;

/// Weight, in the cosine, of a node that is only looked at: far below that of any quadrature node, and far enough above
/// rounding that values over it keep eight digits of the largest.
const PROBE_WEIGHT: f64 = 1e-8;

/// One transverse wavenumber.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    /// Index H at the upper end of its panel.
    top: f64,
    /// `c = sqrt(H^2 - kappa^2)`.
    c: f64,
    /// Weight of `kappa dkappa`.
    weight: f64,
}

/// A direction in a medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    /// Cosine of the polar angle, above 0.
    pub cos: f64,
    /// Sine of the polar angle.
    pub sin: f64,
}

/// All nodes, panel after panel, beginning with the one that reaches the air.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes {
    nodes: Vec<Node>,
    per_panel: usize,
}

impl Nodes {
    /// Nodes for media of these indices (each >= 1) under air, `per_panel` in each panel, and beside them directions to look
    /// at, `probes`, given by their cosines outside, above 0.
    pub fn new(indices: &[f64], per_panel: usize, probes: &[f64]) -> Self {
        let mut tops: Vec<f64> = indices.iter().copied().filter(|index| *index > 1.0).chain([1.0]).collect();
        tops.sort_by(f64::total_cmp);
        tops.dedup();
        let mut nodes = Vec::new();
        let mut below = 0.0;
        for top in tops {
            let end = ((top - below) * (top + below)).sqrt();
            let rule = gauss_legendre(per_panel, 0.0, end);
            nodes.extend(rule.iter().rev().map(|(c, w)| Node { top, c: *c, weight: c * w }));
            if top == 1.0 {
                nodes.extend(probes.iter().map(|c| Node { top, c: *c, weight: c * PROBE_WEIGHT }));
            }
            below = top;
        }
        Self { nodes, per_panel }
    }

    /// Quadrature nodes of a panel.
    pub fn per_panel(&self) -> usize {
        self.per_panel
    }

    /// How many nodes exist in a medium of this index: the first ones.
    pub fn count(&self, index: f64) -> usize {
        self.nodes.iter().take_while(|node| node.top <= index).count()
    }

    /// The directions of the nodes that exist in a medium of this index.
    pub fn directions(&self, index: f64) -> Vec<Direction> {
        let nodes = self.nodes.iter().take(self.count(index));
        // Both without the difference of numbers near each other.
        nodes
            .map(|n| Direction {
                cos: ((index - n.top) * (index + n.top) + n.c * n.c).sqrt() / index,
                sin: ((n.top - n.c) * (n.top + n.c)).max(0.0).sqrt() / index,
            })
            .collect()
    }

    /// `g`, the weights of `kappa dkappa`; those below kappa sum to `kappa^2 / 2`.
    pub fn weights(&self) -> Vec<f64> {
        self.nodes.iter().map(|node| node.weight).collect()
    }

    /// Whether a node carries weight, that is, is no probe.
    pub fn is_quadrature(&self, node: usize) -> bool {
        node < self.per_panel || node >= self.count(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_cover_each_hemisphere() {
        let nodes = Nodes::new(&[1.5, 1.8, 1.5], 7, &[0.5]);
        for index in [1.0, 1.5, 1.8] {
            let n = nodes.count(index);
            let total: f64 = (0..n).filter(|k| nodes.is_quadrature(*k)).map(|k| nodes.weights()[k]).sum();
            // Polynomials: rounding.
            assert!((total / (0.5 * index * index) - 1.0).abs() < 1e-13, "{index}: {total}");
        }
        for d in nodes.directions(1.8) {
            assert!((d.cos.hypot(d.sin) - 1.0).abs() < 1e-14);
        }
    }
}
