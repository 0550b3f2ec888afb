//! All films of a paint on their nodes, and the solution at one wavelength (Ershov 2001, section 4).

use super::accuracy::Settings;
use super::transfer::film::FilmTransfer;
use super::transfer::film_kernel::{film_absorption, film_kernel};
use super::transfer::ground::lambertian;
use super::transfer::kernel::{Kernel, Side};
use super::transfer::layer::Layer;
use super::transfer::nodes::Nodes;
use super::transfer::operator::Operator;
use crate::error::{Error, Result};
use crate::simulate::optics::film_optics::PaintOptics;
use nalgebra::DMatrix;

/// What all wavelengths share.
pub struct PaintTransfer<'a> {
    settings: &'a Settings,
    nodes: Nodes,
    films: Vec<FilmNodes>,
    /// Albedo of the substrate, per band solved.
    albedo: Vec<f64>,
}

/// A film, bottom to top, for all bands solved.
struct FilmNodes {
    index: f64,
    kernel: Kernel,
    absorption: Vec<Vec<f64>>,
    /// The boundary to the film above, or to air.
    surface: Layer,
}

/// One wavelength.
pub struct BandSolution {
    /// BRDF scattered more than once, on the nodes outside, by mode; 1/sr.
    pub rest: Vec<DMatrix<f64>>,
    /// For each node outside, of the light that enters: reflected, into the substrate, into films.
    pub shares: Vec<[f64; 3]>,
    /// Most doublings of any film.
    pub doublings: u32,
}

/// Most memory for the kernels of all films.
const MAX_KERNEL_BYTES: usize = 4_000_000_000;

impl<'a> PaintTransfer<'a> {
    /// Kernels and absorption of all films at these bands.
    ///
    /// # Errors
    /// As [`film_kernel`]; kernels of more than 4 GB.
    pub fn new(optics: &PaintOptics, settings: &'a Settings, bands: &[usize]) -> Result<Self> {
        let indices: Vec<f64> = optics.films.iter().map(|film| film.index).collect();
        let nodes = Nodes::new(&indices, settings.nodes, &[]);
        let pairs: usize = indices.iter().map(|index| nodes.count(*index).pow(2)).sum();
        let bytes = pairs * settings.resolution.modes * bands.len() * size_of::<f64>();
        if bytes > MAX_KERNEL_BYTES {
            let found = format!("{:.1} GB of kernels", bytes as f64 * 1e-9);
            let legal = "up to 4 GB: fewer films of different index, wider flakes or a larger error";
            return Err(Error::unsupported("full model", "size", found, legal));
        }
        let above = indices.iter().copied().skip(1).chain([1.0]);
        let films = optics.films.iter().zip(above).map(|(film, above)| {
            let directions = nodes.directions(film.index);
            Ok(FilmNodes {
                index: film.index,
                kernel: film_kernel(film, &directions, bands, settings.resolution)?,
                absorption: film_absorption(film, &directions, bands),
                surface: Layer::boundary(&nodes, above, film.index),
            })
        });
        let films = films.collect::<Result<Vec<_>>>()?;
        let albedo = bands.iter().map(|k| optics.albedo.0[*k]).collect();
        Ok(Self { settings, nodes, films, albedo })
    }

    /// Cosines of the nodes outside.
    pub fn outside(&self) -> Vec<f64> {
        self.nodes.directions(1.0).iter().map(|d| d.cos).collect()
    }

    /// What each node outside counts in diffuse light.
    pub fn diffuse(&self) -> Vec<f64> {
        self.nodes.weights().iter().take(self.nodes.count(1.0)).map(|g| 2.0 * g).collect()
    }

    /// Solves one band, by its number among those asked for.
    ///
    /// # Errors
    /// As [`FilmTransfer::layer`] and [`Layer::over`].
    pub fn solve(&self, band: usize) -> Result<BandSolution> {
        let films: Vec<FilmTransfer> = self
            .films
            .iter()
            .map(|film| {
                let thinness = self.settings.thinness;
                FilmTransfer::new(
                    &self.nodes,
                    film.index,
                    &film.kernel,
                    band,
                    &film.absorption[band],
                    thinness,
                )
            })
            .collect();
        let (first, shares) = self.mode_zero(&films, band)?;
        let once = Once::new(self, &films);
        let mut rest = vec![once.subtracted(self, &films, first, 0, band)];
        let scale = rest[0].amax();
        let mut quiet = 0;
        for mode in 1..self.settings.resolution.modes {
            let reflection = self.mode(&films, mode, band)?;
            let matrix = once.subtracted(self, &films, reflection, mode, band);
            quiet = if matrix.amax() <= self.settings.negligible * scale { quiet + 1 } else { 0 };
            rest.push(matrix);
            // Odd and even modes may vanish by symmetry: only both together end the series.
            if quiet == 2 {
                break;
            }
        }
        let doublings = films.iter().map(FilmTransfer::doublings).max().unwrap_or(0);
        Ok(BandSolution { rest, shares, doublings })
    }

