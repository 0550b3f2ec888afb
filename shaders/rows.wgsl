// Colors along u, drawn beforehand: a look-up in place of a search, boxes and Lab. The steps of a row are even in the normal number
// that u comes from, so that the rarest and brightest have steps of their own. Like sampler/quantile_row.rs with its `realized`: one
// draw a step, moved to the mean of the slice; the place in a box hangs on u.
//
// A look-up costs a software renderer the same for one word as for four: a step holds the colors of the four slices about a bin.

// Of every level and bin `ROW_STEPS` steps, what the slices remember, their means; see `pack_color`, `pack_memory`. Then two entries
// a texel of the color table: it, its right neighbor, the two below.
@group(3) @binding(3) var<storage, read> rows: array<vec4<u32>>;
// The same, word by word. Behind it which slices are to be filled: how many, and their numbers among those of all levels.
@group(3) @binding(4) var<storage, read_write> filled_rows: array<u32>;

// Steps of a row, their first normal number, and how many there are in one.
const ROW_STEPS: u32 = 254u;
const ROW_FIRST: f32 = -3.0;
const ROW_UNIT: f32 = 36.0;
// Entries of a row.
const ROW: u32 = 256u;
const ROW_THREADS: u32 = 64u;
const STEPS_A_THREAD: u32 = 4u;

var<workgroup> row_sums: array<vec3<f32>, 64>;

// A workgroup a slice and level that was not left out.
@compute @workgroup_size(64)
fn fill_rows(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32) {
    let place = group.y * groups.x + group.x;
    let first_texel = paint.flakes.levels * paint.flakes.slices_per_level * ROW;
    let texels = paint.colors_size.x * paint.colors_size.y;
    // First, so that where a workgroup turns off hangs on nothing but its number: barriers follow.
    let texel_groups = (texels + ROW_THREADS - 1u) / ROW_THREADS;
    if place < texel_groups {
        fill_texels(place * ROW_THREADS + thread, first_texel);
        return;
    }
    // Behind the last one, it again.
    let list = 4u * (first_texel + 2u * texels);
    let number = filled_rows[list + min(1u + place - texel_groups, filled_rows[list])];
    let slice = slice_at(number);
    var draws = array<vec3<f32>, 4>();
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < STEPS_A_THREAD; k++) {
        let step = row_interval(min(thread + k * ROW_THREADS, ROW_STEPS));
        let random = units(pcg4d(vec4<u32>(thread + k * ROW_THREADS, 0u, 0u, 0u)).yzw);
        draws[k] = color(slice, 1.0 - step.x, random);
        sum += draws[k] * step.y;
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
    let number_in_level = number % paint.flakes.slices_per_level;
    let level = number / paint.flakes.slices_per_level;
    let mean = vector(colors[paint.colors_size.x * paint.colors_size.y + number_in_level]);
    let shift = mean - row_sums[0];
    var words: array<u32, 4>;
    for (var k = 0u; k < STEPS_A_THREAD; k++) {
        let step = thread + k * ROW_THREADS;
        words[k] = pack_color(draws[k] + shift);
        if step == ROW_STEPS {
            words[k] = pack_memory(slice);
        } else if step > ROW_STEPS {
            words[k] = pack_color(mean);
        }
    }
    // To the bins whose corner this slice is.
    let own = bin_of(number_in_level);
    let first = max(own, vec2<u32>(1u)) - 1u;
    for (var y = first.y; y <= own.y; y++) {
        let length = grid_row_length(y);
        let end = select(own.x + 1u, length, own.x + 1u == grid_row_length(own.y));
        for (var x = first.x; x < min(end, length); x++) {
            for (var corner = 0u; corner < 4u; corner++) {
                if corner_slice(x + (corner & 1u), y + (corner >> 1u)) == number_in_level {
                    let row = (level * paint.flakes.slices_per_level + grid_slice(x, y)) * ROW;
                    for (var k = 0u; k < STEPS_A_THREAD; k++) {
                        filled_rows[4u * (row + thread + k * ROW_THREADS) + corner] = words[k];
                    }
                }
            }
        }
    }
}

fn fill_texels(texel: u32, first: u32) {
    let size = paint.colors_size;
    if texel >= size.x * size.y {
        return;
    }
    for (var corner = 0u; corner < 4u; corner++) {
        let x = min(texel % size.x + (corner & 1u), size.x - 1u);
        let y = min(texel / size.x + (corner >> 1u), size.y - 1u);
        let color = vector(colors[y * size.x + x]);
        let at = 4u * (first + 2u * texel) + 2u * corner;
        filled_rows[at] = pack2x16float(color.xy);
        filled_rows[at + 1u] = pack2x16float(vec2<f32>(color.z, 0.0));
    }
}

// The bin of a slice.
fn bin_of(slice: u32) -> vec2<u32> {
    // The last row that begins before it, of fewer than 256.
    var y = 0u;
    for (var step = 128u; step > 0u; step /= 2u) {
        if y + step < paint.flakes.rows && grid_start(y + step) <= slice {
            y += step;
        }
    }
    return vec2<u32>(slice - grid_start(y), y);
}

