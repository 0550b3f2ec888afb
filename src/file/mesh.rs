//! Triangle meshes: glTF (`.glb`, or `.gltf` with the files it names) and Wavefront OBJ.
//!
//! All triangles of the file in one mesh, materials and textures left aside. Everything that a file says about sizes and
//! places is checked before it is believed.

use super::text::open;
use super::triangles::Triangles;
use crate::error::{Error, Result};
use glam::{DVec3, Mat3, Mat4, Vec3};
use std::io::{BufReader, Read};
use std::path::Path;

/// Most triangles, and most vertices, of a mesh.
const MAX_TRIANGLES: usize = 1_000_000;
/// Largest file, bytes.
const MAX_BYTES: u64 = 256 << 20;
/// Largest coordinate.
const MAX_COORDINATE: f32 = 1e9;

/// Reads a mesh.
///
/// # Errors
/// Another extension than `glb`, `gltf` or `obj`, those of the file system, a damaged file, one that needs extensions of glTF,
/// no triangles with an area, more than a million triangles or vertices, a vertex that a triangle names and that is not there, a coordinate
/// that is not finite or beyond 1e9 (its vertex named).
pub fn read_mesh(path: &Path) -> Result<Triangles> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let mesh = match extension.as_deref() {
        Some("glb" | "gltf") => read_gltf(path),
        Some("obj") => read_obj(path),
        found => Err(Error::invalid("", "extension of a mesh", found.unwrap_or("none"), "glb, gltf or obj")),
    };
    mesh.and_then(Triangles::checked).map_err(|e| e.in_file(path))
}

impl Triangles {
    fn checked(mut self) -> Result<Self> {
        let count = self.positions.len();
        check_count("triangles", self.triangles.len())?;
        check_count("vertices", count)?;
        let is_good = |p: &[f32; 3]| p.iter().all(|c| c.abs() <= MAX_COORDINATE);
        if let Some(k) = self.positions.iter().position(|p| !is_good(p)) {
            let legal = "finite numbers, -1e9 to 1e9";
            return Err(Error::invalid(
                format!("vertex {k}"),
                "place",
                format!("{:?}", self.positions[k]),
                legal,
            ));
        }
        let is_there = |t: &[u32; 3]| t.iter().all(|k| (*k as usize) < count);
        if let Some(k) = self.triangles.iter().position(|t| !is_there(t)) {
            let found = format!("{:?}", self.triangles[k]);
            return Err(Error::invalid(
                format!("triangle {k}"),
                "vertices",
                found,
                format!("0 to {}", count.saturating_sub(1)),
            ));
        }
        if self.normals.len() != count {
            self.normals.clear();
        }
        if self.uvs.len() != count {
            self.uvs.clear();
        }
        // Lines and points of OBJ come as triangles with corners in one place.
        let place = |k: u32| DVec3::from(self.positions[k as usize].map(f64::from));
        let has_area =
            |[a, b, c]: &[u32; 3]| (place(*b) - place(*a)).cross(place(*c) - place(*a)) != DVec3::ZERO;
        self.triangles.retain(has_area);
        if self.triangles.is_empty() {
            return Err(Error::invalid("", "triangles with an area", "none", "1 to 1000000"));
        }
        Ok(self)
    }

    /// Appends vertices and triangles; their normals and places in pictures count if all have some.
    fn append(&mut self, part: Self) {
        let first = self.positions.len() as u32;
        let counts = [self.positions.len(), part.positions.len()];
        extend_if_all(&mut self.normals, part.normals, counts);
        extend_if_all(&mut self.uvs, part.uvs, counts);
        self.positions.extend(part.positions);
        // What wraps around is beyond the vertices, and refused.
        self.triangles.extend(part.triangles.iter().map(|t| t.map(|k| k.saturating_add(first))));
    }
}

/// Appends what belongs to vertices, or drops it where some of them have none.
fn extend_if_all<T>(all: &mut Vec<T>, part: Vec<T>, counts: [usize; 2]) {
    if [all.len(), part.len()] == counts {
        all.extend(part);
    } else {
        all.clear();
    }
}

