//! The spanning tree of the network simplex and its pivots.
//!
//! Nodes are the sources, then the targets. Every node but the root holds the flow of the arc between it and its
//! parent. Potentials are u of a source and -v of a target, so that an arc's reduced cost is `w - u - v` and moving a
//! subtree changes all its potentials alike.

use super::mass::Mass;

const NONE: u32 = u32::MAX;

/// Costs in fixed point, source by source, and the tree they are routed on.
pub(super) struct Tree<M> {
    sources: usize,
    targets: usize,
    links: Vec<Links>,
    flow: Vec<M>,
    potential: Vec<i64>,
}

/// Neighbors in the tree.
#[derive(Clone, Copy)]
struct Links {
    parent: u32,
    depth: u32,
    first_child: u32,
    next_sibling: u32,
    previous_sibling: u32,
}

/// A step of the construction: what `used_up` still holds goes to or comes from `partner`, which keeps a rest.
pub(super) struct Shipment<M> {
    pub used_up: usize,
    pub partner: usize,
    pub flow: M,
}

impl<M: Mass> Tree<M> {
    /// The tree of a greedy plan. Backwards, each shipment adds one leaf: its node is used up and does not occur later.
    pub fn grow(sources: usize, targets: usize, shipments: &[Shipment<M>]) -> Self {
        let nodes = sources + targets;
        let lone =
            Links { parent: NONE, depth: 0, first_child: NONE, next_sibling: NONE, previous_sibling: NONE };
        let mut tree = Self {
            sources,
            targets,
            links: vec![lone; nodes],
            flow: vec![M::shifted(0, 0); nodes],
            potential: vec![0; nodes],
        };
        for shipment in shipments.iter().rev() {
            tree.attach(shipment.used_up, shipment.partner, shipment.flow);
            tree.links[shipment.used_up].depth = tree.links[shipment.partner].depth + 1;
        }
        tree
    }

    /// Source, target and flow of every arc.
    pub fn arcs(&self) -> impl Iterator<Item = (usize, usize, M)> {
        self.links.iter().enumerate().filter(|(_, links)| links.parent != NONE).map(|(node, links)| {
            let (source, target) = self.oriented(node, links.parent as usize);
            (source, target, self.flow[node])
        })
    }

    /// The duals u of the sources and v of the targets, in units of the costs, v of `target` being 0.
    pub fn duals(&self, target: usize) -> (impl Iterator<Item = i64>, impl Iterator<Item = i64>) {
        let (sources, targets) = self.potential.split_at(self.sources);
        let zero = targets[target];
        (sources.iter().map(move |u| u - zero), targets.iter().map(move |v| zero - v))
    }

    /// What every arc costs beyond its duals, source by source.
    pub fn reduced_costs<'a>(&'a self, costs: &'a [i64]) -> impl Iterator<Item = i64> + 'a {
        let (sources, targets) = self.potential.split_at(self.sources);
        let rows = sources.iter().zip(costs.chunks_exact(self.targets));
        rows.flat_map(move |(u, row)| row.iter().zip(targets).map(move |(cost, v)| cost + v - u))
    }

    /// Sets the potentials so that no arc of the tree costs more or less than its duals.
    pub fn price(&mut self, costs: &[i64]) {
        if let Some(root) = self.links.iter().position(|links| links.parent == NONE) {
            self.for_subtree(root, |tree, node| {
                let parent = tree.links[node].parent;
                if parent != NONE {
                    let (source, target) = tree.oriented(node, parent as usize);
                    let cost = costs[source * tree.targets + target];
                    let change = if node < tree.sources { cost } else { -cost };
                    tree.potential[node] = tree.potential[parent as usize] + change;
                }
            });
        }
    }

    /// Pivots until no arc has a negative reduced cost. `price` must have set the potentials for the same costs.
    ///
    /// The rows of the cost matrix take turns; the arc that enters is the cheapest of its row.
    pub fn optimize(&mut self, costs: &[i64]) {
        let (mut source, mut idle) = (0, 0);
        while idle < self.sources {
            let (target, reduced_cost) = self.cheapest(source, costs);
            if reduced_cost < 0 {
                self.pivot(source, target, reduced_cost);
                idle = 0;
            } else {
                idle += 1;
            }
            source = (source + 1) % self.sources;
        }
    }

