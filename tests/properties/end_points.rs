//! That a blend with all weight on one paint is that paint.

use crate::paints::merged;
use carpaint::Paint;
use carpaint::brdf::Lobe;
use carpaint::cluster::SliceStatistics;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

fn slices(paint: &Paint) -> impl Iterator<Item = &SliceStatistics> {
    paint.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices)
}

/// Those that reflect anything: of a paint with fewer than another the blend holds empty ones.
fn lobes(paint: &Paint) -> Vec<Lobe> {
    paint.lobes.iter().copied().filter(|lobe| lobe.coefficient > 0.0).collect()
}

/// The smooth part to the bit, and the same distribution in every slice.
pub fn same(blend: &Paint, end: &Paint) -> Result<(), TestCaseError> {
    prop_assert_eq!(&blend.coat, &end.coat);
    prop_assert_eq!(blend.diffuse.to_bits(), end.diffuse.to_bits());
    prop_assert_eq!(lobes(blend), lobes(end));
    prop_assert_eq!(&blend.colors, &end.colors);
    prop_assert_eq!(slices(blend).count(), slices(end).count());
    for (k, (x, y)) in slices(blend).zip(slices(end)).enumerate() {
        let (a, b) = (merged(&x.clusters), merged(&y.clusters));
        prop_assert_eq!(a.len(), b.len(), "{}", k);
        for (a, b) in a.iter().zip(&b) {
            prop_assert_eq!((a.min, a.max), (b.min, b.max), "corners to the bit");
            // Sums of up to n + m - 1 arcs of a plan whose row sums are exact to rounding.
            prop_assert!((a.probability - b.probability).abs() <= 1e-14);
        }
        prop_assert_eq!(x.gain, y.gain);
        prop_assert!(x.fades.is_empty());
        // A difference of means that are equal up to rounding, stored in f32.
        let (mean, size) = (y.mean_rgb(), y.box_mean().abs().max_element());
        let error = (x.mean_rgb() - mean).abs().max_element();
        prop_assert!(error <= 1e-6 * size.max(mean.abs().max_element()), "{k}: {error} of {size}");
    }
    Ok(())
}
