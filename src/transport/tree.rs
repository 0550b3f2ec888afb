//! The spanning tree of the network simplex and its pivots.
//!
//! Nodes are the sources, then the targets. Every node but the root holds the flow of the arc between it and its
//! parent. Potentials are u of a source and -v of a target, so that an arc's reduced cost is `w - u - v` and moving a
//! subtree changes all its potentials alike.
//!
//! The nodes lie in preorder in one array, so that a subtree is a range of it: re-hanging one is a handful of copies of
//! ranges, and pointers are followed only around the cycle of a pivot.

use super::dense::stride;
use super::mass::Mass;
use super::start::Shipment;
use std::ops::Range;

const NONE: u32 = u32::MAX;

/// A spanning tree, the flows on it and the potentials that its arcs imply.
pub(super) struct Tree<M> {
    sources: usize,
    nodes: Vec<Node>,
    /// All nodes, each followed by those below it.
    order: Vec<u32>,
    flow: Vec<M>,
    potential: Vec<i64>,
    /// The potentials rounded to f64: what dense pricing reads.
    rounded: Vec<f64>,
    /// A subtree on its way.
    moving: Vec<u32>,
}

/// Duals u of the sources and v of the targets, in units of the costs.
pub(super) struct Duals {
    pub source: Vec<i64>,
    pub target: Vec<i64>,
}

#[derive(Clone, Copy)]
struct Node {
    parent: u32,
    /// Where in the preorder.
    place: u32,
    /// Nodes of the subtree, this one included.
    size: u32,
}

impl<M: Mass> Tree<M> {
    /// The tree of a greedy plan. Backwards, each shipment adds one leaf: its node is used up and does not occur later.
    pub fn grow(sources: usize, targets: usize, shipments: &[Shipment<M>]) -> Self {
        let count = sources + targets;
        let mut nodes = vec![Node { parent: NONE, place: 0, size: 1 }; count];
        let mut flow = vec![M::shifted(0, 0); count];
        for shipment in shipments {
            let node = shipment.used_up;
            flow[node] = shipment.flow;
            nodes[node].parent = shipment.partner as u32;
            // All below this node were used up before.
            nodes[shipment.partner].size += nodes[node].size;
        }
        // Forwards from the root; a node's place serves as the next free one of its children until all have theirs.
        let mut order = vec![0; count];
        let root = shipments.last().map_or(0, |last| last.partner);
        let mut free = vec![1; count];
        order[0] = root as u32;
        for shipment in shipments.iter().rev() {
            let (node, parent) = (shipment.used_up, shipment.partner);
            let place = free[parent];
            free[parent] += nodes[node].size;
            free[node] = place + 1;
            nodes[node].place = place;
            order[place as usize] = node as u32;
        }
        let moving = Vec::with_capacity(count);
        // As long as a row of costs, so that the two are read together.
        let rounded = vec![0.0; sources + stride(targets)];
        Self { sources, nodes, order, flow, potential: vec![0; count], rounded, moving }
    }

    /// Number of nodes; there is one arc less.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Source, target and flow of every arc.
    pub fn arcs(&self) -> impl Iterator<Item = (usize, usize, M)> {
        self.order[1..].iter().map(|&node| {
            let (source, target) = self.arc_above(node as usize);
            (source, target, self.flow[node as usize])
        })
    }

    /// The duals, v of `target` being 0.
    pub fn duals(&self, target: usize) -> Duals {
        let (sources, targets) = self.potential.split_at(self.sources);
        let zero = targets[target];
        Duals {
            source: sources.iter().map(|u| u - zero).collect(),
            target: targets.iter().map(|v| zero - v).collect(),
        }
    }

    /// u of the sources and -v of the targets, rounded to f64.
    pub fn rounded_potentials(&self) -> (&[f64], &[f64]) {
        self.rounded.split_at(self.sources)
    }

    /// What an arc of this cost costs beyond its duals.
    pub fn reduced_cost(&self, source: usize, target: usize, cost: i64) -> i64 {
        cost + self.potential[self.sources + target] - self.potential[source]
    }

    /// Sets the potentials so that no arc of the tree costs more or less than its duals.
    pub fn price(&mut self, cost: impl Fn(usize, usize) -> i64) {
        self.set_potential(self.order[0] as usize, 0);
        for place in 1..self.order.len() {
            let node = self.order[place] as usize;
            let (source, target) = self.arc_above(node);
            let cost = cost(source, target);
            let change = if node < self.sources { cost } else { -cost };
            self.set_potential(node, self.potential[self.nodes[node].parent as usize] + change);
        }
    }

    fn set_potential(&mut self, node: usize, potential: i64) {
        self.potential[node] = potential;
        self.rounded[node] = potential as f64;
    }

