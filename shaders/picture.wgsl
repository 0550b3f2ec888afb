// Entry point: adds a part of what its pixels see to a block of a picture, a pixel an invocation.

// Discs have any size, random numbers may repeat, and boxes may have bands.
const WIDE_DISCS: bool = true;
const TEXTURED: bool = true;
const RAMPS: bool = true;

struct Block {
    // First column and row.
    first: vec2<u32>,
    size: vec2<u32>,
    part: Part,
    // Which of the paints group 0 holds: what wears another one is left to other passes.
    paint: u32,
}

@group(1) @binding(1) var<uniform> block: Block;
// Of the block, row-major.
@group(1) @binding(2) var<storage, read_write> pixels: array<array<f32, 3>>;

@compute @workgroup_size(8, 8)
fn picture(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < block.size) {
        let at = id.y * block.size.x + id.x;
        let radiance = vector(pixels[at]) + pixel(block.first + id.xy, block.part, block.paint);
        pixels[at] = array<f32, 3>(radiance.x, radiance.y, radiance.z);
    }
}
