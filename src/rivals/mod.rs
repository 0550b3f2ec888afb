//! What else a flake BTF can be compressed by (Rump et al. 2008, section 6), to compare statistics with: principal components
//! of its slices, and patches of a small piece of them. Both stand for the fluctuations alone; means are the smooth part's. And the quantizers that could
//! find the clusters of a slice.

mod patches;
mod pca;
mod quantizers;

pub use patches::Patches;
pub use pca::{Grouping, Images, Pca};
pub use quantizers::{k_means, wu};