    /// First target of least reduced cost.
    fn cheapest(&self, source: usize, costs: &[i64]) -> (usize, i64) {
        let row = &costs[source * self.targets..][..self.targets];
        let mut best = (0, i64::MAX);
        for (target, (cost, potential)) in row.iter().zip(&self.potential[self.sources..]).enumerate() {
            let above = cost + potential;
            if above < best.1 {
                best = (target, above);
            }
        }
        (best.0, best.1 - self.potential[source])
    }

    /// Sends through the arc what the cycle it closes can bear; the arc whose flow that takes leaves the tree.
    fn pivot(&mut self, source: usize, target: usize, reduced_cost: i64) {
        let target = self.sources + target;
        let (leaving, at_source, flow) = self.blocking(source, target);
        self.push(source, target, flow);
        let (top, onto, shift) =
            if at_source { (source, target, reduced_cost) } else { (target, source, -reduced_cost) };
        self.rehang(top, onto, leaving, flow);
        self.for_subtree(top, |tree, node| {
            tree.links[node].depth = tree.links[tree.links[node].parent as usize].depth + 1;
            tree.potential[node] += shift;
        });
    }

    /// The arc of the cycle with the least flow among those whose flow falls: its lower node, whether that is on the
    /// side of `source`, and its flow. Without degeneracy it is the only one.
    fn blocking(&self, source: usize, target: usize) -> (usize, bool, M) {
        let mut least: Option<(usize, bool, M)> = None;
        let (mut a, mut b) = (source, target);
        while a != b {
            let at_source = self.links[a].depth >= self.links[b].depth;
            let node = if at_source { &mut a } else { &mut b };
            // From the new arc's target the flow rises to where the sides meet, then falls to its source: arcs of
            // sources carry less on the one side, arcs of targets on the other.
            let falls = (*node < self.sources) == at_source;
            if falls && least.is_none_or(|(_, _, flow)| self.flow[*node] < flow) {
                least = Some((*node, at_source, self.flow[*node]));
            }
            *node = self.links[*node].parent as usize;
        }
        // The cycle leaves `source` by an arc whose flow falls, so there always is one.
        least.unwrap_or((source, true, self.flow[source]))
    }

    fn push(&mut self, source: usize, target: usize, flow: M) {
        let (mut a, mut b) = (source, target);
        while a != b {
            let at_source = self.links[a].depth >= self.links[b].depth;
            let node = if at_source { &mut a } else { &mut b };
            let old = self.flow[*node];
            self.flow[*node] = if (*node < self.sources) == at_source { old - flow } else { old + flow };
            *node = self.links[*node].parent as usize;
        }
    }

    /// Cuts the arc above `leaving`, makes `top` the root of the subtree cut off and hangs it onto another node.
    fn rehang(&mut self, top: usize, onto: usize, leaving: usize, flow: M) {
        let (mut node, mut parent, mut flow) = (top, onto, flow);
        loop {
            let (old_parent, old_flow) = (self.links[node].parent as usize, self.flow[node]);
            self.detach(node);
            self.attach(node, parent, flow);
            if node == leaving {
                break;
            }
            (node, parent, flow) = (old_parent, node, old_flow);
        }
    }

    fn detach(&mut self, node: usize) {
        let Links { parent, next_sibling, previous_sibling, .. } = self.links[node];
        if previous_sibling == NONE {
            self.links[parent as usize].first_child = next_sibling;
        } else {
            self.links[previous_sibling as usize].next_sibling = next_sibling;
        }
        if next_sibling != NONE {
            self.links[next_sibling as usize].previous_sibling = previous_sibling;
        }
    }

    fn attach(&mut self, node: usize, parent: usize, flow: M) {
        let next = std::mem::replace(&mut self.links[parent].first_child, node as u32);
        if next != NONE {
            self.links[next as usize].previous_sibling = node as u32;
        }
        let links = &mut self.links[node];
        (links.parent, links.next_sibling, links.previous_sibling) = (parent as u32, next, NONE);
        self.flow[node] = flow;
    }

    /// Visits a node and all below it, parents first.
    fn for_subtree(&mut self, top: usize, mut visit: impl FnMut(&mut Self, usize)) {
        let mut node = top;
        loop {
            visit(self, node);
            let mut next = self.links[node].first_child;
            while next == NONE {
                if node == top {
                    return;
                }
                next = self.links[node].next_sibling;
                if next == NONE {
                    node = self.links[node].parent as usize;
                }
            }
            node = next as usize;
        }
    }

    fn oriented(&self, node: usize, parent: usize) -> (usize, usize) {
        if node < self.sources { (node, parent - self.sources) } else { (parent, node - self.sources) }
    }
}
