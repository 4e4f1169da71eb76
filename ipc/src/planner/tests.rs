use super::*;
use crate::control::{GroupDescription, VariableDescription};
use crate::wire::Code;

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn held(pairs: &[(&str, f64)]) -> Vec<(String, f64)> {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

const ROBOT: [&str; 3] = ["a", "b", "c"];

fn message(error: PlannerError, code: Code) -> String {
    assert_eq!(error.code(), code, "{error}");
    error.to_string()
}

#[test]
fn columns_without_names_are_the_robots() {
    let columns = Columns::new(&ROBOT, &[], &[]).unwrap();
    assert!(columns.are_the_robots());
    let (rows, mut robot, mut back) = ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.0; 6], [0.0; 6]);
    columns.write(&rows, &mut robot);
    columns.read(&robot, &mut back);
    assert_eq!((robot, back), (rows, rows));
}

#[test]
fn columns_in_another_order_are_the_robots_inside_and_the_callers_outside() {
    let columns = Columns::new(&ROBOT, &names(&["c", "a", "b"]), &[]).unwrap();
    assert_eq!((columns.are_the_robots(), columns.stretch()), (false, None));
    let (rows, mut robot, mut back) = ([3.0, 1.0, 2.0, 6.0, 4.0, 5.0], [0.0; 6], [0.0; 6]);
    columns.write(&rows, &mut robot);
    assert_eq!(robot, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    columns.read(&robot, &mut back);
    assert_eq!(back, rows);
}

#[test]
fn missing_columns_are_held_and_stand_still() {
    let columns = Columns::new(&ROBOT, &names(&["b", "c"]), &held(&[("a", 7.0)])).unwrap();
    assert_eq!((columns.stretch(), columns.given()), (Some(1), vec![0, 1, 1]));
    let (mut robot, mut back) = ([0.0; 6], [0.0; 4]);
    columns.write(&[1.0, 2.0, 3.0, 4.0], &mut robot);
    assert_eq!(robot, [7.0, 1.0, 2.0, 7.0, 3.0, 4.0]);
    columns.read(&robot, &mut back);
    assert_eq!(back, [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn columns_that_are_none_are_refused_with_the_valid_ones() {
    let code = Code::InvalidRobotState;
    let unknown = message(Columns::new(&ROBOT, &names(&["a", "x", "c"]), &[]).unwrap_err(), code);
    assert_eq!(unknown, r#""x" is no column of the robot; valid: a, b, c"#);
    let twice = message(Columns::new(&ROBOT, &names(&["a", "a", "c"]), &[]).unwrap_err(), code);
    assert!(twice.contains(r#""a" is there twice"#), "{twice}");
    let missing = message(Columns::new(&ROBOT, &names(&["a", "c"]), &[]).unwrap_err(), code);
    assert!(missing.contains(r#""b" is missing and not held"#), "{missing}");
}

fn robot() -> RobotDescription {
    let variable = |(index, name): (u32, &&str)| VariableDescription {
        name: (*name).to_owned(),
        coordinate: index,
        coordinates: 1,
        ..VariableDescription::default()
    };
    RobotDescription {
        variables: (0..).zip(&ROBOT).map(variable).collect(),
        held_variables: names(&["torso"]),
        held_values: vec![0.5],
        groups: vec![GroupDescription { name: "arm".to_owned(), variables: vec![1, 2] }],
        nq: 3,
        nv: 3,
        weights: vec![1.0, 2.0, 3.0],
        ..RobotDescription::default()
    }
}

fn refused(request: &Request) -> (Code, String) {
    let robot = robot();
    let columns = request.columns_of(&robot).unwrap();
    let error = request.sections(&robot, &columns, 4).err().expect("refused");
    (error.code(), error.to_string())
}

#[test]
fn names_of_a_request_are_looked_up() {
    let base = || Request::new("r", None);
    let weights = Request { joint_weights: held(&[("b", 9.0)]), ..base() }.weights(&robot()).unwrap();
    assert_eq!(weights, [1.0, 9.0, 3.0]);
    let (code, text) = refused(&Request { group: Some("leg".to_owned()), ..base() });
    assert_eq!((code, text.as_str()), (Code::InvalidGroupName, r#""leg" is no group of the robot; valid: arm"#));
    let (_, text) = refused(&Request { joint_weights: held(&[("x", 1.0)]), ..base() });
    assert!(text.ends_with("valid: a, b, c"), "{text}");
    let (_, text) = refused(&Request { held: held(&[("a", 1.0)]), ..base() });
    assert_eq!(text, r#""a" is no joint without a column; valid: torso"#);
    let (_, text) = refused(&Request { fixed_waypoints: vec![0, 4], ..base() });
    assert!(text.ends_with("waypoints 0 to 3"), "{text}");
}

#[test]
fn a_path_that_has_no_whole_rows_or_too_many_is_refused() {
    let request = Request::new("r", None);
    let columns = Columns::new(&ROBOT, &[], &[]).unwrap();
    for (numbers, code) in
        [(0, Code::InvalidRobotState), (4, Code::InvalidRobotState), (3 * 131_073, Code::ResourceExhausted)]
    {
        assert_eq!(request.waypoints(&columns, numbers).unwrap_err().code(), code, "{numbers}");
    }
    assert_eq!(request.waypoints(&columns, 3 * 131_072).unwrap(), 131_072);
}
