//! Where pictures are rendered.

use super::output;
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::gpu;
use crate::render::{self, Options, Picture, RenderPaint};
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
        let renderer = self.find()?;
        match &renderer {
            Renderer::Cpu => output::note!("device: CPU"),
            #[cfg(feature = "gpu")]
            Renderer::Gpu(gpu) => output::note!("device: {}", gpu.name()),
        }
        Ok(renderer)
    }

    #[cfg(feature = "gpu")]
    fn find(self) -> Result<Renderer> {
        let opened = || gpu::Gpu::new(None).map(Box::new);
        Ok(match self {
            Self::Cpu => Renderer::Cpu,
            Self::Gpu => Renderer::Gpu(opened()?),
            Self::Auto => opened().ok().filter(|gpu| !gpu.is_software()).map_or(Renderer::Cpu, Renderer::Gpu),
        })
    }

    #[cfg(not(feature = "gpu"))]
    fn find(self) -> Result<Renderer> {
        match self {
            Self::Auto | Self::Cpu => Ok(Renderer::Cpu),
            Self::Gpu => {
                let legal = "auto or cpu: this program was built without the feature gpu";
                Err(crate::error::Error::invalid("--device", "device", "gpu", legal))
            }
        }
    }
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
}
