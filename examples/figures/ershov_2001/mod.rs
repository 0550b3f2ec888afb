//! Ershov, Kolchin & Myszkowski 2001, Rendering Pearlescent Appearance Based On Paint-Composition Modelling.

mod figure_2;
mod figure_3;
mod figure_4;
mod figure_5;
mod figure_6;
mod figure_7;

use crate::Figure;

pub const FIGURES: &[Figure] = &[
    figure_2::FIGURE,
    figure_3::FIGURE,
    figure_4::FIGURE,
    figure_5::FIGURE,
    figure_6::FIGURE,
    figure_7::FIGURE,
];
