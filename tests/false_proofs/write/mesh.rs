//! Meshes as STL (text and binary), OBJ and DAE.

use std::fmt::Write;

use super::words;
use crate::make::mesh::{Format, Mesh, Step};
use crate::pose::Vector;

/// The bytes of a mesh file.
pub fn bytes(mesh: &Mesh) -> Vec<u8> {
    let vertices: Vec<Vector> = mesh
        .column
        .vertices()
        .iter()
        .map(|vertex| mesh.in_file(*vertex))
        .collect();
    let mut faces = mesh.faces();
    if mesh.is_mirrored() {
        faces
            .iter_mut()
            .for_each(|face| face[1..].reverse());
    }
    match mesh.format {
        Format::StlText => stl_text(&vertices, &faces).into_bytes(),
        Format::StlBinary => stl_binary(&vertices, &faces, mesh.whim),
        Format::Obj => obj(&vertices, &faces, mesh.whim).into_bytes(),
        Format::Dae => dae(&vertices, &faces, mesh).into_bytes(),
        Format::Inline => unreachable!("a mesh in the scene has no file"),
    }
}

fn stl_text(vertices: &[Vector], faces: &[Vec<usize>]) -> String {
    let mut text = "solid made by a test\n".to_owned();
    for face in faces {
        text += "  facet normal 0 0 0\n    outer loop\n";
        face.iter()
            .for_each(|&i| text += &format!("      vertex {}\n", words(&vertices[i])));
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid made by a test\n"
}

fn stl_binary(vertices: &[Vector], faces: &[Vec<usize>], whim: u64) -> Vec<u8> {
    // Many exporters begin binary files like texts.
    let header: &[u8] = if whim.is_multiple_of(2) {
        b"solid but binary"
    } else {
        b"binary"
    };
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        let corners = face.iter().flat_map(|&i| vertices[i]);
        bytes.extend(corners.flat_map(|number| (number as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(vertices: &[Vector], faces: &[Vec<usize>], whim: u64) -> String {
    let mut text = "# made by a test\no solid\nvn 0 0 1\nvt 0 0\n".to_owned();
    vertices
        .iter()
        .for_each(|vertex| text += &format!("v {}\n", words(vertex)));
    for (index, face) in faces.iter().enumerate() {
        let corner = |&i: &usize| match whim % 5 {
            0 => format!("{}", i as i64 - vertices.len() as i64),
            1 => format!("{}//1", i + 1),
            2 => format!("{}/1/1", i + 1),
            _ => format!("{}", i + 1),
        };
        if whim.is_multiple_of(3) && index == 2 {
            text += "g walls\ns off\n";
        }
        let corners: Vec<String> = face.iter().map(corner).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}

fn dae(vertices: &[Vector], faces: &[Vec<usize>], mesh: &Mesh) -> String {
    let has_normals = mesh.whim.is_multiple_of(2);
    let axis = ["X_UP", "Y_UP", "Z_UP"][mesh.whim as usize / 2 % 3];
    let (open, close) = nodes(&mesh.steps, mesh.whim);
    let normal = if has_normals {
        "<input semantic=\"NORMAL\" source=\"#n\" offset=\"1\"/>"
    } else {
        ""
    };
    let input = format!("<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>{normal}");
    let positions: Vec<String> = vertices
        .iter()
        .map(|vertex| words(vertex))
        .collect();
    format!(
        r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="own" meter="{}"/><up_axis>{axis}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
{}{}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
{}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">{open}<instance_geometry url="#g"/>{close}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"##,
        mesh.unit,
        source("p", vertices.len(), &positions.join(" ")),
        source("n", 1, "0 0 1"),
        polygons(faces, &input, has_normals, mesh.whim / 8),
    )
}

fn source(id: &str, count: usize, numbers: &str) -> String {
    let params = ["X", "Y", "Z"]
        .map(|name| format!("<param name=\"{name}\" type=\"float\"/>"))
        .concat();
    format!(
        "<source id=\"{id}\"><float_array id=\"{id}a\" count=\"{}\">{numbers}</float_array><technique_common>\
         <accessor source=\"#{id}a\" count=\"{count}\" stride=\"3\">{params}</accessor></technique_common></source>\n",
        3 * count
    )
}

/// The node that shows the geometry, within another or not.
fn nodes(steps: &[Step], whim: u64) -> (String, String) {
    let text = |step: &Step| match step {
        Step::Translate(by) => format!("<translate>{}</translate>", words(by)),
        Step::Rotate(axis, degrees) => format!("<rotate>{} {degrees}</rotate>", words(axis)),
        Step::Scale(by) if whim.is_multiple_of(3) => {
            format!(
                "<matrix>{} 0 0 0 0 {} 0 0 0 0 {} 0 0 0 0 1</matrix>",
                by[0], by[1], by[2]
            )
        }
        Step::Scale(by) => format!("<scale>{}</scale>", words(by)),
    };
    let split = steps.len() / 2;
    let [outer, inner] =
        [&steps[..split], &steps[split..]].map(|steps| steps.iter().map(text).collect::<String>());
    (
        format!("<node id=\"outer\">{outer}<node id=\"inner\">{inner}"),
        "</node></node>".to_owned(),
    )
}

fn polygons(faces: &[Vec<usize>], input: &str, has_normals: bool, whim: u64) -> String {
    let list = |face: &Vec<usize>| {
        let corner = |i: &usize| {
            if has_normals {
                format!("{i} 0")
            } else {
                i.to_string()
            }
        };
        face.iter()
            .map(corner)
            .collect::<Vec<_>>()
            .join(" ")
    };
    let lists: Vec<String> = faces.iter().map(list).collect();
    let count = faces.len();
    if faces.iter().all(|face| face.len() == 3) && whim.is_multiple_of(2) {
        return format!(
            "<triangles count=\"{count}\">{input}<p>{}</p></triangles>",
            lists.join(" ")
        );
    }
    if whim % 4 < 2 {
        let each: String = lists
            .iter()
            .map(|list| format!("<p>{list}</p>"))
            .collect();
        return format!("<polygons count=\"{count}\">{input}{each}</polygons>");
    }
    let sizes: Vec<String> = faces
        .iter()
        .map(|face| face.len().to_string())
        .collect();
    let sizes = sizes.join(" ");
    let lists = lists.join(" ");
    format!("<polylist count=\"{count}\">{input}<vcount>{sizes}</vcount><p>{lists}</p></polylist>")
}
