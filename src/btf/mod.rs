//! The flake BTF: a grid of angle pairs, and a signed RGB texture for each.

#[cfg(feature = "files")]
pub mod axf;
mod cell_set;
#[cfg(feature = "files")]
mod file;
mod flake_btf;
mod grid;
mod mip;
#[cfg(feature = "files")]
mod reader;
mod source;

#[cfg(feature = "files")]
pub use axf::AxfFolder;
pub use cell_set::CellSet;
#[cfg(feature = "files")]
pub use file::{BtfWriter, KIND};
pub use flake_btf::{FlakeBtf, FlakeSlice};
pub use grid::AngleGrid;
pub use mip::{half, half_of, level_count};
#[cfg(feature = "files")]
pub use reader::BtfReader;
pub use source::FlakeSource;
