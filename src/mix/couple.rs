//! From paints to a mix: one transport problem a slice and level (Golla & Klein 2018, sections 4.1, 4.3).

use super::{Arc, Constituent, Mix, MixFlakes, MixLevel, MixSlice};
use crate::cluster::SliceStatistics;
use crate::error::{Error, Result};
use crate::paint::{Flakes, Paint};
use crate::transport::{Problem, Solver, solve};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// What coupling cost and how exact it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoupleReport {
    /// Transport problems solved: slices times levels times (paints - 1).
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
    /// Mean transport distance over the slices of the finest level, Delta-E, last paint added.
    pub mean_distance: f64,
}

/// Couples two to eight paints. `tick` is called once per slice and level.
///
/// # Errors
/// A number of paints outside 2-8; coats of which only some refract; flakes on some paints only, on different angle
/// grids, slice sizes or texel sizes; a solver that fails.
pub fn couple(
    paints: &[(String, &Paint)],
    solver: Solver,
    tick: &(dyn Fn() + Sync),
) -> Result<(Mix, CoupleReport)> {
    if !Mix::PAINTS.contains(&paints.len()) {
        return Err(Error::invalid("couple", "number of paints", paints.len(), "2 to 8"));
    }
    check_smooth(paints)?;
    let constituents = paints
        .iter()
        .map(|(name, paint)| Constituent {
            name: name.clone(),
            coat: paint.coat,
            diffuse: paint.diffuse,
            lobes: paint.lobes.clone(),
            colors: paint.colors.clone(),
            provenance: paint.provenance.clone(),
        })
        .collect();
    let mut report = CoupleReport {
        problems: 0,
        worst_relative_gap: 0.0,
        worst_row_error: 0.0,
        worst_column_error: 0.0,
        pitch_ratio: 1.0,
        arcs: 0,
        mean_distance: 0.0,
    };
    let flakes = common_flakes(paints)?.map(|f| couple_flakes(&f, solver, tick, &mut report)).transpose()?;
    let mix = Mix { constituents, flakes };
    mix.validate()?;
    Ok((mix, report))
}

fn check_smooth(paints: &[(String, &Paint)]) -> Result<()> {
    let refracts = paints[0].1.coat.refracts;
    if let Some((name, paint)) = paints.iter().find(|p| p.1.coat.refracts != refracts) {
        let found = format!("{} against {refracts} of {}", paint.coat.refracts, paints[0].0);
        let legal = "the same for all paints (fit them alike)";
        return Err(Error::unsupported(name.clone(), "refracting clear coat", found, legal));
    }
    let size = paints[0].1.colors.size();
    match paints.iter().find(|p| p.1.colors.size() != size) {
        Some((name, paint)) => {
            let legal = format!("{size:?}, that of the first paint");
            Err(Error::unsupported(
                name.clone(),
                "color table size",
                format!("{:?}", paint.colors.size()),
                legal,
            ))
        }
        None => Ok(()),
    }
}

/// The flakes of all paints if they can be coupled, none if no paint has any.
fn common_flakes<'a>(paints: &[(String, &'a Paint)]) -> Result<Option<Vec<&'a Flakes>>> {
    let all: Vec<Option<&Flakes>> = paints.iter().map(|p| p.1.flakes.as_ref()).collect();
    if all.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut flakes: Vec<&'a Flakes> = Vec::with_capacity(all.len());
    for ((name, _), f) in paints.iter().zip(all) {
        let f = f.ok_or_else(|| {
            let legal = "flakes in all paints or in none (`fit --flakes` gives a paint some)";
            Error::unsupported(name.clone(), "flakes", "none", legal)
        })?;
        if let Some(first) = flakes.first() {
            check_alike(first, f).map_err(|e| e.within(name))?;
        }
        flakes.push(f);
    }
    Ok(Some(flakes))
}

fn check_alike(first: &Flakes, other: &Flakes) -> Result<()> {
    if other.grid != first.grid {
        let show = |f: &Flakes| format!("{} bins, {} slices", f.grid.bins(), f.grid.len());
        let legal = format!("the grid of the first paint ({})", show(first));
        return Err(Error::unsupported("flakes", "angle grid", show(other), legal));
    }
    if other.size != first.size || other.levels.len() != first.levels.len() {
        let found = format!("{} x {}, {} levels", other.size[0], other.size[1], other.levels.len());
        let legal = format!("{} x {}, {} levels", first.size[0], first.size[1], first.levels.len());
        return Err(Error::unsupported("flakes", "slice size", found, legal));
    }
    if other.missing != first.missing {
        let legal = format!("{:?}, as the first paint", first.missing);
        return Err(Error::unsupported("flakes", "missing slices", format!("{:?}", other.missing), legal));
    }
    // Texel sizes that differ by less than a part in a million are the same number written twice.
    if (other.texel_mm / first.texel_mm - 1.0).abs() > 1e-6 {
        let legal = format!("{} mm, that of the first paint (`simulate --texel-um`)", first.texel_mm);
        return Err(Error::unsupported("flakes", "texel size", format!("{} mm", other.texel_mm), legal));
    }
    Ok(())
}

/// Largest errors of the problems behind one slice.
struct Quality {
    relative_gap: f64,
    row_error: f64,
    column_error: f64,
    distance: f64,
}

