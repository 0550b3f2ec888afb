// Twin of `Surface` in render/footprint.rs.

struct Surface {
    uv_mm: vec2<f32>,
    chart: u32,
    seed: u32,
    // The two sides of the patch, millimetres.
    footprint: array<vec2<f32>, 2>,
    // Cells a side of the random texture; 0: none, a hash.
    random: u32,
}
