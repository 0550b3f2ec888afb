//! One slice: what every flake adds to the texels it covers.

use super::disc::cover_disc;
use super::flakes::{Flake, Flakes};
use crate::color::{BANDS, luminance, rgb_weights};
use crate::simulate::optics::film_optics::{FilmOptics, FilmView};
use crate::simulate::optics::flake_optics::FlakeOptics;
use crate::simulate::optics::orientation::FlakeLobe;
use glam::{DVec2, DVec3};

/// Flakes of one kind, with what a slice asks of them.
pub(super) struct DrawnKind {
    /// The flakes.
    pub flakes: Flakes,
    /// Their angular lobe.
    pub lobe: FlakeLobe,
}

/// A slice in the making.
pub(super) struct Canvas {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Light of the flakes, row-major.
    pub texels: Vec<DVec3>,
    /// The same seen from the opposite azimuth, where flakes shift with the view.
    pub opposite: Option<Vec<DVec3>>,
    /// Luminance of all flakes, averaged over the slice.
    pub sum: f64,
    /// Sum of its squares: a compound Poisson sum, whose variance this estimates without bias.
    pub squares: f64,
    /// Texels of the flake at hand.
    cover: Vec<(u32, f32)>,
}

/// Where a flake of a film is seen, against its place seen from straight above: `above + z by_depth`, texels, z its depth as
/// a share of the film's thickness.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shift {
    /// What the films above add.
    pub above: DVec2,
    /// What the whole film adds.
    pub by_depth: DVec2,
}

impl Canvas {
    /// An empty slice, seen from the opposite azimuth too if asked.
    pub fn new(size: [usize; 2], opposite: bool) -> Self {
        let texels = vec![DVec3::ZERO; size[0] * size[1]];
        let opposite = opposite.then(|| texels.clone());
        Self { size, texels, opposite, sum: 0.0, squares: 0.0, cover: Vec::new() }
    }

    /// Adds the flakes of one kind in one film. `shifts` are those of the two views; without them flakes are seen where they
    /// are.
    pub fn add(
        &mut self,
        kind: &DrawnKind,
        optics: &FlakeOptics,
        film: &FilmOptics,
        view: &FilmView,
        shifts: Option<[Shift; 2]>,
    ) {
        let half = view.geometry.half;
        let colors = FlakeColor::new(optics, film, view);
        let cutoff = kind.lobe.cutoff();
        for (flake, cover) in kind.flakes.iter() {
            if flake.normal.dot(half).abs() < cutoff {
                continue;
            }
            let color = colors.at(flake.class, flake.depth) * kind.lobe.density(flake.normal, half);
            self.paint(flake, cover, color, shifts);
            let light = luminance(color) * flake.area() / self.texels.len() as f64;
            self.sum += light;
            self.squares += light * light;
        }
    }

    /// Adds the light of one flake.
    fn paint(&mut self, flake: &Flake, cover: &[(u32, f32)], color: DVec3, shifts: Option<[Shift; 2]>) {
        let Some([shift, opposite]) = shifts else { return add_cover(&mut self.texels, cover, color) };
        let views =
            std::iter::once((&mut self.texels, shift)).chain(self.opposite.as_mut().map(|t| (t, opposite)));
        for (texels, shift) in views {
            let seen = DVec2::from(flake.center) + shift.above + flake.depth * shift.by_depth;
            self.cover.clear();
            cover_disc(seen.to_array(), flake.radius, self.size, &mut self.cover);
            add_cover(texels, &self.cover, color);
        }
    }
}

fn add_cover(texels: &mut [DVec3], cover: &[(u32, f32)], color: DVec3) {
    for (texel, share) in cover {
        texels[*texel as usize] += color * f64::from(*share);
    }
}

/// What a flake of a film shows, before its lobe, by its depth.
pub(super) struct FlakeColor {
    /// Linear Rec.709 of every band for a flake on top of the film, by class.
    on_top: Vec<[DVec3; BANDS]>,
    /// Optical thickness of the film along both rays.
    thickness: [f64; BANDS],
}

impl FlakeColor {
    /// For flakes of a kind in a film under light and eye.
    pub fn new(optics: &FlakeOptics, film: &FilmOptics, view: &FilmView) -> Self {
        let g = &view.geometry;
        let factor = view.transmission / (4.0 * film.index.powi(2) * g.cos_inside[0] * g.cos_inside[1]);
        let passed = view.above.map(|x| factor * (-x).exp());
        let weights = rgb_weights();
        let on_top = optics
            .class_reflectances(g.cos_alpha)
            .iter()
            .map(|r| std::array::from_fn(|k| weights[k] * (passed[k] * r[k])))
            .collect();
        Self { on_top, thickness: film.optical_thickness(g) }
    }

    /// The color of a flake of a class at a depth, as a share of the film's thickness.
    pub fn at(&self, class: usize, depth: f64) -> DVec3 {
        let bands = self.on_top[class].iter().zip(&self.thickness);
        bands.fold(DVec3::ZERO, |sum, (color, x)| sum + *color * (-x * depth).exp())
    }
}
