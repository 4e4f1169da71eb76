//! OBJ files: indices, lines, polygons, and what is no surface.

use super::case::Case;

/// A box of 1 × 0.5 × 0.25 m away from the origin, of quads.
const VERTICES: &str = "v 0.125 0.25 0.5\nv 1.125 0.25 0.5\nv 1.125 0.75 0.5\nv 0.125 0.75 0.5\n\
    v 0.125 0.25 0.75\nv 1.125 0.25 0.75\nv 1.125 0.75 0.75\nv 0.125 0.75 0.75\n";
const QUADS: [[i32; 4]; 6] = [
    [1, 4, 3, 2],
    [5, 6, 7, 8],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 4, 8, 7],
    [4, 1, 5, 8],
];

/// The faces with each corner written by `corner`.
fn faces(corner: impl Fn(i32) -> String) -> String {
    QUADS
        .iter()
        .map(|quad| format!("f {}\n", quad.map(&corner).join(" ")))
        .collect()
}

fn cuboid() -> String {
    VERTICES.to_owned() + &faces(|i| i.to_string())
}

fn case(name: &str, text: impl Into<Vec<u8>>) -> Case {
    Case::new(format!("obj/{name}.obj"), text)
}

pub fn cases() -> Vec<Case> {
    let mut cases = indices();
    cases.extend(lines());
    cases.extend(numbers());
    cases.extend(others());
    cases.extend(polygons());
    cases.extend(refused());
    cases
}

/// How corners may be named.
fn indices() -> Vec<Case> {
    let normals = "vn 0 0 1\nvn 0 1 0\nvt 0 0\nvt 1 0 0.5\n";
    let with = |corner: fn(i32) -> String| VERTICES.to_owned() + normals + &faces(corner);
    let triangles: String = QUADS
        .iter()
        .map(|[a, b, c, d]| format!("f {a} {b} {c}\nf {a} {c} {d}\n"))
        .collect();
    let alone: String = QUADS
        .iter()
        .map(|quad| {
            let own = quad.map(|i| {
                VERTICES
                    .lines()
                    .nth(i as usize - 1)
                    .unwrap_or_default()
            });
            format!("{}\nf -4 -3 -2 -1\n", own.join("\n"))
        })
        .collect();
    let mixed = cuboid()
        .replacen("f 1 4 3 2", "f 1//1 4//1 3//1 2//1", 1)
        .replacen("f 5 6 7 8", "f 5/1 6/2 7/1 8/2", 1);
    vec![
        case("quads", cuboid()),
        case("triangles", VERTICES.to_owned() + &triangles),
        case("with_normals", with(|i| format!("{i}//{}", i % 2 + 1))),
        case("with_textures", with(|i| format!("{i}/{}", i % 2 + 1))),
        case("with_both", with(|i| format!("{i}/{}/{}", i % 2 + 1, 1))),
        case(
            "negative",
            VERTICES.to_owned() + &faces(|i| (i - 9).to_string()),
        ),
        case("negative_with_normals", with(|i| format!("{}//-1", i - 9))),
        case("negative_with_both", with(|i| format!("{}/-2/-1", i - 9))),
        case("negative_nearby", alone),
        case(
            "mixed_corners",
            mixed.replacen("f ", &format!("{normals}f "), 1),
        ),
        case("trailing_slash", with(|i| format!("{i}/"))),
        case("trailing_slashes", with(|i| format!("{i}//"))),
        case("texture_and_slash", with(|i| format!("{i}/1/"))),
        case("faces_first", faces(|i| i.to_string()) + VERTICES),
        case(
            "leading_zeros",
            VERTICES.to_owned() + &faces(|i| format!("00{i}")),
        ),
        case(
            "plus_signs",
            VERTICES.to_owned() + &faces(|i| format!("+{i}")),
        ),
    ]
}

/// Blanks, ends of lines and comments.
fn lines() -> Vec<Case> {
    let text = cuboid();
    let halves = |end: &str| {
        VERTICES.to_owned() + &faces(|i| i.to_string()).replace(" 3", &format!(" \\{end}3"))
    };
    let latin = [
        b"# Entwurf: Tr\xe4ger\no Tr\xe4ger\n".as_slice(),
        text.as_bytes(),
    ]
    .concat();
    vec![
        case("crlf", text.replace('\n', "\r\n")),
        case("cr_only", text.replace('\n', "\r"))
            .refused(&["line 1"], "no system writes such lines any more"),
        case("tabs", text.replace(' ', "\t")),
        case("wide_blanks", text.replace(' ', "   ")),
        case("trailing_blanks", text.replace('\n', "  \n")),
        case(
            "leading_blanks",
            format!("  {}", text.trim_end().replace('\n', "\n  ")),
        ),
        case("blank_lines", text.replace('\n', "\n\n \n")),
        case("no_last_newline", text.trim_end().to_owned()),
        case("continued_face", halves("\n")),
        case(
            "continued_face_crlf",
            halves("\r\n")
                .replace("\r\n", "\n")
                .replace('\n', "\r\n"),
        ),
        case(
            "continued_vertex",
            text.replace("0.25 0.75\n", "0.25 \\\n 0.75\n"),
        ),
        case("continued_comment", format!("# a comment \\\n{text}")),
        case(
            "comments",
            format!(
                "# Träger ✓\n#\n##\n{}",
                text.replace("f 5", "# f 1 2 3\nf 5")
            ),
        ),
        case("comment_behind_faces", text.replace("\nf", " # note\nf"))
            .read_as("coal", "a comment says nothing"),
        case(
            "comment_behind_vertices",
            text.replace("0.75\n", "0.75 # 3 of them\n"),
        ),
        case("comment_without_blank", text.replace("3 2\n", "3 2#note\n")),
        case("bom", format!("\u{feff}{text}"))
            .read_as("coal", "the mark says how letters are written"),
        case("latin1", latin),
    ]
}

