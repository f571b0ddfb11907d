//! `nearmiss convert`: rewrites scenarios of any format as CommonRoad 2020a XML, or as OpenSCENARIO for simulators.

use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::commonroad::{NewFile, conform, write};
use nearmiss_formats::{
    EgoError, EgoSelection, Entry, EntryLocation, USUAL_VEHICLE, find_recording,
    not_standard_input, write_recording, write_sized_recording,
};
use nearmiss_scene::scenario::{Ego, EgoSource, Scenario, alike, in_short};
use nearmiss_workflow::{ExportRequest, SimulatedEgo, VariantOrigin, export_to_simulator};
use serde::{Deserialize, Serialize};

use super::ending::interrupted;
use super::many_files::{Failed, Job, ManyFiles, NEXT, RunJournal, Unit, holds};
use super::open::{clash, configuration, found};
use super::plan::as_ego;
use super::{Failure, Outcome, output};

/// Arguments of `convert`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Convert {
    /// Scenario files of any format, folders or names of bundled scenarios.
    #[arg(required = true)]
    #[serde(skip)]
    paths: Vec<PathBuf>,
    /// File to write (.xml or .xosc), or an existing folder; several scenarios need a folder [default: standard output,
    /// CommonRoad only].
    #[arg(short, long, value_name = "PATH")]
    #[serde(skip)]
    output: Option<PathBuf>,
    /// CommonRoad: change what the published schema does not allow, and report each change.
    #[arg(long)]
    schema: bool,
    /// Replace existing files.
    #[arg(long)]
    #[serde(skip)]
    overwrite: bool,
    #[command(flatten)]
    #[serde(skip)]
    many: ManyFiles,
    #[command(flatten)]
    #[serde(flatten)]
    simulator: SimulatorOptions,
}

/// Runs `convert`.
pub fn run(arguments: &Convert) -> Outcome {
    let for_simulators = arguments.simulator.wanted(arguments.output.as_deref())?;
    if for_simulators && arguments.schema {
        return Err(Failure::input(
            "--schema applies to CommonRoad; OpenSCENARIO files conform to their own schema",
        ));
    }
    let entries = arguments.many.part.of(found(&arguments.paths)?);
    let folder = arguments.output.as_deref().filter(|path| path.is_dir());
    if entries.len() > 1 && folder.is_none() {
        return Err(Failure::input(format!(
            "{} scenarios need an existing folder: -o FOLDER",
            entries.len()
        )));
    }
    if let Some((a, b)) = folder.and_then(|_| clash(&entries)) {
        return Err(Failure::input(format!(
            "{} and {} would both become {}.{}; convert them into different folders",
            a.display(),
            b.display(),
            a.name,
            if for_simulators { "xosc" } else { "xml" }
        )));
    }
    let journal = arguments.many.journal("convert", folder, arguments)?;
    let ego = if for_simulators {
        Some(arguments.simulator.ego(&entries)?)
    } else {
        None
    };
    // Before anything is written, so that no file is left half written.
    let stop = interrupted(true);
    let conversion = Conversion {
        arguments,
        ego,
        folder,
        journal,
        cancel: Cancel::from_flag(&stop),
    };
    let (mut failed, mut unfit) = (Failed::of(entries.len()), 0);
    let to_file = conversion.target(None).is_some();
    let done = Job::new("scenarios", &stop).writing_file(to_file).run(
        &entries,
        |entry| {
            let convert = || Some(conversion.convert(entry));
            conversion.journal.unit(entry, convert)
        },
        |entry, unit| {
            match unit.and_then(|unit| conversion.take(entry, unit)) {
                Ok(Notes { fits }) => unfit += usize::from(!fits),
                Err(failure) => failed.add(failure),
            }
            NEXT
        },
    );
    done.end(match folder {
        Some(_) => "finished files are kept; the same command with --resume continues",
        None => "",
    })?;
    if failed.count == 0 && unfit > 0 && arguments.schema {
        return Err(Failure::finding(format!(
            "{unfit} of {} do not conform to the schema; see above",
            output::counted(entries.len(), "scenario")
        )));
    }
    failed.end("converted")
}

/// What holds for all scenarios of a call.
struct Conversion<'a> {
    arguments: &'a Convert,
    /// The ego for simulators; `None` where CommonRoad is written.
    ego: Option<SimulatedEgo>,
    folder: Option<&'a Path>,
    journal: RunJournal,
    cancel: Cancel,
}

