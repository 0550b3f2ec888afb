// Twin of sampler/exact.rs: the cluster at u, by its number among all of the paint.

fn lookup(slice: Slice, u: f32) -> u32 {
    let part = slice.first_part + min(u32(u * f32(slice.parts)), slice.parts - 1u);
    var k = slice.first_cluster + ((guide[part >> 1u] >> ((part & 1u) * 16u)) & 0xffffu);
    while u >= clusters[k].cumulative && clusters[k].cumulative < 1.0 {
        k++;
    }
    return k;
}