    /// Reflection of the whole paint in a mode above 0, which the substrate does not return.
    fn mode(&self, films: &[FilmTransfer], mode: usize, band: usize) -> Result<Operator> {
        let n = self.nodes.count(self.films[0].index);
        let mut reflection = Operator::zero(n, n);
        for (film, transfer) in self.films.iter().zip(films) {
            (reflection, _) = transfer.layer(&film.kernel, mode, band)?.over(&reflection)?;
            (reflection, _) = film.surface.over(&reflection)?;
        }
        Ok(reflection)
    }

    /// Reflection in mode 0, and where the energy goes.
    fn mode_zero(&self, films: &[FilmTransfer], band: usize) -> Result<(Operator, Vec<[f64; 3]>)> {
        let amplitude: Vec<f64> = self.nodes.weights().iter().map(|g| g.sqrt()).collect();
        let albedo = self.albedo[band];
        let mut reflection = lambertian(&self.nodes, self.films[0].index, albedo);
        // What is lost below, as functionals of the light that goes down there: in the substrate, in the films.
        let mut lost: [Vec<f64>; 2] =
            [amplitude.iter().map(|a| (1.0 - albedo) * a).collect(), vec![0.0; amplitude.len()]];
        for (film, transfer) in self.films.iter().zip(films) {
            let layer = transfer.layer(&film.kernel, 0, band)?;
            let absorbed = transfer.absorbed(&layer);
            let (above, down) = layer.over(&reflection)?;
            let from_below = down.before(&reflection.before(&absorbed));
            lost = lost.map(|f| down.before(&f));
            for (sum, (a, b)) in lost[1].iter_mut().zip(absorbed.iter().zip(from_below)) {
                *sum += a + b;
            }
            let (above, down) = film.surface.over(&above)?;
            lost = lost.map(|f| down.before(&f));
            reflection = above;
        }
        let surface = &self.films[self.films.len() - 1].surface;
        let scattered = reflection.scattered_total(&amplitude);
        let shares = (0..self.nodes.count(1.0)).map(|k| {
            let entering = surface.transmit_down.direct()[k] * amplitude[k];
            // What boundaries between films mirror comes back, too.
            let mirrored = (reflection.direct()[k] - surface.reflect_above.direct()[k]) * amplitude[k];
            [scattered[k] + mirrored, lost[0][k], lost[1][k]]
                .map(|share| if entering > 0.0 { share / entering } else { 0.0 })
        });
        let shares = shares.collect();
        Ok((reflection, shares))
    }
}

impl BandSolution {
    /// Largest difference of the sum over azimuth to that interpolated between two others, `weight` that of the second, over
    /// the value itself.
    pub fn difference(&self, a: &Self, b: &Self, weight: f64) -> f64 {
        let [own, a, b] = [self, a, b].map(|solution| &solution.rest[0]);
        let floor = 1e-3 * own.amax();
        let each = own.iter().zip(a.iter().zip(b.iter()));
        each.map(|(x, (a, b))| (a + weight * (b - a) - x).abs() / x.abs().max(floor).max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max)
    }
}

/// Attenuation of what is scattered once, per film and node outside.
struct Once {
    /// What enters each film through all that is above.
    arriving: Vec<Vec<f64>>,
}

impl Once {
    fn new(paint: &PaintTransfer, films: &[FilmTransfer]) -> Self {
        let mut share = vec![1.0; paint.nodes.count(1.0)];
        let mut arriving = Vec::new();
        for (film, transfer) in paint.films.iter().zip(films).rev() {
            // Nodes that a thinner film on the way does not have are beyond this one's reach.
            let passed = film.surface.transmit_down.direct();
            share.iter_mut().zip(passed).for_each(|(s, t)| *s *= t);
            arriving.push(share.iter().map(|s| s / film.index).collect());
            share.iter_mut().zip(transfer.unscattered()).for_each(|(s, t)| *s *= t);
        }
        arriving.reverse();
        Self { arriving }
    }

    /// The BRDF of a mode on the nodes outside, without what is scattered once.
    fn subtracted(
        &self,
        paint: &PaintTransfer,
        films: &[FilmTransfer],
        reflection: Operator,
        mode: usize,
        band: usize,
    ) -> DMatrix<f64> {
        let n = paint.nodes.count(1.0);
        let weights = paint.nodes.weights();
        let mut rest =
            DMatrix::from_fn(n, n, |i, j| reflection.scattered(i, j) / (weights[i] * weights[j]).sqrt());
        for ((film, transfer), arriving) in paint.films.iter().zip(films).zip(&self.arriving) {
            let kernel = film.kernel.matrix(Side::Reflection, mode, band);
            for j in 0..n {
                for i in 0..n {
                    rest[(i, j)] -=
                        arriving[i] * arriving[j] * transfer.once(Side::Reflection, &kernel, i, j);
                }
            }
        }
        rest
    }
}
