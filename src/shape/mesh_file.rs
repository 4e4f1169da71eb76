//! Mesh files: bytes of an STL, OBJ or DAE file to a [`Mesh`], exactly as it stands, never made
//! convex. Coordinates are f64 from the text on.

use std::ffi::OsStr;
use std::path::Path;

use super::surface::Surface;
use super::{Mesh, MeshError, collada, obj, stl};
use crate::math::Vec3;

/// Reads a mesh file. `name` is the file as messages call it; its extension says the format.
///
/// `scale` multiplies the coordinates [m per unit of the file]; an odd number of negative factors
/// mirrors the mesh.
///
/// A polygon of more than three corners is cut into triangles: a convex one from its first corner,
/// any other by ears, whichever corner comes first. Which of them it is, its corners say as the
/// file has them, before any node or `scale`: a quad that is not flat may be convex in one and not
/// in the other, and the file has to mean one shape.
///
/// # Errors
/// Another format than STL, OBJ or DAE, a file that is cut short or cannot be decoded, one that
/// holds surfaces that are no polygons, one without a triangle that has an area, a scale that is
/// zero or not finite.
pub fn read(name: &str, bytes: &[u8], scale: Vec3) -> Result<Mesh, MeshError> {
    let refuse = |reason| MeshError::unreadable(name, reason);
    check_scale(scale).map_err(refuse)?;
    let mut surface = decode(name, bytes).map_err(refuse)?;
    surface.scale(scale);
    let words = surface.words();
    Ok(Mesh::new(name, surface.vertices, surface.triangles)?.with_warnings(words))
}

fn check_scale(scale: Vec3) -> Result<(), String> {
    if scale.is_finite() && !scale.to_array().contains(&0.0) {
        return Ok(());
    }
    Err(format!(
        "its scale is {scale}; every factor must be finite and not 0"
    ))
}

/// A name's extension in lower case; none is empty.
fn extension(name: &str) -> String {
    let extension = Path::new(name).extension();
    let text = extension.and_then(OsStr::to_str);
    text.unwrap_or_default().to_ascii_lowercase()
}

