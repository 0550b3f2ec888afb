//! Files: whole or not at all on the way out, capped and checked on the way in.

#[cfg(feature = "files")]
mod atomic;
#[cfg(feature = "files")]
mod container;
#[cfg(feature = "files")]
mod container_reader;
#[cfg(feature = "files")]
mod container_writer;
#[cfg(feature = "files")]
mod mesh;
#[cfg(feature = "files")]
mod picture;
#[cfg(feature = "files")]
mod print_image;
mod text;
mod triangles;

#[cfg(feature = "files")]
pub use atomic::{
    check_output, check_output_apart, check_output_folder, place, write_atomically, write_text,
};
#[cfg(feature = "files")]
pub use container::{Channel, Container, Part, Samples};
#[cfg(feature = "files")]
pub use container_reader::ContainerReader;
#[cfg(feature = "files")]
pub use container_writer::ContainerWriter;
#[cfg(feature = "files")]
pub use mesh::read_mesh;
#[cfg(feature = "files")]
pub use picture::{PictureFormat, read_panorama, read_picture, write_picture_exr, write_png};
#[cfg(feature = "files")]
pub use print_image::read_print_image;
pub use text::{open, read_text};
pub use triangles::Triangles;

use crate::error::{Error, Result};
use serde_json::Value;

/// Checks `kind` and `version` of a container's JSON before anything else is read from it.
///
/// # Errors
/// Another kind, or a version newer than `version`.
pub fn check_kind(meta: &Value, kind: &str, version: u64) -> Result<()> {
    let found = meta.get("kind").and_then(Value::as_str).unwrap_or("none");
    if found != kind {
        return Err(Error::invalid("attribute carpaint", "kind of file", found, kind));
    }
    match meta.get("version").and_then(Value::as_u64) {
        Some(v) if (1..=version).contains(&v) => Ok(()),
        Some(v) => Err(Error::unsupported("attribute carpaint", "version", v, format!("1 to {version}"))),
        None => Err(Error::invalid("attribute carpaint", "version", "none", format!("1 to {version}"))),
    }
}
