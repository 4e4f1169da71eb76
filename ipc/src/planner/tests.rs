use super::*;
use crate::control::{GroupDescription, RobotDescription, VariableDescription};
use crate::wire::Code;

fn names(names: &[&str]) -> Vec<String> {
    names
        .iter()
        .map(|name| (*name).to_owned())
        .collect()
}

fn held(pairs: &[(&str, f64)]) -> Vec<(String, f64)> {
    pairs
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value))
        .collect()
}

const ROBOT: [&str; 3] = ["a", "b", "c"];

fn message(error: PlannerError, code: Code) -> String {
    assert_eq!(error.code(), code, "{error}");
    error.to_string()
}

#[test]
fn columns_without_names_are_the_robots() {
    let columns = Columns::new(&variables(), &[], &[]).unwrap();
    assert!(columns.are_the_robots());
    let rows = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let mut robot = [0.0; 6];
    let mut back = [0.0; 6];
    columns.write(&rows, &mut robot);
    columns.read(&robot, &mut back);
    assert_eq!((robot, back), (rows, rows));
}

#[test]
fn columns_in_another_order_are_the_robots_inside_and_the_callers_outside() {
    let columns = Columns::new(&variables(), &names(&["c", "a", "b"]), &[]).unwrap();
    assert_eq!((columns.are_the_robots(), columns.stretch()), (false, None));
    let rows = [3.0, 1.0, 2.0, 6.0, 4.0, 5.0];
    let mut robot = [0.0; 6];
    let mut back = [0.0; 6];
    columns.write(&rows, &mut robot);
    assert_eq!(robot, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    columns.read(&robot, &mut back);
    assert_eq!(back, rows);
}

#[test]
fn missing_columns_are_held_and_stand_still() {
    let columns = Columns::new(&variables(), &names(&["b", "c"]), &held(&[("a", 7.0)])).unwrap();
    assert_eq!(
        (columns.stretch(), columns.given()),
        (Some(1), vec![0, 1, 1])
    );
    let mut robot = [0.0; 6];
    let mut back = [0.0; 4];
    columns.write(&[1.0, 2.0, 3.0, 4.0], &mut robot);
    assert_eq!(robot, [7.0, 1.0, 2.0, 7.0, 3.0, 4.0]);
    columns.read(&robot, &mut back);
    assert_eq!(back, [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn columns_that_are_none_are_refused_with_the_valid_ones() {
    let code = Code::InvalidRobotState;
    let unknown = message(
        Columns::new(&variables(), &names(&["a", "x", "c"]), &[]).unwrap_err(),
        code,
    );
    assert_eq!(unknown, r#""x" is no column of the robot; valid: a, b, c"#);
    let twice = message(
        Columns::new(&variables(), &names(&["a", "a", "c"]), &[]).unwrap_err(),
        code,
    );
    assert!(twice.contains(r#""a" is there twice"#), "{twice}");
}

#[test]
fn what_nobody_holds_stands_at_zero_and_the_answer_says_so() {
    let columns = Columns::new(&variables(), &names(&["b"]), &held(&[("a", 7.0)])).unwrap();
    let mut robot = [1.0; 3];
    columns.write(&[2.0], &mut robot);
    assert_eq!((robot, columns.given()), ([7.0, 2.0, 0.0], vec![0, 1, 0]));
    assert_eq!(
        columns.note().unwrap(),
        "the path has no column for c: held still at 0"
    );
    let whole = Columns::new(&variables(), &names(&["c", "b"]), &held(&[("a", 7.0)])).unwrap();
    assert_eq!(whole.note(), None);

    let mut bounded = variables();
    bounded[0].lower = 0.5;
    bounded[0].upper = 2.0;
    let code = Code::InvalidRobotState;
    let text = message(
        Columns::new(&bounded, &names(&["b", "c"]), &[]).unwrap_err(),
        code,
    );
    assert!(
        text.contains(r#""a" is missing"#)
            && text.contains("cannot be held at 0, outside [0.5, 2]"),
        "{text}"
    );
    assert!(Columns::new(&bounded, &names(&["b", "c"]), &held(&[("a", 1.0)])).is_ok());
}

#[test]
fn a_floating_joint_is_held_without_a_turn_and_never_in_part() {
    let parts = [
        "trans_x", "trans_y", "trans_z", "rot_x", "rot_y", "rot_z", "rot_w",
    ];
    let part = |(index, part): (u32, &&str)| VariableDescription {
        name: format!("base/{part}"),
        lower: if index < 3 { f64::NEG_INFINITY } else { -1.0 },
        upper: if index < 3 { f64::INFINITY } else { 1.0 },
        coordinate: index.min(3),
        coordinates: if index < 3 { 1 } else { 3 },
        ..VariableDescription::default()
    };
    let mut variables: Vec<VariableDescription> = (0..).zip(&parts).map(part).collect();
    variables.extend(self::variables());
    let columns = Columns::new(
        &variables,
        &names(&["a", "b", "c"]),
        &held(&[("base/trans_z", 0.3)]),
    )
    .unwrap();
    let mut robot = [9.0; 10];
    columns.write(&[1.0, 2.0, 3.0], &mut robot);
    assert_eq!(robot, [0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0]);
    assert!(!columns.note().unwrap().contains("trans_z"));
    let code = Code::InvalidRobotState;
    let text = message(
        Columns::new(&variables, &names(&["base/trans_x", "a"]), &[]).unwrap_err(),
        code,
    );
    assert!(
        text.contains(r#""base/trans_y" is missing, "base/trans_x" of the same joint"#),
        "{text}"
    );
}

fn variables() -> Vec<VariableDescription> {
    let variable = |(index, name): (u32, &&str)| VariableDescription {
        name: (*name).to_owned(),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        coordinate: index,
        coordinates: 1,
        ..VariableDescription::default()
    };
    (0..).zip(&ROBOT).map(variable).collect()
}

fn robot() -> RobotDescription {
    RobotDescription {
        variables: variables(),
        held_variables: names(&["torso"]),
        held_values: vec![0.5],
        groups: vec![GroupDescription {
            name: "arm".to_owned(),
            variables: vec![1, 2],
        }],
        nq: 3,
        nv: 3,
        weights: vec![1.0, 2.0, 3.0],
        ..RobotDescription::default()
    }
}

fn refused(request: &Request) -> (Code, String) {
    let robot = robot();
    let columns = request.columns_of(&robot).unwrap();
    let error = request
        .sections(&robot, &columns, 4)
        .err()
        .expect("refused");
    (error.code(), error.to_string())
}

#[test]
fn names_of_a_request_are_looked_up() {
    let base = || Request::new("r", None);
    let weights = Request {
        joint_weights: held(&[("b", 9.0)]),
        ..base()
    }
    .weights(&robot())
    .unwrap();
    assert_eq!(weights, [1.0, 9.0, 3.0]);
    let (code, text) = refused(&Request {
        group: Some("leg".to_owned()),
        ..base()
    });
    assert_eq!(
        (code, text.as_str()),
        (
            Code::InvalidGroupName,
            r#""leg" is no group of the robot; valid: arm"#
        )
    );
    let (_, text) = refused(&Request {
        joint_weights: held(&[("x", 1.0)]),
        ..base()
    });
    assert!(text.ends_with("valid: a, b, c"), "{text}");
    let (_, text) = refused(&Request {
        held: held(&[("a", 1.0)]),
        ..base()
    });
    assert_eq!(
        text,
        r#""a" is no joint without a column (it is a column of the path); valid: torso"#
    );
    let (_, text) = refused(&Request {
        fixed_waypoints: vec![0, 4],
        ..base()
    });
    assert!(text.ends_with("waypoints 0 to 3"), "{text}");
}

#[test]
fn a_path_that_has_no_whole_rows_or_too_many_is_refused() {
    let request = Request::new("r", None);
    let columns = Columns::new(&variables(), &[], &[]).unwrap();
    for (numbers, code) in [
        (0, Code::InvalidRobotState),
        (4, Code::InvalidRobotState),
        (3 * 131_073, Code::ResourceExhausted),
    ] {
        assert_eq!(
            request
                .waypoints(&columns, numbers)
                .unwrap_err()
                .code(),
            code,
            "{numbers}"
        );
    }
    assert_eq!(
        request
            .waypoints(&columns, 3 * 131_072)
            .unwrap(),
        131_072
    );
}
