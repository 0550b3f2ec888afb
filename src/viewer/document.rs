//! What is open: a paint, or several and their mix.

use super::job::Progress;
use super::kind::{check_kind, is_mix};
use crate::error::{Error, Result};
use crate::file::{Container, ContainerReader};
use crate::mix::{CoupleOptions, Mix, couple};
use crate::paint::Paint;
use crate::parallel::TryMap;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A paint and its name.
#[derive(Debug, Clone)]
pub struct NamedPaint {
    /// For people, usually that of the file.
    pub name: String,
    /// The paint.
    pub paint: Arc<Paint>,
}

/// One paint, or the mix of several.
#[derive(Debug, Clone)]
pub struct Document {
    /// The paints, in the order of the weights; at least one.
    pub paints: Vec<NamedPaint>,
    /// Their mix; none of a single paint.
    pub mix: Option<Arc<Mix>>,
}

impl Document {
    /// Paints alone, or coupled where they are several.
    ///
    /// # Errors
    /// None or more than eight paints; paints that cannot be coupled.
    pub fn new(paints: Vec<NamedPaint>, progress: &Progress) -> Result<Self> {
        match paints.len() {
            0 => Err(Error::invalid("view", "paints", "none", "1 to 8")),
            1 => Ok(Self { paints, mix: None }),
            _ => {
                let rows = |p: &Paint| p.flakes.as_ref().map_or(0, |f| f.levels.len() * f.grid.len());
                let tick = progress.begin("coupling", rows(&paints[0].paint) * (paints.len() - 1));
                let named: Vec<_> = paints.iter().map(|p| (p.name.clone(), &*p.paint)).collect();
                let (mix, _) = couple(&named, &CoupleOptions::default(), &tick)?;
                Ok(Self { paints, mix: Some(Arc::new(mix)) })
            }
        }
    }

    /// Reads one mix, or paints that are then coupled; with the paints of `open`, if given, before them.
    ///
    /// # Errors
    /// Those of reading, the file named; a mix among other files; those of [`Document::new`].
    pub fn read(files: &[PathBuf], open: Option<&Self>, progress: &Progress) -> Result<Self> {
        let mut paints = open.map_or_else(Vec::new, |document| document.paints.clone());
        for file in files {
            let container = read(file, progress)?;
            if is_mix(&container) {
                if files.len() > 1 || open.is_some() {
                    let legal = "a mix by itself, or paints";
                    return Err(Error::invalid(file.display().to_string(), "kind of file", "mix", legal));
                }
                return Self::of(Mix::from_container(container).map_err(|e| e.in_file(file))?);
            }
            let paint = check_kind(container.kind()).and_then(|()| Paint::from_container(container));
            let paint = Arc::new(paint.map_err(|e| e.in_file(file))?);
            paints.push(NamedPaint { name: stem(file), paint });
        }
        Self::new(paints, progress)
    }

    /// A mix, with the paints at its corners.
    fn of(mix: Mix) -> Result<Self> {
        let n = mix.constituents.len();
        let corner = |k: usize| {
            let paint = mix.blend(&super::weights::only(k, n))?;
            Ok(NamedPaint { name: mix.constituents[k].name.clone(), paint: Arc::new(paint) })
        };
        let paints = (0..n).map(corner).collect::<Result<_>>()?;
        Ok(Self { paints, mix: Some(Arc::new(mix)) })
    }

    /// What is in the title of the window.
    pub fn title(&self) -> String {
        let names: Vec<&str> = self.paints.iter().map(|p| p.name.as_str()).collect();
        names.join(" \u{00b7} ")
    }
}

/// Reads a container, part by part.
fn read(file: &Path, progress: &Progress) -> Result<Container> {
    let reader = ContainerReader::open(file)?;
    let names: Vec<&str> = reader.names().collect();
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    let tick = progress.begin(&format!("reading {name}"), names.len());
    let part = |name: &&str| {
        let part = reader.part(name)?;
        tick();
        Ok(((*name).to_owned(), part))
    };
    let parts = names.par_iter().try_map(part)?.into_iter().collect();
    Ok(Container { meta: reader.meta.clone(), parts })
}

/// Name of a file without folder and `.paint.exr`.
pub fn stem(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let end = [".paint.exr", ".exr", ".toml"]
        .iter()
        .find(|suffix| name.to_ascii_lowercase().ends_with(*suffix))
        .map_or(name.len(), |suffix| name.len() - suffix.len());
    if end == 0 { name } else { name[..end].to_owned() }
}

#[cfg(test)]
mod tests {
    use super::super::job::Job;
    use super::*;
    use crate::brdf::{ClearCoat, ColorTable};

    fn plain(diffuse: f64) -> Paint {
        let (coat, lobes) = (ClearCoat::NONE, Vec::new());
        let provenance = serde_json::Value::Null;
        Paint { coat, diffuse, lobes, colors: ColorTable::white(), flakes: None, provenance }
    }

    fn read(files: &[PathBuf]) -> Result<Document> {
        let files = files.to_vec();
        let job = Job::start(|| (), move |progress| Document::read(&files, None, progress));
        loop {
            if let Some(result) = job.poll() {
                return result;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn paints_and_mixes_are_read_and_anything_else_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        plain(0.1).write(&at("a.paint.exr")).unwrap();
        plain(0.3).write(&at("b.paint.exr")).unwrap();
        let one = read(&[at("a.paint.exr")]).unwrap();
        assert!(one.mix.is_none() && one.title() == "a");
        let two = read(&[at("a.paint.exr"), at("b.paint.exr")]).unwrap();
        let mix = two.mix.unwrap();
        assert!((mix.blend(&[0.5, 0.5]).unwrap().diffuse - 0.2).abs() < 1e-12);
        mix.write(&at("m.paint.exr")).unwrap();
        let again = read(&[at("m.paint.exr")]).unwrap();
        assert_eq!(again.title(), "a \u{00b7} b");
        assert_eq!(again.paints[1].paint.diffuse, 0.3);
        std::fs::write(at("bad.paint.exr"), b"no such thing").unwrap();
        for (files, word) in [
            (vec![at("bad.paint.exr")], "bad.paint.exr"),
            (vec![at("none.paint.exr")], "none.paint.exr"),
            (vec![at("a.paint.exr"), at("m.paint.exr")], "mix"),
            (vec![], "none"),
        ] {
            let message = read(&files).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }

    #[test]
    fn names_lose_only_what_says_the_kind() {
        for (path, name) in [("x/a.v2.paint.exr", "a.v2"), ("B.EXR", "B"), (".exr", ".exr"), ("c", "c")] {
            assert_eq!(stem(Path::new(path)), name);
        }
    }
}
