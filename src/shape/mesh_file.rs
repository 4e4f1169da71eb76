//! Mesh files: bytes of an STL, OBJ or DAE file to a [`Mesh`], exactly as it stands, never made convex.

use std::path::Path;

use super::{Mesh, MeshError, collada};
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
/// Another format than STL, OBJ or DAE, a file that is cut short or cannot be decoded, one without a
/// triangle that has an area, a scale that is zero or not finite.
pub fn read(name: &str, bytes: &[u8], scale: Vec3) -> Result<Mesh, MeshError> {
    let refuse = |reason: String| MeshError::Unreadable { name: name.to_owned(), reason };
    if !scale.is_finite() || scale.to_array().contains(&0.0) {
        return Err(refuse(format!("its scale is {scale}; every factor must be finite and not 0")));
    }
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (mut vertices, mut triangles) = match extension.as_str() {
        "stl" => stl(bytes).map_err(refuse)?,
        "obj" => {
            // Materials say nothing about the shape.
            let no_material = |_: &Path| -> std::io::Result<&[u8]> { Err(std::io::ErrorKind::NotFound.into()) };
            let scene = mesh_loader::obj::from_slice(bytes, None, no_material);
            join(&scene.map_err(|e| refuse(format!("not an OBJ file: {e}")))?.meshes)
        }
        "dae" => {
            let surface = collada::read(bytes).map_err(refuse)?;
            (surface.vertices, surface.triangles)
        }
        other => return Err(refuse(format!("{other:?} is no mesh format; valid formats: stl, obj, dae"))),
    };
    vertices.iter_mut().for_each(|vertex| *vertex *= scale);
    // An odd number of negative factors turns the triangles over.
    if scale.x * scale.y * scale.z < 0.0 {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    Mesh::new(name, vertices, triangles)
}

/// Vertices in the file's unit, and triangles of them.
type Surface = (Vec<Vec3>, Vec<[u32; 3]>);

/// Decodes an STL. The size decides between binary and text: many binary headers start with `solid `.
fn stl(bytes: &[u8]) -> Result<Surface, String> {
    let announced = bytes.get(80..STL_HEADER).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let size = announced.map(|count| STL_HEADER + STL_TRIANGLE * count);
    let is_text = bytes.trim_ascii_start().starts_with(b"solid") && size != Some(bytes.len()) && !bytes.contains(&0);
    if is_text {
        let scene = mesh_loader::stl::from_slice(bytes).map_err(|e| format!("not a text STL: {e}"))?;
        return Ok(join(&scene.meshes));
    }
    match (announced, size) {
        // Up to a triangle's worth of stray bytes (a line end) is harmless; more would be triangles lost.
        (Some(_), Some(size)) if (size..size + STL_TRIANGLE).contains(&bytes.len()) => {
            Ok(binary_stl(&bytes[STL_HEADER..size]))
        }
        (Some(count), Some(size)) => {
            let what = if bytes.len() < size { "cut short" } else { "longer than it says" };
            Err(format!("{what}: {count} triangles need {size} bytes, the file has {}", bytes.len()))
        }
        _ => Err(format!("cut short: an STL has at least {STL_HEADER} bytes, the file has {}", bytes.len())),
    }
}

/// Triangles of a binary STL: each a normal, which says nothing new, three corners, and two bytes of anything.
fn binary_stl(triangles: &[u8]) -> Surface {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corner = |b: &[u8]| Vec3::new(number(b), number(&b[4..]), number(&b[8..]));
    let each = triangles.chunks_exact(STL_TRIANGLE);
    let faces = (0..each.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (each.flat_map(|triangle| triangle[12..48].chunks_exact(12)).map(corner).collect(), faces)
}

/// Joins the parts of a file.
fn join(parts: &[mesh_loader::Mesh]) -> Surface {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for part in parts {
        let first = vertices.len() as u32;
        vertices.extend(part.vertices.iter().map(|vertex| Vec3::from_array(vertex.map(f64::from))));
        triangles.extend(part.faces.iter().map(|face| face.map(|i| first + i)));
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a tetrahedron's four triangles, seen from outside counter-clockwise.
    const FACES: [[[f32; 3]; 3]; 4] = {
        let (o, x, y, z) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        [[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
    };
    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng a\nf 1 3 2\nf 1 2 4\ng b\nf 1 4 3\nf 2 3 4\n";

    fn written_stl(header: &str, faces: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(80, b' ');
        bytes.extend((faces.len() as u32).to_le_bytes());
        for face in faces {
            bytes.extend([0; 12]);
            bytes.extend(face.iter().flatten().flat_map(|c| c.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn text_stl(faces: &[[[f32; 3]; 3]]) -> String {
        let vertex = |[x, y, z]: &[f32; 3]| format!("vertex {x} {y} {z}\n");
        let facet = |face: &[[f32; 3]; 3]| {
            format!(
                "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
                face.iter().map(vertex).collect::<String>()
            )
        };
        format!("solid t\n{}endsolid t\n", faces.iter().map(facet).collect::<String>())
    }

    fn refusal(name: &str, bytes: &[u8]) -> String {
        read(name, bytes, Vec3::ONE).expect_err("must be refused").to_string()
    }

    #[test]
    fn every_format_gives_the_same_welded_and_closed_solid() {
        for (name, bytes) in [
            ("a.stl", written_stl("made by hand", &FACES)),
            ("a.STL", written_stl("solid made by a trap", &FACES)),
            ("a.stl", text_stl(&FACES).into_bytes()),
            ("a.obj", OBJ.as_bytes().to_vec()),
        ] {
            let mesh = read(name, &bytes, Vec3::ONE).unwrap();
            assert_eq!((mesh.vertices().len(), mesh.triangles().len()), (4, 4), "{name}");
            assert!(mesh.warnings().is_empty(), "{:?}", mesh.warnings());
        }
    }

    #[test]
    fn a_file_that_is_cut_short_is_refused_with_its_sizes() {
        let whole = written_stl("solid", &FACES);
        assert_eq!(whole.len(), 284);
        let text = refusal("cup.stl", &whole[..270]);
        assert!(text.contains("cup.stl") && text.contains("4 triangles need 284 bytes, the file has 270"), "{text}");
        let text = refusal("cup.stl", &written_stl("", &FACES)[..60]);
        assert!(text.contains("at least 84 bytes, the file has 60"), "{text}");
        let written = text_stl(&FACES);
        let text = refusal("cup.stl", &written.as_bytes()[..written.len() / 2]);
        assert!(text.contains("cup.stl") && text.contains("text STL"), "{text}");
        let mut longer = whole.clone();
        longer.extend([0; 50]);
        assert!(refusal("cup.stl", &longer).contains("longer than it says"));
    }

    #[test]
    fn a_file_without_an_area_is_refused() {
        let flat = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]];
        for bytes in [written_stl("", &[]), written_stl("", &flat), text_stl(&[]).into_bytes()] {
            let text = refusal("cup.stl", &bytes);
            assert!(text.contains("cup.stl") && text.contains("no triangle with an area"), "{text}");
        }
        assert!(refusal("cup.obj", b"v 0 0 0\n").contains("no triangle"));
    }

    #[test]
    fn what_is_no_mesh_is_refused_with_what_would_be() {
        assert!(refusal("cup.dae", b"<COLLADA/>").contains("cup.dae: it shows no polygon"));
        assert!(refusal("cup.ply", b"ply").contains("valid formats: stl, obj, dae"));
        assert!(refusal("cup.obj", b"v 0 0 0\nf 1 2 3\n").contains("cup.obj"));
        let nan = [[[f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
        assert!(refusal("cup.stl", &written_stl("", &nan)).contains("not finite"));
        let bytes = written_stl("", &FACES);
        for scale in [Vec3::ZERO, Vec3::new(1.0, f64::NAN, 1.0)] {
            assert!(read("cup.stl", &bytes, scale).unwrap_err().to_string().contains("scale"));
        }
    }

    #[test]
    fn a_mirroring_scale_keeps_the_surface_outside_out() {
        let bytes = written_stl("", &FACES);
        let mesh = read("a.stl", &bytes, Vec3::new(-2.0, 1.0, 1.0)).unwrap();
        assert!(mesh.warnings().is_empty(), "{:?}", mesh.warnings());
        assert!(mesh.vertices().contains(&Vec3::new(-2.0, 0.0, 0.0)));
    }

    #[test]
    fn odd_meshes_are_kept_with_a_warning_that_names_them() {
        let warning = |faces: &[[[f32; 3]; 3]], scale| {
            let mesh = read("cup.stl", &written_stl("", faces), scale).unwrap();
            assert!(mesh.warnings().iter().all(|text| text.contains("cup.stl")));
            mesh.warnings().iter().map(|text| text.to_string()).collect::<Vec<_>>().join("; ")
        };
        assert!(warning(&FACES, Vec3::splat(100.0)).contains("100.0 × 100.0 × 100.0 m"));
        assert!(warning(&FACES[..3], Vec3::ONE).contains("3 of 6 edges"));
        assert!(warning(&FACES.map(|[a, b, c]| [a, c, b]), Vec3::ONE).contains("faces inwards"));
    }
}
