//! Meshes of small cases, with the values that closed forms and other libraries give, in this
//! process and through a daemon; and one solid in every format.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::path::PathBuf;

use common::*;
use serde_json::Value;

/// Files of a case.
fn case(folder: &str, file: &str) -> String {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests", "cases", folder, file]
        .iter()
        .collect();
    path.to_str().unwrap().to_owned()
}

/// What `check` says of a path: in this process, and by a daemon that has robot and scene by name.
struct Answers {
    place: Place,
    _daemon: Daemon,
}

impl Answers {
    fn new() -> Self {
        let place = Place::new();
        let daemon = place.serve("");
        Self {
            place,
            _daemon: daemon,
        }
    }

    fn of(&self, folder: &str, path: &str, robot: &str, more: &[&str]) -> [Value; 2] {
        let path = case(folder, path);
        let robot = case(folder, robot);
        let more: Vec<String> = more
            .iter()
            .map(|word| {
                if word.contains('.') && !word.starts_with('0') {
                    case(folder, word)
                } else {
                    (*word).to_owned()
                }
            })
            .collect();
        let mut line = vec!["check", &path, "--robot", &robot, "--format", "json"];
        line.extend(more.iter().map(String::as_str));
        let by_daemon = self.place.taut(&line);
        line.push("--local");
        let here = self.place.taut(&line);
        assert_eq!(here.exit, by_daemon.exit, "{} {}", here.err, by_daemon.err);
        [here.json(), by_daemon.json()]
    }
}

fn number(value: &Value, pointer: &str) -> f64 {
    value
        .pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no {pointer} in {value}"))
}

fn assert_proved(answers: [Value; 2], nearest_m: Option<f64>) {
    for answer in answers {
        assert_eq!(answer["proved"], true, "{answer}");
        if let Some(wanted) = nearest_m {
            let found = number(&answer, "/smallest_clearance/amount");
            assert!((found - wanted).abs() < 1e-6, "{found} instead of {wanted}");
        }
    }
}

/// Depth of the collision at the ratio where it was seen.
fn depth(answer: &Value) -> (f64, f64) {
    assert_eq!(answer["reason"], "COLLISION", "{answer}");
    (-number(answer, "/amount"), number(answer, "/t"))
}

#[test]
fn a_mesh_far_from_its_origin_keeps_its_size() {
    for answer in Answers::new().of(
        "obj-far-from-origin",
        "through.csv",
        "probe.urdf",
        &["--scene", "obj.json"],
    ) {
        // From z = 0.5 down in a metre: the ball of 20 mm meets the cube's top at 0.17 m.
        let (depth, t) = depth(&answer);
        assert!((t - 0.31).abs() < 2e-3 && depth < 2e-3, "{depth} at {t}");
    }
}

#[test]
fn polygons_that_are_not_convex_are_what_they_outline() {
    let answers = Answers::new();
    for (path, wanted) in [
        ("notch.csv", 0.05),
        ("notch_z.csv", 0.13),
        ("notch_z2.csv", 0.05),
    ] {
        for scene in ["scene.json", "tri.json"] {
            let found = answers.of(
                "obj-concave",
                path,
                "probe.urdf",
                &["--scene", scene, "--clearance", "0.2"],
            );
            assert_proved(found, Some(wanted));
        }
    }
    for robot in ["pr_arrow.urdf", "pr_arrow1.urdf"] {
        assert_proved(
            answers.of("obj-concave", "p2.csv", robot, &["--srdf", "none.srdf"]),
            None,
        );
    }
}

#[test]
fn quads_that_are_bent_are_cut_the_same_way_in_every_format() {
    let answers = Answers::new();
    for robot in ["r_dae.urdf", "r_obj.urdf"] {
        let found = answers.of("dae-quads", "p.csv", robot, &["--clearance", "0.1"]);
        // The ball, 0.3 over the middle of a valley along the diagonal from the first corner.
        assert_proved(found, Some(0.3 / 1.5_f64.sqrt() - 0.05));
    }
}

