// Colors along u, drawn beforehand: a look-up in place of a search, boxes and Lab. The steps of a row are even in the normal number
// that u comes from, so that the rarest and brightest have steps of their own. Like sampler/quantile_row.rs with its `realized`: one
// draw a step, moved to the mean of the slice; the place in a box hangs on u. Textures, because software renderers read buffers
// lane by lane.

// A line a slice; levels side by side, a row each.
@group(3) @binding(3) var row_map: texture_2d<f32>;
@group(3) @binding(4) var filled_rows: texture_storage_2d<rgba16float, write>;
// A line a slice; of each level how far it fades, then its mean and what lasts: see `Slice`.
@group(3) @binding(5) var slice_map: texture_2d<f32>;
@group(3) @binding(6) var filled_slices: texture_storage_2d<rgba32float, write>;

// Steps of a row, their first normal number, and how many there are in one.
const ROW: u32 = 320u;
const ROW_FIRST: f32 = -3.0;
const ROW_UNIT: f32 = 44.0;
const ROW_THREADS: u32 = 64u;
const STEPS_A_THREAD: u32 = 5u;

var<workgroup> row_sums: array<vec3<f32>, 64>;

// A workgroup a slice and level.
@compute @workgroup_size(64)
fn fill_rows(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32) {
    let number = group.y * groups.x + group.x;
    if number >= paint.flakes.levels * paint.flakes.slices_per_level {
        return;
    }
    let slice = slices[number];
    var draws = array<vec3<f32>, 5>();
    var sum = vec3<f32>(0.0);
    if slice.parts > 0u {
        for (var k = 0u; k < STEPS_A_THREAD; k++) {
            let step = row_interval(thread + k * ROW_THREADS);
            let random = units(pcg4d(vec4<u32>(thread + k * ROW_THREADS, 0u, 0u, 0u)).yzw);
            draws[k] = color(slice, 1.0 - step.x, random);
            sum += draws[k] * step.y;
        }
    }
    row_sums[thread] = sum;
    for (var stride = ROW_THREADS / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if thread < stride {
            row_sums[thread] += row_sums[thread + stride];
        }
    }
    workgroupBarrier();
    // All levels have the same mean.
    let line = number % paint.flakes.slices_per_level;
    let level = number / paint.flakes.slices_per_level;
    let mean = vector(colors[paint.colors_size.x * paint.colors_size.y + line]);
    let shift = mean - row_sums[0];
    for (var k = 0u; k < STEPS_A_THREAD; k++) {
        let drawn = bounded(select(draws[k] + shift, vec3<f32>(0.0), slice.parts == 0u));
        let at = vec2<u32>(level * ROW + thread + k * ROW_THREADS, line);
        textureStore(filled_rows, at, vec4<f32>(drawn, 0.0));
    }
    if thread == 0u {
        textureStore(filled_slices, vec2<u32>(2u * level, line), slice.fading);
        textureStore(filled_slices, vec2<u32>(2u * level + 1u, line), vec4<f32>(mean, slice.lasting));
    }
}

// The middle of a step, counted from the end of u, and its width.
fn row_interval(step: u32) -> vec2<f32> {
    let near = ROW_FIRST + f32(step) / ROW_UNIT;
    let before = select(cdf(-near), 1.0, step == 0u);
    let behind = select(cdf(-near - 1.0 / ROW_UNIT), 0.0, step == ROW - 1u);
    return vec2<f32>(0.5 * (before + behind), before - behind);
}

// The step of a normal number.
fn row_step(g: f32) -> u32 {
    return u32(clamp((g - ROW_FIRST) * ROW_UNIT, 0.0, f32(ROW - 1u)));
}

// BRDF times cosine under a lamp's middle, at the contrast that its disc leaves; as `disc_radiance` of a small disc.
fn row_radiance(surface: Surface, disc: Disc, wo: vec3<f32>, widening: f32, sparkles: bool) -> vec3<f32> {
    let wi = disc.direction;
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let g = geometry(coat_inner(wi), coat_inner(wo));
    var xi = vec3<f32>(0.0);
    if sparkles {
        // The whole disc is one patch.
        let square = disc.sine * disc.sine;
        let area = 4.0 * FRAC_PI_2 * square / (1.0 + sqrt(max(1.0 - square, 0.0)));
        xi = xi_of_rows(surface, g, projected_half(wi, wo), area * half_stretch(wi, wo));
    }
    return under_coat(g, xi, wi, wo, widening) * wi.z;
}

