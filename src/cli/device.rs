//! Where pictures are rendered.

use super::output;
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::gpu;
use crate::render::{self, Options, Picture, Print, RenderPaint};
use crate::scene::Scene;

/// Where to render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Device {
    /// A GPU if there is one that is not software, else the CPU.
    #[default]
    Auto,
    /// The reference renderer.
    Cpu,
    /// The best adapter that there is, software too.
    Gpu,
}

/// What renders.
#[derive(Debug)]
pub enum Renderer {
    Cpu,
    #[cfg(feature = "gpu")]
    Gpu(Box<gpu::Gpu>),
}

impl Device {
    /// Opens the device, and says which it is.
    ///
    /// # Errors
    /// `gpu` where no adapter can do what is needed.
    pub fn open(self) -> Result<Renderer> {
        let (renderer, name) = self.find()?;
        output::note!("device: {name}");
        Ok(renderer)
    }

    /// The device, and its name for people.
    #[cfg(feature = "gpu")]
    fn find(self) -> Result<(Renderer, String)> {
        let found = match self {
            Self::Cpu => return Ok((Renderer::Cpu, "CPU".to_owned())),
            Self::Gpu => gpu::Gpu::new(None)?,
            Self::Auto => match gpu::Gpu::new(None) {
                Ok(gpu) if gpu.is_software() => {
                    let name = format!("CPU ({} is software, too; --device gpu takes it)", gpu.name());
                    return Ok((Renderer::Cpu, name));
                }
                Ok(gpu) => gpu,
                Err(e) => return Ok((Renderer::Cpu, format!("CPU ({e})"))),
            },
        };
        let name = found.name().to_owned();
        Ok((Renderer::Gpu(Box::new(found)), name))
    }

    #[cfg(not(feature = "gpu"))]
    fn find(self) -> Result<(Renderer, String)> {
        match self {
            Self::Auto | Self::Cpu => Ok((Renderer::Cpu, "CPU".to_owned())),
            Self::Gpu => {
                let legal = "auto or cpu: this program was built without the feature gpu";
                Err(crate::error::Error::invalid("--device", "device", "gpu", legal))
            }
        }
    }
}

/// Name of the device that renders unless another is asked for.
pub fn adapter_name() -> String {
    Device::Auto.find().map_or_else(|e| e.to_string(), |(_, name)| name)
}

impl Renderer {
    /// As [`render::render`].
    pub fn render(
        &self,
        scene: &Scene,
        paints: &[RenderPaint],
        options: &Options,
        tick: &(dyn Fn() + Sync),
    ) -> Result<Picture> {
        match self {
            Self::Cpu => render::render(scene, paints, options, tick),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu::render(gpu, scene, paints, options, tick),
        }
    }

    /// As [`render::render_print`].
    pub fn render_print(
        &self,
        scene: &Scene,
        print: &Print,
        options: &Options,
        tick: &(dyn Fn() + Sync),
    ) -> Result<Picture> {
        match self {
            Self::Cpu => render::render_print(scene, print, options, tick),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) if !gpu::GpuPrint::fits(print.coverage) => {
                output::note!("device: CPU (more dots than the GPU has room for)");
                render::render_print(scene, print, options, tick)
            }
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu::render_print(gpu, scene, print, options, tick),
        }
    }
}
