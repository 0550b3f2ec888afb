//! Bounding volume hierarchy over triangles: which of them a ray may meet.
//!
//! Boxes halve the surface area heuristic's cost (MacDonald & Booth 1990) over sixteen bins an axis (Wald 2007). The tree is a
//! flat array in depth-first order; each node knows where its subtree ends, so that a ray needs no stack: it goes on with the
//! next node, or past the subtree.

use glam::{DVec3, Vec3};

/// A box of triangles, or of boxes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub low: Vec3,
    pub high: Vec3,
    /// Number of the node after this one's subtree.
    pub next: u32,
    /// First triangle and number of triangles, a multiple of 8 and what is above; 0: a box of boxes.
    pub leaf: u32,
}

/// Most triangles of a leaf, below 8.
const LEAF: usize = 4;
const BINS: usize = 16;
/// Deeper, triangles are halved by number: where bins separate few of many.
const MAX_DEPTH: usize = 40;

impl Node {
    /// Numbers of the triangles of a leaf.
    pub fn triangles(&self) -> std::ops::Range<usize> {
        let first = (self.leaf >> 3) as usize;
        first..first + (self.leaf & 7) as usize
    }
}

/// Boxes around triangles, and the order in which leaves number them.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> (Vec<Node>, Vec<usize>) {
    let boxes: Vec<Bounds> =
        triangles.iter().map(|t| t.iter().fold(Bounds::NONE, |b, p| b.with(*p))).collect();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    let mut nodes = Vec::with_capacity(2 * triangles.len());
    split(&boxes, &mut order, 0, 0, &mut nodes);
    (nodes, order)
}

/// Writes the subtree of the triangles `order`, the first of which has the number `first` among all.
fn split(boxes: &[Bounds], order: &mut [usize], first: usize, depth: usize, nodes: &mut Vec<Node>) {
    let bounds = order.iter().fold(Bounds::NONE, |b, k| b.joined(&boxes[*k]));
    let here = nodes.len();
    nodes.push(Node { low: bounds.low, high: bounds.high, next: 0, leaf: 0 });
    if order.len() <= LEAF {
        nodes[here].leaf = (first << 3 | order.len()) as u32;
    } else {
        let middle = if depth < MAX_DEPTH { partition(boxes, order) } else { order.len() / 2 };
        let (left, right) = order.split_at_mut(middle);
        split(boxes, left, first, depth + 1, nodes);
        split(boxes, right, first + middle, depth + 1, nodes);
    }
    nodes[here].next = nodes.len() as u32;
}

/// Sorts triangles into two parts by the cheapest plane between bins, and returns how many are in the first.
fn partition(boxes: &[Bounds], order: &mut [usize]) -> usize {
    let centers = order.iter().fold(Bounds::NONE, |b, k| b.with(boxes[*k].center()));
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        let mut bins = [(Bounds::NONE, 0); BINS];
        for k in order.iter() {
            let (bounds, count) = &mut bins[centers.bin(axis, boxes[*k].center())];
            *bounds = bounds.joined(&boxes[*k]);
            *count += 1;
        }
        for plane in 1..BINS {
            let cost = cost(&bins[..plane]) + cost(&bins[plane..]);
            if cost < best.0 {
                best = (cost, axis, plane);
            }
        }
    }
    let (_, axis, plane) = best;
    let is_left = |k: &usize| centers.bin(axis, boxes[*k].center()) < plane;
    // Few are many times moved: the order within a part does not matter.
    order.sort_by_key(|k| !is_left(k));
    let middle = order.partition_point(is_left);
    // All centers in one place.
    if middle == 0 || middle == order.len() { order.len() / 2 } else { middle }
}

/// Area of a box around bins times their triangles.
fn cost(bins: &[(Bounds, usize)]) -> f32 {
    let (bounds, count) = bins.iter().fold((Bounds::NONE, 0), |(b, n), (c, m)| (b.joined(c), n + m));
    if count == 0 { f32::INFINITY } else { bounds.area() * count as f32 }
}

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn with(self, p: Vec3) -> Self {
        Self { low: self.low.min(p), high: self.high.max(p) }
    }

    fn joined(self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn center(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    fn area(&self) -> f32 {
        let d = self.high - self.low;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Which of the bins along an axis of this box of centers holds a center.
    fn bin(&self, axis: usize, center: Vec3) -> usize {
        let width = self.high[axis] - self.low[axis];
        let at = (center[axis] - self.low[axis]) / width * BINS as f32;
        // No width: not a number, which becomes 0.
        (at as usize).min(BINS - 1)
    }
}

/// A ray as boxes are tried against it.
pub(super) struct Slabs {
    origin: DVec3,
    inverse: DVec3,
}

impl Slabs {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        // Along a face of a box 0 times infinity would be no number.
        let inverse = direction.map(|d| if d.abs() < 1e-20 { 1e20f64.copysign(d) } else { 1.0 / d });
        Self { origin, inverse }
    }

    /// Whether the ray is in the box somewhere between 0 and `far`.
    pub fn meets(&self, node: &Node, far: f64) -> bool {
        let a = (node.low.as_dvec3() - self.origin) * self.inverse;
        let b = (node.high.as_dvec3() - self.origin) * self.inverse;
        let enters = a.min(b).max_element();
        // Three roundings, so that a ray along an edge is not lost (Ize 2013).
        let leaves = a.max(b).min_element() * (1.0 + 4.0 * f64::EPSILON);
        enters <= leaves && leaves >= 0.0 && enters <= far
    }
}
