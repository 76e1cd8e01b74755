//! What a loader of mesh files says beside the mesh.

/// What the loader left out of a mesh, and other remarks about the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct MeshReport {
    /// Number of vertices in the file. The mesh of an OBJ file holds only vertices that faces use. That of an STL file
    /// holds equal ones once.
    pub vertices: usize,
    /// Number of triangles of exactly zero area. The mesh keeps them, so that primitive numbers follow the file.
    pub degenerate: usize,
    /// Number of points, lines, curves and free-form surfaces of an OBJ file.
    pub ignored_elements: usize,
    /// One line for each kind, such as missing materials, unknown keywords, properties that are not read, polygons that
    /// cross themselves or are not flat. It names the first and counts the others.
    pub warnings: Vec<String>,
}
