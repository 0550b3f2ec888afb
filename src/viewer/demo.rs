//! What is shown when no file is named: three paints, simulated on the spot.

use super::document::{Document, NamedPaint};
use super::job::Progress;
use super::recipe::{Sizes, simulated};
use crate::error::Result;
use crate::simulate::Composition;
use std::sync::Arc;

/// A warm, a blue and a gray one: hue, density and size of flakes differ.
const PAINTS: [(&str, &str); 3] = [
    ("brown", include_str!("../../fixtures/compositions/brown_metallic.toml")),
    ("blue", include_str!("../../fixtures/compositions/blue_metallic.toml")),
    ("silver", include_str!("../../fixtures/compositions/silver_metallic.toml")),
];

/// One texel for all, so that their slices can be coupled: between what suits the fine blue flakes and the coarse brown ones.
const SIZES: Sizes = Sizes { texel_mm: Some(0.012), ..Sizes::QUICK };

/// Simulates and couples the paints.
///
/// # Errors
/// Those of the stages; none with the built-in compositions.
pub fn demo(progress: &Progress) -> Result<Document> {
    let paint = |(name, text): &(&str, &str)| {
        let composition = Composition::parse(text).map_err(|e| e.within(name))?;
        let paint = Arc::new(simulated(name, &composition, SIZES, progress)?);
        Ok(NamedPaint { name: (*name).to_owned(), paint })
    };
    let paints = PAINTS.iter().map(paint).collect::<Result<Vec<_>>>()?;
    Document::new(paints, progress)
}
