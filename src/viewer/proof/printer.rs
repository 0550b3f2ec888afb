//! What the thread behind the window does with an order: dots and inks, coarse pictures where they take long, fine ones.

use super::super::waker::Waker;
use super::engine::Engine;
use super::made::{Made, Maker};
use super::press::{Proof, Shared};
use super::request::{Order, Request};
use super::stages::{Stage, stages};
use crate::error::Result;
use crate::render::{Picture, ToneMap};
use crate::scene::Scene;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A coarse picture must stay as it is for so long before it becomes fine: nobody waits for a fine one while something moves.
const REST: Duration = Duration::from_millis(150);

/// What the thread has.
pub struct Printer {
    engine: Engine,
    waker: Waker,
    shared: Arc<Shared>,
    maker: Maker,
    /// What a ray costs, seconds, as the last picture had it.
    ray: f64,
    /// Pictures as fine as they get, of the last order that came so far.
    fine: Vec<(Request, Picture)>,
}

impl Printer {
    /// Takes its orders from there.
    pub fn new(engine: Engine, waker: Waker, shared: Arc<Shared>) -> Self {
        Self { ray: engine.guess(), engine, waker, shared, maker: Maker::default(), fine: Vec::new() }
    }

    /// Makes one order after the other until the window is closed.
    pub fn run(mut self) {
        while let Some((number, order)) = self.shared.next() {
            let outcome = self.make(number, &order);
            self.shared.finish(number, outcome);
            self.waker.wake();
        }
    }

    /// Makes the pictures of an order, unless there is a newer one.
    fn make(&mut self, number: u64, order: &Order) -> Result<()> {
        if order.requests.iter().all(|request| self.known(request).is_some()) {
            let mut stops = order.stops;
            for (pane, request) in order.requests.iter().enumerate() {
                if let Some(picture) = self.known(request) {
                    self.deliver(pane, picture, &mut stops, Stage::LAST, Duration::ZERO);
                }
            }
            return Ok(());
        }
        self.shared.does("making dots and inks", 0.0);
        self.waker.wake();
        let made = order.requests.iter().map(|request| self.maker.make(request));
        let made = made.collect::<Result<Vec<Made>>>()?;
        let pixels = order.requests.iter().map(|r| r.scene.size[0] * r.scene.size[1]).sum();
        let mut fine = Vec::new();
        for stage in stages(pixels, self.ray) {
            let mut stops = order.stops;
            for (pane, (request, made)) in order.requests.iter().zip(&made).enumerate() {
                let start = Instant::now();
                let Some(picture) = self.render(number, request, made, stage)? else { return Ok(()) };
                self.deliver(pane, &picture, &mut stops, stage, start.elapsed());
                if stage == Stage::LAST {
                    fine.push((request.clone(), picture));
                }
            }
            if stage.divisor > 1 && !self.shared.rests(number, REST) {
                return Ok(());
            }
        }
        self.fine = fine;
        Ok(())
    }

    /// The fine picture of a request, if it is there.
    fn known(&self, request: &Request) -> Option<&Picture> {
        self.fine.iter().find(|(known, _)| known == request).map(|(_, picture)| picture)
    }

    /// A step of a picture; none if there is a newer order.
    fn render(
        &mut self,
        number: u64,
        request: &Request,
        made: &Made,
        stage: Stage,
    ) -> Result<Option<Picture>> {
        let scene = Scene { size: stage.size(request.scene.size), ..request.scene.clone() };
        let (shared, waker) = (&self.shared, &self.waker);
        let goes_on = |share: f32| {
            if stage.divisor == 1 {
                shared.does("rendering", share);
                waker.wake();
            }
            shared.is_wanted(number)
        };
        let start = Instant::now();
        let picture = self.engine.render(&scene, made, stage.rays, &goes_on)?;
        if picture.is_some() {
            let rays = scene.size[0] * scene.size[1] * stage.rays;
            self.ray = start.elapsed().as_secs_f64() / rays as f64;
        }
        Ok(picture)
    }

    /// Hands a picture over; where nobody sets the exposure, the first one does, for itself and the other.
    fn deliver(&self, pane: usize, picture: &Picture, stops: &mut Option<f64>, stage: Stage, time: Duration) {
        let stops = *stops.get_or_insert_with(|| picture.exposure(Picture::WHITE_SHARE));
        let codes = picture.encode(stops, &ToneMap::InGamut);
        let time = (stage == Stage::LAST).then_some(time);
        let proof = Proof { pane, size: picture.size, stops, codes, is_coarse: stage.divisor > 1, time };
        self.shared.deliver(proof);
        self.waker.wake();
    }
}
