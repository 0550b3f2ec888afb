//! Every reader of a file that the program takes: what makes a small valid file, and what reads it. Listed once, for tests and
//! for fuzzing (`fuzz/`).
#![allow(dead_code)]

#[path = "../common/small.rs"]
mod small;
#[path = "../common/tensor.rs"]
mod tensor;

use carpaint::brdf::{
    ClearCoat, ColorTable, Goniospectra, Ink, Lobe, TabulatedBrdf, merl, read_measured, read_nbrdf,
    read_samples,
};
use carpaint::btf::axf::{AxfFolder, AxfSmooth, write_axf_folder};
use carpaint::btf::{BtfReader, FlakeSource};
use carpaint::color::{ResponseCurve, read_emission};
use carpaint::dome::{DomeOptions, MadeOf, Stand};
use carpaint::file::{
    Container, read_mesh, read_panorama, read_picture, read_print_image, read_text, write_png,
};
use carpaint::math::projection::{Intrinsics, Projection};
use carpaint::measure::CaptureFolder;
use carpaint::measure::calibrate::{
    Calibration, CameraQuality, CameraResponse, GeometryCalibration, LeftOut, SensorNoise,
};
use carpaint::mix::Mix;
use carpaint::render::RenderPaint;
use carpaint::scene::Scene;
use carpaint::simulate::Composition;
use carpaint::{Paint, Result};
use exr::prelude::{
    Blocks, Compression, Encoding, Image, LineOrder, SpecificChannels, Vec2, WritableImage,
    read_all_flat_layers_from_file,
};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::OnceLock;

/// A reader and a file for it.
pub struct Reader {
    /// What it is called here; files of `fixtures/broken` begin with it.
    pub name: &'static str,
    /// Name of its file, which says the format.
    pub file: &'static str,
    /// Writes a small valid file of this path, and what it names beside it.
    pub make: fn(&Path),
    /// Reads the file as the program does.
    pub read: fn(&Path) -> Result<()>,
    /// Mutated inputs tried of it.
    pub inputs: usize,
}

const fn reader(
    name: &'static str,
    file: &'static str,
    make: fn(&Path),
    read: fn(&Path) -> Result<()>,
    inputs: usize,
) -> Reader {
    Reader { name, file, make, read, inputs }
}

