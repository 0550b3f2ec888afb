//! Frames that are drawn to be read back, and what textures want to be shown.

use super::options::FrameOptions;
use super::{FrameRenderer, check};
use crate::error::{Error, Result};
use crate::gpu::device::Gpu;
use crate::gpu::paint::GpuPaint;
use crate::gpu::pass::texture;
use crate::render::Picture;
use crate::scene::Scene;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

impl FrameRenderer {
    /// What [`FrameRenderer::draw`] draws, of the scene's size, read back; for a renderer of [`TextureFormat::Rgba32Float`].
    ///
    /// # Errors
    /// As [`FrameRenderer::draw`]; another format.
    pub fn picture(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
    ) -> Result<Picture> {
        let target = self.drawn(gpu, scene, paints, options)?;
        self.read(gpu, &target)
    }

    /// The same as eight-bit sRGB; for a renderer of [`TextureFormat::Rgba8Unorm`] or [`TextureFormat::Rgba8UnormSrgb`].
    ///
    /// # Errors
    /// As [`FrameRenderer::draw`]; another format.
    pub fn codes(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
    ) -> Result<Vec<[u8; 3]>> {
        self.expect(&[TextureFormat::Rgba8Unorm, TextureFormat::Rgba8UnormSrgb])?;
        let texels = read_texels(gpu, &self.drawn(gpu, scene, paints, options)?, 4)?;
        Ok(texels.chunks(4).map(|t| [t[0], t[1], t[2]]).collect())
    }

    /// What a texture shows that was drawn into, [`TextureFormat::Rgba32Float`] with usage `COPY_SRC`.
    ///
    /// # Errors
    /// A renderer of another format, what the driver complains about.
    pub fn read(&self, gpu: &Gpu, target: &wgpu::Texture) -> Result<Picture> {
        self.expect(&[TextureFormat::Rgba32Float])?;
        let texels = read_texels(gpu, target, 16)?;
        let float = |at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|k| texels[at + k]));
        let pixels = (0..texels.len() / 16).map(|k| [0, 4, 8].map(|c| float(16 * k + c)));
        Ok(Picture { size: [target.width(), target.height()].map(|n| n as usize), pixels: pixels.collect() })
    }

    fn expect(&self, formats: &[TextureFormat]) -> Result<()> {
        if formats.contains(&self.format) {
            return Ok(());
        }
        Err(Error::gpu("frame", "format", format!("{:?}", self.format), format!("{formats:?} to be read")))
    }

    /// A texture of the scene's size, drawn into.
    fn drawn(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
    ) -> Result<wgpu::Texture> {
        scene.validate()?;
        let size = scene.size.map(|n| n as u32);
        check(gpu, scene, paints, options, size)?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let target = texture(gpu, "target", self.format, size, usage);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.draw(gpu, scene, paints, options, &view, size)?;
        Ok(target)
    }
}

/// Whether the shader has to encode what such a texture shows: floats stay linear, others may encode by themselves.
pub(super) fn encodes(format: TextureFormat) -> bool {
    use TextureFormat as F;
    !(format.is_srgb() || matches!(format, F::Rgba16Float | F::Rgba32Float | F::Rg11b10Ufloat))
}

/// The texels of a texture of so many bytes each, row after row.
fn read_texels(gpu: &Gpu, texture: &wgpu::Texture, bytes: u32) -> Result<Vec<u8>> {
    let (row, rows) = (texture.width() * bytes, texture.height());
    // Rows of a copy start at multiples of this.
    let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copy = gpu.empty_buffer(
        "copy",
        u64::from(stride) * u64::from(rows),
        BufferUsages::MAP_READ | BufferUsages::COPY_DST,
    );
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: Some(rows) };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &copy, layout },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let texels = gpu.read(&copy)?;
    Ok(texels.chunks(stride as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bits_are_encoded_once() {
        assert!(encodes(TextureFormat::Rgba8Unorm) && encodes(TextureFormat::Bgra8Unorm));
        assert!(!encodes(TextureFormat::Rgba8UnormSrgb) && !encodes(TextureFormat::Rgba32Float));
    }
}
