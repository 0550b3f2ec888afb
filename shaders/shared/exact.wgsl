// Twin of sampler/exact.rs: the cluster where the search for that at u begins, by its number among all. A table of clusters with bands
// leads to the first whose color has not gone over.

fn first_candidate(slice: Slice, u: f32) -> u32 {
    let parts = 1u << ((slice.guide & 31u) - 1u);
    let part = (slice.guide >> 5u) + min(u32(u * f32(parts)), parts - 1u);
    return slice.first_cluster + ((guide[part >> 1u] >> ((part & 1u) * 16u)) & 0xffffu);
}
