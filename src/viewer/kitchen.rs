//! A composition being edited: its fast paint at once, its whole one behind that.

use super::job::Job;
use super::recipe::{Sizes, preview, simulated};
use super::shelf::Ready;
use crate::color::{BANDS, Spectrum, reflectance_of_rgb};
use crate::error::{Error, Result};
use crate::file::write_text;
use crate::simulate::Composition;
use crate::simulate::composition::{Film, FlakeKind, MieSpheres, Mirror, Pigment};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Compositions to begin with.
pub const PRESETS: [(&str, &str); 8] = [
    ("silver metallic", include_str!("../../fixtures/compositions/silver_metallic.toml")),
    ("blue metallic", include_str!("../../fixtures/compositions/blue_metallic.toml")),
    ("brown metallic", include_str!("../../fixtures/compositions/brown_metallic.toml")),
    ("pearl on black", include_str!("../../fixtures/compositions/pearl_on_black.toml")),
    ("pearl on white", include_str!("../../fixtures/compositions/pearl_on_white.toml")),
    ("green-blue flip-flop", include_str!("../../fixtures/compositions/green_blue_flip_flop.toml")),
    ("two flake layers", include_str!("../../fixtures/compositions/two_flake_layers.toml")),
    ("solid red", include_str!("../../fixtures/compositions/solid_red.toml")),
];

/// A composition must stay as it is for so long before the full model begins.
const REST: Duration = Duration::from_millis(400);

/// What is known of the paint on show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stage {
    /// Nothing yet.
    #[default]
    Nothing,
    /// The fast model's mean, no flakes.
    Fast,
    /// The full model, flakes included.
    Full,
}

/// The composition and what is made of it.
#[derive(Default)]
pub struct Kitchen {
    /// None before one is chosen or opened.
    pub composition: Option<Composition>,
    /// Where to save it.
    pub file: String,
    /// What is on show.
    pub stage: Stage,
    /// Why the composition is not feasible.
    pub problem: Option<String>,
    /// Where it leaves what the model assumes.
    pub warnings: Vec<String>,
    /// From the last edit to the picture of the fast model, and to that of the full one.
    pub times: [Option<Duration>; 2],
    /// When it was edited last, until its picture is there.
    edited: Option<Instant>,
    /// Whether the last edit waits for a job.
    waits: bool,
    fast: Option<Job<Arc<Ready>>>,
    full: Option<Job<Arc<Ready>>>,
    /// Whether the paint on show awaits its picture.
    unseen: bool,
}

impl Kitchen {
    /// Takes a composition to edit.
    pub fn open(&mut self, composition: Composition, name: &str) {
        self.composition = Some(composition);
        self.file = format!("{name}.toml");
        self.stage = Stage::Nothing;
        self.edited();
    }

    /// Tells that the composition was changed.
    pub fn edited(&mut self) {
        let Some(composition) = &self.composition else { return };
        self.problem = composition.validate().err().map(|e| e.to_string());
        self.warnings = composition.warnings().unwrap_or_default();
        self.edited = Some(Instant::now());
        self.waits = true;
        self.times = [None; 2];
        // What it would come to is out of date.
        self.full = None;
    }

