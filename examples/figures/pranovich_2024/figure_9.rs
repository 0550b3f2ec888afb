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
    let is_lit: Vec<bool> =
        photograph.on_print.iter().zip(&photograph.in_shadow).map(|(on, dark)| *on && !dark).collect();
    // The light that the paper lets through knows nothing of inks in this photograph: their models are told apart beside it, too.
    let [lit, print] = [&is_lit, &photograph.on_print]
        .map(|counts| [&ours, &tiles[1]].map(|preview| photograph.errors(preview, counts)));
    let ours_is_nearer = |[ours, standard]: &[[f64; 2]; 2]| ours[0] < standard[0] && ours[1] < standard[1];
    Ok(Finding {
        holds: shadow[0] < shadow[1] && ours_is_nearer(&print) && ours_is_nearer(&lit),
        says: format!(
            "shadow: Delta-E 2000 {:.1} from the photograph with the lamp behind, {:.1} without; RMSE in sRGB codes from 0 to 1 and \
             Delta-E 2000 of the whole print by ours and by Schlick's {print:.3?}, of its lit part {lit:.3?}",
            shadow[0], shadow[1]
        ),
    })
}