/// # Errors
/// More than a mesh may have.
fn check_count(what: &str, count: usize) -> Result<()> {
    if count <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(Error::invalid("", what, count, format!("up to {MAX_TRIANGLES}")))
}

fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let (file, length) = open(path)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    if bytes.len() as u64 > MAX_BYTES {
        let found = length.max(bytes.len() as u64);
        return Err(Error::invalid("", "number of bytes", found, format!("up to {MAX_BYTES}")));
    }
    Ok(bytes)
}

fn read_obj(path: &Path) -> Result<Triangles> {
    let bytes = read_bytes(path)?;
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    // Materials say nothing about the shape.
    let material = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut BufReader::new(&bytes[..]), &options, material)
        .map_err(|e| Error::invalid("", "not a readable OBJ file", e, "a complete OBJ file"))?;
    let mut mesh = Triangles::default();
    let threes = |values: &[f32]| values.as_chunks().0.to_vec();
    for tobj::Model { mesh: part, .. } in models {
        mesh.append(Triangles {
            positions: threes(&part.positions),
            normals: threes(&part.normals),
            // OBJ counts from the bottom.
            uvs: part.texcoords.as_chunks().0.iter().map(|[u, v]| [*u, 1.0 - v]).collect(),
            triangles: part.indices.as_chunks().0.to_vec(),
        });
    }
    Ok(mesh)
}

fn read_gltf(path: &Path) -> Result<Triangles> {
    let bytes = read_bytes(path)?;
    check_length(&bytes)?;
    let wrong = |e| Error::invalid("", "not a readable glTF file", e, "a complete file of glTF 2.0");
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(&bytes).map_err(wrong)?;
    check_positions(document.as_json())?;
    let document = gltf::Document::from_json(document.into_json()).map_err(wrong)?;
    let version = &document.as_json().asset.version;
    if !version.starts_with("2.") {
        return Err(Error::unsupported("", "version of glTF", version, "2.0"));
    }
    let buffers = read_buffers(&document, blob, path.parent().unwrap_or(Path::new("")))?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Error::invalid("", "scenes", "none", "1 or more"))?;
    let mut mesh = Triangles::default();
    let mut todo: Vec<_> = scene.nodes().map(|node| (node, Mat4::IDENTITY)).collect();
    let mut seen = vec![false; document.nodes().len()];
    while let Some((node, above)) = todo.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            let place = format!("node {}", node.index());
            return Err(Error::invalid(place, "parents", "two, or itself", "one: nodes are trees"));
        }
        let transform = above * Mat4::from_cols_array_2d(&node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            let place = format!("mesh of node {}: primitive {}", node.index(), primitive.index());
            let part = Accessors { buffers: &buffers }.primitive(&primitive).map_err(|e| e.within(place))?;
            mesh.append(part.transformed(transform));
            check_count("triangles", mesh.triangles.len())?;
            check_count("vertices", mesh.positions.len())?;
        }
        todo.extend(node.children().map(|child| (child, transform)));
    }
    Ok(mesh)
}

/// The bytes of all buffers: the binary part of the file, or files in its folder, all of them no larger than one may be.
fn read_buffers(document: &gltf::Document, mut blob: Option<Vec<u8>>, folder: &Path) -> Result<Vec<Vec<u8>>> {
    let mut total = 0;
    let mut read = |buffer: gltf::Buffer| {
        let place = || format!("buffer {}", buffer.index());
        let bytes = match buffer.source() {
            // There is one of it, and one buffer has it.
            gltf::buffer::Source::Bin => blob
                .take()
                .ok_or_else(|| Error::invalid(place(), "binary part", "none", "that of a .glb file"))?,
            gltf::buffer::Source::Uri(name) if name.starts_with("data:") => {
                return Err(Error::unsupported(place(), "data", "in the text", "a .glb file"));
            }
            gltf::buffer::Source::Uri(name) => read_bytes(&folder.join(name))?,
        };
        total += bytes.len() as u64;
        if total > MAX_BYTES {
            return Err(Error::invalid(place(), "bytes so far", total, format!("up to {MAX_BYTES}")));
        }
        Ok(bytes)
    };
    document.buffers().map(&mut read).collect()
}