/// All of them.
pub const READERS: &[Reader] = &[
    reader("paint", "a.paint.exr", |p| good(small::paint(1).write(p)), read_paint, 600),
    reader("paint-plain", "a.paint.exr", plain_paint, read_paint, 400),
    reader("paint-json", "a.json", paint_json, read_paint_json, 400),
    reader("mix", "a.mix.exr", |p| good(small::mix().write(p)), read_mix, 400),
    reader("mix-plain", "a.mix.exr", plain_mix, read_mix, 400),
    reader("mix-json", "a.json", mix_json, read_mix_json, 400),
    reader("btf", "a.btf.exr", |p| good(small::btf().write(p)), read_btf, 400),
    reader("btf-plain", "a.btf.exr", plain_btf, read_btf, 400),
    reader("exr", "a.exr", |p| exr_picture(p, Compression::ZIP16, Blocks::ScanLines), picture, 300),
    reader("exr-zip1", "a.exr", |p| exr_picture(p, Compression::ZIP1, Blocks::ScanLines), picture, 200),
    reader("exr-rle", "a.exr", |p| exr_picture(p, Compression::RLE, Blocks::ScanLines), picture, 200),
    reader("exr-piz", "a.exr", |p| exr_picture(p, Compression::PIZ, Blocks::ScanLines), picture, 300),
    reader("exr-pxr24", "a.exr", |p| exr_picture(p, Compression::PXR24, Blocks::ScanLines), picture, 200),
    reader("exr-b44", "a.exr", |p| exr_picture(p, Compression::B44, Blocks::ScanLines), picture, 200),
    reader("exr-tiles", "a.exr", |p| exr_picture(p, Compression::PIZ, TILES), picture, 200),
    reader("exr-raw", "a.exr", |p| exr_picture(p, Compression::Uncompressed, TILES), picture, 200),
    reader("png", "a.png", png, picture, 400),
    reader("print-png", "a.png", png, print, 200),
    reader("print-exr", "a.exr", |p| exr_picture(p, Compression::ZIP16, Blocks::ScanLines), print, 200),
    reader("jpeg", "a.jpg", jpeg, print, 600),
    reader("hdr", "a.hdr", hdr, |p| read_panorama(p).map(drop), 600),
    reader("hdr-flat", "a.hdr", hdr_flat, |p| read_panorama(p).map(drop), 200),
    reader("merl", "a.binary", merl_zeros, |p| read_samples(p).map(drop), 12),
    reader("half-angle", "a.bin", half_angle_zeros, |p| read_samples(p).map(drop), 12),
    reader("rgl", "a.bsdf", rgl, |p| read_samples(p).map(drop), 600),
    reader("mbsdf", "a.mbsdf", mbsdf, |p| read_measured(p).map(drop), 600),
    reader("nbrdf", "a.f32", nbrdf, |p| read_nbrdf(p).map(drop), 300),
    reader("multi-angle", "a.csv", |p| text(p, MULTI_ANGLE), |p| read_samples(p).map(drop), 600),
    reader("goniospectra", "a.csv", |p| text(p, GONIOSPECTRA), read_goniospectra, 600),
    reader("emission", "a.csv", |p| text(p, EMISSION), |p| read_emission(p).map(drop), 300),
    reader("ink", "a.ink.json", |p| text(p, INK), |p| Ink::read(p).map(drop), 400),
    reader("composition", "a.toml", |p| text(p, COMPOSITION), |p| Composition::read(p).map(drop), 800),
    reader("composition-tilts", "a.toml", |p| text(p, FLAT_INK), |p| Composition::read(p).map(drop), 400),
    reader("scene", "a.toml", |p| text(p, SCENE), |p| Scene::read(p).map(drop), 800),
    reader("scene-files", "a.toml", |p| text(p, MESH_SCENE), |p| Scene::read(p).map(drop), 300),
    reader("dome", "a.toml", |p| text(p, DOME), read_dome, 400),
    reader("axf", "axf.json", axf, read_axf, 120),
    reader("capture", "capture.json", capture, |p| CaptureFolder::open(folder(p)).map(drop), 400),
    reader("truth", "truth.json", truth, |p| MadeOf::read(folder(p)).map(drop), 300),
    reader("calibration", "calibration.json", calibration, read_calibration, 400),
    reader("response", "a.txt", |p| text(p, RESPONSE), read_response, 300),
    reader("hashes", "a.txt", hashes, |p| merl::known_merl(&p.with_file_name("m.binary"), p).map(drop), 200),
    reader("obj", "a.obj", |p| text(p, OBJ), |p| read_mesh(p).map(drop), 600),
    reader("glb", "a.glb", |p| gltf(p, true), |p| read_mesh(p).map(drop), 800),
    reader("gltf", "a.gltf", |p| gltf(p, false), |p| read_mesh(p).map(drop), 600),
];

/// The reader of this name.
pub fn named(name: &str) -> Option<&'static Reader> {
    READERS.iter().find(|reader| reader.name == name)
}

const TILES: Blocks = Blocks::Tiles(Vec2(8, 4));
const COMPOSITION: &str = include_str!("../../fixtures/compositions/three_layers.toml");
const FLAT_INK: &str = include_str!("../../fixtures/inks/blue_flat.toml");
const SCENE: &str = include_str!("../../fixtures/scenes/demo.toml");
const MESH_SCENE: &str = include_str!("../../fixtures/scenes/mesh.toml");
const DOME: &str = include_str!("../../fixtures/domes/laptop.toml");
const INK: &str = r#"{"kind": "carpaint ink", "version": 1, "name": "blue", "alpha": 0.19,
    "wavelengths_nm": [400, 450, 500, 550.5, 600, 700], "rho": [0.4, 0.9, 0.3, 1e-3, 0.2, 0.25], "c": [0.1, -0.5, 0, 1, 2.5, 0.3]}"#;
const MULTI_ANGLE: &str = "# silver\ngeometry, 400, 410nm, weight, name\n45as-15, 0.81, 0.82, 1, a\n45as15, 231 %, 2.33, 0.5, b\n\
    45:110, 1e-3, 0.05, 2, c # far\n";
