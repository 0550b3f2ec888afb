//! A mix on the GPU, or on its way there: that takes a while, and the window does not wait for it.

use super::job::Job;
use super::waker::Waker;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, GpuMix};
use crate::mix::Mix;
use eframe::wgpu::ErrorFilter;
use std::sync::Arc;

/// A mix, and what the GPU has of it.
pub struct Held {
    mix: Arc<Mix>,
    here: Here,
}

enum Here {
    Coming(Job<GpuMix>),
    There(Box<GpuMix>),
}

impl Held {
    /// Begins to bring a mix to the GPU, in a thread of its own that wakes the window.
    pub fn begin(gpu: &Arc<Gpu>, mix: &Arc<Mix>, waker: &Waker) -> Self {
        let (on, own) = (gpu.clone(), mix.clone());
        let job = Job::start(waker.function(), move |progress| {
            let _tick = progress.begin("bringing the mix to the GPU", 1);
            bring(&on, &own)
        });
        Self { mix: mix.clone(), here: Here::Coming(job) }
    }

    /// Whether it is this one.
    pub fn is_of(&self, mix: &Arc<Mix>) -> bool {
        Arc::ptr_eq(&self.mix, mix)
    }

    /// Takes note that it is there.
    ///
    /// # Errors
    /// As [`GpuMix::new`].
    pub fn step(&mut self) -> Result<()> {
        if let Here::Coming(job) = &self.here
            && let Some(result) = job.poll()
        {
            self.here = Here::There(Box::new(result?));
        }
        Ok(())
    }

    /// Until it is there, or will not be.
    pub fn wait(&self) {
        if let Here::Coming(job) = &self.here {
            job.wait();
        }
    }

    /// What is under way, and the share of it that is done; none: it is there.
    pub fn progress(&self) -> Option<(String, f32)> {
        match &self.here {
            Here::Coming(job) => Some(job.progress()),
            Here::There(_) => None,
        }
    }

    /// Once it is there.
    pub fn mix(&self) -> Option<&GpuMix> {
        match &self.here {
            Here::Coming(_) => None,
            Here::There(mix) => Some(mix),
        }
    }

    /// The same, to be realized.
    pub fn mix_mut(&mut self) -> Option<&mut GpuMix> {
        match &mut self.here {
            Here::Coming(_) => None,
            Here::There(mix) => Some(mix),
        }
    }
}

/// [`GpuMix::new`], with what the driver complains about meanwhile in this thread, and not in that of the window.
fn bring(gpu: &Gpu, mix: &Mix) -> Result<GpuMix> {
    let scopes = [ErrorFilter::Validation, ErrorFilter::OutOfMemory, ErrorFilter::Internal]
        .map(|filter| gpu.device().push_error_scope(filter));
    let brought = GpuMix::new(&gpu.apart(), mix);
    // The last one first.
    let faults: Vec<_> =
        scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
    match faults.first() {
        None => brought,
        Some(fault) => Err(Error::gpu(gpu.name(), "mix", fault, "no complaint of the driver")),
    }
}