/// A scenario as it is written.
#[derive(Default)]
struct Converted {
    /// In the order in which they are written.
    files: Vec<(PathBuf, Vec<u8>)>,
    /// For standard output.
    printed: Option<String>,
    /// What is said of it.
    said: Vec<String>,
    /// Whether it fits the schema.
    fits: bool,
}

/// What is noted of a scenario that is written.
#[derive(Serialize, Deserialize)]
struct Notes {
    /// Whether it fits the schema.
    fits: bool,
}

impl Conversion<'_> {
    /// The file of a scenario; nothing where it is printed.
    fn target(&self, entry: Option<&Entry>) -> Option<PathBuf> {
        let named = |folder: &Path| match entry {
            Some(entry) if self.ego.is_some() => simulator_file(folder, entry),
            Some(entry) => folder.join(format!("{}.xml", entry.name)),
            None => folder.to_path_buf(),
        };
        match self.folder {
            Some(folder) => Some(named(folder)),
            // As elsewhere, `-` is the standard output.
            None => self
                .arguments
                .output
                .clone()
                .filter(|path| path.as_os_str() != "-"),
        }
    }

    /// Converts a scenario. Nothing is written yet.
    fn convert(&self, entry: &Entry) -> Result<Converted, Failure> {
        let target = self.target(Some(entry));
        match &self.ego {
            Some(ego) => convert_for_simulator(entry, target, ego, &self.cancel),
            None => commonroad(entry, target, self.arguments),
        }
    }

    /// Writes a scenario, unless an earlier run has done it.
    fn take(
        &self,
        entry: &Entry,
        unit: Unit<Notes, Result<Converted, Failure>>,
    ) -> Result<Notes, Failure> {
        match unit {
            Unit::Kept(notes) => Ok(notes),
            Unit::New(converted, earlier) => {
                let converted = converted?;
                let write = || self.write(entry, converted);
                self.journal.write(entry, earlier, write)
            }
        }
    }

    fn write(&self, entry: &Entry, converted: Converted) -> Result<(Vec<PathBuf>, Notes), Failure> {
        let own_ego = self.target(Some(entry)).map(|path| ego_beside(&path));
        let refused = |path: &Path, error: &dyn std::fmt::Display| {
            let hint = if path.exists() { " (--overwrite)" } else { "" };
            Failure::input(format!("{error}{hint}"))
        };
        // All are begun before one is there, so that none is left without the others.
        let mut begun = Vec::new();
        for (path, bytes) in converted.files.iter().rev() {
            // A scenario that is rewritten in its place has its ego already.
            let may_hold = self.arguments.many.resume || Some(path) == own_ego.as_ref();
            if may_hold && holds(path, bytes) {
                continue;
            }
            let mut file =
                NewFile::begin(path, self.arguments.overwrite).map_err(|e| refused(path, &e))?;
            file.write_all(bytes)
                .map_err(|e| Failure::system(path.display(), &e))?;
            begun.push((path, file));
        }
        for (path, file) in begun.into_iter().rev() {
            file.finish().map_err(|e| refused(path, &e))?;
        }
        if let Some(text) = &converted.printed {
            output::text(text)?;
        }
        converted.said.iter().for_each(|said| output::say(said));
        let files = converted.files.into_iter().map(|(path, _)| path);
        let fits = converted.fits;
        Ok((files.collect(), Notes { fits }))
    }
}

/// A scenario as CommonRoad XML.
fn commonroad(
    entry: &Entry,
    target: Option<PathBuf>,
    arguments: &Convert,
) -> Result<Converted, Failure> {
    let scenario = entry.read().map_err(Failure::input)?;
    let conformed = conform(&scenario);
    let name = &entry.name;
    let written = if arguments.schema {
        &conformed.scenario
    } else {
        &scenario
    };
    let bytes = write(written).map_err(Failure::input)?;
    let mut done = Converted::default();
    match (&target, ego_recording(entry, &scenario)) {
        (_, Ok(None)) => {}
        // Before the scenario, so that it is never there without.
        (Some(path), Ok(Some(recording))) => done.files.push((ego_beside(path), recording)),
        (None, Ok(Some(_))) => done.said.push(format!(
            "{name}: the ego is left out; -o FILE.xml writes it beside the scenario"
        )),
        (_, Err(error)) => done
            .said
            .push(format!("{name}: the ego is left out: {error}")),
    }
    if VariantOrigin::read(entry).is_some() {
        done.said.push(format!(
            "{name}: its manifest and the drives of good drivers are of the original file, and not copied"
        ));
    }
    match target {
        Some(path) => done.files.push((path, bytes)),
        None => done.printed = Some(output::escaped_xml(&String::from_utf8_lossy(&bytes))),
    }
    let said = &mut done.said;
    for (_, words) in in_short(&scenario.diagnostics) {
        said.push(format!("{name}: reading: {words}"));
    }
    let (changes, violations) = (&conformed.changes, &conformed.violations);
    if arguments.schema {
        let changed = alike(changes).into_iter().map(|c| format!("{name}: {c}"));
        said.extend(changed);
        let unfit = alike(violations).into_iter();
        said.extend(unfit.map(|v| format!("{name}: does not conform: {v}")));
    } else if changes.len() + violations.len() > 0 {
        let count = changes.len() + violations.len();
        let things = if count == 1 {
            "element does"
        } else {
            "elements do"
        };
        said.push(format!(
            "{name}: written as read; {count} {things} not conform to the 2020a schema; --schema lists and fixes them"
        ));
    }
    done.fits = violations.is_empty();
    Ok(done)
}