const GONIOSPECTRA: &str =
    "theta_i,theta_o,400,500,600\n20,20,1,4,2\n30,-10,0.5,0.25,1\n20,20,3,4,3\n30,30,0.5,2,1\n";
const EMISSION: &str = "nm, power # a lamp\n380,0.5\n450 1.25\n550;2e1\n780\t3\n";
const RESPONSE: &str = "# linear light, red, green, blue\n0 0 0 0\n0.25 0.5 0.5 0.45\n1e0 1 0.9 1 # white\n";
const OBJ: &str = "# a roof\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0.5\nvn 0 0 1\nvn 0 -0.4 0.9\nvt 0 0\nvt 1 0.5\n\
    o one\nf 1/1/1 2/2/1 3/2/2 4/1/2\no two\ng x\nf -4//1 -3//2 -2//1\nl 1 2\n";

fn good<T>(made: Result<T>) -> T {
    made.expect("a valid file")
}

fn folder(path: &Path) -> &Path {
    path.parent().expect("a folder")
}

fn bytes(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("writes");
}

fn text(path: &Path, text: &str) {
    bytes(path, text.as_bytes());
}

/// The same parts without compression, so that a changed byte is a changed sample.
fn without_compression(path: &Path) {
    let mut image = read_all_flat_layers_from_file(path).expect("reads");
    image.layer_data.iter_mut().for_each(|layer| layer.encoding = Encoding::UNCOMPRESSED);
    image.write().to_file(path).expect("writes");
}

fn plain_paint(path: &Path) {
    good(small::paint(1).write(path));
    without_compression(path);
}

fn plain_mix(path: &Path) {
    good(small::mix().write(path));
    without_compression(path);
}

fn plain_btf(path: &Path) {
    good(small::btf().write(path));
    without_compression(path);
}

fn container(write: impl Fn(&Path) -> Result<()>) -> Container {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.exr");
    good(write(&path));
    good(Container::read(&path))
}

fn paint_container() -> &'static Container {
    static KEPT: OnceLock<Container> = OnceLock::new();
    KEPT.get_or_init(|| container(|path| small::paint(1).write(path)))
}

fn mix_container() -> &'static Container {
    static KEPT: OnceLock<Container> = OnceLock::new();
    KEPT.get_or_init(|| container(|path| small::mix().write(path)))
}

/// What a container says beside its arrays: longer or shorter text than an EXR file's byte changes can make.
fn paint_json(path: &Path) {
    text(path, &paint_container().meta.to_string());
}

fn mix_json(path: &Path) {
    text(path, &mix_container().meta.to_string());
}

/// The container with these words, written and read; what is no JSON is no container's fault.
fn reworded(path: &Path, whole: &Container, read: impl Fn(&Path) -> Result<()>) -> Result<()> {
    let Ok(meta) = serde_json::from_str(&read_text(path, 1 << 20)?) else { return Ok(()) };
    let file = path.with_extension("exr");
    Container { meta, parts: whole.parts.clone() }.write(&file)?;
    read(&file)
}

fn read_paint_json(path: &Path) -> Result<()> {
    reworded(path, paint_container(), read_paint)
}

fn read_mix_json(path: &Path) -> Result<()> {
    reworded(path, mix_container(), read_mix)
}

/// What is read can be used; whether it gives a picture is another matter.
fn read_paint(path: &Path) -> Result<()> {
    let paint = Paint::read(path)?;
    let _ = RenderPaint::new(&paint);
    Ok(())
}

fn read_mix(path: &Path) -> Result<()> {
    let mix = Mix::read(path)?;
    for weights in [[0.5, 0.5], [-1.5, 2.5]] {
        let _ = mix.blend(&weights).and_then(|paint| RenderPaint::new(&paint).map(drop));
    }
    Ok(())
}

/// Slice by slice, as a fit does.
fn read_btf(path: &Path) -> Result<()> {
    let reader = BtfReader::open(path)?;
    (0..reader.grid().len()).try_for_each(|k| reader.slice(k).map(drop))
}

fn picture(path: &Path) -> Result<()> {
    read_picture(path).map(drop)
}

fn print(path: &Path) -> Result<()> {
    read_print_image(path).map(drop)
}