/// Refuses accessors of positions that are not there, which the decoder looks up before it checks them.
fn check_positions(root: &gltf::json::Root) -> Result<()> {
    use gltf::json::validation::Checked;
    let count = root.accessors.len();
    for (k, mesh) in root.meshes.iter().enumerate() {
        let accessors = mesh
            .primitives
            .iter()
            .filter_map(|p| p.attributes.get(&Checked::Valid(gltf::Semantic::Positions)));
        if let Some(accessor) = accessors.map(|index| index.value()).find(|index| *index >= count) {
            let legal = format!("one of {count}");
            return Err(Error::invalid(format!("mesh {k}"), "accessor of positions", accessor, legal));
        }
    }
    Ok(())
}

/// Refuses a .glb file that claims to be shorter than its own header, from which the decoder would subtract that.
fn check_length(bytes: &[u8]) -> Result<()> {
    const HEADER: u32 = 12;
    let claimed = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..)?.first_chunk());
    match claimed.map(|word| u32::from_le_bytes(*word)) {
        Some(length) if length < HEADER => {
            Err(Error::invalid("", "length in the header", length, format!("{HEADER} bytes or more")))
        }
        _ => Ok(()),
    }
}

impl Triangles {
    fn transformed(mut self, transform: Mat4) -> Self {
        let linear = Mat3::from_mat4(transform);
        // Normals are across the surface, whatever stretches it: the cofactors.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let across = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let flip = linear.determinant() < 0.0;
        self.positions.iter_mut().for_each(|p| *p = transform.transform_point3(Vec3::from(*p)).to_array());
        let sign = if flip { -1.0 } else { 1.0 };
        self.normals.iter_mut().for_each(|n| *n = (across * Vec3::from(*n) * sign).to_array());
        if flip {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }
}

/// Reads numbers out of the buffers of a glTF file, within their ends.
struct Accessors<'a> {
    buffers: &'a [Vec<u8>],
}

