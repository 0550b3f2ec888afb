//! Pictures on the screen: the seam between the window and the renderer of frames.

use super::held::Held;
use super::shelf::Ready;
use super::waker::Waker;
use super::worn::{BLENDS, Blend, Worn, number_of};
use crate::error::{Error, Result};
use crate::gpu::{FrameOptions, FrameRenderer, Gpu, GpuMix, GpuPaint};
use crate::mix::Mix;
use crate::scene::{Environment, Scene, Shape};
use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Everything that a picture depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// What is seen, its size and exposure included.
    pub scene: Scene,
    /// What its objects wear.
    pub worn: Vec<Worn>,
    /// Whether flakes sparkle.
    pub flakes: bool,
    /// Which flakes there are.
    pub seed: u32,
    /// The columns that are seen, from and to; all of them are not more than those of the scene.
    pub columns: [usize; 2],
}

/// Paints kept on the GPU at most: those of a mix, a composition.
const KEPT: usize = 12;
/// What egui takes for a picture: codes, not light.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// What one drawing may take, seconds: what takes longer is drawn coarse first, then finely, some rows at a time, so that the
/// window goes on answering.
const BUDGET: f64 = 0.05;
/// What some fine rows may take, seconds: nobody waits for them, and every drawing of the window costs some time of its own.
const ROWS_BUDGET: f64 = 0.2;
/// Pixels of a coarse picture at most, to either side.
const COARSEST: usize = 8;
/// A coarse picture must stay as it is for so long before it becomes fine: the first fine rows find what all of it shows, and
/// nobody could move anything meanwhile.
const REST: Duration = Duration::from_millis(150);
/// First guess of what a pixel costs, seconds, on a GPU and in software.
const GUESS: [f64; 2] = [1e-9, 1e-6];
/// It is drawn into and shown, and read back where pictures are compared.
const USAGE: wgpu::TextureUsages = wgpu::TextureUsages::RENDER_ATTACHMENT
    .union(wgpu::TextureUsages::TEXTURE_BINDING)
    .union(wgpu::TextureUsages::COPY_SRC);
/// Renderers and textures of fine pictures, and of coarse ones.
const FINE: usize = 0;
const COARSE: usize = 1;

/// A texture that egui shows.
struct Target {
    texture: wgpu::Texture,
    id: TextureId,
}

/// A picture on its way: all of it coarse, or the first rows of it as fine as it gets.
struct Pane {
    fine: Target,
    coarse: Option<Target>,
    /// When the coarse one was drawn.
    since: Instant,
    /// What it shows.
    shows: Option<Request>,
    /// Rows that are fine.
    rows: usize,
    /// What they took.
    spent: Duration,
}

/// What egui puts on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layers {
    /// Under the other, where that is not done.
    pub coarse: Option<TextureId>,
    /// The fine picture.
    pub fine: TextureId,
    /// Share of its rows that are done, from the top.
    pub done: f32,
}

/// What a drawing came to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drawn {
    /// What a picture took that is now there, coarse or fine, until its last pixel was.
    pub time: Option<Duration>,
    /// Whether rows are left to draw.
    pub is_partial: bool,
    /// How long to wait with them.
    pub rest: Duration,
}

/// Draws requests into textures, one a pane.
pub struct Pictures {
    gpu: Arc<Gpu>,
    state: RenderState,
    waker: Waker,
    /// One for fine and one for coarse pictures: each keeps the geometry of its size.
    renderers: [FrameRenderer; 2],
    /// The last used last.
    paints: Vec<(Arc<Ready>, GpuPaint)>,
    /// One for each blend that is shown: any weights give its paint in place.
    mixes: [Option<Held>; BLENDS],
    /// Mixes on their way that nobody wants any more.
    leaving: Vec<Held>,
    panes: [Option<Pane>; 2],
    /// Of a pixel, seconds, as the last two drawings had it.
    costs: [f64; 2],
}

