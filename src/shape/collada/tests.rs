use super::*;
use crate::shape::{Mesh, mesh_file};

/// A file of the geometries `cube` (the unit cube at the origin, as quads) and `tent` (a
/// tetrahedron, as triangles with a normal beside each position), with this asset and these nodes.
fn file(asset: &str, nodes: &str) -> String {
    format!(
        r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_geometries>
<geometry id="cube"><mesh>
<source id="corners"><float_array id="numbers" count="24">0 0 0 1 0 0 1 1 0 0 1 0
 0 0 1 <!-- the lid --> 1 0 1 1 1 1 0 1 1</float_array>
<technique_common><accessor source="#numbers" count="8" stride="3"/></technique_common></source>
<vertices id="cube-vertices"><input semantic="POSITION" source="#corners"/></vertices>
<polylist count="6"><input semantic="VERTEX" source="#cube-vertices" offset="0"/>
<vcount>4 4 4 4 4 4</vcount>
<p>0 3 2 1 4 5 6 7 0 1 5 4 1 2 6 5 2 3 7 6 3 0 4 7</p></polylist></mesh></geometry>
<geometry id="tent"><mesh>
<source id="tips"><float_array id="tip-numbers" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array></source>
<source id="normals"><float_array id="normal-numbers" count="3">0 0 1</float_array></source>
<vertices id="tent-vertices"><input semantic="POSITION" source="#tips"/></vertices>
<triangles count="4"><input semantic="NORMAL" source="#normals" offset="0"/>
<input semantic="VERTEX" source="#tent-vertices" offset="1"/>
<p>0 0 0 2 0 1 0 0 0 1 0 3 0 0 0 3 0 2 0 1 0 2 0 3</p></triangles></mesh></geometry>
</library_geometries>
<library_nodes><node id="shared"><translate>0 0 2</translate><instance_geometry url="#tent"/></node></library_nodes>
<library_visual_scenes><visual_scene id="other"><node><instance_geometry url="#cube"/></node></visual_scene>
<visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"##
    )
}

const CUBE: &str = "<instance_geometry url='#cube'/>";

fn mesh(text: &str) -> Mesh {
    mesh_file::read("cup.dae", text.as_bytes(), Vec3::ONE).unwrap_or_else(|error| panic!("{error}"))
}

/// Lowest and highest corner, and the enclosed volume, of a closed mesh that faces outwards.
fn solid(text: &str) -> ([Vec3; 2], f64) {
    let mesh = mesh(text);
    assert!(mesh.warnings().is_empty(), "{:?}", mesh.warnings());
    let bounds = mesh
        .vertices()
        .iter()
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[l, h], v| {
            [l.min(*v), h.max(*v)]
        });
    (bounds, mesh.signed_volume())
}

fn assert_near(actual: ([Vec3; 2], f64), low: [f64; 3], high: [f64; 3], volume: f64) {
    let ([l, h], v) = actual;
    let off = (l - Vec3::from_array(low)).length() + (h - Vec3::from_array(high)).length();
    assert!(off < 1e-12 && (v - volume).abs() < 1e-12, "{actual:?}");
}

#[test]
fn quads_make_a_closed_solid() {
    let text = file("", &format!("<node>{CUBE}</node>"));
    assert_eq!(
        (mesh(&text).vertices().len(), mesh(&text).triangles().len()),
        (8, 12)
    );
    assert_near(solid(&text), [0.0; 3], [1.0; 3], 1.0);
}

#[test]
fn the_unit_is_applied_and_the_up_axis_is_not() {
    let nodes = format!("<node><translate>1000 0 0</translate>{CUBE}</node>");
    for up in ["X_UP", "Y_UP", "Z_UP"] {
        let text = file(
            &format!("<unit name='mm' meter='0.001'/><up_axis>{up}</up_axis>"),
            &nodes,
        );
        assert_near(solid(&text), [1.0, 0.0, 0.0], [1.001, 0.001, 0.001], 1e-9);
    }
    assert_near(
        solid(&file(
            "<unit meter='0,5'/>",
            &format!("<node>{CUBE}</node>"),
        )),
        [0.0; 3],
        [0.5; 3],
        0.125,
    );
}

