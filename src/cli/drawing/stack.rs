//! A cut through films and substrate, lengths and heights to one scale, flakes as such a cut would meet them.

use super::svg::{FAINT, INK, Svg};
use super::{css, digits};
use crate::color::Spectrum;
use crate::simulate::Model;
use crate::simulate::composition::{Film, FlakeKind};
use crate::simulate::optics::film_optics::{FilmOptics, KindOptics};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::PI;

/// Width of the cut, pixels.
const WIDTH: f64 = 330.0;
/// Tallest stack of films, pixels.
const TALLEST: f64 = 320.0;
/// Largest scale, pixels a micrometer: some 80 micrometers across.
const LARGEST_SCALE: f64 = 4.0;
/// Height of the substrate's visible part.
const SUBSTRATE: f64 = 46.0;
/// Where the words begin, from the left edge of the cut.
const WORDS: f64 = WIDTH + 26.0;
/// Height of a line of words.
const LINE: f64 = 16.0;
/// Most flakes, and most dots of pigment, of one kind in a film.
const MOST: f64 = 400.0;
/// Normals looked at for the tilt of a kind.
const NORMALS: usize = 999;

/// Draws the cut with its upper left corner at `at`; returns its lower edge.
pub fn draw(svg: &mut Svg, model: &Model, [x, y]: [f64; 2]) -> f64 {
    let films = &model.composition().films;
    let total: f64 = films.iter().map(|film| film.thickness_um).sum();
    let scale = LARGEST_SCALE.min(TALLEST / total.max(1e-9));
    let mut rng = Pcg64::seed_from_u64(1);
    let (mut edge, mut words) = (y, y);
    for (number, (film, optics)) in films.iter().zip(&model.optics().films).enumerate().rev() {
        let height = film.thickness_um * scale;
        draw_film(svg, film, optics, [x, edge], height, scale, &mut rng);
        let name = if films.len() == 1 { "film".to_owned() } else { format!("film {}", number + 1) };
        let first = (words + LINE).max(edge + 0.5 * height);
        svg.polyline(
            &[
                [x + WIDTH, edge + 0.5 * height],
                [x + WIDTH + 12.0, first - 4.0],
                [x + WORDS - 4.0, first - 4.0],
            ],
            &format!(r#"stroke="{FAINT}" stroke-width="0.8""#),
        );
        words = describe(svg, &name, film, optics, [x + WORDS, first], &mut rng);
        edge += height;
    }
    let albedo = &model.composition().substrate.albedo;
    draw_substrate(svg, albedo, [x, edge]);
    let first = (words + LINE).max(edge + 0.5 * SUBSTRATE);
    svg.text([x + WORDS, first], 13.0, "start", "substrate");
    svg.note([x + WORDS, first + LINE], "start", &format!("albedo {:.2} at 550 nm", albedo.0[17]));
    svg.rect([x, y], [WIDTH, edge - y + SUBSTRATE], &format!(r#"fill="none" stroke="{INK}""#));
    let foot = edge + SUBSTRATE + 22.0;
    draw_scale(svg, scale, [x, foot]);
    foot.max(first + LINE)
}

/// A film with what is in it.
fn draw_film(
    svg: &mut Svg,
    film: &Film,
    optics: &FilmOptics,
    at: [f64; 2],
    height: f64,
    scale: f64,
    rng: &mut Pcg64,
) {
    // What white light keeps on its way through the binder alone, on a tint that tells film from paper.
    let passed = film.absorption_per_mm.0.map(|kappa| 0.93 * (-kappa * film.thickness_um * 1e-3).exp());
    let binder = css(Spectrum(passed).linear_rgb());
    svg.rect(at, [WIDTH, height], &format!(r#"fill="{binder}""#));
    svg.clipped(at, [WIDTH, height], |svg| {
        for pigment in &optics.pigments {
            let albedo: [f64; 41] = std::array::from_fn(|k| {
                if pigment.extinction.0[k] > 0.0 {
                    pigment.scattering.0[k] / pigment.extinction.0[k]
                } else {
                    0.0
                }
            });
            let style =
                format!(r#"fill="{}" stroke="{INK}" stroke-width="0.3""#, css(Spectrum(albedo).linear_rgb()));
            // Dots in proportion to what the pigment takes of green light, not to its particles.
            let dots = (60.0 * pigment.extinction.0[17]).clamp(8.0, MOST);
            for _ in 0..dots as usize {
                let place = [at[0] + WIDTH * rng.random::<f64>(), at[1] + height * rng.random::<f64>()];
                svg.circle(place, 1.3, &style);
            }
        }
        for (kind, optics) in film.flakes.iter().zip(&optics.kinds) {
            draw_flakes(svg, kind, optics, at, height, scale, rng);
        }
    });
    svg.line(at, [at[0] + WIDTH, at[1]], &format!(r#"stroke="{INK}" stroke-width="1""#));
}

/// Flakes as a vertical cut meets them: their number, chords and slopes.
fn draw_flakes(
    svg: &mut Svg,
    kind: &FlakeKind,
    optics: &KindOptics,
    at: [f64; 2],
    height: f64,
    scale: f64,
    rng: &mut Pcg64,
) {
    let color = color(optics);
    let crossed = kind.area_density / kind.mean_area_um2() * kind.diameter_um * WIDTH / scale;
    // One at least of every kind there is.
    let count = if crossed > 0.0 { crossed.round().clamp(1.0, MOST) } else { 0.0 };
    for k in 0..count as usize {
        let normal = optics.orientation.sample(rng);
        // A disc at a random distance from the cut shows a chord; its slope is the normal's in the plane of the cut.
        let offset: f64 = rng.random();
        let half = 0.5 * kind.diameter_um * scale * (1.0 - offset * offset).sqrt();
        let slope = (-normal.x).atan2(normal.z);
        let (dx, dy) = (half * slope.cos(), half * slope.sin());
        // Flakes do not stick out of their film.
        let room = (height - 2.0 * dy.abs()).max(0.0);
        // Evenly spread along the cut, so that a few flakes show what many would.
        let along = (k as f64 + rng.random::<f64>()) / count;
        let middle = [at[0] + WIDTH * along, at[1] + 0.5 * height + room * (rng.random::<f64>() - 0.5)];
        let ends = [[middle[0] - dx, middle[1] - dy], [middle[0] + dx, middle[1] + dy]];
        let width = (0.5 * scale).clamp(1.0, 2.2);
        let outline = format!(r#"stroke="{INK}" stroke-width="{:.1}""#, width + 1.0);
        svg.line(ends[0], ends[1], &outline);
        svg.line(ends[0], ends[1], &format!(r#"stroke="{color}" stroke-width="{width:.1}""#));
    }
}

/// What a film is made of, in words; returns the last line's height.
fn describe(
    svg: &mut Svg,
    name: &str,
    film: &Film,
    optics: &FilmOptics,
    [x, mut y]: [f64; 2],
    rng: &mut Pcg64,
) -> f64 {
    svg.text(
        [x, y],
        13.0,
        "start",
        &format!("{name}: {} µm, index {}", digits(film.thickness_um), digits(film.index)),
    );
    for (kind, optics) in film.flakes.iter().zip(&optics.kinds) {
        y += LINE;
        let chip = format!(r#"fill="{}" stroke="{INK}" stroke-width="0.6""#, color(optics));
        svg.rect([x, y - 9.0], [10.0, 10.0], &chip);
        let tilt = median_tilt(optics, rng).to_degrees();
        let words = format!(
            "flakes {} × area, {} µm, median tilt {tilt:.0}°",
            digits(kind.area_density),
            digits(kind.diameter_um)
        );
        svg.note([x + 15.0, y], "start", &words);
        if let Some(layers) = &kind.stack {
            y += LINE;
            let layer = |l: &crate::simulate::composition::StackLayer| {
                format!("{} {}", l.material.as_deref().unwrap_or("layer"), digits(l.thickness_nm))
            };
            let words: Vec<String> = layers.iter().take(5).map(layer).collect();
            let more = if layers.len() > 5 { " / …" } else { "" };
            svg.note([x + 15.0, y], "start", &format!("{}{more} nm", words.join(" / ")));
        }
    }
    for pigment in &optics.pigments {
        y += LINE;
        svg.circle([x + 5.0, y - 4.0], 2.0, &format!(r#"fill="{INK}""#));
        let (scattered, taken) = (pigment.scattering.0[17], pigment.extinction.0[17]);
        let albedo = if taken > 0.0 { scattered / taken } else { 0.0 };
        let words = format!("pigment, optical thickness {taken:.2}, albedo {albedo:.2}");
        svg.note([x + 15.0, y], "start", &words);
    }
    y + 6.0
}

fn draw_substrate(svg: &mut Svg, albedo: &Spectrum, at: [f64; 2]) {
    svg.rect(at, [WIDTH, SUBSTRATE], &format!(r#"fill="{}""#, css(albedo.linear_rgb())));
    svg.clipped(at, [WIDTH, SUBSTRATE], |svg| {
        for k in 0..((WIDTH + SUBSTRATE) / 9.0) as usize {
            let x = at[0] + 9.0 * k as f64;
            let style = r##"stroke="#8a9099" stroke-width="0.6""##;
            svg.line([x, at[1]], [x - SUBSTRATE, at[1] + SUBSTRATE], style);
        }
    });
    svg.line(at, [at[0] + WIDTH, at[1]], &format!(r#"stroke="{INK}" stroke-width="1.6""#));
}

/// A bar of a round length, and what it stands for.
fn draw_scale(svg: &mut Svg, scale: f64, [x, y]: [f64; 2]) {
    let longest = 0.4 * WIDTH / scale;
    let decade = 10f64.powf(longest.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|n| n * decade).into_iter().find(|l| *l <= longest).unwrap_or(decade);
    svg.line([x, y - 4.0], [x + length * scale, y - 4.0], &format!(r#"stroke="{INK}" stroke-width="2""#));
    svg.note([x + length * scale + 8.0, y], "start", &format!("{length} µm, across and down"));
}

/// What a flake of a kind reflects head on.
fn color(optics: &KindOptics) -> String {
    css(Spectrum(optics.optics.reflectance(1.0)).linear_rgb())
}

/// The tilt that half of the flakes exceed, radians.
fn median_tilt(optics: &KindOptics, rng: &mut Pcg64) -> f64 {
    let mut tilts: Vec<f64> =
        (0..NORMALS).map(|_| optics.orientation.sample(rng).z.clamp(-1.0, 1.0).acos()).collect();
    tilts.sort_by(f64::total_cmp);
    tilts.get(NORMALS / 2).copied().unwrap_or(0.5 * PI)
}