impl Drop for Pictures {
    /// The driver ends with the program: nobody may be using it then.
    fn drop(&mut self) {
        self.mixes.iter().flatten().chain(&self.leaving).for_each(Held::wait);
    }
}

impl Pictures {
    /// On the device of a window; `waker`: wakes it when a mix is there.
    ///
    /// # Errors
    /// Those of [`Gpu::from_device`] and [`FrameRenderer::new`].
    pub fn new(state: &RenderState, waker: Waker) -> Result<Self> {
        let (device, queue) = (state.device.clone(), state.queue.clone());
        let gpu = Arc::new(Gpu::from_device(device, queue, &state.adapter.get_info())?);
        let renderers = [FrameRenderer::new(&gpu, FORMAT)?, FrameRenderer::new(&gpu, FORMAT)?];
        let costs = [GUESS[usize::from(gpu.is_software())]; 2];
        let (paints, mixes, panes) = (Vec::new(), [None, None], [None, None]);
        Ok(Self {
            gpu,
            state: state.clone(),
            waker,
            renderers,
            paints,
            mixes,
            leaving: Vec::new(),
            panes,
            costs,
        })
    }

    /// Of a pixel, seconds: of the last two drawings the cheaper one, since one may have waited for a driver that compiles.
    fn cost(&self) -> f64 {
        self.costs[0].min(self.costs[1])
    }

    /// Begins to bring the mix of a blend to the GPU, or takes note that it is there.
    ///
    /// # Errors
    /// As [`GpuMix::new`], when that comes to an end: a mix that is too large for the GPU.
    pub fn hold(&mut self, blend: &Blend) -> Result<()> {
        self.leaving.retain_mut(|held| held.step().is_ok() && held.progress().is_some());
        let slot = &mut self.mixes[blend.slot];
        if slot.as_ref().is_none_or(|held| !held.is_of(&blend.mix)) {
            // The old one goes first, its memory with it; one on its way goes when it is there.
            self.leaving.extend(slot.take().filter(|held| held.progress().is_some()));
            *slot = Some(Held::begin(&self.gpu, &blend.mix, &self.waker));
            return Ok(());
        }
        let stepped = slot.as_mut().map_or(Ok(()), Held::step);
        if stepped.is_err() {
            *slot = None;
        }
        stepped
    }

    /// Lets go of mixes that are not open any more.
    pub fn forget_others(&mut self, open: Option<&Arc<Mix>>) {
        for slot in &mut self.mixes {
            let left = slot.take_if(|held| open.is_none_or(|open| !held.is_of(open)));
            self.leaving.extend(left.filter(|held| held.progress().is_some()));
        }
    }

    /// Mixes on their way to the GPU, and the share of that which is done.
    pub fn work(&self) -> Vec<(String, f32)> {
        self.mixes.iter().flatten().filter_map(Held::progress).collect()
    }

    /// Whether what is worn can be drawn: no mix of it is on its way to the GPU.
    fn is_here(&self, worn: &Worn) -> bool {
        match worn {
            Worn::Paint(_) => true,
            Worn::Blend(blend) => self.mixes[blend.slot].as_ref().is_some_and(|held| held.mix().is_some()),
        }
    }

    /// The open device.
    pub fn device(&self) -> &wgpu::Device {
        self.gpu.device()
    }

    /// Name of the adapter.
    pub fn adapter(&self) -> &str {
        self.gpu.name()
    }

    /// What a pane shows, once something was drawn.
    pub fn layers(&self, pane: usize) -> Option<Layers> {
        let pane = self.panes[pane].as_ref()?;
        let height = pane.shows.as_ref()?.scene.size[1];
        Some(Layers {
            coarse: pane.coarse.as_ref().map(|coarse| coarse.id),
            fine: pane.fine.id,
            done: pane.rows as f32 / height as f32,
        })
    }

