//! Mesh files: bytes of an STL, OBJ or DAE file to a [`Mesh`], exactly as it stands, never made convex. Coordinates
//! are f64 from the text on.

use std::path::Path;

use super::{Mesh, MeshError, collada, obj, stl};
use crate::math::Vec3;

/// Reads a mesh file. `name` is the file as messages call it; its extension says the format.
///
/// `scale` multiplies the coordinates [m per unit of the file]; an odd number of negative factors
/// mirrors the mesh.
///
/// A polygon of more than three corners is cut into triangles: a convex one from its first corner, any other by ears,
/// whichever corner comes first.
///
/// # Errors
/// Another format than STL, OBJ or DAE, a file that is cut short or cannot be decoded, one that holds surfaces that are
/// no polygons, one without a triangle that has an area, a scale that is zero or not finite.
pub fn read(name: &str, bytes: &[u8], scale: Vec3) -> Result<Mesh, MeshError> {
    let refuse = |reason: String| MeshError::Unreadable { name: name.to_owned(), reason };
    if !scale.is_finite() || scale.to_array().contains(&0.0) {
        return Err(refuse(format!("its scale is {scale}; every factor must be finite and not 0")));
    }
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let surface = match extension.as_str() {
        "stl" => stl::read(bytes),
        "obj" => obj::read(bytes),
        "dae" => collada::read(bytes),
        other => Err(format!("{other:?} is no mesh format; valid formats: stl, obj, dae")),
    };
    let mut surface = surface.map_err(refuse)?;
    surface.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
    // An odd number of negative factors turns the triangles over.
    if scale.to_array().into_iter().filter(|factor| *factor < 0.0).count() % 2 == 1 {
        surface.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    let words = surface.words();
    Ok(Mesh::new(name, surface.vertices, surface.triangles)?.with_warnings(words))
}

/// A coordinate of a text file.
pub(super) fn number(word: &str) -> Result<f64, String> {
    let advice = if word.contains(',') { "; the decimal sign must be a point" } else { "" };
    word.parse().map_err(|_| format!("{word:?} is no number{advice}"))
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
            mesh.warnings().join("; ")
        };
        assert!(warning(&FACES, Vec3::splat(100.0)).contains("100.0 × 100.0 × 100.0 m"));
        assert!(warning(&FACES[..3], Vec3::ONE).contains("3 of 6 edges"));
        assert!(warning(&FACES.map(|[a, b, c]| [a, c, b]), Vec3::ONE).contains("faces inwards"));
    }
}
