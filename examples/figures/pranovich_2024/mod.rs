//! Pranovich, Frisvad, Valyukh, Gooran & Nyström 2024, Empirical BRDF Model for Goniochromatic Materials and Soft Proofing With
//! Reflective Inks.

mod figure_4;
mod figure_5;
mod figure_6;
mod figure_7;
mod figure_8;
mod figure_9;
mod inks;
mod photograph;
mod prints;

use crate::Figure;

pub const FIGURES: &[Figure] = &[
    figure_4::FIGURE,
    figure_5::FIGURE,
    figure_6::FIGURE,
    figure_7::FIGURE,
    figure_8::FIGURE,
    figure_9::FIGURE,
];
