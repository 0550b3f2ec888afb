//! Uniform buffers that change from frame to frame.

use super::device::Gpu;
use crate::error::{Error, Result};
use encase::internal::WriteInto;
use encase::{ShaderType, UniformBuffer};

/// A uniform buffer that is written when its value changes, and only then.
#[derive(Debug)]
pub(super) struct Uniform {
    label: &'static str,
    bytes: Vec<u8>,
    pub buffer: wgpu::Buffer,
}

impl Uniform {
    /// A buffer with a first value.
    pub fn new<T: ShaderType + WriteInto>(gpu: &Gpu, label: &'static str, value: &T) -> Result<Self> {
        Ok(Self { label, bytes: bytes(label, value)?, buffer: gpu.uniform(label, value)? })
    }

    /// Whether the value is another one than before.
    pub fn set<T: ShaderType + WriteInto>(&mut self, gpu: &Gpu, value: &T) -> Result<bool> {
        let bytes = bytes(self.label, value)?;
        if bytes == self.bytes {
            return Ok(false);
        }
        gpu.queue.write_buffer(&self.buffer, 0, &bytes);
        self.bytes = bytes;
        Ok(true)
    }
}

fn bytes<T: ShaderType + WriteInto>(label: &str, value: &T) -> Result<Vec<u8>> {
    let mut bytes = UniformBuffer::new(Vec::new());
    bytes.write(value).map_err(|e| Error::gpu(label, "layout", e, "one that fits"))?;
    Ok(bytes.into_inner())
}
