//! Collada files: units and transforms, references, kinds of polygons, and what else a scene holds.

use super::case::Case;

/// A tetrahedron of corners (0.125 0.25 0.5) and edges of 1, 0.5 and 0.25, turned outwards.
const POSITIONS: &str = "0.125 0.25 0.5 1.125 0.25 0.5 0.125 0.75 0.5 0.125 0.25 0.75";
const TRIANGLES: &str = r##"<triangles count="4"><input semantic="VERTEX" source="#verts" offset="0"/>
  <p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>"##;
const ASSET: &str = r#"<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>"#;
const SHOWN: &str = r##"<instance_geometry url="#geo"/>"##;

/// A document of these parts.
struct Parts {
    asset: String,
    positions: String,
    accessor: String,
    polygons: String,
    node: String,
    more: String,
}

impl Default for Parts {
    fn default() -> Self {
        Self {
            asset: ASSET.to_owned(),
            positions: POSITIONS.to_owned(),
            accessor: accessor(4, 3, 0),
            polygons: TRIANGLES.to_owned(),
            node: format!("<node id=\"n\" name=\"n\">{SHOWN}</node>"),
            more: String::new(),
        }
    }
}

fn accessor(count: usize, stride: usize, offset: usize) -> String {
    format!(
        r##"<accessor source="#pos-array" count="{count}" stride="{stride}" offset="{offset}"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>"##
    )
}

impl Parts {
    fn text(&self) -> String {
        let Self {
            asset,
            positions,
            accessor,
            polygons,
            node,
            more,
        } = self;
        let count = positions.split_whitespace().count();
        format!(
            r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
{asset}
{more}
<library_geometries><geometry id="geo" name="geo"><mesh>
<source id="pos"><float_array id="pos-array" count="{count}">{positions}</float_array>
 <technique_common>{accessor}</technique_common></source>
<vertices id="verts"><input semantic="POSITION" source="#pos"/></vertices>
{polygons}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene" name="scene">
{node}
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
"##
        )
    }

    fn case(self, name: &str) -> Case {
        Case::new(format!("dae/{name}.dae"), self.text())
    }
}

fn node(name: &str, node: &str) -> Case {
    Parts {
        node: node.replace("SHOWN", SHOWN),
        ..Parts::default()
    }
    .case(name)
}

fn replaced(name: &str, old: &str, new: &str) -> Case {
    let text = Parts::default().text();
    assert!(text.contains(old), "{name}: {old}");
    Case::new(format!("dae/{name}.dae"), text.replace(old, new))
}

pub fn cases() -> Vec<Case> {
    let mut cases = units();
    cases.extend(transforms());
    cases.extend(nodes());
    cases.extend(polygons());
    cases.extend(sources());
    cases.extend(documents());
    cases.extend(beside());
    cases.extend(refused());
    cases
}

fn units() -> Vec<Case> {
    let unit = |name: &str, unit: &str| replaced(name, "<unit name=\"meter\" meter=\"1\"/>", unit);
    let counts =
        "the unit counts, as in RViz and Gazebo; coal and MoveIt take the numbers for metres";
    let other = |name: &str, text: &str| unit(name, text).read_as("pycollada", counts);
    let up = |name: &str, up: &str| {
        replaced(name, "<up_axis>Z_UP</up_axis>", up).read_as(
            "pycollada",
            "as in RViz and MoveIt, a link means the mesh's own x, y and z",
        )
    };
    vec![
        unit("unit_metre", "<unit name=\"meter\" meter=\"1\"/>"),
        other(
            "unit_centimetre",
            "<unit name=\"centimeter\" meter=\"0.01\"/>",
        ),
        other("unit_inch", "<unit name=\"inch\" meter=\"0.0254\"/>"),
        other("unit_exponent", "<unit meter=\"1.0e-3\"/>"),
        other("unit_blank", "<unit meter=\" 0.01 \"/>"),
        other("unit_two_metres", "<unit name=\"two\" meter=\"2\"/>"),
        unit("unit_name_only", "<unit name=\"millimeter\"/>"),
        unit("unit_missing", ""),
        unit("unit_empty", "<unit/>"),
        up("up_x", "<up_axis>X_UP</up_axis>"),
        up("up_y", "<up_axis>Y_UP</up_axis>"),
        replaced("up_missing", "<up_axis>Z_UP</up_axis>", "").read_as(
            "pycollada",
            "as in RViz and MoveIt, a link means the mesh's own x, y and z",
        ),
        replaced("asset_missing", ASSET, "").read_as(
            "pycollada",
            "as in RViz and MoveIt, a link means the mesh's own x, y and z",
        ),
        replaced(
            "asset_long",
            "<unit",
            "<contributor><author>J. Doe</author></contributor><created>2024-01-01T00:00:00</created><unit",
        ),
    ]
}

