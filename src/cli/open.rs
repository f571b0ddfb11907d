//! Shared by commands: opening a scenario with its ego and warnings about both, and names of frames, tasks and techniques.

use std::collections::HashMap;
use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use nearmiss_ask::llm::{Environment, Parameters, Registry};
use nearmiss_ask::prompts::Techniques;
use nearmiss_base::system::unknown;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats as formats;
use nearmiss_formats::{
    Columns, EGO_FILES, EgoError, EgoSelection, Entry, EntryLocation, SearchResults, TableOptions,
    not_standard_input, only_part,
};
use nearmiss_scene::metrics::{Measure, OwnMeasures, Thresholds, measure, measures};
use nearmiss_scene::scenario::{
    EgoSource, Obstacle, ObstacleRole, Participant, Scenario, Scene, Severity,
};
use nearmiss_settings::{Config, ConfigError, Folders, TextFile};
use nearmiss_study::evaluation::Judge;
use nearmiss_workflow::{
    MissingEgo, Models, OpenError, OpenRequest, OpenedScene, StandIn, find, named_tables, open,
    read_as_said,
};

use tokio::runtime::Runtime;

use super::files::{Inputs, say_shared_names, without_side_files};
use super::plan::as_ego;
use super::{Command, Failure, Outcome, output};

/// Which scenario, and who is the ego in it.
#[derive(Debug, clap::Args)]
pub struct ScenarioArguments {
    /// Scenario file or name of a bundled scenario; a unique prefix of the name is enough.
    file: PathBuf,
    #[command(flatten)]
    ego: EgoChoice,
}

/// Who is the ego.
#[derive(Debug, Clone, Default, clap::Args, serde::Serialize)]
pub struct EgoChoice {
    /// Ego: an obstacle, a recorded motion or a planner [default: the recording beside the scenario, else `planner` if
    /// there is a planning problem, else the follower of the most dangerous pair]
    ///
    /// ID is an obstacle id, or its name in a table of tracks. FILE is a recorded trajectory, a Frenetix log or a
    /// CommonRoad solution. `planner` is the built-in planner, `planner:NAME` that of [planner.NAME] in config.toml or
    /// a command. FILE#ID and planner#ID choose the planning problem; #ID chooses it in the recording beside the
    /// scenario.
    #[arg(
        long,
        value_name = "ID|FILE[#ID]|planner[#ID]",
        allow_negative_numbers = true
    )]
    ego: Option<PathBuf>,
}

impl EgoChoice {
    /// As if it were said on the command line.
    pub fn said(ego: Option<&str>) -> Self {
        Self {
            ego: ego.map(PathBuf::from),
        }
    }

    /// Who that is in these scenarios; a planner drives in them first.
    ///
    /// # Errors
    /// An obstacle is named and a planning problem too, or standard input; or the planner drives in none of them.
    pub fn wanted(&self, entries: &[Entry]) -> Result<EgoSelection, Failure> {
        let (said, planning_problem) = self.parts();
        match said.and_then(Path::to_str).and_then(as_ego::named) {
            Some(planner) => as_ego::drive(planner, planning_problem, entries),
            None => recorded(said, planning_problem),
        }
    }

    /// Whether it is the one beside the scenario.
    pub fn is_beside(&self) -> bool {
        self.ego.is_none()
    }

    /// Who it is, and of which planning problem. A file whose name ends like one is a file.
    fn parts(&self) -> (Option<&Path>, Option<i64>) {
        let said = self.ego.as_deref();
        let split = said.filter(|file| !file.exists()).and_then(|said| {
            let (of, id) = said.to_str()?.rsplit_once('#')?;
            Some((of, id.parse().ok()?))
        });
        match split {
            Some(("", id)) => (None, Some(id)),
            Some((of, id)) => (Some(Path::new(of)), Some(id)),
            None => (said, None),
        }
    }
}

fn recorded(said: Option<&Path>, planning_problem: Option<i64>) -> Result<EgoSelection, Failure> {
    let Some(wanted) = said else {
        return Ok(match planning_problem {
            Some(planning_problem) => EgoSelection::BesideFor { planning_problem },
            None => EgoSelection::Beside,
        });
    };
    // A file that is called like a number is meant by `./7`.
    match wanted.to_str().and_then(|text| text.parse().ok()) {
        Some(id) if planning_problem.is_some() => Err(Failure::input(format!(
            "--ego {id} is an obstacle, which has no planning problem; #ID chooses one of a file or planner"
        ))),
        Some(id) => Ok(EgoSelection::Obstacle(id)),
        None => {
            not_standard_input(wanted).map_err(Failure::input)?;
            Ok(EgoSelection::File {
                path: wanted.to_path_buf(),
                planning_problem,
            })
        }
    }
}