/// The surface of a file in the format that its name says.
fn decode(name: &str, bytes: &[u8]) -> Result<Surface, String> {
    match extension(name).as_str() {
        "stl" => stl::read(bytes),
        "obj" => obj::read(bytes),
        "dae" => collada::read(bytes),
        other => Err(format!(
            "{other:?} is no mesh format; valid formats: stl, obj, dae"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a tetrahedron's four triangles, seen from outside counter-clockwise.
    const FACES: [[[f32; 3]; 3]; 4] = {
        let o = [0.0, 0.0, 0.0];
        let x = [1.0, 0.0, 0.0];
        let y = [0.0, 1.0, 0.0];
        let z = [0.0, 0.0, 1.0];
        [[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
    };
    const OBJ: &str =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng a\nf 1 3 2\nf 1 2 4\ng b\nf 1 4 3\nf 2 3 4\n";

    fn written_stl(header: &str, faces: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(80, b' ');
        bytes.extend((faces.len() as u32).to_le_bytes());
        for face in faces {
            bytes.extend([0; 12]);
            bytes.extend(
                face.iter()
                    .flatten()
                    .flat_map(|c| c.to_le_bytes()),
            );
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
        format!(
            "solid t\n{}endsolid t\n",
            faces.iter().map(facet).collect::<String>()
        )
    }

    fn refusal(name: &str, bytes: &[u8]) -> String {
        read(name, bytes, Vec3::ONE)
            .expect_err("must be refused")
            .to_string()
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
            assert_eq!(
                (mesh.vertices().len(), mesh.triangles().len()),
                (4, 4),
                "{name}"
            );
            assert!(mesh.warnings().is_empty(), "{:?}", mesh.warnings());
        }
    }

    #[test]
    fn a_file_that_is_cut_short_is_refused_with_its_sizes() {
        let whole = written_stl("solid", &FACES);
        assert_eq!(whole.len(), 284);
        let text = refusal("cup.stl", &whole[..270]);
        assert!(
            text.contains("cup.stl")
                && text.contains("4 triangles need 284 bytes, the file has 270"),
            "{text}"
        );
        let text = refusal("cup.stl", &written_stl("", &FACES)[..60]);
        assert!(
            text.contains("at least 84 bytes, the file has 60"),
            "{text}"
        );
        let written = text_stl(&FACES);
        let text = refusal("cup.stl", &written.as_bytes()[..written.len() / 2]);
        assert!(
            text.contains("cup.stl") && text.contains("text STL"),
            "{text}"
        );
        let mut longer = whole.clone();
        longer.extend([0; 50]);
        assert!(refusal("cup.stl", &longer).contains("longer than it says"));
    }

    #[test]
    fn a_file_without_an_area_is_refused() {
        let flat = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]];
        for bytes in [
            written_stl("", &[]),
            written_stl("", &flat),
            text_stl(&[]).into_bytes(),
        ] {
            let text = refusal("cup.stl", &bytes);
            assert!(
                text.contains("cup.stl") && text.contains("no triangle with an area"),
                "{text}"
            );
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
            assert!(
                read("cup.stl", &bytes, scale)
                    .unwrap_err()
                    .to_string()
                    .contains("scale")
            );
        }
    }

    #[test]
    fn a_mirroring_scale_keeps_the_surface_outside_out() {
        let bytes = written_stl("", &FACES);
        let mesh = read("a.stl", &bytes, Vec3::new(-2.0, 1.0, 1.0)).unwrap();
        assert!(mesh.warnings().is_empty(), "{:?}", mesh.warnings());
        assert!(
            mesh.vertices()
                .contains(&Vec3::new(-2.0, 0.0, 0.0))
        );
    }

    #[test]
    fn odd_meshes_are_kept_with_a_warning_that_names_them() {
        let warning = |faces: &[[[f32; 3]; 3]], scale| {
            let mesh = read("cup.stl", &written_stl("", faces), scale).unwrap();
            assert!(
                mesh.warnings()
                    .iter()
                    .all(|text| text.contains("cup.stl"))
            );
            mesh.warnings()
                .iter()
                .map(|text| text.to_string())
                .collect::<Vec<_>>()
                .join("; ")
        };
        assert!(warning(&FACES, Vec3::splat(100.0)).contains("100.0 × 100.0 × 100.0 m"));
        assert!(warning(&FACES[..3], Vec3::ONE).contains("3 of 6 edges"));
        assert!(warning(&FACES.map(|[a, b, c]| [a, c, b]), Vec3::ONE).contains("faces inwards"));
    }

    fn solid(name: &str, text: &str) -> Mesh {
        read(name, text.as_bytes(), Vec3::ONE).unwrap_or_else(|error| panic!("{error}: {text}"))
    }

    #[test]
    fn every_dialect_of_text_stl_gives_the_same_solid() {
        let plain = text_stl(&FACES);
        let wanted = solid("a.stl", &plain).hash();
        let two = plain.replacen(
            "endfacet\nfacet",
            "endfacet\nendsolid one\nsolid the second facet\nfacet",
            1,
        );
        for text in [
            plain.to_uppercase(),
            plain.replace('\n', "\r\n"),
            plain.replace('\n', " "),
            plain
                .replace('\n', "\n\t  ")
                .trim_end()
                .to_owned(),
            plain.replace("solid t", "solid"),
            plain
                .replace("solid t", "solid made with a facet normal of care")
                .replace("endsolid made", "endsolid"),
            plain.replace("normal 0 0 0", "normal nan -1.#IND 0"),
            plain.replace(" normal 0 0 0", ""),
            plain
                .replace("endloop\n", "")
                .replace("endfacet\n", ""),
            plain.replace("vertex 1 0 0", "vertex 1.0e+000 0.000000E+00 +0."),
            format!("\u{feff}\n{two}"),
            two,
        ] {
            assert_eq!(solid("a.STL", &text).hash(), wanted, "{text}");
        }
        let quad = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid";
        assert_eq!(solid("a.stl", quad).triangles(), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn text_stl_that_is_odd_is_refused_with_its_line() {
        let plain = text_stl(&FACES);
        for (old, new, parts) in [
            (
                "vertex 1 0 0",
                "vertex 1,0 0 0",
                ["line 6", "\"1,0\"", "must be a point"],
            ),
            (
                "vertex 1 0 0",
                "vertx 1 0 0",
                ["line 6", "\"vertx\"", "endfacet"],
            ),
            (
                "vertex 1 0 0",
                "vertex 1 0",
                ["line 7", "\"endloop\"", "no number"],
            ),
            (
                "vertex 1 0 0",
                "vertex 1 0 0 0",
                ["line 6", "\"0\"", "no word"],
            ),
            (
                "vertex 1 0 0\n",
                "",
                ["line 6", "facet of 2 corners", "missing"],
            ),
            (
                "endsolid t\n",
                "",
                ["cut short", "endsolid", "add that line"],
            ),
        ] {
            let text = refusal("cup.stl", plain.replacen(old, new, 1).as_bytes());
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{text:?} lacks one of {parts:?}"
            );
        }
        let text = refusal(
            "cup.stl",
            plain
                .replacen("vertex 1 0 0", "vertex inf 0 0", 1)
                .as_bytes(),
        );
        assert!(text.contains("not finite"), "{text}");
        assert!(refusal("cup.stl", b"").contains("the file has 0"));
        let mut none = written_stl("solid", &FACES);
        none[80..84].fill(0);
        assert!(
            refusal("cup.stl", &none)
                .contains("longer than it says: 0 triangles need 84 bytes, the file has 284")
        );
    }

    #[test]
    fn every_dialect_of_obj_gives_the_same_solid() {
        let wanted = solid("a.obj", OBJ).hash();
        for text in [
            OBJ.replace('\n', "\r\n"),
            OBJ.replace(' ', "\t "),
            OBJ.trim_end().to_owned(),
            OBJ.replace("f 1 ", "f 1 \\\n  "),
            OBJ.replace("f 1 ", "f 1 \\\r\n  "),
            OBJ.replace("\ng ", "\n# C:\\models\\\ng "),
            OBJ.replace("f 1 3 2", "f 1 3 2 # a face"),
            OBJ.replace("f 1 3 2", "f -4 -2 -3"),
            OBJ.replace("f 1 3 2", "vt 0 0\nvn 0 0 1\nvp 0 0\nf 1/1 3/1 2/1"),
            OBJ.replace("f 1 3 2", "vn 0 0 1\nf 1//1 3//1 2//1"),
            OBJ.replace("f 1 3 2", "vt 0 0\nvn 0 0 1\nf 1/1/1 3/1/1 2/1/1"),
            OBJ.replace("v 1 0 0", "v 1 0 0 1.0")
                .replace("v 0 1 0", "v 0 1 0 0.5 0.25 1")
                .replace("v 0 0 1", "v 0 0 1 1 1 1 1"),
            format!(
                "mtllib a b.mtl\no thing\ns off\nusemtl red\n{}",
                OBJ.replace("g b", "usemtl blue\no \u{fffd}")
            ),
            // Faces before vertices.
            format!(
                "{}{}",
                &OBJ[OBJ.find("g a").unwrap()..],
                &OBJ[..OBJ.find("g a").unwrap()]
            ),
        ] {
            let mesh = solid("a.Obj", &text);
            assert_eq!(mesh.hash(), wanted, "{text}");
            assert!(mesh.warnings().is_empty(), "{:?}", mesh.warnings());
        }
        let mut latin = b"# caf\xe9\ng caf\xe9\n".to_vec();
        latin.extend(OBJ.as_bytes());
        assert_eq!(read("a.obj", &latin, Vec3::ONE).unwrap().hash(), wanted);
    }

    #[test]
    fn what_an_obj_has_besides_polygons_is_counted_or_refused() {
        let mesh = solid("cup.obj", &format!("{OBJ}l 1 2\nl 2 3\np 1\nf 1 2\n"));
        let warnings: Vec<&str> = mesh
            .warnings()
            .iter()
            .map(|warning| warning.text())
            .collect();
        assert_eq!(
            warnings,
            [
                "mesh cup.obj has 2 lines, 1 points, 1 polygons of fewer than three corners; they have no surface and are left out"
            ]
        );
        let crossing = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n";
        assert!(
            solid("cup.obj", crossing)
                .warnings()
                .iter()
                .any(|text| text.contains("1 polygons that cross themselves"))
        );
        for (line, parts) in [
            ("surf 0 1 0 1 1 2 3 4", ["line 11", "\"surf\"", "free-form"]),
            ("curv 0 1 1 2", ["line 11", "\"curv\"", "free-form"]),
            ("call other.obj", ["line 11", "\"call\"", "in one file"]),
            ("F 1 2 3", ["line 11", "\"F\"", "v and f"]),
            ("v 1 2", ["line 11", "2 numbers", "x, y and z"]),
            ("v 1 2 3 0.5", ["line 11", "weight 0.5", "only weight 1"]),
            ("v 1,5 2 3", ["line 11", "\"1,5\"", "must be a point"]),
            ("f 1 2 0", ["line 11", "\"0\"", "1, 2"]),
            ("f 1 2 -5", ["line 11", "\"-5\"", "\u{2212}4"]),
            ("f 1 2 x", ["line 11", "\"x\"", "1, 2"]),
            ("f 1 2 9", ["vertex 9", "there are 4", ""]),
            ("f 1 2 99999999999", ["line 11", "99999999999", ""]),
        ] {
            let text = refusal("cup.obj", format!("{OBJ}{line}\n").as_bytes());
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{text:?} lacks one of {parts:?}"
            );
        }
        assert!(refusal("cup.obj", b"v\x00 0\x00").contains("no text in UTF-8"));
    }

    /// Bent so much that it is not convex; drawn flat it is.
    #[test]
    fn a_quad_is_cut_as_the_file_has_it_whatever_scales_it() {
        let text = "v 0 0 -5\nv 1 0 9\nv 1 1 -7\nv 0 1 -1\nf 1 2 3 4\n";
        let cut = |text: &str, scale| {
            read("a.obj", text.as_bytes(), scale)
                .unwrap()
                .triangles()
                .to_vec()
        };
        let flatter = Vec3::new(1.0, 1.0, 0.1);
        assert_eq!(cut(text, flatter), cut(text, Vec3::ONE));
        let flat = "v 0 0 -0.5\nv 1 0 0.9\nv 1 1 -0.7\nv 0 1 -0.1\nf 1 2 3 4\n";
        assert_ne!(cut(flat, Vec3::ONE), cut(text, flatter));
        let positions = "0 0 -5  1 0 9  1 1 -7  0 1 -1";
        let node = |scale: &str| dae(positions, scale);
        let whole = read("a.dae", node("1 1 1").as_bytes(), Vec3::ONE).unwrap();
        let scaled = read("a.dae", node("1 1 0.1").as_bytes(), Vec3::ONE).unwrap();
        assert_eq!(scaled.triangles(), whole.triangles());
    }

    /// One quad that a node scales.
    fn dae(positions: &str, scale: &str) -> String {
        format!(
            "<COLLADA><library_geometries><geometry id='g'><mesh><source id='p'><float_array id='a' count='12'>\
             {positions}</float_array><technique_common><accessor source='#a' count='4' stride='3'><param name='X' \
             type='float'/><param name='Y' type='float'/><param name='Z' type='float'/></accessor></technique_common>\
             </source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices><polylist count='1'><input \
             semantic='VERTEX' source='#v' offset='0'/><vcount>4</vcount><p>0 1 2 3</p></polylist></mesh></geometry>\
             </library_geometries><library_visual_scenes><visual_scene id='s'><node><scale>{scale}</scale>\
             <instance_geometry url='#g'/></node></visual_scene></library_visual_scenes>\
             <scene><instance_visual_scene url='#s'/></scene></COLLADA>"
        )
    }

    /// A cube far from the origin keeps its size in formats of text: f32 has steps of 0.5 there.
    #[test]
    fn coordinates_of_text_are_f64() {
        let at = |[x, y, z]: [f32; 3]| {
            [
                400321.65 + 0.2 * f64::from(x),
                5812345.78 + 0.2 * f64::from(y),
                f64::from(z),
            ]
        };
        let line = |word: &str, corner: [f32; 3]| {
            at(corner)
                .iter()
                .fold(word.to_owned(), |line, c| format!("{line} {c}"))
        };
        let facet = |face: &[[f32; 3]; 3]| {
            format!(
                "facet normal 0 0 0 outer loop {} endloop endfacet\n",
                face.map(|c| line("vertex", c)).join(" ")
            )
        };
        let stl = format!(
            "solid\n{}endsolid\n",
            FACES.iter().map(facet).collect::<String>()
        );
        let corners: String = FACES
            .iter()
            .flatten()
            .map(|corner| line("v", *corner) + "\n")
            .collect();
        let obj = corners + "f 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n";
        for (name, text) in [("a.stl", stl), ("a.obj", obj)] {
            let mesh = solid(name, &text);
            assert!(mesh.has_inside() && mesh.vertices().len() == 4, "{name}");
            assert!(
                (mesh.signed_volume() - 0.04 / 6.0).abs() < 1e-10,
                "{name}: {}",
                mesh.signed_volume()
            );
        }
    }
}
