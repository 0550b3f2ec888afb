//! From paints to a mix: one transport problem a slice and level (Golla & Klein 2018, sections 4.1, 4.3).

use super::common::{FlakesForm, Form};
use super::couple_slice::Quality;
use super::{CommonForm, Constituent, Mix, MixFlakes, MixLevel, MixSlice, Path};
use crate::error::{Error, Result};
use crate::paint::{Flakes, Knots, Paint};
use crate::parallel::TryMap;
use crate::transport::{Cost, Solver};
use rayon::prelude::*;
use serde::Serialize;

/// How paints are coupled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupleOptions {
    /// The path that blends take unless another is asked for; any can be asked for.
    pub path: Path,
    /// Ground cost; none: [`Path::cost`].
    pub cost: Option<Cost>,
    /// Distance from which on [`Path::Hybrid`] exchanges probability instead of moving a box, Delta-E, above 0.
    pub threshold: f64,
    /// How transport problems are solved.
    pub solver: Solver,
}

impl Default for CoupleOptions {
    fn default() -> Self {
        Self { path: Path::default(), cost: None, threshold: Path::THRESHOLD, solver: Solver::default() }
    }
}

/// What coupling cost and how exact it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoupleReport {
    /// Transport problems solved: slices times levels times paints added.
    pub problems: usize,
    /// Largest duality gap of a problem, relative to max(cost, 1e-3 of the mean edge).
    pub worst_relative_gap: f64,
    /// Largest error of a row sum (a paint's own probability), relative to it.
    pub worst_row_error: f64,
    /// Largest error of a column sum, relative to it with the network simplex; LP back ends lose columns below 1e-9 of the mass.
    pub worst_column_error: f64,
    /// Largest ratio of the paints' lattice pitches at one level, 1 or more: the mix draws on their geometric mean.
    pub pitch_ratio: f64,
    /// Arcs in all slices and levels.
    pub arcs: usize,
    /// Mean transport cost over the slices of the finest level, last paint added; Delta-E where the cost is a distance.
    pub mean_distance: f64,
    /// The paints that had another form than the first, and what it cost to bring them to it.
    pub common_form: Vec<CommonForm>,
}

/// Couples two to eight paints: the first two, then each further one with the realization at equal weights of those before
/// it. Grid, levels and color table of the mix are those of the first paint: the finest comes first. `tick` is called once a
/// slice, level and paint added.
///
/// # Errors
/// A number of paints outside 2-8; a threshold or cap that is not above 0; coats of which only some refract; a solver that
/// fails.
pub fn couple(
    paints: &[(String, &Paint)],
    options: &CoupleOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<(Mix, CoupleReport)> {
    if !Mix::PAINTS.contains(&paints.len()) {
        return Err(Error::invalid("couple", "number of paints", paints.len(), "2 to 8"));
    }
    let (name, first) = &paints[0];
    extend(Mix::of(name, first, options), &paints[1..], options.solver, tick)
}

/// The mix with more paints, the rest of it as it was: the same as coupling all of them at once, in that order, with the
/// path, cost and threshold of the mix.
///
/// # Errors
/// As [`couple`].
pub fn add(
    mix: &Mix,
    paints: &[(String, &Paint)],
    solver: Solver,
    tick: &(dyn Fn() + Sync),
) -> Result<(Mix, CoupleReport)> {
    let number = mix.constituents.len() + paints.len();
    if !Mix::PAINTS.contains(&number) {
        return Err(Error::invalid("couple", "number of paints", number, "2 to 8"));
    }
    extend(mix.clone(), paints, solver, tick)
}

fn extend(
    mut mix: Mix,
    paints: &[(String, &Paint)],
    solver: Solver,
    tick: &(dyn Fn() + Sync),
) -> Result<(Mix, CoupleReport)> {
    let mut report = CoupleReport {
        problems: 0,
        worst_relative_gap: 0.0,
        worst_row_error: 0.0,
        worst_column_error: 0.0,
        pitch_ratio: 1.0,
        arcs: 0,
        mean_distance: 0.0,
        common_form: Vec::new(),
    };
    mix.cost.validated()?;
    for (name, paint) in paints {
        let (constituent, flakes, cost) = mix.form().bring(name, paint)?;
        report.common_form.extend(cost);
        if let Some(flakes) = flakes {
            mix.add_flakes(&flakes, solver, tick, &mut report)?;
        }
        mix.constituents.push(constituent);
    }
    let slices = mix.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices);
    report.arcs = slices.map(|s| s.probabilities.len()).sum();
    mix.validate()?;
    Ok((mix, report))
}

