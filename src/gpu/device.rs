//! The adapter that is used, and the device opened on it.

use crate::error::{Error, Result};
use encase::internal::WriteInto;
use encase::{ShaderType, StorageBuffer, UniformBuffer};
use std::sync::{Arc, Mutex};
use wgpu::{Backends, BufferUsages, DeviceType, DownlevelFlags, Limits};

/// An open GPU.
#[derive(Debug)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
    is_software: bool,
    faults: Arc<Mutex<Faults>>,
}

/// What the driver complained about, in its words.
#[derive(Debug, Default)]
struct Faults {
    /// Why the device is lost: from then on nothing works, and no other complaint comes.
    loss: Option<String>,
    /// Since they were last asked for.
    others: Vec<String>,
}

impl Gpu {
    /// Storage buffers that the largest pass binds: four of a mix, four of the paint that it becomes.
    const STORAGE_BUFFERS: u32 = 8;
    /// Largest storage buffer, bytes.
    pub(super) const STORAGE_BYTES: u64 = 128 << 20;

    /// Opens the best adapter whose [`Gpu::name`] contains `wanted` in any case, of all without it: a discrete GPU before an
    /// integrated one, software last.
    ///
    /// # Errors
    /// No such adapter, none that can do what is needed, a driver that refuses.
    pub fn new(wanted: Option<&str>) -> Result<Self> {
        let adapter = choose(wanted)?;
        let name = name(&adapter.get_info());
        // No more than needed, but pictures as large as it can.
        let limits = Self::required_limits().using_resolution(adapter.limits());
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| Error::gpu(&name, "device", e, "one that opens"))?;
        Ok(Self::watching(device, queue, &adapter.get_info()))
    }

    /// A GPU that is open already, such as a window's. From now on complaints of its driver and its loss are errors of what is
    /// done here.
    ///
    /// # Errors
    /// Limits below [`Gpu::required_limits`].
    pub fn from_device(
        device: wgpu::Device,
        queue: wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
    ) -> Result<Self> {
        check_limits(&device.limits(), &name(adapter))?;
        Ok(Self::watching(device, queue, adapter))
    }

    /// What every pass together needs, beyond what any GPU has: what a window has to ask for, with `using_resolution` of its
    /// adapter's limits if pictures are to be larger than 2048 pixels.
    pub fn required_limits() -> Limits {
        Limits {
            max_storage_buffers_per_shader_stage: Self::STORAGE_BUFFERS,
            max_storage_buffer_binding_size: Self::STORAGE_BYTES,
            ..Limits::downlevel_defaults()
        }
    }

    fn watching(device: wgpu::Device, queue: wgpu::Queue, adapter: &wgpu::AdapterInfo) -> Self {
        let faults = Arc::new(Mutex::new(Faults::default()));
        let (errors, losses) = (faults.clone(), faults.clone());
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| note(&errors, e.to_string())));
        device.set_device_lost_callback(move |reason, why| {
            if let Ok(mut faults) = losses.lock() {
                faults.loss = Some(format!("device lost ({reason:?}) {why}"));
            }
        });
        Self {
            device,
            queue,
            name: name(adapter),
            is_software: adapter.device_type == DeviceType::Cpu,
            faults,
        }
    }

    /// The same device for work in another thread: complaints of the driver that nobody catches are still told here alone.
    pub(crate) fn apart(&self) -> Self {
        let loss = self.faults.lock().ok().and_then(|faults| faults.loss.clone());
        Self {
            device: self.device.clone(),
            queue: self.queue.clone(),
            name: self.name.clone(),
            is_software: self.is_software,
            faults: Arc::new(Mutex::new(Faults { loss, others: Vec::new() })),
        }
    }

    /// Names of all adapters, best first.
    pub fn adapters() -> Vec<String> {
        adapters().iter().map(|adapter| name(&adapter.get_info())).collect()
    }

    /// Name of the adapter, and its back end.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The open device, to make textures to be drawn into.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The device's queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Whether the adapter computes on the CPU.
    pub fn is_software(&self) -> bool {
        self.is_software
    }

    /// # Errors
    /// What the driver has complained about since the last call; that the device is lost, from then on at every call.
    pub(super) fn check(&self, place: &str) -> Result<()> {
        // The loss of a device is only told to those who ask, and once its queue is empty; until then it complains of this and that.
        let _ = self.device.poll(wgpu::PollType::Poll);
        let complains = |faults: &Mutex<Faults>| faults.lock().is_ok_and(|f| !f.others.is_empty());
        if complains(&self.faults) {
            let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        }
        let fault = self.faults.lock().ok().and_then(|mut faults| {
            let first = std::mem::take(&mut faults.others).into_iter().next();
            faults.loss.clone().or(first)
        });
        match fault {
            None => Ok(()),
            Some(fault) => Err(Error::gpu(&self.name, place, fault, "no complaint of the driver")),
        }
    }

    /// A storage buffer of the layout that the shader sees.
    pub(super) fn storage<T: ShaderType + WriteInto>(&self, label: &str, value: &T) -> Result<wgpu::Buffer> {
        let mut bytes = StorageBuffer::new(Vec::new());
        bytes.write(value).map_err(|e| Error::gpu(label, "layout", e, "one that fits"))?;
        self.buffer(label, &bytes.into_inner(), BufferUsages::STORAGE)
    }

    /// A uniform buffer of the layout that the shader sees.
    pub(super) fn uniform<T: ShaderType + WriteInto>(&self, label: &str, value: &T) -> Result<wgpu::Buffer> {
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes.write(value).map_err(|e| Error::gpu(label, "layout", e, "one that fits"))?;
        self.buffer(label, &bytes.into_inner(), BufferUsages::UNIFORM)
    }

    fn buffer(&self, label: &str, bytes: &[u8], usage: BufferUsages) -> Result<wgpu::Buffer> {
        let size = bytes.len() as u64;
        if size > Self::STORAGE_BYTES {
            let legal = format!("{} at most", Self::STORAGE_BYTES);
            return Err(Error::gpu(&self.name, format!("bytes of {label}"), size, legal));
        }
        let buffer = self.empty_buffer(label, size, usage | BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
        self.queue.write_buffer(&buffer, 0, bytes);
        self.check(label)?;
        Ok(buffer)
    }

    pub(super) fn empty_buffer(&self, label: &str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        let label = Some(label);
        self.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
    }

    /// Writes words behind so many.
    pub(super) fn write_words(&self, buffer: &wgpu::Buffer, first: u64, words: &[u32]) {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        if !bytes.is_empty() {
            self.queue.write_buffer(buffer, 4 * first, &bytes);
        }
    }

    /// Waits for the work so far.
    ///
    /// # Errors
    /// What the driver has complained about.
    pub fn wait(&self) -> Result<()> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| Error::gpu(&self.name, "waiting", e, "an end"))?;
        self.check("waiting")
    }

    /// Waits for the work so far, and returns what lies in a buffer of `COPY_SRC`.
    pub(super) fn read_back(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>> {
        let copy = self.empty_buffer("copy", buffer.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        self.read(&copy)
    }

    /// Waits for the work so far, and returns what lies in a buffer of `MAP_READ`.
    pub(super) fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>> {
        let complain = |e: String| Error::gpu(&self.name, "reading", e, "a buffer");
        let faults = self.faults.clone();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            if let Err(e) = mapped {
                note(&faults, e.to_string());
            }
        });
        self.wait()?;
        let bytes = buffer.get_mapped_range(..).map_err(|e| complain(e.to_string()))?.to_vec();
        buffer.unmap();
        Ok(bytes)
    }
}

