//! From a composition to a flake BTF: explicit flakes, the same in every slice.
//!
//! At a cell of the angle grid, with both outer polar angles equal (phi_d = 90 degrees), flake k adds to each texel it
//! covers
//! `share T r_p(alpha) / (4 eta^2 cos(bar theta) cos(bar theta')) K(n_k, h) exp(-x_above - [tau(bar theta) + tau(bar theta')] z_k)`,
//! all inside its own film: h the half vector, K the flake's angular lobe, T what the boundaries above pass both ways and
//! x_above the optical thickness of the films above. With area density `D<S>h`, normals from P and depths uniform in [0, h]
//! the expectation is Ershov 2001, eq. 36, with P convolved with K: the glitter of the model. A slice stores the texel minus
//! that; the smooth BRDF stored beside the slices carries it (DESIGN: who carries the mean).
//!
//! No cell needs clipping: theta_h and theta_i stay below 90 degrees, so that both cosines are positive, and the model
//! diverges at grazing only without a surface (index 1), as 1/cos.

mod disc;
pub mod flakes;
pub mod panel;
pub mod parallax;
pub mod phi_d;
mod slice;

pub use disc::cover_disc;

use crate::brdf::TabulatedBrdf;
#[cfg(feature = "files")]
use crate::btf::BtfWriter;
use crate::btf::{AngleGrid, FlakeBtf, FlakeSlice};
use crate::color::luminance;
use crate::error::{Error, Result};
use crate::math::half_difference::directions;
use crate::parallel::TryMap;
use crate::simulate::Model;
use crate::simulate::composition::Composition;
use crate::simulate::optics::film_optics::{FilmView, PaintOptics};
use flakes::Flakes;
use parallax::{OppositeView, ParallaxError, shifts};
use phi_d::phi_d_error;
use rayon::prelude::*;
use serde_json::json;
use slice::{Canvas, DrawnKind};
use std::f64::consts::FRAC_PI_2;
#[cfg(feature = "files")]
use std::path::Path;

/// Polar and azimuthal cells of the smooth table: those of the measured tables in circulation.
const SMOOTH_RESOLUTION: [usize; 2] = [45, 90];
/// Angle bins per 90 degrees that users get without asking: steps of 3.75 degrees, half a flake's lifetime (Golla & Klein 2018
/// name 24 to 30 samples).
pub const DEFAULT_BINS: usize = 24;
/// Width of the mean flake, in texels, where the texel size is not given: resolved, and few texels wasted on it.
const FLAKE_TEXELS: f64 = 1.5;
/// Effective number of flakes above which the mean of a slice is tested: below, its distribution is far from normal.
const TESTED_FLAKES: f64 = 20.0;

/// What to synthesize.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthesisOptions {
    /// Which (theta_h, theta_i), outer angles, get a slice.
    pub grid: AngleGrid,
    /// Columns and rows of a slice, each 1 to 4096.
    pub size: [usize; 2],
    /// Side of a texel, millimetres; by default the mean flake is 1.5 texels wide.
    pub texel_mm: Option<f64>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Whether flakes are seen shifted by their depth (a convention fixes the azimuth of the view; what that costs is
    /// reported as [`ParallaxError`]).
    pub parallax: bool,
}

impl SynthesisOptions {
    /// The grid with slices of 128 x 128, default texels, seed 1, no parallax.
    pub fn new(grid: AngleGrid) -> Self {
        Self { grid, size: [128, 128], texel_mm: None, seed: 1, parallax: false }
    }
}

/// Synthesizes the flake BTF of a model's composition: [`Synthesis::new`] and [`Synthesis::run`].
///
/// # Errors
/// Those of both.
pub fn synthesize(model: &Model, options: &SynthesisOptions, tick: &(dyn Fn() + Sync)) -> Result<FlakeBtf> {
    Synthesis::new(model, options)?.run(tick)
}

/// All flakes of a paint, ready to be seen from anywhere.
///
/// Each slice has the same bits for any number of threads, in whichever order and company it is made.
pub struct Synthesis<'a> {
    model: &'a Model,
    options: &'a SynthesisOptions,
    texel_mm: f64,
    /// The kinds of flakes of every film, bottom to top.
    films: Vec<Vec<DrawnKind>>,
}

/// What is kept of a slice once it is written.
struct SliceCheck {
    /// Mean luminance over texels minus expectation.
    mean_error: f64,
    /// Its standard error; 0 without light.
    deviation: f64,
    /// (sum of contributions)^2 over sum of squares: how many flakes make the mean.
    effective_flakes: f64,
    /// The other view, with parallax.
    opposite: OppositeView,
}

