// Twin of render/flakes.rs. Taps are drawn one by one, not kept: a software renderer is slow with arrays.

fn flake_draw(surface: Surface, d: Detail, tap: u32) -> Draw {
    let along = (f32(tap) + 0.5) / f32(d.count) - 0.5;
    let uv_mm = surface.uv_mm + d.long * along;
    let fine = cell(surface, uv_mm, d.level, level_cells_per_mm(d.level));
    var coarse = vec4<u32>(0u);
    if d.fraction > 0.0 {
        coarse = coarse_cell(surface, uv_mm, d.level + 1u, level_cells_per_mm(d.level + 1u));
    }
    return draw_of_words(fine, coarse, d.fraction, paint.flakes.knots_per_unit > 0.0);
}

fn level_cells_per_mm(level: u32) -> f32 {
    return paint.flakes.cells_per_mm[level >> 2u][level & 3u];
}

// Xi of one surface point, 1/sr.
fn xi(surface: Surface, theta_h: f32, theta_i: f32, half: vec2<f32>) -> vec3<f32> {
    return xi_of_taps(surface, detail(surface.footprint), flake_slices(theta_h, theta_i), half);
}

fn xi_of_taps(surface: Surface, d: Detail, slices: SliceTaps, half: vec2<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var tap = 0u; tap < d.count; tap++) {
        sum += xi_of_draw(flake_draw(surface, d, tap), d.level, d.fraction, slices, half);
    }
    return sum / f32(d.count);
}

// Mean of Xi over the surface, 1/sr. Means lie behind the color table.
fn xi_mean(theta_h: f32, theta_i: f32) -> vec3<f32> {
    let taps = flake_slices(theta_h, theta_i);
    let first = paint.colors_size.x * paint.colors_size.y;
    var sum = vec3<f32>(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        if taps.slice[corner] != NO_SLICE {
            sum += vector(colors[first + taps.slice[corner]]) * taps.weight[corner];
        }
    }
    return sum;
}

// Xi of one tap, 1/sr.
fn xi_of_draw(draw: Draw, level: u32, fraction: f32, taps: SliceTaps, half: vec2<f32>) -> vec3<f32> {
    let u = draw_u(draw, knot_place(half));
    let fine = quantile(level, taps, u, draw.inside);
    if fraction == 0.0 {
        return fine;
    }
    return mix(fine, quantile(level + 1u, taps, u, draw.inside), fraction);
}

fn quantile(level: u32, taps: SliceTaps, u: f32, inside: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        if taps.weight[corner] > 0.0 && taps.slice[corner] != NO_SLICE {
            let slice = slice_at(level * paint.flakes.slices_per_level + taps.slice[corner]);
            // None: left out.
            if slice.guide != 0u {
                sum += color(slice, u, inside) * taps.weight[corner];
            }
        }
    }
    return sum;
}

// What all draws see at a pair of directions.
struct FlakeView {
    slices: SliceTaps,
    half: vec2<f32>,
    mean: vec3<f32>,
}

fn flake_view(g: Geometry, half: vec2<f32>) -> FlakeView {
    return FlakeView(flake_slices(g.theta_h, g.theta_i), half, xi_mean(g.theta_h, g.theta_i));
}

// Xi of one tap less the mean, 1/sr.
fn fluctuation_of_draw(draw: Draw, d: Detail, seen: FlakeView) -> vec3<f32> {
    return xi_of_draw(draw, d.level, d.fraction, seen.slices, seen.half) - seen.mean;
}

// What a patch of light adds to the fluctuation, over an area of `area` of projected half vectors, counted `weight` times.
fn flake_patch(d: Detail, seen: FlakeView, area: f32, weight: f32) -> LightPatch {
    var light: LightPatch;
    if paint.flakes.knots_per_unit == 0.0 {
        return light;
    }
    light.memory = flake_memory(d.level, seen.slices);
    if d.fraction > 0.0 {
        let coarse = flake_memory(d.level + 1u, seen.slices);
        light.memory.lasting = mix(light.memory.lasting, coarse.lasting, d.fraction);
        light.memory.fading = mix(light.memory.fading, coarse.fading, d.fraction);
    }
    light.memory.lasting *= weight;
    light.memory.fading *= weight;
    light.place = knot_place(seen.half);
    light.variance = variance_of(area * knot_stretch(seen.half));
    return light;
}

// How much draws fluctuate, interpolated between slices like the draws. A slice that was left out has none.
fn flake_memory(level: u32, taps: SliceTaps) -> Memory {
    var sum: Memory;
    for (var corner = 0u; corner < 4u; corner++) {
        if taps.weight[corner] > 0.0 && taps.slice[corner] != NO_SLICE {
            let slice = slice_at(level * paint.flakes.slices_per_level + taps.slice[corner]);
            sum.lasting += slice.lasting * taps.weight[corner];
            sum.fading += slice.fading * taps.weight[corner];
        }
    }
    return sum;
}
