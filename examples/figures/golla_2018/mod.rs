//! Golla & Klein 2018, Interactive Interpolation of Metallic Effect Car Paints.

mod figure_1;
mod figure_3;
mod figure_4;
mod figure_5;
mod figure_6;
mod figure_7;
mod figure_8;
mod look;

use crate::Figure;

pub const FIGURES: &[Figure] = &[
    figure_1::FIGURE,
    figure_3::FIGURE,
    figure_4::FIGURE,
    figure_5::FIGURE,
    figure_6::FIGURE,
    figure_7::FIGURE,
    figure_8::FIGURE,
];

const BLUE: &str = "blue_metallic";
const BROWN: &str = "brown_metallic";
const GRAY: &str = "silver_metallic";
