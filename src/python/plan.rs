//! The ego of a planning problem, driven by the built-in planner, a process, or a Python function.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use nearmiss_base::system::unknown;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{
    Answering, Clock, ExternalOptions, ExternalPlanner, PlannerFunction, Settings,
};
use nearmiss_record::fields::Layers;
use nearmiss_scene::scenario::Scene;
use nearmiss_settings::Planning;
use nearmiss_workflow::drive::{DriveOptions, DriveRecord, PlannerChoice, drive};
use nearmiss_workflow::{OpenedScene, PreparedPlan, SimulatedEgo, prepare_opened, prepare_read};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use crate::errors::Problem;
use crate::scenario::Scenario;
use crate::settings::User;
use crate::window::json;
use crate::work;

/// A planner's drive; `nearmiss.plan` makes one.
#[pyclass(frozen, module = "nearmiss")]
pub struct Drive {
    record: DriveRecord,
    scenario: Scenario,
}

#[pymethods]
impl Drive {
    /// How it ended and what it took, as a dict: `outcome` (goal, collision, timeout, off_road, infeasible or planner_error),
    /// `collision_with`, `steps`, `max_jerk`, `rules_broken` and more: the line of `nearmiss plan --format json`.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &self.record)
    }

    /// The scenario with the ego that was driven, for measures, figures and questions.
    #[getter]
    fn scenario(&self) -> Scenario {
        self.scenario.clone()
    }

    fn __repr__(&self) -> String {
        let DriveRecord {
            scenario,
            outcome,
            steps,
            planner,
            ..
        } = &self.record;
        format!("<nearmiss.Drive {scenario}: {outcome} after {steps} steps, planner {planner}>")
    }
}

