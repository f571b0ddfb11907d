//! A question about a window of a scenario: its messages, the built-in judge's verdict, a model's answer, and claims checked.

use std::sync::Arc;

use nearmiss_ask::llm::{Environment, Registry};
use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_drive::planner::Cancel;
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_scene::verdict::{self, ParsedAnswer, Task};
use nearmiss_settings::Folders;
use nearmiss_store::Store;
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::claims::{
    SentenceRecord, Subject, TimeOrigin, sentences, waypoints,
};
use nearmiss_study::evaluation::{AttackTerms, Question, RunOptions, validate};
use nearmiss_workflow::span::Span;
use nearmiss_workflow::{
    AskDocument, AskRequest, Models, QuestionRequest, Server, ask as ask_model,
    configured_experiment, described, question,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::arguments::Moment;
use crate::errors::{Problem, of_keyword};
use crate::scenario::Scenario;
use crate::settings::User;
use crate::work;

/// What serialises, as Python's dicts, lists and numbers.
pub fn json<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(Problem::new)?;
    py.import("json")?.getattr("loads")?.call1((text,))
}

/// A window of a scenario and what is asked about it; `scenario.window` makes one.
#[pyclass(frozen, module = "nearmiss")]
pub struct Window {
    question: Arc<Question>,
}

#[pymethods]
impl Window {
    /// The task: collision, safety, recording, attacker or trajectory.
    #[getter]
    fn task(&self) -> &'static str {
        self.question.case.task.name()
    }

    /// First and last time step.
    #[getter]
    fn steps(&self) -> (i64, i64) {
        (
            self.question.case.window.first(),
            self.question.case.window.last(),
        )
    }

    /// The scene in words, as the frame has it.
    #[getter]
    fn description(&self) -> &str {
        &self.question.description
    }

    /// Estimated tokens of the messages.
    #[getter]
    fn tokens(&self) -> usize {
        self.question.tokens()
    }

    fn __repr__(&self) -> String {
        let case = &self.question.case;
        let (first, last) = self.steps();
        format!(
            "<nearmiss.Window {}: {} in steps {first} to {last}>",
            case.name,
            case.task.name()
        )
    }
}

/// How a window is named by keywords.
pub struct Named {
    /// Its end.
    pub at: Option<Moment>,
    /// Its steps.
    pub history: Option<usize>,
    /// The only obstacle that is described.
    pub obstacle: Option<i64>,
}

impl Named {
    fn span(self) -> Result<Span, Problem> {
        Ok(Span {
            at: self.at.map(Moment::at).transpose()?,
            history: self.history,
            obstacle: self.obstacle,
        })
    }
}

/// What is asked, in words.
pub struct Asked<'a> {
    /// The task.
    pub task: &'a str,
    /// The frame; that of the template where none is named.
    pub frame: Option<&'a str>,
    /// The techniques; those of the template where none are named.
    pub techniques: Option<&'a str>,
}

impl Window {
    /// The window of a scenario, and what is asked about it.
    pub fn new(
        py: Python<'_>,
        scenario: &Scenario,
        asked: Asked<'_>,
        named: Named,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let user = User::read()?;
        let set = set(&user, "description", settings)?;
        let task: Task = of_keyword("task", asked.task.parse())?;
        let frame = of_keyword("frame", asked.frame.map(str::parse).transpose())?;
        let techniques = asked.techniques.map(Techniques::parse).transpose();
        let techniques = of_keyword("techniques", techniques)?;
        let (span, scene) = (named.span()?, Arc::clone(scenario.scene()?));
        let name = scenario.entry.name.clone();
        let thresholds = (*scenario.thresholds).clone();
        let made = work::run(py, move |_| {
            let folder = user.folders.as_ref().map(Folders::prompts);
            let library = validate(Library::load(folder.as_deref())).with_pack(set.pack);
            question(QuestionRequest {
                name,
                scene,
                task,
                frame,
                techniques,
                span,
                set: &set,
                library: &library,
                thresholds,
                attack: AttackTerms::of_style(user.config.attack_style),
            })
        })?;
        let question = Arc::new(made.map_err(Problem::from)?);
        Ok(Self { question })
    }
}