impl Accessors<'_> {
    /// The triangles of a primitive; lines and points have none.
    fn primitive(&self, primitive: &gltf::Primitive) -> Result<Triangles> {
        use gltf::mesh::Mode;
        match primitive.mode() {
            Mode::Triangles => (),
            Mode::TriangleStrip | Mode::TriangleFan => {
                let found = format!("{:?}", primitive.mode());
                return Err(Error::unsupported("", "mode", found, "separate triangles"));
            }
            _ => return Ok(Triangles::default()),
        }
        let vectors = |what: &str, semantic| match primitive.get(semantic) {
            Some(accessor) => self.vectors(&accessor).map(Some).map_err(|e| e.within(what)),
            None => Ok(None),
        };
        let positions = vectors("positions", &gltf::Semantic::Positions)?
            .ok_or_else(|| Error::invalid("", "positions", "none", "a place for each vertex"))?;
        let normals = vectors("normals", &gltf::Semantic::Normals)?.unwrap_or_default();
        let uvs = match primitive.get(&gltf::Semantic::TexCoords(0)) {
            Some(accessor) => self.uvs(&accessor).map_err(|e| e.within("texture coordinates"))?,
            None => Vec::new(),
        };
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor).map_err(|e| e.within("indices"))?,
            None => (0..positions.len() as u32).collect(),
        };
        Ok(Triangles { positions, normals, uvs, triangles: indices.as_chunks().0.to_vec() })
    }

    fn vectors(&self, accessor: &gltf::Accessor) -> Result<Vec<[f32; 3]>> {
        use gltf::accessor::{DataType, Dimensions};
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            let found = format!("{:?} {:?}", accessor.dimensions(), accessor.data_type());
            return Err(Error::unsupported("", "type", found, "Vec3 F32"));
        }
        Ok(self.items(accessor)?.map(|item| [0, 4, 8].map(|at| number(item, at))).collect())
    }

    /// Texture coordinates; those in bytes and shorts are left out, as if there were none.
    fn uvs(&self, accessor: &gltf::Accessor) -> Result<Vec<[f32; 2]>> {
        use gltf::accessor::{DataType, Dimensions};
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec2) {
            return Ok(Vec::new());
        }
        Ok(self.items(accessor)?.map(|item| [0, 4].map(|at| number(item, at))).collect())
    }

    fn indices(&self, accessor: &gltf::Accessor) -> Result<Vec<u32>> {
        use gltf::accessor::{DataType, Dimensions};
        let little = |item: &[u8]| item.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte));
        match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8 | DataType::U16 | DataType::U32, Dimensions::Scalar) => {
                Ok(self.items(accessor)?.map(little).collect())
            }
            found => Err(Error::invalid("", "type", format!("{found:?}"), "U8, U16 or U32")),
        }
    }

    /// The bytes of each item.
    fn items(&self, accessor: &gltf::Accessor) -> Result<impl Iterator<Item = &[u8]>> {
        if accessor.sparse().is_some() {
            return Err(Error::unsupported("", "accessor", "a sparse one", "a plain one"));
        }
        let Some(view) = accessor.view() else {
            return Err(Error::unsupported("", "accessor", "one without data", "a plain one"));
        };
        let (size, count) = (accessor.size(), accessor.count());
        check_count("items", count / 3)?;
        let stride = view.stride().unwrap_or(size);
        let buffer = self.buffers.get(view.buffer().index()).map_or(&[][..], Vec::as_slice);
        let part = view.offset().checked_add(view.length()).and_then(|end| buffer.get(view.offset()..end));
        let needed = stride.checked_mul(count.saturating_sub(1)).and_then(|n| n.checked_add(size));
        let end = needed.and_then(|n| n.checked_add(accessor.offset()));
        let found = end.zip(part).and_then(|(end, part)| part.get(accessor.offset()..end));
        match found {
            Some(bytes) if stride >= size => {
                Ok(bytes.chunks(stride).take(count).map(move |item| &item[..size]))
            }
            _ => {
                let legal = format!("{count} items of {size} bytes, {stride} apart");
                Err(Error::invalid("", "buffer", format!("{} bytes", buffer.len()), legal))
            }
        }
    }
}