/// Drives the ego of the planning problem, as `nearmiss plan` does.
///
/// planner: None for the built-in one, a [planner.NAME] of config.toml, a command that speaks the planner protocol, or a
/// function. A function gets a `plan` message of the protocol each cycle as a dict, with the `hello` of the drive as
/// message["hello"], and returns a `trajectory` or an `error` as a dict (`nearmiss help planners` tells their keys):
///
/// >>> import math
/// >>> def straight(message):
/// ...     ego, dt = message["ego"], message["hello"]["dt"]
/// ...     way = [k * dt * ego["velocity"] for k in range(30)]
/// ...     x, y = math.cos(ego["heading"]), math.sin(ego["heading"])
/// ...     same = {"heading": ego["heading"], "velocity": ego["velocity"]}
/// ...     states = [{"x": ego["x"] + d * x, "y": ego["y"] + d * y, **same} for d in way]
/// ...     return {"type": "trajectory", "step": message["step"], "states": states}
/// >>> nearmiss.plan(scenario, straight).record["outcome"]
///
/// Its attribute `ready`, a dict, says what it wants, such as straight.ready = {"predictions": True, "history": 5}. Its
/// exceptions come out of `plan`; an answer that is none, or cannot be driven, is the outcome planner_error, as of a
/// process, and record["note"] says why.
///
/// problem: id of the planning problem; None for that of the recorded ego, else the first. traffic: recorded or reactive.
/// More keywords are settings of [planner] in config.toml: prediction, rules, replan, horizon, vehicle; timeout is of a
/// cycle of a planner of your own, seconds.
#[pyfunction]
#[pyo3(signature = (scenario, planner=None, *, problem=None, traffic=None, **settings))]
pub fn plan(
    py: Python<'_>,
    scenario: &Scenario,
    planner: Option<Planner<'_>>,
    problem: Option<i64>,
    traffic: Option<&str>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Drive> {
    let user = User::read()?;
    let planning = planning(&user, traffic, settings)?;
    let chosen = Chosen::new(planner, &user, planning.timeout)?;
    let (choice, settings) = (chosen.choice, Settings::from(&planning));
    let own = scenario.clone();
    let driven = work::run(py, move |cancel| {
        driven(&own, problem, &settings, choice.as_ref(), cancel)
    });
    chosen.calls.settle(py);
    let driven = driven?;
    chosen.calls.check()?;
    Ok(driven?)
}

fn driven(
    scenario: &Scenario,
    problem: Option<i64>,
    settings: &Settings,
    planner: Option<&PlannerChoice>,
    cancel: &Cancel,
) -> Result<Drive, Problem> {
    let prepared = scenario.prepared(problem, settings)?;
    let options = DriveOptions {
        planner,
        monitor: None,
        counts: false,
    };
    let driven = drive(&scenario.entry, prepared, options, cancel).map_err(Problem::new)?;
    let Some(driven) = driven else {
        return Err(Problem::new("interrupted"));
    };
    let scene = driven
        .scene()
        .ok_or_else(|| Problem::new("internal error: the planning problem is gone"))?;
    Ok(Drive {
        record: DriveRecord::new(&driven),
        scenario: scenario.driven(scene),
    })
}

impl Scenario {
    /// Ready to be driven. What it is compared with is the recorded ego, or that of a drive, which no file holds.
    ///
    /// # Errors
    /// There is nothing to drive, or not as asked.
    pub fn prepared(
        &self,
        problem: Option<i64>,
        settings: &Settings,
    ) -> Result<PreparedPlan, Problem> {
        let (entry, scenario) = (&self.entry, Arc::clone(&self.scenario));
        let prepared = if self.asked == SimulatedEgo::Planned {
            let opened = OpenedScene {
                scenario,
                scene: self.opened.clone(),
                stands_in: false,
            };
            prepare_opened(entry, opened, problem, settings)
        } else {
            prepare_read(entry, scenario, problem, settings)
        };
        prepared.map_err(Problem::new)
    }

    /// The same with the ego of a drive.
    pub fn driven(&self, scene: Scene) -> Self {
        Self {
            scenario: Arc::clone(&scene.scenario),
            opened: Ok(Arc::new(scene)),
            asked: SimulatedEgo::Planned,
            stands_in: false,
            ..self.clone()
        }
    }
}

/// How motions are planned: as the configuration says, and over that what is named.
pub fn planning(
    user: &User,
    traffic: Option<&str>,
    named: Option<&Bound<'_, PyDict>>,
) -> Result<Planning, Problem> {
    let mut layers = Layers::<Planning>::default();
    layers.fields("config.toml: planner.", &user.config.planning());
    if let Some(traffic) = traffic {
        layers.word("traffic", "traffic", traffic);
    }
    for (key, value) in named.into_iter().flatten() {
        let key = key.to_string();
        let known: Vec<String> = Planning::keys().collect();
        if !known.contains(&key) {
            let known = known.iter().map(String::as_str);
            return Err(Problem::new(unknown("setting", &key, known)));
        }
        let word = match value.cast::<PyBool>() {
            Ok(is) => is.is_true().to_string(),
            Err(_) => value.to_string(),
        };
        layers.word(&key, &key, &word);
    }
    layers.read().map_err(Problem::new)
}

/// A planner as Python names it.
#[derive(FromPyObject)]
pub enum Planner<'py> {
    /// A name or a command.
    Named(String),
    /// A function.
    Function(Bound<'py, PyAny>),
}

/// The planner that drives.
pub struct Chosen {
    /// None for the built-in planner without a word about it.
    pub choice: Option<PlannerChoice>,
    /// Of a function.
    pub calls: Arc<Calls>,
}

impl Chosen {
    /// The one that was named; `timeout` is of a cycle, seconds.
    ///
    /// # Errors
    /// It is no planner, or there is a timeout for the built-in one.
    pub fn new(
        planner: Option<Planner<'_>>,
        user: &User,
        timeout: Option<f64>,
    ) -> Result<Self, Problem> {
        let calls = Arc::<Calls>::default();
        let choice = match planner {
            None if timeout.is_some() => {
                return Err(Problem::new(
                    "timeout is for a planner of your own: planner=…",
                ));
            }
            None => None,
            Some(Planner::Named(said)) => {
                let (config, clock) = (&user.config, Clock::Simulated);
                let choice = PlannerChoice::named(&said, "planner ", config, timeout, clock);
                Some(choice.map_err(Problem::new)?)
            }
            Some(Planner::Function(function)) if function.is_callable() => {
                Some(function_planner(&function, timeout, Arc::clone(&calls)))
            }
            Some(Planner::Function(other)) => {
                return Err(Problem::new(format!(
                    "planner: expected a name, a command or a function, not {other}"
                )));
            }
        };
        Ok(Self { choice, calls })
    }
}

fn function_planner(
    function: &Bound<'_, PyAny>,
    timeout: Option<f64>,
    calls: Arc<Calls>,
) -> PlannerChoice {
    let own = function.getattr("__name__");
    let named = own.or_else(|_| Ok::<_, PyErr>(function.get_type().name()?.into_any()));
    let name = named.map_or_else(|_| "function".into(), |name| name.to_string());
    let mut options = ExternalOptions::new(Vec::new());
    if let Some(seconds) = timeout {
        options.cycle = Duration::from_secs_f64(seconds);
    }
    let function = Arc::new(Function {
        name: name.clone(),
        function: function.clone().unbind(),
        calls,
    });
    let planner = ExternalPlanner::of_function(name.clone(), options, function);
    PlannerChoice {
        external: Some(Arc::new(planner)),
        name,
        ..PlannerChoice::default()
    }
}

/// The calls of a function while Rust works.
#[derive(Debug, Default)]
pub struct Calls {
    /// The first exception.
    raised: Mutex<Option<PyErr>>,
    /// Threads that wait for requests, or answer one.
    threads: AtomicUsize,
}

/// How long threads are waited for.
const GRACE: Duration = Duration::from_millis(300);

impl Calls {
    /// Waits a little until the threads end: one that came back to Rust while Python ends would break it off. One whose
    /// function does not return may go on.
    pub fn settle(&self, py: Python<'_>) {
        py.detach(|| {
            let until = Instant::now() + GRACE;
            while self.threads.load(Ordering::Acquire) > 0 && Instant::now() < until {
                std::thread::sleep(Duration::from_millis(1));
            }
        });
    }

    /// Raises the exception, if there is one.
    pub fn check(&self) -> PyResult<()> {
        let mut kept = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        kept.take().map_or(Ok(()), Err)
    }

    fn keep(&self, error: PyErr) {
        let mut kept = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get_or_insert(error);
    }
}

/// A Python function as a planner.
#[derive(Debug)]
struct Function {
    name: String,
    function: Py<PyAny>,
    calls: Arc<Calls>,
}

impl PlannerFunction for Function {
    fn begin(&self) -> Answering {
        let (to, asked) = sync_channel(1);
        let (answers, from) = sync_channel(1);
        self.calls.threads.fetch_add(1, Ordering::AcqRel);
        let requests = Requests {
            asked: Mutex::new(asked),
            answers,
            calls: Arc::clone(&self.calls),
        };
        let begun = Python::attach(|py| {
            let thread = py.import("nearmiss._planners")?;
            let function = self.function.bind(py);
            thread.call_method1("begin", (function, &self.name, requests))?;
            Ok::<_, PyErr>(())
        });
        let begun = begun.map_err(|error| error.to_string());
        Box::new(move |line| {
            begun.clone()?;
            let gone = "its thread has ended";
            to.send(line.to_string()).map_err(|_| gone)?;
            from.recv().map_err(|_| gone)?
        })
    }
}

/// What a drive asks of a function, for the thread that answers it.
#[pyclass(frozen)]
struct Requests {
    asked: Mutex<Receiver<String>>,
    answers: SyncSender<Result<String, String>>,
    calls: Arc<Calls>,
}

#[pymethods]
impl Requests {
    fn __iter__(own: Py<Self>) -> Py<Self> {
        own
    }

    fn __next__(&self, py: Python<'_>) -> Option<String> {
        py.detach(|| {
            let asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
            asked.recv().ok()
        })
    }

    fn answer(&self, line: String) {
        // Nobody waits for one that comes too late.
        let _ = self.answers.try_send(Ok(line));
    }

    fn fail(&self, error: &Bound<'_, PyAny>) {
        let error = PyErr::from_value(error.clone());
        let words = error.to_string();
        self.calls.keep(error);
        let _ = self.answers.try_send(Err(words));
    }
}

impl Drop for Requests {
    fn drop(&mut self) {
        self.calls.threads.fetch_sub(1, Ordering::AcqRel);
    }
}
