//! The three inks of a print, and which of them another one takes the place of.

use crate::brdf::Ink;
use crate::color::Illuminant;
use crate::error::{Error, Result};
use crate::render::{InkModel, PrintInks, own_inks};
use glam::Vec3;
use std::path::PathBuf;
use std::sync::Arc;

/// What the places are for.
pub const PLACES: [&str; 3] = ["red", "green", "blue"];
/// Where an ink shows its color: mirrored at 20 degrees, as the steepest of the measurements in the paper.
const SEEN_DEG: f32 = 20.0;

/// The inks for red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub struct InkSet(Arc<[Ink; 3]>);

impl InkSet {
    /// Those of these files, or those that come with the program.
    ///
    /// # Errors
    /// Those of reading; another number than three.
    pub fn read(files: Option<&[PathBuf]>) -> Result<Self> {
        let inks = match files {
            Some(files) => files.iter().map(|file| Ink::read(file)).collect::<Result<Vec<_>>>()?,
            None => own_inks()?,
        };
        let inks = <[Ink; 3]>::try_from(inks)
            .map_err(|inks| Error::invalid("--inks", "number of inks", inks.len(), "3"))?;
        Ok(Self(Arc::new(inks)))
    }

    /// The inks, in the order of [`PLACES`].
    pub fn inks(&self) -> &Arc<[Ink; 3]> {
        &self.0
    }

    /// Takes an ink in place of the one whose color it is nearest to; the number of that place.
    ///
    /// # Errors
    /// As [`PrintInks::new`].
    pub fn replace(&mut self, ink: Ink) -> Result<usize> {
        let place = place(&ink)?;
        Arc::make_mut(&mut self.0)[place] = ink;
        Ok(place)
    }
}

/// The place for an ink: the channel of linear Rec.709 in which it is brightest, under D65, near the mirror direction.
fn place(ink: &Ink) -> Result<usize> {
    let light = Illuminant::D65.spectrum();
    let seen = PrintInks::new(std::slice::from_ref(ink), InkModel::Goniochromatic, &light, false)?;
    let (sin, cos) = SEEN_DEG.to_radians().sin_cos();
    let color = seen.reflectance(Vec3::X, Vec3::new(-sin, 0.0, cos), Vec3::new(sin, 0.0, cos));
    Ok(color.max_position())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ink_takes_the_place_of_its_color() {
        let wavelengths = crate::color::Wavelengths::even(41).unwrap();
        let ink = |nm: f64| {
            let rho = wavelengths.nm().iter().map(|w| (-((w - nm) / 40.0).powi(2)).exp()).collect();
            Ink::new(format!("{nm} nm"), 0.2, wavelengths.clone(), rho, vec![0.0; 41]).unwrap()
        };
        let mut set = InkSet::read(None).unwrap();
        for (nm, expected) in [(640.0, 0), (535.0, 1), (450.0, 2)] {
            let before = set.clone();
            assert_eq!(set.replace(ink(nm)).unwrap(), expected);
            assert_eq!(set.inks()[expected].name(), format!("{nm} nm"));
            assert_ne!(before, set);
        }
    }

    #[test]
    fn three_files_make_a_set() {
        let file = |name| PathBuf::from(format!("{}/fixtures/inks/{name}", env!("CARGO_MANIFEST_DIR")));
        let files = PLACES.map(|name| file(format!("{name}.ink.json")));
        assert_eq!(InkSet::read(Some(&files)).unwrap(), InkSet::read(None).unwrap());
        assert!(InkSet::read(Some(&files[..2])).unwrap_err().to_string().contains("--inks"));
        assert!(InkSet::read(Some(&[file("none.ink.json".to_owned())])).is_err());
    }
}