    /// Draws a request, or more of it if the pane shows only a part and `may_refine`; nothing if all of it is there and nothing
    /// asks for it `again`, nor while a mix is on its way.
    ///
    /// # Errors
    /// Those of [`GpuPaint::new`], [`GpuMix::realize`] and [`FrameRenderer::draw`]; the pane then shows what it did.
    pub fn draw(&mut self, pane: usize, request: &Request, again: bool, may_refine: bool) -> Result<Drawn> {
        let shown = self.panes[pane].as_ref().filter(|pane| pane.shows.as_ref() == Some(request));
        let rows = shown.map(|pane| pane.rows);
        let rested = shown.map_or(REST, |pane| pane.since.elapsed());
        let [width, height] = request.scene.size;
        let seen = request.columns[1].saturating_sub(request.columns[0]);
        if seen == 0 || height == 0 || (!again && rows == Some(height)) {
            return Ok(Drawn::default());
        }
        if !request.worn.iter().all(|worn| self.is_here(worn)) {
            // Who brings it wakes the window.
            return Ok(Drawn { is_partial: true, rest: Duration::MAX, ..Drawn::default() });
        }
        if rows.is_some() && !again && !may_refine {
            return Ok(Drawn { is_partial: true, ..Drawn::default() });
        }
        if rows == Some(0) && !again && rested < REST {
            return Ok(Drawn { is_partial: true, rest: REST - rested, ..Drawn::default() });
        }
        self.make_pane(pane, [width, height]);
        let estimate = self.cost() * (seen * height) as f64;
        match rows {
            Some(rows) if !again => {
                let more =
                    (ROWS_BUDGET / (self.cost() * seen as f64)).max(1.0).min((height - rows) as f64) as usize;
                self.rows(pane, request, rows, rows + more)
            }
            _ if again || estimate <= BUDGET => self.rows(pane, request, 0, height),
            _ => {
                let divisor = ((estimate / BUDGET).sqrt().ceil() as usize).clamp(2, COARSEST);
                self.coarse(pane, request, divisor)
            }
        }
    }

    /// Draws rows of the fine picture.
    fn rows(&mut self, pane: usize, request: &Request, first: usize, end: usize) -> Result<Drawn> {
        let [from, to] = request.columns;
        let part = [[from, first], [to - from, end - first]];
        let time = self.fill(pane, FINE, request, request.scene.size, part)?;
        let Some(pane) = &mut self.panes[pane] else { return Ok(Drawn::default()) };
        pane.spent = if first == 0 { time } else { pane.spent + time };
        pane.rows = end;
        pane.shows = Some(request.clone());
        let is_partial = end < request.scene.size[1];
        Ok(Drawn { time: (!is_partial).then_some(pane.spent), is_partial, ..Drawn::default() })
    }

    /// Draws the coarse picture, a pixel for so many on each side.
    fn coarse(&mut self, pane: usize, request: &Request, divisor: usize) -> Result<Drawn> {
        let size = request.scene.size.map(|n| n.div_ceil(divisor));
        let old = self.panes[pane].as_mut().and_then(|pane| pane.coarse.take());
        let coarse = self.target(old, size, wgpu::FilterMode::Linear);
        if let Some(pane) = &mut self.panes[pane] {
            pane.coarse = Some(coarse);
        }
        let from = request.columns[0] / divisor;
        let to = request.columns[1].div_ceil(divisor);
        let time = self.fill(pane, COARSE, request, size, [[from, 0], [to - from, size[1]]])?;
        if let Some(pane) = &mut self.panes[pane] {
            pane.shows = Some(request.clone());
            pane.rows = 0;
            pane.since = Instant::now();
        }
        Ok(Drawn { time: Some(time), is_partial: true, rest: REST })
    }

