//! What the commands share: opening a scenario with its ego, and the words for frames, tasks and techniques.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Arguments, Failure, output};
use crate::config::{Config, Folders, TextFile};
use crate::evaluation::Settings;
use crate::metrics::Thresholds;
use crate::prompts::{MOST_DECIMALS, Techniques};
use crate::scenario::{
    EgoError, Entry, Place, Scenario, Scene, Severity, WantedEgo, Window, bundled, find,
    not_standard_input,
};
use crate::text::{Form, Frame};
use crate::verdict::Task;

/// Which scenario, and who is the ego in it.
#[derive(Debug, clap::Args)]
pub struct Which {
    /// A CommonRoad file, or the name of a bundled scenario.
    file: PathBuf,
    #[command(flatten)]
    ego: EgoChoice,
}

/// Who is the ego.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct EgoChoice {
    /// Who is the ego: the id of an obstacle, or a file with a recorded trajectory, a log of Frenetix or a CommonRoad
    /// solution [default: the file that lies with the scenario].
    #[arg(long, value_name = "ID|FILE", allow_negative_numbers = true)]
    ego: Option<PathBuf>,
    /// The planning problem whose vehicle is the ego, where the file solves several.
    #[arg(
        long,
        value_name = "ID",
        requires = "ego",
        allow_negative_numbers = true
    )]
    planning_problem: Option<i64>,
}

impl EgoChoice {
    /// Who that is.
    ///
    /// # Errors
    /// An obstacle is named and a planning problem too, or standard input.
    pub fn wanted(&self) -> Result<WantedEgo, Failure> {
        let Some(wanted) = &self.ego else {
            return Ok(WantedEgo::Beside);
        };
        let planning_problem = self.planning_problem;
        // A file that is called like a number is meant by `./7`.
        match wanted.to_str().and_then(|text| text.parse().ok()) {
            Some(_) if planning_problem.is_some() => Err(Failure::input(
                "--planning-problem chooses among the egos of a file; --ego names an obstacle",
            )),
            Some(id) => Ok(WantedEgo::Obstacle(id)),
            None => {
                not_standard_input(wanted).map_err(Failure::input)?;
                Ok(WantedEgo::File {
                    path: wanted.clone(),
                    planning_problem,
                })
            }
        }
    }
}

impl Which {
    /// Opens the scene.
    pub fn open(&self) -> Result<(Entry, Arc<Scene>), Failure> {
        let entry = entry(&self.file)?;
        let scene = scene(&entry, &self.ego)?;
        Ok((entry, scene))
    }
}

/// The entry that an argument means, if it is a file or the name of a bundled scenario.
pub fn entry(argument: &Path) -> Result<Entry, Failure> {
    not_standard_input(argument).map_err(Failure::input)?;
    let entry = Entry::of_argument(argument);
    if let Place::File(path) = &entry.place {
        let shown = path.display();
        match path.metadata() {
            Ok(found) if found.is_dir() => {
                return Err(Failure::input(format!(
                    "{shown} is a folder; this command takes one scenario, `nearmiss metrics` takes folders"
                )));
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let names: Vec<String> = bundled().into_iter().map(|e| e.name).collect();
                return Err(Failure::input(format!(
                    "{shown}: no such file; the bundled scenarios are {}",
                    names.join(", ")
                )));
            }
            _ => {}
        }
    }
    Ok(entry)
}

/// Who shall be the ego in the workbench, checked as far as that needs no screen.
///
/// # Errors
/// An ego is chosen, and there is a command, or the paths are not one scenario, or it cannot be the ego there.
pub fn chosen_ego(arguments: &Arguments) -> Result<WantedEgo, Failure> {
    let wanted = arguments.ego.wanted()?;
    if wanted == WantedEgo::Beside {
        return Ok(wanted);
    }
    if arguments.command.is_some() {
        return Err(Failure::input(
            "--ego before a command is that of the workbench; put it behind: nearmiss COMMAND FILE --ego ID|FILE",
        ));
    }
    let entries = match &arguments.paths[..] {
        [] => bundled(),
        paths => find(paths).map_err(Failure::input)?.entries,
    };
    let [entry] = &entries[..] else {
        return Err(Failure::input(format!(
            "--ego is the ego of one scenario, and here are {}; name one file or bundled scenario",
            entries.len()
        )));
    };
    let scenario = entry.read().map_err(Failure::input)?;
    wanted.of(entry, &scenario).map_err(advised)?;
    Ok(wanted)
}

