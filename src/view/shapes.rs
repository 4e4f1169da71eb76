//! Solids as the page draws them: sizes as numbers, meshes as bytes, each once.

use std::collections::HashMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use taut::math::Pose;
use taut::shape::{Drawn, Mesh, PlacedShape};

/// A solid at its place in the frame of its object.
#[derive(Serialize)]
pub(super) struct Solid {
    pose: Place,
    #[serde(flatten)]
    form: Form,
}

/// x y z (m), then the unit quaternion x y z w.
pub(super) type Place = [f64; 7];

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Form {
    Box { size: [f64; 3] },
    Sphere { radius: f64 },
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Mesh { mesh: usize },
}

/// Meshes by number; equal ones are one.
#[derive(Default)]
pub(super) struct Meshes {
    numbers: HashMap<u64, usize>,
    meshes: Vec<MeshBytes>,
}

/// Little-endian numbers in base 64.
#[derive(Serialize)]
pub(super) struct MeshBytes {
    /// Three f32 for each vertex (m).
    vertices: String,
    /// Three u32 for each triangle.
    triangles: String,
}

impl MeshBytes {
    fn of(mesh: &Mesh) -> Self {
        Self {
            vertices: STANDARD.encode(vertices(mesh)),
            triangles: STANDARD.encode(triangles(mesh)),
        }
    }
}

fn vertices(mesh: &Mesh) -> Vec<u8> {
    let vertices = mesh.vertices().iter();
    vertices
        .flat_map(|vertex| vertex.to_array())
        .flat_map(|number| (number as f32).to_le_bytes())
        .collect()
}

fn triangles(mesh: &Mesh) -> Vec<u8> {
    let corners = mesh.triangles().iter().flatten();
    corners
        .flat_map(|corner| corner.to_le_bytes())
        .collect()
}

impl Meshes {
    /// The number of a mesh.
    pub(super) fn number(&mut self, mesh: &Mesh) -> usize {
        let Self { numbers, meshes } = self;
        *numbers.entry(mesh.hash()).or_insert_with(|| {
            meshes.push(MeshBytes::of(mesh));
            meshes.len() - 1
        })
    }

    /// All of them, by number.
    pub(super) fn into_bytes(self) -> Vec<MeshBytes> {
        self.meshes
    }
}

impl Solid {
    /// A shape as the page has it.
    pub(super) fn of(placed: &PlacedShape, meshes: &mut Meshes) -> Self {
        let form = match placed.shape.drawn() {
            Drawn::Box { size } => Form::Box {
                size: size.to_array(),
            },
            Drawn::Sphere { radius } => Form::Sphere { radius },
            Drawn::Cylinder { radius, length } => Form::Cylinder { radius, length },
            Drawn::Capsule { radius, length } => Form::Capsule { radius, length },
            Drawn::Mesh(mesh) => Form::Mesh {
                mesh: meshes.number(&mesh),
            },
        };
        Self {
            pose: place(&placed.pose),
            form,
        }
    }
}

/// A pose as the page has it.
pub(super) fn place(pose: &Pose) -> Place {
    let [x, y, z] = pose.translation.to_array();
    let [i, j, k, w] = pose.rotation.to_array();
    [x, y, z, i, j, k, w]
}
