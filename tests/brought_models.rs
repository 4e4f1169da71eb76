//! Models as people bring them: MoveIt's scenes, DAE meshes, odd meshes, a robot without an SRDF.
#![cfg(feature = "daemon")]

mod common;

use common::*;

/// An arm of three links, of which the middle one is a DAE in centimetres; where all joints are at
/// 0 the hand is in the base, which no joint of its own connects to it.
const ARM: &str = "<robot name='folded'>
    <link name='base'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>
    <link name='arm'><collision><geometry><mesh filename='tent.dae'/></geometry></collision></link>
    <link name='hand'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>
    <joint name='lift' type='prismatic'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>
        <limit lower='0' upper='3'/></joint>
    <joint name='turn' type='revolute'><parent link='arm'/><child link='hand'/><axis xyz='0 0 1'/>
        <limit lower='-1' upper='1'/></joint></robot>";

const TENT: &str = r##"<COLLADA version="1.4.1"><asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>
    <library_geometries><geometry id="tent"><mesh>
    <source id="tips"><float_array id="numbers" count="12">0 0 0 10 0 0 0 10 0 0 0 10</float_array></source>
    <vertices id="vertices"><input semantic="POSITION" source="#tips"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#vertices" offset="0"/>
    <p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry></library_geometries>
    <library_visual_scenes><visual_scene id="scene"><node><instance_geometry url="#tent"/></node></visual_scene>
    </library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>"##;

/// A ball beside the arm's way, and a sheet in millimetres that no path comes near.
const CELL: &str = "our cell\n* ball\n0.5 0 1\n0 0 0 1\n1\nsphere\n0.1\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n\
    * sheet\n0 0 -300\n0 0 0 1\n1\nmesh\n3 1\n0 0 0\n80 0 0\n0 60 0\n0 1 2\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n";

const ADVICE: &str =
    "base × hand collide with every joint at 0 and are apart in other configurations";
const LINE: &str = r#"<disable_collisions link1="base" link2="hand" reason="User"/>"#;

struct Brought {
    place: Place,
    arm: String,
    cell: String,
    path: String,
}

fn brought() -> Brought {
    let place = Place::new();
    place.file("tent.dae", TENT);
    let arm = place.file("arm.urdf", ARM);
    let cell = place.file("cell.scene", CELL);
    let path = place.file("path.csv", "lift,turn\n1,0\n2,0.5\n");
    Brought {
        place,
        arm,
        cell,
        path,
    }
}

fn assert_warned(err: &str, parts: &[&str]) {
    for part in parts {
        let times = err
            .lines()
            .filter(|line| line.starts_with("warning: ") && line.contains(part))
            .count();
        assert_eq!(times, 1, "{part:?} must be told once: {err}");
    }
}

#[test]
fn a_path_is_checked_in_a_moveit_scene_and_what_is_odd_is_told_once() {
    let Brought {
        place,
        arm,
        cell,
        path,
    } = brought();
    let run = place.taut(&["check", &path, "--local", "--robot", &arm, "--scene", &cell]);
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    // The arm's tip at x = 0.1 and z = 1 is nearest to the ball: 0.5 - 0.1 - 0.1.
    assert!(run.out.starts_with("proved   clearance ≥ "), "{}", run.out);
    let oddities = [
        ADVICE,
        "80.0 × 60.0 × 0.000 m large",
        "3 of 3 edges are open",
    ];
    assert_warned(&run.err, &oddities);
    let hit = place.file("hit.csv", "lift,turn\n1,0\n3,0\n");
    let at_ball = place.file("near.scene", &CELL.replace("0.5 0 1", "0.1 0 1.5"));
    let run = place.taut(&[
        "check", &hit, "--local", "--robot", &arm, "--scene", &at_ball,
    ]);
    assert!(
        run.exit == 1 && run.out.contains("arm × ball"),
        "{} {}",
        run.out,
        run.err
    );

    // Naming the pair has not allowed it: the path through 0 collides until the line stands in the
    // SRDF.
    let down = place.file("down.csv", "lift,turn\n1,0\n0,0\n");
    let run = place.taut(&["check", &down, "--local", "--robot", &arm]);
    assert!(
        run.exit == 1 && run.out.contains("base × hand"),
        "{} {}",
        run.out,
        run.err
    );
    let pairs = LINE.to_owned() + &LINE.replace("hand", "arm") + &LINE.replace("base", "arm");
    place.file("arm.srdf", &format!("<robot name='folded'>{pairs}</robot>"));
    let run = place.taut(&["check", &down, "--local", "--robot", &arm]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""), "{}", run.out);
}

#[test]
fn the_daemon_takes_the_same_models_and_tells_the_same() {
    let Brought {
        place,
        arm,
        cell,
        path,
    } = brought();
    let _daemon = place.serve("");
    let run = place.taut(&["load-robot", "folded", "--urdf", &arm]);
    assert_eq!(run.exit, 0, "{}", run.err);
    assert_warned(&run.err, &[ADVICE]);
    let run = place.taut(&["load-scene", "cell", &cell]);
    assert!(
        run.exit == 0 && run.out.contains("2 objects"),
        "{} {}",
        run.out,
        run.err
    );
    assert_warned(
        &run.err,
        &["80.0 × 60.0 × 0.000 m large", "3 of 3 edges are open"],
    );
    for (robot, scene) in [("folded", "cell"), (arm.as_str(), cell.as_str())] {
        let run = place.taut(&["check", &path, "--robot", robot, "--scene", scene]);
        assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
        assert_warned(&run.err, &[ADVICE, "80.0 × 60.0 × 0.000 m large"]);
    }
    let cone = place.file("cone.scene", &CELL.replace("sphere\n0.1", "cone\n0.1 0.1"));
    let run = place.taut(&["load-scene", "cone", &cone]);
    assert_eq!(run.exit, 65, "{}", run.err);
    assert!(
        run.err.contains("line 6") && run.err.contains("\"ball\" has a cone"),
        "{}",
        run.err
    );
}
