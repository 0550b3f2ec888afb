//! The polygon in which one point sets all weights.

use super::super::document::Document;
use super::super::places::Places;
use super::super::state::State;
use super::super::weights;
use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2};
use glam::DVec2;

/// Height of the pad, points.
const HEIGHT: f32 = 190.0;
/// Room for names around the polygon, points.
const MARGIN: f32 = 30.0;
/// Size of the polygon against the pad where points may leave it.
const SHRUNK: f32 = 0.55;

/// From weights' places to points of the window.
struct Frame {
    middle: Pos2,
    scale: f32,
}

impl Frame {
    fn new(rect: Rect, n: usize, extrapolates: bool) -> Self {
        let heights = (0..n).map(|k| weights::corner(k, n).y as f32);
        let (top, foot) = heights.fold((1.0f32, -1.0f32), |(top, foot), y| (top.min(y), foot.max(y)));
        let full = (rect.height() - 2.0 * MARGIN) / (foot - top);
        let scale = if extrapolates { SHRUNK * full } else { full };
        Self { middle: rect.center() - Vec2::new(0.0, 0.5 * scale * (top + foot)), scale }
    }

    fn point(&self, place: DVec2) -> Pos2 {
        self.middle + self.scale * Vec2::new(place.x as f32, place.y as f32)
    }

    fn place(&self, point: Pos2) -> DVec2 {
        let offset = (point - self.middle) / self.scale;
        DVec2::new(f64::from(offset.x), f64::from(offset.y))
    }
}

/// The pad of three or more paints.
pub fn show(ui: &mut Ui, places: &mut Places, state: &mut State, document: &Document, colors: &[Color32]) {
    let n = document.paints.len();
    let size = Vec2::new(ui.available_width(), HEIGHT);
    let (response, painter) = ui.allocate_painter(size, Sense::click_and_drag());
    let frame = Frame::new(response.rect, n, state.extrapolates);
    if let Some(pointer) = response.interact_pointer_pos() {
        state.weights = weights::at_place(frame.place(pointer), n);
        let range = state.weight_range();
        weights::clamp(&mut state.weights, range);
    }
    places.note("pad", response.rect);
    let corners: Vec<Pos2> = (0..n).map(|k| frame.point(weights::corner(k, n))).collect();
    for (k, corner) in corners.iter().enumerate() {
        places.note(format!("pad corner {}", k + 1), Rect::from_center_size(*corner, Vec2::splat(2.0)));
    }
    let visuals = ui.visuals();
    painter.rect_filled(response.rect, 4.0, visuals.extreme_bg_color);
    let rim = Stroke::new(1.0, visuals.weak_text_color());
    painter.add(Shape::closed_line(corners.clone(), rim));
    for (k, corner) in corners.iter().enumerate() {
        let color = colors.get(k).copied().unwrap_or(Color32::GRAY);
        painter.circle(*corner, 7.0, color, rim);
        let outward = weights::corner(k, n);
        let side = if outward.y < 0.1 { (-13.0, Align2::CENTER_BOTTOM) } else { (12.0, Align2::CENTER_TOP) };
        let text = &document.paints[k].name;
        painter.text(
            *corner + Vec2::new(0.0, side.0),
            side.1,
            text,
            FontId::proportional(11.0),
            visuals.text_color(),
        );
    }
    let handle = frame.point(weights::place(&state.weights)).clamp(response.rect.min, response.rect.max);
    painter.circle(handle, 6.0, visuals.strong_text_color(), Stroke::new(2.0, visuals.extreme_bg_color));
    response.on_hover_text("Drag the point: the nearer a corner, the more of its paint");
}
