//! A second reader of OBJ files, as simple as possible, and the comparison of a mesh with what it reads. It expects
//! files that the loader accepts.

use glam::{DVec3, Vec3};
use raylanes::geom::Triangle;

/// A line that begins with `f`.
pub(crate) struct Face {
    pub(crate) corners: Vec<Vec3>,
    /// The name after the last `usemtl`.
    pub(crate) material: String,
}

/// The faces of a file, in order.
pub(crate) fn faces(text: &[u8]) -> Vec<Face> {
    let (mut vertices, mut faces, mut material) = (vec![], vec![], String::new());
    for line in lines(text) {
        let line = line.trim_ascii();
        let uncommented = line.split(|&byte| byte == b'#').next().unwrap();
        let text = String::from_utf8_lossy(uncommented);
        let words = text.split_ascii_whitespace().collect::<Vec<_>>();
        match words[..] {
            ["v", x, y, z, ref more @ ..] => {
                let [x, y, z] = [x, y, z].map(|word| word.parse::<f32>().unwrap());
                let weight = if let [weight] = more { weight.parse().unwrap() } else { 1.0 };
                vertices.push(Vec3::new(x / weight, y / weight, z / weight));
            }
            ["f", ref corners @ ..] => {
                let so_far = vertices.len() as isize;
                let index = |word: &&str| match word.split('/').next().unwrap().parse().unwrap() {
                    index @ ..0 => so_far + index,
                    index => index - 1,
                };
                faces.push((corners.iter().map(index).collect::<Vec<_>>(), material.clone()));
            }
            ["usemtl", ..] => material = decode(&line[6..]).trim().to_owned(),
            _ => {}
        }
    }
    let corners = |indices: Vec<isize>| indices.into_iter().map(|index| vertices[index as usize]).collect();
    faces.into_iter().map(|(indices, material)| Face { corners: corners(indices), material }).collect()
}

fn decode(name: &[u8]) -> String {
    String::from_utf8(name.to_vec()).unwrap_or_else(|_| name.iter().copied().map(char::from).collect())
}

/// The lines of a file, with those that a backslash joins in one.
fn lines(text: &[u8]) -> Vec<Vec<u8>> {
    const MARK: &[u8] = b"\xef\xbb\xbf";
    let is_half_break = |&at: &usize| text[at..].starts_with(b"\r\n");
    let text: Vec<_> = (0..text.len()).filter(|at| !is_half_break(at)).map(|at| text[at]).collect();
    let mut lines = vec![vec![]];
    for part in text.split(|byte| b"\n\r\x0b\x0c".contains(byte)) {
        let line = lines.last_mut().unwrap();
        let part = if line.is_empty() { part.strip_prefix(MARK).unwrap_or(part) } else { part }.trim_ascii_end();
        match part {
            [before @ .., b'\\'] if !part.contains(&b'#') && before.last().is_none_or(u8::is_ascii) => {
                line.extend([before, b" "].concat());
            }
            _ => {
                line.extend(part);
                lines.push(vec![]);
            }
        }
    }
    lines
}

/// How many triangles each face has, if they are the surface of the faces: they have its corners, in its orientation,
/// and its area. `overlap` allows triangles that turn the other way.
pub(crate) fn triangles_per_face(triangles: &[Triangle], faces: &[Face], overlap: bool) -> Option<Vec<usize>> {
    let Some((face, later)) = faces.split_first() else { return triangles.is_empty().then(Vec::new) };
    let corners = &face.corners;
    let fan: Vec<_> =
        corners[1..].windows(2).map(|pair| Triangle { v0: corners[0], v1: pair[0], v2: pair[1] }).collect();
    let whole: DVec3 = fan.iter().map(double_area).sum();
    let size = corners.iter().map(|corner| (corner - corners[0]).as_dvec3().length()).fold(0.0, f64::max);
    let turns_back = |triangle: &Triangle| double_area(triangle).dot(whole) < -1e-9 * size.powi(4);
    let has_corners = |triangle: &Triangle| triangle.vertices().iter().all(|vertex| corners.contains(vertex));
    let is_surface = |part: &[Triangle]| {
        let area: DVec3 = part.iter().map(double_area).sum();
        let is_split =
            corners.len() > 3 && part.iter().all(has_corners) && (area - whole).length() <= 0.01 * whole.length();
        (part == fan || is_split) && (overlap || !part.iter().any(turns_back))
    };
    (1..=fan.len().min(triangles.len())).rev().find_map(|count| {
        let (part, rest) = triangles.split_at(count);
        let mut counts = is_surface(part).then(|| triangles_per_face(rest, later, overlap))??;
        counts.insert(0, count);
        Some(counts)
    })
}

/// The normal of a triangle. Its length is twice the area.
fn double_area(triangle: &Triangle) -> DVec3 {
    let [a, b, c] = triangle.vertices().map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}
