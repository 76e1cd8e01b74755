//! Writes meshes as OBJ files, and their colours as one MTL file.

use std::collections::HashMap;
use std::io::{self, Write};

use glam::Vec3;

use crate::tracer::meshes::mesh::{DEFAULT_COLOR, Mesh, Part};
use crate::tracer::meshes::number::Shortest;

/// The colours of meshes, as the materials of one library. Colours with the same bits are one material. Its name is
/// its number.
#[derive(Debug, Default)]
pub(crate) struct Materials {
    colors: Vec<Vec3>,
    numbers: HashMap<[u32; 3], usize>,
}

impl Materials {
    /// The colours of meshes that need materials.
    pub(crate) fn of<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> Self {
        let mut materials = Self::default();
        for part in meshes.into_iter().filter(|mesh| has_materials(mesh)).flat_map(Mesh::parts) {
            materials.numbers.entry(bits(part.color)).or_insert_with(|| {
                materials.colors.push(part.color);
                materials.colors.len()
            });
        }
        materials
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.colors.is_empty()
    }

    /// Writes the library, an MTL file.
    ///
    /// # Errors
    /// If `out` fails.
    pub(crate) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for (number, color) in (1..).zip(&self.colors) {
            writeln!(out, "newmtl {number}")?;
            write_numbers(out, "Kd", &color.to_array())?;
        }
        Ok(())
    }
}

/// Whether a mesh has other colours than those of a file without materials.
fn has_materials(mesh: &Mesh) -> bool {
    mesh.parts().len() > 1 || bits(mesh.color(0)) != bits(DEFAULT_COLOR)
}

fn bits(color: Vec3) -> [u32; 3] {
    color.to_array().map(f32::to_bits)
}

/// Writes a mesh as an OBJ file, triangle by triangle, so that it takes no memory. `materials` holds its colours,
/// `library` is the name of their file beside this one.
///
/// # Errors
/// If `out` fails.
pub(crate) fn write_obj(mesh: &Mesh, materials: &Materials, library: &str, out: &mut dyn Write) -> io::Result<()> {
    let has_materials = has_materials(mesh);
    if has_materials {
        writeln!(out, "mtllib {library}")?;
    }
    for position in mesh.positions() {
        write_numbers(out, "v", &position.to_array())?;
    }
    let (textures, normals) = (mesh.texture_values(), mesh.normal_values());
    for value in textures.iter().flat_map(|textures| textures.values()) {
        write_numbers(out, "vt", &value.to_array())?;
    }
    for value in normals.iter().flat_map(|normals| normals.values()) {
        write_numbers(out, "vn", &value.to_array())?;
    }
    for (number, &Part { first_triangle, color }) in (1..).zip(mesh.parts()) {
        if has_materials {
            writeln!(out, "usemtl {}", materials.numbers[&bits(color)])?;
        }
        let end = mesh.parts().get(number).map_or(mesh.len(), |next| next.first_triangle as usize);
        for triangle in first_triangle as usize..end {
            let texture = textures.and_then(|textures| textures.indices(triangle));
            let normal = normals.and_then(|normals| normals.indices(triangle));
            out.write_all(b"f")?;
            for (corner, &vertex) in mesh.triangles()[triangle].iter().enumerate() {
                // A file counts from 1.
                let [texture, normal] = [texture, normal].map(|indices| indices.map(|indices| indices[corner] + 1));
                write!(out, " {}", u64::from(vertex) + 1)?;
                match (texture, normal) {
                    (None, None) => Ok(()),
                    (Some(texture), None) => write!(out, "/{texture}"),
                    (None, Some(normal)) => write!(out, "//{normal}"),
                    (Some(texture), Some(normal)) => write!(out, "/{texture}/{normal}"),
                }?;
            }
            out.write_all(b"\n")?;
        }
    }
    Ok(())
}

fn write_numbers(out: &mut dyn Write, keyword: &str, numbers: &[f32]) -> io::Result<()> {
    out.write_all(keyword.as_bytes())?;
    numbers.iter().try_for_each(|&number| write!(out, " {}", Shortest(number)))?;
    out.write_all(b"\n")
}
