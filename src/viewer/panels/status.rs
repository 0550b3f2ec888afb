//! The line at the foot of the window, and messages over the picture.

use super::super::places::Places;
use eframe::egui::{
    Align2, Area, Color32, Context, Frame, Id, Order, ProgressBar, RichText, Stroke, Ui, Vec2,
};

/// Width of a progress bar, points.
const BAR: f32 = 240.0;

/// Where messages end, points from the foot of the window: above the line and the scale bar.
const ABOVE: f32 = -76.0;

/// The line: adapter, picture, and what is being done.
pub fn show(ui: &mut Ui, adapter: &str, picture: &str, work: &[(String, f32)]) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(adapter).small()).on_hover_text("The adapter that draws");
        ui.separator();
        ui.label(RichText::new(picture).small())
            .on_hover_text("Size of the picture and of what a pixel in its middle covers");
        for (what, share) in work {
            ui.separator();
            let text = RichText::new(what).small();
            ui.add(ProgressBar::new(*share).desired_width(BAR).desired_height(14.0).text(text));
        }
    });
}

/// Most messages at once; older ones go.
const MESSAGES: usize = 4;

/// Says something once.
pub fn tell(all: &mut Vec<Message>, text: String, is_error: bool) {
    let message = Message { text, is_error };
    if !all.contains(&message) {
        all.push(message);
    }
    let surplus = all.len().saturating_sub(MESSAGES);
    all.drain(..surplus);
}

/// What went wrong or was done, newest last; a click takes a message away.
pub fn messages(context: &Context, places: &mut Places, all: &mut Vec<Message>) {
    let area = Area::new(Id::unique("messages")).order(Order::Foreground);
    let mut gone = None;
    area.anchor(Align2::CENTER_BOTTOM, Vec2::new(0.0, ABOVE)).show(context, |ui| {
        for (k, message) in all.iter().enumerate() {
            let color = if message.is_error {
                Color32::from_rgb(220, 90, 80)
            } else {
                Color32::from_rgb(90, 160, 110)
            };
            let frame = Frame::popup(ui.style()).stroke(Stroke::new(1.5, color));
            let response = frame.show(ui, |ui| {
                ui.set_max_width(560.0);
                ui.horizontal_top(|ui| {
                    if ui.small_button("\u{00d7}").on_hover_text("Take away (Esc: all)").clicked() {
                        gone = Some(k);
                    }
                    ui.label(&message.text);
                });
            });
            places.note(format!("message {}", k + 1), response.response.rect);
        }
    });
    if let Some(k) = gone {
        all.remove(k);
    }
}

/// Something to tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// In full.
    pub text: String,
    /// Whether something went wrong.
    pub is_error: bool,
}
