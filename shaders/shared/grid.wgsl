// Twin of btf/grid.rs.

const NO_SLICE: u32 = 0xffffffffu;

// Four slices, or NO_SLICE, and their weights.
struct SliceTaps {
    slice: vec4<u32>,
    weight: vec4<f32>,
}

fn grid_start(row: u32) -> u32 {
    return paint.flakes.starts[row >> 2u][row & 3u];
}

fn grid_row_length(row: u32) -> u32 {
    return grid_start(row + 1u) - grid_start(row);
}

fn grid_slice(theta_h: u32, theta_i: u32) -> u32 {
    if theta_i >= paint.flakes.rows || theta_h >= grid_row_length(theta_i) {
        return NO_SLICE;
    }
    return grid_start(theta_i) + theta_h;
}

// Coordinates of a pair of angles, in bins.
fn grid_place(theta_h: f32, theta_i: f32) -> vec2<f32> {
    return max(vec2<f32>(theta_h, theta_i) * (f32(paint.flakes.bins) * FRAC_2_PI), vec2<f32>(0.0));
}

fn grid_taps(theta_h: f32, theta_i: f32) -> SliceTaps {
    let place = grid_place(theta_h, theta_i);
    let bin = vec2<u32>(place);
    let f = fract(place);
    return SliceTaps(
        vec4<u32>(
            grid_slice(bin.x, bin.y),
            grid_slice(bin.x + 1u, bin.y),
            grid_slice(bin.x, bin.y + 1u),
            grid_slice(bin.x + 1u, bin.y + 1u),
        ),
        vec4<f32>((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y),
    );
}