impl ScenarioArguments {
    /// Opens the scene.
    pub fn open(&self) -> Result<(Entry, Arc<Scene>), Failure> {
        check_reading(std::slice::from_ref(&self.file), None)?;
        let entry = entry(&self.file)?;
        let scene = scene(&entry, &self.ego)?;
        Ok((entry, scene))
    }
}

/// The entry that an argument means, if it is a file or the name of a bundled scenario.
pub fn entry(argument: &Path) -> Result<Entry, Failure> {
    // Of one scenario in a file, the name is the one that lists and stored answers have.
    let entry = Entry::of_argument(&only_part(&resolved(argument)?));
    match &entry.place {
        EntryLocation::File(path) if path.is_dir() => Err(Failure::input(format!(
            "{} is a folder; this command takes one scenario. `inspect`, `metrics` and `evaluate` take folders",
            path.display()
        ))),
        _ => Ok(entry),
    }
}

/// The path that an argument means: itself, or the bundled scenario whose name begins so, if it is the only one.
///
/// # Errors
/// There is no such file or scenario, with what was probably meant; or several scenarios begin so.
pub fn resolved(argument: &Path) -> Result<PathBuf, Failure> {
    formats::resolved(argument).map_err(Failure::input)
}

/// More files that were passed over are not named each.
const MAX_LISTED: usize = 20;

/// Two scenarios of the same name, which would be written to the same file.
pub fn clash(entries: &[Entry]) -> Option<(&Entry, &Entry)> {
    let mut seen = HashMap::new();
    entries
        .iter()
        .find_map(|entry| Some((seen.insert(&entry.name, entry)?, entry)))
}

/// Refuses options for tables that apply to none of these arguments, and a file to write that is one of them.
pub fn check_reading(paths: &[PathBuf], output: Option<&Path>) -> Outcome {
    let paths: Result<Vec<PathBuf>, _> = paths.iter().map(|path| formats::resolved(path)).collect();
    // One that is not there is said where it is opened.
    let Ok(paths) = paths else {
        return Ok(());
    };
    let entries: Vec<Entry> = paths.iter().map(|path| Entry::of_argument(path)).collect();
    formats::check_table_options(&entries, false).map_err(Failure::input)?;
    Inputs::of(&entries).spare(output)
}

/// The scenarios at `paths`. What was passed over is said.
///
/// # Errors
/// One cannot be found, or an option for tables applies to none of them.
pub fn found(paths: &[PathBuf]) -> Result<Vec<Entry>, Failure> {
    found_beside(paths, false)
}

/// The same; `has_tables` is whether tables are read beside them.
pub fn found_beside(paths: &[PathBuf], has_tables: bool) -> Result<Vec<Entry>, Failure> {
    let paths = without_side_files(paths);
    let paths = paths.iter().map(|path| resolved(path));
    let found = find(&paths.collect::<Result<Vec<_>, _>>()?).map_err(Failure::input)?;
    formats::check_table_options(&found.entries, has_tables).map_err(Failure::input)?;
    Ok(with_notes(found))
}

/// The scenarios that were found. What was passed over is said, and which have the same name.
pub fn with_notes(found: SearchResults) -> Vec<Entry> {
    let all = &found.passed_over;
    if (1..=MAX_LISTED).contains(&all.len()) {
        let count = found.passed_over_count().unwrap_or_default();
        output::say(&format!("nearmiss: {count} skipped:"));
        all.iter().for_each(|one| output::say(&format!("  {one}")));
    } else if let Some(words) = found.passed_over_in_short() {
        output::say(&format!("nearmiss: {words}"));
    }
    say_shared_names(&found.entries);
    found.entries
}

/// A scene, and warnings about its ego.
pub type Opened = (Arc<Scene>, Vec<String>);

