//! Speed against error: every stage of the chain, its knob, what each setting costs and how far it is from the best truth at hand.
//!
//! A curve runs over the settings of one knob. All of its settings are timed in turns, so that a machine that is busy for a while is so for
//! all, and the cost of a setting is the middle one of its ratios to the default within a turn. Errors come from one run each: all that is
//! random has a seed. What lies on the Pareto front is both cheaper and nearer to the truth than what does not.

mod blending;
mod budget;
mod clustering;
mod fitting;
#[cfg(feature = "gpu")]
mod frames;
mod inks;
mod levels;
mod measure;
mod model;
mod peers;
mod rendering;
mod rivals;
mod slab;
mod synthesis;
mod transport;

pub use budget::{Budget, Choice, Tried, pick_clusters, pick_model, pick_samples, pick_starts};
pub use measure::{Axis, Cost, Curve, Effort, Point};
pub use peers::Peer;

use crate::brdf::Measured;

use crate::error::{Error, Result};
use crate::report::{Chain, ChainOptions, PhysicalChange, run_chain};
use crate::simulate::Composition;

/// The paints that curves are measured on: one, and the same with 0.4 of its flakes.
pub struct Subject {
    /// The chain of the paint.
    chain: Chain,
    /// That of the other, with which it is coupled.
    other: Chain,
    /// Sizes of both.
    options: ChainOptions,
    /// What lobes are fitted to, too.
    measured: Option<Measured>,
}

/// Bytes of a cluster: two corners and a cumulative probability.
const CLUSTER_BYTES: usize = 28;

/// What makes the other paint.
const CHANGE: PhysicalChange = PhysicalChange::FlakeDensity;

impl Subject {
    /// Simulates, fits and reduces a composition; fits are measured on `measured`, too. `begin` as [`run_chain`] takes it.
    ///
    /// # Errors
    /// Those of the chain; a composition without flakes.
    pub fn new<T: Fn() + Sync>(
        composition: &Composition,
        measured: Option<Measured>,
        effort: &Effort,
        begin: impl Fn(&str, usize) -> T,
    ) -> Result<Self> {
        let bins = if effort.quick { 8 } else { 12 };
        let options = ChainOptions { bins, size: 128, texel_mm: None, seed: effort.seed };
        if composition.films.iter().all(|film| film.flakes.is_empty()) {
            return Err(Error::invalid("report", "flakes of the composition", "none", "some"));
        }
        let chain = run_chain("paint", composition, &options, &begin)?;
        let other = CHANGE.at(composition, 1.0)?;
        let options = ChainOptions { texel_mm: Some(chain.btf.texel_mm), ..options };
        let seed = effort.seed.wrapping_add(1);
        let other = run_chain("partner", &other, &ChainOptions { seed, ..options }, &begin)?;
        Ok(Self { chain, other, options, measured })
    }
}

/// A stage's name, and how its curves are measured.
type Stage = (&'static str, fn(&Subject, &Effort) -> Result<Vec<Curve>>);

/// All stages, in the order of the chain.
const STAGES: &[Stage] = &[
    ("simulation", model::curves),
    ("slab", slab::curves),
    ("synthesis", synthesis::curves),
    ("fit", fitting::curves),
    ("statistics", clustering::curves),
    ("levels", levels::curves),
    ("rivals", rivals::curves),
    ("transport", transport::curves),
    ("blend", blending::curves),
    ("inks", inks::curves),
    ("rendering", rendering::curves),
    #[cfg(feature = "gpu")]
    ("adapters", frames::curves),
];

/// Names of the stages, in the order of the chain.
pub fn stage_names() -> [&'static str; STAGES.len()] {
    std::array::from_fn(|k| STAGES[k].0)
}

/// The curves of the stages of these names, in the order of the chain. `tick` is called once a stage.
///
/// # Errors
/// Those of the stages.
pub fn curves(
    subject: &Subject,
    effort: &Effort,
    names: &[impl AsRef<str>],
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Curve>> {
    let mut all = Vec::new();
    for (_, stage) in STAGES.iter().filter(|(name, _)| names.iter().any(|n| n.as_ref() == *name)) {
        all.extend(stage(subject, effort)?);
        tick();
    }
    Ok(all)
}
