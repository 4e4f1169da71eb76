//! Mesh files: bytes of an STL or OBJ file to a [`Mesh`], exactly as it stands, never made convex.

use std::path::Path;

use super::{Mesh, MeshError};
use crate::math::Vec3;

/// Bytes of a binary STL before its first triangle, and of each triangle.
const STL_HEADER: usize = 84;
const STL_TRIANGLE: usize = 50;

/// Reads a mesh file. `name` is the file as messages call it; its extension says the format.
///
/// `scale` multiplies the coordinates [m per unit of the file]; an odd number of negative factors
/// mirrors the mesh.
///
/// # Errors
/// Another format than STL or OBJ, a file that is cut short or cannot be decoded, one without a
/// triangle that has an area, a scale that is zero or not finite.
pub fn read(name: &str, bytes: &[u8], scale: Vec3) -> Result<Mesh, MeshError> {
    let refuse = |reason: String| MeshError::Unreadable { name: name.to_owned(), reason };
    if !scale.is_finite() || scale.to_array().contains(&0.0) {
        return Err(refuse(format!("its scale is {scale}; every factor must be finite and not 0")));
    }
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let parts = match extension.as_str() {
        "stl" => stl(bytes).map_err(refuse)?,
        "obj" => {
            // Materials say nothing about the shape.
            let no_material = |_: &Path| -> std::io::Result<&[u8]> { Err(std::io::ErrorKind::NotFound.into()) };
            mesh_loader::obj::from_slice(bytes, None, no_material)
                .map_err(|e| refuse(format!("not an OBJ file: {e}")))?
        }
        "dae" => return Err(refuse("DAE comes later; convert it to STL or OBJ".to_owned())),
        other => return Err(refuse(format!("{other:?} is no mesh format; valid formats: stl, obj"))),
    };
    let (vertices, triangles) = join(&parts.meshes, scale);
    Mesh::new(name, vertices, triangles)
}

/// Decodes an STL. The size decides between binary and text: many binary headers start with `solid `.
fn stl(bytes: &[u8]) -> Result<mesh_loader::Scene, String> {
    let announced = bytes.get(80..STL_HEADER).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let size = announced.map(|count| STL_HEADER + STL_TRIANGLE * count);
    let is_text = bytes.trim_ascii_start().starts_with(b"solid") && size != Some(bytes.len());
    if is_text {
        return mesh_loader::stl::from_slice(bytes).map_err(|e| format!("not a text STL: {e}"));
    }
    match (announced, size) {
        // Up to a triangle's worth of stray bytes (a line end) is harmless; more would be triangles lost.
        (Some(count), Some(size)) if (size..size + STL_TRIANGLE).contains(&bytes.len()) => {
            let mut binary = bytes[..size].to_vec();
            binary[..80].fill(0); // else a header that starts with `solid ` is taken for text
            let scene = mesh_loader::stl::from_slice(&binary);
            scene.map_err(|e| format!("not a binary STL of {count} triangles: {e}"))
        }
        (Some(count), Some(size)) => {
            let what = if bytes.len() < size { "cut short" } else { "longer than it says" };
            Err(format!("{what}: {count} triangles need {size} bytes, the file has {}", bytes.len()))
        }
        _ => Err(format!("cut short: an STL has at least {STL_HEADER} bytes, the file has {}", bytes.len())),
    }
}

/// Joins the parts of a file. An odd number of negative factors turns the triangles over, so the winding is flipped.
fn join(parts: &[mesh_loader::Mesh], scale: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mirrored = scale.x * scale.y * scale.z < 0.0;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for part in parts {
        let first = vertices.len() as u32;
        vertices.extend(part.vertices.iter().map(|vertex| Vec3::from_array(vertex.map(f64::from)) * scale));
        triangles.extend(part.faces.iter().map(|face| {
            let [a, b, c] = face.map(|i| first + i);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }
    (vertices, triangles)
}