    /// Draws a part of the fine or coarse texture of a pane and waits for it; what that took.
    fn fill(
        &mut self,
        pane: usize,
        which: usize,
        request: &Request,
        size: [usize; 2],
        part: [[usize; 2]; 2],
    ) -> Result<Duration> {
        let start = Instant::now();
        // The options have the exposure: a scene that changes is uploaded anew.
        let scene = Scene { size, exposure_stops: 0.0, ..request.scene.clone() };
        let finds = which == COARSE && !has_mesh(&scene);
        for worn in &request.worn {
            match worn {
                Worn::Paint(ready) => self.upload(ready)?,
                Worn::Blend(blend) => {
                    let number = number_of(worn, &request.worn);
                    self.realize(blend, finds.then_some((&scene, number)))?;
                }
            }
        }
        let on_gpu = |worn| on_gpu(&self.paints, &self.mixes, worn);
        let paints: Option<Vec<&GpuPaint>> = request.worn.iter().map(on_gpu).collect();
        let (Some(pane), Some(paints)) = (&self.panes[pane], paints) else {
            return Ok(Duration::ZERO);
        };
        let Some(target) = (if which == FINE { Some(&pane.fine) } else { pane.coarse.as_ref() }) else {
            return Ok(Duration::ZERO);
        };
        let options = FrameOptions {
            seed: request.seed,
            flakes: request.flakes,
            exposure_stops: request.scene.exposure_stops,
            part: Some(part.map(|pair| pair.map(|n| n as u32))),
            // What a software adapter takes seconds for.
            rows: self.gpu.is_software(),
            around: self.sees_around(),
            ..FrameOptions::default()
        };
        let view = target.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size = size.map(|n| n as u32);
        self.renderers[which].draw(&self.gpu, &scene, &paints, &options, &view, size)?;
        let waited = self.state.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|e| Error::gpu(self.gpu.name(), "picture", e, "an end"))?;
        let time = start.elapsed();
        let pixels = part[1][0] * part[1][1];
        self.costs = [self.costs[1], time.as_secs_f64() / pixels.max(1) as f64];
        Ok(time)
    }

    /// Whether flakes sparkle under the surroundings.
    fn sees_around(&self) -> bool {
        !self.gpu.is_software()
    }

    /// Makes a blend of its mix, for a coarse picture of a scene only what that draws from, where the blend is worn as this number
    /// (none: as several). A hand that moves a weight sees coarse pictures of one scene, and what they need is soon found. For fine
    /// ones that takes longer than it spares, so they get all of it; what is missing at the same weights is added.
    fn realize(&mut self, blend: &Blend, coarse: Option<(&Scene, Option<usize>)>) -> Result<()> {
        let sees_around = self.sees_around();
        let Some(mix) = self.mixes[blend.slot].as_mut().and_then(Held::mix_mut) else { return Ok(()) };
        let Some((scene, number)) = coarse else {
            return mix.realize(&self.gpu, &blend.weights, &blend.options).map(drop);
        };
        // Flakes that only surroundings light are not drawn where these light none.
        let dark = Environment::Constant { radiance: [0.0; 3] };
        let environment = if sees_around { scene.environment.clone() } else { dark };
        let lit = Scene { environment, ..scene.clone() };
        mix.realize_for(&self.gpu, &blend.weights, &blend.options, &lit, number).map(drop)
    }

    /// Brings a paint to the GPU and to the end of the list.
    fn upload(&mut self, ready: &Arc<Ready>) -> Result<()> {
        let kept = match self.paints.iter().position(|(other, _)| Arc::ptr_eq(other, ready)) {
            Some(k) => self.paints.remove(k),
            None => (ready.clone(), GpuPaint::new(&self.gpu, &ready.paint)?),
        };
        self.paints.push(kept);
        let surplus = self.paints.len().saturating_sub(KEPT);
        self.paints.drain(..surplus);
        Ok(())
    }

    /// Textures of the size for a pane; what was drawn in those of another size goes.
    fn make_pane(&mut self, pane: usize, size: [usize; 2]) {
        let fits =
            |target: &Target| [target.texture.width(), target.texture.height()] == size.map(|n| n as u32);
        if self.panes[pane].as_ref().is_some_and(|pane| fits(&pane.fine)) {
            return;
        }
        let old = self.panes[pane].take();
        let (fine, coarse) = old.map_or((None, None), |pane| (Some(pane.fine), pane.coarse));
        let fine = self.target(fine, size, wgpu::FilterMode::Nearest);
        self.panes[pane] =
            Some(Pane { fine, coarse, since: Instant::now(), shows: None, rows: 0, spent: Duration::ZERO });
    }

    /// A texture of the size: the old one, or another in its place.
    fn target(&self, old: Option<Target>, size: [usize; 2], filter: wgpu::FilterMode) -> Target {
        let [width, height] = size.map(|n| n as u32);
        if let Some(old) =
            old.as_ref().filter(|old| [old.texture.width(), old.texture.height()] == [width, height])
        {
            return Target { texture: old.texture.clone(), id: old.id };
        }
        let texture = self.state.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: USAGE,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut renderer = self.state.renderer.write();
        let id = match old {
            Some(old) => {
                renderer.update_egui_texture_from_wgpu_texture(&self.state.device, &view, filter, old.id);
                old.id
            }
            None => renderer.register_native_texture(&self.state.device, &view, filter),
        };
        Target { texture, id }
    }
}