/// The scene of an entry, with an obstacle or a file's ego. What is doubtful about the ego is said.
pub fn scene(entry: &Entry, choice: &EgoChoice) -> Result<Arc<Scene>, Failure> {
    scene_with(entry, &choice.wanted(std::slice::from_ref(entry))?)
}

/// The same with an ego given by id, file or place.
pub fn scene_with(entry: &Entry, wanted: &EgoSelection) -> Result<Arc<Scene>, Failure> {
    let (scene, doubts) = scene_and_doubts(entry, wanted)?;
    doubts.iter().for_each(|doubt| output::say(doubt));
    Ok(scene)
}

/// The scene of an entry with an ego that is told by id, file or place, and warnings about the ego.
pub fn scene_and_doubts(entry: &Entry, wanted: &EgoSelection) -> Result<Opened, Failure> {
    let opened = opened(entry, wanted)?;
    match opened.scene {
        Ok(scene) => Ok(with_doubts(entry, scene, opened.stands_in)),
        Err(why) => Err(without_ego(entry, &opened.scenario, &why)),
    }
}

/// That a scenario has no ego, what was looked for, and what to do.
pub fn without_ego(entry: &Entry, scenario: &Scenario, why: &MissingEgo) -> Failure {
    let more = match why {
        MissingEgo::NotDriven(why) => format!("; the built-in planner does not drive: {why}"),
        _ => String::new(),
    };
    Failure::input(format!(
        "{}: no recorded ego{}{more}; choose an obstacle with --ego ID ({}), or a file with --ego FILE",
        entry.display(),
        looked_for(scenario),
        possible(scenario)
    ))
}

/// Who is the ego where none is recorded: with a planning problem the built-in planner drives, as `--ego planner` does.
pub fn stand_in() -> StandIn<'static> {
    static SETTINGS: OnceLock<Settings> = OnceLock::new();
    StandIn::Planner(SETTINGS.get_or_init(|| {
        let config = configuration().map(|(_, config)| config);
        as_ego::settings(&config.unwrap_or_default())
    }))
}

/// The scene of an entry with the ego beside it or who stands in for it, and warnings about that; `None` if there is none.
pub fn scene_beside(entry: &Entry) -> Result<Option<Opened>, Failure> {
    let opened = opened(entry, &EgoSelection::Beside)?;
    let scene = opened.scene.ok();
    Ok(scene.map(|scene| with_doubts(entry, scene, opened.stands_in)))
}

fn opened(entry: &Entry, wanted: &EgoSelection) -> Result<OpenedScene, Failure> {
    let request = OpenRequest {
        entry,
        ego: wanted,
        transform: None,
        strict: true,
        stand_in: stand_in(),
    };
    open(&request).map_err(not_opened)
}

/// Why a scenario cannot be opened, with advice.
pub fn not_opened(error: OpenError) -> Failure {
    match error {
        OpenError::Ego(error) => advised(error),
        error => Failure::input(error),
    }
}

fn with_doubts(entry: &Entry, scene: Arc<Scene>, stands_in: bool) -> Opened {
    let chosen = stands_in.then(|| said_once(&scene)).flatten();
    let doubts = chosen.into_iter().chain(doubts(entry, &scene)).collect();
    (scene, doubts)
}

/// Who stands in for egos that are not recorded; nothing where that has been said: tables name the ego of each scenario.
pub fn said_once(scene: &Scene) -> Option<String> {
    static SAID: [AtomicBool; 2] = [const { AtomicBool::new(false) }; 2];
    let (place, who) = match scene.ego.source {
        EgoSource::Planned { .. } => (0, "the built-in planner drives the planning problem"),
        _ => (
            1,
            "without a planning problem the follower of the most dangerous pair is the ego",
        ),
    };
    let is_new = !SAID[place].swap(true, Ordering::Relaxed);
    let looked_for = looked_for(&scene.scenario);
    is_new.then(|| format!("nearmiss: no recorded ego{looked_for}; {who}; --ego chooses another"))
}

/// Which files with an ego were looked for, in brackets; nothing where recordings have theirs inside.
pub fn looked_for(scenario: &Scenario) -> String {
    match scenario.header.other_format {
        None => format!(" ({EGO_FILES})"),
        Some(_) => String::new(),
    }
}

