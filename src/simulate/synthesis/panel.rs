//! The flakes of a flat panel, lit and seen from finite distances: every flake by the directions at its own place.
//!
//! A flake shows what it shows in a slice ([the module above](super)), for light and eye as they stand at its cell of the panel, 1 mm
//! wide; the half vector, on which its lobe hangs, is followed inside the cell to first order. A panel that would hold more than
//! [`Panel::MAX_FLAKES`] repeats a tile; directions do not repeat.

use super::flakes::Flake;
use super::slice::{DrawnKind, FlakeColor};
use super::{SynthesisOptions, draw_films};
use crate::btf::AngleGrid;
use crate::error::{Error, Result};
use crate::simulate::Model;
use crate::simulate::optics::film_optics::{FilmView, PaintOptics};
use crate::simulate::optics::geometry::Geometry;
use glam::{DVec2, DVec3};

/// Side of a cell, millimetres: a tenth of a degree at half a meter.
const CELL_MM: f64 = 1.0;
/// Texels a cell of the texture on which flakes are drawn; they set nothing but its repetition.
const CELL_TEXELS: usize = 20;
/// Side of such a texel, millimetres.
const TEXEL_MM: f64 = CELL_MM / CELL_TEXELS as f64;
/// Most cells along the side of a tile: its texture has sides of up to 4096 texels.
const MOST_CELLS: f64 = 200.0;
/// A flake whose lobe has fallen to this is dark.
const DARK: f64 = 1e-6;

/// A flat panel of a paint in the plane z = 0, about the origin.
pub struct Panel<'a> {
    model: &'a Model,
    size_mm: [f64; 2],
    /// Cells of the panel and of the tile that it repeats.
    cells: [usize; 2],
    tile: [usize; 2],
    /// The flakes of every kind of every film, bottom to top, by cell of the tile.
    films: Vec<Vec<KindFlakes>>,
}

/// Flakes of one kind, sorted by cell.
struct KindFlakes {
    drawn: DrawnKind,
    /// First flake of each cell, and their number at the end.
    first: Vec<usize>,
}

/// What a flake shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitFlake {
    /// Where the eye sees it in the plane z = 0, millimetres.
    pub place_mm: DVec2,
    /// Its area, square millimetres.
    pub area_mm2: f64,
    /// Its BRDF, linear Rec.709, 1/sr.
    pub color: DVec3,
}

impl<'a> Panel<'a> {
    /// Most flakes of a panel's tile: half a gigabyte while they are drawn, half of that afterwards.
    pub const MAX_FLAKES: f64 = 3e6;
    /// Longest side of a panel, millimetres.
    pub const MAX_SIDE_MM: f64 = 2000.0;

    /// Draws the flakes of a panel of this width (x) and height (y), millimetres, 0.1 to 2000.
    ///
    /// # Errors
    /// A side outside its range; what [`Synthesis::new`](super::Synthesis::new) refuses of flakes.
    pub fn new(model: &'a Model, size_mm: [f64; 2], seed: u64) -> Result<Self> {
        for side in size_mm {
            if !(0.1..=Self::MAX_SIDE_MM).contains(&side) {
                return Err(Error::invalid("panel", "side, mm", side, "0.1 to 2000"));
            }
        }
        let cells = size_mm.map(|side| (side / CELL_MM).ceil().max(1.0) as usize);
        let density: f64 =
            model.composition().flakes().map(|k| k.area_density / (k.mean_area_um2() * 1e-6)).sum();
        let cells_of_most = Self::MAX_FLAKES / (density * CELL_MM * CELL_MM).max(f64::MIN_POSITIVE);
        let most = cells_of_most.sqrt().clamp(1.0, MOST_CELLS) as usize;
        let tile = cells.map(|n| n.min(most));
        let options = SynthesisOptions {
            size: tile.map(|n| n * CELL_TEXELS),
            seed,
            ..SynthesisOptions::new(AngleGrid::triangle(2)?)
        };
        let films = draw_films(model.composition(), model.optics(), &options, 1e3 * TEXEL_MM)?
            .into_iter()
            .map(|kinds| kinds.into_iter().map(|drawn| KindFlakes::new(drawn, tile)).collect())
            .collect();
        Ok(Self { model, size_mm, cells, tile, films })
    }

