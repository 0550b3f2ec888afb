//! Where tests find reference numbers and measured data that are not part of the project.
#![allow(dead_code)]

use std::io::Write;
use std::path::PathBuf;

/// A file or folder below `CARPAINT_REFERENCE`. Without the variable the test is skipped, loudly; with it, a missing file
/// fails the test.
pub fn reference(name: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("CARPAINT_REFERENCE") else {
        // Not eprintln: the test runner would keep it to itself.
        let _ = writeln!(std::io::stderr(), "SKIPPED: {name} not compared: CARPAINT_REFERENCE is not set");
        return None;
    };
    let root = PathBuf::from(root);
    let path = if root.is_relative() { PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(root) } else { root }
        .join(name);
    assert!(path.exists(), "CARPAINT_REFERENCE is set, but {} is missing", path.display());
    Some(path)
}

/// A JSON file below `CARPAINT_REFERENCE`.
pub fn reference_json(name: &str) -> Option<serde_json::Value> {
    let text = std::fs::read_to_string(reference(name)?).expect("readable");
    Some(serde_json::from_str(&text).expect("JSON"))
}

/// The carpaint binary.
pub fn carpaint() -> std::process::Command {
    std::process::Command::new(env!("CARGO_BIN_EXE_carpaint"))
}
