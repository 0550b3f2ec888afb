//! Fig. 8: the preview, a dim lamp behind the paper included (left), beside the photograph, here the full simulation (right).

use super::photograph::{Photograph, Preview};
use crate::{Figure, Finding, pictures};
use carpaint::error::Result;
use carpaint::render::{InkModel, ToneMap};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "pranovich-2024-8",
    claim: "the preview looks like the photograph (here the full simulation)",
    draw,
};

/// The least error against the measurement in the paper's Table 1, root mean square in sRGB codes from 0 to 1.
const TABLE_1: f64 = 0.0792;

fn draw(name: &Path) -> Result<Finding> {
    let photograph = Photograph::taken()?;
    let preview = Preview::by(InkModel::Goniochromatic)?;
    let share = preview.share_behind(&photograph);
    let tiles = [preview.with(share), photograph.picture.clone()];
    let whole = pictures::mosaic(&tiles, 2);
    whole.write(&name.with_added_extension("png"), photograph.stops, &ToneMap::InGamut)?;
    let [rmse, apart] = photograph.errors(&tiles[0], &photograph.on_print);
    Ok(Finding {
        holds: rmse < TABLE_1,
        says: format!(
            "RMSE of the print in sRGB codes from 0 to 1: {rmse:.3} (the paper's balls against its measurement: {TABLE_1} at \
             best), mean Delta-E 2000 {apart:.1}; the lamp behind has {:.1} % of the light, so that the shadow is nearest",
            100.0 * share
        ),
    })
}
