//! What a file is opened as: by its name, and where that says too little, by what is in it.

use crate::error::{Error, Result};
use crate::file::{Container, ContainerReader, open, read_text};
use crate::scene::Scene;
use crate::simulate::Composition;
use crate::{mix, paint};
use std::path::Path;

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A paint or a mix: `.paint.exr`, and whatever has another name than the others.
    Paint,
    /// `.toml` with layers of paint.
    Composition,
    /// `.toml` with what is in a picture besides the paint.
    Scene,
    /// An equirectangular picture: `.hdr`, and `.exr` that does not say `.paint.exr`.
    Surroundings,
    /// `.glb`, `.gltf`, `.obj`.
    Mesh,
    /// `.png`, `.jpg`, `.jpeg`: an image to be printed.
    Image,
}

/// Keys of compositions and of scenes.
const COMPOSITION: [&str; 4] = ["title", "substrate", "film", "surface"];
const SCENE: [&str; 8] =
    ["size", "exposure_stops", "background", "camera", "shape", "environment", "light", "object"];

/// Largest text, bytes, as of compositions and scenes.
const MAX_BYTES: u64 = 1 << 20;

impl Kind {
    /// By the name's end, in any case, and by the keys of a `.toml`.
    ///
    /// # Errors
    /// Those of reading a `.toml`; one whose keys are of neither kind.
    pub fn of(file: &Path) -> Result<Self> {
        let name = file.to_string_lossy().to_ascii_lowercase();
        let ends = |suffixes: &[&str]| suffixes.iter().any(|suffix| name.ends_with(suffix));
        Ok(if ends(&[".paint.exr", ".btf.exr"]) {
            Self::Paint
        } else if ends(&[".toml"]) {
            of_text(&read_text(file, MAX_BYTES)?).map_err(|e| e.in_file(file))?
        } else if ends(&[".hdr", ".exr"]) {
            Self::Surroundings
        } else if ends(&[".glb", ".gltf", ".obj"]) {
            Self::Mesh
        } else if ends(&[".png", ".jpg", ".jpeg"]) {
            Self::Image
        } else {
            Self::Paint
        })
    }

    /// Looks whether a file can be what it is opened as, without reading all of it: texts as a whole, of containers the headers,
    /// of other files that they are there.
    ///
    /// # Errors
    /// What is wrong with it so far.
    pub fn check(file: &Path) -> Result<Self> {
        let kind = Self::of(file)?;
        match kind {
            Self::Paint => check_kind(ContainerReader::open(file)?.kind()).map_err(|e| e.in_file(file))?,
            Self::Composition => drop(Composition::read(file)?),
            Self::Scene => drop(Scene::read(file)?),
            Self::Surroundings | Self::Mesh | Self::Image => drop(open(file)?),
        }
        Ok(kind)
    }
}

/// Whether a container's JSON says that it holds a paint or a mix.
///
/// # Errors
/// It holds something else.
pub fn check_kind(kind: &str) -> Result<()> {
    if [paint::KIND, mix::KIND].contains(&kind) {
        return Ok(());
    }
    Err(Error::invalid("", "kind of file", kind, format!("{} or {}", paint::KIND, mix::KIND)))
}

/// Whether a container holds a mix.
pub fn is_mix(container: &Container) -> bool {
    container.kind() == mix::KIND
}

fn of_text(text: &str) -> Result<Kind> {
    let legal = format!("a composition ({}) or a scene ({})", COMPOSITION.join(", "), SCENE.join(", "));
    let table: toml::Table = toml::from_str(text)
        .map_err(|e| Error::invalid("", "TOML", e.to_string().trim_end(), legal.clone()))?;
    let count = |keys: &[&str]| table.keys().filter(|key| keys.contains(&key.as_str())).count();
    match count(&COMPOSITION).cmp(&count(&SCENE)) {
        std::cmp::Ordering::Greater => Ok(Kind::Composition),
        std::cmp::Ordering::Less => Ok(Kind::Scene),
        std::cmp::Ordering::Equal => {
            let keys: Vec<&str> = table.keys().take(8).map(String::as_str).collect();
            let found =
                if keys.is_empty() { "no keys".to_owned() } else { format!("keys {}", keys.join(", ")) };
            Err(Error::invalid("", "kind of file", found, legal))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_a_file_is() {
        for (name, kind) in [
            ("a/b.paint.exr", Kind::Paint),
            ("B.PAINT.EXR", Kind::Paint),
            ("x", Kind::Paint),
            ("studio.exr", Kind::Surroundings),
            ("studio.HDR", Kind::Surroundings),
            ("car.glb", Kind::Mesh),
            ("car.obj", Kind::Mesh),
            ("photo.JPG", Kind::Image),
        ] {
            assert_eq!(Kind::of(Path::new(name)).unwrap(), kind, "{name}");
        }
    }

    #[test]
    fn texts_are_told_apart_by_their_keys() {
        let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures");
        for (folder, kind) in [("compositions", Kind::Composition), ("scenes", Kind::Scene)] {
            for file in std::fs::read_dir(format!("{fixtures}/{folder}")).unwrap() {
                let file = file.unwrap().path();
                if file.extension().is_some_and(|e| e == "toml") {
                    assert_eq!(Kind::of(&file).unwrap(), kind, "{}", file.display());
                }
            }
        }
        for text in ["", "color = 1", "film = 1\nlight = 1", "[camera"] {
            let message = of_text(text).unwrap_err().to_string();
            assert!(message.contains("substrate") && message.contains("camera"), "{message}");
        }
    }

    #[test]
    fn files_that_cannot_be_opened_are_found_out_by_a_look() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str, text: &str| {
            let file = folder.path().join(name);
            std::fs::write(&file, text).unwrap();
            file
        };
        for (file, word) in [
            (at("bad.paint.exr", "no such thing"), "EXR"),
            (at("c.toml", "film = []\n[substrate]\nalbedo = 0.1\n"), "films"),
            (at("s.toml", "[camera]\nposition = 1\n"), "position_mm"),
            (folder.path().join("none.hdr"), "none.hdr"),
            (folder.path().join("none.toml"), "none.toml"),
            (concat!(env!("CARGO_MANIFEST_DIR"), "/src").into(), "folder"),
        ] {
            let message = Kind::check(&file).unwrap_err().to_string();
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            assert!(message.contains(word) && message.contains(&name), "{message}");
        }
    }
}
