//! Containers read part by part, in any order and from any thread: memory is that of the parts at hand.
//!
//! An EXR file begins with the headers of all parts, and then says where the chunks of each part lie. Both are read when
//! the file is opened; a part is looked up when it is asked for.

use super::container::{ATTRIBUTE, Channel, Container, Part, Samples, exr_error, kind, no_part};
use super::picture::MOST_UNPACKED;
use super::text::open;
use crate::error::{Error, Result};
use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::*;
use half::f16;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// An open container.
pub struct ContainerReader {
    path: PathBuf,
    /// Everything that is not an array.
    pub meta: Value,
    headers: MetaData,
    /// Header and chunk offsets of each part.
    parts: BTreeMap<String, (usize, Vec<u64>)>,
}

impl ContainerReader {
    const MAX_PARTS: usize = 1 << 16;
    const MAX_CHANNELS: usize = 256;
    /// Decoded bytes that any file may claim to hold.
    const FREE_BYTES: u64 = 16 << 20;

    /// Opens a container; no array is read.
    ///
    /// # Errors
    /// No such file, a folder, not an EXR file, larger than [`Container::MAX_BYTES`] decoded, no carpaint attribute, deep or
    /// subsampled data, two parts of one name.
    pub fn open(path: &Path) -> Result<Self> {
        let (file, length) = open(path)?;
        let mut file = BufReader::new(file);
        let headers = MetaData::read_from_buffered(&mut file, false).map_err(|e| exr_error(path, e))?;
        let mut read = || {
            check_sizes(&headers.headers, length)?;
            let meta = json(&headers.headers)?;
            let mut parts = BTreeMap::new();
            for (k, header) in headers.headers.iter().enumerate() {
                let offsets = offsets(&mut file, header.chunk_count)?;
                if parts.insert(name(header), (k, offsets)).is_some() {
                    return Err(Error::invalid("parts", "name used twice", name(header), "unique names"));
                }
            }
            Ok((meta, parts))
        };
        let (meta, parts) = read().map_err(|e| e.in_file(path))?;
        Ok(Self { path: path.to_owned(), meta, headers, parts })
    }

    /// What the file is, as its JSON says; `none` where it says nothing.
    pub fn kind(&self) -> &str {
        kind(&self.meta)
    }

    /// Names of all parts.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parts.keys().map(String::as_str)
    }

    /// Reads a part.
    ///
    /// # Errors
    /// No such part; a file that was cut off or damaged; a sample that is not finite.
    pub fn part(&self, name: &str) -> Result<Part> {
        let Some((header, offsets)) = self.parts.get(name) else {
            return Err(no_part(name, self.parts.keys()).in_file(&self.path));
        };
        let (file, _) = open(&self.path)?;
        let part = self.read(*header, offsets, BufReader::new(file)).map_err(|e| exr_error(&self.path, e))?;
        part.check_finite().map_err(|e| e.within(format!("part {name}")).in_file(&self.path))?;
        Ok(part)
    }

    fn read(&self, layer: usize, offsets: &[u64], mut file: impl Read + Seek) -> exr::error::Result<Part> {
        let header = &self.headers.headers[layer];
        let mut part = empty(header);
        for (offset, place) in offsets.iter().zip(header.blocks_increasing_y_order()) {
            if !place.location.is_largest_resolution_level() {
                continue;
            }
            file.seek(SeekFrom::Start(*offset))?;
            let chunk = Chunk::read(&mut file, &self.headers)?;
            let block = UncompressedBlock::decompress_chunk(chunk, &self.headers, false)?;
            let expected = header.get_absolute_block_pixel_coordinates(place.location)?;
            let position = expected.position.to_usize("block position")?;
            let place = (layer, position, place.location.level_index);
            if (block.index.layer, block.index.pixel_position, block.index.level) != place {
                return Err(exr::error::Error::Invalid("chunk offset table".into()));
            }
            fill(&mut part, &block, header)?;
        }
        Ok(part)
    }
}