// As `flake_slices`.
fn corner_slice(theta_h: u32, theta_i: u32) -> u32 {
    let slice = grid_slice(theta_h, theta_i);
    if slice == NO_SLICE && paint.flakes.missing_is_nearest != 0u {
        return nearest_slice(theta_h, theta_i);
    }
    return slice;
}

// A color, 1/sr, in a word: three signed numbers of nine bits, and in five bits the power of two of their unit. The largest
// keeps eight bits.
fn pack_color(color: vec3<f32>) -> u32 {
    let size = abs(color);
    let most = max(max(size.x, size.y), max(size.z, COLOR_UNIT));
    let power = min((bitcast<u32>(most) >> 23u) + 1u - COLOR_BIAS - 8u, 31u);
    let unit = bitcast<f32>((power + COLOR_BIAS) << 23u);
    let whole = bitcast<vec3<u32>>(vec3<i32>(clamp(round(color / unit), vec3<f32>(-256.0), vec3<f32>(255.0))));
    return (whole.x << 23u) | ((whole.y & 511u) << 14u) | ((whole.z & 511u) << 5u) | power;
}

// Exponent of the least unit as a float has it, and the least of the largest numbers.
const COLOR_BIAS: u32 = 107u;
const COLOR_UNIT: f32 = 1.2207031e-4;

fn unpack_color(word: u32) -> vec3<f32> {
    let unit = bitcast<f32>(((word & 31u) + COLOR_BIAS) << 23u);
    return vec3<f32>(vec3<i32>(vec3<u32>(word, word << 9u, word << 18u)) >> vec3<u32>(23u)) * unit;
}

// Shares of the variance of draws that fade: see `LightPatch`.
fn pack_memory(slice: Slice) -> u32 {
    let fading = slice.fading * slice.fading;
    let all = slice.lasting * slice.lasting + dot(fading, vec4<f32>(1.0));
    return pack4x8unorm(fading / max(all, 1e-30));
}

// The middle of a step, counted from the end of u, and its width.
fn row_interval(step: u32) -> vec2<f32> {
    let near = ROW_FIRST + f32(step) / ROW_UNIT;
    let before = select(cdf(-near), 1.0, step == 0u);
    let behind = select(cdf(-near - 1.0 / ROW_UNIT), 0.0, step == ROW_STEPS - 1u);
    // Behind the last there is none.
    return vec2<f32>(0.5 * (before + behind), select(before - behind, 0.0, step >= ROW_STEPS));
}

// The step of a normal number.
fn row_step(g: f32) -> u32 {
    return u32(clamp((g - ROW_FIRST) * ROW_UNIT, 0.0, f32(ROW_STEPS - 1u)));
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
    return row_under_coat(g, xi, wi, wo, widening) * wi.z;
}

// As `under_coat`, the color table in halves.
fn row_under_coat(g: Geometry, xi: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>, widening: f32) -> vec3<f32> {
    let h = bracket(g.theta_h, paint.colors_size.x);
    let i = bracket(g.theta_i, paint.colors_size.y);
    let first = paint.flakes.levels * paint.flakes.slices_per_level * ROW;
    let at = first + 2u * (i.low * paint.colors_size.x + h.low);
    let upper = rows[at];
    let lower = rows[at + 1u];
    let down = vec4<f32>(vec2<f32>(1.0 - i.share), vec2<f32>(i.share));
    let weight = vec4<f32>(1.0 - h.share, h.share, 1.0 - h.share, h.share) * down;
    let xy = unpack2x16float(upper.x) * weight.x + unpack2x16float(upper.z) * weight.y
        + unpack2x16float(lower.x) * weight.z + unpack2x16float(lower.z) * weight.w;
    let z = unpack2x16float(upper.y).x * weight.x + unpack2x16float(upper.w).x * weight.y
        + unpack2x16float(lower.y).x * weight.z + unpack2x16float(lower.w).x * weight.w;
    let base = vec3<f32>(xy, z) * brightness(g.lobe, 0.0) + xi;
    return base * transmittance(wi.z, wo.z) + coat_gloss(wi, wo, widening);
}