fn couple_flakes(
    flakes: &[&Flakes],
    solver: Solver,
    tick: &(dyn Fn() + Sync),
    report: &mut CoupleReport,
) -> Result<MixFlakes> {
    let first = flakes[0];
    let slices = first.grid.len();
    let done: Vec<(MixSlice, Quality)> = (0..first.levels.len() * slices)
        .into_par_iter()
        .map(|k| {
            let (level, slice) = (k / slices, k % slices);
            let statistics: Vec<&SliceStatistics> =
                flakes.iter().map(|f| &f.levels[level].slices[slice]).collect();
            let coupled = couple_slice(&statistics, solver)
                .map_err(|e| e.within(format!("level {level}: slice {slice}")))?;
            tick();
            Ok(coupled)
        })
        .collect::<Result<_>>()?;
    report.problems = done.len() * (flakes.len() - 1);
    report.arcs = done.iter().map(|d| d.0.arcs.len()).sum();
    report.mean_distance = done.iter().take(slices).map(|d| d.1.distance).sum::<f64>() / slices as f64;
    for (_, quality) in &done {
        report.worst_relative_gap = report.worst_relative_gap.max(quality.relative_gap);
        report.worst_row_error = report.worst_row_error.max(quality.row_error);
        report.worst_column_error = report.worst_column_error.max(quality.column_error);
    }
    let mut coupled = done.into_iter().map(|d| d.0);
    let levels = (0..first.levels.len())
        .map(|l| {
            let pitches = || flakes.iter().map(|f| f.levels[l].pitch_mm);
            let (least, most) = pitches().fold((f64::INFINITY, 0.0f64), |(a, b), p| (a.min(p), b.max(p)));
            report.pitch_ratio = report.pitch_ratio.max(most / least);
            let log_mean = pitches().map(f64::ln).sum::<f64>() / flakes.len() as f64;
            // One pitch shared by all stays what it is, to the bit.
            let same = least == most;
            let pitch_mm = if same { first.levels[l].pitch_mm } else { log_mean.exp() };
            MixLevel { pitch_mm, slices: coupled.by_ref().take(slices).collect() }
        })
        .collect();
    Ok(MixFlakes {
        grid: first.grid.clone(),
        missing: first.missing,
        size: first.size,
        texel_mm: first.texel_mm,
        inverse_cdf_steps: first.inverse_cdf_steps,
        knot_spacing: common_spacing(flakes),
        levels,
    })
}

/// The geometric mean, as for the pitch of the lattice; none unless all paints have one.
fn common_spacing(flakes: &[&Flakes]) -> Option<f64> {
    let spacings: Vec<f64> = flakes.iter().map(|f| f.knot_spacing).collect::<Option<_>>()?;
    let same = spacings.iter().all(|s| *s == spacings[0]);
    let log_mean = spacings.iter().map(|s| s.ln()).sum::<f64>() / spacings.len() as f64;
    Some(if same { spacings[0] } else { log_mean.exp() })
}

/// Couples one slice of all paints: the first two, then each further paint with the realization at equal weights of those
/// before it.
fn couple_slice(statistics: &[&SliceStatistics], solver: Solver) -> Result<(MixSlice, Quality)> {
    let mut arcs: Vec<Arc> = statistics[0]
        .clusters
        .iter()
        .map(|c| Arc { probability: c.probability, boxes: vec![[c.min, c.max]] })
        .collect();
    let mut quality = Quality { relative_gap: 0.0, row_error: 0.0, column_error: 0.0, distance: 0.0 };
    let mut gap = 0.0f64;
    for paint in &statistics[1..] {
        let centers: Vec<DVec3> = arcs.iter().map(center).collect();
        let masses: Vec<f64> = arcs.iter().map(|a| a.probability).collect();
        let next: Vec<Arc> = paint
            .clusters
            .iter()
            .map(|c| Arc { probability: c.probability, boxes: vec![[c.min, c.max]] })
            .collect();
        let targets: Vec<DVec3> = next.iter().map(center).collect();
        let wanted: Vec<f64> = next.iter().map(|a| a.probability).collect();
        let problem = Problem::from_centers(&centers, &masses, &targets, &wanted)?;
        let plan = solve(&problem, solver)?;
        let certificate = &plan.certificate;
        gap = gap.max(certificate.gap);
        // Identical paints have cost 0: there the gap is seen against the size of the problem.
        let scale = certificate.cost.max(1e-3 * problem.mean_cost()).max(f64::MIN_POSITIVE);
        quality.relative_gap = quality.relative_gap.max(certificate.gap / scale);
        quality.row_error = quality.row_error.max(certificate.row_error);
        quality.column_error = quality.column_error.max(certificate.column_error);
        quality.distance = certificate.cost;
        arcs = plan
            .entries
            .iter()
            .map(|(i, j, probability)| {
                let mut boxes = arcs[*i].boxes.clone();
                boxes.push(next[*j].boxes[0]);
                Arc { probability: *probability, boxes }
            })
            .collect();
    }
    sort_by_lightness(&mut arcs);
    let means = statistics.iter().map(|s| s.mean_rgb()).collect();
    Ok((MixSlice { arcs, means, gap }, quality))
}

/// Center of an arc's box at equal weights, Lab.
fn center(arc: &Arc) -> DVec3 {
    let sum: DVec3 = arc
        .boxes
        .iter()
        .map(|[min, max]| 0.5 * (DVec3::from(min.map(f64::from)) + DVec3::from(max.map(f64::from))))
        .sum();
    sum / arc.boxes.len() as f64
}

/// Ascending L, then a, b and the boxes themselves, so that the order depends on nothing but the arcs.
fn sort_by_lightness(arcs: &mut [Arc]) {
    arcs.sort_by_cached_key(|arc| {
        let c = center(arc).to_array().map(total_order);
        let corners: Vec<u64> =
            arc.boxes.as_flattened().as_flattened().iter().map(|x| total_order(f64::from(*x))).collect();
        (c, corners)
    });
}

/// A finite number as an integer in the same order (IEEE 754 total order).
fn total_order(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}
