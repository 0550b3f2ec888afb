//! Ershov, Khodulev & Kolchin 1999, Simulation of Sparkles in Metallic Paints.

mod distance;

use crate::Figure;

pub const FIGURES: &[Figure] = &[distance::FIGURE];