#[test]
fn lines_of_an_obj_go_on_and_end_in_comments() {
    let answers = Answers::new();
    for scene in ["cont.json", "comment.json"] {
        assert_proved(
            answers.of("obj-lines", "near.csv", "probe.urdf", &["--scene", scene]),
            Some(0.003),
        );
    }
}

/// The bodies are at (0.1 + 0.01 t, 0.01, 0.02) of each other.
#[test]
fn meshes_are_as_deep_in_each_other_as_the_solids_that_they_are() {
    let answers = Answers::new();
    let seen = |robot: &str| {
        let [here, by_daemon] =
            answers.of("mesh-depth", "path.csv", robot, &["--srdf", "none.srdf"]);
        assert_eq!(depth(&here), depth(&by_daemon), "{robot}");
        depth(&here)
    };
    for robot in ["box.urdf", "cube.urdf"] {
        let (depth, t) = seen(robot);
        assert!(
            (depth - 0.1 + 0.01 * t).abs() < 1e-9,
            "{robot}: {depth} at {t}"
        );
    }
    let (depth, t) = seen("sphere.urdf");
    let exact =
        |t: f64| 0.2 - ((0.1 + 0.01 * t).powi(2) + 0.01_f64.powi(2) + 0.02_f64.powi(2)).sqrt();
    assert!((depth - exact(t)).abs() < 1e-9, "sphere: {depth} at {t}");
    // The facets of each ball are up to 1.53 mm inside of the sphere.
    let (depth, t) = seen("ball.urdf");
    assert!(
        depth < exact(t) && depth > exact(t) - 2.0 * 1.53e-3,
        "ball: {depth} at {t}"
    );
    assert!(
        (depth - 0.094_810_4).abs() < 2e-5,
        "along the facet that is left first: {depth}"
    );
}

/// Writes one solid in every format; what is said of each must be the same, to the last bit where
/// the numbers are.
#[test]
fn one_solid_in_every_format_gives_one_answer() {
    let place = Place::new();
    let mut rng = fastrand::Rng::with_seed(21);
    let robot = case("obj-concave", "probe.urdf");
    for round in 0..8 {
        let solid = Prism::random(&mut rng);
        fs::write(place.folder.path().join("s.STL"), solid.text_stl()).unwrap();
        fs::write(place.folder.path().join("b.stl"), solid.binary_stl()).unwrap();
        place.file("s.obj", &solid.obj());
        place.file("s.Dae", &solid.dae());
        let path = place.file(
            "p.csv",
            &format!("x,y,z\n0,0,{0}\n0.05,0,{0}\n", solid.height + 0.2),
        );
        let distance = |file: &str| {
            let scene = format!(
                r#"{{"name": "s", "objects": [{{"id": "prism", "meshes": [{{"file": "{file}"}}], "mesh_poses": [{{"position": [0, 0, 0], "orientation": {{"x": 0, "y": 0, "z": 0, "w": 1}}}}]}}]}}"#
            );
            let scene = place.file(&format!("{file}.json"), &scene);
            let line = [
                "check",
                &path,
                "--robot",
                &robot,
                "--scene",
                &scene,
                "--clearance",
                "0.3",
                "--local",
                "--format",
                "json",
            ];
            let run = place.taut(&line);
            assert_eq!(
                run.exit, 0,
                "round {round}, {file}: {} {}",
                run.out, run.err
            );
            assert!(!run.err.contains("mesh "), "{}", run.err);
            number(&run.json(), "/smallest_clearance/amount")
        };
        let obj = distance("s.obj");
        for (file, tolerance) in [("s.STL", 1e-12), ("s.Dae", 1e-12), ("b.stl", 1e-6)] {
            assert!(
                (distance(file) - obj).abs() < tolerance,
                "round {round}: {file}"
            );
        }
    }
}

/// A star-shaped outline, mostly not convex, drawn out upwards.
struct Prism {
    outline: Vec<[f64; 2]>,
    height: f64,
}

