//! Points that are one to all others.

use super::mass::Mass;

/// The points of one side that have mass; those that cost the same to all of the other side are one.
///
/// Many points at one place have many plans of the same cost: as one point they have a single plan, which is then dealt
/// out among them in their order.
pub(super) struct Points {
    /// Numbers of the points, each followed by those that coincide with it.
    numbers: Vec<usize>,
    /// Where those at each place end.
    ends: Vec<usize>,
}

impl Points {
    /// Points of these numbers. Those that are the `same` have the same `key`, counted as they stand in the list.
    pub fn new(numbers: &[usize], key: &[f64], same: impl Fn(usize, usize) -> bool) -> Self {
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.sort_by(|&a, &b| key[a].total_cmp(&key[b]).then(a.cmp(&b)));
        let mut places = Vec::with_capacity(numbers.len());
        for run in order.chunk_by(|&a, &b| key[a] == key[b]) {
            let mut firsts: Vec<usize> = Vec::new();
            for &k in run {
                let first = firsts.iter().copied().find(|&first| same(first, k)).unwrap_or(k);
                if first == k {
                    firsts.push(k);
                }
                places.push((first, numbers[k]));
            }
        }
        places.sort();
        let ends = places.chunk_by(|a, b| a.0 == b.0).scan(0, |end, place| {
            *end += place.len();
            Some(*end)
        });
        Self { ends: ends.collect(), numbers: places.iter().map(|place| place.1).collect() }
    }

    /// Number of places.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// All points, place by place.
    pub fn numbers(&self) -> &[usize] {
        &self.numbers
    }

    /// Number of the first point at each place.
    pub fn firsts(&self) -> impl ExactSizeIterator<Item = usize> + Clone {
        self.starts().map(|start| self.numbers[start])
    }

    /// Number and place of every point, place by place.
    pub fn placed(&self) -> impl Iterator<Item = (usize, usize)> {
        let place = |(place, (start, end)): (usize, (usize, &usize))| {
            self.numbers[start..*end].iter().map(move |&number| (number, place))
        };
        self.starts().zip(&self.ends).enumerate().flat_map(place)
    }

    /// Sums over the points of each place of amounts given place by place.
    pub fn sums<M: Mass>(&self, amounts: &[M]) -> Vec<M> {
        let sum = |(start, end): (usize, &usize)| {
            amounts[start..*end].iter().copied().reduce(|a, b| a + b).unwrap_or(M::shifted(0, 0))
        };
        self.starts().zip(&self.ends).map(sum).collect()
    }

    /// Where in [`Points::numbers`] the points of each place begin.
    fn starts(&self) -> impl ExactSizeIterator<Item = usize> + Clone {
        (0..self.len()).map(|place| if place == 0 { 0 } else { self.ends[place - 1] })
    }
}

/// Points of one side and their masses, place by place.
pub(super) type Side<'a, M> = (&'a Points, Vec<M>);

/// Deals out flows between places, sorted by source, then target: each point in turn sends or takes what it has. Pairs of
/// numbers and their flows.
pub(super) fn deal<M: Mass>(
    flows: &[(usize, usize, M)],
    (sources, mut supply): Side<M>,
    (targets, mut demand): Side<M>,
) -> Vec<(usize, usize, M)> {
    let zero = M::shifted(0, 0);
    let (mut from, mut to): (Vec<usize>, Vec<usize>) =
        (sources.starts().collect(), targets.starts().collect());
    let mut dealt = Vec::with_capacity(supply.len() + demand.len());
    for &(source, target, mut flow) in flows {
        while flow > zero {
            let (i, j) = (from[source], to[target]);
            let moved = flow.min(supply[i]).min(demand[j]);
            dealt.push((sources.numbers[i], targets.numbers[j], moved));
            flow = flow - moved;
            supply[i] = supply[i] - moved;
            demand[j] = demand[j] - moved;
            from[source] += usize::from(supply[i] == zero);
            to[target] += usize::from(demand[j] == zero);
        }
    }
    dealt
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_and_their_flows_dealt_out_in_order() {
        // 3 and 7 coincide; 5 has their key by chance.
        let sources = Points::new(&[3, 5, 7], &[1.0, 1.0, 1.0], |a, b| a != 1 && b != 1);
        assert_eq!(sources.placed().collect::<Vec<_>>(), [(3, 0), (7, 0), (5, 1)]);
        assert_eq!(sources.firsts().collect::<Vec<_>>(), [3, 5]);
        let targets = Points::new(&[0, 1], &[2.0, 4.0], |_, _| true);
        assert_eq!(targets.len(), 2);
        let supply = vec![2_u64, 4, 3];
        assert_eq!(sources.sums(&supply), [6, 3]);
        let dealt = deal(&[(0, 0, 3), (0, 1, 3), (1, 1, 3)], (&sources, supply), (&targets, vec![3, 6]));
        assert_eq!(dealt, [(3, 0, 2), (7, 0, 1), (7, 1, 3), (5, 1, 3)]);
    }
}
