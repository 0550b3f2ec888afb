// Twin of render/print/, proof/coverage.rs and what they take of brdf/goniochromatic.rs and brdf/torrance_sparrow.rs.

struct Print {
    // Of each ink.
    roughness: vec3<f32>,
    // Wavelengths.
    bands: u32,
    white: vec3<f32>,
    levels: u32,
    // Share of the highlight, its exponent, albedo of the depth.
    paper: vec3<f32>,
    // Columns, rows and first word of every level of the coverage.
    sizes: array<vec4<u32>, 28>,
}

// Where a patch lies in its picture, and width and height of the rectangle with its variance, as shares of the picture's.
struct PrintPlace {
    printed: bool,
    uv: vec2<f32>,
    sides: vec2<f32>,
}

const COVERAGE_MAX_RATIO: f32 = 8.0;
const GONIOCHROMATIC: u32 = 0u;
const SCHLICK: u32 = 1u;
// How inks reflect: fixed when the pass is made, so that no pixel asks.
override INK_MODEL: u32 = 0u;

@group(2) @binding(0) var<uniform> printed: Print;
// A column a wavelength; rows: rho and c of each ink, linear Rec.709 of a reflectance of 1, index of the coating.
@group(2) @binding(1) var spectra: texture_2d<f32>;
// Dots, two bits each, then of each level three shares a texel.
@group(2) @binding(2) var<storage, read> coverage: array<u32>;

fn ggx(tan2_h: f32, roughness: vec3<f32>) -> vec3<f32> {
    let a2 = roughness * roughness;
    let root = 1.0 + (1.0 - a2) / (a2 + tan2_h);
    return a2 * root * root * FRAC_1_PI;
}

fn cos_mean_angle(cos_i: f32, cos_o: f32) -> f32 {
    let outer = sqrt((1.0 + cos_i) * (1.0 + cos_o));
    let inner = sqrt(max((1.0 - cos_i) * (1.0 - cos_o), 0.0));
    return (cos_i + cos_o) / (outer + inner);
}

fn smith_over_cosine(cosine: f32, roughness: vec3<f32>) -> vec3<f32> {
    let a2 = roughness * roughness;
    return 1.0 / (cosine + sqrt(a2 + (1.0 - a2) * cosine * cosine));
}

fn conductor(cos_i: f32, n: f32, k: f32) -> f32 {
    let c2 = cos_i * cos_i;
    let s2 = 1.0 - c2;
    let real = (n - k) * (n + k) - s2;
    let size = length(vec2<f32>(real, 2.0 * n * k));
    let root = sqrt(max((size + real) / 2.0, 0.0));
    let twice = 2.0 * root * cos_i;
    let s = (size + c2 - twice) / (size + c2 + twice);
    let a = c2 * size + s2 * s2;
    let b = twice * s2;
    return (s + s * (a - b) / (a + b)) / 2.0;
}

// BRDF where inks cover these shares of a place.
fn print_reflectance(covered: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    return inks_reflectance(covered, wi, wo) + printed.white * paper_reflectance(wi, wo);
}

// All inks at once, each by its share: one that is not there costs what the others do, and no branch.
fn inks_reflectance(covered: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let g = geometry(wi, wo).lobe;
    var amplitude = covered * ggx(g.tan2_h, printed.roughness);
    if INK_MODEL == GONIOCHROMATIC {
        amplitude *= 0.25;
    } else {
        amplitude *= smith_over_cosine(g.cos_i, printed.roughness) * smith_over_cosine(g.cos_o, printed.roughness);
    }
    let versine = 1.0 - cos_mean_angle(g.cos_i, g.cos_o);
    var sum = vec3<f32>(0.0);
    for (var band = 0u; band < printed.bands; band++) {
        let rho = textureLoad(spectra, vec2<u32>(band, 0u), 0).xyz;
        let color = textureLoad(spectra, vec2<u32>(band, 2u), 0).xyz;
        if INK_MODEL == GONIOCHROMATIC {
            let c = textureLoad(spectra, vec2<u32>(band, 1u), 0).xyz;
            sum += color * dot(amplitude, rho * exp(c * versine));
        } else if INK_MODEL == SCHLICK {
            let m = max(1.0 - g.cos_d, 0.0);
            let m2 = m * m;
            sum += color * dot(amplitude, rho + (1.0 - rho) * (m2 * m2 * m));
        } else {
            let index = textureLoad(spectra, vec2<u32>(band, 3u), 0).xy;
            sum += color * (conductor(g.cos_d, index.x, index.y) * dot(amplitude, rho));
        }
    }
    return sum;
}

fn paper_reflectance(wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let along = max(wi.z * wo.z - dot(wi.xy, wo.xy), 0.0);
    // 0^0 is 1, as on the CPU.
    let power = select(pow(along, printed.paper.y), 1.0, printed.paper.y == 0.0);
    let highlight = printed.paper.x * (printed.paper.y + 2.0) * 0.5 * FRAC_1_PI * power;
    return highlight + 0.25 * FRAC_1_PI * printed.paper.z / (wi.z + wo.z);
}

