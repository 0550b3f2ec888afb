//! Every file that ever failed (`fixtures/broken`): the reader refuses it and names it, and so does the program, with exit code 2.

use crate::common::carpaint;
use crate::readers::{Reader, named};
use crate::trial::{ALONE, Trial, peak, say};
use std::path::{Path, PathBuf};

fn broken() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/broken")
}

/// Files and their readers, whose names they begin with.
fn files() -> Vec<(&'static Reader, PathBuf)> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(broken()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.file_name().unwrap() != "README.md");
    files.sort();
    let reader = |path: PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap().split("--").next().unwrap().to_owned();
        (named(&name).unwrap_or_else(|| panic!("{}: no reader {name}", path.display())), path)
    };
    files.into_iter().map(reader).collect()
}

/// The command that reads a file of this name beside what the reader's maker left there.
fn command(path: &Path) -> Vec<String> {
    let name = path.file_name().unwrap().to_str().unwrap();
    let file = path.to_str().unwrap().to_owned();
    let out = |name: &str| path.with_file_name(name).to_str().unwrap().to_owned();
    let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect();
    let scene = |key: &str| {
        let toml = out("scene.toml");
        std::fs::write(
            &toml,
            format!(
                "[{key}]\nkind = \"{}\"\npath = \"{name}\"\n",
                if key == "shape" { "mesh" } else { "image" }
            ),
        )
        .unwrap();
        let paint = out("worn.paint.exr");
        (crate::readers::named("paint").unwrap().make)(Path::new(&paint));
        words(&["render", &paint, "--scene", &toml, "--size", "8x8", "--device", "cpu", "-o", &out("x.png")])
    };
    match () {
        () if [".paint.exr", ".mix.exr", ".btf.exr", ".ink.json"].iter().any(|end| name.ends_with(end)) => {
            words(&["inspect", &file])
        }
        () if name.ends_with(".hdr") => scene("environment"),
        () if [".obj", ".glb", ".gltf"].iter().any(|end| name.ends_with(end)) => scene("shape"),
        () if name.ends_with(".jpg") => words(&["halftone", &file, "-o", &out("x.png")]),
        () if [".png", ".exr"].iter().any(|end| name.ends_with(end)) => words(&["compare", &file, &file]),
        () if name.ends_with(".toml") => words(&["simulate", &file]),
        () => words(&["fit", &file, "-o", &out("x.paint.exr")]),
    }
}

#[test]
fn what_ever_failed_is_refused_by_name() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let files = files();
    for (reader, file) in &files {
        let trial = Trial::new(reader);
        let bytes = std::fs::read(file).unwrap();
        let (outcome, memory) = peak(|| trial.read_bytes(&bytes));
        assert_eq!(outcome, Ok(false), "{}", file.display());
        assert!(memory < trial.cap(), "{}: {memory} bytes of memory", file.display());
        let arguments = command(&trial.path);
        let out = carpaint().args(&arguments).output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{}: {arguments:?}: {said}", file.display());
        let name = trial.path.file_name().unwrap().to_str().unwrap();
        assert!(said.contains(name) && !said.contains("panicked"), "{}: {said}", file.display());
    }
    say(&format!("broken: {} files refused", files.len()));
}
