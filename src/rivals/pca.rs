//! Principal components of slices (Sattler, Sarlette & Klein 2003; 20 to 25 of them a view in Rump et al. 2008, section 6).
//!
//! A group of slices is a matrix X, a slice a row; its best approximation of rank c is `U (U^T X)`, U the c strongest
//! eigenvectors of `X X^T`. Kept in half floats: U, and the rows of `U^T X` as images. No mean image is taken off: slices have no
//! mean over their texels, and a mean over slices would cost as much as one more component.

use crate::btf::FlakeSource;
use crate::error::{Error, Result};
use half::f16;
use nalgebra::{DMatrix, SymmetricEigen};
use std::ops::Range;

/// Which slices share images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grouping {
    /// Those of equal theta_i: what a view is to Sattler et al.
    Row,
    /// All.
    All,
}

/// What an image is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Images {
    /// Red, green and blue: one coefficient a slice and component, as Sattler et al. have it.
    Color,
    /// One channel, shared by all three: three coefficients a slice and component, and a third of the texels. Better for flakes
    /// of little color.
    Gray,
}

/// A flake BTF as principal components.
pub struct Pca {
    images: Images,
    groups: Vec<Group>,
}

struct Group {
    slices: Range<usize>,
    /// Rows and columns of the matrix.
    shape: [usize; 2],
    /// Components, strongest first, `shape[1]` numbers each.
    images: Vec<f16>,
    /// For each row of the matrix a number a component.
    coefficients: Vec<f16>,
}

impl Pca {
    /// Up to `components` components of each group of slices, 1 or more. Holds the slices of a group twice, once in f64.
    ///
    /// # Errors
    /// No component; those of the source.
    pub fn new(btf: &dyn FlakeSource, grouping: Grouping, images: Images, components: usize) -> Result<Self> {
        if components == 0 {
            return Err(Error::invalid("principal components", "number", components, "1 or more"));
        }
        let lengths = match grouping {
            Grouping::Row => btf.grid().rows().to_vec(),
            Grouping::All => vec![btf.grid().len()],
        };
        let mut groups = Vec::with_capacity(lengths.len());
        let mut start = 0;
        for length in lengths {
            groups.push(Group::new(btf, start..start + length, images, components)?);
            start += length;
        }
        Ok(Self { images, groups })
    }

    /// Bytes of so many components, fewer in groups that have no more.
    pub fn bytes(&self, components: usize) -> usize {
        self.groups.iter().map(|g| 2 * components.min(g.components()) * (g.shape[0] + g.shape[1])).sum()
    }

    /// Fluctuation of slice `k` from so many components, row-major; None for a slice that there is not.
    pub fn slice(&self, k: usize, components: usize) -> Option<Vec<[f32; 3]>> {
        let group = self.groups.iter().find(|g| g.slices.contains(&k))?;
        let at = k - group.slices.start;
        Some(match self.images {
            Images::Color => group.row(at, components).as_chunks().0.to_vec(),
            Images::Gray => {
                let [r, g, b] = [0, 1, 2].map(|c| group.row(3 * at + c, components));
                r.into_iter().zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect()
            }
        })
    }
}

impl Group {
    fn new(btf: &dyn FlakeSource, slices: Range<usize>, images: Images, components: usize) -> Result<Self> {
        let texels = btf.size()[0] * btf.size()[1];
        let shape = match images {
            Images::Color => [slices.len(), 3 * texels],
            Images::Gray => [3 * slices.len(), texels],
        };
        let mut data = DMatrix::<f64>::zeros(shape[0], shape[1]);
        for (at, k) in slices.clone().enumerate() {
            let slice = btf.slice(k)?;
            for (texel, color) in slice.fluctuation.iter().enumerate() {
                for (c, value) in color.iter().enumerate() {
                    let place = match images {
                        Images::Color => (at, 3 * texel + c),
                        Images::Gray => (3 * at + c, texel),
                    };
                    data[place] = f64::from(*value);
                }
            }
        }
        let eigen = SymmetricEigen::new(&data * data.transpose());
        let mut order: Vec<usize> = (0..shape[0]).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        order.truncate(components);
        let directions = DMatrix::from_fn(shape[0], order.len(), |i, j| eigen.eigenvectors[(i, order[j])]);
        // Columns of the transposed are contiguous: an image each, and a row of coefficients each.
        let half = |matrix: DMatrix<f64>| matrix.iter().map(|v| f16::from_f64(*v)).collect();
        Ok(Self {
            slices,
            shape,
            images: half(data.transpose() * &directions),
            coefficients: half(directions.transpose()),
        })
    }

    fn components(&self) -> usize {
        self.images.len() / self.shape[1]
    }

    fn row(&self, row: usize, components: usize) -> Vec<f32> {
        let n = self.components();
        let mut sum = vec![0.0; self.shape[1]];
        let images = self.images.chunks_exact(self.shape[1]).take(components);
        for (image, coefficient) in images.zip(&self.coefficients[row * n..(row + 1) * n]) {
            let coefficient = coefficient.to_f32();
            sum.iter_mut().zip(image).for_each(|(s, v)| *s += coefficient * v.to_f32());
        }
        sum
    }
}