/// Numbers and what stands behind them.
fn numbers() -> Vec<Case> {
    let text = cuboid();
    let behind = |more: &str| {
        text.lines()
            .map(|line| match line.starts_with('v') {
                true => format!("{line}{more}\n"),
                false => format!("{line}\n"),
            })
            .collect::<String>()
    };
    let far = |x: f64| {
        text.replace("v 0.125", &format!("v {}", x + 0.125))
            .replace("v 1.125", &format!("v {}", x + 1.125))
    };
    vec![
        case(
            "exponents",
            text.replace("1.125", "+1125.0E-3")
                .replace("0.25", "2.5e-1"),
        ),
        case(
            "bare_points",
            text.replace("0.5", ".5")
                .replace("1.125", "1125.e-3"),
        ),
        case(
            "whole_numbers",
            text.replace("0.125", "0").replace("1.125", "1"),
        ),
        case(
            "many_digits",
            text.replace("0.125", "0.12500000000000000000000000000001"),
        ),
        case("colours", behind(" 0.2 0.4 0.6")),
        case("colours_of_bytes", behind(" 255 128 0")),
        case("w_1", behind(" 1.0")),
        case("w_2", behind(" 2.0")).refused(&["line 1"], "assimp divides by it, others do not"),
        case("far_1000", far(1e3)),
        case("far_100000", far(1e5)),
        case("far_10000000", far(1e7)),
        case("millimetres", text.replace("0.", "0").replace("1.", "1")),
        case("minus_zero", text.replace("v 0.125", "v -0.0")),
        case("nan_normals", text.replacen("f ", "vn nan nan nan\nf ", 1)),
    ]
}

/// Lines that are no part of the surface.
fn others() -> Vec<Case> {
    let text = cuboid();
    let before = |more: &str| text.replacen("f ", &format!("{more}\nf "), 1);
    let between = |more: &str| text.replace("f 1 2", &format!("{more}\nf 1 2"));
    let curve = "vp 0.1\nvp 0.9\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend";
    vec![
        case("groups", before("g upper lower").replace("f 5", "g\nf 5")),
        case("objects", before("o one").replace("f 5", "o two\nf 5")),
        case(
            "missing_material",
            format!("mtllib not there.mtl\n{}", between("usemtl steel")),
        ),
        case(
            "two_materials",
            between("usemtl steel").replacen("f ", "usemtl paint\nf ", 1),
        ),
        case(
            "material_of_each_face",
            text.replace("f ", "usemtl m\nf ")
                .replacen("usemtl m", "usemtl first", 3),
        ),
        case("smoothing", before("s off").replace("f 5", "s 1\nf 5")),
        case("edges", between("l 1 2 3\nl 4/1 5/1\nvt 0 0")),
        case("points", between("p 1 2 3")),
        case("curve", before(curve)).refused(
            &["line 13", "curv"],
            "a curve may bound a surface that is not read",
        ),
        case(
            "unknown_words",
            before("shadow_obj x.obj\nlod 3\nbevel on\nc_interp off"),
        ),
        case("unused_vertices", before("v 50 60 70\nv -50 -60 -70")),
        case("doubled_face", text.clone() + "f 5 6 7 8\n"),
        case("repeated_corner", text.replace("f 5 6 7 8", "f 5 6 6 7 8")),
        case("closed_polygon", text.replace("f 5 6 7 8", "f 5 6 7 8 5")),
        case("face_of_two", before("f 1 2")),
        case("face_of_one", before("f 1")),
        case("empty_group", text.clone() + "g nothing\no nothing\n"),
        case("open", text.replace("f 5 6 7 8\n", "")),
        case(
            "inwards",
            VERTICES.to_owned()
                + &QUADS
                    .map(|[a, b, c, d]| format!("f {d} {c} {b} {a}\n"))
                    .concat(),
        ),
        case("quads_as_fo", text.replace("f ", "fo "))
            .read_as("coal", "the old word for a face means a face"),
    ]
}

