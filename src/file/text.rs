//! Files on the way in: regular ones only, and no more of a text than its reader can use.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Opens a regular file and says how many bytes it has.
///
/// # Errors
/// Those of the file system; a folder or a special file.
pub fn open(path: &Path) -> Result<(File, u64)> {
    // Asked before opening: to open a named pipe waits for its writer.
    let meta = std::fs::metadata(path).map_err(|e| Error::io(path, e))?;
    if !meta.is_file() {
        let found = if meta.is_dir() { "a folder" } else { "a special file" };
        return Err(Error::invalid(path.display().to_string(), "input", found, "a file"));
    }
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    Ok((file, meta.len()))
}

/// Reads a text of up to `max_bytes` bytes.
///
/// # Errors
/// Those of [`open`]; a longer file; one that is not UTF-8 (the first bad byte named).
pub fn read_text(path: &Path, max_bytes: u64) -> Result<String> {
    let (file, length) = open(path)?;
    let mut bytes = Vec::new();
    // The length may be 0 (/proc) or change meanwhile: what counts is what can be read.
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    if bytes.len() as u64 > max_bytes {
        let found = length.max(bytes.len() as u64);
        let legal = format!("up to {max_bytes}");
        return Err(Error::invalid(path.display().to_string(), "number of bytes", found, legal));
    }
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let place = format!("{}: byte {at}", path.display());
        Error::invalid(place, "text", format!("{:#04x}", e.as_bytes()[at]), "UTF-8")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_up_to_the_cap() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        std::fs::write(&path, "größe").unwrap();
        assert_eq!(read_text(&path, 7).unwrap(), "größe");
        let message = read_text(&path, 6).unwrap_err().to_string();
        assert!(message.ends_with("a.toml: number of bytes: found 7, expected up to 6"), "{message}");
        std::fs::write(&path, b"key = \"\xe4\"").unwrap();
        let message = read_text(&path, 99).unwrap_err().to_string();
        assert!(message.ends_with("a.toml: byte 7: text: found 0xe4, expected UTF-8"), "{message}");
        let message = read_text(folder.path(), 99).unwrap_err().to_string();
        assert!(message.ends_with("input: found a folder, expected a file"), "{message}");
        assert!(read_text(&folder.path().join("none"), 99).is_err());
    }
}