/// Copies the lines of a block to their places.
fn fill(part: &mut Part, block: &UncompressedBlock, header: &Header) -> exr::error::Result<()> {
    let width = part.size[0];
    for line in block.lines(&header.channels) {
        let at = line.location.position.y() * width + line.location.position.x();
        let range = at..at + line.location.sample_count;
        match &mut part.channels[line.location.channel].samples {
            Samples::F16(v) => line.read_samples_into_slice(&mut v[range])?,
            Samples::F32(v) => line.read_samples_into_slice(&mut v[range])?,
            Samples::U32(v) => line.read_samples_into_slice(&mut v[range])?,
        }
    }
    Ok(())
}

/// A part of zeros of the size and channels that a header tells.
fn empty(header: &Header) -> Part {
    let size = [header.layer_size.width(), header.layer_size.height()];
    let samples = |kind: SampleType| match kind {
        SampleType::F16 => Samples::F16(vec![f16::ZERO; size[0] * size[1]]),
        SampleType::F32 => Samples::F32(vec![0.0; size[0] * size[1]]),
        SampleType::U32 => Samples::U32(vec![0; size[0] * size[1]]),
    };
    let channel =
        |c: &ChannelDescription| Channel { name: c.name.to_string(), samples: samples(c.sample_type) };
    Part { size, channels: header.channels.list.iter().map(channel).collect() }
}

/// The next `count` entries of the table of offsets.
fn offsets(file: &mut impl Read, count: usize) -> Result<Vec<u64>> {
    let mut bytes = vec![0; 8 * count];
    let cut = |e: std::io::Error| Error::invalid("", "not a readable EXR file", e, "a complete EXR file");
    file.read_exact(&mut bytes).map_err(cut)?;
    Ok(bytes.chunks_exact(8).map(|b| u64::from_le_bytes(b.try_into().unwrap_or_default())).collect())
}

fn name(header: &Header) -> String {
    header.own_attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default()
}

/// The JSON of the first part that has one.
fn json(headers: &[Header]) -> Result<Value> {
    let key = Text::from(ATTRIBUTE);
    let text = headers.iter().find_map(|header| match header.own_attributes.other.get(&key) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    });
    let Some(text) = text else {
        return Err(Error::invalid("attributes", "no text attribute", "none", "one named carpaint"));
    };
    serde_json::from_str(&text).map_err(|e| Error::invalid("attribute carpaint", "not JSON", e, "JSON"))
}

/// Refuses headers that claim more than the caps, or than a file of so many bytes can hold, before anything is allocated.
fn check_sizes(headers: &[Header], length: u64) -> Result<()> {
    if headers.len() > ContainerReader::MAX_PARTS {
        return Err(Error::invalid("parts", "number", headers.len(), "up to 65536"));
    }
    let (mut total, mut chunks) = (0usize, 0u64);
    for header in headers {
        let fault = |what: &str, found: String, legal: &str| {
            Err(Error::invalid(format!("part {}", name(header)), what, found, legal))
        };
        let (size, channels) = (header.layer_size, header.channels.list.len());
        if size.width().max(size.height()) > Part::MAX_SIDE || channels > ContainerReader::MAX_CHANNELS {
            let found = format!("{} x {} with {channels} channels", size.width(), size.height());
            return fault("size", found, "sides to 1048576, 256 channels");
        }
        if header.deep {
            return fault("data", "deep".into(), "flat");
        }
        if let Some(c) = header.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
            return fault("sampling", format!("{:?} of channel {}", c.sampling, c.name), "1 x 1");
        }
        total = total.saturating_add(size.area().saturating_mul(4 * channels));
        chunks = chunks.saturating_add(header.chunk_count as u64);
    }
    if total > Container::MAX_BYTES {
        let legal = format!("up to {}", Container::MAX_BYTES);
        return Err(Error::invalid("parts", "decoded bytes", total, legal));
    }
    let most = length.saturating_mul(MOST_UNPACKED).max(ContainerReader::FREE_BYTES);
    if total as u64 > most {
        let legal = format!("up to {most} in a file of {length}");
        return Err(Error::invalid("parts", "decoded bytes", total, legal));
    }
    // A chunk has its entry in the table of offsets.
    if chunks > length / 8 {
        return Err(Error::invalid(
            "parts",
            "chunks",
            chunks,
            format!("up to {} in {length} bytes", length / 8),
        ));
    }
    Ok(())
}