/// Some obstacles that could be the ego.
fn possible(scenario: &Scenario) -> String {
    let ids = scenario.possible_egos();
    let mut some: Vec<String> = ids.iter().take(8).map(i64::to_string).collect();
    if ids.len() > some.len() {
        some.push("… (`nearmiss inspect` lists all)".into());
    }
    if some.is_empty() {
        return "none has a trajectory".into();
    }
    some.join(", ")
}

/// An error about an ego, with what to do on the command line.
pub fn advised(error: EgoError) -> Failure {
    let advice = match &error {
        EgoError::Several { .. } => ", as --ego FILE#ID",
        EgoError::Io { source, .. } if source.kind() == ErrorKind::NotFound => {
            "; --ego takes the id of an obstacle or its name in a table, a file, or planner"
        }
        _ => "",
    };
    Failure::input(format!("{error}{advice}"))
}

/// Folders and configuration; a configuration that cannot be used is an error here, where no warning could be seen.
pub fn configuration() -> Result<(Folders, Config), Failure> {
    let folders = Folders::find().map_err(Failure::input)?;
    folders.close();
    let config = Config::read(&folders.config_file()).map_err(unusable)?;
    Ok((folders, config))
}

/// Puts the measures of the configuration in use. Arguments name measures, so that it comes before them.
///
/// # Errors
/// One of them is wrong; then none is in use.
pub fn use_own_measures() -> Result<(), ConfigError> {
    // Without a home folder there are none.
    let Ok(folders) = Folders::find() else {
        return Ok(());
    };
    Config::measures(&folders.config_file()).map(OwnMeasures::register)
}

/// The measure with this id, of an argument.
pub fn named_measure(id: &str) -> Result<&'static Measure, String> {
    measure(id).ok_or_else(|| {
        // It may be one of the user's.
        if let Err(error) = use_own_measures() {
            return error.in_short();
        }
        let unknown = unknown("measure", id, measures().map(|m| m.id));
        format!("{unknown}\n`nearmiss metrics --list` lists all")
    })
}

/// How tables of tracks are read, and which map they lie on.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Reading {
    /// Columns of tables of tracks, such as `time=t[ms],id=track,x=px[ft],y=py[down]`; see `nearmiss help tracks` for
    /// roles and units [default: from the column names].
    // `report` has an option of that name of its own, which is this one for clap: both are texts.
    #[arg(long, global = true, value_name = "ROLE=COLUMN,…", help_heading = TABLES, value_parser = spelled::<Columns>)]
    columns: Option<String>,
    /// Frame rate in Hz, for tables that count frames instead of time.
    #[arg(long, global = true, value_name = "HZ", help_heading = TABLES, value_parser = rate)]
    rate: Option<f64>,
    /// Map for tables of tracks: Lanelet2, OpenDRIVE, CommonRoad or a SUMO net.
    #[arg(long, global = true, value_name = "FILE", help_heading = TABLES)]
    map: Option<PathBuf>,
}

/// Over these options in `--help`.
const TABLES: &str = "Tables of tracks";