/// What is worn, on the GPU.
fn on_gpu<'a>(
    paints: &'a [(Arc<Ready>, GpuPaint)],
    mixes: &'a [Option<Held>],
    worn: &Worn,
) -> Option<&'a GpuPaint> {
    match worn {
        Worn::Paint(ready) => paints.iter().find(|(kept, _)| Arc::ptr_eq(kept, ready)).map(|(_, p)| p),
        Worn::Blend(blend) => mixes[blend.slot].as_ref().and_then(Held::mix).map(GpuMix::paint),
    }
}

/// Whether rays meet a mesh, which would be made ready again to find what they need.
fn has_mesh(scene: &Scene) -> bool {
    let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh { .. } | Shape::SpeedShape { .. });
    match scene.objects.as_slice() {
        [] => is_mesh(&scene.shape),
        objects => objects.iter().any(|object| is_mesh(&object.shape)),
    }
}

/// How a window asks for its device: an adapter whose name contains `wanted`, in any case, of several the best one (discrete
/// before integrated, software last), with the limits that pictures need.
pub fn setup(wanted: Option<String>) -> eframe::egui_wgpu::WgpuSetupCreateNew {
    let name = |info: &wgpu::AdapterInfo| format!("{} ({})", info.name, info.backend);
    let choose = move |adapters: &[wgpu::Adapter], surface: Option<&wgpu::Surface<'_>>| {
        let fits = |adapter: &&wgpu::Adapter| {
            let is_wanted = |w: &String| name(&adapter.get_info()).to_lowercase().contains(&w.to_lowercase());
            wanted.as_ref().is_none_or(is_wanted) && surface.is_none_or(|s| adapter.is_surface_supported(s))
        };
        let best = adapters.iter().filter(fits).min_by_key(|adapter| rank(&adapter.get_info()));
        best.cloned().ok_or_else(|| {
            let all: Vec<String> = adapters.iter().map(|adapter| name(&adapter.get_info())).collect();
            let found = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
            match &wanted {
                Some(wanted) => format!("none named {wanted} that can show a window; there are: {found}"),
                None => format!("none that can show a window; there are: {found}"),
            }
        })
    };
    eframe::egui_wgpu::WgpuSetupCreateNew {
        native_adapter_selector: Some(Arc::new(choose)),
        device_descriptor: Arc::new(|adapter| wgpu::DeviceDescriptor {
            label: Some("carpaint view"),
            required_limits: Gpu::required_limits().using_resolution(adapter.limits()),
            ..Default::default()
        }),
        ..eframe::egui_wgpu::WgpuSetupCreateNew::without_display_handle()
    }
}

/// Lower is better.
fn rank(info: &wgpu::AdapterInfo) -> (u8, bool) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (kind, info.backend == wgpu::Backend::Gl)
}

#[cfg(test)]
mod tests;