impl SliceCheck {
    /// The error of the mean in standard errors.
    fn z(&self) -> f64 {
        if self.deviation > 0.0 { self.mean_error / self.deviation } else { 0.0 }
    }
}

impl<'a> Synthesis<'a> {
    /// Draws the flakes.
    ///
    /// # Errors
    /// Flakes without a lobe (`flake_lifetime_deg = 0`), which no texture resolves; more texels than
    /// [`FlakeBtf::MAX_TEXELS`]; a texel size that is not positive, or missing while there are no flakes; more than
    /// [`Flakes::MAX`] flakes of all kinds together, or too wide ones for the texture ([`Flakes::draw`]).
    pub fn new(model: &'a Model, options: &'a SynthesisOptions) -> Result<Self> {
        let composition = model.composition();
        let texel_mm = texel_size(composition, options)?;
        let films = draw_films(composition, model.optics(), options, texel_mm * 1e3)?;
        Ok(Self { model, options, texel_mm, films })
    }

    /// Side of a texel, millimetres.
    pub fn texel_mm(&self) -> f64 {
        self.texel_mm
    }

    /// Slice `k` of the grid, for `k` below its length.
    pub fn slice(&self, k: usize) -> FlakeSlice {
        self.checked_slice(k).0
    }

    /// All slices in memory. `tick` is called once a slice.
    ///
    /// # Errors
    /// A smooth BRDF that is not finite: none within the ranges of a composition.
    pub fn run(&self, tick: &(dyn Fn() + Sync)) -> Result<FlakeBtf> {
        let slices = self.each_slice(|_, slice| {
            tick();
            Ok(slice)
        })?;
        let (slices, checks): (Vec<_>, Vec<_>) = slices.into_iter().unzip();
        Ok(FlakeBtf {
            grid: self.options.grid.clone(),
            size: self.options.size,
            texel_mm: self.texel_mm,
            slices,
            smooth: self.smooth()?,
            coat: self.model.coat(),
            provenance: self.provenance(&checks),
        })
    }

    /// All slices into a file, each forgotten once it is written: the bytes that [`FlakeBtf::write`] makes of
    /// [`Synthesis::run`]. Returns the provenance. `tick` is called once a slice.
    ///
    /// # Errors
    /// As [`Synthesis::run`], and those of the file system.
    #[cfg(feature = "files")]
    pub fn write(&self, path: &Path, tick: &(dyn Fn() + Sync)) -> Result<serde_json::Value> {
        let writer = BtfWriter::new(path, &self.options.grid, self.options.size, self.texel_mm)?;
        let checks = self.each_slice(|k, slice| {
            writer.slice(k, &slice)?;
            tick();
            Ok(())
        })?;
        let checks: Vec<_> = checks.into_iter().map(|((), check)| check).collect();
        let provenance = self.provenance(&checks);
        writer.finish(&self.smooth()?, self.model.coat(), &provenance)?;
        Ok(provenance)
    }

    /// Hands every slice to `keep`, in parallel.
    fn each_slice<T: Send>(
        &self,
        keep: impl Fn(usize, FlakeSlice) -> Result<T> + Sync,
    ) -> Result<Vec<(T, SliceCheck)>> {
        (0..self.options.grid.len()).into_par_iter().try_map(|k| {
            let (slice, check) = self.checked_slice(k);
            Ok((keep(k, slice)?, check))
        })
    }

    fn checked_slice(&self, k: usize) -> (FlakeSlice, SliceCheck) {
        let (theta_h, theta_i) = self.options.grid.angles(k);
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let optics = self.model.optics();
        // Topmost first; none only by rounding, at 90 degrees.
        let mut views: Vec<FilmView> = Vec::with_capacity(optics.films.len());
        optics.visit(wi, wo, |_, view| views.push(view.clone()));
        let seen =
            self.options.parallax.then(|| [wo, wi].map(|eye| shifts(eye, &views, &self.thicknesses())));
        let mut canvas = Canvas::new(self.options.size, seen.is_some());
        let films = optics.films.iter().zip(&self.films).rev();
        for (n, ((film, kinds), view)) in films.zip(&views).enumerate() {
            let shifts = seen.as_ref().map(|seen| seen.each_ref().map(|eye| eye[n]));
            for (kind, optics) in kinds.iter().zip(&film.kinds) {
                canvas.add(kind, &optics.optics, film, view, shifts);
            }
        }
        let glitter = self.model.glitter(wi, wo).linear_rgb();
        let slice = FlakeSlice {
            fluctuation: canvas.texels.iter().map(|t| (*t - glitter).as_vec3().to_array()).collect(),
            expectation: (glitter + self.model.rest(wi, wo).linear_rgb()).to_array(),
        };
        let Canvas { sum, squares, texels, opposite, .. } = canvas;
        let opposite =
            match (opposite, seen.map(|seen| seen.map(|eye| eye.last().copied().unwrap_or_default()))) {
                (Some(opposite), Some(lowest)) => OppositeView::new(&texels, &opposite, lowest),
                _ => OppositeView::default(),
            };
        let check = SliceCheck {
            mean_error: sum - luminance(glitter),
            deviation: squares.sqrt(),
            effective_flakes: if squares > 0.0 { sum * sum / squares } else { 0.0 },
            opposite,
        };
        (slice, check)
    }