/// Columns and rows of pictures: more than a tile, a block of lines and a run.
const SIZE: [usize; 2] = [19, 21];

/// Smooth with a flat half, so that there are runs.
fn shade(k: usize, channel: usize) -> f32 {
    let (x, y) = (k % SIZE[0], k / SIZE[0]);
    if y > 12 { 0.25 } else { (x * (channel + 1) + y * y) as f32 / 64.0 }
}

fn exr_picture(path: &Path, compression: Compression, blocks: Blocks) {
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let k = at.y() * SIZE[0] + at.x();
        (shade(k, 0), shade(k, 1), shade(k, 2))
    });
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let image = Image::from_encoded_channels((SIZE[0], SIZE[1]), encoding, channels);
    image.write().to_file(path).expect("writes");
}

fn codes() -> Vec<[u8; 3]> {
    (0..SIZE[0] * SIZE[1]).map(|k| [0, 1, 2].map(|c| (64.0 * shade(k, c)) as u8)).collect()
}

fn png(path: &Path) {
    good(write_png(path, SIZE, &codes()));
}

fn jpeg(path: &Path) {
    let mut out = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, 80)
        .write_image(codes().as_flattened(), SIZE[0] as u32, SIZE[1] as u32, ExtendedColorType::Rgb8)
        .expect("encodes");
    bytes(path, &out);
}

fn hdr(path: &Path) {
    let mut out = Vec::new();
    let pixels: Vec<_> = (0..SIZE[0] * SIZE[1]).map(|k| image::Rgb([0, 1, 2].map(|c| shade(k, c)))).collect();
    image::codecs::hdr::HdrEncoder::new(&mut out).encode(&pixels, SIZE[0], SIZE[1]).expect("encodes");
    bytes(path, &out);
}

/// Too narrow for the new run lengths; the second pixel repeats the first by the old ones.
fn hdr_flat(path: &Path) {
    let mut out = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2.0\n\n-Y 2 +X 3\n".to_vec();
    out.extend([128, 64, 0, 129, 1, 1, 1, 2, 255, 0, 1, 140, 9, 9, 9, 120, 8, 8, 8, 121]);
    bytes(path, &out);
}

/// The header, and zeros that take no place on the disk.
fn zeros(path: &Path, header: &[u8], length: u64) {
    bytes(path, header);
    let file = std::fs::OpenOptions::new().write(true).open(path).expect("opens");
    file.set_len(length).expect("grows");
}

