//! The picture itself: what the mouse does in it, and what is written over it.

use super::super::orbit::Orbit;
use super::super::picture::Layers;
use super::super::places::Places;
use super::super::stage::Grip;
use super::super::state::State;
use crate::scene::{Bodies, Scene};
use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Id, Painter, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui,
    Vec2,
};
use glam::DVec2;

/// A field of view lower than this, millimetres, turns about the surface instead of the middle of the object, which would take
/// what is looked at out of sight.
const NEAR_FIELD_MM: f64 = 20.0;
/// Points of the wheel that double the size.
const WHEEL: f64 = 180.0;
/// Half the width of the divider's handle, points.
const GRIP: f32 = 6.0;

/// What the mouse asks for in a pane of `rect`, which shows `scene`.
pub fn drag(
    ui: &Ui,
    response: &Response,
    rect: Rect,
    state: &mut State,
    (scene, bodies): (&Scene, &Bodies),
    grip: &mut Option<Grip>,
) {
    let pixel = |point: Pos2| {
        let offset = (point - rect.min) * ui.ctx().pixels_per_point();
        [f64::from(offset.x), f64::from(offset.y)]
    };
    match asked(ui, response) {
        Some(Drag::Lamp(points)) => state.lamp.turn(points),
        Some(Drag::Pan(points)) => state.orbit.pan(points / f64::from(rect.height())),
        Some(Drag::Turn(points)) => {
            if response.drag_started() {
                let origin = ui.input(|i| i.pointer.press_origin());
                let n = state.weights.len();
                *grip = origin.and_then(|at| Grip::take(scene, bodies, n, pixel(at), state.movable));
                pivot(&mut state.orbit, scene, bodies);
            }
            match (*grip, response.interact_pointer_pos()) {
                (Some(grip), Some(pointer)) => {
                    if let Some(place) = grip.drag(scene, pixel(pointer)) {
                        state.move_capsule(place);
                    }
                }
                _ => state.orbit.orbit(points),
            }
        }
        None => {}
    }
    if response.double_clicked() {
        state.home();
    }
    zoom(ui, response, rect, &mut state.orbit);
}

/// What a drag asks for, by so many points, right and down.
pub enum Drag {
    /// To move the lamp.
    Lamp(DVec2),
    /// To move the object along the picture.
    Pan(DVec2),
    /// To turn the object.
    Turn(DVec2),
}

/// What the buttons ask for.
pub fn asked(ui: &Ui, response: &Response) -> Option<Drag> {
    let modifiers = ui.input(|i| i.modifiers);
    let delta = response.drag_delta();
    let points = DVec2::new(f64::from(delta.x), f64::from(delta.y));
    let by = |button| response.dragged_by(button);
    if by(PointerButton::Secondary) || (by(PointerButton::Primary) && modifiers.ctrl) {
        Some(Drag::Lamp(points))
    } else if by(PointerButton::Middle) || (by(PointerButton::Primary) && modifiers.shift) {
        Some(Drag::Pan(points))
    } else {
        by(PointerButton::Primary).then_some(Drag::Turn(points))
    }
}

/// Comes nearer to what is under the pointer, or goes away, as the wheel asks for.
pub fn zoom(ui: &Ui, response: &Response, rect: Rect, orbit: &mut Orbit) {
    let (wheel, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
    if response.contains_pointer()
        && let Some(pointer) = ui.input(|i| i.pointer.hover_pos())
    {
        let factor = (f64::from(wheel) / WHEEL).exp2() * f64::from(pinch);
        let offset = (pointer - rect.center()) / rect.height();
        if factor != 1.0 {
            orbit.zoom(factor, DVec2::new(f64::from(offset.x), f64::from(offset.y)));
        }
    }
}

/// Near the surface, turns go about what is in the middle of the picture.
pub fn pivot(orbit: &mut Orbit, scene: &Scene, bodies: &Bodies) {
    if orbit.field_mm() > NEAR_FIELD_MM {
        return;
    }
    let view = scene.camera.view(scene.size);
    let middle = view.direction(scene.size[0] as f64 / 2.0, scene.size[1] as f64 / 2.0);
    if let Some(hit) = bodies.intersect(view.origin, middle) {
        orbit.pivot(hit.distance);
    }
}

/// A picture: its coarse form, and over it the rows that are fine.
pub fn layers(painter: &Painter, rect: Rect, layers: Layers) {
    let part = |share: f32| Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, share));
    if let Some(coarse) = layers.coarse.filter(|_| layers.done < 1.0) {
        painter.image(coarse, rect, part(1.0), Color32::WHITE);
    }
    let mut rows = rect;
    rows.set_height(rect.height() * layers.done);
    painter.image(layers.fine, rows, part(layers.done), Color32::WHITE);
}

/// The divider of a split picture, dragged.
pub fn divider(ui: &Ui, places: &mut Places, rect: Rect, share: &mut f32) {
    let x = rect.left() + *share * rect.width();
    let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, rect.y_range());
    let response = ui.interact(grip, Id::unique("divider"), Sense::drag());
    if let Some(pointer) = response.interact_pointer_pos() {
        *share = ((pointer.x - rect.left()) / rect.width()).clamp(0.02, 0.98);
    }
    places.note("divider", grip);
    let painter = ui.painter_at(rect);
    painter.vline(x, rect.y_range(), Stroke::new(3.0, Color32::from_black_alpha(140)));
    painter.vline(x, rect.y_range(), Stroke::new(1.0, Color32::WHITE));
    let middle = Pos2::new(x, rect.center().y);
    painter.circle(middle, 6.0, Color32::from_black_alpha(170), Stroke::new(1.0, Color32::WHITE));
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
}

/// Text over the picture, legible on anything.
pub fn caption(painter: &Painter, at: Pos2, anchor: Align2, text: &str) {
    let font = FontId::proportional(13.0);
    let rect =
        anchor.anchor_size(at, painter.layout_no_wrap(text.to_owned(), font.clone(), Color32::WHITE).size());
    painter.rect_filled(rect.expand2(Vec2::new(4.0, 1.0)), 3.0, Color32::from_black_alpha(150));
    painter.text(at, anchor, text, font, Color32::WHITE);
}