/// The scenarios at `paths`. What was passed over is said.
pub fn found(paths: &[PathBuf]) -> Result<Vec<Entry>, Failure> {
    let found = find(paths).map_err(Failure::input)?;
    if let Some(words) = found.passed_over_in_short() {
        output::say(&format!("nearmiss: {words}"));
    }
    Ok(found.entries)
}

/// The scene of an entry, with an obstacle or a file's ego. What is doubtful about the ego is said.
pub fn scene(entry: &Entry, choice: &EgoChoice) -> Result<Arc<Scene>, Failure> {
    scene_with(entry, &choice.wanted()?)
}

/// The same with an ego that is told by id, file or place.
pub fn scene_with(entry: &Entry, wanted: &WantedEgo) -> Result<Arc<Scene>, Failure> {
    let (scene, doubts) = wanted_scene(entry, wanted)?;
    doubts.iter().for_each(|doubt| output::say(doubt));
    Ok(scene)
}

/// The scene of an entry, with an obstacle or a file's ego, and what is doubtful about the ego, in words.
pub fn scene_and_doubts(
    entry: &Entry,
    choice: &EgoChoice,
) -> Result<(Arc<Scene>, Vec<String>), Failure> {
    wanted_scene(entry, &choice.wanted()?)
}

/// The same with an ego that is already told by id, file or place.
fn wanted_scene(entry: &Entry, wanted: &WantedEgo) -> Result<(Arc<Scene>, Vec<String>), Failure> {
    let scenario = entry.read().map_err(Failure::input)?;
    let Some(ego) = wanted.of(entry, &scenario).map_err(advised)? else {
        return Err(Failure::input(format!(
            "{}: no recorded ego (NAME.ego_trajectory.csv beside it); choose an obstacle with --ego ID ({}), \
             or a file with --ego FILE",
            entry.display(),
            possible(&scenario)
        )));
    };
    let doubts = ego.diagnostics.iter();
    let doubts = doubts.filter(|doubt| doubt.severity == Severity::Warning);
    let doubts = doubts.map(|doubt| {
        let line = match doubt.line {
            0 => String::new(),
            line => format!("line {line}: "),
        };
        format!("nearmiss: ego {}: {line}{}", ego.source, doubt.message)
    });
    let doubts = doubts.collect();
    Ok((Arc::new(Scene::new(scenario, ego)), doubts))
}

/// Some obstacles that could be the ego.
fn possible(scenario: &Scenario) -> String {
    let ids = scenario.possible_egos();
    let mut some: Vec<String> = ids.iter().take(8).map(i64::to_string).collect();
    if ids.len() > some.len() {
        some.push("…, all of them: `nearmiss inspect`".into());
    }
    if some.is_empty() {
        return "none has a trajectory".into();
    }
    some.join(", ")
}

/// An error about an ego, with what to do on the command line.
pub fn advised(error: EgoError) -> Failure {
    let advice = match &error {
        EgoError::Several { .. } => ", with --ego FILE --planning-problem ID",
        EgoError::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            "; --ego takes the id of an obstacle or a file"
        }
        _ => "",
    };
    Failure::input(format!("{error}{advice}"))
}