    /// Index and thickness, texels, of every film, topmost first.
    fn thicknesses(&self) -> Vec<(f64, f64)> {
        let texel_um = self.texel_mm * 1e3;
        let films = self.model.composition().films.iter().rev();
        films.map(|film| (film.index, film.thickness_um / texel_um)).collect()
    }

    fn smooth(&self) -> Result<TabulatedBrdf> {
        let [theta, phi] = SMOOTH_RESOLUTION;
        TabulatedBrdf::from_fn(theta, phi, |wi, wo| self.model.brdf_rgb(wi, wo))
    }

    fn provenance(&self, checks: &[SliceCheck]) -> serde_json::Value {
        let tested: Vec<f64> =
            checks.iter().filter(|c| c.effective_flakes >= TESTED_FLAKES).map(SliceCheck::z).collect();
        let rms = (tested.iter().map(|z| z * z).sum::<f64>() / tested.len() as f64).sqrt();
        let opposite: Vec<OppositeView> = checks.iter().map(|c| c.opposite).collect();
        let grid = &self.options.grid;
        json!({
            "tool": "carpaint simulate",
            "version": env!("CARGO_PKG_VERSION"),
            "model": self.model.kind(),
            "seed": self.options.seed,
            "composition": self.model.composition(),
            "flakes": self.films.iter().flatten().map(|kind| kind.flakes.flakes.len()).collect::<Vec<_>>(),
            "check": {
                "what": "luminance of the slice means against the model, in standard errors",
                "slices": tested.len(),
                "rms_z": rms.is_finite().then_some(rms),
                "max_abs_z": tested.iter().fold(0.0f64, |m, z| m.max(z.abs())),
                "phi_d": phi_d_error(self.model, grid),
                "parallax": self.options.parallax.then(|| ParallaxError::new(&opposite, grid)),
            },
        })
    }
}

fn texel_size(composition: &Composition, options: &SynthesisOptions) -> Result<f64> {
    let texels = options.grid.len().saturating_mul(options.size[0]).saturating_mul(options.size[1]);
    if options.size.iter().any(|n| !(1..=FlakeBtf::MAX_SIDE).contains(n)) || texels > FlakeBtf::MAX_TEXELS {
        let found = format!("{} slices of {} x {}", options.grid.len(), options.size[0], options.size[1]);
        let legal = format!("sides of 1 to {}, {} texels in all", FlakeBtf::MAX_SIDE, FlakeBtf::MAX_TEXELS);
        return Err(Error::invalid("synthesis", "size", found, legal));
    }
    let area = composition.area_density();
    let mean_um = composition.flakes().map(|kind| kind.area_density * kind.diameter_um).sum::<f64>() / area;
    let texel_mm = options.texel_mm.unwrap_or(mean_um * 1e-3 / FLAKE_TEXELS);
    if texel_mm > 0.0 && texel_mm.is_finite() {
        return Ok(texel_mm);
    }
    let found = options.texel_mm.map_or("none given".into(), |mm| mm.to_string());
    let legal = "a positive number, which only flakes make optional";
    Err(Error::invalid("synthesis", "texel size, mm", found, legal))
}