impl Prism {
    fn random(rng: &mut fastrand::Rng) -> Self {
        let count = rng.usize(5..10);
        let corner = |i: usize| {
            let (sine, cosine) = (std::f64::consts::TAU * i as f64 / count as f64).sin_cos();
            let radius = 0.1 + 0.2 * rng.f64();
            [radius * cosine, radius * sine]
        };
        Self {
            outline: (0..count).map(corner).collect(),
            height: 0.1 + 0.1 * rng.f64(),
        }
    }

    fn corners(&self) -> Vec<[f64; 3]> {
        let at = |z: f64| {
            self.outline
                .iter()
                .map(move |[x, y]| [*x, *y, z])
        };
        at(0.0).chain(at(self.height)).collect()
    }

    /// Faces as polygons.
    fn faces(&self) -> Vec<Vec<usize>> {
        let count = self.outline.len();
        let wall = |i: usize| vec![i, (i + 1) % count, count + (i + 1) % count, count + i];
        let mut faces: Vec<Vec<usize>> = (0..count).map(wall).collect();
        faces.extend([(0..count).rev().collect(), (count..2 * count).collect()]);
        faces
    }

    /// Triangles from the middle of each end, which a star-shaped outline has inside.
    fn triangles(&self) -> Vec<[[f64; 3]; 3]> {
        let corners = self.corners();
        let count = self.outline.len();
        (0..count)
            .flat_map(|i| {
                let next = (i + 1) % count;
                let [a, b, c, d] = [i, next, count + next, count + i].map(|at| corners[at]);
                [
                    [a, b, c],
                    [a, c, d],
                    [[0.0, 0.0, 0.0], b, a],
                    [[0.0, 0.0, self.height], d, c],
                ]
            })
            .collect()
    }

    fn text_stl(&self) -> String {
        let facet = |corners: &[[f64; 3]; 3]| {
            let vertices = corners
                .map(|[x, y, z]| format!("    vertex {x:e} {y:e} {z:e}\n"))
                .concat();
            format!("  facet normal 0 0 0\n   outer loop\n{vertices}   endloop\n  endfacet\n")
        };
        format!(
            "solid prism\n{}endsolid prism\n",
            self.triangles()
                .iter()
                .map(facet)
                .collect::<String>()
        )
    }

    fn binary_stl(&self) -> Vec<u8> {
        let triangles = self.triangles();
        let mut bytes = b"solid but binary".to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for corners in &triangles {
            bytes.extend([0; 12]);
            bytes.extend(
                corners
                    .iter()
                    .flatten()
                    .flat_map(|c| (*c as f32).to_le_bytes()),
            );
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn obj(&self) -> String {
        let vertices: String = self
            .corners()
            .iter()
            .map(|[x, y, z]| format!("v {x} {y} {z}\n"))
            .collect();
        let face = |face: &Vec<usize>| {
            face.iter()
                .fold("f".to_owned(), |line, i| format!("{line} {}", i + 1))
                + "\n"
        };
        vertices
            + &self
                .faces()
                .iter()
                .map(face)
                .collect::<String>()
    }

    /// In centimetres, turned a quarter about z and back by its node.
    fn dae(&self) -> String {
        let numbers: Vec<String> = self
            .corners()
            .iter()
            .map(|[x, y, z]| format!("{} {} {}", 100.0 * y, -100.0 * x, 100.0 * z))
            .collect();
        let faces = self.faces();
        let counts: Vec<String> = faces
            .iter()
            .map(|face| face.len().to_string())
            .collect();
        let corners: Vec<String> = faces
            .iter()
            .flatten()
            .map(usize::to_string)
            .collect();
        format!(
            r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{}">{}</float_array></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="{}"><input semantic="VERTEX" source="#v" offset="0"/><vcount>{}</vcount><p>{}</p></polylist>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">
<node><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
            3 * numbers.len(),
            numbers.join(" "),
            faces.len(),
            counts.join(" "),
            corners.join(" ")
        )
    }
}
