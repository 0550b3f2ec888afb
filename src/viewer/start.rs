//! What the window starts with, looked at before it opens.

use super::kind::Kind;
use super::weights::BEYOND;
use crate::error::{Error, Result};
use crate::file::ContainerReader;
use crate::mix::{self, Mix};
use std::path::{Path, PathBuf};

/// What the window starts with.
#[derive(Debug, Clone, Default)]
pub struct Start {
    /// A mix, or paints; compositions, scenes, surroundings and meshes beside them. No paint and no composition: a
    /// demonstration is simulated.
    pub files: Vec<PathBuf>,
    /// A scene, whose objects wear the paints.
    pub scene: Option<PathBuf>,
    /// Weights of the paints, one each, -1 to 2, summing to 1; none: equal ones.
    pub weights: Option<Vec<f64>>,
    /// The inks for red, green and blue of a print instead of those that come with the program.
    pub inks: Option<Vec<PathBuf>>,
    /// Part of the name of the adapter to use.
    pub adapter: Option<String>,
    /// Where the places of controls are written, rectangles as JSON.
    pub places: Option<PathBuf>,
    /// After so many pictures the device is taken away, from the first window and the second, to see what comes of it.
    pub lose_device_after: Option<usize>,
    /// After so many pictures the device is taken away when a frame is on its way to the screen.
    pub lose_device_late_after: Option<usize>,
}

impl Start {
    /// The image that is shown as a print; none: paints are shown.
    ///
    /// # Errors
    /// An image with anything that speaks of paints; inks without an image.
    pub fn image(&self) -> Result<Option<&Path>> {
        let is_image = |file: &&PathBuf| matches!(Kind::of(file), Ok(Kind::Image));
        let Some(image) = self.files.iter().find(is_image) else {
            return match &self.inks {
                Some(_) => Err(Error::invalid("--inks", "image", "none", "one that is printed (.png, .jpg)")),
                None => Ok(None),
            };
        };
        if self.files.len() > 1 || self.scene.is_some() || self.weights.is_some() {
            let legal = "an image by itself, with --inks at most";
            return Err(Error::invalid(image.display().to_string(), "kind of file", "image", legal));
        }
        Ok(Some(image))
    }

    /// Looks at the files without reading all of them, so that what is wrong with them is said before a window opens.
    ///
    /// # Errors
    /// No such file, another kind than its name says, a text or headers that cannot be read; a mix among paints, more paints than
    /// can be coupled; illegal weights.
    pub fn check(&self) -> Result<()> {
        let mut paints = Vec::new();
        for file in &self.files {
            if Kind::check(file)? == Kind::Paint {
                paints.push(file);
            }
        }
        if let Some(file) = &self.scene {
            super::staged::Staged::read(file)?;
        }
        let mut mixed = None;
        for file in &paints {
            let reader = ContainerReader::open(file)?;
            if reader.kind() == mix::KIND {
                mixed = reader.meta.get("constituents").and_then(|all| all.as_array()).map(Vec::len);
                if paints.len() > 1 {
                    let legal = "a mix by itself, or paints";
                    return Err(Error::invalid(file.display().to_string(), "kind of file", mix::KIND, legal));
                }
            }
        }
        if paints.len() > *Mix::PAINTS.end() {
            let legal = format!("up to {}", Mix::PAINTS.end());
            return Err(Error::invalid("view", "paints", paints.len(), legal));
        }
        let n = mixed.or_else(|| (!paints.is_empty()).then_some(paints.len()));
        self.weights.as_deref().map_or(Ok(()), |weights| check_weights(weights, n))
    }
}

/// Whether these are weights of `n` paints, or of as many as they are.
///
/// # Errors
/// Another number; a weight beyond those of the window; another sum than 1.
pub fn check_weights(weights: &[f64], n: Option<usize>) -> Result<()> {
    let (low, high) = BEYOND;
    if n.is_some_and(|n| n != weights.len()) {
        let legal = format!("{}, one a paint", n.unwrap_or_default());
        return Err(Error::invalid("--weights", "weights", weights.len(), legal));
    }
    if let Some(weight) = weights.iter().find(|w| !(low..=high).contains(*w)) {
        return Err(Error::invalid("--weights", "weight", weight, format!("{low} to {high}")));
    }
    let sum: f64 = weights.iter().sum();
    // As the mix itself has it.
    if (sum - 1.0).abs() > 1e-5 {
        return Err(Error::invalid("--weights", "sum", sum, "1"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_that_the_window_can_set() {
        check_weights(&[0.25, 0.75], Some(2)).unwrap();
        check_weights(&[-1.0, 2.0], None).unwrap();
        for (weights, n, word) in [
            (&[0.5, 0.5][..], Some(3), "found 2, expected 3"),
            (&[-1.5, 2.5], Some(2), "-1 to 2"),
            (&[0.5, 0.6], Some(2), "sum"),
            (&[f64::NAN, 1.0], Some(2), "NaN"),
        ] {
            let message = check_weights(weights, n).unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("--weights"), "{message}");
        }
    }

    #[test]
    fn an_image_is_shown_by_itself() {
        let start =
            |files: &[&str]| Start { files: files.iter().map(PathBuf::from).collect(), ..Start::default() };
        assert_eq!(start(&["a.png"]).image().unwrap(), Some(Path::new("a.png")));
        assert_eq!(start(&["a.paint.exr", "b.paint.exr"]).image().unwrap(), None);
        let weights = Start { weights: Some(vec![1.0]), ..start(&["a.jpg"]) };
        let inks = Start { inks: Some(Vec::new()), ..start(&["a.paint.exr"]) };
        for (start, word) in [(start(&["a.png", "b.png"]), "by itself"), (weights, "a.jpg"), (inks, "--inks")]
        {
            let message = start.image().unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }

    #[test]
    fn a_look_finds_what_is_wrong_before_a_window_opens() {
        let fixture = |name: &str| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name);
        let scene = Some(fixture("scenes/demo.toml"));
        Start { scene, files: vec![fixture("compositions/solid_red.toml")], ..Start::default() }
            .check()
            .unwrap();
        let scene = Some(fixture("compositions/solid_red.toml"));
        assert!(Start { scene, ..Start::default() }.check().is_err(), "a composition is no scene");
        let files = vec![fixture("scenes/studio.exr"), fixture("none.paint.exr")];
        let message = Start { files, ..Start::default() }.check().unwrap_err().to_string();
        assert!(message.contains("none.paint.exr"), "{message}");
    }
}
