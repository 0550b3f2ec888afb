//! Layers with reflection and transmission from both sides, and adding them (Ershov 2001, eqs 2, 3, 5, 7, 8).
//!
//! `D = (1 - R1- R2+)^-1 T1+` is the light that goes down between an upper layer 1 and a lower layer 2, and
//! `R+ = R1+ + T1- R2+ D`, `T+ = T2+ D`; light from below is the same with the layers turned over.

use super::nodes::{Direction, Nodes};
use super::operator::Operator;
use crate::brdf::fresnel::dielectric;
use crate::error::Result;

/// A layer between two media.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// R+: light from above, back up.
    pub reflect_above: Operator,
    /// T+: light from above, down.
    pub transmit_down: Operator,
    /// R-: light from below, back down.
    pub reflect_below: Operator,
    /// T-: light from below, up.
    pub transmit_up: Operator,
}

impl Layer {
    /// A layer that is the same from both sides.
    pub fn symmetric(reflection: Operator, transmission: Operator) -> Self {
        Self {
            reflect_above: reflection.clone(),
            transmit_down: transmission.clone(),
            reflect_below: reflection,
            transmit_up: transmission,
        }
    }

    /// The smooth boundary between a medium of index `above` and one of index `below`: eq. 5 without its Jacobian.
    pub fn boundary(nodes: &Nodes, above: f64, below: f64) -> Self {
        let (up, down) = (nodes.count(above), nodes.count(below));
        let reflectance = |from: f64, to: f64| -> Vec<f64> {
            // A node that the other medium does not have is beyond the critical angle.
            let common = nodes.count(from.min(to));
            let directions: Vec<Direction> = nodes.directions(from);
            let all = directions.iter().enumerate();
            all.map(|(k, d)| if k < common { dielectric(d.cos, to / from) } else { 1.0 }).collect()
        };
        // From the thinner side, where no difference of large numbers occurs; both are the same by reciprocity.
        let common = reflectance(above.min(below), above.max(below));
        let passed: Vec<f64> = common.iter().map(|r| 1.0 - r).collect();
        let with_total = |n: usize| {
            let mut r = common.clone();
            r.resize(n, 1.0);
            Operator::diagonal(n, n, r)
        };
        Self {
            reflect_above: with_total(up),
            transmit_down: Operator::diagonal(down, up, passed.clone()),
            reflect_below: with_total(down),
            transmit_up: Operator::diagonal(up, down, passed),
        }
    }

    /// This layer over something that reflects `lower`: its reflection from above, and D.
    ///
    /// # Errors
    /// As [`Operator::all_rounds`].
    pub fn over(&self, lower: &Operator) -> Result<(Operator, Operator)> {
        if lower.is_zero() {
            return Ok((self.reflect_above.clone(), self.transmit_down.clone()));
        }
        let down = self.reflect_below.after(lower).all_rounds(&self.transmit_down)?;
        let reflection = self.transmit_up.after(&lower.after(&down)).plus(&self.reflect_above);
        Ok((reflection, down))
    }

    /// The layer turned over.
    #[must_use]
    pub fn turned(&self) -> Self {
        Self {
            reflect_above: self.reflect_below.clone(),
            transmit_down: self.transmit_up.clone(),
            reflect_below: self.reflect_above.clone(),
            transmit_up: self.transmit_down.clone(),
        }
    }

    /// This layer on top of another one.
    ///
    /// # Errors
    /// As [`Operator::all_rounds`].
    pub fn on(&self, lower: &Self) -> Result<Self> {
        let (reflect_above, down) = self.over(&lower.reflect_above)?;
        let (reflect_below, up) = lower.turned().over(&self.reflect_below)?;
        Ok(Self {
            reflect_above,
            transmit_down: lower.transmit_down.after(&down),
            reflect_below,
            transmit_up: self.transmit_up.after(&up),
        })
    }
}
