//! Fig. 9: the preview of Fig. 8 without the lamp behind (left), and by the standard model with it (right).

use super::photograph::{Photograph, Preview};
use crate::{Figure, Finding, pictures};
use carpaint::error::Result;
use carpaint::render::{InkModel, ToneMap};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "pranovich-2024-9",
    claim: "without the lamp behind the shadowed side is lost, and the standard model is farther from the photograph than ours",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let photograph = Photograph::taken()?;
    let preview = Preview::by(InkModel::Goniochromatic)?;
    let share = preview.share_behind(&photograph);
    let (ours, tiles) =
        (preview.with(share), [preview.with(0.0), Preview::by(InkModel::Schlick)?.with(share)]);
    let whole = pictures::mosaic(&tiles, 2);
    whole.write(&name.with_added_extension("png"), photograph.stops, &ToneMap::InGamut)?;
    let shadow = [&ours, &tiles[0]].map(|p| photograph.errors(p, &photograph.in_shadow)[1]);
    let print = [&ours, &tiles[1]].map(|p| photograph.errors(p, &photograph.on_print));
    Ok(Finding {
        holds: shadow[0] < shadow[1] && print[0][0] < print[1][0] && print[0][1] < print[1][1],
        says: format!(
            "shadow: Delta-E 2000 {:.1} from the photograph with the lamp behind, {:.1} without; print: RMSE {:.3} and \
             Delta-E 2000 {:.1} by ours, {:.3} and {:.1} by Schlick's",
            shadow[0], shadow[1], print[0][0], print[0][1], print[1][0], print[1][1]
        ),
    })
}
