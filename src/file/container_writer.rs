//! Containers written part by part, in any order and from any thread, in the memory of the parts at hand.
//!
//! An EXR file begins with the headers of all parts, and one of them holds the JSON, which may tell what only the last part
//! shows. So parts are compressed as they come and wait, a spool of chunks: in memory as long as they are few, then in an
//! unnamed temporary file beside the target. The file itself is written at the end, parts in the order of their names: its
//! bytes do not depend on the order in which they came.

use super::atomic::{folder, write_atomically};
use super::container::{ATTRIBUTE, Part, Samples, exr_error};
use crate::error::{Error, Result};
use crate::parallel::TryMap;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::image::write::layers::{LayersWriter, WritableLayers};
use exr::meta::header::Header;
use exr::prelude::*;
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::SpooledTempFile;

/// Compressed bytes kept in memory before they move to a temporary file.
const IN_MEMORY: usize = 16 << 20;

/// A container on its way to a file.
pub struct ContainerWriter {
    path: PathBuf,
    spool: Mutex<Spool>,
}

/// The compressed chunks of all parts so far, one after the other.
struct Spool {
    bytes: SpooledTempFile,
    length: u64,
    parts: BTreeMap<String, SpooledPart>,
}

/// What is known of a part, and where its chunks wait.
struct SpooledPart {
    header: Header,
    start: u64,
    /// First line and compressed bytes of each chunk.
    chunks: Vec<(i32, usize)>,
}

impl ContainerWriter {
    /// A container without parts that [`ContainerWriter::finish`] will write to `path`.
    pub fn new(path: &Path) -> Self {
        let bytes = SpooledTempFile::new_in(IN_MEMORY, folder(path));
        let spool = Spool { bytes, length: 0, parts: BTreeMap::new() };
        Self { path: path.to_owned(), spool: Mutex::new(spool) }
    }