fn merl_zeros(path: &Path) {
    let header: Vec<u8> = [90i32, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect();
    zeros(path, &header, 34_992_012);
}

fn half_angle_zeros(path: &Path) {
    zeros(path, &[7; 84], 17_496_084);
}

fn rgl(path: &Path) {
    bytes(path, &tensor::tensor_bytes(&tensor::spectral_fields()));
}

fn mbsdf(path: &Path) {
    let values = (0..12).map(|k| [0.1, 0.2, 0.01 * k as f32]).collect();
    good(good(TabulatedBrdf::new(2, 3, values)).write_mbsdf(path));
}

fn nbrdf(path: &Path) {
    let weight = |k: u32| (k.wrapping_mul(2_654_435_761) >> 16) as f32 / 65536.0 - 0.45;
    bytes(path, &(0..675).flat_map(|k| weight(k).to_le_bytes()).collect::<Vec<u8>>());
}

/// As its own white.
fn read_goniospectra(path: &Path) -> Result<()> {
    Goniospectra::read_over_white(path, path, 0.99).map(drop)
}

fn read_dome(path: &Path) -> Result<()> {
    DomeOptions::parse(&read_text(path, 1 << 20)?).map(drop).map_err(|e| e.in_file(path))
}

fn read_response(path: &Path) -> Result<()> {
    ResponseCurve::parse(&read_text(path, 1 << 20)?).map(drop).map_err(|e| e.in_file(path))
}

fn axf(path: &Path) {
    let btf = small::btf();
    let smooth = AxfSmooth {
        coat: ClearCoat::ideal(1.5, false),
        diffuse: 0.08,
        lobes: vec![Lobe { coefficient: 0.2, roughness: 0.4, f0: 0.1 }],
        colors: good(ColorTable::new([2, 2], vec![[0.5, 1.0, 2.5]; 4], vec![true; 4])),
    };
    good(write_axf_folder(&btf, &smooth, folder(path)));
}

fn read_axf(path: &Path) -> Result<()> {
    let read = AxfFolder::open(folder(path))?;
    (0..read.grid().len()).try_for_each(|k| read.slice(k).map(drop))
}

/// A dome of two cameras and four diodes.
fn dome() -> DomeOptions {
    let text = "rings = [{ cameras = 2, polar_deg = 20 }]\nimage_px = [32, 32]\nleds = [2, 2]\n";
    good(DomeOptions::parse(text))
}

fn capture(path: &Path) {
    text(path, &CaptureFolder::describe(&good(Stand::new(&dome())).rig));
}

fn truth(path: &Path) {
    let dome = dome();
    let truth = good(Stand::new(&dome)).truth;
    text(path, &json!({ "truth": truth, "dome": dome, "composition": Value::Null }).to_string());
}

fn calibration(path: &Path) {
    let Stand { rig, truth } = good(Stand::new(&dome()));
    let camera = |k: usize| Projection { intrinsics: truth.wide, pose: rig.cameras[k] };
    let quality = CameraQuality {
        diodes: [4, 4],
        rms_px: [0.1, 0.2],
        position_error_mm: 0.01,
        rotation_error_deg: 0.02,
        focal_error_px: 0.5,
    };
    let response = CameraResponse {
        light: vec![-0.01, 0.25, 1.0],
        says: vec![[0.0; 3], [0.5; 3], [1.0; 3]],
        saturation: [1.0, 1.1, 1.2],
        measured_to: 0.9,
        rms: [[0.01, 0.02]; 3],
        noise: SensorNoise { read: [1e-4; 3], shot: [1e-5; 3] },
        broken_pixels: vec![3, 9],
        unread: vec!["dark".into()],
    };
    let geometry = GeometryCalibration {
        wide: Intrinsics { distortion: [-0.1, 0.0], ..truth.wide },
        cameras: vec![Some(camera(0)), None],
        quality: vec![Some(quality), None],
        left_out: vec![LeftOut { camera: 1, reason: "blind".into() }],
    };
    text(path, &Calibration { geometry, responses: vec![Some(response), None] }.to_json());
}

/// With the dome that it is of.
fn read_calibration(path: &Path) -> Result<()> {
    let rig = good(Stand::new(&dome())).rig;
    let read = Calibration::from_json(&read_text(path, 1 << 24)?);
    read.and_then(|read| read.check_rig(&rig)).map_err(|e| e.in_file(path))
}

/// Of a file of three letters.
fn hashes(path: &Path) {
    text(&path.with_file_name("m.binary"), "abc");
    let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    text(path, &format!("{} 34992012 other\n{known} 3 abc\n", "0".repeat(64)));
}

/// Two triangles with normals and places in a picture, in a tree of nodes; the numbers in the file or beside it.
fn gltf(path: &Path, binary: bool) {
    let positions = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]];
    let mut data: Vec<u8> = positions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    data.extend([[0f32, 0.0, 1.0]; 4].iter().flatten().flat_map(|c| c.to_le_bytes()));
    data.extend([[0f32, 0.5]; 4].iter().flatten().flat_map(|c| c.to_le_bytes()));
    data.extend([0u16, 1, 2, 2, 1, 3].iter().flat_map(|k| k.to_le_bytes()));
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "children": [1], "rotation": [0, 0, 0, 1] }, { "mesh": 0, "translation": [0, 0, 5], "scale": [-1, 1, 1] }],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3, "mode": 4 },
        ] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0.5] },
            { "bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 96, "byteStride": 12 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 128, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": data.len() }],
    });
    if !binary {
        document["buffers"][0]["uri"] = "a.bin".into();
        bytes(&path.with_file_name("a.bin"), &data);
        return text(path, &document.to_string());
    }
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    data.resize(data.len().next_multiple_of(4), 0);
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut file = b"glTF".to_vec();
    file.extend([word(2), word(28 + json.len() + data.len()), word(json.len())].concat());
    file.extend([&b"JSON"[..], &json, &word(data.len()), b"BIN\0", &data].concat());
    bytes(path, &file);
}
