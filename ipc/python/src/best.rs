//! One answer, shown in place.

use pyo3::prelude::*;
use pyo3::sync::{MutexExt, PyOnceLock};
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use taut_ipc::planner::{Best, PlannerError};
use taut_ipc::wire::{ResponseFlags, Stage, Termination};

use super::about::About;
use super::guard::Own;
use super::{errors, ndarray, result, trajectory};

static AS_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// An answer that several threads may look at, one at a time.
pub type Shared = Arc<Mutex<Own<Best>>>;

/// An answer being looked at.
pub struct Look<'a>(MutexGuard<'a, Own<Best>>);

impl<'a> Look<'a> {
    /// Waits for others without the interpreter's lock: they may need it.
    ///
    /// # Errors
    /// In a forked child.
    pub fn at(best: &'a Shared) -> PyResult<Self> {
        let guard =
            Python::attach(|py| best.lock_py_attached(py)).unwrap_or_else(PoisonError::into_inner);
        guard.get()?;
        Ok(Self(guard))
    }
}

impl std::ops::Deref for Look<'_> {
    type Target = Best;

    fn deref(&self) -> &Best {
        self.0
            .get()
            .expect("checked when it was locked")
    }
}

/// A path that is better than those before it, or the final answer. See `taut.Improvement`.
#[pyclass(frozen, module = "taut._taut")]
pub struct Improvement {
    best: Shared,
    /// The path in the caller's columns, where these do not lie side by side in the robot's.
    permuted: Option<Vec<f64>>,
    about: Arc<About>,
    /// When it came, after the request was sent (s).
    time_s: f64,
}

impl Improvement {
    pub fn new(best: Shared, about: Arc<About>) -> PyResult<Self> {
        let time_s = about.start.elapsed().as_secs_f64();
        let look = Look::at(&best)?;
        let permuted = look
            .columns()
            .stretch()
            .is_none()
            .then(|| look.rows().into_owned());
        drop(look);
        Ok(Self {
            permuted,
            best,
            about,
            time_s,
        })
    }

    fn best(&self) -> PyResult<Look<'_>> {
        Look::at(&self.best)
    }
}