fn transforms() -> Vec<Case> {
    let moved = |name: &str, transform: &str| {
        node(name, &format!("<node id=\"n\">{transform}SHOWN</node>"))
    };
    vec![
        moved("translate", "<translate sid=\"t\">1 2 3</translate>"),
        moved(
            "translate_small",
            "<translate>0.001 0.002 0.003</translate>",
        ),
        moved("rotate", "<rotate>0 0 1 90</rotate>"),
        moved("rotate_long_axis", "<rotate>0 0 2 90</rotate>").refused(
            &["line", "rotate"],
            "readers do not make it a unit vector: they stretch the mesh",
        ),
        moved("rotate_tilted", "<rotate>1 1 0 30</rotate>").refused(
            &["line", "rotate"],
            "readers do not make it a unit vector: they stretch the mesh",
        ),
        moved("scale", "<scale>2 3 4</scale>"),
        moved("scale_mirrors", "<scale>-1 1 1</scale>"),
        moved(
            "matrix",
            "<matrix>0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1</matrix>",
        ),
        moved(
            "matrix_sheared",
            "<matrix>1 0.5 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>",
        ),
        moved(
            "matrix_lines",
            "<matrix sid=\"m\">\n 1 0 0 1\n 0 1 0 2\n 0 0 1 3\n 0 0 0 1\n</matrix>",
        ),
        moved("lookat", "<lookat>1 2 3 0 0 0 0 0 1</lookat>").refused(
            &["line", "lookat"],
            "readers do not agree whether it places the eye or the world",
        ),
        moved("skew", "<skew>45 0 1 0 1 0 0</skew>")
            .refused(&["line", "skew"], "readers do not agree what it does"),
        moved(
            "translate_then_rotate",
            "<translate>1 2 3</translate><rotate>0 0 1 90</rotate>",
        ),
        moved(
            "rotate_then_translate",
            "<rotate>0 0 1 90</rotate><translate>1 2 3</translate>",
        ),
        moved(
            "three_rotations",
            "<rotate>0 0 1 30</rotate><rotate>0 1 0 20</rotate><rotate>1 0 0 10</rotate><scale>1 1 2</scale>",
        ),
        moved(
            "two_matrices",
            "<matrix>0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1</matrix><matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix>",
        ),
    ]
}