/// A text that says a `T`.
pub fn spelled<T: FromStr<Err: Display>>(text: &str) -> Result<String, String> {
    match text.parse::<T>() {
        Ok(_) => Ok(text.to_string()),
        Err(error) => Err(error.to_string()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text
        .parse()
        .map_err(|_| "expected a number of frames a second".to_string())?;
    if rate > 0.0 && rate <= 1e6 {
        return Ok(rate);
    }
    Err("expected a rate above 0".into())
}

impl Reading {
    /// Tells the readers of recordings what the user says of tables, where the user's maps are, and who plays scenarios. What
    /// else is wrong with the configuration is said by those who need it.
    ///
    /// # Errors
    /// The configuration explains a table with words that no column has, or has a wrong measure. The workbench and the
    /// commands that look at the configuration say the latter themselves.
    pub fn apply(&self, command: Option<&Command>) -> Outcome {
        if let Err(error) = use_own_measures()
            && command.is_some_and(Command::stops_at_mistakes)
        {
            return Err(unusable(error));
        }
        let folders = Folders::find().ok();
        let config = match folders.as_ref().map(|f| Config::read(&f.config_file())) {
            Some(Err(error)) if command.is_some_and(Command::stops_at_mistakes) => {
                return Err(unusable(error));
            }
            Some(Ok(config)) => config,
            _ => Config::default(),
        };
        let is_axis = matches!(command, Some(Command::Report(_)));
        let columns = self.columns.as_ref().filter(|_| !is_axis);
        let said = TableOptions {
            columns: columns.and_then(|said| said.parse().ok()),
            rate: self.rate,
            map: self.map.clone(),
            named: named_tables(&config).map_err(Failure::input)?,
        };
        read_as_said(said, &config, folders.as_ref());
        Ok(())
    }
}

/// What is wrong with the configuration, a line for each mistake.
pub fn unusable(error: ConfigError) -> Failure {
    let mut mistakes: Vec<String> = error.mistakes_in_words().collect();
    let last = mistakes.pop().unwrap_or_default();
    for mistake in mistakes {
        output::say(&format!("nearmiss: {mistake}"));
    }
    Failure::input(last)
}

/// The shipped thresholds, changed by the user's file in the configuration folder if there is one.
pub fn user_thresholds(folders: &Folders) -> Result<Thresholds, Failure> {
    folders.user_thresholds().map_err(Failure::input)
}

/// The thresholds of the user; without a home folder there are none, and the shipped ones hold.
pub fn thresholds_in_use() -> Result<Thresholds, Failure> {
    match Folders::find() {
        Ok(folders) => user_thresholds(&folders),
        Err(_) => Ok(Thresholds::shipped().clone()),
    }
}

/// The shipped thresholds, changed by a file.
pub fn thresholds_of(path: &Path) -> Result<Thresholds, Failure> {
    let said =
        TextFile::read(path).map_err(|error| Failure::input(format!("--thresholds {error}")))?;
    Thresholds::read(&said.text, &said.file).map_err(Failure::input)
}

/// What waits for the network, on so many threads.
pub fn runtime(threads: usize) -> Result<Runtime, Failure> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(threads)
        .enable_all()
        .build()
        .map_err(Failure::input)
}

/// The parameters of config.toml, without what single commands ask for.
pub fn configured_parameters(config: &Config) -> Parameters {
    Parameters {
        log_probabilities: false,
        ..nearmiss_workflow::parameters(config)
    }
}

/// The models of these providers.
pub fn configured_models(
    providers: &toml::Table,
    folders: &Folders,
    parameters: Parameters,
    budget: Option<f64>,
) -> Models {
    Models::new(
        Registry::lenient(providers, &folders.config_file()),
        Environment::with_files(&[Path::new("."), &folders.config]),
        parameters,
        budget,
    )
}

/// The judge with a model's name; a key that came with the current folder is told.
pub fn judge_of(models: &Models, model: &str) -> Result<Judge, Failure> {
    if let Some(key) = models.key_of_folder(model) {
        output::say(&format!("nearmiss: {key}"));
    }
    models.judge(model).map_err(Failure::input)
}

/// `cp,cot,icl`, `base` or `all`.
pub fn techniques(words: &str) -> Result<Techniques, String> {
    Techniques::parse(words)
}

/// Warnings about a scenario and its ego.
pub fn doubts(entry: &Entry, scene: &Scene) -> Vec<String> {
    let ego = &scene.ego;
    let doubts = ego
        .diagnostics
        .iter()
        .filter(|doubt| doubt.severity == Severity::Warning)
        .map(|doubt| {
            let line = match doubt.line {
                0 => String::new(),
                line => format!("line {line}: "),
            };
            format!("nearmiss: ego {}: {line}{}", ego.source, doubt.message)
        });
    let scenario = &scene.scenario;
    doubts
        .chain(without_lanes(entry, scenario))
        .chain(left_out(entry, scenario))
        .chain(with_gaps(entry, scenario))
        .chain(double(entry, scene))
        .collect()
}

/// Says that what needs lanes is missing.
fn without_lanes(entry: &Entry, scenario: &Scenario) -> Option<String> {
    scenario.network.lanelets.is_empty().then(|| {
        format!(
            "nearmiss: {}: no lanes, so measures and rules that need them are missing; see `nearmiss inspect`",
            entry.display()
        )
    })
}

/// Describes obstacles without a shape: results ignore them, and may be wrong for that.
fn left_out(entry: &Entry, scenario: &Scenario) -> Option<String> {
    let solid = |role| matches!(role, ObstacleRole::Static | ObstacleRole::Dynamic);
    let lost = |o: &&Obstacle| solid(o.role) && o.any_footprint().is_none();
    let ids = ids(scenario, lost);
    let count = scenario.obstacles.len();
    (!ids.is_empty()).then(|| {
        format!(
            "nearmiss: {}: {} of {count} obstacles ignored in measures and verdicts, as they have no usable shape: {}; \
             see `nearmiss inspect`",
            entry.display(),
            ids.len(),
            ids[..ids.len().min(MAX_IDS_LISTED)].join(", ")
        )
    })
}

/// Names obstacles that are not recorded at each step between their first and their last: they count as absent there.
fn with_gaps(entry: &Entry, scenario: &Scenario) -> Option<String> {
    let gap = |o: &&Obstacle| {
        let steps = o.track().steps();
        !o.is_set_based() && (o.track().iter().count() as i64) < steps.end - steps.start
    };
    let ids = ids(scenario, gap);
    (!ids.is_empty()).then(|| {
        format!(
            "nearmiss: {}: obstacles with gaps in their tracks, absent in these: {}{}; see `nearmiss inspect`",
            entry.display(),
            ids[..ids.len().min(MAX_IDS_LISTED)].join(", "),
            match ids.len().saturating_sub(MAX_IDS_LISTED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            }
        )
    })
}

/// Names an obstacle that is where the ego is at each step: the recording of the ego as one of the others.
fn double(entry: &Entry, scene: &Scene) -> Option<String> {
    let is_double = |other: &Participant<'_>| {
        let pairs = scene.ego.track.iter();
        let mut apart = pairs.filter_map(|(step, ego)| {
            Some((other.at(step)?.pose.position - ego.pose.position).norm())
        });
        let first = apart.next().is_some_and(|metres| metres < SAME_PLACE);
        first && apart.all(|metres| metres < SAME_PLACE)
    };
    let double = scene.participants().find(is_double)?;
    let id = double.obstacle.id;
    let instead = match Scene::with_obstacle_as_ego(Arc::clone(&scene.scenario), id) {
        Ok(_) => format!("; if it is the ego, `--ego {id}` says so"),
        Err(_) => String::new(),
    };
    Some(format!(
        "nearmiss: {}: obstacle {id} is where the ego is at each step, so that they touch all the time{instead}",
        entry.display()
    ))
}