/// The little-endian number at a byte.
fn number(item: &[u8], at: usize) -> f32 {
    f32::from_le_bytes([item[at], item[at + 1], item[at + 2], item[at + 3]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn refused(path: &Path) -> String {
        read_mesh(path).map_or_else(|e| e.to_string(), |mesh| format!("read: {mesh:?}"))
    }

    #[test]
    fn obj_files_are_read_and_bad_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let write = |text: &str| std::fs::write(&path, text).unwrap();
        write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n");
        let mesh = read_mesh(&path).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.normals[3]), (4, 2, [0.0, 0.0, 1.0]));
        for (text, word) in [
            ("", "triangles with an area: found none"),
            ("v 0 0 0\nv 1 0 0\nf 1 2\n", "triangles with an area: found none"),
            ("v 0 0 0\nv 1 0 0\nv nan 0 0\nf 1 2 3\n", "vertex 2"),
            ("v 0 0 0\nv 1 0 0\nv 1 1e30 0\nf 1 2 3\n", "vertex 2"),
            ("v 0 0 0\nf 1 2 3\n", "OBJ"),
            ("v 0 0 x\nf 1 1 1\n", "OBJ"),
            ("v 0 0 0\nf 1 1 -9\n", "OBJ"),
        ] {
            write(text);
            let message = refused(&path);
            assert!(message.contains(word) && message.contains("a.obj"), "{text:?}: {message}");
        }
        assert!(refused(&folder.path().join("a.stl")).contains("found stl, expected glb, gltf or obj"));
    }

    /// A .glb file of this JSON and these bytes.
    fn glb(json: &Value, bytes: &[u8]) -> Vec<u8> {
        let padded = |bytes: &[u8], with: u8| {
            let mut bytes = bytes.to_vec();
            bytes.resize(bytes.len().next_multiple_of(4), with);
            bytes
        };
        let (text, bytes) = (padded(json.to_string().as_bytes(), b' '), padded(bytes, 0));
        let mut file = b"glTF".to_vec();
        let word = |n: usize| (n as u32).to_le_bytes();
        file.extend([word(2), word(28 + text.len() + bytes.len()), word(text.len())].concat());
        file.extend([&b"JSON"[..], &text, &word(bytes.len()), b"BIN\0", &bytes].concat());
        file
    }

    /// One triangle, its node moved by (0, 0, 5) and mirrored in x.
    fn triangle() -> (Value, Vec<u8>) {
        let numbers = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut bytes: Vec<u8> = numbers.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        bytes.extend([0u16, 1, 2].iter().flat_map(|k| k.to_le_bytes()));
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0, "translation": [0.0, 0.0, 5.0], "scale": [-1.0, 1.0, 1.0] }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
                { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
            ],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
                { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
            ],
            "buffers": [{ "byteLength": 42 }],
        });
        (json, bytes)
    }

    #[test]
    fn gltf_files_are_read_with_their_nodes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let (json, bytes) = triangle();
        std::fs::write(&path, glb(&json, &bytes)).unwrap();
        let mesh = read_mesh(&path).unwrap();
        assert_eq!(mesh.positions, [[0.0, 0.0, 5.0], [-1.0, 0.0, 5.0], [0.0, 1.0, 5.0]]);
        // Mirrored: the other way around.
        assert_eq!(mesh.triangles, [[0, 2, 1]]);
        assert!(mesh.normals.is_empty());
        // The buffer in a file of its own.
        let mut apart = json.clone();
        apart["buffers"][0]["uri"] = "a.bin".into();
        let text = folder.path().join("b.gltf");
        std::fs::write(&text, apart.to_string()).unwrap();
        assert!(refused(&text).contains("a.bin"));
        std::fs::write(folder.path().join("a.bin"), &bytes).unwrap();
        assert_eq!(read_mesh(&text).unwrap(), mesh);
    }

    #[test]
    fn hostile_gltf_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let (json, bytes) = triangle();
        let mut cases: Vec<(&str, Value, Value, &str)> = vec![
            ("/accessors/0/count", json!(4), json!(3), "buffer"),
            ("/accessors/0/count", json!(4_000_000_000_000_000_000u64), json!(3), "items"),
            ("/accessors/0/byteOffset", json!(4), json!(0), "buffer"),
            ("/bufferViews/0/byteLength", json!(100), json!(36), "buffer"),
            ("/bufferViews/0/byteOffset", json!(u32::MAX), json!(0), "buffer"),
            ("/bufferViews/1/byteStride", json!(1), json!(2), "buffer"),
            ("/accessors/1/componentType", json!(5126), json!(5123), "type"),
            ("/meshes/0/primitives/0/mode", json!(5), json!(4), "mode"),
            ("/meshes/0/primitives/0/mode", json!(1), json!(4), "triangles with an area: found none"),
            ("/meshes/0/primitives/0/attributes", json!({}), json!({ "POSITION": 0 }), "POSITION"),
            ("/nodes/0/children", json!([0]), json!([]), "node 0: parents"),
            ("/nodes/0/translation", json!([1e38, 0, 0]), json!([0, 0, 0]), "vertex 0"),
            ("/scenes", json!([]), json!([{ "nodes": [0] }]), ""),
            ("/asset/version", json!("3.0"), json!("2.0"), "version"),
        ];
        for (pointer, bad, _, word) in &mut cases {
            let mut json = json.clone();
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            json.pointer_mut(parent).unwrap()[key] = bad.take();
            std::fs::write(&path, glb(&json, &bytes)).unwrap();
            let message = refused(&path);
            assert!(message.contains(*word) && message.contains("a.glb"), "{pointer}: {message}");
        }
        // A vertex that is not there.
        let mut other = bytes.clone();
        other[40] = 3;
        std::fs::write(&path, glb(&json, &other)).unwrap();
        assert!(refused(&path).contains("triangle 0: vertices"));
        let whole = glb(&json, &bytes);
        for length in 0..whole.len() - 2 {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read_mesh(&path).is_err(), "{length} of {} bytes were accepted", whole.len());
        }
    }
}
