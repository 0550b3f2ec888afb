//! The overlay of `carpaint calibrate`: mirrored flashes, where they are and where they should be (Rump et al. 2008, figure 7).

use super::output;
use crate::error::{Error, Result};
use crate::file::write_png;
use crate::measure::calibrate::{Calibration, Reflection, reflection};
use crate::measure::highlight::Mirrored;
use crate::measure::{CaptureFolder, Images};
use std::path::Path;

/// Least width of a tile, pixels: smaller pictures are magnified.
const TILE: usize = 384;
/// Largest side of the picture, pixels, and most tiles a row.
const SIDE: usize = 4096;
const COLUMNS: usize = 3;
/// Pixels between tiles, and their color.
const GAP: usize = 4;
const GRAY: [u8; 3] = [96; 3];

/// A pair that shows a mirrored flash.
type Shown = ([usize; 2], Reflection);

/// Writes the overlay of one pair, or of some that show a mirrored flash, row after row, and says what it shows.
pub fn write_overlay(
    path: &Path,
    capture: &CaptureFolder,
    calibration: &Calibration,
    pair: Option<[usize; 2]>,
) -> Result<()> {
    let size = capture.rig().image_px;
    let zoom = TILE.div_ceil(size[0]);
    let columns = (SIDE / (size[0] * zoom)).min(SIDE / (size[1] * zoom)).clamp(1, COLUMNS);
    let mut tiles = Vec::new();
    for ([camera, light], expected) in shown(capture, calibration, pair, columns * columns)? {
        let picture = match calibration.merge(capture, camera, light) {
            Err(e) if pair.is_none() => {
                output::note!("warning: left out of the overlay: camera {camera}, light {light}: {e}");
                continue;
            }
            merged => merged?,
        };
        let found = expected.find(&picture);
        let highlight = if let Mirrored::At(highlight) = &found { Some(highlight) } else { None };
        tiles.push(expected.overlay(&picture, highlight, zoom));
        let what = match &found {
            Mirrored::Absent => "no highlight is found".to_owned(),
            Mirrored::Broad => "what shines is broader than a mirrored flash".to_owned(),
            Mirrored::At(at) => format!("{:.2} pixels from its place", expected.distance_px(at.center_px)),
        };
        let place = [(tiles.len() - 1) / columns + 1, (tiles.len() - 1) % columns + 1];
        output::note!(
            "overlay, row {}, column {}: camera {camera}, flash {light}: {what}",
            place[0],
            place[1]
        );
    }
    if tiles.is_empty() {
        return Err(Error::invalid(
            "--overlay",
            "pictures",
            "none that can be read",
            "one that shows a flash",
        ));
    }
    let (size, pixels) = mosaic(&tiles, size.map(|n| n * zoom), columns.min(tiles.len()));
    write_png(path, size, &pixels)
}

/// The pair that is asked for, or up to `most` of all that show a mirrored flash, evenly spread.
fn shown(
    capture: &CaptureFolder,
    calibration: &Calibration,
    pair: Option<[usize; 2]>,
    most: usize,
) -> Result<Vec<Shown>> {
    if let Some([camera, light]) = pair {
        let (eye, flash) = (calibration.camera(camera)?, calibration.camera(light)?);
        let expected = reflection(eye, &flash.pose, capture.rig()).ok_or_else(|| {
            let found = format!(
                "the flash of camera {light} mirrored beside what camera {camera} sees of the sample"
            );
            Error::invalid("--pair", "pair", found, "one whose flash the sample mirrors into the camera")
        })?;
        return Ok(vec![([camera, light], expected)]);
    }
    let cameras = &calibration.geometry.cameras;
    let pairs = (0..cameras.len()).flat_map(|camera| (0..cameras.len()).map(move |light| [camera, light]));
    let expected = |[camera, light]: [usize; 2]| {
        Some(([camera, light], reflection(&cameras[camera]?, &cameras[light]?.pose, capture.rig())?))
    };
    let all: Vec<Shown> = pairs.filter_map(expected).collect();
    let count = most.min(all.len());
    if count == 0 {
        let found = "none in which the sample mirrors a flash into the camera";
        return Err(Error::invalid("--overlay", "pairs", found, "at least one"));
    }
    Ok((0..count).map(|k| all[k * all.len() / count].clone()).collect())
}

/// Tiles of one size, row after row.
fn mosaic(tiles: &[Vec<[u8; 3]>], size: [usize; 2], columns: usize) -> ([usize; 2], Vec<[u8; 3]>) {
    let step = size.map(|n| n + GAP);
    let whole = [step[0] * columns - GAP, step[1] * tiles.len().div_ceil(columns) - GAP];
    let mut pixels = vec![GRAY; whole[0] * whole[1]];
    for (k, tile) in tiles.iter().enumerate() {
        let corner = k / columns * step[1] * whole[0] + k % columns * step[0];
        for (row, line) in tile.chunks_exact(size[0]).enumerate() {
            pixels[corner + row * whole[0]..][..size[0]].copy_from_slice(line);
        }
    }
    (whole, pixels)
}
