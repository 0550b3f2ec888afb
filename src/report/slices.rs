//! Which slices of a paint are looked at, and a grid to simulate no others.

use crate::btf::AngleGrid;
use crate::color::luminance;
use crate::error::Result;
use crate::paint::Flakes;
use crate::simulate::SynthesisOptions;

/// Slices looked at among those that hold 80 % of the energy, and as many among the rest.
const SLICES: usize = 12;

/// Slices with the variance of their luminance, strongest first, and whether those before hold less than 80 % of all.
pub(super) fn by_energy(flakes: &Flakes) -> Vec<(usize, bool)> {
    let energy = |slice: &crate::cluster::SliceStatistics| {
        let y = |c: &crate::cluster::Cluster| luminance(crate::color::rgb_from_lab(c.center()));
        let sum = |power: i32| slice.clusters.iter().map(|c| c.probability * y(c).powi(power)).sum::<f64>();
        sum(2) - sum(1) * sum(1)
    };
    let mut order: Vec<(f64, usize)> =
        flakes.levels[0].slices.iter().enumerate().map(|(k, s)| (energy(s), k)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let total: f64 = order.iter().map(|o| o.0).sum();
    let mut before = 0.0;
    let held = order.into_iter().filter(|o| o.0 > 1e-6 * total).map(|(energy, slice)| {
        let strong = before < 0.8 * total;
        before += energy;
        (slice, strong)
    });
    held.collect()
}

/// Twelve of either kind, evenly thinned.
pub(super) fn chosen(flakes: &Flakes) -> Vec<(usize, bool)> {
    let (strong, weak): (Vec<_>, Vec<_>) = by_energy(flakes).into_iter().partition(|s| s.1);
    let thin = |list: Vec<(usize, bool)>| {
        let stride = list.len().div_ceil(SLICES).max(1);
        list.into_iter().step_by(stride)
    };
    thin(strong).chain(thin(weak)).collect()
}

/// The options with the smallest grid of so many bins a quarter turn that holds these cells, theta_h before theta_i, in bins.
///
/// # Errors
/// Cells beyond the horizon.
pub(super) fn with_cells(
    options: &SynthesisOptions,
    bins: usize,
    cells: impl IntoIterator<Item = (usize, usize)>,
) -> Result<SynthesisOptions> {
    let mut rows = vec![1];
    for (theta_h, theta_i) in cells {
        rows.resize(rows.len().max(theta_i + 1), 1);
        rows[theta_i] = rows[theta_i].max(theta_h + 1);
    }
    Ok(SynthesisOptions { grid: AngleGrid::new(bins, rows)?, ..options.clone() })
}