    /// Starts what is due and takes what is done; a new paint, if there is one. `wake` is called when there will be more.
    pub fn step<W: Fn() + Send + Sync + 'static>(
        &mut self,
        wake: impl Fn() -> W,
    ) -> Option<Result<Arc<Ready>>> {
        let mut made = None;
        if let Some(result) = self.fast.as_ref().and_then(Job::poll) {
            self.fast = None;
            made = Some(self.take(result, Stage::Fast));
        }
        if let Some(result) = self.full.as_ref().and_then(Job::poll) {
            self.full = None;
            made = Some(self.take(result, Stage::Full));
        }
        let Some(composition) = self.composition.as_ref().filter(|_| self.problem.is_none()) else {
            return made;
        };
        if self.waits && self.fast.is_none() {
            self.waits = false;
            let composition = composition.clone();
            self.fast = Some(Job::start(wake(), move |progress| {
                let _tick = progress.begin("fast model", 1);
                Ready::new(&preview(&composition)?)
            }));
        } else if self.is_due() {
            let composition = composition.clone();
            self.full = Some(Job::start(wake(), move |progress| {
                Ready::new(&simulated("composition", &composition, Sizes::QUICK, progress)?)
            }));
        }
        made
    }

    /// Whether the full model should begin.
    fn is_due(&self) -> bool {
        let rested = self.edited.is_none_or(|edited| edited.elapsed() >= REST);
        self.stage == Stage::Fast && !self.waits && self.fast.is_none() && self.full.is_none() && rested
    }

    /// Whether the full model only waits for the hand to rest.
    pub fn is_resting(&self) -> Option<Duration> {
        let due = self.stage == Stage::Fast && self.fast.is_none() && self.full.is_none();
        due.then(|| REST.saturating_sub(self.edited.map_or(REST, |edited| edited.elapsed())))
    }

    fn take(&mut self, result: Result<Arc<Ready>>, stage: Stage) -> Result<Arc<Ready>> {
        // A failure is not tried again before the next edit.
        self.stage = stage;
        self.unseen = result.is_ok();
        result
    }

    /// Tells that a picture of the paint on show was drawn.
    pub fn seen(&mut self) {
        if std::mem::take(&mut self.unseen) {
            let time = self.edited.map(|edited| edited.elapsed());
            match self.stage {
                Stage::Nothing => {}
                Stage::Fast => self.times[0] = time,
                Stage::Full => self.times[1] = time,
            }
        }
    }

    /// Work under way.
    pub fn progress(&self) -> Option<(String, f32)> {
        self.full.as_ref().or(self.fast.as_ref()).map(Job::progress)
    }

    /// Writes the composition as TOML.
    ///
    /// # Errors
    /// Nothing to write, an illegal composition, those of the file system.
    pub fn save(&self) -> Result<String> {
        let Some(composition) = &self.composition else {
            return Err(Error::invalid("save composition", "composition", "none", "an open one"));
        };
        let path = Path::new(self.file.trim());
        composition.validate().map_err(|e| e.in_file(path))?;
        let text = toml::to_string(composition).map_err(|e| {
            Error::invalid(path.display().to_string(), "composition", e, "one that TOML can hold")
        })?;
        write_text(path, &text)?;
        Ok(format!("saved {}", path.display()))
    }
}

/// Mean over the wavelengths.
pub fn mean(spectrum: &Spectrum) -> f64 {
    spectrum.0.iter().sum::<f64>() / BANDS as f64
}

/// Brings the mean to `value`, the shape kept, no band above `most`; what was 0 everywhere becomes constant.
pub fn set_mean(spectrum: &mut Spectrum, value: f64, most: f64) {
    let now = mean(spectrum);
    *spectrum = match now > 0.0 {
        true => Spectrum(spectrum.0.map(|v| (v * value / now).min(most))),
        false => Spectrum::constant(value.min(most)),
    };
}

/// Absorption that leaves a color of white light, linear Rec.709, its mean kept: by the exponential law of the flattest
/// reflectance of that color.
///
/// # Errors
/// A color that no reflectance has.
pub fn tinted(absorption: &Spectrum, color: [f32; 3]) -> Result<Spectrum> {
    // Within what reflectances reach.
    let color = DVec3::from(color.map(f64::from)).clamp(DVec3::splat(0.02), DVec3::splat(0.98));
    let passed = reflectance_of_rgb(color)?;
    let mut tint = Spectrum(passed.0.map(|t| -t.max(1e-6).ln()));
    set_mean(&mut tint, mean(absorption), 1e6);
    Ok(tint)
}

/// A film to begin with, above the others: clear.
pub fn new_film() -> Film {
    let absorption_per_mm = Spectrum::constant(0.0);
    Film { thickness_um: 15.0, index: 1.5, absorption_per_mm, flakes: Vec::new(), pigments: Vec::new() }
}

