//! Triangles as a file gives them.

/// Vertices, and triangles between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// Places of the vertices, finite.
    pub positions: Vec<[f32; 3]>,
    /// Normals of the vertices, of any length, not always finite; empty where some of them have none.
    pub normals: Vec<[f32; 3]>,
    /// Places of the vertices in a picture, (0, 0) its top left, (1, 1) its bottom right corner, not always finite; empty where some
    /// of them have none.
    pub uvs: Vec<[f32; 2]>,
    /// Three vertices each, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}