    /// What the panel is painted with.
    pub fn model(&self) -> &Model {
        self.model
    }

    /// Width and height, millimetres.
    pub fn size_mm(&self) -> [f64; 2] {
        self.size_mm
    }

    /// Hands every lit flake to `draw`; `rays` tells the unit directions to light and eye at a place of the panel, millimetres.
    /// Flakes that lie on the panel but are seen beyond its edge come too.
    pub fn flakes(&self, rays: impl Fn(DVec2) -> (DVec3, DVec3), mut draw: impl FnMut(LitFlake)) {
        let corner = -0.5 * DVec2::from(self.size_mm);
        for row in 0..self.cells[1] {
            for column in 0..self.cells[0] {
                let low = corner + CELL_MM * DVec2::new(column as f64, row as f64);
                let seen = CellView::new(self.model.optics(), &rays, low + 0.5 * CELL_MM);
                let cell = (row % self.tile[1]) * self.tile[0] + column % self.tile[0];
                self.cell_flakes(cell, low, &seen, &mut draw);
            }
        }
    }

    fn cell_flakes(&self, cell: usize, low: DVec2, seen: &CellView, draw: &mut impl FnMut(LitFlake)) {
        let optics = self.model.optics();
        let thicknesses = self.model.composition().films.iter().map(|film| 1e-3 * film.thickness_um);
        let tile_corner = CELL_MM * DVec2::new((cell % self.tile[0]) as f64, (cell / self.tile[0]) as f64);
        let edge = 0.5 * DVec2::from(self.size_mm);
        let mut above = DVec2::ZERO;
        // Topmost film first, as the views are.
        let films = optics.films.iter().zip(thicknesses).zip(&self.films).rev();
        for (((film, thickness), kinds), view) in films.zip(&seen.films) {
            let by_depth =
                seen.eye.truncate() * (thickness / (film.index * view.middle.geometry.cos_inside[1]));
            for (kind, optics) in kinds.iter().zip(&film.kinds) {
                let colors = FlakeColor::new(&optics.optics, film, &view.middle);
                let lobe = &kind.drawn.lobe;
                let reach = lobe.reach(DARK);
                for flake in kind.cell(cell) {
                    let inside = TEXEL_MM * DVec2::from(flake.center) - tile_corner;
                    let half = view.half(inside - 0.5 * CELL_MM);
                    if lobe.distance(flake.normal, half) > reach || (low + inside).cmpgt(edge).any() {
                        continue;
                    }
                    let place_mm = low + inside + above + flake.depth * by_depth;
                    let color = colors.at(flake.class, flake.depth) * lobe.density(flake.normal, half);
                    draw(LitFlake { place_mm, area_mm2: flake.area() * TEXEL_MM * TEXEL_MM, color });
                }
            }
            above += by_depth;
        }
    }
}

/// What light and eye find at a cell of the panel.
struct CellView {
    /// To the eye, outside.
    eye: DVec3,
    /// Topmost first.
    films: Vec<FilmCellView>,
}

/// What they find in a film.
struct FilmCellView {
    middle: FilmView,
    /// Change of the half vector by a millimetre along x and y.
    slopes: [DVec3; 2],
}

impl CellView {
    fn new(optics: &PaintOptics, rays: &impl Fn(DVec2) -> (DVec3, DVec3), middle: DVec2) -> Self {
        let (wi, wo) = rays(middle);
        let mut films = Vec::with_capacity(optics.films.len());
        optics.visit(wi, wo, |film, view| {
            let half = |side: DVec2| {
                let (wi, wo) = rays(middle + 0.5 * CELL_MM * side);
                Geometry::new(wi, wo, film.index).map_or(view.geometry.half, |g| g.half)
            };
            let slope = |axis: DVec2| (half(axis) - half(-axis)) / CELL_MM;
            films.push(FilmCellView { middle: view.clone(), slopes: [slope(DVec2::X), slope(DVec2::Y)] });
        });
        Self { eye: wo, films }
    }
}

