//! The ego of a planning problem, driven by the built-in planner, a process, or a Python function.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use nearmiss_base::system::unknown;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{
    Answering, Clock, ExternalOptions, ExternalPlanner, PROTOCOL, PlannerFunction, Settings,
};
use nearmiss_record::fields::Layers;
use nearmiss_scene::scenario::Scene;
use nearmiss_settings::Planning;
use nearmiss_workflow::drive::{DriveOptions, DriveRecord, PlannerChoice, drive};
use nearmiss_workflow::{OpenedScene, PreparedPlan, SimulatedEgo, prepare_opened, prepare_read};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

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
/// >>> def straight(message):
/// ...     ego, dt = message["ego"], message["hello"]["dt"]
/// ...     way = [k * dt * ego["velocity"] for k in range(30)]
/// ...     x, y = math.cos(ego["heading"]), math.sin(ego["heading"])
/// ...     states = [{**ego, "x": ego["x"] + d * x, "y": ego["y"] + d * y} for d in way]
/// ...     return {"type": "trajectory", "step": message["step"], "states": states}
/// >>> nearmiss.plan(scenario, straight).record["outcome"]
///
/// Its attribute `ready`, a dict, says what it wants, such as straight.ready = {"predictions": True, "history": 5}. Its
/// exceptions come out of `plan`; an answer that cannot be driven is the outcome planner_error, as of a process.
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
    })?;
    chosen.raised.check()?;
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
    let driven = driven.ok_or_else(|| Problem::new("interrupted"))?;
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
    /// The exception of a function.
    pub raised: Raised,
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
        let raised = Raised::default();
        let choice = match planner {
            None if timeout.is_some() => {
                return Err(Problem::new(
                    "timeout is for a planner of your own: planner=…",
                ));
            }
            None => None,
            Some(Planner::Named(said)) => {
                let process = (timeout, Clock::Simulated);
                let choice = PlannerChoice::named(&said, "planner ", &user.config, process);
                Some(choice.map_err(Problem::new)?)
            }
            Some(Planner::Function(function)) if function.is_callable() => {
                Some(function_planner(&function, timeout, raised.clone()))
            }
            Some(Planner::Function(other)) => {
                return Err(Problem::new(format!(
                    "planner: expected a name, a command or a function, not {other}"
                )));
            }
        };
        Ok(Self { choice, raised })
    }
}

fn function_planner(
    function: &Bound<'_, PyAny>,
    timeout: Option<f64>,
    raised: Raised,
) -> PlannerChoice {
    let named = function.getattr("__name__");
    let named = named.or_else(|_| Ok::<_, PyErr>(function.get_type().name()?.into_any()));
    let name = named.map_or_else(|_| "function".into(), |name| name.to_string());
    let mut options = ExternalOptions::new(Vec::new());
    if let Some(seconds) = timeout {
        options.cycle = Duration::from_secs_f64(seconds);
    }
    let function = Arc::new(Function {
        name: name.clone(),
        function: function.clone().unbind(),
        raised,
    });
    PlannerChoice {
        external: Some(Arc::new(ExternalPlanner::of_function(
            name.clone(),
            options,
            function,
        ))),
        name,
        is_recorded: false,
    }
}

/// The first exception of a function, kept while Rust works.
#[derive(Debug, Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Raises it, if there is one.
    pub fn check(&self) -> PyResult<()> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.take().map_or(Ok(()), Err)
    }

    fn keep(&self, error: PyErr) -> String {
        let words = error.to_string();
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get_or_insert(error);
        words
    }
}

/// A Python function as a planner.
#[derive(Debug)]
struct Function {
    name: String,
    function: Py<PyAny>,
    raised: Raised,
}

impl PlannerFunction for Function {
    fn begin(&self) -> Answering {
        let (name, raised) = (self.name.clone(), self.raised.clone());
        let function = Python::attach(|py| self.function.clone_ref(py));
        let mut told = None;
        Box::new(move |line| {
            let answered = Python::try_attach(|py| {
                let message = py.import("json")?.getattr("loads")?.call1((line,))?;
                let function = function.bind(py);
                let answer = if message.get_item("type")?.eq("hello")? {
                    told = Some(message.unbind());
                    ready(function, &name)?
                } else {
                    message.set_item("hello", &told)?;
                    function.call1((message,))?
                };
                let text = py.import("json")?.getattr("dumps")?.call1((answer,))?;
                Ok(text.cast_into::<PyString>()?.to_string())
            });
            answered
                .unwrap_or_else(|| Ok::<_, PyErr>(String::new()))
                .map_err(|error| raised.keep(error))
        })
    }
}

/// What a function says of itself, and over that its attribute `ready`.
fn ready<'py>(function: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let ready = PyDict::new(function.py());
    ready.set_item("type", "ready")?;
    ready.set_item("protocol", PROTOCOL)?;
    ready.set_item("name", name)?;
    if let Ok(wants) = function.getattr("ready")
        && let Ok(wants) = wants.cast::<PyDict>()
    {
        ready.update(wants.as_mapping())?;
    }
    Ok(ready.into_any())
}