impl Mix {
    /// A mix of one paint, to which others are added.
    fn of(name: &str, paint: &Paint, options: &CoupleOptions) -> Self {
        let constituent = Constituent {
            name: name.to_owned(),
            coat: paint.coat,
            diffuse: paint.diffuse,
            lobes: paint.lobes.clone(),
            colors: paint.colors.clone(),
            provenance: paint.provenance.clone(),
        };
        Self {
            constituents: vec![constituent],
            flakes: paint.flakes.as_ref().map(MixFlakes::of),
            path: options.path,
            cost: options.cost.unwrap_or(options.path.cost(options.threshold)),
            threshold: options.threshold,
        }
    }

    fn form(&self) -> Form<'_> {
        let first = &self.constituents[0];
        let flakes = self.flakes.as_ref().map(|f| FlakesForm {
            grid: &f.grid,
            missing: f.missing,
            size: f.size,
            texel_mm: f.texel_mm,
            pitch_mm: f.levels.iter().map(|l| l.pitch_mm).collect(),
            knots: f.knots,
        });
        Form { name: &first.name, coat: first.coat, table_size: first.colors.size(), flakes }
    }

    fn add_flakes(
        &mut self,
        flakes: &Flakes,
        solver: Solver,
        tick: &(dyn Fn() + Sync),
        report: &mut CoupleReport,
    ) -> Result<()> {
        let paints = self.constituents.len();
        let mix = self.flakes.get_or_insert_with(|| MixFlakes::nothing_like(flakes, paints));
        let (cost, threshold) = (self.cost, self.threshold);
        let slices = mix.grid.len();
        let done: Vec<(MixSlice, Quality)> = (0..mix.levels.len() * slices).into_par_iter().try_map(|k| {
            let (level, slice) = (k / slices, k % slices);
            let added = &flakes.levels[level].slices[slice];
            let coupled = mix.levels[level].slices[slice]
                .with(added, cost, threshold, solver)
                .map_err(|e| e.within(format!("level {level}: slice {slice}")))?;
            tick();
            Ok(coupled)
        })?;
        report.add(&done, slices);
        let mut coupled = done.into_iter().map(|d| d.0);
        for (level, added) in mix.levels.iter_mut().zip(&flakes.levels) {
            let (low, high) = (level.pitch_mm.min(added.pitch_mm), level.pitch_mm.max(added.pitch_mm));
            report.pitch_ratio = report.pitch_ratio.max(high / low);
            level.pitch_mm = geometric_mean(level.pitch_mm, paints, added.pitch_mm);
            level.slices = coupled.by_ref().take(slices).collect();
        }
        mix.knots = mix.knots.zip(flakes.knots).map(|(a, b)| Knots {
            spacing: geometric_mean(a.spacing, paints, b.spacing),
            compression: mean(a.compression, paints, b.compression),
        });
        Ok(())
    }
}

/// The mean of one more value than `n` of which it is `mean`; a value shared by all stays what it is, to the bit.
fn mean(mean: f64, n: usize, value: f64) -> f64 {
    mean + (value - mean) / (n + 1) as f64
}

/// The geometric mean of one more value than `n` of which it is `mean`; a value shared by all stays what it is, to the bit.
fn geometric_mean(mean: f64, n: usize, value: f64) -> f64 {
    let log = (n as f64 * mean.ln() + value.ln()) / (n + 1) as f64;
    if mean == value { mean } else { log.exp() }
}

impl CoupleReport {
    fn add(&mut self, done: &[(MixSlice, Quality)], slices: usize) {
        let solved = |done: &[(MixSlice, Quality)]| done.iter().filter(|d| !d.0.is_left_out()).count();
        self.problems += solved(done);
        let finest = &done[..slices];
        let cost: f64 = finest.iter().map(|d| d.1.cost).sum();
        self.mean_distance = cost / solved(finest).max(1) as f64;
        for (_, quality) in done {
            self.worst_relative_gap = self.worst_relative_gap.max(quality.relative_gap);
            self.worst_row_error = self.worst_row_error.max(quality.row_error);
            self.worst_column_error = self.worst_column_error.max(quality.column_error);
        }
    }
}

impl MixFlakes {
    /// The flakes of one paint.
    fn of(flakes: &Flakes) -> Self {
        let level = |l: &crate::paint::FlakeLevel| MixLevel {
            pitch_mm: l.pitch_mm,
            slices: l.slices.iter().map(MixSlice::of).collect(),
        };
        Self {
            grid: flakes.grid.clone(),
            missing: flakes.missing,
            size: flakes.size,
            texel_mm: flakes.texel_mm,
            inverse_cdf_steps: flakes.inverse_cdf_steps,
            knots: flakes.knots,
            levels: flakes.levels.iter().map(level).collect(),
        }
    }

    /// So many paints without flakes, laid out as another's are.
    fn nothing_like(flakes: &Flakes, paints: usize) -> Self {
        let mut nothing = Self::of(flakes);
        for slice in nothing.levels.iter_mut().flat_map(|l| &mut l.slices) {
            let left_out = slice.is_left_out();
            *slice = if left_out { MixSlice::left_out(paints) } else { MixSlice::nothing(paints) };
        }
        nothing
    }
}
