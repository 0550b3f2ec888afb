//! What films lie on.

use super::nodes::Nodes;
use super::operator::Operator;
use nalgebra::DMatrix;

/// A Lambertian ground of this albedo under a medium of this index, for m = 0 (eq. 4; it scatters into no other mode):
/// `f_0 = 2 albedo`.
pub fn lambertian(nodes: &Nodes, index: f64, albedo: f64) -> Operator {
    let n = nodes.count(index);
    let amplitude: Vec<f64> = nodes.weights().iter().map(|g| g.sqrt()).collect();
    let factor = 2.0 * albedo / (index * index);
    Operator::square(vec![0.0; n], DMatrix::from_fn(n, n, |i, j| factor * amplitude[i] * amplitude[j]))
}

/// A mirror of this reflectance at all angles.
pub fn mirror(nodes: &Nodes, index: f64, reflectance: f64) -> Operator {
    let n = nodes.count(index);
    Operator::diagonal(n, n, vec![reflectance; n])
}
