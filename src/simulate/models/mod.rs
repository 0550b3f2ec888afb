//! The mean BRDF of a paint: the fast model, the full solution, the gloss, and the choice between them.

pub mod accuracy;
pub mod bands;
pub mod fast_model;
pub mod full_model;
pub mod gloss;
pub mod model;
pub mod paint_transfer;
pub mod substrate_return;
pub mod transfer;