    /// Adds a part; threads may add parts at the same time.
    ///
    /// # Errors
    /// A channel whose length does not fit the part, a name used before, no room for the temporary file.
    pub fn part(&self, name: &str, part: &Part) -> Result<()> {
        let (header, chunks) =
            compress(name, part).map_err(|fault| fault.within(format!("part {name}")).in_file(&self.path))?;
        // A thread that panicked while it held the spool has left no whole part in it.
        let mut spool = self.spool.lock().unwrap_or_else(PoisonError::into_inner);
        spool.add(name, header, &chunks).map_err(|e| Error::io(&self.path, e))?.ok_or_else(|| {
            Error::invalid("parts", "name used twice", name, "unique names").in_file(&self.path)
        })
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// Those of the file system; no parts.
    pub fn finish(self, meta: &Value) -> Result<()> {
        let path = &self.path;
        let Spool { mut bytes, mut parts, .. } =
            self.spool.into_inner().unwrap_or_else(PoisonError::into_inner);
        let text = Text::new_or_none(ascii_json(meta))
            .ok_or_else(|| Error::invalid(path.display().to_string(), "metadata", "", "text"))?;
        let Some(first) = parts.values_mut().next() else {
            return Err(Error::invalid(path.display().to_string(), "parts", "none", "one or more"));
        };
        // Custom attributes belong to a part; readers that know no carpaint keep them.
        first.header.own_attributes.other.insert(Text::from(ATTRIBUTE), AttributeValue::Text(text));
        let shared = ImageAttributes::new(IntegerBounds::from_dimensions(first.header.layer_size));
        let headers = parts.values().map(|part| part.header.clone().with_shared_attributes(shared.clone()));
        let headers = headers.collect();
        write_atomically(path, |file| {
            exr::block::write(file, headers, true, |_, writer| {
                parts.values().enumerate().try_for_each(|(k, part)| part.copy(k, &mut bytes, writer))
            })
            .map_err(|e| exr_error(path, e))
        })
    }
}

impl Spool {
    /// Appends a part; none if there is one of this name.
    fn add(
        &mut self,
        name: &str,
        header: Header,
        chunks: &[CompressedScanLineBlock],
    ) -> std::io::Result<Option<()>> {
        if self.parts.contains_key(name) {
            return Ok(None);
        }
        self.bytes.seek(SeekFrom::Start(self.length))?;
        let mut part = SpooledPart { header, start: self.length, chunks: Vec::with_capacity(chunks.len()) };
        for chunk in chunks {
            self.bytes.write_all(&chunk.compressed_pixels_le)?;
            part.chunks.push((chunk.y_coordinate, chunk.compressed_pixels_le.len()));
            self.length += chunk.compressed_pixels_le.len() as u64;
        }
        self.parts.insert(name.to_owned(), part);
        Ok(Some(()))
    }
}

impl SpooledPart {
    /// Copies the part from the spool to the file, whose part `layer_index` it is.
    fn copy(
        &self,
        layer_index: usize,
        bytes: &mut SpooledTempFile,
        writer: &mut impl ChunksWriter,
    ) -> exr::error::UnitResult {
        bytes.seek(SeekFrom::Start(self.start))?;
        for (k, (y_coordinate, length)) in self.chunks.iter().enumerate() {
            let mut compressed_pixels_le = vec![0; *length];
            bytes.read_exact(&mut compressed_pixels_le)?;
            let block = CompressedScanLineBlock { y_coordinate: *y_coordinate, compressed_pixels_le };
            writer
                .write_chunk(k, Chunk { layer_index, compressed_block: CompressedBlock::ScanLine(block) })?;
        }
        Ok(())
    }
}

/// The header of a part and its chunks, from the first line to the last.
fn compress(name: &str, part: &Part) -> Result<(Header, Vec<CompressedScanLineBlock>)> {
    let layer = layer(name, part)?;
    let mut headers = layer.infer_headers(&ImageAttributes::new(IntegerBounds::from_dimensions(layer.size)));
    let source = layer.create_writer(&headers);
    let blocks: Vec<BlockIndex> =
        enumerate_ordered_header_block_indices(&headers).map(|block| block.1).collect();
    let chunks = blocks.into_par_iter().try_map(|index| {
        let data = source.extract_uncompressed_block(&headers, index);
        let chunk = UncompressedBlock { index, data }.compress_to_chunk(&headers);
        match chunk.map(|chunk| chunk.compressed_block) {
            Ok(CompressedBlock::ScanLine(block)) => Ok(block),
            Ok(_) => Err(Error::invalid("", "blocks", "tiles", "scan lines")),
            Err(e) => Err(Error::invalid("", "not compressible", e, "an array")),
        }
    })?;
    Ok((headers.remove(0), chunks))
}

fn layer(name: &str, part: &Part) -> Result<Layer<AnyChannels<FlatSamples>>> {
    let mut list = SmallVec::new();
    for channel in &part.channels {
        part.check_length(channel)?;
        let samples = match &channel.samples {
            Samples::F16(v) => FlatSamples::F16(v.clone()),
            Samples::F32(v) => FlatSamples::F32(v.clone()),
            Samples::U32(v) => FlatSamples::U32(v.clone()),
        };
        list.push(AnyChannel::new(Text::from(channel.name.as_str()), samples));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = Vec2(part.size[0], part.size[1]);
    Ok(Layer::new(size, LayerAttributes::named(name), encoding, AnyChannels::sort(list)))
}

/// JSON in ASCII (EXR text is not UTF-8): other characters become \u escapes, which only strings can hold.
fn ascii_json(value: &Value) -> String {
    let mut out = String::new();
    for c in value.to_string().chars() {
        if c.is_ascii() {
            out.push(c);
        } else {
            let mut units = [0; 2];
            for unit in c.encode_utf16(&mut units) {
                out.push_str(&format!("\\u{unit:04x}"));
            }
        }
    }
    out
}