fn nodes() -> Vec<Case> {
    let library =
        "<library_nodes><node id=\"part\"><translate>0 0 1</translate>SHOWN</node></library_nodes>"
            .replace("SHOWN", SHOWN);
    let from_library = |name: &str, inner: &str| {
        Parts {
            more: library.clone(),
            node: inner.to_owned(),
            ..Parts::default()
        }
        .case(name)
    };
    let sheared = "<translate>1 0 0</translate><rotate>0 0 1 90</rotate>";
    vec![
        node(
            "nested",
            &format!(
                "<node id=\"a\">{sheared}<node id=\"b\"><translate>0 0 1</translate><node id=\"c\"><scale>1 2 1</scale>SHOWN</node></node></node>"
            ),
        ),
        node(
            "placed_twice",
            "<node id=\"a\">SHOWN</node><node id=\"b\"><translate>5 0 0</translate>SHOWN</node>",
        ),
        node("twice_in_a_node", "<node id=\"a\">SHOWN SHOWN</node>"),
        node("node_without_id", "<node>SHOWN</node>"),
        node(
            "joint_node",
            "<node id=\"a\" type=\"JOINT\"><translate>0 1 0</translate>SHOWN</node>",
        ),
        node("layer", "<node id=\"a\" layer=\"L1 L2\">SHOWN</node>"),
        node(
            "empty_nodes",
            "<node id=\"e\"/><node id=\"a\">SHOWN</node><node id=\"z\"><translate>1 1 1</translate></node>",
        ),
        node(
            "extras",
            "<node id=\"a\">SHOWN<extra><technique profile=\"X\"><visibility>1</visibility></technique></extra></node>",
        ),
        node(
            "material",
            "<node id=\"a\"><instance_geometry url=\"#geo\"><bind_material><technique_common/></bind_material></instance_geometry></node>",
        ),
        from_library(
            "instance_node",
            "<node id=\"a\"><instance_node url=\"#part\"/></node>",
        ),
        from_library(
            "instance_node_moved",
            "<node id=\"a\"><translate>1 0 0</translate><instance_node url=\"#part\"/><instance_node url=\"#part\"/></node>",
        ),
        replaced(
            "second_scene",
            "</library_visual_scenes>",
            "<visual_scene id=\"other\"><node id=\"o\"><translate>9 9 9</translate><instance_geometry url=\"#geo\"/></node></visual_scene></library_visual_scenes>",
        ),
        replaced(
            "not_shown",
            "</library_geometries>",
            "<geometry id=\"spare\"><mesh><source id=\"p2\"><float_array id=\"a2\" count=\"9\">0 0 0 9 0 0 0 9 0</float_array><technique_common><accessor source=\"#a2\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v2\"><input semantic=\"POSITION\" source=\"#p2\"/></vertices><triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v2\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>",
        ),
        replaced(
            "no_scene",
            "<scene><instance_visual_scene url=\"#scene\"/></scene>",
            "",
        )
        .read_as(
            "pycollada",
            "the only visual scene is the one that is shown",
        ),
    ]
}

/// A box of quads: positions and corners.
const BOX: &str = "0 0 0 1 0 0 1 0.5 0 0 0.5 0 0 0 0.25 1 0 0.25 1 0.5 0.25 0 0.5 0.25";
const QUADS: &str = "0 3 2 1 4 5 6 7 0 1 5 4 1 2 6 5 2 3 7 6 3 0 4 7";
const INPUT: &str = r##"<input semantic="VERTEX" source="#verts" offset="0"/>"##;

fn boxed(name: &str, polygons: &str) -> Case {
    let polygons = polygons
        .replace("INPUT", INPUT)
        .replace("QUADS", QUADS);
    Parts {
        positions: BOX.to_owned(),
        accessor: accessor(8, 3, 0),
        polygons,
        ..Parts::default()
    }
    .case(name)
}

fn quads() -> Vec<String> {
    let words: Vec<&str> = QUADS.split(' ').collect();
    words
        .chunks(4)
        .map(|quad| quad.join(" "))
        .collect()
}

