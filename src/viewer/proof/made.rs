//! What is made of a request before anything is rendered: dots and inks, kept as long as what they depend on stays.

use super::request::{Dots, Inked, Request};
use crate::error::Result;
use crate::proof::{Coverage, InkLimit, Separation};
use crate::render::{Paper, Print, PrintInks};
use std::sync::Arc;

/// Seed of what is random in the placement of dots, as of `carpaint proof`.
const SEED: u32 = 1;
/// Inks kept at most: those of two pictures.
const KEPT: usize = 2;

/// A print ready to be rendered.
#[derive(Debug, Clone)]
pub struct Made {
    /// The dots.
    pub coverage: Arc<Coverage>,
    /// The inks.
    pub inks: Arc<PrintInks>,
    /// What lies beneath.
    pub paper: Paper,
}

impl Made {
    /// As renderers take it.
    pub fn print(&self) -> Print<'_> {
        Print { inks: &self.inks, coverage: &self.coverage, paper: self.paper }
    }

    /// Whether it is the very same, which is asked before it is uploaded again.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.coverage, &other.coverage)
            && Arc::ptr_eq(&self.inks, &other.inks)
            && self.paper == other.paper
    }
}

/// Dots and inks of the last requests.
#[derive(Debug, Default)]
pub struct Maker {
    dots: Option<(Dots, Arc<Coverage>)>,
    inks: Vec<(Inked, Arc<PrintInks>)>,
}

impl Maker {
    /// Makes what a request needs and is not there.
    ///
    /// # Errors
    /// An image of which no dots can be made, more dots than there may be; inks that are seen under no light.
    pub fn make(&mut self, request: &Request) -> Result<Made> {
        let coverage = self.coverage(&request.dots)?;
        Ok(Made { coverage, inks: self.inks(&request.inked)?, paper: request.paper })
    }

    fn coverage(&mut self, dots: &Dots) -> Result<Arc<Coverage>> {
        if let Some((made, coverage)) = &self.dots
            && made == dots
        {
            return Ok(coverage.clone());
        }
        let Dots { image, method, cell } = dots;
        let separation = Separation::new(image.size, &image.pixels, InkLimit::default())
            .map_err(|e| e.in_file(&image.path))?;
        let coverage = Arc::new(Coverage::new(method.halftone(&separation, *cell, SEED)?));
        self.dots = Some((dots.clone(), coverage.clone()));
        Ok(coverage)
    }

    fn inks(&mut self, inked: &Inked) -> Result<Arc<PrintInks>> {
        if let Some((_, inks)) = self.inks.iter().find(|(made, _)| made == inked) {
            return Ok(inks.clone());
        }
        let inks = Arc::new(inked.look.inks(&inked.inks()?)?);
        self.inks.truncate(KEPT - 1);
        self.inks.insert(0, (inked.clone(), inks.clone()));
        Ok(inks)
    }
}

#[cfg(test)]
mod tests {
    use super::super::desk::tests::desk;
    use super::super::state::{LampLight, State};
    use super::*;
    use crate::render::InkModel;

    /// What a change of the state has made anew: dots, inks.
    fn anew(change: impl Fn(&mut State)) -> [bool; 2] {
        let mut desk = desk();
        let request = |desk: &super::super::desk::Desk| {
            desk.request(InkModel::Goniochromatic, [8, 6]).unwrap().unwrap()
        };
        let mut maker = Maker::default();
        let before = maker.make(&request(&desk)).unwrap();
        change(&mut desk.state);
        let after = maker.make(&request(&desk)).unwrap();
        [!Arc::ptr_eq(&before.coverage, &after.coverage), !Arc::ptr_eq(&before.inks, &after.inks)]
    }

    #[test]
    fn only_what_depends_on_a_change_is_made_anew() {
        assert_eq!(anew(|state| state.lamp.azimuth_deg += 10.0), [false, false]);
        assert_eq!(anew(|state| state.has_paper = false), [false, false]);
        assert_eq!(anew(|state| state.exposure_stops = 1.0), [false, false]);
        assert_eq!(anew(|state| state.next_shape(false)), [false, false]);
        assert_eq!(anew(|state| state.roughness = 0.5), [false, false], "it is not in use");
        assert_eq!(anew(|state| state.light = LampLight::A), [false, true]);
        assert_eq!(anew(|state| state.own_roughness = false), [false, true]);
        assert_eq!(anew(|state| state.bands = State::BANDS[4]), [false, true]);
        assert_eq!(anew(|state| state.cell = 2), [true, false]);
        assert_eq!(anew(|state| state.method = crate::proof::Method::BlueNoise), [true, false]);
    }

    #[test]
    fn inks_of_two_pictures_are_kept() {
        let desk = desk();
        let mut maker = Maker::default();
        let mut inks = |model| maker.make(&desk.request(model, [8, 6]).unwrap().unwrap()).unwrap().inks;
        let first = inks(InkModel::Goniochromatic);
        let second = inks(InkModel::Schlick);
        assert!(Arc::ptr_eq(&first, &inks(InkModel::Goniochromatic)));
        assert!(Arc::ptr_eq(&second, &inks(InkModel::Schlick)));
    }
}
