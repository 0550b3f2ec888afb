//! Bringing a paint to the form of those it is mixed with: angle grid, texels, levels, color table, coat.

use super::Constituent;
use crate::brdf::{ClearCoat, ColorTable};
use crate::btf::AngleGrid;
use crate::cluster::{Cluster, SliceStatistics, deviation_of_draws};
use crate::color::lab_from_rgb;
use crate::error::{Error, Result};
use crate::paint::{FlakeLevel, Flakes, Knots, MissingSlice, Paint};
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// What it cost to bring a paint to the form of the first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CommonForm {
    /// Name of the paint.
    pub paint: String,
    /// Largest angle (of theta_h and theta_i) between where a slice is used and where it was, degrees.
    pub angle_moved_deg: f64,
    /// Levels of detail by which the paint was shifted: positive if its own texels are the finer ones.
    pub levels_shifted: i32,
    /// Size of its texels over that of the first paint's at the same level, after the shift: 0.7 to 1.42 unless the paint
    /// has no level so fine.
    pub texel_ratio: f64,
    /// Largest difference, Delta-E (Euclidean in Lab), between its color table and the resampled one, at its own texels.
    pub color_table_error: f64,
    /// Whether it has no flakes, and got slices of nothing.
    pub without_flakes: bool,
}

impl CommonForm {
    fn unchanged(paint: &str) -> Self {
        Self {
            paint: paint.to_owned(),
            angle_moved_deg: 0.0,
            levels_shifted: 0,
            texel_ratio: 1.0,
            color_table_error: 0.0,
            without_flakes: false,
        }
    }
}

/// What a paint must share with the mix that it is added to.
pub(super) struct Form<'a> {
    pub name: &'a str,
    pub coat: ClearCoat,
    pub table_size: [usize; 2],
    pub flakes: Option<FlakesForm<'a>>,
}

/// Layout of the slices.
pub(super) struct FlakesForm<'a> {
    pub grid: &'a AngleGrid,
    pub missing: MissingSlice,
    pub size: [usize; 2],
    pub texel_mm: f64,
    pub pitch_mm: Vec<f64>,
    pub knots: Option<Knots>,
}

impl Form<'_> {
    /// The paint in this form, and what that cost if it had another.
    ///
    /// # Errors
    /// A coat that refracts beside one that does not, unless its index is 1: the angles of their tables mean different things.
    pub(super) fn bring(
        &self,
        name: &str,
        paint: &Paint,
    ) -> Result<(Constituent, Option<Flakes>, Option<CommonForm>)> {
        let mut cost = CommonForm::unchanged(name);
        let constituent = Constituent {
            name: name.to_owned(),
            coat: self.coat(paint.coat).map_err(|e| e.within(name))?,
            diffuse: paint.diffuse,
            lobes: paint.lobes.clone(),
            colors: resampled(&paint.colors, self.table_size, &mut cost.color_table_error)?,
            provenance: paint.provenance.clone(),
        };
        let flakes = match (&self.flakes, &paint.flakes) {
            (None, own) => own.clone(),
            (Some(form), Some(own)) => Some(form.bring(own, &mut cost)),
            (Some(form), None) => {
                cost.without_flakes = true;
                Some(form.nothing())
            }
        };
        let changed = cost != CommonForm::unchanged(name);
        Ok((constituent, flakes, changed.then_some(cost)))
    }

    fn coat(&self, coat: ClearCoat) -> Result<ClearCoat> {
        if coat.refracts == self.coat.refracts || coat.ior == 1.0 {
            return Ok(ClearCoat { refracts: self.coat.refracts, ..coat });
        }
        let found = format!("{} against {} of {}", coat.refracts, self.coat.refracts, self.name);
        Err(Error::unsupported(
            "",
            "refracting clear coat",
            found,
            "the same for all paints (fit them alike)",
        ))
    }
}

/// A color table in another size, bilinear; the texels of an equal size are the same.
fn resampled(table: &ColorTable, size: [usize; 2], error: &mut f64) -> Result<ColorTable> {
    if table.size() == size {
        return Ok(table.clone());
    }
    let angles = |k: usize, size: [usize; 2]| {
        let at = |k: usize, n: usize| (FRAC_PI_2 * k as f64 / (n - 1) as f64) as f32;
        (at(k % size[0], size[0]), at(k / size[0], size[1]))
    };
    let texel = |k: usize| {
        let (h, i) = angles(k, size);
        let measured = table.taps(h, i).iter().all(|(k, w)| *w == 0.0 || table.measured()[*k]);
        (table.sample(h, i), measured)
    };
    let (texels, measured) = (0..size[0] * size[1]).map(texel).unzip();
    let new = ColorTable::new(size, texels, measured)?;
    let lab = |c: [f32; 3]| lab_from_rgb(DVec3::from(c.map(f64::from)));
    for (k, own) in table.texels().iter().enumerate() {
        let (h, i) = angles(k, table.size());
        *error = error.max(lab(*own).distance(lab(new.sample(h, i))));
    }
    Ok(new)
}

