//! What every command prints alike, and how: a reader that leaves early (`carpaint inspect x | head -1`) is no error.

use crate::error::{Error, Result};
use serde::Serialize;
use std::fmt::Arguments;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::time::Instant;

/// A line on standard output.
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::output::print(format_args!("{}\n", format_args!($($text)*))) };
}
/// A line on standard error.
macro_rules! note {
    ($($text:tt)*) => { $crate::cli::output::print_error(format_args!("{}\n", format_args!($($text)*))) };
}
pub(super) use {note, say};

/// Text on standard output. A closed pipe ends nothing: the work goes on and its exit code counts. Any other refusal, of a
/// full disk for one, ends the program with exit code 2: what a caller asked for would be missing.
pub fn print(text: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    match out.write_fmt(text).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            note!("error: {}", Error::io("standard output", e));
            std::process::exit(2);
        }
        _ => {}
    }
}

/// Text on standard error; where that is closed there is nobody to tell.
pub fn print_error(text: Arguments<'_>) {
    let _ = std::io::stderr().lock().write_fmt(text);
}

/// A value as indented JSON on standard output.
pub fn json(value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|e| Error::invalid("output", "not representable as JSON", e, "finite numbers"))?;
    say!("{text}");
    Ok(())
}

/// The last line of a command that made a file: on standard error, so that it never mixes with JSON.
pub fn wrote(path: &Path, start: Instant) -> Result<()> {
    let bytes = std::fs::metadata(path).map_err(|e| Error::io(path, e))?.len();
    note!("wrote {} ({}) in {:.2} s", path.display(), size(bytes), start.elapsed().as_secs_f64());
    Ok(())
}

/// Refuses a name that ends in something else, letter case aside.
pub fn require_suffix(option: &str, path: &Path, suffix: &str) -> Result<()> {
    if path.to_string_lossy().to_ascii_lowercase().ends_with(suffix) {
        return Ok(());
    }
    Err(Error::invalid(option, "name", path.display(), format!("one that ends in {suffix}")))
}

/// Bytes for people.
pub fn size(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} B"),
        1024..1_048_576 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
    }
}

/// Name of a file without folder and without `.paint.exr` and the like.
pub fn stem(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let lower = name.to_ascii_lowercase();
    let end = SUFFIXES.iter().find_map(|suffix| lower.strip_suffix(suffix)).map_or(name.len(), str::len);
    // A name that is all suffix has no other name.
    if end == 0 { name } else { name[..end].to_owned() }
}

/// Endings that say what a file is, longer ones first.
const SUFFIXES: [&str; 9] =
    [".paint.exr", ".btf.exr", ".exr", ".mbsdf", ".nbrdf", ".f32", ".toml", ".ink.json", ".csv"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lose_only_what_says_the_kind() {
        for (path, name) in [
            ("a/blue.v2.paint.exr", "blue.v2"),
            ("blue.BTF.EXR", "blue"),
            ("blue_7.5um.mbsdf", "blue_7.5um"),
            ("b.f32", "b"),
            ("x.toml", "x"),
            ("red.ink.json", "red"),
            ("red.csv", "red"),
            ("plain", "plain"),
            (".paint.exr", ".paint.exr"),
            ("bl\u{fc}.exr", "bl\u{fc}"),
        ] {
            assert_eq!(stem(Path::new(path)), name);
        }
    }
}