/// A window of a scenario in words.
pub fn description(
    py: Python<'_>,
    scenario: &Scenario,
    frame: &str,
    named: Named,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<String> {
    let set = set(&User::read()?, "description", settings)?;
    let frame = of_keyword("frame", frame.parse())?;
    let (span, scene) = (named.span()?, Arc::clone(scenario.scene()?));
    let thresholds = Arc::clone(&scenario.thresholds);
    let told = work::run(py, move |_| {
        described(&scene, &thresholds, frame, span, &set)
    })?;
    Ok(told.map_err(Problem::from)?.described.text)
}

/// Settings of the configuration, and over them those that are named, which belong to these sections.
fn set(
    user: &User,
    section: &str,
    named: Option<&Bound<'_, PyDict>>,
) -> Result<Experiment, Problem> {
    let mut layers = Layers::<Experiment>::default();
    layers.fields("config.toml: ", &configured_experiment(&user.config));
    for (key, value) in named.into_iter().flatten() {
        let (key, value) = (key.to_string(), value.to_string());
        let rows = Experiment::rows()
            .iter()
            .filter(|row| row.section == section);
        let known: Vec<&str> = rows.map(|row| row.key).collect();
        if !known.contains(&key.as_str()) {
            return Err(Problem::new(nearmiss_base::system::unknown(
                "setting", &key, known,
            )));
        }
        layers.word(&key, &key, &value);
    }
    layers.checked().map_err(Problem::new)?;
    Ok(layers.fields_so_far())
}

/// The messages that a model receives about a window: a list of dicts with `role` and `content`.
#[pyfunction]
pub fn prompt<'py>(py: Python<'py>, window: &Window) -> PyResult<Bound<'py, PyAny>> {
    json(py, &window.question.messages())
}

/// The built-in judge's verdict on a window, from exact geometry: a dict with `dangerous`, `obstacles` (id, risk_score from 0,
/// a contact, to 5, none; reason), `critical_obstacles`, `probability` and `justification`; beside `dangerous` stands the word of the task:
/// `collision`, `safety_critical` or `high_risk`.
///
/// The tasks attacker and trajectory have no verdict.
#[pyfunction]
pub fn judge<'py>(py: Python<'py>, window: &Window) -> PyResult<Bound<'py, PyAny>> {
    let question = Arc::clone(&window.question);
    let judged = work::run(py, move |_| question.reference())?;
    let verdict = judged.ok_or_else(|| {
        Problem::new(format!(
            "the task {} has no verdict: ask about collision, safety or recording",
            window.task()
        ))
    })?;
    said(py, &ParsedAnswer::Verdict(verdict))
}

/// What an answer says; of a verdict whether that is dangerous, too, whatever the task calls it.
fn said<'py>(py: Python<'py>, answer: &ParsedAnswer) -> PyResult<Bound<'py, PyAny>> {
    let made = json(py, answer)?;
    if let Some(verdict) = answer.verdict() {
        made.set_item("dangerous", verdict.dangerous)?;
    }
    Ok(made)
}

/// The verdict that an answer to a window's question states, as a dict: for answers that come from elsewhere.
///
/// An answer without one is an error that says what is missing.
#[pyfunction]
pub fn read_verdict<'py>(
    py: Python<'py>,
    window: &Window,
    answer: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (task, answer) = (window.question.case.task, answer.to_string());
    let reading = work::run(py, move |_| verdict::read(task, &answer))?;
    said(py, &reading.map_err(Problem::new)?.said)
}