/// Which steps are looked at, and how they are described.
#[derive(Debug, clap::Args)]
pub struct Span {
    /// Last step of the window [default: the last step; for the safety task two steps before it].
    #[arg(long, value_name = "STEP", allow_negative_numbers = true)]
    at: Option<i64>,
    /// Steps in the window [default: what the template says, else 10].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    history: Option<u32>,
    /// Only every so many steps are described, the last one always [default: what the template says, else 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    stride: Option<u32>,
    /// Obstacles farther from the ego are left out, metres [default: what the template says, else 30].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    radius: Option<f64>,
    /// Decimals of metres, m/s and m/s²; radians get one more [default: what the template says, else 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=MOST_DECIMALS as i64))]
    precision: Option<u8>,
    /// Sentences or a table: prose or compact [default: what the template says, else prose].
    #[arg(long, value_parser = form)]
    form: Option<Form>,
    /// The one obstacle that is described; the trajectory frame needs it.
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    obstacle: Option<i64>,
}

impl Span {
    /// The window in a scene, of so many steps.
    pub fn window(
        &self,
        scene: &Scene,
        task: Option<Task>,
        history: usize,
    ) -> Result<Window, Failure> {
        let steps = scene.steps();
        if let Some(at) = self.at.filter(|at| !steps.contains(at)) {
            return Err(Failure::input(format!(
                "--at {at}: the ego is recorded from step {} to {}",
                steps.start,
                steps.end - 1
            )));
        }
        // The paper's safety inference looks at a window that ends two steps before the last one.
        let back = if task == Some(Task::Safety) { 2 } else { 0 };
        let last = self.at.unwrap_or(steps.end - 1 - back);
        Ok(Window::ending_at(scene, last, history))
    }

    /// What the user says, here and in the configuration, about how a scene is described.
    pub fn settings(
        &self,
        techniques: Option<Techniques>,
        config: &Config,
    ) -> Result<Settings, Failure> {
        let radius = self.radius.or(config.radius);
        if radius.is_some_and(|r| !(r.is_finite() && r > 0.0)) {
            return Err(Failure::input(
                "--radius must be a positive number of metres",
            ));
        }
        Ok(Settings {
            history: self.history.map(|steps| steps as usize).or(config.history),
            stride: self.stride.map(|steps| steps as usize),
            radius,
            precision: self.precision.map(usize::from),
            form: self.form,
            techniques,
            obstacle: self.obstacle,
        })
    }
}

/// Folders and configuration; a configuration that cannot be used is an error here, where nobody could see a warning.
pub fn configuration() -> Result<(Folders, Config), Failure> {
    let folders = Folders::find().map_err(Failure::input)?;
    let config = Config::read(&folders.config_file()).map_err(Failure::input)?;
    Ok((folders, config))
}

/// The shipped thresholds, changed by the user's file in the configuration folder if there is one.
pub fn user_thresholds(folders: &Folders) -> Result<Thresholds, Failure> {
    match TextFile::read_if_there(&folders.thresholds()).map_err(Failure::input)? {
        Some(said) => Thresholds::read(&said.text, &said.file).map_err(Failure::input),
        None => Ok(Thresholds::shipped().clone()),
    }
}

/// The shipped thresholds, changed by a file.
pub fn thresholds_of(path: &Path) -> Result<Thresholds, Failure> {
    let said =
        TextFile::read(path).map_err(|error| Failure::input(format!("--thresholds {error}")))?;
    Thresholds::read(&said.text, &said.file).map_err(Failure::input)
}

/// The name of a task.
pub fn task(word: &str) -> Result<Task, String> {
    let names = Task::ALL.map(Task::name).join(", ");
    Task::parse(word).ok_or_else(|| format!("there are {names}"))
}

/// The name of a frame.
pub fn frame(word: &str) -> Result<Frame, String> {
    Frame::parse(word).ok_or_else(|| format!("there are {}", Frame::names()))
}

/// `prose` or `compact`.
fn form(word: &str) -> Result<Form, String> {
    Form::parse(word).ok_or_else(|| "there are prose and compact".into())
}

/// `cp,cot,icl`, `base` or `all`.
pub fn techniques(words: &str) -> Result<Techniques, String> {
    Techniques::parse(words)
}
