//! The parts of the window that show pictures.

use super::super::measure::Spot;
use super::super::panels::{self, measure, view};
use super::super::picture::Request;
use super::super::stage;
use super::super::state::{Layout, Object, Shown, State};
use super::super::worn::Worn;
use super::Window;
use crate::error::Result;
use crate::scene::Scene;
use eframe::egui::{Align2, Color32, Context, FontId, Rect, Response, Sense, Ui, Vec2};
use serde_json::{Value, json};
use std::time::Duration;

/// A part of the window that shows a picture.
pub struct Pane {
    pub index: usize,
    /// All of the picture, points.
    pub rect: Rect,
    /// What of it is seen.
    pub clip: Rect,
    pub shown: Shown,
}

impl Window {
    /// What a picture shows; sees to it that mixes come to the GPU, or their blends to the CPU where it does not take them.
    pub(super) fn request(&mut self, shown: Shown, size: [usize; 2], columns: [usize; 2]) -> Result<Request> {
        let scene = self.desk.state.scene(size);
        let mut worn = self.desk.worn(shown)?;
        for one in &worn {
            if let Worn::Blend(blend) = one
                && let Err(e) = self.pictures.hold(blend)
            {
                // Of a device that is gone nothing can be learned.
                if self.shell.loss.is_found() {
                    return Err(e);
                }
                self.desk.blend_here(&e);
                worn = self.desk.worn(shown)?;
                break;
            }
        }
        let (flakes, seed) = (self.desk.state.flakes, self.desk.state.seed);
        Ok(Request { scene, worn, flakes, seed, columns })
    }

    /// Where pictures go in the middle of the window.
    fn lay_out(&self, rect: Rect) -> Vec<Pane> {
        let State { layout, divider, shown, .. } = &self.desk.state;
        let areas = areas(rect, *layout, *divider).into_iter().zip(shown);
        areas
            .enumerate()
            .map(|(index, ([rect, clip], shown))| Pane { index, rect, clip, shown: *shown })
            .collect()
    }

    /// Pictures, and what the mouse does in them.
    pub(super) fn middle(&mut self, ui: &mut Ui) {
        let rect = ui.max_rect();
        self.panes = self.lay_out(rect);
        self.shell.places.note("picture", rect);
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        self.spot = None;
        self.is_settled = true;
        self.rest = Duration::MAX;
        let mut has_picture = false;
        for k in 0..self.panes.len() {
            has_picture |= self.pane(ui, &response, k);
        }
        if self.desk.state.layout == Layout::Split {
            panels::picture::divider(ui, &mut self.shell.places, rect, &mut self.desk.state.divider);
        }
        if has_picture {
            let height = pixels(rect, ui.ctx())[1].max(1);
            measure::scale_bar(ui, rect, self.desk.state.orbit.field_mm() / height as f64);
        }
    }

    /// One of them; whether it shows a picture.
    fn pane(&mut self, ui: &Ui, response: &Response, k: usize) -> bool {
        let Pane { index, rect, clip, shown } = self.panes[k];
        let size = pixels(rect, ui.ctx());
        // Of a window that is closed to a slit there is nothing to draw.
        if size.contains(&0) || clip.width() < 1.0 {
            return false;
        }
        let scene = self.desk.state.scene(size);
        match self.bodies.changed(&scene) {
            Ok(bodies) => self.bodies = bodies,
            Err(e) => self.desk.fail(&e),
        }
        let pointer = ui.input(|i| i.pointer.latest_pos());
        // Where a drag began counts, wherever it has led since.
        let held = ui.input(|i| i.pointer.press_origin()).filter(|_| response.dragged()).or(pointer);
        if held.is_some_and(|p| clip.contains(p)) {
            let world = (&scene, &self.bodies);
            panels::picture::drag(ui, response, rect, &mut self.desk.state, world, &mut self.grip);
        }
        if self.desk.one(shown).is_none() {
            self.wait(ui, clip);
            return false;
        }
        let drawn = self.draw(index, shown, size, columns(rect, clip, size[0]));
        if let Err(e) = &drawn
            && !self.shell.loss.is_known()
        {
            self.desk.fail(e);
        }
        match self.pictures.layers(index) {
            Some(layers) => panels::picture::layers(&ui.painter_at(clip), rect, layers),
            None if !self.pictures.work().is_empty() => self.wait(ui, clip),
            None => {}
        }
        self.caption(ui, k);
        let pointer = pointer.filter(|p| clip.contains(*p) && response.contains_pointer());
        if let (Some(pointer), Ok(request)) = (pointer, &drawn) {
            let at = (pointer - rect.min) * ui.ctx().pixels_per_point();
            let shelf = &mut self.desk.shelf;
            let paint = |k: usize| request.worn.get(k).and_then(|worn| shelf.ready(worn));
            self.spot = Spot::at(&request.scene, &self.bodies, paint, [at.x, at.y].map(f64::from));
        }
        drawn.is_ok()
    }