#[test]
fn nodes_carry_nodes_and_the_last_transform_acts_first() {
    // Scaled, then turned a quarter about z, then shifted; and the parent's matrix after all.
    let inner = "<node><translate>1 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>";
    let nodes = format!(
        "<node><matrix>1 0 0 0  0 1 0 0.004  0 0 1 0  0 0 0 1</matrix>{inner}{CUBE}</node></node>"
    );
    assert_near(
        solid(&file("", &nodes)),
        [0.0, 0.004, 0.0],
        [1.0, 2.004, 1.0],
        2.0,
    );
    // A matrix is written by rows: this one takes x to y.
    let turn = format!("<node><matrix>0 -1 0 5 1 0 0 0 0 0 1 0 0 0 0 1</matrix>{CUBE}</node>");
    assert_near(
        solid(&file("", &turn)),
        [4.0, 0.0, 0.0],
        [5.0, 1.0, 1.0],
        1.0,
    );
}

#[test]
fn a_mirror_keeps_the_surface_outside_out() {
    let nodes = format!("<node><scale>-1 1 1</scale>{CUBE}</node>");
    assert_near(
        solid(&file("", &nodes)),
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 1.0],
        1.0,
    );
}

#[test]
fn every_instance_of_every_geometry_is_there() {
    let again = format!(
        "<node><translate>3 0 0</translate>{CUBE}</node><node><instance_node url='#shared'/></node>"
    );
    let text = file("", &format!("<node>{CUBE}</node>{again}"));
    assert_eq!(mesh(&text).triangles().len(), 12 + 12 + 4);
    assert_near(solid(&text), [0.0; 3], [4.0, 1.0, 3.0], 2.0 + 1.0 / 6.0);
}

#[test]
fn without_a_visual_scene_all_geometries_are_shown() {
    let text = file("<unit meter='2'/>", "");
    let from = text.find("<library_visual_scenes>").unwrap();
    let text = format!("{}</COLLADA>", &text[..from]);
    assert_eq!(mesh(&text).triangles().len(), 16);
}

