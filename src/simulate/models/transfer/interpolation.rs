//! BRDFs between the nodes: barycentric interpolation in the cosine outside, and the cosine series in azimuth.
//!
//! Mode m vanishes like `sin^m` of either angle where light is along the normal; odd modes are divided by one sine of each
//! angle, what is left is smooth in the cosine. A scattering medium itself, without a boundary that refracts, shines like
//! `1/(mu + mu')` at grazing angles (Chandrasekhar 1960); that is taken out with the cosines mu inside.

use crate::brdf::fresnel::refracted_cosine;

/// A reciprocal BRDF for several wavelengths, by azimuth modes over nodes in the cosine.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeTable {
    cos: Vec<f64>,
    index: f64,
    /// Barycentric weights.
    weights: Vec<f64>,
    modes: usize,
    bands: usize,
    /// For each pair (i, j <= i): mode, band; odd modes over both sines, modes above 0 doubled, all times `mu + mu'`
    /// over 2 pi.
    pairs: Vec<Vec<f64>>,
}

impl ModeTable {
    /// A table over nodes of these cosines above a medium of index `index`; `value(mode, i, j, band)` is mode m at a pair of nodes, `j <= i`.
    pub fn new(
        cos: Vec<f64>,
        index: f64,
        modes: usize,
        bands: usize,
        value: impl Fn(usize, usize, usize, usize) -> f64,
    ) -> Self {
        let sin = |i: usize| ((1.0 - cos[i]) * (1.0 + cos[i])).sqrt();
        let mu = |i: usize| refracted_cosine(cos[i], index);
        let mut pairs = Vec::new();
        for i in 0..cos.len() {
            for j in 0..=i {
                let mut series = Vec::with_capacity(modes * bands);
                for mode in 0..modes {
                    let scale = (mu(i) + mu(j)) * if mode == 0 { 0.5 } else { 1.0 } / std::f64::consts::PI;
                    let scale = if mode % 2 == 1 { scale / (sin(i) * sin(j)) } else { scale };
                    series.extend((0..bands).map(|band| scale * value(mode, i, j, band)));
                }
                pairs.push(series);
            }
        }
        let weights = barycentric_weights(&cos);
        Self { cos, index, weights, modes, bands, pairs }
    }

    /// The table of what `f` makes of the bands of each value, `N` numbers; `f` is linear.
    pub fn map<const N: usize>(&self, f: impl Fn(&[f64]) -> [f64; N]) -> Self {
        let each = |pair: &Vec<f64>| pair.chunks_exact(self.bands).flat_map(&f).collect();
        Self { pairs: self.pairs.iter().map(each).collect(), bands: N, ..self.clone() }
    }

    /// The modes at two cosines: what [`ModeTable::sum`] takes, for every azimuth.
    pub fn series(&self, cosines: [f64; 2]) -> Vec<f64> {
        let [a, b] = cosines.map(|c| cardinal(&self.cos, &self.weights, c));
        let mu = cosines.map(|c| refracted_cosine(c, self.index));
        let scale = 1.0 / (mu[0] + mu[1]);
        let mut series = vec![0.0; self.modes * self.bands];
        let mut pairs = self.pairs.iter();
        for i in 0..self.cos.len() {
            for (j, pair) in (0..=i).zip(&mut pairs) {
                let weight = scale * if i == j { a[i] * b[i] } else { a[i] * b[j] + a[j] * b[i] };
                series.iter_mut().zip(pair).for_each(|(s, v)| *s += weight * v);
            }
        }
        let sines = cosines.map(|c| ((1.0 - c) * (1.0 + c)).max(0.0).sqrt());
        for row in series.chunks_exact_mut(self.bands).skip(1).step_by(2) {
            row.iter_mut().for_each(|s| *s *= sines[0] * sines[1]);
        }
        series
    }

    /// The BRDF, one value a band, from its modes and the azimuth difference of travel directions.
    pub fn sum(&self, series: &[f64], cos_phi: f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.bands];
        let (mut before, mut now) = (cos_phi, 1.0);
        for row in series.chunks_exact(self.bands) {
            sum.iter_mut().zip(row).for_each(|(t, s)| *t += now * s);
            (before, now) = (now, 2.0 * cos_phi * now - before);
        }
        sum
    }
}

/// `1 / prod (x_k - x_j)`, scaled to stay within range.
pub fn barycentric_weights(nodes: &[f64]) -> Vec<f64> {
    // A span of 4 has capacity 1: the products neither over- nor underflow.
    nodes
        .iter()
        .enumerate()
        .map(|(k, x)| {
            let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
            others.map(|(_, y)| 1.0 / (4.0 * (x - y))).product()
        })
        .collect()
}

/// What each node's value counts at `x` (Berrut & Trefethen 2004).
pub fn cardinal(nodes: &[f64], weights: &[f64], x: f64) -> Vec<f64> {
    if let Some(at) = nodes.iter().position(|node| *node == x) {
        return (0..nodes.len()).map(|k| f64::from(u8::from(k == at))).collect();
    }
    let shares: Vec<f64> = nodes.iter().zip(weights).map(|(node, w)| w / (x - node)).collect();
    let total: f64 = shares.iter().sum();
    shares.iter().map(|s| s / total).collect()
}
