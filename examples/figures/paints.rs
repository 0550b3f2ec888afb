//! The presets, simulated and fitted once a run.

use carpaint::error::Result;
use carpaint::mix::{CoupleOptions, Mix, couple};
use carpaint::paint::Paint;
use carpaint::report::{Chain, ChainOptions, run_chain};
use carpaint::simulate::Composition;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

const SIZES: ChainOptions = ChainOptions { bins: 24, size: 128, texel_mm: Some(0.012), seed: 1 };

/// The composition of a preset.
pub fn composition(preset: &str) -> Result<Composition> {
    Composition::read(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{preset}.toml")),
    )
}

/// The paint of a preset.
pub fn simulated(preset: &'static str) -> Result<Arc<Paint>> {
    Ok(Arc::new(chain(preset)?.paint.clone()))
}

/// The paint of a preset and all it was made from; each is simulated once.
pub fn chain(preset: &'static str) -> Result<Arc<Chain>> {
    static DONE: Mutex<Option<HashMap<&str, Arc<Chain>>>> = Mutex::new(None);
    let mut done = DONE.lock().unwrap_or_else(PoisonError::into_inner);
    let done = done.get_or_insert_default();
    if let Some(chain) = done.get(preset) {
        return Ok(chain.clone());
    }
    let chain = Arc::new(run_chain(preset, &composition(preset)?, &SIZES, |_, _| || ())?);
    done.insert(preset, chain.clone());
    Ok(chain)
}

/// Paints coupled in this order.
pub fn mix<const N: usize>(presets: [&'static str; N]) -> Result<Mix> {
    let paints = presets.map(|preset| Ok((preset.to_owned(), simulated(preset)?)));
    let paints = paints.into_iter().collect::<Result<Vec<_>>>()?;
    let named: Vec<(String, &Paint)> =
        paints.iter().map(|(name, paint)| (name.clone(), paint.as_ref())).collect();
    Ok(couple(&named, &CoupleOptions::default(), &|| ())?.0)
}

/// Blends of two at percentages of the second paint.
pub fn steps(mix: &Mix, percent: &[i32]) -> Result<Vec<Paint>> {
    percent.iter().map(|p| mix.blend(&[1.0 - f64::from(*p) / 100.0, f64::from(*p) / 100.0])).collect()
}