#[test]
fn strips_fans_and_polygons_are_read() {
    let text = file("", &format!("<node>{CUBE}</node>"));
    let from = text.find("<polylist").unwrap();
    let to = text.find("</polylist>").unwrap() + "</polylist>".len();
    let input = "<input semantic='VERTEX' source='#cube-vertices' offset='0'/>";
    // Bottom and lid as fans, the four walls as one strip, or every face a polygon of its own.
    let walls = format!("<tristrips count='1'>{input}<p>4 0 5 1 6 2 7 3 4 0</p></tristrips>");
    let ends = format!("<trifans count='2'>{input}<p>0 3 2 1</p><p>4 5 6 7</p></trifans>");
    let faces = [
        "0 3 2 1", "4 5 6 7", "0 1 5 4", "1 2 6 5", "2 3 7 6", "3 0 4 7",
    ]
    .map(|p| format!("<p>{p}</p>"));
    let polygons = format!("<polygons count='6'>{input}{}</polygons>", faces.concat());
    for elements in [walls + &ends, polygons] {
        let text = format!("{}{elements}{}", &text[..from], &text[to..]);
        assert_near(solid(&text), [0.0; 3], [1.0; 3], 1.0);
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_its_line() {
    let good = file("<unit meter='1'/>", &format!("<node>{CUBE}</node>"));
    assert!(read(good.as_bytes()).is_ok());
    let last = "<node><instance_node url='#again'/></node>";
    for (old, new, parts) in [
        (
            "url='#cube'/",
            "url='#cup'/",
            ["line 23", "\"#cup\"", "no <geometry>"],
        ),
        (
            "url='#cube'/",
            "url='other.dae#cube'/",
            ["line 23", "other.dae#cube", "this file"],
        ),
        (
            "meter='1'",
            "meter='0'",
            ["line 3", "meter=\"0\"", "greater than 0"],
        ),
        (
            "1 0 1 1 1 1 0 1 1",
            "1 0 1 1 1",
            ["line 6", "20 numbers", "says 24"],
        ),
        (
            "1 0 1 1 1 1 0 1 1",
            "1 0 1 1 1 1 0 1 x",
            ["line 6", "\"x\"", "no number"],
        ),
        (
            "3 0 4 7</p>",
            "3 0 4 8</p>",
            ["line 12", "position 8", "there are 8"],
        ),
        (
            "3 0 4 7</p>",
            "3 0 4</p>",
            ["line 10", "too few corners", "cut short"],
        ),
        (
            "3 0 4 7</p>",
            "3 0 4 7 1</p>",
            ["line 10", "1 more corners", "cut short"],
        ),
        (
            "polylist count=\"6\"",
            "polylist count=\"7\"",
            ["line 10", "6 polygons", "says 7"],
        ),
        (
            "semantic=\"POSITION\" source=\"#corners\"",
            "semantic=\"NORMAL\"",
            ["line 9", "<vertices>", "POSITION"],
        ),
        (
            "<node><inst",
            "<node><skew>1 2</skew><inst",
            ["line 23", "<skew>", "before the export"],
        ),
        (
            "<node><inst",
            "<node><scale>1 2</scale><inst",
            ["line 23", "<scale> has 2 numbers", "3"],
        ),
        (
            "<node><inst",
            "<node><rotate>0 0 0 9</rotate><inst",
            ["line 23", "9 degrees", "length 0"],
        ),
        (
            "<node><inst",
            "<node><rotate>0 0 2 9</rotate><inst",
            ["line 23", "0 0 2", "unit vector"],
        ),
        (
            "instance_geometry url='#cube'",
            "instance_controller url='#x'",
            ["line 23", "skeleton", "armature"],
        ),
        (CUBE, last, ["line 23", "\"#again\"", "no <node>"]),
        (
            CUBE,
            "",
            ["shows no polygon", "<triangles>", "visual scene"],
        ),
        (
            "<node><inst",
            "<node id='me'><instance_node url='#me'/><inst",
            ["line 22", "64 deep", "itself"],
        ),
        (
            "url=\"#scene\"",
            "url=\"#set\"",
            ["line 24", "\"#set\"", "<visual_scene>"],
        ),
        ("</COLLADA>", "", ["not a DAE file", "", ""]),
        ("<COLLADA", "<COLLAGE", ["not a DAE file", "", ""]),
        (
            "<geometry id=\"tent\"><mesh>",
            "<geometry id=\"tent\"><spline>",
            ["not a DAE file", "", ""],
        ),
    ] {
        assert!(good.contains(old), "{old} is not in the file");
        let text = read(good.replace(old, new).as_bytes()).expect_err(new);
        assert!(
            parts.iter().all(|part| text.contains(part)),
            "{text:?} lacks one of {parts:?}"
        );
        assert!(!text.contains('\n'), "one line: {text:?}");
    }
    for kind in ["convex_mesh", "brep"] {
        let other = good
            .replace("<mesh>", &format!("<{kind}>"))
            .replace("</mesh>", &format!("</{kind}>"));
        let text = read(other.as_bytes()).unwrap_err();
        assert!(
            text.contains("line 5") && text.contains(&format!("\"cube\" is a <{kind}>")),
            "{text}"
        );
    }
    let misspelt = good.replace("polylist", "polylists");
    let text = read(misspelt.as_bytes()).unwrap_err();
    assert!(
        text.contains("line 10")
            && text.contains("<polylists>")
            && text.contains("polylist, polygons"),
        "{text}"
    );
    assert!(
        read(&[0xff, 0xfe, 0x3c, 0x00])
            .unwrap_err()
            .contains("not a DAE file")
    );
    assert!(
        read(&[b'<', 0xe9, b'>'])
            .unwrap_err()
            .contains("UTF-8, UTF-16 or ISO-8859-1")
    );
}

#[test]
fn what_shows_no_surface_is_passed_over_and_curves_are_counted() {
    let camera = "<node><lookat>1 2 3 0 0 0 0 0 1</lookat><instance_camera url='#c'/><instance_light url='#l'/></node>";
    let text = file(
        "",
        &format!("{camera}<node>{CUBE}<instance_geometry url='#curve'/></node>"),
    );
    let curve = "<geometry id='curve'><spline closed='1'/></geometry></library_geometries>";
    let text = text.replace("</library_geometries>", curve);
    let text = text.replace(
        "</polylist></mesh>",
        "</polylist><lines count='0'/><extra/></mesh>",
    );
    let mesh = mesh(&text);
    assert_eq!(mesh.triangles().len(), 12);
    let [only] = mesh.warnings() else {
        panic!("{:?}", mesh.warnings())
    };
    assert!(
        only.contains("cup.dae has 1 elements of lines, 1 splines; they have no surface"),
        "{only}"
    );
}

#[test]
fn other_encodings_prefixes_and_orders_of_axes_are_read() {
    let text = file("", &format!("<node>{CUBE}</node>"));
    let cube = |bytes: &[u8]| {
        mesh_file::read("cup.DAE", bytes, Vec3::ONE).unwrap_or_else(|error| panic!("{error}"))
    };
    let wanted = mesh(&text).hash();
    let declared = text.replace("utf-8", "utf-16");
    let little: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(declared.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    let big: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(declared.encode_utf16())
        .flat_map(u16::to_be_bytes)
        .collect();
    let named = text.replace("utf-8", "ISO-8859-1").replace(
        "<visual_scene id=\"other\">",
        "<visual_scene id=\"\u{e9}\">",
    );
    let latin: Vec<u8> = named
        .chars()
        .map(|letter| letter as u32 as u8)
        .collect();
    let prefixed = text
        .replace("xmlns=", "xmlns:c=")
        .replace("</", "\u{0}")
        .replace("<!--", "\u{1}")
        .replace("<?", "\u{2}");
    let prefixed = prefixed
        .replace('<', "<c:")
        .replace("\u{0}", "</c:")
        .replace("\u{1}", "<!--")
        .replace("\u{2}", "<?");
    let with_type = text.replace("?>", "?>\n<!DOCTYPE COLLADA [<!ENTITY one \"1\">]>");
    let blank = format!("\n \u{feff}{}", text.replace('\n', "\r\n")).replace("\n \u{feff}", "\n ");
    for bytes in [
        &little,
        &big,
        &latin,
        prefixed.as_bytes(),
        with_type.as_bytes(),
        blank.as_bytes(),
    ] {
        assert_eq!(cube(bytes).hash(), wanted);
    }
    let accessor = "<accessor source=\"#numbers\" count=\"8\" stride=\"3\"/>";
    assert!(text.contains(accessor));
    let turned = ["Z", "X", "Y"]
        .map(|axis| format!("<param name='{axis}' type='float'/>"))
        .concat();
    let text = text.replace(
        accessor,
        &format!("{}{turned}</accessor>", accessor.replace("/>", ">")),
    );
    let text = text
        .replace("0 0 0 1 0 0 1 1 0 0 1 0", "7 0 0 7 1 0 7 1 1 7 0 1")
        .replace(
            "0 0 1 <!-- the lid --> 1 0 1 1 1 1 0 1 1",
            "8 0 0 8 1 0 8 1 1 8 0 1",
        );
    assert_near(solid(&text), [0.0, 0.0, 7.0], [1.0, 1.0, 8.0], 1.0);
}

/// `0.1 + 1e-12` is another number than `0.1`, through the unit and the nodes.
#[test]
fn coordinates_are_f64_through_units_and_nodes() {
    let nodes =
        format!("<node><translate>400321.25 0 0</translate><scale>1e-9 1 1</scale>{CUBE}</node>");
    let mesh = mesh(&file("<unit meter='0.01'/>", &nodes));
    let most = mesh
        .vertices()
        .iter()
        .map(|vertex| vertex.x)
        .fold(f64::NEG_INFINITY, f64::max);
    assert!((most - 4003.2125 - 1e-11).abs() < 2e-12, "{most:.15}");
}

/// Ten nodes that each show the next one ten times would be 10¹⁰ cubes.
#[test]
fn nodes_that_multiply_each_other_end() {
    let level = |i: usize| {
        let next = if i == 9 {
            CUBE.to_owned()
        } else {
            format!("<instance_node url='#n{}'/>", i + 1)
        };
        format!("<node id='n{i}'>{}</node>", next.repeat(10))
    };
    let text = file("", &(0..10).map(level).collect::<String>());
    assert!(
        read(text.as_bytes())
            .unwrap_err()
            .contains("multiply each other")
    );
}

#[test]
fn triangles_that_are_missing_are_noticed() {
    let good = file("", "<node><instance_geometry url='#tent'/></node>");
    assert!(read(good.as_bytes()).is_ok());
    for (old, new, parts) in [
        (
            "triangles count=\"4\"",
            "triangles count=\"5\"",
            ["line 17", "4 triangles", "says 5"],
        ),
        (
            "2 0 1 0 2 0 3</p>",
            "2 0 1 0 2 0</p>",
            ["line 19", "23 indices", "2 a corner"],
        ),
        (
            "2 0 1 0 2 0 3</p>",
            "2 0 1 0 2</p>",
            ["line 17", "11 corners", "multiple of 3"],
        ),
        (
            "offset=\"1\"",
            "offset=\"x\"",
            ["line 18", "offset=\"x\"", "whole number"],
        ),
        (
            "semantic=\"VERTEX\" source=\"#tent",
            "semantic=\"TEXCOORD\" source=\"#tent",
            ["line 17", "<triangles>", "VERTEX"],
        ),
        (
            "0 3</p></triangles>",
            "0 3</p><ph/></triangles>",
            ["line 19", "holes", "triangles"],
        ),
    ] {
        assert!(good.contains(old), "{old} is not in the file");
        let text = read(good.replace(old, new).as_bytes()).expect_err(new);
        assert!(
            parts.iter().all(|part| text.contains(part)),
            "{text:?} lacks one of {parts:?}"
        );
    }
}
