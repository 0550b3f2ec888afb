//! What a picture of a print shows, in the parts that are made one of the other.

use super::opened::Image;
use crate::brdf::Ink;
use crate::error::Result;
use crate::proof::Method;
use crate::render::{Look, Paper};
use crate::scene::Scene;
use std::sync::Arc;

/// Everything that a picture's light depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Which dots.
    pub dots: Dots,
    /// Which inks, seen how.
    pub inked: Inked,
    /// What lies beneath.
    pub paper: Paper,
    /// What is seen; its exposure is 0.
    pub scene: Scene,
}

/// What dots depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Dots {
    /// What is printed.
    pub image: Arc<Image>,
    /// How dots are placed.
    pub method: Method,
    /// Dots along a side of a pixel.
    pub cell: usize,
}

/// What inks under a light depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Inked {
    /// The inks for red, green and blue.
    pub inks: Arc<[Ink; 3]>,
    /// Roughness of all of them instead of their own.
    pub roughness: Option<f64>,
    /// How they are seen.
    pub look: Look,
}

impl Inked {
    /// The inks as rough as they are seen.
    ///
    /// # Errors
    /// A roughness outside its range.
    pub fn inks(&self) -> Result<Vec<Ink>> {
        let rough = |ink: Ink| match self.roughness {
            Some(alpha) => ink.with_roughness(alpha).map_err(|e| e.within("roughness")),
            None => Ok(ink),
        };
        self.inks.iter().cloned().map(rough).collect()
    }
}

/// Pictures that the window shows: one, or two of one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// From left to right.
    pub requests: Vec<Request>,
    /// Exposure, stops; none: that of the first picture, see [`Picture::exposure`](crate::render::Picture::exposure).
    pub stops: Option<f64>,
}