fn polygons() -> Vec<Case> {
    let each: String = quads()
        .iter()
        .map(|quad| format!("<p>{quad}</p>"))
        .collect();
    let strips = "<p>0 3 1 2 5 6 4 7 0 3</p><p>3 7 2 6</p><p>0 1 4 5</p>";
    let fans: String = each.clone();
    let l = "0 0 0 2 0 0 2 0.5 0 0.5 0.5 0 0.5 2 0 0 2 0 0 0 0.25 2 0 0.25 2 0.5 0.25 0.5 0.5 0.25 0.5 2 0.25 0 2 0.25";
    let ends = |a: &str, b: &str| {
        format!(
            "<polylist count=\"8\">{INPUT}<vcount>6 6 4 4 4 4 4 4</vcount><p>{a} {b} 0 1 7 6 1 2 8 7 2 3 9 8 3 4 10 9 4 5 11 10 5 0 6 11</p></polylist>"
        )
    };
    let l_shape = |name: &str, a: &str, b: &str| {
        Parts {
            positions: l.to_owned(),
            accessor: accessor(12, 3, 0),
            polygons: ends(a, b),
            ..Parts::default()
        }
        .case(name)
    };
    let bent = |name: &str, polygons: &str| {
        let mut case = boxed(name, polygons);
        case.bytes = String::from_utf8_lossy(&case.bytes)
            .replace("0 0.5 0.25</float_array>", "0 0.5 0.5</float_array>")
            .into_bytes();
        case
    };
    let polylist =
        "<polylist count=\"6\">INPUT<vcount>4 4 4 4 4 4</vcount><p>QUADS</p></polylist>".to_owned();
    vec![
        boxed("polylist", &polylist),
        boxed(
            "polylist_lines",
            &polylist.replace("4 4 4 4 4 4", "\n4 4\n4 4 4\t4\n"),
        ),
        boxed(
            "polygons",
            &format!("<polygons count=\"6\">INPUT{each}</polygons>"),
        ),
        boxed(
            "tristrips",
            &format!("<tristrips count=\"3\">INPUT{strips}</tristrips>"),
        ),
        boxed(
            "trifans",
            &format!("<trifans count=\"6\">INPUT{fans}</trifans>"),
        ),
        boxed(
            "two_elements",
            "<polylist count=\"3\">INPUT<vcount>4 4 4</vcount><p>0 3 2 1 4 5 6 7 0 1 5 4</p></polylist><triangles count=\"6\">INPUT<p>1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7</p></triangles>",
        ),
        boxed(
            "lines_beside",
            &format!(
                "<lines count=\"2\">INPUT<p>0 1 2 3</p></lines>{polylist}<linestrips count=\"1\">INPUT<p>0 1 2 3</p></linestrips>"
            ),
        ),
        boxed("no_count", &polylist.replace(" count=\"6\"", "")),
        boxed(
            "empty_triangles_beside",
            &format!("<triangles count=\"0\">INPUT<p/></triangles>{polylist}"),
        ),
        bent("bent_polylist", &polylist),
        bent(
            "bent_polygons",
            &format!("<polygons count=\"6\">INPUT{each}</polygons>"),
        ),
        l_shape("l_shape", "0 5 4 3 2 1", "6 7 8 9 10 11"),
        l_shape("l_shape_other_corner", "3 2 1 0 5 4", "9 10 11 6 7 8")
            .read_as("coal", "a concave polygon is what its outline holds"),
        boxed(
            "repeated_corner",
            &polylist
                .replacen("4 4", "5 4", 1)
                .replace("QUADS", &QUADS.replacen("0 3 2 1", "0 3 3 2 1", 1)),
        ),
        boxed(
            "hole",
            "<polygons count=\"1\">INPUT<ph><p>0 1 2 3</p><h>4 5 6</h></ph></polygons>",
        )
        .refused(&["line", "<ph>"], "no reader cuts holes"),
    ]
}

