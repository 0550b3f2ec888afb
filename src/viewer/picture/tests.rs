//! Pictures on a device without a window.

use super::super::recipe::{Sizes, simulated};
use super::super::state::State;
use super::*;
use crate::mix::{BlendOptions, CoupleOptions, couple};
use crate::paint::Paint;
use crate::simulate::Composition;
use crate::viewer::job::Progress;
use eframe::egui_wgpu::{RendererOptions, WgpuConfiguration};
use eframe::wgpu::{BufferDescriptor, BufferUsages, MapMode};
use glam::DVec2;
use std::io::Write;
use std::sync::OnceLock;

/// Rows of a copy start at multiples of 256 bytes: 64 pixels.
const SIZE: [usize; 2] = [128, 96];
/// Of a pixel, seconds: a picture is drawn coarse first, a pixel for 5 x 5, then 15 rows at a time.
const COST: f64 = 1e-4;

/// None, loudly, where there is no adapter; with `CARPAINT_REQUIRE_GPU` that is a failure.
fn pictures() -> Option<Pictures> {
    let configuration = WgpuConfiguration { wgpu_setup: setup(None).into(), ..Default::default() };
    let instance = pollster::block_on(configuration.wgpu_setup.new_instance());
    let state = RenderState::create(&configuration, &instance, None, RendererOptions::default());
    match pollster::block_on(state) {
        Ok(state) => Some(Pictures::new(&state, Waker::default()).unwrap()),
        Err(e) => {
            let is_required = std::env::var_os("CARPAINT_REQUIRE_GPU").is_some();
            assert!(!is_required, "CARPAINT_REQUIRE_GPU is set, but {e}");
            // Not eprintln: the test runner would keep it to itself.
            let _ = writeln!(std::io::stderr(), "SKIPPED: no GPU adapter, pictures were not drawn");
            None
        }
    }
}

/// Two small paints.
fn mix() -> Arc<Mix> {
    static MIX: OnceLock<Arc<Mix>> = OnceLock::new();
    let paint = |text: &str| -> Paint {
        let sizes = Sizes { bins: 4, texels: 32, texel_mm: Some(0.02) };
        simulated("test", &Composition::parse(text).unwrap(), sizes, &Progress::silent()).unwrap()
    };
    let couple_both = || {
        let one = paint(include_str!("../../../fixtures/compositions/brown_metallic.toml"));
        let two = paint(include_str!("../../../fixtures/compositions/blue_metallic.toml"));
        let named = [("one".to_owned(), &one), ("two".to_owned(), &two)];
        Arc::new(couple(&named, &CoupleOptions::default(), &|| ()).unwrap().0)
    };
    MIX.get_or_init(couple_both).clone()
}

fn blend(mix: &Arc<Mix>, weight: f64) -> Blend {
    let weights = vec![weight, 1.0 - weight];
    Blend { mix: mix.clone(), slot: 0, weights, options: BlendOptions::default() }
}

fn request(state: &State, blend: Blend) -> Request {
    let worn = vec![Worn::Blend(blend)];
    Request { scene: state.scene(SIZE), worn, flakes: true, seed: 1, columns: [0, SIZE[0]] }
}

/// Waits until the mixes of a request are there.
fn wait(pictures: &mut Pictures, request: &Request) {
    for worn in &request.worn {
        let Worn::Blend(blend) = worn else { continue };
        pictures.hold(blend).unwrap();
        while !pictures.work().is_empty() {
            std::thread::yield_now();
            pictures.hold(blend).unwrap();
        }
    }
}

/// Draws the coarse picture of something new.
fn draw_coarse(pictures: &mut Pictures, request: &Request) {
    pictures.costs = [COST; 2];
    let drawn = pictures.draw(0, request, false, true).unwrap();
    assert!(drawn.time.is_some() && drawn.is_partial, "{drawn:?}");
    assert_eq!(pictures.layers(0).unwrap().done, 0.0, "nothing of it is fine");
}

/// Draws until all of it is fine.
fn settle(pictures: &mut Pictures, request: &Request) -> Vec<u8> {
    loop {
        pictures.costs = [COST; 2];
        let drawn = pictures.draw(0, request, false, true).unwrap();
        if !drawn.is_partial {
            return read(pictures);
        }
        std::thread::sleep(drawn.rest);
    }
}

/// Codes of the fine picture.
fn read(pictures: &Pictures) -> Vec<u8> {
    let (device, texture) = (&pictures.state.device, &pictures.panes[0].as_ref().unwrap().fine.texture);
    let row = 4 * texture.width();
    let copy = device.create_buffer(&BufferDescriptor {
        label: None,
        size: u64::from(row * texture.height()),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    pictures.state.queue.submit([encoder.finish()]);
    copy.map_async(MapMode::Read, .., |mapped| mapped.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    copy.get_mapped_range(..).unwrap().to_vec()
}

/// How many slices of the blend are there.
fn realized(pictures: &Pictures) -> usize {
    let mix = pictures.mixes[0].as_ref().and_then(Held::mix).unwrap();
    mix.paint().statistics(&pictures.gpu).unwrap().iter().filter(|slice| !slice.is_left_out()).count()
}

#[test]
fn a_blend_made_for_one_picture_is_whole_in_the_next() {
    let (Some(mut moving), Some(mut fresh)) = (pictures(), pictures()) else { return };
    let mix = mix();
    let mut state = State::default();
    let first = request(&state, blend(&mix, 0.9));
    wait(&mut moving, &first);
    wait(&mut fresh, &first);
    settle(&mut moving, &first);
    let all = realized(&moving);
    // What the hand changes after a weight has moved; nothing: it rests.
    for (k, what) in ["nothing", "eye", "nearness", "lamp", "object"].into_iter().enumerate() {
        // From the second weight on it is known what the coarse picture needs.
        for step in 0..3 {
            let weight = 0.8 - 0.1 * k as f64 - 0.01 * f64::from(step);
            draw_coarse(&mut moving, &request(&state, blend(&mix, weight)));
        }
        assert!(realized(&moving) < all / 2, "{what}: {} of {all}", realized(&moving));
        match what {
            "eye" => state.orbit.orbit(DVec2::new(150.0, 60.0)),
            "nearness" => state.orbit.zoom(30.0, DVec2::ZERO),
            "lamp" => state.lamp.azimuth_deg += 50.0,
            "object" => state.next_object(),
            _ => {}
        }
        let last = request(&state, blend(&mix, 0.78 - 0.1 * k as f64));
        // Another device has never seen another picture of these weights.
        assert!(settle(&mut moving, &last) == settle(&mut fresh, &last), "{what}");
    }
}

#[test]
fn nobody_waits_for_a_mix_on_its_way() {
    let Some(mut pictures) = pictures() else { return };
    let request = request(&State::default(), blend(&mix(), 0.5));
    let Worn::Blend(blend) = &request.worn[0] else { panic!("a blend") };
    pictures.hold(blend).unwrap();
    assert_eq!(pictures.work().len(), 1, "it is on its way");
    let drawn = pictures.draw(0, &request, false, true).unwrap();
    assert_eq!(drawn, Drawn { time: None, is_partial: true, rest: Duration::MAX });
    assert!(pictures.layers(0).is_none(), "nothing is shown yet");
    wait(&mut pictures, &request);
    assert!(settle(&mut pictures, &request).iter().any(|code| *code != 0));
    // Another document: its mix comes, this one goes.
    pictures.forget_others(None);
    assert!(!pictures.is_here(&request.worn[0]));
}
