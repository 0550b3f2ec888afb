//! What instruments read, and how long pictures took.

use super::super::frame_times::FrameTimes;
use super::super::measure::{ASPECULAR_DEG, Instrument, Spot};
use super::controls;
use crate::color::delta_e_2000;
use eframe::egui::{Grid, Pos2, Rect, RichText, Sense, Stroke, Ui, Vec2};
use glam::DVec3;

/// Readings of the first paint, and how far the second is from it; `is_old`: of a blend that has changed since.
pub fn instrument(ui: &mut Ui, first: &Instrument, second: Option<&Instrument>, is_old: bool) {
    controls::heading(ui, if is_old { "Instrument \u{2026}" } else { "Instrument" });
    let hint = "Light at 45\u{00b0}; aspecular angle, from the mirror direction towards the light. L*a*b* under D65 of the \
                mean reflectance factor, gloss left out";
    ui.spacing_mut().interact_size.y = 15.0;
    let response =
        Grid::new("instrument").num_columns(5).spacing([10.0, 0.0]).min_row_height(15.0).show(ui, |ui| {
            let last = if second.is_some() { "\u{0394}E\u{2080}\u{2080}" } else { "" };
            for head in ["45\u{00b0} as", "L*", "a*", "b*", last] {
                ui.label(RichText::new(head).weak());
            }
            ui.end_row();
            for (k, aspecular) in ASPECULAR_DEG.iter().enumerate() {
                ui.monospace(format!("{aspecular:3.0}\u{00b0}"));
                numbers(ui, first.labs[k]);
                if let Some(second) = second {
                    ui.monospace(format!("{:5.1}", delta_e_2000(first.labs[k], second.labs[k])));
                }
                ui.end_row();
            }
        });
    response.response.on_hover_text(hint);
    let flop = |of: &Instrument| of.flop_index.map_or("\u{2013}".to_owned(), |flop| format!("{flop:.2}"));
    let text = match second {
        Some(second) => format!("flop index {}, of the second {}", flop(first), flop(second)),
        None => format!("flop index {}", flop(first)),
    };
    ui.label(text)
        .on_hover_text("2.69 (L*15 - L*110)^1.11 / L*45^0.86 (Alman 1987); 0: alike from everywhere");
}

fn numbers(ui: &mut Ui, lab: DVec3) {
    for value in lab.to_array() {
        ui.monospace(format!("{value:6.1}"));
    }
}

/// What is under the pointer.
pub fn spot(ui: &mut Ui, spot: Option<&Spot>) {
    controls::heading(ui, "At the pointer");
    let Some(spot) = spot else {
        ui.label(RichText::new("rest the pointer on lit paint").weak());
        ui.label("");
        return;
    };
    let [l, a, b] = spot.lab.to_array();
    ui.monospace(format!("L* {l:.1}  a* {a:.1}  b* {b:.1}"))
        .on_hover_text("Mean reflectance factor under the lamp, gloss left out, D65");
    let Spot { theta_h_deg: h, theta_i_deg: i, aspecular_deg, .. } = spot;
    ui.monospace(format!("\u{03b8}h {h:.1}\u{00b0} \u{03b8}i {i:.1}\u{00b0} as {aspecular_deg:.1}\u{00b0}"))
        .on_hover_text(
            "Half vector from the normal, light from the half vector, eye from the mirror direction",
        );
}

/// Height of the graph, points.
const HEIGHT: f32 = 44.0;

/// The graph of frame times.
pub fn frame_times(ui: &mut Ui, times: &FrameTimes, runs: &mut bool) {
    controls::heading(ui, "Frame time");
    let (rect, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    let text = match (times.last(), times.median_and_largest()) {
        (Some(last), Some([median, largest])) => {
            let top = largest.max(1.0);
            let step = rect.width() / FrameTimes::KEPT as f32;
            let stroke = Stroke::new(step.max(1.0), visuals.selection.bg_fill);
            for (k, time) in times.all().enumerate() {
                let x = rect.left() + (k as f32 + 0.5) * step;
                let y = rect.bottom() - (time / top) as f32 * (rect.height() - 4.0);
                painter.line_segment([Pos2::new(x, rect.bottom()), Pos2::new(x, y)], stroke);
            }
            format!("last {last:.1}, median {median:.1}, most {largest:.1} ms")
        }
        _ => "nothing drawn yet".to_owned(),
    };
    ui.label(RichText::new(text).small());
    ui.checkbox(runs, "draw without pause")
        .on_hover_text("Otherwise a picture is drawn when something changes (Space)");
}

/// A bar as long as a round number of millimetres, in the lower left corner of a picture.
pub fn scale_bar(ui: &Ui, rect: Rect, pixel_mm: f64) {
    let pixels_per_point = f64::from(ui.ctx().pixels_per_point());
    let widest = 0.25 * f64::from(rect.width()) * pixels_per_point * pixel_mm;
    let power = 10f64.powf(widest.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|l| *l <= widest).unwrap_or(power);
    let points = (length / pixel_mm / pixels_per_point) as f32;
    let text =
        if length >= 1.0 { format!("{length:.0} mm") } else { format!("{:.3} \u{00b5}m", 1e3 * length) };
    let text = text.replace(".000", "");
    let start = rect.left_bottom() + Vec2::new(14.0, -14.0);
    let painter = ui.painter_at(rect);
    for (width, color) in [(4.0, eframe::egui::Color32::BLACK), (2.0, eframe::egui::Color32::WHITE)] {
        painter.line_segment([start, start + Vec2::new(points, 0.0)], Stroke::new(width, color));
    }
    super::picture::caption(&painter, start + Vec2::new(0.0, -6.0), eframe::egui::Align2::LEFT_BOTTOM, &text);
}
