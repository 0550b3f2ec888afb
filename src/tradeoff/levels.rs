//! Levels of detail: how many of them a paint needs.

use super::measure::{Curve, Effort, Head, Trial, curve_of_bytes};
use super::{CLUSTER_BYTES, Subject};
use crate::error::Result;
use crate::paint::Flakes;
use crate::report::scales;

const KEPT: [usize; 4] = [1, 2, 3, 5];
/// Footprints: root of the area in texels, long side over short.
const FOOTPRINTS: [(f64, f64); 6] = [(1.0, 1.0), (2.0, 1.0), (4.0, 1.0), (8.0, 1.0), (8.0, 4.0), (24.0, 1.0)];

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let Some(flakes) = &subject.chain.paint.flakes else { return Ok(Vec::new()) };
    let all = flakes.levels.len();
    let kept = |levels: usize| {
        let levels = flakes.levels[..levels].to_vec();
        Ok(Flakes { levels, ..flakes.clone() })
    };
    let counts = KEPT.into_iter().filter(|levels| *levels < all).chain([all]);
    let trials: Vec<Trial<Flakes>> =
        counts.map(|levels| Trial::new(levels, levels == all, move || kept(levels))).collect();
    let head = Head {
        stage: "Levels of detail",
        knob: "levels that are kept, finest first",
        error: "standard deviation of the luminance under footprints of 1 to 24 texels, relative, against the box-filtered source, root mean \
                square",
        why: "Half of the slices' clusters are coarse levels'. Without them far flakes glitter like near ones: contrast has to fall with \
              the footprint, as the source's does, at the price of one look a pixel and not one a texel.",
    };
    let options = subject.options.synthesis()?;
    let judge = |flakes: &Flakes| {
        let found = scales(&subject.chain.model, &options, flakes, &FOOTPRINTS)?;
        let squares = found.iter().map(|scale| (scale.deviation_ratio - 1.0).powi(2));
        let clusters: usize =
            flakes.levels.iter().flat_map(|level| &level.slices).map(|slice| slice.clusters.len()).sum();
        Ok(((squares.sum::<f64>() / found.len() as f64).sqrt(), Some((CLUSTER_BYTES * clusters) as f64)))
    };
    Ok(vec![curve_of_bytes(head, &trials, *effort, judge)?])
}