/// A kind of flakes to begin with: aluminium.
pub fn new_flakes() -> FlakeKind {
    let mirror = Mirror { reflectance: Spectrum::constant(0.8), transmittance: Spectrum::constant(0.0) };
    FlakeKind {
        area_density: 0.4,
        diameter_um: 18.0,
        diameter_spread: 0.3,
        sigma_deg: Some(7.0),
        tilts: None,
        flake_lifetime_deg: 6.5,
        mirror: Some(mirror),
        stack: None,
    }
}

/// A pigment to begin with: a little titanium dioxide.
pub fn new_pigment() -> Pigment {
    let material = Some("TiO2-rutile".to_owned());
    let mie = MieSpheres { volume_fraction: 0.01, radius_um: 0.12, material, index: None, extinction: None };
    Pigment { mie: Some(mie), rayleigh: None, henyey_greenstein: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn presets() -> impl Iterator<Item = Composition> {
        PRESETS.iter().map(|(_, text)| Composition::parse(text).unwrap())
    }

    #[test]
    fn what_is_saved_is_what_was_edited() {
        let folder = tempfile::tempdir().unwrap();
        for mut composition in presets() {
            let film = &mut composition.films[0];
            film.thickness_um = 21.0;
            film.absorption_per_mm = tinted(&Spectrum::constant(10.0), [0.8, 0.2, 0.1]).unwrap();
            composition.films.push(new_film());
            composition.films[0].flakes.push(new_flakes());
            composition.films[0].pigments.push(new_pigment());
            let file = folder.path().join("c.toml");
            let mut kitchen = Kitchen::default();
            kitchen.open(composition.clone(), "c");
            assert_eq!(kitchen.problem, None);
            kitchen.file = file.display().to_string();
            kitchen.save().unwrap();
            let back = Composition::read(&file).unwrap();
            assert_eq!(back.films[0].thickness_um, 21.0);
            for (a, b) in back.films.iter().zip(&composition.films) {
                // Knots of the bands themselves, interpolated at them.
                let pairs = a.absorption_per_mm.0.iter().zip(&b.absorption_per_mm.0);
                assert!(pairs.clone().all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs()));
                assert_eq!((a.flakes.len(), a.pigments.len()), (b.flakes.len(), b.pigments.len()));
            }
        }
    }

    #[test]
    fn what_is_not_feasible_is_said_and_not_made() {
        let mut kitchen = Kitchen::default();
        let mut composition = presets().next().unwrap();
        composition.films[0].thickness_um = -1.0;
        kitchen.open(composition, "bad");
        assert!(kitchen.problem.as_ref().is_some_and(|p| p.contains("thickness_um")));
        assert!(kitchen.step(|| || ()).is_none() && kitchen.progress().is_none());
        assert!(kitchen.save().is_err());
    }

    #[test]
    fn the_fast_paint_comes_first_and_the_full_one_after_it() {
        let mut kitchen = Kitchen::default();
        kitchen.open(presets().next().unwrap(), "silver");
        let mut stages = Vec::new();
        while stages.len() < 2 {
            if let Some(made) = kitchen.step(|| || ()) {
                let flakes = made.unwrap().paint.flakes.is_some();
                kitchen.seen();
                stages.push((kitchen.stage, flakes));
            }
            std::thread::yield_now();
        }
        assert_eq!(stages, [(Stage::Fast, false), (Stage::Full, true)]);
        assert!(kitchen.times.iter().all(Option::is_some));
    }

    #[test]
    fn a_tint_keeps_the_mean_and_takes_what_the_color_lacks() {
        let red = tinted(&Spectrum::constant(30.0), [0.9, 0.1, 0.1]).unwrap();
        assert!((mean(&red) - 30.0).abs() < 1e-9);
        let blue_end = red.0[..10].iter().sum::<f64>();
        let red_end = red.0[25..35].iter().sum::<f64>();
        assert!(blue_end > 5.0 * red_end, "{blue_end} {red_end}");
        let mut spectrum = Spectrum::constant(0.0);
        set_mean(&mut spectrum, 0.4, 1.0);
        assert_eq!(spectrum, Spectrum::constant(0.4));
    }
}