/// Nearer to each other at each step two tracks are of one vehicle, metres.
const SAME_PLACE: f64 = 0.05;

/// Obstacles named in a warning.
const MAX_IDS_LISTED: usize = 12;

fn ids(scenario: &Scenario, of: impl Fn(&&Obstacle) -> bool) -> Vec<String> {
    let obstacles = scenario.obstacles.iter().filter(of);
    obstacles.map(|o| o.id.to_string()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::Arc;

    use super::*;
    use nearmiss_formats::bundled;
    use nearmiss_scene::scenario::{ObstacleParts, Prediction, State};

    #[test]
    fn gaps_in_tracks_and_the_ego_among_the_others_are_named() {
        let entry = &bundled()[0];
        let mut scenario = (*entry.read().unwrap()).clone();
        let is_long = |o: &&Obstacle| o.role == ObstacleRole::Dynamic && o.states().count() > 30;
        let ego = scenario.obstacles.iter().find(is_long).unwrap().clone();
        let again = |id: i64, states: Vec<State>| {
            let parts = ObstacleParts {
                id,
                role: ego.role,
                kind: ego.kind,
                footprint: ego.footprint.clone(),
                initial: ego.initial.clone(),
                prediction: Prediction::Trajectory(states),
                signals: Vec::new(),
            };
            Obstacle::new(parts, 0.1)
        };
        let states: Vec<State> = ego.states().skip(1).cloned().collect();
        let of = |scenario: &Scenario| {
            let scene = Scene::with_obstacle_as_ego(Arc::new(scenario.clone()), ego.id).unwrap();
            doubts(entry, &scene).join("\n")
        };
        assert_eq!(of(&scenario), "");
        scenario.obstacles.push(again(9001, states.clone()));
        scenario
            .obstacles
            .push(again(9002, [&states[..5], &states[9..]].concat()));
        let told = of(&scenario);
        assert!(
            told.contains("obstacle 9001 is where the ego is at each step"),
            "{told}"
        );
        assert!(
            told.contains("gaps in their tracks, absent in these: 9002;"),
            "{told}"
        );
    }
}
