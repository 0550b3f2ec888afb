//! How the lobes of several paints become those of a blend.

use super::weights::Weights;
use crate::brdf::Lobe;
use crate::error::Error;
use std::fmt;
use std::str::FromStr;

/// Which lobes belong together, and what is linear in the weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LobePath {
    /// `index`: lobes of equal number; coefficient s and normal reflectance s F0 are linear, so that lobes of one width are blended
    /// exactly. (Golla & Klein 2018, section 4.2, take F0 itself; but a fit knows the product far better than either factor, and
    /// the product of two blends is not the blend of two products.) Roughness is geometric, as linear it would become negative. F0
    /// is cut at 0 and 1, a coefficient at 0.
    #[default]
    Index,
    /// `matched`: lobes of like roughness; linear in `ln s`, `ln alpha` and `ln (F0 / (1 - F0))`, which are legal at any
    /// weights. A lobe without a partner is linear in s.
    Matched,
}

impl LobePath {
    /// Every choice.
    pub const ALL: [Self; 2] = [Self::Index, Self::Matched];

    fn name(self) -> &'static str {
        match self {
            Self::Index => "index",
            Self::Matched => "matched",
        }
    }
}

impl fmt::Display for LobePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for LobePath {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|path| path.name() == text);
        found.ok_or_else(|| Error::invalid("lobes", "name", text, Self::ALL.map(Self::name).join(", ")))
    }
}

/// Largest exponent of a transformed parameter, its exponential short of the largest legal coefficient.
const MOST: f64 = 13.8;
/// Roughness of a blend beyond its paints.
const ROUGHNESS: (f64, f64) = (1e-4, 100.0);

impl Weights {
    /// The lobes of the blend of paints with these lobes.
    pub(super) fn lobes(&self, paints: &[&[Lobe]], path: LobePath) -> Vec<Lobe> {
        let count = paints.iter().map(|lobes| lobes.len()).max().unwrap_or(0);
        let rows: Vec<Vec<Option<&Lobe>>> = match path {
            LobePath::Index => (0..count).map(|k| paints.iter().map(|p| p.get(k)).collect()).collect(),
            LobePath::Matched => matched(paints, count),
        };
        rows.iter().map(|row| self.lobe(row, path)).collect()
    }

    /// One lobe; a paint without it contributes nothing, at the roughness and F0 of the first that has it.
    pub(super) fn lobe(&self, lobes: &[Option<&Lobe>], path: LobePath) -> Lobe {
        let absent =
            lobes.iter().flatten().next().map_or(Lobe { coefficient: 0.0, roughness: 1.0, f0: 0.0 }, |l| {
                Lobe { coefficient: 0.0, ..**l }
            });
        let all = lobes.iter().map(|l| l.copied().unwrap_or(absent));
        let coefficients = all.clone().map(|l| l.coefficient);
        let f0 = all.clone().map(|l| l.f0);
        let bounded = |x: f64| x.clamp(-MOST, MOST).exp();
        let log_legal = path == LobePath::Matched && all.clone().all(|l| l.coefficient > 0.0);
        let coefficient = if log_legal {
            self.along(coefficients, f64::ln, bounded)
        } else {
            self.linear(coefficients).max(0.0)
        };
        let f0 = match path {
            // Counted from the heaviest: equal ones, and one with all the weight, stay what they are, to the bit.
            LobePath::Index if coefficient > 0.0 => {
                let heaviest = all.clone().zip(&self.0).max_by(|(_, v), (_, w)| v.abs().total_cmp(&w.abs()));
                let base = heaviest.map_or(0.0, |(lobe, _)| lobe.f0);
                let apart = all.clone().map(|l| l.coefficient * (l.f0 - base));
                (base + self.linear(apart) / coefficient).clamp(0.0, 1.0)
            }
            LobePath::Index => self.linear(f0).clamp(0.0, 1.0),
            // An F0 of 0 or 1 is as far out as its neighbour in f32.
            LobePath::Matched => {
                let inner = |x: f64| x.clamp(1e-7, 1.0 - 1e-7);
                self.along(f0, |x| (inner(x) / (1.0 - inner(x))).ln(), |x| 1.0 / (1.0 + (-x).exp()))
            }
        };
        // Paints may be smoother or rougher than what extrapolation is kept to: each stays what it is.
        let roughnesses = all.map(|l| l.roughness);
        let least = roughnesses.clone().fold(ROUGHNESS.0, f64::min);
        let most = roughnesses.clone().fold(ROUGHNESS.1, f64::max);
        let roughness = self.along(roughnesses, f64::ln, bounded).clamp(least, most);
        Lobe { coefficient, roughness, f0 }
    }
}

/// For every lobe of the paint that has most, the lobe of each paint that is matched to it: the assignment of least sum of
/// `|ln (alpha / alpha')|`. Lobes on a line are assigned in their order; which ones go without is found by trying.
fn matched<'a>(paints: &[&'a [Lobe]], count: usize) -> Vec<Vec<Option<&'a Lobe>>> {
    let Some(most) = paints.iter().find(|lobes| lobes.len() == count) else { return Vec::new() };
    let order = |lobes: &[Lobe]| {
        let mut order: Vec<usize> = (0..lobes.len()).collect();
        order.sort_by(|a, b| lobes[*b].roughness.total_cmp(&lobes[*a].roughness));
        order
    };
    let slots = order(most);
    let mut rows = vec![vec![None; paints.len()]; count];
    for (k, lobes) in paints.iter().enumerate() {
        let own = order(lobes);
        let cost = |i: usize, j: usize| (lobes[own[i]].roughness / most[slots[j]].roughness).ln().abs();
        for (i, j) in assigned(own.len(), count, cost).into_iter().enumerate() {
            rows[slots[j]][k] = Some(&lobes[own[i]]);
        }
    }
    rows
}

/// Ascending places among `slots` for `n <= slots` things, of least total cost.
fn assigned(n: usize, slots: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    let choices = |from: usize, left: usize| from..=slots - left;
    // best[i]: least cost of things i.. from each slot on; at most four lobes, so plain recursion does.
    fn best(
        i: usize,
        from: usize,
        n: usize,
        choices: &impl Fn(usize, usize) -> std::ops::RangeInclusive<usize>,
        cost: &impl Fn(usize, usize) -> f64,
    ) -> (f64, Vec<usize>) {
        if i == n {
            return (0.0, Vec::new());
        }
        let tries = choices(from, n - i).map(|j| {
            let (rest, mut places) = best(i + 1, j + 1, n, choices, cost);
            places.push(j);
            (cost(i, j) + rest, places)
        });
        tries.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, Vec::new()))
    }
    let (_, mut places) = best(0, 0, n, &choices, &cost);
    places.reverse();
    places
}