// Xi under light from an area of projected half vectors about `half`, 1/sr.
fn xi_of_rows(surface: Surface, g: Geometry, half: vec2<f32>, area: f32) -> vec3<f32> {
    let d = detail(surface.footprint);
    let next = min(d.level + 1u, paint.flakes.levels - 1u);
    let lines = row_lines(g.theta_h, g.theta_i);
    let place = knot_place(half);
    let near = lines.weight * (1.0 - d.fraction);
    let far = lines.weight * d.fraction;
    var sum = vec3<f32>(0.0);
    for (var tap = 0u; tap < d.count; tap++) {
        let step = row_step(row_normal(surface, d, next, tap, place));
        sum += row_color(lines.slice, near, d.level * ROW + step) + row_color(lines.slice, far, next * ROW + step);
    }
    let drawn = sum / f32(d.count);
    if !TURNING {
        return drawn;
    }
    var light: LightPatch;
    light.variance = variance_of(area * knot_stretch(half));
    light.memory.fading = row_slices(lines.slice, near, 2u * d.level) + row_slices(lines.slice, far, 2u * next);
    let fine = row_slices(lines.slice, near, 2u * d.level + 1u);
    let coarse = row_slices(lines.slice, far, 2u * next + 1u);
    light.memory.lasting = fine.w + coarse.w;
    let mean = fine.xyz + coarse.xyz;
    return mean + (drawn - mean) * kept_of_one(light);
}

// As `flake_slices`; what is not there is any, with no weight.
fn row_lines(theta_h: f32, theta_i: f32) -> SliceTaps {
    let place = grid_place(theta_h, theta_i);
    let bin = vec2<u32>(place);
    let f = fract(place);
    let bins = vec4<u32>(bin.x, bin.x + 1u, bin.x, bin.x + 1u);
    let rows = min(vec2<u32>(bin.y, bin.y + 1u), vec2<u32>(paint.flakes.rows - 1u));
    let starts = vec2<u32>(grid_start(rows.x), grid_start(rows.y));
    let lengths = vec2<u32>(grid_start(rows.x + 1u), grid_start(rows.y + 1u)) - starts;
    let has_row = vec2<bool>(bin.y == rows.x, bin.y + 1u == rows.y);
    let is_there = (bins < lengths.xxyy) & has_row.xxyy;
    let weight = vec4<f32>((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    return SliceTaps(
        starts.xxyy + min(bins, lengths.xxyy - 1u),
        select(vec4<f32>(0.0), weight, is_there | vec4<bool>(paint.flakes.missing_is_nearest != 0u)),
    );
}

// The normal number of one tap at a place among the knots. Without branches: a software renderer takes both sides.
fn row_normal(surface: Surface, d: Detail, next: u32, tap: u32, place: vec2<f32>) -> f32 {
    let along = (f32(tap) + 0.5) / f32(d.count) - 0.5;
    let uv_mm = surface.uv_mm + d.long * along;
    let fine = cell(surface, uv_mm, d.level, level_cells_per_mm(d.level));
    let coarse = coarse_cell(surface, uv_mm, next, level_cells_per_mm(next));
    if TURNING {
        let g = knot_value(knot_lattice(pcg4d(fine)), place);
        return normal_blend(g, knot_value(knot_lattice(pcg4d(coarse)), place), d.fraction);
    }
    return normal_blend(probit(unit(fine.x)), probit(unit(coarse.x)), d.fraction);
}

fn row_color(lines: vec4<u32>, weight: vec4<f32>, x: u32) -> vec3<f32> {
    return textureLoad(row_map, vec2<u32>(x, lines.x), 0).xyz * weight.x
        + textureLoad(row_map, vec2<u32>(x, lines.y), 0).xyz * weight.y
        + textureLoad(row_map, vec2<u32>(x, lines.z), 0).xyz * weight.z
        + textureLoad(row_map, vec2<u32>(x, lines.w), 0).xyz * weight.w;
}

fn row_slices(lines: vec4<u32>, weight: vec4<f32>, x: u32) -> vec4<f32> {
    return textureLoad(slice_map, vec2<u32>(x, lines.x), 0) * weight.x
        + textureLoad(slice_map, vec2<u32>(x, lines.y), 0) * weight.y
        + textureLoad(slice_map, vec2<u32>(x, lines.z), 0) * weight.z
        + textureLoad(slice_map, vec2<u32>(x, lines.w), 0) * weight.w;
}