impl FilmCellView {
    /// The half vector at an offset from the middle of the cell, millimetres.
    fn half(&self, offset: DVec2) -> DVec3 {
        self.middle.geometry.half + self.slopes[0] * offset.x + self.slopes[1] * offset.y
    }
}

impl KindFlakes {
    fn new(mut drawn: DrawnKind, tile: [usize; 2]) -> Self {
        let cell = |flake: &Flake| {
            let [x, y] = [0, 1].map(|k| (flake.center[k] as usize / CELL_TEXELS).min(tile[k] - 1));
            y * tile[0] + x
        };
        drawn.flakes.forget_cover();
        let flakes = &mut drawn.flakes.flakes;
        flakes.sort_by_key(cell);
        let first = (0..=tile[0] * tile[1]).map(|k| flakes.partition_point(|f| cell(f) < k)).collect();
        Self { drawn, first }
    }

    fn cell(&self, cell: usize) -> &[Flake] {
        &self.drawn.flakes.flakes[self.first[cell]..self.first[cell + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use crate::simulate::composition::Composition;

    const PAINT: &str = "substrate = { albedo = 0 }\n[[film]]\nthickness_um = 20\nindex = 1.4\nabsorption_per_mm = 8\n\
        [[film.flakes]]\narea_density = 0.8\ndiameter_um = 30\nsigma_deg = 8\nmirror = { reflectance = 0.7 }\n";

    #[test]
    fn flakes_average_to_the_glitter_at_every_place() {
        let model = Model::flakes_alone(&Composition::parse(PAINT).unwrap()).unwrap();
        let (light, eye) = (DVec3::new(60.0, 10.0, 80.0), DVec3::new(-40.0, 0.0, 90.0));
        let rays = |p: DVec2| ((light - p.extend(0.0)).normalize(), (eye - p.extend(0.0)).normalize());
        let size = [24.0, 12.0];
        let (mut ratio, mut variance) = (0.0, 0.0);
        for seed in 1..=4 {
            let panel = Panel::new(&model, size, seed).unwrap();
            panel.flakes(rays, |flake| {
                let (wi, wo) = rays(flake.place_mm);
                // Over the model at the flake's own place: near light makes it vary five-fold over the panel.
                let share = flake.color.x * flake.area_mm2
                    / (size[0] * size[1])
                    / model.glitter(wi, wo).linear_rgb().x;
                ratio += share / 4.0;
                variance += (share / 4.0).powi(2);
            });
        }
        // Four standard errors of the compound Poisson sum, about 1 %.
        assert!((ratio - 1.0).abs() < 4.0 * variance.sqrt(), "{ratio} +- {}", variance.sqrt());
        assert!(variance.sqrt() < 0.02);
    }

    #[test]
    fn a_tile_repeats_and_nothing_lies_beyond_the_edge() {
        let dense = PAINT.replace("diameter_um = 30", "diameter_um = 2");
        let model = Model::flakes_alone(&Composition::parse(&dense).unwrap()).unwrap();
        let panel = Panel::new(&model, [30.5, 3.2], 1).unwrap();
        assert!(panel.tile[0] < panel.cells[0], "{:?}", panel.tile);
        let up = spherical(0.1, 0.0);
        let mut places = Vec::new();
        panel.flakes(|_| (up, up), |flake| places.push(flake.place_mm));
        let reach = places.iter().fold(DVec2::ZERO, |m, p| m.max(p.abs()));
        // Seen through the film a flake moves by less than 2 um.
        assert!(reach.x < 15.26 && reach.y < 1.61, "{reach}");
        assert!(
            Panel::new(&model, [0.0, 1.0], 1).is_err() && Panel::new(&model, [1.0, f64::NAN], 1).is_err()
        );
    }
}
