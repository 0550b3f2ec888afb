//! Pictures on the screen.

use super::press::Proof;
use eframe::egui::{ColorImage, Context, TextureHandle, TextureId, TextureOptions};

/// The last picture of each pane.
#[derive(Default)]
pub struct Screen([Option<TextureHandle>; 2]);

impl Screen {
    /// Takes a picture in place of the one before.
    pub fn take(&mut self, context: &Context, proof: &Proof) {
        let image = ColorImage::from_rgb(proof.size, proof.codes.as_flattened());
        let options = if proof.is_coarse { TextureOptions::LINEAR } else { TextureOptions::NEAREST };
        let Some(slot) = self.0.get_mut(proof.pane) else { return };
        match slot {
            Some(texture) => texture.set(image, options),
            None => *slot = Some(context.load_texture("print", image, options)),
        }
    }

    /// The picture of a pane.
    pub fn get(&self, pane: usize) -> Option<TextureId> {
        self.0.get(pane)?.as_ref().map(TextureHandle::id)
    }
}
