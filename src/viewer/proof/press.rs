//! A thread that makes what the window shows of a print: the newest order counts, older ones are left where they are.

use super::super::waker::Waker;
use super::engine::Engine;
use super::printer::Printer;
use super::request::Order;
use crate::error::{Error, Result};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// A picture for the window.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// Its number in the order.
    pub pane: usize,
    /// Columns and rows, fewer than asked for where it is coarse.
    pub size: [usize; 2],
    /// Its exposure, stops.
    pub stops: f64,
    /// sRGB, brought into its gamut.
    pub codes: Vec<[u8; 3]>,
    /// Whether a pixel stands for several.
    pub is_coarse: bool,
    /// What it took, for one that is as fine as it gets.
    pub time: Option<Duration>,
}

/// The thread, and what goes to and fro.
pub struct Press {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    /// The last order.
    asked: Option<Order>,
}

/// What goes to and fro.
#[derive(Default)]
pub struct Shared {
    desk: Mutex<Desk>,
    /// Rings when there is an order.
    bell: Condvar,
}

#[derive(Default)]
struct Desk {
    /// The newest order, until it is taken.
    order: Option<Order>,
    /// Orders so far.
    newest: u64,
    /// Orders until the last one that came to an end.
    finished: u64,
    is_closed: bool,
    /// What is being done, and the share of it that is done.
    work: Option<(&'static str, f32)>,
    outcomes: Vec<Result<Proof>>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next order, and its number; none when the window is closed.
    pub fn next(&self) -> Option<(u64, Order)> {
        let mut desk = self.lock();
        loop {
            if desk.is_closed {
                return None;
            }
            if let Some(order) = desk.order.take() {
                return Some((desk.newest, order));
            }
            desk = self.bell.wait(desk).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Whether an order is the newest one.
    pub fn is_wanted(&self, number: u64) -> bool {
        let desk = self.lock();
        desk.newest == number && !desk.is_closed
    }

    /// Waits; whether an order is still the newest one then.
    pub fn rests(&self, number: u64, rest: Duration) -> bool {
        let is_wanted = |desk: &mut Desk| desk.newest == number && !desk.is_closed;
        let waited = self.bell.wait_timeout_while(self.lock(), rest, is_wanted);
        is_wanted(&mut waited.unwrap_or_else(PoisonError::into_inner).0)
    }

    /// Says what is being done, and the share of it that is done.
    pub fn does(&self, what: &'static str, share: f32) {
        self.lock().work = Some((what, share));
    }

    /// Hands a picture over.
    pub fn deliver(&self, proof: Proof) {
        self.lock().outcomes.push(Ok(proof));
    }

    /// An order came to an end, or was left for a newer one.
    pub fn finish(&self, number: u64, outcome: Result<()>) {
        let mut desk = self.lock();
        desk.work = None;
        desk.finished = number;
        desk.outcomes.extend(outcome.err().map(Err));
    }
}

impl Press {
    /// Starts the thread.
    pub fn new(engine: Engine, waker: Waker) -> Self {
        let shared = Arc::new(Shared::default());
        let printer = Printer::new(engine, waker, shared.clone());
        let thread = Some(std::thread::spawn(move || printer.run()));
        Self { shared, thread, asked: None }
    }

    /// Asks for pictures in place of those before; if they are the same, nothing is done.
    pub fn ask(&mut self, order: Order) {
        if self.asked.as_ref() != Some(&order) {
            self.asked = Some(order.clone());
            let mut desk = self.shared.lock();
            desk.newest += 1;
            desk.order = Some(order);
            self.shared.bell.notify_all();
        }
    }

    /// Whether all that was asked for was made, as fine as it gets, or failed.
    pub fn is_settled(&self) -> bool {
        let desk = self.shared.lock();
        desk.newest == desk.finished && desk.outcomes.is_empty()
    }

    /// What is being done, and the share of it that is done.
    pub fn work(&self) -> Option<(String, f32)> {
        self.shared.lock().work.map(|(what, share)| (what.to_owned(), share))
    }

    /// Pictures that have been made since, and what went wrong.
    pub fn take(&mut self) -> Vec<Result<Proof>> {
        let mut outcomes = std::mem::take(&mut self.shared.lock().outcomes);
        if self.thread.take_if(|thread| thread.is_finished()).is_some() {
            let mut desk = self.shared.lock();
            desk.finished = desk.newest;
            outcomes.push(Err(Error::invalid("view", "thread", "one that broke down", "one that goes on")));
        }
        outcomes
    }
}

impl Drop for Press {
    /// The driver ends with the program: nobody may be using it then.
    fn drop(&mut self) {
        self.shared.lock().is_closed = true;
        self.shared.bell.notify_all();
        if let Some(thread) = self.thread.take() {
            // One that broke down has nothing to say any more.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::choices::Layout;
    use super::super::desk::tests::desk;
    use super::super::made::Maker;
    use super::super::stages::Stage;
    use super::*;
    use crate::gpu::Gpu;
    use crate::render::{InkModel, Options, Picture, ToneMap, render_print};

    const SIZE: [usize; 2] = [40, 30];

    /// All pictures until an order is finished.
    fn finished(press: &mut Press) -> Vec<Proof> {
        let mut proofs = Vec::new();
        loop {
            let is_settled = press.is_settled();
            proofs.extend(press.take().into_iter().map(Result::unwrap));
            if is_settled {
                return proofs;
            }
            std::thread::yield_now();
        }
    }

    fn order(desk: &super::super::desk::Desk) -> Order {
        desk.order(&[SIZE; 2]).unwrap().unwrap()
    }

    /// The first picture by the reference renderer.
    fn reference(desk: &super::super::desk::Desk) -> Picture {
        let request = desk.request(InkModel::Goniochromatic, SIZE).unwrap().unwrap();
        let made = Maker::default().make(&request).unwrap();
        let options = Options { samples: Stage::LAST.rays, ..Options::default() };
        render_print(&request.scene, &made.print(), &options, &|| ()).unwrap()
    }

    #[test]
    fn the_last_picture_is_that_of_the_reference_renderer() {
        let mut desk = desk();
        desk.state.auto_exposure = false;
        let mut press = Press::new(Engine::Cpu, Waker::default());
        press.ask(order(&desk));
        let last = finished(&mut press).pop().unwrap();
        let picture = reference(&desk);
        assert_eq!(last.codes, picture.encode(0.0, &ToneMap::InGamut));
        // Nothing has changed, then only the exposure: nothing is rendered, which would bring a coarse picture or none at all.
        press.ask(order(&desk));
        assert!(press.is_settled() && press.take().is_empty());
        desk.state.exposure_stops = 1.0;
        press.ask(order(&desk));
        let [brighter] = &finished(&mut press)[..] else { panic!("one picture") };
        assert_eq!(brighter.time, Some(Duration::ZERO));
        assert_eq!(brighter.codes, picture.encode(1.0, &ToneMap::InGamut));
    }

    #[test]
    fn an_exposure_that_nobody_sets_follows_the_first_picture_and_settles() {
        let mut desk = desk();
        desk.state.layout = Layout::SideBySide;
        let mut press = Press::new(Engine::Cpu, Waker::default());
        press.ask(order(&desk));
        let [first, second] = &finished(&mut press)[..] else { panic!("two pictures") };
        let picture = reference(&desk);
        let stops = picture.exposure(Picture::WHITE_SHARE);
        assert_ne!(stops, desk.state.exposure_stops, "nothing would follow");
        assert_eq!([first.stops, second.stops], [stops; 2]);
        assert_eq!(first.codes, picture.encode(stops, &ToneMap::InGamut));
        // What the window learns of it asks for nothing anew.
        desk.state.exposed(stops);
        assert_eq!(desk.state.exposure_stops, stops);
        press.ask(order(&desk));
        assert!(press.is_settled() && press.take().is_empty());
        // A user who takes over begins with what is seen, and is not overruled.
        desk.state.auto_exposure = false;
        desk.state.exposed(stops + 1.0);
        press.ask(order(&desk));
        let [same, _] = &finished(&mut press)[..] else { panic!("two pictures") };
        assert_eq!((same.stops, &same.codes), (stops, &first.codes));
    }

    #[test]
    fn the_newest_order_is_what_comes_at_last() {
        let mut desk = desk();
        let mut press = Press::new(Engine::Cpu, Waker::default());
        for _ in 0..20 {
            desk.state.lamp.azimuth_deg += 3.0;
            press.ask(order(&desk));
        }
        let last = finished(&mut press).pop().unwrap();
        let mut other = Press::new(Engine::Cpu, Waker::default());
        other.ask(order(&desk));
        assert_eq!(last.codes, finished(&mut other).pop().unwrap().codes);
        assert_eq!(last.size, SIZE);
    }

    #[test]
    fn what_goes_wrong_is_said_once() {
        let mut desk = desk();
        desk.state.cell = 33;
        let mut press = Press::new(Engine::Cpu, Waker::default());
        press.ask(order(&desk));
        while !press.is_settled() {
            if let Some(outcome) = press.take().pop() {
                assert!(outcome.unwrap_err().to_string().contains("cell"));
                assert!(press.is_settled() && press.take().is_empty());
                return;
            }
            std::thread::yield_now();
        }
        panic!("nothing was said");
    }

    #[test]
    fn a_gpu_shows_what_the_reference_renderer_shows() {
        let Ok(gpu) = Gpu::new(None) else {
            assert!(std::env::var_os("CARPAINT_REQUIRE_GPU").is_none(), "CARPAINT_REQUIRE_GPU is set");
            return;
        };
        let mut on_gpu = Engine::on(gpu);
        let desk = desk();
        for model in InkModel::ALL {
            let request = desk.request(model, SIZE).unwrap().unwrap();
            let made = Maker::default().make(&request).unwrap();
            let picture = |engine: &mut Engine| {
                engine
                    .render(&request.scene, &made, 2, &|_| true)
                    .unwrap()
                    .unwrap()
                    .encode(0.0, &ToneMap::InGamut)
            };
            let [a, b] = [picture(&mut on_gpu), picture(&mut Engine::Cpu)];
            let far = a.iter().flatten().zip(b.iter().flatten()).filter(|(a, b)| a.abs_diff(**b) > 1).count();
            // Roundings of f32, and a ray at an edge now and then that meets it on one side only.
            assert!(far <= 3 * SIZE[0], "{model:?}: {far}");
        }
    }
}