fn note(faults: &Mutex<Faults>, fault: String) {
    if let Ok(mut faults) = faults.lock() {
        faults.others.push(fault);
    }
}

fn name(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({})", info.name, info.backend)
}

/// All adapters, best first; among equals in the order of the system.
fn adapters() -> Vec<wgpu::Adapter> {
    let backends = Backends::VULKAN | Backends::METAL | Backends::DX12 | Backends::GL;
    let descriptor =
        wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        let kind = match info.device_type {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu => 2,
            DeviceType::Other => 3,
            DeviceType::Cpu => 4,
        };
        (kind, info.backend == wgpu::Backend::Gl)
    });
    adapters
}

fn choose(wanted: Option<&str>) -> Result<wgpu::Adapter> {
    let adapters = adapters();
    let names: Vec<String> = adapters.iter().map(|adapter| name(&adapter.get_info())).collect();
    if names.is_empty() {
        return Err(Error::gpu("", "GPU adapter", "none", "a Vulkan, Metal, Direct3D 12 or OpenGL driver"));
    }
    let is_wanted = |name: &str| wanted.is_none_or(|w| name.to_lowercase().contains(&w.to_lowercase()));
    let mut complaint = None;
    for (adapter, name) in adapters.into_iter().zip(&names).filter(|(_, name)| is_wanted(name)) {
        match check_adapter(&adapter, name) {
            Ok(()) => return Ok(adapter),
            Err(e) => complaint = complaint.or(Some(e)),
        }
    }
    let none = || Error::gpu("", "GPU adapter", wanted.unwrap_or_default(), names.join(", "));
    Err(complaint.unwrap_or_else(none))
}

/// # Errors
/// The first thing that an adapter cannot do.
fn check_adapter(adapter: &wgpu::Adapter, name: &str) -> Result<()> {
    let needed = DownlevelFlags::COMPUTE_SHADERS | DownlevelFlags::FRAGMENT_STORAGE;
    let missing = needed - adapter.get_downlevel_capabilities().flags;
    if !missing.is_empty() {
        return Err(Error::gpu(name, "abilities", format!("no {missing:?}"), format!("{needed:?}")));
    }
    check_limits(&adapter.limits(), name)
}

/// # Errors
/// The first limit that is too small.
fn check_limits(limits: &Limits, name: &str) -> Result<()> {
    let mut first = Ok(());
    Gpu::required_limits().check_limits_with_fail_fn(limits, true, |limit, needed, found| {
        first = Err(Error::gpu(name, limit, found, format!("{needed} or better")));
    });
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_is_too_small_is_named() {
        check_limits(&Limits::defaults(), "good").unwrap();
        let small = Limits { max_storage_buffers_per_shader_stage: 4, ..Limits::defaults() };
        let message = check_limits(&small, "small").unwrap_err().to_string();
        assert_eq!(
            message,
            "small: max_storage_buffers_per_shader_stage: found 4, expected 8 or better (GPU)"
        );
        assert!(check_limits(&Limits::downlevel_webgl2_defaults(), "web").is_err());
    }
}
