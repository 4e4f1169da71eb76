//! VAMP's problem files: sets of scenes of spheres, cylinders and boxes, each with a start and
//! goals.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

/// A file of problems.
#[derive(Deserialize)]
struct ProblemFile {
    #[serde(default)]
    joints: Vec<String>,
    problems: BTreeMap<String, Vec<Entry>>,
}

/// One problem: only what is read here.
#[derive(Clone, Default, Deserialize)]
struct Entry {
    index: Option<u64>,
    #[serde(default)]
    sphere: Vec<Solid>,
    #[serde(default)]
    cylinder: Vec<Solid>,
    #[serde(default, rename = "box")]
    cuboid: Vec<Solid>,
    #[serde(default)]
    start: Vec<f64>,
    #[serde(default)]
    goals: Vec<Vec<f64>>,
}

#[derive(Clone, Deserialize)]
struct Solid {
    name: Option<String>,
    position: [f64; 3],
    #[serde(default = "upright")]
    orientation_quat_xyzw: [f64; 4],
    radius: Option<f64>,
    length: Option<f64>,
    half_extents: Option<[f64; 3]>,
}

fn upright() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

/// One problem of a file.
pub(super) struct Problem {
    name: String,
    joints: Vec<String>,
    entry: Entry,
}

/// Whether a JSON text is a file of VAMP's problems.
pub(super) fn is_problems(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Probe {
        problems: Option<serde::de::IgnoredAny>,
    }
    serde_json::from_str::<Probe>(text).is_ok_and(|probe| probe.problems.is_some())
}

impl Problem {
    /// The problem of a text that is named `SET:INDEX`, the index as the file has it, or its place
    /// in the set from 0.
    ///
    /// # Errors
    /// No such file, set or index, with the valid ones.
    pub fn select(text: &str, selection: Option<&str>) -> Result<Self, String> {
        let file: ProblemFile = serde_json::from_str(text)
            .map_err(|error| format!("not a file of VAMP's problems: {error}"))?;
        let numbers = |entries: &[Entry]| -> Vec<u64> {
            entries
                .iter()
                .zip(0..)
                .map(|(entry, place)| entry.index.unwrap_or(place))
                .collect()
        };
        let sets = file.problems.iter().map(|(set, entries)| {
            let numbers = numbers(entries);
            match (numbers.iter().min(), numbers.iter().max()) {
                (Some(first), Some(last)) => format!("{set}:{first} to {set}:{last}"),
                _ => format!("{set} (empty)"),
            }
        });
        let valid = sets.collect::<Vec<_>>().join(", ");
        let Some(selection) = selection else {
            return Err(format!(
                "it holds many problems; choose one by --select SET:INDEX: {valid}"
            ));
        };
        let unknown = || format!("it has no problem {selection:?}; valid: {valid}");
        let (set, number) = selection.rsplit_once(':').ok_or_else(unknown)?;
        let number: u64 = number.parse().map_err(|_| unknown())?;
        let entries = file.problems.get(set).ok_or_else(unknown)?;
        let place = numbers(entries)
            .iter()
            .position(|known| *known == number)
            .ok_or_else(unknown)?;
        Ok(Self {
            name: selection.replace(':', "_"),
            joints: file.joints,
            entry: entries[place].clone(),
        })
    }

    /// The straight line from its start to its first goal.
    ///
    /// # Errors
    /// A problem without start or goal, or of other lengths than its joints.
    pub fn path(&self) -> Result<(Vec<String>, Vec<Vec<f64>>), String> {
        let goal = self
            .entry
            .goals
            .first()
            .cloned()
            .unwrap_or_default();
        let rows = vec![self.entry.start.clone(), goal];
        if self.joints.is_empty() {
            return Err(
                "it does not name its joints; give a path of your own with this file as --scene"
                    .to_owned(),
            );
        }
        match rows
            .iter()
            .find(|row| row.len() != self.joints.len())
        {
            Some(row) => Err(format!(
                "{} has {} numbers for {} joints",
                self.name,
                row.len(),
                self.joints.len()
            )),
            None => Ok((self.joints.clone(), rows)),
        }
    }

    /// Its scene as the JSON of a scene file. Objects of the same name get a number.
    ///
    /// # Errors
    /// A solid without its sizes.
    pub fn scene(&self) -> Result<String, String> {
        let mut objects: Vec<Value> = Vec::new();
        let mut known: BTreeMap<String, u32> = BTreeMap::new();
        let kinds = [
            ("sphere", &self.entry.sphere),
            ("cylinder", &self.entry.cylinder),
            ("box", &self.entry.cuboid),
        ];
        for (kind, solids) in kinds {
            for solid in solids {
                let base = solid
                    .name
                    .clone()
                    .unwrap_or_else(|| kind.to_owned());
                let times = known.entry(base.clone()).or_insert(0);
                *times += 1;
                let id = if *times == 1 {
                    base
                } else {
                    format!("{base}_{times}")
                };
                let dimensions = solid
                    .dimensions(kind)
                    .ok_or_else(|| format!("{kind} {id:?} lacks its sizes"))?;
                let [x, y, z, w] = solid.orientation_quat_xyzw;
                objects.push(json!({
                    "id": id,
                    "primitives": [{ "type": kind, "dimensions": dimensions }],
                    "primitive_poses": [
                        { "position": solid.position, "orientation": { "x": x, "y": y, "z": z, "w": w } }
                    ],
                }));
            }
        }
        Ok(json!({ "name": self.name, "objects": objects }).to_string())
    }
}

impl Solid {
    /// MoveIt's dimensions: box x y z, sphere radius, cylinder height and radius.
    fn dimensions(&self, kind: &str) -> Option<Vec<f64>> {
        Some(match kind {
            "sphere" => vec![self.radius?],
            "cylinder" => vec![self.length?, self.radius?],
            _ => self
                .half_extents?
                .map(|half| 2.0 * half)
                .to_vec(),
        })
    }
}
