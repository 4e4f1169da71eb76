//! STL files: dialects of the text, and what stands around the triangles of the binary.

use super::case::{Case, triangles};

type Face = [[f32; 3]; 3];

/// A corner of a box, turned outwards: no two of its coordinates are alike, so that nothing can be
/// mixed up.
const TETRA: [Face; 4] = {
    let o = [0.125, 0.25, 0.5];
    let x = [1.125, 0.25, 0.5];
    let y = [0.125, 0.75, 0.5];
    let z = [0.125, 0.25, 0.75];
    [[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
};

fn facet(face: &Face) -> String {
    let vertex = |[x, y, z]: &[f32; 3]| format!("      vertex {x} {y} {z}\n");
    let corners: String = face.iter().map(vertex).collect();
    format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
}

fn solid(name: &str, faces: &[Face]) -> String {
    format!(
        "solid {name}\n{}endsolid {name}\n",
        faces.iter().map(facet).collect::<String>()
    )
}

fn binary(header: &[u8], faces: &[Face], attribute: [u8; 2], normal: [f32; 3]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend(
            normal
                .iter()
                .chain(face.iter().flatten())
                .flat_map(|c| c.to_le_bytes()),
        );
        bytes.extend(attribute);
    }
    bytes
}

fn plain(faces: &[Face]) -> Vec<u8> {
    binary(b"", faces, [0; 2], [0.0; 3])
}

fn moved(change: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<Face> {
    TETRA
        .iter()
        .map(|face| face.map(&change))
        .collect()
}

fn with_count(count: u32) -> Vec<u8> {
    let mut bytes = plain(&TETRA);
    bytes[80..84].copy_from_slice(&count.to_le_bytes());
    bytes
}

fn with_tail(tail: &[u8]) -> Vec<u8> {
    [&plain(&TETRA), tail].concat()
}

fn ball() -> Vec<Face> {
    let ball = triangles::ball(0.5, 12, 24);
    ball.iter()
        .map(|face| face.map(|corner| corner.map(|c| c as f32)))
        .collect()
}

pub fn cases() -> Vec<Case> {
    let mut cases = dialects();
    cases.extend(words());
    cases.extend(binaries());
    cases.extend(numbers());
    cases
}

/// Blanks, letters and lines.
fn dialects() -> Vec<Case> {
    let text = solid("part", &TETRA);
    let case = |name: &str, text: String| Case::new(format!("stl/text_{name}.stl"), text);
    vec![
        case("plain", text.clone()),
        case(
            "tabs",
            text.replace("      ", "\t\t\t")
                .replace("  ", "\t"),
        ),
        case("no_indent", text.replace("  ", "")),
        case("crlf", text.replace('\n', "\r\n")),
        case("upper_case", text.to_uppercase()),
        case(
            "mixed_case",
            text.replace("facet", "Facet")
                .replace("vertex", "Vertex")
                .replace("solid", "SOLID"),
        ),
        case("blank_lines", text.replace('\n', "\n\n")),
        case("blank_line_first", format!("\n\n{text}")),
        case("blanks_first", format!("   {text}")),
        case("trailing_blanks", text.replace('\n', "   \n")),
        case("wide_blanks", text.replace("vertex ", "vertex    ")),
        case("no_last_newline", text.trim_end().to_owned()),
        case("bom", format!("\u{feff}{text}")),
        case("nul_at_end", format!("{text}\0\0")),
        case(
            "comma_free_exponents",
            text.replace("1.125", "+1.125E+00")
                .replace("0.25", "2.5e-1"),
        ),
        case(
            "bare_points",
            text.replace("0.125", ".125")
                .replace("0.5", "5.e-1"),
        ),
        case(
            "many_digits",
            text.replace("1.125", "1.12500000000000000000000000"),
        ),
    ]
}

/// Names, words and what is missing.
fn words() -> Vec<Case> {
    let text = solid("part", &TETRA);
    let case = |name: &str, text: String| Case::new(format!("stl/text_{name}.stl"), text);
    let two = solid("one", &TETRA[..2]) + &solid("two", &TETRA[2..]);
    let latin = [b"solid Tr\xe4ger\n".as_slice(), &text.as_bytes()[11..]].concat();
    vec![
        case("no_name", text.replace(" part", "")),
        case(
            "long_name",
            text.replace("part", "my part v2 (mm), by J. Doe; 2024-01-01"),
        ),
        case("name_facet", text.replace("part", "facet holder")),
        case("name_unicode", text.replace("part", "Träger ✓")),
        Case::new("stl/text_name_latin1.stl", latin),
        case(
            "other_end_name",
            text.replace("endsolid part", "endsolid something else"),
        ),
        case("no_endsolid", text.replace("endsolid part\n", "")).refused(
            &["cut short", "endsolid"],
            "whether a part is lost cannot be told",
        ),
        case("two_solids", two.clone()),
        case("two_solids_one_unnamed", two.replace(" two", "")),
        case(
            "empty_solid_first",
            format!("solid none\nendsolid none\n{text}"),
        ),
        case(
            "empty_solid_last",
            format!("{text}solid none\nendsolid none\n"),
        ),
        case(
            "nan_normals",
            text.replace("normal 0 0 0", "normal nan nan nan"),
        ),
        case(
            "minus_nan_normals",
            text.replace("normal 0 0 0", "normal -nan(ind) -nan(ind) -nan(ind)"),
        ),
        case(
            "msvc_nan_normals",
            text.replace("normal 0 0 0", "normal -1.#IND -1.#IND -1.#IND"),
        ),
        case(
            "wrong_normals",
            text.replace("normal 0 0 0", "normal 0 0 1"),
        ),
        case(
            "sliver",
            text.replacen(
                "endsolid",
                &(facet(&[[0.125, 0.25, 0.5]; 3]) + "endsolid"),
                1,
            ),
        ),
        case(
            "twice",
            text.replacen("endsolid", &(facet(&TETRA[0]) + "endsolid"), 1),
        ),
        case("open", solid("part", &TETRA[1..])),
        case("inwards", solid("part", &TETRA.map(|[a, b, c]| [a, c, b]))),
        case("ball", solid("ball", &ball())),
    ]
}

/// What stands around the triangles of a binary file.
fn binaries() -> Vec<Case> {
    let case = |name: &str, bytes: Vec<u8>| Case::new(format!("stl/binary_{name}.stl"), bytes);
    let header = |header: &[u8]| binary(header, &TETRA, [0; 2], [0.0; 3]);
    vec![
        case("plain", plain(&TETRA)),
        Case::new("stl/binary_upper.STL", plain(&TETRA)),
        case("header_solid", header(b"solid")),
        case("header_blanks", header(&[b' '; 80])),
        case("header_ones", header(&[0xff; 80])),
        case(
            "header_colour",
            header(b"COLOR=\x10\x20\x30\xff,MATERIAL=\x01\x02\x03\x04"),
        ),
        case("facet_colours", binary(b"", &TETRA, [0x1f, 0x80], [0.0; 3])),
        case(
            "attributes_ffff",
            binary(b"solid", &TETRA, [0xff, 0xff], [0.0; 3]),
        ),
        case("tail_newline", with_tail(b"\n")).read_as(
            "pymeshlab",
            "less than a triangle follows, so that none is lost",
        ),
        case("tail_crlf", with_tail(b"\r\n")).read_as(
            "pymeshlab",
            "less than a triangle follows, so that none is lost",
        ),
        case("tail_text", with_tail(b"end of file")).read_as(
            "pymeshlab",
            "less than a triangle follows, so that none is lost",
        ),
        case("more_than_counted", with_count(3)).refused(
            &["longer than it says", "3 triangles"],
            "either the count or the triangles are wrong",
        ),
        case("fewer_than_counted", with_count(5)).refused(
            &["cut short", "5 triangles need 334 bytes"],
            "a part is lost",
        ),
        case("count_0", with_count(0)).refused(
            &["longer than it says", "0 triangles"],
            "as with any wrong count",
        ),
        case("count_ffffffff", with_count(u32::MAX))
            .refused(&["cut short", "4294967295"], "as with any wrong count"),
    ]
}

/// Odd numbers of a binary file.
fn numbers() -> Vec<Case> {
    let case = |name: &str, bytes: Vec<u8>| Case::new(format!("stl/binary_{name}.stl"), bytes);
    let nan = f32::NAN;
    let slivers = [
        &TETRA[..],
        &[[[0.125, 0.25, 0.5], [0.625, 0.25, 0.5], [1.125, 0.25, 0.5]]],
    ]
    .concat();
    vec![
        case("nan_normals", binary(b"", &TETRA, [0; 2], [nan; 3])),
        case(
            "wrong_normals",
            binary(b"", &TETRA, [0; 2], [0.0, 0.0, 1.0]),
        ),
        case("huge_normals", binary(b"", &TETRA, [0; 2], [1e30; 3])),
        case(
            "minus_zero",
            plain(&moved(|[x, y, z]| {
                [if x == 0.125 { -0.0 } else { x }, y, z]
            })),
        ),
        case("tiny", plain(&moved(|c| c.map(|c| c * 1e-6)))),
        case("millimetres", plain(&moved(|c| c.map(|c| c * 1000.0)))),
        case(
            "far",
            plain(&moved(|[x, y, z]| [x + 4096.0, y - 8192.0, z])),
        ),
        case("mirrored", plain(&moved(|[x, y, z]| [-x, y, z]))),
        case("sliver", plain(&slivers)),
        case("open", plain(&TETRA[1..])),
        case("one_triangle", plain(&TETRA[..1])),
        case("twice", plain(&[TETRA, TETRA].concat())),
        case("ball", plain(&ball())),
        case(
            "nan_corner",
            plain(&moved(|[x, y, z]| [if x > 1.0 { nan } else { x }, y, z])),
        )
        .refused(&["vertex", "not finite"], "nobody knows where that is"),
        case(
            "infinite_corner",
            plain(&moved(|[x, y, z]| {
                [if x > 1.0 { f32::INFINITY } else { x }, y, z]
            })),
        )
        .refused(&["vertex", "not finite"], "nobody knows where that is"),
    ]
}
