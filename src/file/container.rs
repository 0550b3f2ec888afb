//! The one container: an OpenEXR file of named parts, and JSON in one string attribute.
//!
//! Any EXR viewer opens it. Reading is hostile: sizes are capped before anything is allocated, NaN and infinity are
//! refused with part, channel and pixel named.

use super::container_reader::ContainerReader;
use super::container_writer::ContainerWriter;
use super::text::open;
use crate::error::{Error, Result};
use crate::parallel::TryMap;
use exr::prelude::*;
use half::f16;
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Name of the string attribute that holds the JSON.
pub(super) const ATTRIBUTE: &str = "carpaint";

/// Named parts and the JSON that explains them.
#[derive(Debug, Clone, PartialEq)]
pub struct Container {
    /// Everything that is not an array.
    pub meta: Value,
    /// Arrays, by name.
    pub parts: BTreeMap<String, Part>,
}

/// One 2-D array with any number of channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Channels, each with `size[0] * size[1]` row-major samples.
    pub channels: Vec<Channel>,
}

/// One channel of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name, as EXR viewers show it.
    pub name: String,
    /// Row-major samples.
    pub samples: Samples,
}

/// The three sample types of EXR.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// 16-bit float.
    F16(Vec<f16>),
    /// 32-bit float.
    F32(Vec<f32>),
    /// 32-bit unsigned integer.
    U32(Vec<u32>),
}

impl Part {
    /// Largest number of columns or rows.
    pub(super) const MAX_SIDE: usize = 1 << 20;

    /// A part of f32 RGB.
    pub fn rgb(size: [usize; 2], texels: &[[f32; 3]]) -> Self {
        let channels = ["R", "G", "B"]
            .iter()
            .enumerate()
            .map(|(c, name)| Channel::f32(*name, texels.iter().map(|t| t[c]).collect()))
            .collect();
        Self { size, channels }
    }

    /// The f32 samples of a channel (half floats widened).
    ///
    /// # Errors
    /// No such channel, one that does not fill the part, or integers.
    pub fn f32(&self, name: &str) -> Result<Vec<f32>> {
        match &self.channel(name)?.samples {
            Samples::F32(v) => Ok(v.clone()),
            Samples::F16(v) => Ok(v.iter().map(|x| x.to_f32()).collect()),
            Samples::U32(_) => Err(Error::invalid(format!("channel {name}"), "type", "integers", "floats")),
        }
    }

    /// The integer samples of a channel.
    ///
    /// # Errors
    /// No such channel, one that does not fill the part, or floats.
    pub fn u32(&self, name: &str) -> Result<&[u32]> {
        match &self.channel(name)?.samples {
            Samples::U32(v) => Ok(v),
            _ => Err(Error::invalid(format!("channel {name}"), "type", "floats", "32-bit integers")),
        }
    }

    /// The R, G, B channels, interleaved.
    ///
    /// # Errors
    /// A channel is missing or not float.
    pub fn rgb_texels(&self) -> Result<Vec<[f32; 3]>> {
        let [r, g, b] = [self.f32("R")?, self.f32("G")?, self.f32("B")?];
        Ok(r.into_iter().zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect())
    }

    /// # Errors
    /// A sample that is not finite; its channel and pixel are named.
    pub(super) fn check_finite(&self) -> Result<()> {
        for channel in &self.channels {
            if let Some((k, value)) = channel.samples.first_not_finite() {
                let place =
                    format!("channel {}: pixel ({}, {})", channel.name, k % self.size[0], k / self.size[0]);
                return Err(Error::invalid(place, "value", value, "finite numbers"));
            }
        }
        Ok(())
    }

    fn channel(&self, name: &str) -> Result<&Channel> {
        let channel = self.channels.iter().find(|c| c.name == name).ok_or_else(|| {
            let names: Vec<_> = self.channels.iter().map(|c| c.name.as_str()).collect();
            Error::invalid("channels", format!("no channel {name}"), names.join(", "), name)
        })?;
        self.check_length(channel)?;
        Ok(channel)
    }

    pub(super) fn check_length(&self, channel: &Channel) -> Result<()> {
        let expected = self.size[0].saturating_mul(self.size[1]);
        if channel.samples.len() == expected {
            return Ok(());
        }
        let place = format!("channel {}", channel.name);
        Err(Error::invalid(place, "samples", channel.samples.len(), expected.to_string()))
    }
}

impl Channel {
    /// A 32-bit float channel.
    pub fn f32(name: impl Into<String>, samples: Vec<f32>) -> Self {
        Self { name: name.into(), samples: Samples::F32(samples) }
    }

    /// A 32-bit integer channel.
    pub fn u32(name: impl Into<String>, samples: Vec<u32>) -> Self {
        Self { name: name.into(), samples: Samples::U32(samples) }
    }
}