fn sources() -> Vec<Case> {
    let normals = r##"<source id="nor"><float_array id="nor-array" count="3">0 0 1</float_array><technique_common><accessor source="#nor-array" count="1" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>"##;
    let with_normals = |name: &str, polygons: &str| {
        let mut case = Parts {
            polygons: polygons.to_owned(),
            ..Parts::default()
        }
        .case(name);
        case.bytes = String::from_utf8_lossy(&case.bytes)
            .replace("<vertices id", &format!("{normals}<vertices id"))
            .into_bytes();
        case
    };
    let normal =
        |offset: usize| format!("<input semantic=\"NORMAL\" source=\"#nor\" offset=\"{offset}\"/>");
    let own = Parts {
        positions: format!("7 7 7 7 {}", POSITIONS),
        accessor: accessor(4, 3, 4),
        ..Parts::default()
    };
    let wide = POSITIONS
        .split(' ')
        .collect::<Vec<_>>()
        .chunks(3)
        .map(|c| format!("{} 1", c.join(" ")))
        .collect::<Vec<_>>()
        .join(" ");
    vec![
        with_normals(
            "normals_behind",
            &format!(
                "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/>{}<p>0 0 2 0 1 0 0 0 1 0 3 0 0 0 3 0 2 0 1 0 2 0 3 0</p></triangles>",
                normal(1)
            ),
        ),
        with_normals(
            "normals_before",
            &format!(
                "<triangles count=\"4\">{}<input semantic=\"VERTEX\" source=\"#verts\" offset=\"1\"/><p>0 0 0 2 0 1 0 0 0 1 0 3 0 0 0 3 0 2 0 1 0 2 0 3</p></triangles>",
                normal(0)
            ),
        ),
        with_normals(
            "offset_gap",
            &format!(
                "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/>{}<p>0 9 0 2 9 0 1 9 0 0 9 0 1 9 0 3 9 0 0 9 0 3 9 0 2 9 0 1 9 0 2 9 0 3 9 0</p></triangles>",
                normal(2)
            ),
        ),
        Parts {
            positions: wide,
            accessor: accessor(4, 4, 0).replace(
                "</accessor>",
                "<param name=\"W\" type=\"float\"/></accessor>",
            ),
            ..Parts::default()
        }
        .case("stride_4")
        .read_as("coal", "the accessor says where each position stands"),
        own.case("accessor_offset")
            .read_as("coal", "the accessor says where each position stands"),
        Parts {
            positions: POSITIONS
                .replace("1.125", "+1.125E0")
                .replace("0.25", "25.0e-2"),
            ..Parts::default()
        }
        .case("exponents"),
        Parts {
            positions: format!("\n\t{}\n", POSITIONS.replace(' ', "\n\t")),
            ..Parts::default()
        }
        .case("lines_and_tabs"),
        Parts {
            positions: POSITIONS
                .replace("0.5", ".5")
                .replace("0.125", "0.12500000000000000000000"),
            ..Parts::default()
        }
        .case("bare_points"),
        Parts {
            positions: format!("{POSITIONS} 90 90 90"),
            accessor: accessor(5, 3, 0),
            ..Parts::default()
        }
        .case("unused_position"),
        Parts {
            positions: POSITIONS.replace("0.125 0.25 0.75", "0.125 <!-- z next --> 0.25 0.75"),
            ..Parts::default()
        }
        .case("comment_in_numbers")
        .refused(
            &["line", "<float_array>", "cut short"],
            "no reader goes on behind the comment",
        ),
        Parts {
            positions: format!("<![CDATA[{POSITIONS}]]>"),
            ..Parts::default()
        }
        .case("cdata_numbers"),
        Parts::default()
            .case("character_references")
            .with(|text| text.replace(POSITIONS, &POSITIONS.replace(' ', "&#x20;"))),
        Parts {
            accessor: accessor(4, 3, 0)
                .replace("name=\"X\" ", "")
                .replace("name=\"Y\" ", "")
                .replace("name=\"Z\" ", ""),
            ..Parts::default()
        }
        .case("unnamed_params"),
        replaced(
            "digits_magnitude",
            "count=\"12\"",
            "count=\"12\" digits=\"6\" magnitude=\"38\"",
        ),
    ]
}

fn utf16(text: &str, big: bool) -> Vec<u8> {
    let bytes = |unit: u16| {
        if big {
            unit.to_be_bytes()
        } else {
            unit.to_le_bytes()
        }
    };
    "\u{feff}"
        .encode_utf16()
        .chain(text.encode_utf16())
        .flat_map(bytes)
        .collect()
}

