// Colors along u, drawn beforehand: a look-up in place of a search, boxes and Lab. Half of the steps of what is left of (0, 1) lie
// in its lower half, and so on, so that the rarest and brightest have steps of their own. Like sampler/quantile_row.rs with its
// `realized`: one draw a step, moved to the mean of the slice; the place in a box hangs on u.

@group(3) @binding(3) var<storage, read> rows: array<vec2<u32>>;
@group(3) @binding(4) var<storage, read_write> filled_rows: array<vec2<u32>>;

const OCTAVES: u32 = 10u;
// Of an octave.
const STEPS: u32 = 32u;
const ROW: u32 = 320u;
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
    let first = paint.colors_size.x * paint.colors_size.y;
    let shift = vector(colors[first + number % paint.flakes.slices_per_level]) - row_sums[0];
    for (var k = 0u; k < STEPS_A_THREAD; k++) {
        let drawn = bounded(select(draws[k] + shift, vec3<f32>(0.0), slice.parts == 0u));
        let at = number * ROW + thread + k * ROW_THREADS;
        filled_rows[at] = vec2<u32>(pack2x16float(drawn.xy), pack2x16float(vec2<f32>(drawn.z, 0.0)));
    }
}

// The middle of a step, counted from the end of u, and its width.
fn row_interval(step: u32) -> vec2<f32> {
    let octave = step / STEPS;
    let inside = (f32(step % STEPS) + 0.5) / f32(STEPS);
    let is_last = octave == OCTAVES - 1u;
    let side = 1.0 / f32(1u << min(octave + 1u, OCTAVES - 1u));
    return vec2<f32>(side * select(1.0 + inside, inside, is_last), side / f32(STEPS));
}

// The step of u.
fn row_step(u: f32) -> u32 {
    let left = 1.0 - u;
    let bits = bitcast<u32>(left);
    let octave = 126u - (bits >> 23u);
    let inside = (bits >> 18u) & (STEPS - 1u);
    let last = (OCTAVES - 1u) * STEPS + u32(left * f32(STEPS << (OCTAVES - 1u)));
    return select(octave * STEPS + inside, last, octave >= OCTAVES - 1u);
}

// The random numbers of one tap, as of `flake_draw`, but for the place in a box.
struct RowDraw {
    fine: KnotLattice,
    coarse: KnotLattice,
    fixed_u: f32,
    // Of the two normal numbers in their blend.
    shares: vec2<f32>,
}

// Without branches: a software renderer takes both sides.
fn row_draw(surface: Surface, d: Detail, tap: u32) -> RowDraw {
    let along = (f32(tap) + 0.5) / f32(d.count) - 0.5;
    let uv_mm = surface.uv_mm + d.long * along;
    let next = min(d.level + 1u, paint.flakes.levels - 1u);
    let fine = cell(surface, uv_mm, d.level, level_cells_per_mm(d.level));
    let coarse = cell(surface, uv_mm, next, level_cells_per_mm(next));
    let parts = vec2<f32>(1.0 - d.fraction, d.fraction);
    var draw: RowDraw;
    draw.shares = parts / length(parts);
    if TURNING {
        draw.fine = knot_lattice(pcg4d(fine));
        draw.coarse = knot_lattice(pcg4d(coarse));
    } else {
        let blend = cdf(dot(draw.shares, vec2<f32>(probit(unit(fine.x)), probit(unit(coarse.x)))));
        draw.fixed_u = select(unit(fine.x), blend, d.fraction > 0.0);
    }
    return draw;
}

fn row_u(draw: RowDraw, place: vec2<f32>) -> f32 {
    if TURNING {
        return cdf(dot(draw.shares, vec2<f32>(knot_value(draw.fine, place), knot_value(draw.coarse, place))));
    }
    return draw.fixed_u;
}

// As `xi_of_draw`.
fn xi_of_rows(draw: RowDraw, d: Detail, taps: SliceTaps, half: vec2<f32>) -> vec3<f32> {
    let step = row_step(row_u(draw, knot_place(half)));
    let next = min(d.level + 1u, paint.flakes.levels - 1u);
    return mix(row_color(d.level, taps, step), row_color(next, taps, step), d.fraction);
}

fn row_color(level: u32, taps: SliceTaps, step: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        let is_there = taps.slice[corner] != NO_SLICE;
        let slice = level * paint.flakes.slices_per_level + select(0u, taps.slice[corner], is_there);
        let texel = rows[slice * ROW + step];
        let drawn = vec3<f32>(unpack2x16float(texel.x), unpack2x16float(texel.y).x);
        sum += drawn * select(0.0, taps.weight[corner], is_there);
    }
    return sum;
}
