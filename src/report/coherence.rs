//! Whether what is drawn hangs together as the source does: over angles, between slices, over scales.

use super::angular::{HalfWidth, Midway, half_widths, midway};
use super::scales::{Scale, scales};
use super::{Chain, ChainOptions};
use crate::error::Result;
use crate::paint::Knots;
use serde::Serialize;

/// Everything measured of one paint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coherence {
    /// The flakes' lifetime.
    pub knots: Option<Knots>,
    /// Angular autocorrelation.
    pub half_widths: Vec<HalfWidth>,
    /// Contrast between slices.
    pub midway: Vec<Midway>,
    /// Contrast at all scales: zooming.
    pub zoom: Vec<Scale>,
    /// Contrast under long footprints: tilting.
    pub tilt: Vec<Scale>,
}

/// Roots of footprint areas, texels, for zooming: four octaves, whole quarters.
const SIDES: [f64; 17] =
    [1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 14.0, 16.0];
/// Long side over short, for tilting.
const RATIOS: [f64; 12] = [1.0, 1.2, 1.5, 1.8, 2.2, 2.8, 3.6, 4.5, 6.0, 8.0, 11.0, 16.0];
/// Short side while tilting, texels.
const SHORT: [f64; 2] = [1.0, 3.0];

/// Measures a paint of a composition. `tick` is called once a table, four times.
///
/// # Errors
/// Those of the synthesis.
pub fn coherence(
    chain: &Chain,
    options: &ChainOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<Option<Coherence>> {
    let Some(flakes) = &chain.paint.flakes else { return Ok(None) };
    let synthesis = options.synthesis()?;
    let done = |_: &_| tick();
    let zoom: Vec<(f64, f64)> = SIDES.iter().map(|side| (*side, 1.0)).collect();
    // A tilted surface: the short side stays, the long one grows.
    let tilt: Vec<(f64, f64)> =
        SHORT.iter().flat_map(|short| RATIOS.map(|ratio| (short * ratio.sqrt(), ratio))).collect();
    let half_widths = half_widths(&chain.model, &synthesis, flakes)?;
    tick();
    let midway = midway(&chain.model, &synthesis, flakes)?;
    tick();
    let [zoom, tilt] =
        [zoom, tilt].map(|f| scales(&chain.model, &synthesis, flakes, &f).inspect(|t| done(t)));
    let knots = flakes.knots;
    Ok(Some(Coherence { knots, half_widths, midway, zoom: zoom?, tilt: tilt? }))
}

/// Tables for people.
impl std::fmt::Display for Coherence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.knots {
            Some(Knots { spacing, compression }) => {
                let degrees = spacing.to_degrees();
                writeln!(
                    f,
                    "spacing of knots {spacing:.4} ({degrees:.2} degrees inside), compression {compression:.2}"
                )?
            }
            None => writeln!(f, "flakes do not go out")?,
        }
        writeln!(
            f,
            "half-width of the autocorrelation, degrees of theta_h\ntheta_h theta_i  energy  lit texels   source   drawn   ratio"
        )?;
        for row in &self.half_widths {
            let energy = if row.strong { "80 %" } else { "rest" };
            let (h, i, ratio) = (row.theta_h_deg, row.theta_i_deg, row.ratio());
            writeln!(
                f,
                "{h:7.1} {i:7.1}  {energy}   {:10.0} {:8.2} {:7.2} {ratio:7.3}",
                row.lit_texels, row.source_deg, row.drawn_deg
            )?;
        }
        writeln!(
            f,
            "standard deviation midway between slices, luminance, 1/sr\ntheta_h theta_i    source     drawn   ratio"
        )?;
        for row in &self.midway {
            let (h, i) = (row.theta_h_deg, row.theta_i_deg);
            writeln!(
                f,
                "{h:7.2} {i:7.2} {:9.4} {:9.4} {:7.3}",
                row.source,
                row.drawn,
                row.drawn / row.source
            )?;
        }
        for (what, rows) in [("zooming", &self.zoom), ("tilting", &self.tilt)] {
            writeln!(
                f,
                "{what}: drawn against the box-filtered source\nside, texels   ratio   std ratio   mean error"
            )?;
            for row in rows {
                let Scale { side_texels, ratio, deviation_ratio, mean_error, mean_noise } = row;
                writeln!(
                    f,
                    "{side_texels:12.2} {ratio:7.2} {deviation_ratio:11.3}   {mean_error:10.4} +- {mean_noise:.4}"
                )?;
            }
        }
        Ok(())
    }
}