fn documents() -> Vec<Case> {
    let text = Parts::default().text();
    let case = |name: &str, bytes: Vec<u8>| Case::new(format!("dae/{name}.dae"), bytes);
    let wide = text.replace("utf-8", "utf-16");
    let latin = text
        .replace("utf-8", "ISO-8859-1")
        .replacen("name=\"geo\"", "name=\"Träger\"", 1);
    let latin: Vec<u8> = latin.chars().map(|c| c as u8).collect();
    let prefixed = text
        .replace("</", "</c:")
        .replace('<', "<c:")
        .replace("<c:/c:", "</c:")
        .replace("<c:?", "<?")
        .replace("xmlns=", "xmlns:c=");
    vec![
        case("plain", text.clone().into_bytes()),
        case("no_declaration", text.lines().skip(1).collect::<Vec<_>>().join("\n").into_bytes()),
        case("bom", format!("\u{feff}{text}").into_bytes()),
        case("crlf", text.replace('\n', "\r\n").into_bytes()),
        case("one_line", text.replace('\n', "").into_bytes()),
        case("blank_line_first", format!("\n{text}").into_bytes()).read_as("coal", "the blank line says nothing"),
        case("utf16_le", utf16(&wide, false)),
        case("utf16_be", utf16(&wide, true)),
        case("latin1", latin),
        case("prefixed", prefixed.into_bytes()).read_as("pycollada", "a prefix is a way to write a namespace"),
        case("doctype", text.replace("<COLLADA", "<!DOCTYPE COLLADA>\n<COLLADA").into_bytes()),
        case("comments", text.replace("<library", "<!-- part -->\n<library").into_bytes()),
        case("no_namespace", text.replace(" xmlns=\"http://www.collada.org/2005/11/COLLADASchema\"", "").into_bytes()),
        case("version_1_5", text.replace("2005/11", "2008/03").replace("1.4.1", "1.5.0").into_bytes()),
        case("scene_first", {
            let (start, scene) = (text.find("<library_visual").unwrap_or(0), text.find("<scene>").unwrap_or(0));
            let moved = text[start..scene].to_owned();
            text.replace(&moved, "")
                .replace("<library_geometries>", &format!("{moved}<library_geometries>"))
                .into_bytes()
        }),
        case("id_with_dots", text.replace("geo\"", "my.geo-1_é\"").into_bytes()),
        case("single_quotes", text.replace('"', "'").into_bytes()),
        case(
            "mesh_extra",
            text.replace(
                "</mesh>",
                "<extra><technique profile=\"MAYA\"><double_sided>1</double_sided></technique></extra></mesh>",
            )
            .into_bytes(),
        ),
    ]
}