// Xi under light from an area of projected half vectors about `half`, 1/sr.
fn xi_of_rows(surface: Surface, g: Geometry, half: vec2<f32>, area: f32) -> vec3<f32> {
    let d = detail(surface.footprint);
    let next = min(d.level + 1u, paint.flakes.levels - 1u);
    let at = row_bin(g.theta_h, g.theta_i);
    let fine = (d.level * paint.flakes.slices_per_level + at.bin) * ROW;
    let coarse = (next * paint.flakes.slices_per_level + at.bin) * ROW;
    let place = knot_place(half);
    let cells = vec2<f32>(level_cells_per_mm(d.level), level_cells_per_mm(next));
    let near = at.weight * (1.0 - d.fraction);
    let far = at.weight * d.fraction;
    var sum = vec3<f32>(0.0);
    for (var tap = 0u; tap < d.count; tap++) {
        let uv_mm = surface.uv_mm + d.long * ((f32(tap) + 0.5) / f32(d.count) - 0.5);
        let step = row_step(row_normal(surface, uv_mm, d, next, cells, place));
        sum += row_color(rows[fine + step], near) + row_color(rows[coarse + step], far);
    }
    let drawn = sum / f32(d.count);
    if !TURNING {
        return drawn;
    }
    // What of it the light's extent leaves: `kept` of one patch, the slices' shares interpolated.
    let fading = row_memory(rows[fine + ROW_STEPS], near) + row_memory(rows[coarse + ROW_STEPS], far);
    let spread = 2.0 * variance_of(area * knot_stretch(half));
    let left = sqrt(max(1.0 - dot(fading, spread / (RANGES + spread)), 0.0));
    let mean = row_color(rows[fine + ROW_STEPS + 1u], at.weight);
    return mean + (drawn - mean) * left;
}

// The bin whose corners are the slices about a pair of angles, and their weights, as `flake_slices`.
struct RowBin {
    bin: u32,
    weight: vec4<f32>,
}

fn row_bin(theta_h: f32, theta_i: f32) -> RowBin {
    let place = grid_place(theta_h, theta_i);
    let bin = vec2<u32>(place);
    let f = fract(place);
    let row = min(bin.y, paint.flakes.rows - 1u);
    let start = grid_start(row);
    let last = grid_start(row + 1u) - start - 1u;
    // Rows are never longer than those before: beyond the end of one there is nothing.
    let is_there = (bin.x <= last && bin.y == row) || paint.flakes.missing_is_nearest != 0u;
    let weight = vec4<f32>((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    return RowBin(start + min(bin.x, last), select(vec4<f32>(0.0), weight, is_there));
}

// The normal number of one tap at a place among the knots, `cells` a millimetre of both levels. Without branches: a software renderer takes both sides.
fn row_normal(surface: Surface, uv_mm: vec2<f32>, d: Detail, next: u32, cells: vec2<f32>, place: vec2<f32>) -> f32 {
    let fine = cell(surface, uv_mm, d.level, cells.x);
    let coarse = coarse_cell(surface, uv_mm, next, cells.y);
    if TURNING {
        let g = rough_knot_value(knot_lattice(pcg4d(fine)), place);
        return normal_blend(g, rough_knot_value(knot_lattice(pcg4d(coarse)), place), d.fraction);
    }
    return normal_blend(rough_probit(fine.x), rough_probit(coarse.x), d.fraction);
}

// `knot_value` to a twentieth of a step.
fn rough_knot_value(lattice: KnotLattice, place: vec2<f32>) -> f32 {
    let t = lattice.turn;
    let at = vec2<f32>(t.x * place.x - t.y * place.y, t.y * place.x + t.x * place.y) + lattice.offset;
    let corner = floor(at);
    let knot = bitcast<vec2<u32>>(vec2<i32>(corner));
    let g = vec4<f32>(
        rough_probit(pcg4d(vec4<u32>(knot, lattice.key)).x),
        rough_probit(pcg4d(vec4<u32>(knot.x + 1u, knot.y, lattice.key)).x),
        rough_probit(pcg4d(vec4<u32>(knot.x, knot.y + 1u, lattice.key)).x),
        rough_probit(pcg4d(vec4<u32>(knot + 1u, lattice.key)).x),
    );
    return dot(g, knot_weights(at - corner));
}

// `probit` of `unit` to 1.5e-3: with w = -ln(4 p (1 - p)), whose logarithm is to 1e-4, its square over w is nearly even.
fn rough_probit(bits: u32) -> f32 {
    let p = unit(bits);
    let x = 4.0 * p * (1.0 - p);
    let x_bits = bitcast<i32>(x);
    let exponent = (x_bits - 0x3f3504f3) >> 23u;
    let t = bitcast<f32>(x_bits - (exponent << 23u)) - 1.0;
    let w = -(f32(exponent) * LN_2 + t * (1.0 + t * (t * (0.35154592 - 0.22298907 * t) - 0.50227739)));
    let g = sqrt(max(w, 0.0) * (1.56200469 + 0.21922389 * w) / (1.0 + 0.10928317 * w));
    return select(g, -g, p < 0.5);
}

fn row_color(words: vec4<u32>, weight: vec4<f32>) -> vec3<f32> {
    return unpack_color(words.x) * weight.x + unpack_color(words.y) * weight.y
        + unpack_color(words.z) * weight.z + unpack_color(words.w) * weight.w;
}

fn row_memory(words: vec4<u32>, weight: vec4<f32>) -> vec4<f32> {
    return unpack4x8unorm(words.x) * weight.x + unpack4x8unorm(words.y) * weight.y
        + unpack4x8unorm(words.z) * weight.z + unpack4x8unorm(words.w) * weight.w;
}
