//! Flakes of one kind whose layers vary in thickness: a few classes of equal flakes.
//!
//! Every layer with a spread takes the thicknesses of a Gauss rule ([`super::thickness_spread`]), independently of the
//! others: the classes are all combinations. Their number is chosen so that the mean reflectance over flakes is that of the
//! continuous law to 1e-3 for light up to 45 degrees off the flake's normal, a tenth of the error the models promise. (At
//! flatter angles a flake is a sharper resonator, and single wavelengths can be off by some percent; sums over angles are
//! not.) The same classes make the smooth paint's mean and the single flakes of a texture: there is nothing between them.

use super::thickness_spread::gauss_rule;
use super::thin_film::{Characteristic, Embedded, Incidence, then};
use crate::color::{BANDS, wavelength_nm};
use crate::error::{Error, Result};
use crate::simulate::composition::StackLayer;
use nalgebra::Complex;

/// Error of the mean over classes, absolute.
const TOLERANCE: f64 = 1e-3;
/// Cosines of the angles of incidence at which it is met, and bands.
const PROBES: [f64; 3] = [1.0, 0.85, 0.7];
const PROBED_BANDS: [usize; 9] = [0, 3, 6, 10, 15, 20, 26, 33, 40];
/// Sizes of the Gauss rules tried.
const RULES: [usize; 12] = [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96];

/// All classes of one kind of flakes in their binder.
#[derive(Debug, Clone, PartialEq)]
pub struct StackClasses {
    binder: f64,
    layers: Vec<Layer>,
    weights: Vec<f64>,
}

/// A layer in all its thicknesses.
#[derive(Debug, Clone, PartialEq)]
struct Layer {
    index: [Complex<f64>; BANDS],
    thicknesses: Vec<f64>,
}

impl StackClasses {
    /// Most classes of one kind of flakes.
    pub const MAX: usize = 4096;

    /// Classes of a stack in a binder of real index `binder`.
    ///
    /// # Errors
    /// As [`StackLayer::indices`]; more than [`StackClasses::MAX`] classes needed: thick layers with wide spreads.
    pub fn new(stack: &[StackLayer], binder: f64) -> Result<Self> {
        let layers = stack
            .iter()
            .map(|layer| {
                let (n, k) = layer.indices()?;
                let index = std::array::from_fn(|band| Complex::new(n.0[band], k.0[band]));
                Ok(Layer { index, thicknesses: vec![layer.thickness_nm] })
            })
            .collect::<Result<Vec<_>>>()?;
        let mean = Self { binder, layers, weights: vec![1.0] };
        let mut all = mean.clone();
        for (k, layer) in stack.iter().enumerate() {
            if layer.thickness_spread == 0.0 || layer.thickness_nm == 0.0 {
                continue;
            }
            let rule = mean.converged_rule(k, layer)?;
            if all.weights.len() * rule.len() > Self::MAX {
                let found = format!("more than {}", Self::MAX);
                let legal = "fewer: smaller spreads or thinner layers";
                return Err(Error::not_converged("", "thickness_spread: classes of flakes", found, legal));
            }
            all.weights = all.weights.iter().flat_map(|w| rule.iter().map(move |x| w * x.1)).collect();
            all.layers[k] = all.layers[k].spread(layer.thickness_nm, &rule);
        }
        Ok(all)
    }

    /// The smallest rule that gives the mean over the thicknesses of layer `k` alone, all others at their means, at a few
    /// angles and wavelengths.
    fn converged_rule(&self, k: usize, layer: &StackLayer) -> Result<Vec<(f64, f64)>> {
        let means = |rule: &[(f64, f64)]| {
            let mut one = self.clone();
            one.layers[k] = self.layers[k].spread(layer.thickness_nm, rule);
            one.weights = rule.iter().map(|x| x.1).collect();
            let probes = PROBES.into_iter().flat_map(|c| PROBED_BANDS.map(|band| (c, band)));
            probes.map(|(cos_alpha, band)| one.mean(cos_alpha, band)).collect::<Vec<_>>()
        };
        let mut rule = gauss_rule(layer.thickness_spread, RULES[0]);
        let mut values = means(&rule);
        for n in &RULES[1..] {
            let finer = gauss_rule(layer.thickness_spread, *n);
            let better = means(&finer);
            let error = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 - b.0).abs().max((a.1 - b.1).abs());
            if values.iter().zip(&better).map(error).fold(0.0, f64::max) < TOLERANCE {
                return Ok(rule);
            }
            (rule, values) = (finer, better);
        }
        let legal = "a smaller spread or a thinner layer";
        Err(Error::not_converged(format!("stack[{k}]"), "thickness_spread", layer.thickness_spread, legal))
    }

    /// Share of the flakes in each class; the sum is 1.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// r_p of every class (mean of both faces) at an angle of incidence on the flake, all bands.
    pub fn reflectances(&self, cos_alpha: f64) -> Vec<[f64; BANDS]> {
        let mut all = vec![[0.0; BANDS]; self.weights.len()];
        (0..BANDS).for_each(|band| self.visit(cos_alpha, band, |class, power| all[class][band] = power.0));
        all
    }

    /// Mean r_p and t_p over the classes at one band.
    pub fn mean(&self, cos_alpha: f64, band: usize) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        self.visit(cos_alpha, band, |class, (reflectance, transmittance)| {
            sum.0 += self.weights[class] * reflectance;
            sum.1 += self.weights[class] * transmittance;
        });
        sum
    }

    /// Calls `f` with every class, in order, and its r_p and t_p.
    fn visit(&self, cos_alpha: f64, band: usize, mut f: impl FnMut(usize, (f64, f64))) {
        let incidence = Incidence::new(self.binder, cos_alpha, wavelength_nm(band));
        let wave = |layer: &Layer| incidence.layer(layer.index[band]);
        // The last layer that varies is put in last: all amplitudes are linear in its matrix.
        let varied = self.layers.iter().rposition(|layer| layer.thicknesses.len() > 1).unwrap_or(0);
        let mut stacks = vec![[Characteristic::NONE; 2]];
        for layer in &self.layers[..varied] {
            let choices: Vec<_> = layer.thicknesses.iter().map(|nm| wave(layer).matrices(*nm)).collect();
            stacks = stacks.iter().flat_map(|s| choices.iter().map(move |c| then(s, c))).collect();
        }
        let behind = self.layers[varied + 1..].iter().fold([Characteristic::NONE; 2], |stack, layer| {
            then(&stack, &wave(layer).matrices(layer.thicknesses[0]))
        });
        let last = wave(&self.layers[varied]);
        let turns: Vec<_> = self.layers[varied].thicknesses.iter().map(|nm| last.turn(*nm)).collect();
        let mut class = 0;
        for stack in &stacks {
            let without = Embedded::new(&incidence, &then(stack, &behind));
            let within = Embedded::new(&incidence, &then(&then(stack, &last.generators()), &behind));
            for turn in &turns {
                let [s, p] = [0, 1].map(|p| without[p].turned(&within[p], turn).power());
                f(class, (0.5 * (s.0 + p.0), 0.5 * (s.1 + p.1)));
                class += 1;
            }
        }
    }
}

impl Layer {
    fn spread(&self, thickness_nm: f64, rule: &[(f64, f64)]) -> Self {
        Self { index: self.index, thicknesses: rule.iter().map(|x| x.0 * thickness_nm).collect() }
    }
}