    /// Brings in an arc of negative reduced cost: it is sent what the cycle it closes can bear, and the arc whose flow that
    /// takes leaves the tree.
    pub fn pivot(&mut self, source: usize, target: usize, reduced_cost: i64) {
        let target = self.sources + target;
        let (leaving, at_source) = self.blocking(source, target);
        let (flow, size) = (self.flow[leaving], self.nodes[leaving].size);
        let (top, onto, shift) =
            if at_source { (source, target, reduced_cost) } else { (target, source, -reduced_cost) };
        let meeting = self.push(source, target, flow);
        self.for_path(self.nodes[leaving].parent as usize, meeting, |node| node.size -= size);
        self.for_path(onto, meeting, |node| node.size += size);
        let start = self.rehang(top, onto, leaving, flow);
        for place in start..start + size as usize {
            let node = self.order[place] as usize;
            self.set_potential(node, self.potential[node] + shift);
        }
    }

    /// The arc of the cycle with the least flow among those whose flow falls: its lower node, and whether that is on the
    /// side of `source`. Without degeneracy it is the only one.
    fn blocking(&self, source: usize, target: usize) -> (usize, bool) {
        let mut least: Option<(usize, bool, M)> = None;
        let (mut a, mut b) = (source, target);
        while a != b {
            // A smaller subtree holds no ancestor of the other node.
            let at_source = self.nodes[a].size <= self.nodes[b].size;
            let node = if at_source { &mut a } else { &mut b };
            // From the new arc's target the flow rises to where the sides meet, then falls to its source: arcs of
            // sources carry less on the one side, arcs of targets on the other.
            let falls = (*node < self.sources) == at_source;
            if falls && least.is_none_or(|(_, _, flow)| self.flow[*node] < flow) {
                least = Some((*node, at_source, self.flow[*node]));
            }
            *node = self.nodes[*node].parent as usize;
        }
        // The cycle leaves `source` by an arc whose flow falls, so there always is one.
        least.map_or((source, true), |(node, at_source, _)| (node, at_source))
    }

    /// Sends flow around the cycle; the node at which its sides meet.
    fn push(&mut self, source: usize, target: usize, flow: M) -> usize {
        let (mut a, mut b) = (source, target);
        while a != b {
            let at_source = self.nodes[a].size <= self.nodes[b].size;
            let node = if at_source { &mut a } else { &mut b };
            let old = self.flow[*node];
            self.flow[*node] = if (*node < self.sources) == at_source { old - flow } else { old + flow };
            *node = self.nodes[*node].parent as usize;
        }
        a
    }

    /// Changes the nodes from one up to, not including, another.
    fn for_path(&mut self, mut node: usize, end: usize, change: impl Fn(&mut Node)) {
        while node != end {
            change(&mut self.nodes[node]);
            node = self.nodes[node].parent as usize;
        }
    }

    /// Cuts the arc above `leaving`, makes `top` the root of the subtree cut off, hangs it below `onto` and tells its place.
    fn rehang(&mut self, top: usize, onto: usize, leaving: usize, flow: M) -> usize {
        let total = self.nodes[leaving].size;
        let (mut node, mut parent, mut flow) = (top, onto, flow);
        let range = |node: Node| node.place as usize..(node.place + node.size) as usize;
        // The former range of the child that has become the parent.
        let mut inner = range(Node { size: 0, ..self.nodes[top] });
        self.moving.clear();
        loop {
            let outer = range(self.nodes[node]);
            self.moving.extend_from_slice(&self.order[outer.start..inner.start]);
            self.moving.extend_from_slice(&self.order[inner.end..outer.end]);
            let size = total - inner.len() as u32;
            let above =
                std::mem::replace(&mut self.nodes[node], Node { parent: parent as u32, place: 0, size });
            let old_flow = std::mem::replace(&mut self.flow[node], flow);
            inner = outer;
            if node == leaving {
                break;
            }
            (node, parent, flow) = (above.parent as usize, node, old_flow);
        }
        self.reorder(inner, self.nodes[onto].place as usize + 1)
    }

    /// Puts the nodes of `moving` in front of those at `place`, away from their old range; tells where they now begin.
    fn reorder(&mut self, old: Range<usize>, place: usize) -> usize {
        let (start, changed) = if place <= old.start {
            self.order.copy_within(place..old.start, place + old.len());
            (place, place..old.end)
        } else {
            self.order.copy_within(old.end..place, old.start);
            (place - old.len(), old.start..place)
        };
        self.order[start..start + old.len()].copy_from_slice(&self.moving);
        for place in changed {
            self.nodes[self.order[place] as usize].place = place as u32;
        }
        start
    }

    /// The arc between a node and its parent, as source and target.
    fn arc_above(&self, node: usize) -> (usize, usize) {
        let parent = self.nodes[node].parent as usize;
        if node < self.sources { (node, parent - self.sources) } else { (parent, node - self.sources) }
    }
}
