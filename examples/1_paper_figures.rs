//! Figures 3 to 8 of Golla & Klein 2018, with simulated paints: `cargo run --release --example 1_paper_figures [FOLDER]`.
//!
//! Every figure is one picture, tiles from left to right (and rows from top to bottom) as in the paper. For Fig. 6 the hue
//! of the flip-flop paint at 15 and 110 degrees aspecular is printed.

use carpaint::error::{Error, Result};
use carpaint::fit::SmoothFit;
use carpaint::math::half_difference::spherical;
use carpaint::mix::{BlendOptions, Channels, CoupleOptions, Mix, couple, distance_weights};
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, RenderPaint, ToneMap, render};
use carpaint::report::{Chain, ChainOptions, run_chain};
use carpaint::scene::Scene;
use carpaint::simulate::Composition;
use std::f64::consts::PI;
use std::io::Write;
use std::path::{Path, PathBuf};

const SIZES: ChainOptions = ChainOptions { bins: 24, size: 128, texel_mm: Some(0.012), seed: 1 };

fn main() -> Result<()> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "figures".into()));
    std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, e))?;
    let [blue, brown, silver, flip_flop] =
        ["blue_metallic", "brown_metallic", "silver_metallic", "green_blue_flip_flop"].map(simulated);
    let (blue, brown, silver, flip_flop) = (blue?, brown?, silver?, flip_flop?);

    let blue_brown = mix(&[("blue", &blue), ("brown", &brown)])?;
    let channels = |source: usize, channels: Channels, share: f64| {
        let options = BlendOptions { channels, source, ..BlendOptions::default() };
        blue_brown.blend_with(&[1.0 - share, share], &options)
    };
    let lightness = |share: f64| channels(0, Channels::Lightness, share);
    picture(&folder, "figure_3", &[blue.clone(), lightness(0.5)?, lightness(1.0)?, brown.clone()], 1)?;
    let rest = |share: f64| channels(1, Channels::AllButLightness, share);
    picture(&folder, "figure_4", &[brown.clone(), rest(0.5)?, rest(0.0)?, blue.clone()], 1)?;
    picture(&folder, "figure_5", &[blue.clone(), channels(0, Channels::WhiteFlakes, 0.0)?], 1)?;

    let flip_gray = mix(&[("flip-flop", &flip_flop), ("gray", &silver)])?;
    let rows = [mix(&[("brown", &brown), ("blue", &blue)])?, mix(&[("blue", &blue), ("gray", &silver)])?];
    let mut tiles = Vec::new();
    for row in rows.iter().chain([&flip_gray]) {
        tiles.extend(steps(row, [0, 25, 50, 75, 100])?);
    }
    hue_table(&tiles[10..]);
    picture(&folder, "figure_6", &tiles, 3)?;

    let three = mix(&[("blue", &blue), ("brown", &brown), ("gray", &silver)])?;
    let moved = [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| {
        // From the blue sample at (0, 0) past the others, which stand at (1, 1) and (2, 0).
        let at = [2.0 * t, 0.6 * (1.0 - (2.0 * t - 1.0f64).abs())];
        let distance = |sample: [f64; 2]| (at[0] - sample[0]).hypot(at[1] - sample[1]);
        three.blend(&distance_weights(&[[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]].map(distance))?)
    });
    picture(&folder, "figure_7", &moved.into_iter().collect::<Result<Vec<_>>>()?, 1)?;
    picture(&folder, "figure_8", &steps(&rows[0], [-75, -50, -25, 0, 100, 125, 150, 175])?, 1)
}

/// The paint of a preset, simulated and fitted.
fn simulated(name: &str) -> Result<Paint> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let Chain { paint, .. } = run_chain(name, &Composition::read(&path)?, &SIZES, |_, _| || ())?;
    say(&format!("{name} simulated"));
    Ok(paint)
}

fn mix(paints: &[(&str, &Paint)]) -> Result<Mix> {
    let named: Vec<(String, &Paint)> =
        paints.iter().map(|(name, paint)| ((*name).to_owned(), *paint)).collect();
    Ok(couple(&named, &CoupleOptions::default(), &|| ())?.0)
}

/// Blends at percentages of the second paint.
fn steps<const N: usize>(mix: &Mix, percent: [i32; N]) -> Result<Vec<Paint>> {
    percent.iter().map(|p| mix.blend(&[1.0 - f64::from(*p) / 100.0, f64::from(*p) / 100.0])).collect()
}

/// Hue of the smooth part at 15 and 110 degrees aspecular, 45 degrees incidence.
fn hue_table(paints: &[Paint]) {
    for (step, paint) in paints.iter().enumerate() {
        let fit = SmoothFit::from(paint);
        let [near, far] = [15.0f64, 110.0].map(|aspecular| {
            let wo = spherical((aspecular - 45.0).to_radians(), 0.0);
            carpaint::color::lab_from_rgb(PI * fit.eval(spherical(PI / 4.0, 0.0), wo))
        });
        let chord = (near.y - far.y).hypot(near.z - far.z);
        say(&format!(
            "figure 6, {} % gray: a, b at 15 degrees {:.1}, {:.1}; at 110 degrees {:.1}, {:.1}; apart {chord:.1}",
            25 * step,
            near.y,
            near.z,
            far.y,
            far.z
        ));
    }
}

/// Renders capsules in rows of equal length.
fn picture(folder: &Path, name: &str, paints: &[Paint], rows: usize) -> Result<()> {
    let scene = Scene { size: [144, 320], ..Scene::strip() };
    let mut whole = Picture { size: [0, 0], pixels: Vec::new() };
    for row in paints.chunks(paints.len() / rows) {
        let ready = row.iter().map(RenderPaint::new).collect::<Result<Vec<_>>>()?;
        let tiles = render(&scene, &ready, &Options::default(), &|| ())?;
        whole.size = [tiles.size[0], whole.size[1] + tiles.size[1]];
        whole.pixels.extend(tiles.pixels);
    }
    let path = folder.join(format!("{name}.png"));
    whole.write(&path, scene.exposure_stops, &ToneMap::Srgb)?;
    say(&format!("wrote {}", path.display()));
    Ok(())
}

fn say(text: &str) {
    // A closed pipe is no reason to stop.
    let _ = writeln!(std::io::stdout(), "{text}");
}
