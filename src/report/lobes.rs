//! Blended lobes, inside and outside the paints, against the simulated paint.

use super::{PhysicalChange, smooth};
use crate::error::Result;
use crate::fit::SmoothFit;
use crate::mix::{BlendOptions, LobePath, Mix};
use crate::simulate::{Composition, Model, ModelOptions};
use serde::Serialize;

/// Half way, and as far again outside on either side.
const WAYS: [f64; 3] = [-0.5, 0.5, 1.5];

/// Error of the smooth part of a blend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LobeError {
    /// What changes from end to end.
    pub change: PhysicalChange,
    /// Weight of the end.
    pub way: f64,
    /// Which lobes belong together.
    pub lobes: LobePath,
    /// Mean Delta-E 2000 of the smooth part over 320 pairs of directions.
    pub smooth: f64,
}

/// Both ways to blend lobes; where the change, extrapolated, leaves what a composition can be, there is no row.
pub(super) fn errors(change: PhysicalChange, composition: &Composition, mix: &Mix) -> Result<Vec<LobeError>> {
    let mut all = Vec::new();
    for way in WAYS {
        let Ok(composition) = change.at(composition, way) else { continue };
        let model = Model::new(&composition, ModelOptions::default())?;
        for lobes in LobePath::ALL {
            let options = BlendOptions { lobes, ..BlendOptions::default() };
            let fit = smooth::matt(&SmoothFit::from(&mix.blend_with(&[1.0 - way, way], &options)?));
            let smooth = smooth::mean_difference(|wi, wo| fit.eval(wi, wo), &model);
            all.push(LobeError { change, way, lobes, smooth });
        }
    }
    Ok(all)
}