    /// Which paint it is, where there are two.
    fn caption(&self, ui: &Ui, k: usize) {
        let Pane { clip, shown, .. } = self.panes[k];
        if self.panes.len() > 1 {
            let name = view::shown_name(shown, self.desk.document.as_ref());
            caption(ui, clip, self.desk.state.layout, k, &name);
        }
    }

    /// Says in a pane that there is no paint for it yet.
    fn wait(&self, ui: &Ui, clip: Rect) {
        let text = if self.desk.makes_paints() || !self.pictures.work().is_empty() {
            "making paints ready"
        } else {
            "open a mix, a paint or a composition"
        };
        let font = FontId::proportional(18.0);
        ui.painter_at(clip).text(clip.center(), Align2::CENTER_CENTER, text, font, Color32::GRAY);
    }

    /// Draws a pane anew if it shows something else; what it shows.
    fn draw(&mut self, pane: usize, shown: Shown, size: [usize; 2], columns: [usize; 2]) -> Result<Request> {
        let request = self.request(shown, size, columns)?;
        // One picture becomes fine after the other: what is known of a paint is made anew when another one is drawn.
        let drawn = self.pictures.draw(pane, &request, self.runs, self.is_settled)?;
        if let Some(time) = drawn.time {
            self.times.push(time);
            self.drawn += 1;
            if shown == Shown::Recipe {
                self.desk.kitchen.seen();
            }
        }
        if drawn.is_partial {
            self.is_settled = false;
            self.rest = self.rest.min(drawn.rest);
        }
        Ok(request)
    }

    /// Where the middle of the movable capsule is seen, points; null without the demonstration.
    pub(super) fn movable_place(&self, context: &Context) -> Value {
        let state = &self.desk.state;
        let Some(pane) = self.panes.first().filter(|_| state.object == Object::Demonstration) else {
            return Value::Null;
        };
        let scene = state.scene(pixels(pane.rect, context));
        let Some([x, y]) = stage::seen_at(&scene, state.movable) else { return Value::Null };
        let scale = f64::from(context.pixels_per_point());
        let origin = pane.rect.min;
        json!([f64::from(origin.x) + x / scale, f64::from(origin.y) + y / scale])
    }
}

/// Where the pictures of a layout go, the first one first: all of it, and what of it is seen.
pub fn areas(rect: Rect, layout: Layout, divider: f32) -> Vec<[Rect; 2]> {
    match layout {
        Layout::Single => vec![[rect; 2]],
        Layout::Split => {
            let (left, right) = rect.split_left_right_at_fraction(divider);
            vec![[rect, left], [rect, right]]
        }
        Layout::SideBySide => {
            let (left, right) = rect.split_left_right_at_fraction(0.5);
            let gap = Vec2::new(1.0, 0.0);
            let (left, right) = (
                Rect::from_min_max(left.min, left.max - gap),
                Rect::from_min_max(right.min + gap, right.max),
            );
            vec![[left; 2], [right; 2]]
        }
    }
}

/// What picture `k` of a layout shows, written over it where it is seen.
pub fn caption(ui: &Ui, clip: Rect, layout: Layout, k: usize, text: &str) {
    let (at, anchor) = match (layout, k) {
        (Layout::Split, 1) => (clip.right_top() + Vec2::new(-12.0, 12.0), Align2::RIGHT_TOP),
        _ => (clip.left_top() + Vec2::new(12.0, 12.0), Align2::LEFT_TOP),
    };
    panels::picture::caption(&ui.painter_at(clip), at, anchor, text);
}

/// Size of a rectangle, pixels, as large as a scene may be.
pub fn pixels(rect: Rect, context: &Context) -> [usize; 2] {
    let size = rect.size() * context.pixels_per_point();
    [size.x, size.y].map(|side| (side.round().max(0.0) as usize).min(Scene::MAX_SIDE / 4))
}

/// The columns of a picture in `rect`, `width` pixels wide, that are seen in `clip`.
fn columns(rect: Rect, clip: Rect, width: usize) -> [usize; 2] {
    let at = |x: f32| (x - rect.left()) / rect.width().max(1e-6) * width as f32;
    let first = at(clip.left()).floor().max(0.0) as usize;
    [first.min(width), (at(clip.right()).ceil().max(0.0) as usize).min(width)]
}