/// A model's answer about a window: a dict with `verdict`, `reasoning`, `answer`, tokens and cost, as `nearmiss ask --format json`.
///
/// model: `provider/model`; None for that of config.toml, else the built-in judge. Answers are kept in the user's store, so
/// that none is paid for twice; fresh=True asks again, sample=1 asks for a second one. base_url: the server, in place of the
/// provider's own. budget: the most that it may cost, US dollars. More keywords are settings of the request: temperature,
/// max_tokens, seed, effort.
#[pyfunction]
#[pyo3(signature = (window, model=None, *, base_url=None, budget=None, fresh=false, sample=0, store=true, **settings))]
#[allow(clippy::too_many_arguments)]
pub fn ask<'py>(
    py: Python<'py>,
    window: &Window,
    model: Option<&str>,
    base_url: Option<&str>,
    budget: Option<f64>,
    fresh: bool,
    sample: u32,
    store: bool,
    settings: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let user = User::read()?;
    let set = set(&user, "sampling", settings)?;
    let model = model
        .or(user.config.model.as_deref())
        .unwrap_or(nearmiss_scene::judge::MODEL)
        .to_string();
    let mut providers = user.config.provider.clone();
    if let Some(url) = base_url {
        let (name, _) = model.split_once('/').ok_or_else(|| {
            Problem::new("base_url needs model=\"provider/model\" with any provider name, such as local/default")
        })?;
        Server {
            url,
            ..Server::default()
        }
        .overlay(&mut providers, name);
    }
    let question = Arc::clone(&window.question);
    let answered = work::run(py, move |cancel| {
        let config_file = user
            .folders
            .as_ref()
            .map(Folders::config_file)
            .unwrap_or_default();
        let registry = Registry::lenient(&providers, &config_file);
        let folders = user.folders.iter().map(|folders| folders.config.as_path());
        let environment = Environment::with_files(&Vec::from_iter(folders));
        let budget = budget.or(user.config.budget);
        let models = Models::new(registry, environment, set.parameters(), budget);
        let judge = models.judge(&model).map_err(Problem::new)?;
        let store = match &user.folders {
            Some(folders) if store => Some(Arc::new(
                Store::open(&folders.store()).map_err(Problem::new)?,
            )),
            _ => None,
        };
        let request = AskRequest {
            question: &question,
            judge: &judge,
            store,
            options: RunOptions {
                sample,
                fresh,
                batch: None,
            },
        };
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build();
        let outcome = runtime.map_err(Problem::new)?.block_on(async {
            tokio::select! {
                outcome = ask_model(request, |_| {}) => outcome.map_err(Problem::new),
                // Dropping the request cancels it; what came until then is stored.
                () = asked_to_end(cancel) => Err(Problem::new("interrupted")),
            }
        })?;
        if let Some(why) = outcome.not_stored {
            return Err(Problem::new(why));
        }
        let document = AskDocument::new(&outcome.answer, &question, &judge);
        serde_json::to_string(&document).map_err(Problem::new)
    })?;
    py.import("json")?.getattr("loads")?.call1((answered?,))
}

async fn asked_to_end(cancel: &Cancel) {
    while !cancel.is_asked() {
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
}

/// Checks the sentences of a text about a scene: a list of dicts with `text`, `outcome` (right, wrong, open, not_understood)
/// and `claims`, each with `text` (where the value stands), `outcome`, `why` an open one cannot be decided, `kind`, `obstacle`,
/// `step`, `stated`, `actual`, `unit` and `truth` in words. Sentences that say nothing of the scene are not in it.
///
/// text: the reasoning of a model, or anyone's. window: what the text is about, as steps (first, last) or a Window; times and
/// "now" are read by it. prompt: what the model was shown; numbers of claims that it does not have are `invented`. trajectory:
/// what came with the text, [(t, x, y), ...] from the present on; what the ego is said to do is held against it.
#[pyfunction]
#[pyo3(signature = (text, scenario, window=None, *, prompt=None, trajectory=None))]
pub fn check<'py>(
    py: Python<'py>,
    text: String,
    scenario: &Scenario,
    window: Option<&Bound<'py, PyAny>>,
    prompt: Option<String>,
    trajectory: Option<Vec<[f64; 3]>>,
) -> PyResult<Bound<'py, PyAny>> {
    let way = waypoints(&trajectory.unwrap_or_default())
        .map_err(|why| PyValueError::new_err(why.to_string()))?;
    let (steps, times) = match window {
        None => (None, TimeOrigin::default()),
        Some(given) => match (given.cast::<Window>(), given.extract()) {
            (Ok(window), _) => (Some(window.get().steps()), window.get().question.times()),
            (_, Ok((first, last))) => (Some((first, last)), TimeOrigin::default()),
            _ => {
                let kind = given.get_type();
                return Err(PyTypeError::new_err(format!(
                    "window: expected a Window or (first step, last step), not {}",
                    kind.name()?
                )));
            }
        },
    };
    let scene = Arc::clone(scenario.scene()?);
    let found = work::run(py, move |_| {
        let subject = Subject {
            prompt: prompt.as_deref(),
            trajectory: &way,
            ..Subject::new(&scene, times, steps)
        };
        let found = sentences(&text, &subject);
        let record = |one| SentenceRecord::new(&text, one, &subject);
        found.iter().map(record).collect::<Vec<_>>()
    })?;
    json(py, &found)
}
