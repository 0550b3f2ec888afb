//! Tensor files: named arrays of numbers, as the RGL material database keeps its measurements.
//!
//! "tensor_file\0", u8 major 1, u8 minor 0, u32 number of fields; per field u16 length of the name, the name, u16 dimensions, u8
//! type (1 u8, 5 u32, 10 f32, 11 f64 ...), u64 offset of the data in the file, u64 a dimension; little-endian, last index
//! fastest.

use crate::error::{Error, Result};
use crate::file::open;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// First bytes of the file.
pub(in crate::brdf) const MAGIC: &[u8] = b"tensor_file\0";
/// Most fields; RGL's files have about ten.
const MAX_FIELDS: u32 = 256;
/// Most dimensions of a field; RGL's have up to five.
const MAX_DIMENSIONS: u16 = 8;
/// Most numbers read of a field: isotropic spectral ones of RGL have two millions.
const MAX_NUMBERS: u64 = 1 << 27;
/// Type code of f32.
const F32: u8 = 10;
/// Type code of u8.
const U8: u8 = 1;

/// An open tensor file: what it holds is known, data are read when asked for.
pub(super) struct TensorFile {
    reader: BufReader<File>,
    path: PathBuf,
    fields: BTreeMap<String, Field>,
}

/// Where a field is, and its shape.
struct Field {
    kind: u8,
    offset: u64,
    shape: Vec<usize>,
    /// Product of the shape.
    count: u64,
}

/// A field's numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tensor {
    pub shape: Vec<usize>,
    /// Last index fastest.
    pub values: Vec<f32>,
}

impl TensorFile {
    /// Reads the list of fields; each has to lie within the file. Faults of the content do not name the file.
    pub fn open(path: &Path) -> Result<Self> {
        let (file, length) = open(path)?;
        let mut file = Self { reader: BufReader::new(file), path: path.to_owned(), fields: BTreeMap::new() };
        file.read_fields(length)?;
        Ok(file)
    }

    fn read_fields(&mut self, length: u64) -> Result<()> {
        if self.bytes::<12>("first bytes")? != MAGIC {
            return Err(refuse("first bytes", "others", "\"tensor_file\\0\""));
        }
        let version = self.bytes::<2>("version")?;
        if version != [1, 0] {
            let found = format!("{}.{}", version[0], version[1]);
            return Err(Error::unsupported("", "version", found, "1.0"));
        }
        let count = u32::from_le_bytes(self.bytes("number of fields")?);
        if count > MAX_FIELDS {
            return Err(refuse("fields", count, &format!("up to {MAX_FIELDS}")));
        }
        for k in 0..count {
            let (name, field) = self.read_field(k)?;
            let size = if field.kind == U8 { 1 } else { 4 };
            // Other types are never read: their data may be anywhere.
            let end = field.count.checked_mul(size).and_then(|bytes| bytes.checked_add(field.offset));
            if [U8, F32].contains(&field.kind) && end.is_none_or(|end| end > length) {
                let found = format!("{:?} at byte {}", field.shape, field.offset);
                return Err(refuse(
                    &format!("field {name}"),
                    found,
                    &format!("within the file's {length} bytes"),
                ));
            }
            self.fields.insert(name, field);
        }
        Ok(())
    }

    fn read_field(&mut self, k: u32) -> Result<(String, Field)> {
        let what = format!("field {k}");
        let name_length = u16::from_le_bytes(self.bytes(&what)?);
        let mut name = vec![0; name_length.into()];
        self.read(&what, &mut name)?;
        let name = String::from_utf8_lossy(&name).into_owned();
        let dimensions = u16::from_le_bytes(self.bytes(&what)?);
        if dimensions > MAX_DIMENSIONS {
            return Err(refuse(&format!("field {name}: dimensions"), dimensions, "up to 8"));
        }
        let [kind] = self.bytes(&what)?;
        let offset = u64::from_le_bytes(self.bytes(&what)?);
        let mut shape = Vec::with_capacity(dimensions.into());
        let mut count = 1u64;
        for _ in 0..dimensions {
            let side = u64::from_le_bytes(self.bytes(&what)?);
            let product = count.checked_mul(side).filter(|n| *n <= MAX_NUMBERS);
            count = product.ok_or_else(|| {
                refuse(&format!("field {name}: side"), side, &format!("up to {MAX_NUMBERS} numbers in all"))
            })?;
            shape.push(side as usize);
        }
        Ok((name, Field { kind, offset, shape, count }))
    }

    /// Whether there is a field of this name.
    pub fn has(&self, name: &str) -> bool {
        self.fields.contains_key(name)
    }

    /// The shape of a field.
    pub fn shape(&self, name: &str) -> Result<&[usize]> {
        Ok(&self.field(name)?.shape)
    }

    fn field(&self, name: &str) -> Result<&Field> {
        let names = || self.fields.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        let missing =
            || Error::invalid("", format!("field {name}"), format!("only {}", names()), "that field");
        self.fields.get(name).ok_or_else(missing)
    }

    /// The numbers of a field of f32, which may be no numbers.
    pub fn f32(&mut self, name: &str) -> Result<Tensor> {
        let (bytes, shape) = self.data(name, F32, 4)?;
        let values = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        Ok(Tensor { shape, values })
    }

    /// The bytes of a field of u8.
    pub fn u8(&mut self, name: &str) -> Result<Vec<u8>> {
        Ok(self.data(name, U8, 1)?.0)
    }

    fn data(&mut self, name: &str, kind: u8, size: u64) -> Result<(Vec<u8>, Vec<usize>)> {
        let field = self.field(name)?;
        if field.kind != kind {
            return Err(refuse(&format!("field {name}: type"), field.kind, &kind.to_string()));
        }
        let (count, offset, shape) = (field.count, field.offset, field.shape.clone());
        self.reader.seek(SeekFrom::Start(offset)).map_err(|e| Error::io(&self.path, e))?;
        let mut bytes = vec![0; (count * size) as usize];
        self.read(&format!("field {name}"), &mut bytes)?;
        Ok((bytes, shape))
    }

    fn bytes<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.read(what, &mut bytes)?;
        Ok(bytes)
    }

    fn read(&mut self, what: &str, bytes: &mut [u8]) -> Result<()> {
        self.reader.read_exact(bytes).map_err(|e| match e.kind() {
            std::io::ErrorKind::UnexpectedEof => refuse(what, "the end of the file", "more bytes"),
            _ => Error::io(&self.path, e),
        })
    }
}

fn refuse(what: &str, found: impl ToString, legal: &str) -> Error {
    Error::invalid("tensor file", what, found, legal)
}
