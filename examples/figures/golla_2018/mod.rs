//! Golla & Klein 2018, Interactive Interpolation of Metallic Effect Car Paints.

mod figure_6;

use crate::Figure;

pub const FIGURES: &[Figure] = &[figure_6::FIGURE];