impl FlakesForm<'_> {
    fn bring(&self, own: &Flakes, cost: &mut CommonForm) -> Flakes {
        let ratio = own.texel_mm / self.texel_mm;
        // Texel sizes that differ by less than a part in a million are the same number written twice.
        let octaves = if (ratio - 1.0).abs() <= 1e-6 { 0.0 } else { ratio.log2() };
        let shift = -octaves.round() as i32;
        let last = own.levels.len() as i32 - 1;
        let source = |level: usize| (level as i32 + shift).clamp(0, last) as usize;
        let offset = source(0) as i32;
        cost.levels_shifted = shift;
        cost.texel_ratio = (octaves + f64::from(offset)).exp2();
        let places = self.places(own, &mut cost.angle_moved_deg);
        let level = |l: usize| {
            let from = &own.levels[source(l)];
            FlakeLevel {
                pitch_mm: from.pitch_mm,
                slices: places.iter().map(|p| p.slice(&from.slices)).collect(),
            }
        };
        self.flakes((0..self.pitch_mm.len()).map(level).collect(), own.inverse_cdf_steps, own.knots)
    }

    /// Where each slice of this form's grid comes from.
    fn places(&self, own: &Flakes, moved_deg: &mut f64) -> Vec<Place> {
        (0..self.grid.len())
            .map(|k| {
                let place = Place::new(own, self.grid, k);
                if let Some((nearest, _)) = place.nearest() {
                    let ((h, i), (h0, i0)) = (self.grid.angles(k), own.grid.angles(nearest));
                    *moved_deg = moved_deg.max((h - h0).abs().max((i - i0).abs()).to_degrees());
                }
                place
            })
            .collect()
    }

    /// Slices without flakes.
    fn nothing(&self) -> Flakes {
        let level =
            |pitch_mm: &f64| FlakeLevel { pitch_mm: *pitch_mm, slices: vec![black(); self.grid.len()] };
        // Nothing lives as long as anything: the lifetime of the others stays.
        self.flakes(self.pitch_mm.iter().map(level).collect(), 500, self.knots)
    }

    fn flakes(&self, levels: Vec<FlakeLevel>, inverse_cdf_steps: usize, knots: Option<Knots>) -> Flakes {
        let (grid, missing, size, texel_mm) = (self.grid.clone(), self.missing, self.size, self.texel_mm);
        Flakes { grid, missing, size, texel_mm, levels, inverse_cdf_steps, knots }
    }
}

/// Statistics that draw nothing but 0.
fn black() -> SliceStatistics {
    SliceStatistics::new(vec![Cluster { probability: 1.0, min: [0.0; 3], max: [0.0; 3] }], [0.0; 3])
}

/// Up to four slices about an angle pair, with their bilinear weights.
struct Place(Vec<(usize, f64)>);

impl Place {
    /// In the grid of `own`, at the angles of slice `k` of another.
    fn new(own: &Flakes, grid: &AngleGrid, k: usize) -> Self {
        // Exact where the grids have a point in common.
        let split = |bin: usize| {
            let product = bin * own.grid.bins();
            (product / grid.bins(), (product % grid.bins()) as f64 / grid.bins() as f64)
        };
        let (h, i) = grid.bins_of(k);
        let ((h, fh), (i, fi)) = (split(h), split(i));
        let corners = [
            (h, i, (1.0 - fh) * (1.0 - fi)),
            (h + 1, i, fh * (1.0 - fi)),
            (h, i + 1, (1.0 - fh) * fi),
            (h + 1, i + 1, fh * fi),
        ];
        let slice = |h: usize, i: usize| match own.missing {
            MissingSlice::Zero => own.grid.slice(h, i),
            MissingSlice::Nearest => {
                let row = i.min(own.grid.rows().len() - 1);
                own.grid.slice(h.min(own.grid.rows()[row] - 1), row)
            }
        };
        let taps = corners.into_iter().filter(|(.., w)| *w > 0.0);
        Self(taps.filter_map(|(h, i, w)| slice(h, i).map(|k| (k, w))).collect())
    }

    /// The slice of largest weight.
    fn nearest(&self) -> Option<(usize, f64)> {
        self.0.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a })
    }

    /// The nearest slice, brought to the interpolated mean and standard deviation.
    fn slice(&self, slices: &[SliceStatistics]) -> SliceStatistics {
        let Some((nearest, weight)) = self.nearest() else { return black() };
        if self.0.iter().any(|(k, _)| slices[*k].is_left_out()) {
            return SliceStatistics::left_out();
        }
        if weight == 1.0 {
            return slices[nearest].clone();
        }
        let mut slice = slices[nearest].clone();
        let gain = |s: &SliceStatistics| DVec3::from(s.gain.map(f64::from));
        let deviation = |s: &SliceStatistics| gain(s) * deviation_of_draws(&s.clusters, &s.fades);
        let wanted: DVec3 = self.0.iter().map(|(k, w)| *w * deviation(&slices[*k])).sum();
        let mean: DVec3 = self.0.iter().map(|(k, w)| *w * slices[*k].mean_rgb()).sum();
        let ratio = wanted / deviation(&slice);
        for c in (0..3).filter(|c| ratio[*c].is_finite()) {
            slice.gain[c] =
                (f64::from(slice.gain[c]) * ratio[c]).min(f64::from(SliceStatistics::MAX_GAIN)) as f32;
        }
        slice.offset = (mean - gain(&slice) * slice.box_mean()).as_vec3().to_array();
        slice
    }
}