/// What else a scene may hold.
fn beside() -> Vec<Case> {
    let with = |name: &str, library: &str, inner: &str| {
        let node = format!("<node id=\"a\">{SHOWN}</node><node id=\"b\">{inner}</node>");
        Parts {
            more: library.to_owned(),
            node,
            ..Parts::default()
        }
        .case(name)
    };
    let camera = "<library_cameras><camera id=\"cam\"><optics><technique_common><perspective><xfov>40</xfov><aspect_ratio>1</aspect_ratio><znear>0.1</znear><zfar>100</zfar></perspective></technique_common></optics></camera></library_cameras>";
    let light = "<library_lights><light id=\"sun\"><technique_common><directional><color>1 1 1</color></directional></technique_common></light></library_lights>";
    let effect = "<library_effects><effect id=\"fx\"><profile_COMMON><technique sid=\"common\"><lambert><diffuse><color>0.8 0.8 0.8 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects><library_materials><material id=\"mat\"><instance_effect url=\"#fx\"/></material></library_materials>";
    let spline = "<library_geometries><geometry id=\"curve\"><spline closed=\"0\"><source id=\"sp\"><float_array id=\"spa\" count=\"6\">0 0 0 1 1 1</float_array><technique_common><accessor source=\"#spa\" count=\"2\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source><control_vertices><input semantic=\"POSITION\" source=\"#sp\"/></control_vertices></spline></geometry></library_geometries>";
    let animation = "<library_animations><animation id=\"anim\"/></library_animations>";
    let physics = "<library_physics_models><physics_model id=\"pm\"><rigid_body sid=\"rb\"><technique_common><dynamic>true</dynamic></technique_common></rigid_body></physics_model></library_physics_models>";
    let skin = "<library_controllers><controller id=\"skin\"><skin source=\"#geo\"><bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix><source id=\"j\"><Name_array id=\"ja\" count=\"1\">bone</Name_array><technique_common><accessor source=\"#ja\" count=\"1\" stride=\"1\"><param name=\"JOINT\" type=\"name\"/></accessor></technique_common></source><source id=\"m\"><float_array id=\"ma\" count=\"16\">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</float_array><technique_common><accessor source=\"#ma\" count=\"1\" stride=\"16\"><param name=\"TRANSFORM\" type=\"float4x4\"/></accessor></technique_common></source><source id=\"w\"><float_array id=\"wa\" count=\"1\">1</float_array><technique_common><accessor source=\"#wa\" count=\"1\" stride=\"1\"><param name=\"WEIGHT\" type=\"float\"/></accessor></technique_common></source><joints><input semantic=\"JOINT\" source=\"#j\"/><input semantic=\"INV_BIND_MATRIX\" source=\"#m\"/></joints><vertex_weights count=\"4\"><input semantic=\"JOINT\" source=\"#j\" offset=\"0\"/><input semantic=\"WEIGHT\" source=\"#w\" offset=\"1\"/><vcount>1 1 1 1</vcount><v>0 0 0 0 0 0 0 0</v></vertex_weights></skin></controller></library_controllers>";
    vec![
        with("camera", camera, "<instance_camera url=\"#cam\"/>"),
        with("light", light, "<instance_light url=\"#sun\"/>"),
        with(
            "camera_and_light",
            &format!("{camera}{light}"),
            "<instance_camera url=\"#cam\"/><instance_light url=\"#sun\"/>",
        ),
        with("camera_missing", "", "<instance_camera url=\"#nowhere\"/>"),
        with("effects", effect, ""),
        with("animation", animation, ""),
        with("physics", physics, ""),
        with("spline_unused", spline, ""),
        with(
            "spline_shown",
            spline,
            "<instance_geometry url=\"#curve\"/>",
        )
        .read_as("coal", "a curve is no surface"),
        with("skin_unused", skin, ""),
        with("skin_shown", skin, "<instance_controller url=\"#skin\"/>")
            .refused(&["line", "skeleton"], "a mesh that bends is no rigid shape"),
    ]
}

fn refused() -> Vec<Case> {
    let missing = "it is cut short, or names what is not there";
    vec![
        replaced("geometry_missing", "url=\"#geo\"", "url=\"#gone\"")
            .refused(&["line", "gone"], missing),
        replaced("other_file", "url=\"#geo\"", "url=\"parts.dae#geo\"")
            .refused(&["line", "parts.dae#geo"], missing),
        replaced("count_short", "count=\"12\"", "count=\"15\"").refused(&["line", "15"], missing),
        replaced("number_bad", "1.125 0.25", "1.125x 0.25").refused(&["line", "1.125x"], missing),
        replaced(
            "triangles_count",
            "<triangles count=\"4\"",
            "<triangles count=\"5\"",
        )
        .refused(&["line", "5"], missing),
        replaced("no_mesh_shown", SHOWN, "").refused(&["shows no polygon"], "it is no solid"),
        Case::new(
            "dae/cut_short.dae",
            Parts::default().text()[..900].to_owned(),
        )
        .refused(&["not a DAE file"], missing),
    ]
}