/// The file beside a scenario, where its ego is looked for first.
fn ego_beside(scenario: &Path) -> PathBuf {
    scenario.with_extension("ego_trajectory.csv")
}

/// The ego that lies with a scenario, or is in its file, as CSV; nothing where there is none.
///
/// A CSV file that tells all is copied byte for byte.
///
/// # Errors
/// The file with the ego cannot be read.
fn ego_recording(entry: &Entry, scenario: &Scenario) -> Result<Option<Vec<u8>>, EgoError> {
    let Some(ego) = entry.recorded_ego(scenario)? else {
        return Ok(None);
    };
    let size = ego.footprint.shape().size();
    let is_usual = size == USUAL_VEHICLE.footprint().shape().size();
    if is_usual && let Some(bytes) = as_it_is(entry, scenario, &ego) {
        return Ok(Some(bytes));
    }
    let written = if is_usual {
        write_recording(ego.id, &ego.track)
    } else {
        write_sized_recording(ego.id, &ego.track, size)
    };
    // Writing goes to memory.
    Ok(written.ok())
}

/// The bytes of a recording in a file of its own.
fn as_it_is(entry: &Entry, scenario: &Scenario, ego: &Ego) -> Option<Vec<u8>> {
    let is_csv = matches!(ego.source, EgoSource::Recording(_)) && scenario.recorded_ego.is_none();
    match &entry.place {
        EntryLocation::File(path) if is_csv => {
            system::read_file(&find_recording(path)?, system::LARGEST).ok()
        }
        _ => None,
    }
}

/// The ending of scenarios for simulators.
const SCENARIO: &str = "xosc";

/// The ending of CommonRoad files.
const COMMONROAD: &str = "xml";

/// That of their roads.
const ROADS: &str = "xodr";

/// Who the ego is, and what it does.
#[derive(Debug, Clone, clap::Args, Serialize)]
struct SimulatorOptions {
    /// Format to write: commonroad (XML) or openscenario (FILE.xosc and FILE.xodr) [default: by the ending of -o, else
    /// commonroad].
    #[arg(long, value_parser = ["commonroad", "openscenario"])]
    format: Option<String>,
    /// OpenSCENARIO: the ego: free (placed at its start, for a driver under test), planner (the built-in planner drives),
    /// `planner:NAME` with a [planner.NAME] of config.toml or a command, id of an obstacle, or file with a trajectory
    /// [default: the recording beside the scenario].
    #[arg(
        long,
        value_name = "free|planner|ID|FILE",
        allow_negative_numbers = true
    )]
    ego: Option<PathBuf>,
}

impl SimulatorOptions {
    /// Whether scenarios are written for simulators.
    ///
    /// # Errors
    /// The ending of the file is of no format, or of another than --format; or an ego is chosen for a format that has none.
    fn wanted(&self, output: Option<&Path>) -> Result<bool, Failure> {
        let file = output.filter(|path| !path.is_dir() && path.as_os_str() != "-");
        let by_ending = file.map(of_ending).transpose()?.flatten();
        let for_simulators = match (self.format.as_deref(), by_ending) {
            (None, by_ending) => {
                if let (Some(file), None) = (file, by_ending) {
                    return Err(unknown_ending(file));
                }
                by_ending.unwrap_or(false)
            }
            (Some(format), by_ending) => {
                let wanted = format == "openscenario";
                if let (Some(file), true) = (file, by_ending.is_some_and(|by| by != wanted)) {
                    let ending = if wanted { SCENARIO } else { COMMONROAD };
                    return Err(Failure::input(format!(
                        "{}: --format {format} writes .{ending} files; rename the file or leave out --format",
                        file.display()
                    )));
                }
                wanted
            }
        };
        if self.ego.is_some() && !for_simulators {
            return Err(Failure::input(
                "--ego applies to OpenSCENARIO: -o FILE.xosc or --format openscenario; CommonRoad files have no ego in them",
            ));
        }
        Ok(for_simulators)
    }