// Coverage over a patch; none where nothing is printed.
fn coverage_sample(place: PrintPlace) -> vec3<f32> {
    if !place.printed {
        return vec3<f32>(0.0);
    }
    let dots = place.sides * vec2<f32>(printed.sizes[0].xy);
    let texel = max(max(min(dots.x, dots.y), max(dots.x, dots.y) / COVERAGE_MAX_RATIO), 1.0);
    let level = min(log2(texel), f32(printed.levels - 1u));
    let fine = u32(level);
    let near = coverage_mean(fine, place.uv, place.sides);
    let far = coverage_mean(min(fine + 1u, printed.levels - 1u), place.uv, place.sides);
    return mix(near, far, level - f32(fine));
}

fn coverage_mean(level: u32, uv: vec2<f32>, sides: vec2<f32>) -> vec3<f32> {
    let size = vec2<f32>(printed.sizes[level].xy);
    let half = 0.5 * min(max(sides * size, max(vec2<f32>(1e-3), 4e-7 * size)), size);
    let center = clamp(uv, vec2<f32>(0.0), vec2<f32>(1.0)) * size;
    let low = center - half;
    let high = center + half;
    let first = vec2<i32>(floor(low));
    let end = vec2<i32>(ceil(high));
    var sum = vec3<f32>(0.0);
    var all = 0.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let texel = vec2<f32>(f32(x), f32(y));
            let part = min(high, texel + 1.0) - max(low, texel);
            all += part.x * part.y;
            sum += part.x * part.y * coverage_texel(level, inside(x, printed.sizes[level].x), inside(y, printed.sizes[level].y));
        }
    }
    return sum / all;
}

// What lies beyond an edge is mirrored there.
fn inside(k: i32, n: u32) -> u32 {
    let count = i32(n);
    return u32(clamp(select(min(k, 2 * count - 1 - k), -1 - k, k < 0), 0, count - 1));
}

fn coverage_texel(level: u32, x: u32, y: u32) -> vec3<f32> {
    let size = printed.sizes[level];
    let k = y * size.x + x;
    if level == 0u {
        let ink = (coverage[k >> 4u] >> (2u * (k & 15u))) & 3u;
        return vec3<f32>(vec3<u32>(ink) == vec3<u32>(1u, 2u, 3u));
    }
    let at = size.z + 3u * k;
    return bitcast<vec3<f32>>(vec3<u32>(coverage[at], coverage[at + 1u], coverage[at + 2u]));
}

// Where the patch about a hit lies in the picture that its object is printed with.
fn print_place(hit: Hit, covered: Footprint) -> PrintPlace {
    let shape = scene.objects[hit.object].shape;
    let steps = covered.sides;
    if shape.kind == MESH {
        return mesh_print_place(shape, hit, steps);
    }
    if shape.kind == PANEL {
        let axes = mat2x3<f32>(shape.right / (2.0 * shape.half_size.x), -shape.up / (2.0 * shape.half_size.y));
        return placed(true, hit.point * axes + 0.5, steps[0] * axes, steps[1] * axes);
    }
    let half_turn = 2.0 * FRAC_PI_2;
    let turned = vec2<f32>(-hit.point.y, hit.point.x);
    let from_axis = max(length(turned), 1e-18);
    let around = full_angle(turned.y, turned.x) / half_turn + 0.5;
    var down = 0.5 - 0.5 * hit.point.z / (shape.half_height + shape.radius);
    var down_per_mm = -0.5 / (shape.half_height + shape.radius);
    if shape.kind == SPHERE {
        down = full_angle(-hit.point.z, length(turned)) / half_turn + 0.5;
        down_per_mm = -1.0 / (from_axis * half_turn);
    }
    let right = turned / from_axis / (from_axis * half_turn);
    let sides = mat2x2<f32>(
        vec2<f32>(dot(right, steps[0].xy), steps[0].z * down_per_mm),
        vec2<f32>(dot(right, steps[1].xy), steps[1].z * down_per_mm),
    );
    return placed(around >= 0.0 && around <= 1.0, vec2<f32>(around, down), sides[0], sides[1]);
}

// A parallelogram; a side of hundreds of pictures is as good as one of one.
fn placed(printed_here: bool, uv: vec2<f32>, a: vec2<f32>, b: vec2<f32>) -> PrintPlace {
    let far = vec2<f32>(100.0);
    let first = clamp(a, -far, far);
    let second = clamp(b, -far, far);
    return PrintPlace(printed_here, uv, sqrt(first * first + second * second));
}

// Texture coordinates lie behind places and normals; a mesh without has some that are none.
fn mesh_print_place(mesh: Shape, hit: Hit, steps: array<vec3<f32>, 2>) -> PrintPlace {
    let vertices = mesh.first_vertex + 2u * tables[mesh.first_triangle + hit.part].xyz;
    let a = mesh_uv(vertices.x);
    let edges = mat2x2<f32>(mesh_uv(vertices.y) - a, mesh_uv(vertices.z) - a);
    let uv = a + edges * hit.weights;
    let printed_here = all(abs(uv) < vec2<f32>(1e20)) && dot(mesh_across(mesh, hit.part), hit.normal) > 0.0;
    let first = edges * mesh_weights_step(mesh, hit.part, steps[0]);
    return placed(printed_here, uv, first, edges * mesh_weights_step(mesh, hit.part, steps[1]));
}

fn mesh_uv(vertex: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(vec2<u32>(tables[vertex].w, tables[vertex + 1u].w));
}