/// A prism over an outline, its ends as one polygon each that starts at corner `first`.
fn prism(outline: &[[f64; 2]], first: usize) -> String {
    let n = outline.len();
    let at = |z: f64| {
        outline
            .iter()
            .map(move |[x, y]| format!("v {x} {y} {z}\n"))
    };
    let corner = |i: usize| (first + i) % n + 1;
    let lower: Vec<String> = (0..n)
        .rev()
        .map(|i| corner(i).to_string())
        .collect();
    let upper: Vec<String> = (0..n)
        .map(|i| (corner(i) + n).to_string())
        .collect();
    let side = |i: usize| {
        format!(
            "f {} {} {} {}\n",
            i + 1,
            (i + 1) % n + 1,
            (i + 1) % n + 1 + n,
            i + 1 + n
        )
    };
    let sides: String = (0..n).map(side).collect();
    let ends = format!("f {}\nf {}\n", lower.join(" "), upper.join(" "));
    at(0.0).chain(at(0.25)).collect::<String>() + &ends + &sides
}

fn star(points: usize) -> Vec<[f64; 2]> {
    let corner = |i: usize| {
        let angle = std::f64::consts::PI * i as f64 / points as f64;
        let radius = if i.is_multiple_of(2) { 1.0 } else { 0.5 };
        [radius * angle.cos(), radius * angle.sin()].map(|c| (c * 4096.0).round() / 4096.0)
    };
    (0..2 * points).map(corner).collect()
}

/// Faces that are no triangles.
fn polygons() -> Vec<Case> {
    let l = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 0.5],
        [0.5, 0.5],
        [0.5, 2.0],
        [0.0, 2.0],
    ];
    let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
    let comb = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 2.0],
        [3.0, 2.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let edge = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
    // Around a hole and back through the same slit.
    let slit = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ];
    let bent = cuboid().replace("v 0.125 0.75 0.75", "v 0.125 0.75 1.0");
    let turned = bent.replace("f 5 6 7 8", "f 6 7 8 5");
    let why = "a concave polygon is what its outline holds; a fan covers the notch";
    vec![
        case(
            "octagon",
            prism(
                &star(8)
                    .into_iter()
                    .step_by(2)
                    .collect::<Vec<_>>(),
                0,
            ),
        ),
        case(
            "hundred_corners",
            prism(
                &star(100)
                    .into_iter()
                    .step_by(2)
                    .collect::<Vec<_>>(),
                0,
            ),
        ),
        case("l_shape", prism(&l, 0)),
        case("l_shape_other_corner", prism(&l, 3)).read_as("coal", why),
        case("arrow", prism(&arrow, 0)).read_as("coal", why),
        case("arrow_other_corner", prism(&arrow, 3)).read_as("coal", why),
        case("comb", prism(&comb, 0)).read_as("coal", why),
        case("comb_other_corner", prism(&comb, 4)).read_as("coal", why),
        case("star", prism(&star(5), 0)).read_as("coal", why),
        case("star_other_corner", prism(&star(5), 1)).read_as("coal", why),
        case("corner_on_edge", prism(&edge, 0)),
        case("corner_on_edge_first", prism(&edge, 1)),
        case("slit_to_hole", prism(&slit, 0)).read_as("coal", why),
        case("bent_quad", bent),
        case("bent_quad_other_corner", turned),
    ]
}

fn refused() -> Vec<Case> {
    let text = cuboid();
    let odd =
        |name: &str, old: &str, new: &str, parts: &'static [&'static str], why: &'static str| {
            case(name, text.replace(old, new)).refused(parts, why)
        };
    let nowhere = "nobody knows where that is";
    vec![
        odd(
            "index_0",
            "f 5 6",
            "f 0 6",
            &["line 10"],
            "corners count from 1",
        ),
        odd(
            "index_beyond",
            "f 5 6",
            "f 5 9",
            &["vertex 9", "8"],
            "there is no such corner",
        ),
        odd(
            "index_far_back",
            "f 5 6",
            "f 5 -9",
            &["line 10"],
            "there is no such corner",
        ),
        odd(
            "nan_vertex",
            "v 1.125 0.75 0.75",
            "v nan 0.75 0.75",
            &["vertex 6", "not finite"],
            nowhere,
        ),
        odd(
            "infinite_vertex",
            "v 1.125 0.75 0.75",
            "v inf 0.75 0.75",
            &["vertex 6", "not finite"],
            nowhere,
        ),
        odd(
            "two_numbers",
            "v 1.125 0.75 0.75",
            "v 1.125 0.75",
            &["line 7"],
            nowhere,
        ),
        odd(
            "decimal_comma",
            "v 1.125 0.75 0.75",
            "v 1,125 0,75 0,75",
            &["line 7"],
            nowhere,
        ),
        case("no_face", VERTICES).refused(&["no triangle with an area"], "it is no solid"),
        case("only_edges", VERTICES.to_owned() + "l 1 2 3 4\n")
            .refused(&["no triangle with an area"], "it is no solid"),
    ]
}