/// The flakes of every film, bottom to top; kinds are numbered through all films.
fn draw_films(
    composition: &Composition,
    optics: &PaintOptics,
    options: &SynthesisOptions,
    texel_um: f64,
) -> Result<Vec<Vec<DrawnKind>>> {
    let expected = composition.flakes().map(|kind| Flakes::expected(kind, options.size, texel_um)).sum();
    Flakes::check_number(expected)?;
    let mut number = 0..;
    let mut films = Vec::with_capacity(composition.films.len());
    for (n, (film, seen)) in composition.films.iter().zip(&optics.films).enumerate() {
        let mut kinds = Vec::with_capacity(film.flakes.len());
        for (k, (kind, seen)) in film.flakes.iter().zip(&seen.kinds).enumerate() {
            let lobe = seen.lobe.ok_or_else(|| {
                let place = format!("film[{n}]: flakes[{k}]");
                let legal = "0.1 to 90 to draw flakes";
                Error::invalid(place, "flake_lifetime_deg", kind.flake_lifetime_deg, legal)
            })?;
            let stream = (options.seed, number.next().unwrap_or(u32::MAX));
            let flakes = Flakes::draw(
                kind,
                &seen.orientation,
                seen.optics.class_weights(),
                options.size,
                texel_um,
                stream,
            )?;
            kinds.push(DrawnKind { flakes, lobe });
        }
        films.push(kinds);
    }
    Ok(films)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Flakes under flakes, behind a clear film that takes light on the way.
    const TWO_LAYERS: &str = "substrate = { albedo = 0.5 }\n\
        [[film]]\nthickness_um = 15\nindex = 1.5\nabsorption_per_mm = 10\n\
        [[film.flakes]]\narea_density = 1.5\ndiameter_um = 20\nsigma_deg = 12\nflake_lifetime_deg = 9\n\
        mirror = { reflectance = [[380, 0.9], [780, 0.3]], transmittance = 0.1 }\n\
        [[film]]\nthickness_um = 20\nindex = 1.3\nabsorption_per_mm = [[380, 40], [780, 5]]\n\
        [[film]]\nthickness_um = 10\nindex = 1.6\n\
        [[film.flakes]]\narea_density = 0.3\ndiameter_um = 15\nsigma_deg = 15\nflake_lifetime_deg = 9\n\
        mirror = { reflectance = 0.5, transmittance = 0.5 }\n\
        [[film.flakes]]\narea_density = 0.1\ndiameter_um = 15\nsigma_deg = 20\nflake_lifetime_deg = 9\n\
        stack = [{ index = 2.3, thickness_nm = 90, thickness_spread = 0.15 }]\n";

    #[test]
    fn texels_average_to_the_glitter_of_all_films() {
        let model = Model::flakes_alone(&Composition::parse(TWO_LAYERS).unwrap()).unwrap();
        let grid = AngleGrid::new(6, vec![3, 3, 3]).unwrap();
        let (mut chi2, mut count) = (0.0, 0.0);
        for seed in 1..=8 {
            let base = SynthesisOptions::new(grid.clone());
            let options = SynthesisOptions { size: [256; 2], texel_mm: Some(0.012), seed, ..base };
            let synthesis = Synthesis::new(&model, &options).unwrap();
            for slice in 0..grid.len() {
                let (made, check) = synthesis.checked_slice(slice);
                assert!(check.effective_flakes > 50.0, "{slice}: {}", check.effective_flakes);
                // One in ten thousand beyond four, 72 scores.
                assert!(check.z().abs() < 4.0, "seed {seed} slice {slice}: {}", check.z());
                let texels = || made.fluctuation.iter().map(|t| luminance(DVec3::from(t.map(f64::from))));
                let mean = texels().sum::<f64>() / 65536.0;
                let peak = texels().fold(0.0, f64::max);
                // The score is that of the texels: covered shares and texels are f32.
                assert!((mean - check.mean_error).abs() < 1e-6 * peak, "{mean} {}", check.mean_error);
                if slice < 3 {
                    chi2 += check.z().powi(2);
                    count += 1.0;
                }
            }
        }
        // Slices 15 degrees of theta_h apart show other flakes: 24 independent squares of a normal variable, whose sum lies
        // in here with probability 0.998.
        assert!(count == 24.0 && (8.1..52.7).contains(&chi2), "{chi2} of {count}");
    }

    #[test]
    fn what_lies_above_dims_and_bends() {
        // A film of index 1.5 under itself is one film: the same flakes on the same light.
        let film = |thickness: f64, area: f64| {
            let flakes = format!(
                "[[film.flakes]]\narea_density = {area}\ndiameter_um = 20\nsigma_deg = 12\nmirror = {{ reflectance = 0.6 }}\n"
            );
            format!("[[film]]\nthickness_um = {thickness}\nindex = 1.5\nabsorption_per_mm = 30\n{flakes}")
        };
        let model = |films: &[String]| {
            let text = format!("substrate = {{ albedo = 0.5 }}\n{}", films.concat());
            Model::flakes_alone(&Composition::parse(&text).unwrap()).unwrap()
        };
        let (one, two) = (model(&[film(20.0, 1.0)]), model(&[film(5.0, 0.25), film(15.0, 0.75)]));
        let (wi, wo) = directions(0.2, 0.7, 1.1);
        let [a, b] = [&one, &two].map(|m| luminance(m.glitter(wi, wo).linear_rgb()));
        // Extinction is tabulated to 1e-10 of its peak.
        assert!((a / b - 1.0).abs() < 1e-8, "{a} {b}");
    }
}