impl Samples {
    fn len(&self) -> usize {
        match self {
            Self::F16(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::U32(v) => v.len(),
        }
    }

    fn first_not_finite(&self) -> Option<(usize, f32)> {
        let find = |x: f32| !x.is_finite();
        match self {
            Self::F16(v) => v.iter().map(|x| x.to_f32()).enumerate().find(|x| find(x.1)),
            Self::F32(v) => v.iter().copied().enumerate().find(|x| find(x.1)),
            Self::U32(_) => None,
        }
    }
}

impl Container {
    /// Largest file read, in decoded bytes.
    pub const MAX_BYTES: usize = 4 << 30;

    /// What the file is, as its JSON says; `none` where it says nothing.
    pub fn kind(&self) -> &str {
        kind(&self.meta)
    }

    /// Whether an EXR file is a container of carpaint, by its headers alone.
    ///
    /// # Errors
    /// No such file, a folder, not an EXR file.
    pub fn is_container(path: &Path) -> Result<bool> {
        let key = Text::from(ATTRIBUTE);
        Ok(headers(path)?.headers.iter().any(|h| h.own_attributes.other.contains_key(&key)))
    }

    /// The part of this name.
    ///
    /// # Errors
    /// There is none.
    pub fn part(&self, name: &str) -> Result<&Part> {
        self.parts.get(name).ok_or_else(|| no_part(name, self.parts.keys()))
    }

    /// Writes the container, losslessly compressed, whole or not at all.
    ///
    /// # Errors
    /// Those of the file system; a channel whose length does not fit its part.
    pub fn write(&self, path: &Path) -> Result<()> {
        let writer = ContainerWriter::new(path);
        let parts: Vec<(&String, &Part)> = self.parts.iter().collect();
        parts.par_iter().try_map(|(name, part)| writer.part(name, part))?;
        writer.finish(&self.meta)
    }

    /// Reads a container.
    ///
    /// # Errors
    /// No such file, a folder, not an EXR file, truncated, larger than [`Container::MAX_BYTES`] decoded, no carpaint
    /// attribute, a sample that is not finite.
    pub fn read(path: &Path) -> Result<Self> {
        let reader = ContainerReader::open(path)?;
        let names: Vec<&str> = reader.names().collect();
        let part = |name: &&str| Ok(((*name).to_owned(), reader.part(name)?));
        let parts = names.par_iter().try_map(part)?.into_iter().collect();
        Ok(Self { meta: reader.meta, parts })
    }
}

fn headers(path: &Path) -> Result<MetaData> {
    let (file, _) = open(path)?;
    MetaData::read_from_unbuffered(file, false).map_err(|e| exr_error(path, e))
}

/// A part that is asked for and not among these.
pub(super) fn no_part<'a>(name: &str, parts: impl ExactSizeIterator<Item = &'a String>) -> Error {
    let count = parts.len();
    let mut names: Vec<_> = parts.take(8).map(String::as_str).collect();
    if count > names.len() {
        names.push("...");
    }
    Error::invalid("parts", format!("no part {name}"), names.join(", "), name)
}

pub(super) fn kind(meta: &Value) -> &str {
    meta.get("kind").and_then(Value::as_str).unwrap_or("none")
}

pub(super) fn exr_error(path: &Path, error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            Error::io(path, source)
        }
        other => Error::invalid(
            path.display().to_string(),
            "not a readable EXR file",
            other,
            "a complete EXR file",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn sample() -> Container {
        let part = Part {
            size: [3, 2],
            channels: vec![
                Channel::f32("p", vec![0.0, 1.0, -2.5, 1e-30, 3e20, 4.0]),
                Channel::u32("index", vec![0, 1, 2, u32::MAX, 4, 5]),
                Channel { name: "half".into(), samples: Samples::F16(vec![f16::from_f32(0.5); 6]) },
            ],
        };
        let rgb = Part::rgb([1, 1], &[[1.0, 2.0, 3.0]]);
        Container {
            meta: json!({ "kind": "test", "name": "Müller \u{1F697}" }),
            parts: [("clusters".to_owned(), part), ("colors".to_owned(), rgb)].into(),
        }
    }

    #[test]
    fn containers_survive_the_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        sample().write(&path).unwrap();
        let mut back = Container::read(&path).unwrap();
        let mut expected = sample();
        for container in [&mut back, &mut expected] {
            for part in container.parts.values_mut() {
                part.channels.sort_by(|a, b| a.name.cmp(&b.name));
            }
        }
        assert_eq!(back, expected);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn every_truncation_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        sample().write(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(Container::read(&path).is_err(), "{length} of {} bytes were accepted", bytes.len());
        }
    }

    #[test]
    fn a_value_that_is_not_finite_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut bad = sample();
        bad.parts.insert(
            "x".into(),
            Part { size: [3, 1], channels: vec![Channel::f32("q", vec![0.0, 0.0, f32::NAN])] },
        );
        bad.write(&path).unwrap();
        let message = Container::read(&path).unwrap_err().to_string();
        for word in ["a.exr", "part x", "channel q", "pixel (2, 0)", "NaN"] {
            assert!(message.contains(word), "{message}");
        }
    }
}
