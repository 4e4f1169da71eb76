//! A robot and a scene of meshes, as files of one host.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::orders::Job;

/// Label of the robot.
pub(crate) const ROBOT: &str = "cart_in_rust";
/// Label of the scene.
pub(crate) const SCENE: &str = "wall_in_rust";
/// The scene's text.
pub(crate) const SCENE_TEXT: &str = include_str!("../model/scene.json");

const FILES: [(&str, &str); 6] = [
    ("cart.urdf", include_str!("../model/cart.urdf")),
    ("cube.obj", include_str!("../model/cube.obj")),
    ("problem.json", include_str!("../model/problem.json")),
    ("scene.json", SCENE_TEXT),
    ("ask.py", include_str!("../programs/ask.py")),
    ("ask.c", include_str!("../programs/ask.c")),
];

/// Writes it into a host's folder; tells where.
pub(crate) fn write(folder: &Path) -> Result<PathBuf, Error> {
    let folder = folder.join("model");
    let written = fs::create_dir_all(&folder).and_then(|()| {
        FILES
            .iter()
            .try_for_each(|(name, text)| fs::write(folder.join(name), text))
    });
    written.map_err(|source| Error::System {
        what: "the model's files",
        source,
    })?;
    Ok(folder)
}

/// The problem's request, as the other languages' programs ask it.
pub(crate) fn job() -> Job {
    let path = [
        [-2.0, 0.0],
        [-1.5, 1.0],
        [-0.7, 1.6],
        [0.1, 1.8],
        [0.9, 1.5],
        [1.5, 0.8],
        [2.0, 0.0],
    ];
    Job {
        name: "cart".to_owned(),
        robot: ROBOT.to_owned(),
        scene: Some(SCENE.to_owned()),
        path: path.concat(),
        budget: 6_000,
        seed: 7,
        ..Job::default()
    }
}