#[pymethods]
impl Improvement {
    /// Where numpy finds the path.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let best = self.best()?;
        let shape = (best.waypoints(), best.columns().width());
        match &self.permuted {
            Some(rows) => ndarray::interface(py, rows, shape, shape.1),
            None => {
                let first = best.columns().stretch().unwrap_or_default();
                let path = best.path().get(first..).unwrap_or_default();
                ndarray::interface(py, path, shape, best.columns().robot_width())
            }
        }
    }

    /// The waypoints, a read-only array of the request's columns.
    #[getter]
    fn path<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        // numpy may take an object whose interface raises for one without.
        slf.get().best()?;
        let as_array = AS_ARRAY.get_or_try_init(py, || {
            Ok::<_, PyErr>(py.import("numpy")?.getattr("asarray")?.unbind())
        })?;
        as_array.bind(py).call1((slf,))
    }

    /// Whether the path lies in shared memory.
    #[getter]
    fn is_shared(&self) -> PyResult<bool> {
        Ok(self.permuted.is_none() && self.best()?.is_shared())
    }

    #[getter]
    fn length(&self) -> PyResult<f64> {
        Ok(self.best()?.header().length_after)
    }

    #[getter]
    fn length_before(&self) -> PyResult<f64> {
        Ok(self.best()?.header().length_before)
    }

    #[getter]
    fn lower_bound(&self) -> PyResult<f64> {
        Ok(self.best()?.header().lower_bound)
    }

    #[getter]
    fn proved(&self) -> PyResult<bool> {
        Ok(self.best()?.header().flags & ResponseFlags::PROVED != 0)
    }

    #[getter(r#final)]
    fn is_final(&self) -> PyResult<bool> {
        Ok(self.best()?.is_final())
    }

    #[getter]
    fn world_age(&self) -> PyResult<Option<f64>> {
        let age_ns = self.best()?.header().world_age_ns;
        Ok((age_ns != 0).then_some(age_ns as f64 * 1e-9))
    }

    #[getter]
    fn superseded(&self) -> PyResult<bool> {
        Ok(self.best()?.header().flags & ResponseFlags::SUPERSEDED != 0)
    }

    #[getter]
    fn code(&self) -> PyResult<i32> {
        Ok(self.best()?.header().code)
    }

    #[getter]
    fn code_name(&self) -> PyResult<&'static str> {
        Ok(self.best()?.code().name())
    }

    #[getter]
    fn message(&self) -> PyResult<String> {
        Ok(self.best()?.message().to_owned())
    }

    /// Lines that a person should know, each with whether it says what the verdict does not cover.
    #[getter]
    fn warnings(&self) -> PyResult<Vec<(bool, String)>> {
        let told = self
            .best()?
            .warnings()
            .map_err(|error| errors::of(&PlannerError::from(error)))?;
        Ok(told
            .into_iter()
            .map(|warning| (warning.is_uncovered, warning.text))
            .collect())
    }

    /// Whether there is a trajectory, and why not.
    #[getter]
    fn times(&self) -> PyResult<&'static str> {
        Ok(self.best()?.times().name())
    }

    /// The trajectory; raises what says why there is none.
    fn trajectory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let about = &*self.about;
        let best = &self.best;
        let (found, names) = py.detach(|| {
            let found = Look::at(best)?
                .timed()
                .map_err(|error| errors::of(&error))?;
            let robot = about.planner.get()?.robot(&about.request.robot);
            let robot = robot.map_err(|error| errors::of(&error))?;
            Ok::<_, PyErr>((found, trajectory::names(&about.request, &robot)))
        })?;
        trajectory::dict(py, &found, names)
    }

    #[getter]
    fn pairs(&self) -> PyResult<u64> {
        Ok(self.best()?.header().pairs)
    }

    #[getter]
    fn clearance(&self) -> PyResult<f64> {
        Ok(self.best()?.header().clearance_m)
    }

    #[getter]
    fn floor(&self) -> PyResult<f64> {
        Ok(self.best()?.header().floor_m)
    }

    #[getter]
    fn scene_version(&self) -> PyResult<u64> {
        Ok(self.best()?.header().scene_version)
    }

    #[getter]
    fn seq(&self) -> PyResult<u32> {
        Ok(self.best()?.header().seq)
    }

    #[getter]
    fn iterations(&self) -> PyResult<u64> {
        Ok(self.best()?.header().iterations)
    }

    #[getter]
    fn work(&self) -> PyResult<u64> {
        Ok(self.best()?.header().work)
    }

    #[getter]
    fn compute_time(&self) -> PyResult<f64> {
        Ok(self.best()?.header().compute_ns as f64 * 1e-9)
    }

    #[getter]
    fn time(&self) -> f64 {
        self.time_s
    }

    #[getter]
    fn request_id(&self) -> PyResult<String> {
        Ok(format!("{:016x}", self.best()?.header().request_id))
    }

    #[getter]
    fn stage(&self) -> PyResult<&'static str> {
        let stage = Stage::try_from(self.best()?.header().stage).unwrap_or(Stage::Input);
        Ok(stage.name())
    }

    #[getter]
    fn ended(&self) -> PyResult<&'static str> {
        let termination = Termination::try_from(self.best()?.header().termination);
        Ok(termination
            .unwrap_or(Termination::Running)
            .name())
    }

    /// Raises the error that a final answer is which is no success.
    fn check(&self) -> PyResult<()> {
        match self
            .best()?
            .refused()
            .map_err(|error| errors::of(&error))?
        {
            None => Ok(()),
            Some(refused) => Err(errors::of(&PlannerError::Refused(Box::new(refused)))),
        }
    }

    /// All of it but the paths as the JSON of a result file.
    fn details(&self, py: Python<'_>) -> PyResult<String> {
        let about = &*self.about;
        let best = &self.best;
        py.detach(|| {
            let best = Look::at(best)?;
            result::details(about, &best, self.time_s)
        })
    }

    /// Writes a result file.
    fn save(
        &self,
        py: Python<'_>,
        file: PathBuf,
        path_before: numpy::PyReadonlyArray2<'_, f64>,
        lengths_over_time: Vec<(f64, f64)>,
    ) -> PyResult<()> {
        let (_, numbers) = ndarray::path_of(&path_before)?;
        let about = &*self.about;
        let best = &self.best;
        py.detach(|| {
            let best = Look::at(best)?;
            result::save(about, &best, self.time_s, &file, numbers, lengths_over_time)
        })
    }
}
