//! What is asked of a path's times, as flags.

use serde_json::{Map, Value, json};
use taut::files::{self, Timing};

use super::error::CliError;
use super::motors::Motors;
use super::quantity;

/// Whether times are asked for, and what they are to be.
#[derive(clap::Args)]
pub(super) struct Times {
    /// Give the shortened path times: near the least that the motors allow, proved as they are written;
    /// half of the time until the deadline is for them
    #[arg(long)]
    time: bool,
    #[command(flatten)]
    motors: Motors,
    /// Part of full speed, above 0 and up to 1: whatever is done takes 1/SPEED times as long
    #[arg(long, value_name = "SPEED", value_parser = speed)]
    speed: Option<f64>,
    /// How fast a joint moves at the start (rad/s or m/s); the others stand still; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = quantity::value)]
    start_velocity: Vec<(String, f64)>,
    /// What goes from point to point: cubic, quintic, or linear@RATE (points per second)
    #[arg(long, value_name = "CONTROLLER")]
    controller: Option<String>,
    /// Clearance to keep where it is executed, such as 1mm, below the one that the path keeps: shorten
    /// at 5 mm, execute at 1 mm
    #[arg(long, value_name = "LENGTH", value_parser = quantity::metres)]
    time_clearance: Option<f64>,
}

/// A part of full speed.
pub(super) fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse().ok();
    speed
        .filter(|speed| *speed > 0.0 && *speed <= 1.0)
        .ok_or_else(|| "give a number above 0 and up to 1".to_owned())
}

impl Times {
    /// The text that a request carries; empty where no times are asked for.
    ///
    /// # Errors
    /// A file that cannot be read, flags of times without `--time`.
    pub(super) fn text(&self) -> Result<String, CliError> {
        let words = self.words()?;
        match (self.time, words.is_empty()) {
            (true, _) => {
                let text = Value::Object(words).to_string();
                Timing::parse(&text).map_err(CliError::Usage)?;
                Ok(text)
            }
            (false, true) => Ok(String::new()),
            (false, false) => {
                let given: Vec<&String> = words.keys().collect();
                Err(CliError::Usage(format!(
                    "{given:?} are about times; add --time"
                )))
            }
        }
    }

    fn words(&self) -> Result<Map<String, Value>, CliError> {
        let mut words = Map::new();
        if let Some(file) = &self.motors.limits {
            words.insert("file".to_owned(), json!(file));
            words.insert("content".to_owned(), json!(files::limits_text(file)?));
        }
        let mut enter = |name: &str, value: Option<Value>| {
            if let Some(value) = value {
                words.insert(name.to_owned(), value);
            }
        };
        let motors = &self.motors;
        enter(
            "acceleration",
            motors
                .acceleration
                .map(|size| json!(size.to_string())),
        );
        enter("speed", self.speed.map(Value::from));
        enter(
            "controller",
            self.controller.as_ref().map(|name| json!(name)),
        );
        enter("clearance", self.time_clearance.map(Value::from));
        let start: Map<String, Value> = self
            .start_velocity
            .iter()
            .map(|(name, velocity)| (name.clone(), json!(velocity)))
            .collect();
        enter(
            "start_velocity",
            (!start.is_empty()).then_some(Value::Object(start)),
        );
        Ok(words)
    }
}
