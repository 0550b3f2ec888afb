//! What an object wears: a paint as it is, or a mix at weights, which the GPU turns into a paint.

use super::shelf::Ready;
use crate::error::Result;
use crate::mix::{BlendOptions, Mix};
use std::sync::Arc;

/// Blends that the window shows at once at most: the one being made, and one kept beside it.
pub const BLENDS: usize = 2;

/// A mix at weights.
#[derive(Debug, Clone)]
pub struct Blend {
    /// What is mixed.
    pub mix: Arc<Mix>,
    /// Which of the blends of the window it is, below [`BLENDS`]: each has a place of its own on the GPU.
    pub slot: usize,
    /// One a paint, summing to 1.
    pub weights: Vec<f64>,
    /// What goes, and how.
    pub options: BlendOptions,
}

impl Blend {
    /// The same on the CPU: takes long, and is for those who need its values.
    ///
    /// # Errors
    /// As [`Mix::blend_with`].
    pub fn ready(&self) -> Result<Arc<Ready>> {
        Ready::new(&self.mix.blend_with(&self.weights, &self.options)?)
    }
}

impl PartialEq for Blend {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.mix, &other.mix)
            && self.slot == other.slot
            && self.weights == other.weights
            && self.options == other.options
    }
}

/// What an object wears.
#[derive(Debug, Clone)]
pub enum Worn {
    /// A paint as it is.
    Paint(Arc<Ready>),
    /// A mix at weights.
    Blend(Blend),
}

impl Worn {
    /// On the CPU.
    ///
    /// # Errors
    /// As [`Blend::ready`].
    pub fn ready(&self) -> Result<Arc<Ready>> {
        match self {
            Self::Paint(ready) => Ok(ready.clone()),
            Self::Blend(blend) => blend.ready(),
        }
    }

    /// Side of a texel of its flakes, millimetres.
    pub fn texel_mm(&self) -> Option<f64> {
        match self {
            Self::Paint(ready) => ready.texel_mm,
            Self::Blend(blend) => blend.mix.flakes.as_ref().map(|flakes| flakes.texel_mm),
        }
    }
}

impl PartialEq for Worn {
    /// Paints are the same if they are one allocation.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Paint(a), Self::Paint(b)) => Arc::ptr_eq(a, b),
            (Self::Blend(a), Self::Blend(b)) => a == b,
            _ => false,
        }
    }
}

/// The number as which `one` of `all` is worn; none: several are the same.
pub fn number_of(one: &Worn, all: &[Worn]) -> Option<usize> {
    let mut numbers = all.iter().enumerate().filter_map(|(k, worn)| (worn == one).then_some(k));
    numbers.next().filter(|_| numbers.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_that_of_the_only_one() {
        let (constituents, flakes) = (Vec::new(), None);
        let (path, cost) = Default::default();
        let mix = Arc::new(Mix { constituents, flakes, path, cost, threshold: 1.0 });
        let blend = |weight: f64| {
            Worn::Blend(Blend {
                mix: mix.clone(),
                slot: 0,
                weights: vec![weight],
                options: Default::default(),
            })
        };
        let (one, two) = (blend(0.1), blend(0.2));
        for (all, number) in [(vec![&two, &one], Some(1)), (vec![&one, &two, &one], None), (vec![&two], None)]
        {
            let all: Vec<Worn> = all.into_iter().cloned().collect();
            assert_eq!(number_of(&one, &all), number, "{all:?}");
        }
    }
}