    /// The ego of these scenarios; a planner that is a process drives in them first.
    ///
    /// # Errors
    /// It is read from standard input, or the planner drives in none of the scenarios.
    fn ego(&self, entries: &[Entry]) -> Result<SimulatedEgo, Failure> {
        let Some(wanted) = &self.ego else {
            return Ok(SimulatedEgo::Follows(EgoSelection::Beside));
        };
        // Files of these names are meant by `./free`.
        match wanted.to_str() {
            Some("free") => return Ok(SimulatedEgo::Free),
            // The second is its earlier name.
            Some("planner" | "planned") => return Ok(SimulatedEgo::Planned),
            _ => {}
        }
        if let Some(planner) = wanted.to_str().and_then(as_ego::named) {
            return as_ego::drive(planner, None, entries).map(SimulatedEgo::Follows);
        }
        if let Some(id) = wanted.to_str().and_then(|text| text.parse().ok()) {
            return Ok(SimulatedEgo::Follows(EgoSelection::Obstacle(id)));
        }
        not_standard_input(wanted).map_err(Failure::input)?;
        Ok(SimulatedEgo::Follows(EgoSelection::File {
            path: wanted.clone(),
            planning_problem: None,
        }))
    }
}

/// Whether the ending of a file is that of scenarios for simulators; `None` where it is of no format.
fn of_ending(file: &Path) -> Result<Option<bool>, Failure> {
    let is = |ending: &str| {
        let own = file.extension();
        own.is_some_and(|own| own.eq_ignore_ascii_case(ending))
    };
    if is(ROADS) {
        return Err(Failure::input(
            "roads are written beside a scenario: -o FILE.xosc writes FILE.xosc and FILE.xodr",
        ));
    }
    let known = [(COMMONROAD, false), (SCENARIO, true)];
    let found = known.into_iter().find(|(ending, _)| is(ending));
    Ok(found.map(|(_, for_simulators)| for_simulators))
}

fn unknown_ending(file: &Path) -> Failure {
    Failure::input(format!(
        "{}: no folder, and no ending of a scenario: .{COMMONROAD} (CommonRoad) or .{SCENARIO} (OpenSCENARIO); create the \
         folder, or choose with --format",
        file.display()
    ))
}

/// The file of an entry in a folder.
fn simulator_file(folder: &Path, entry: &Entry) -> PathBuf {
    folder.join(format!("{}.{SCENARIO}", entry.name))
}

/// How egos are planned.
fn planning() -> Result<Settings, Failure> {
    let (_, config) = configuration()?;
    Ok((&config.planning()).into())
}

/// One scenario, and what the formats cannot say of it.
fn convert_for_simulator(
    entry: &Entry,
    target: Option<PathBuf>,
    ego: &SimulatedEgo,
    cancel: &Cancel,
) -> Result<Converted, Failure> {
    let Some(path) = target else {
        return Err(Failure::input(
            "OpenSCENARIO is two files; name the first one or a folder: -o FILE.xosc",
        ));
    };
    let roads = path.with_extension(ROADS);
    let road_file = roads.file_name().unwrap_or_default().to_string_lossy();
    let request = ExportRequest {
        entry,
        ego,
        road_file: &road_file,
        settings: &planning()?,
    };
    let exported = export_to_simulator(&request, cancel).map_err(Failure::input)?;
    let Some((scenario, exported)) = exported else {
        return Ok(Converted::default());
    };
    let read = in_short(&scenario.diagnostics)
        .into_iter()
        .map(|(_, said)| format!("{}: reading: {said}", entry.name));
    let notes = exported
        .notes
        .iter()
        .map(|note| format!("{}: {note}", entry.name));
    let said = read.chain(notes).collect();
    Ok(Converted {
        // The roads first, so that a scenario is never there without them.
        files: vec![(roads, exported.roads), (path, exported.scenario)],
        printed: None,
        said,
        fits: true,
    })
}
