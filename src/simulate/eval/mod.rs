//! Single formulas of the papers, for rows of reference numbers.

pub mod flake_layer;
pub mod rows;
pub mod slab;
