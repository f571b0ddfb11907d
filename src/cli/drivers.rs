//! `nearmiss drivers`: which models of drivers avoid the contacts and near misses of recordings, cases of a family, or those of
//! one encounter; without either, the models.

use std::path::{Path, PathBuf};

use super::convert::save_converted;
use super::corpus::save_picture;
use super::ending::interrupted;
use super::files::{Inputs, Labels};
use super::many_files::{Failed, Job, NEXT, ShardOption};
use super::open::{EgoChoice, found, scene_and_doubts, thresholds_in_use};
use super::output::{self, OutputFile, PageFormat};
use super::{Failure, Outcome, json};
use nearmiss_drive::driver::family::Family;
use nearmiss_drive::driver::{DRIVERS, DriverOutcome, DriverRecord, VerdictRecord};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_record::{Cell, Column, Kind, Row, text_table};
use nearmiss_render::Format as PictureFormat;
use nearmiss_scene::metrics::{SEVERITY_NAMES, Thresholds};
use nearmiss_scene::scenario::Scene;
use nearmiss_workflow::SimulatedEgo;
use nearmiss_workflow::convert::{ConvertRequest, Part, Target, convert_varied};
use nearmiss_workflow::tables::{
    Encounter, EncounterCases, FamilyResults, RowFile, Vary, encounter_rows, encounter_table,
    encounters, left_out, too_coarse,
};

/// Arguments of `drivers`.
#[derive(Debug, clap::Args)]
pub struct Drivers {
    /// Scenario files, folders or names of bundled scenarios [default: list the driver models].
    paths: Vec<PathBuf>,
    #[command(flatten)]
    ego: EgoChoice,
    /// Drive every case of a UN Regulation 157 family: cut-in, cut-out or braking; -o FILE.svg or .png draws the
    /// boundary of preventability.
    #[arg(long, value_name = "FAMILY", conflicts_with = "paths")]
    family: Option<Family>,
    /// Drive only the cases with these ego speeds (km/h), separated by commas.
    #[arg(long, value_name = "KMH", value_delimiter = ',', requires = "family")]
    speed: Vec<i64>,
    /// Vary up to three parameters of the most severe encounter of one scenario, separated by commas
    ///
    /// Parameters: gap (m), closing (m/s), lateral_speed (m/s) and start (s). Write gap=2..20, gap=2..20:0.5 with a
    /// step, or gap for values around the recorded one. -o FILE.svg or .png draws the boundary of preventability; -o
    /// FILE.xosc writes a parameterised scenario.
    #[arg(
        long,
        value_name = "PARAMETER,…",
        value_delimiter = ',',
        requires = "paths",
        conflicts_with = "family"
    )]
    vary: Vec<Vary>,
    /// Output format [default: from the file name, else table].
    #[arg(long, value_enum)]
    format: Option<PageFormat>,
    #[command(flatten)]
    output: OutputFile,
    #[command(flatten)]
    part: ShardOption,
}

/// Runs `drivers`.
pub fn run(arguments: &Drivers) -> Outcome {
    let file = arguments.output.file();
    if let Some(family) = arguments.family {
        return drive(arguments, || {
            FamilyResults::of(family, &arguments.speed)
                .map_err(|why| Failure::input(format!("--speed: {why}")))
        });
    }
    let format = match arguments.vary[..] {
        [] => PageFormat::of(arguments.format, file)?,
        // A family has pictures and scenarios, too.
        _ => PageFormat::Table,
    };
    if arguments.paths.is_empty() {
        return list(arguments, format);
    }
    if let Some(format) = format.of_table() {
        output::check_format(format, file)?;
    }
    let thresholds = thresholds_in_use()?;
    let entries = arguments.part.of(found(&arguments.paths)?);
    Inputs::of(&entries).spare(file)?;
    let ego = arguments.ego.wanted(&entries)?;
    if !arguments.vary.is_empty() {
        return vary(arguments, &entries, &ego, &thresholds);
    }
    let labels = Labels::new(&entries);
    let stop = interrupted(file.is_some());
    let mut failed = Failed::of(entries.len());
    let mut without = 0;
    let (mut rows, mut lines) = (Vec::new(), Vec::new());
    let done = Job::new("scenarios", &stop)
        .writing_file(file.is_some())
        .run(
            &entries,
            |entry| Some((entry, judged(entry, &ego, &thresholds))),
            |_, (entry, judged)| {
                match judged {
                    Ok((said, scene, found)) => {
                        said.iter().for_each(|said| output::say(said));
                        without += usize::from(found.is_empty());
                        let name = labels.of(&entry.name, &entry.display());
                        lines.extend(found.iter().map(|one| text_row(&name, &scene, one)));
                        rows.extend(encounter_rows(&RowFile::new(entry, &scene), &scene, &found));
                    }
                    Err(failure) => failed.add(failure),
                }
                NEXT
            },
        );
    done.end("no file was written")?;
    if without > 0 {
        output::say(&format!(
            "nearmiss: {} without an encounter that drivers are judged in",
            output::counted(without, "scenario")
        ));
    }
    if !failed.all() {
        let target = arguments.output.begin()?;
        match format.of_table() {
            Some(format) => output::save_table(&encounter_table(), format, rows, target, file)?,
            None => target.save(text(&lines).as_bytes())?,
        }
    }
    failed.end("judged")
}

/// The family of the most severe encounter of the only scenario.
fn vary(
    arguments: &Drivers,
    entries: &[Entry],
    ego: &EgoSelection,
    thresholds: &Thresholds,
) -> Outcome {
    let [entry] = entries else {
        return Err(Failure::input(format!(
            "--vary is for one scenario, and not for {}; name one file",
            entries.len()
        )));
    };
    let (scene, said) = scene_and_doubts(entry, ego)?;
    said.iter().for_each(|said| output::say(said));
    let cases = EncounterCases::of(entry, &scene, thresholds, &arguments.vary);
    let (cases, family) = cases.map_err(|why| {
        let file = output::visible(&entry.display());
        Failure::input(format!("{file}: --vary: {why}"))
    })?;
    let file = arguments.output.file();
    if let Some(file) = file.filter(|file| Target::of_ending(file) == Some(Target::OpenScenario)) {
        if arguments.format.is_some() {
            return Err(Failure::input(
                "--format is that of a table; leave it out for OpenSCENARIO",
            ));
        }
        let request = ConvertRequest {
            entry,
            target: Target::OpenScenario,
            file: Some(file),
            part: &Part::default(),
            ego: &SimulatedEgo::Follows(ego.clone()),
            to_schema: false,
        };
        let varied = cases.varied(&family);
        let written = convert_varied(&request, &scene, &varied).map_err(Failure::input)?;
        let how = [arguments.output.overwrites(), false];
        return save_converted(&request, &written, how, &Inputs::of(entries));
    }
    if file.is_some_and(is_picture) && !cases.has_figure() {
        return Err(Failure::input(
            "a figure has two axes: vary two or three parameters",
        ));
    }
    drive(arguments, || {
        Ok(FamilyResults::of_encounter(cases, &family))
    })
}

fn is_picture(file: &Path) -> bool {
    PictureFormat::of_file(file).is_some_and(PictureFormat::is_picture)
}

/// Every case of a family: a table, the boundary in words, or a figure of it.
fn drive(arguments: &Drivers, results: impl FnOnce() -> Result<FamilyResults, Failure>) -> Outcome {
    let file = arguments.output.file();
    if let (Some(file), None) = (file.filter(|file| is_picture(file)), arguments.format) {
        let overwrites = arguments.output.overwrites();
        return save_picture(&results()?.chart().picture(), file, overwrites);
    }
    let format = PageFormat::of(arguments.format, file)?.of_table();
    if let Some(format) = format {
        output::check_format(format, file)?;
    }
    let results = results()?;
    let target = arguments.output.begin()?;
    match format {
        Some(format) => output::save_table(&results.table(), format, results.rows(), target, file),
        None => {
            let (columns, rows, meaning) = results.boundary();
            let text = format!("{}{meaning}\n", text_table(&columns, &rows));
            target.save(text.as_bytes())
        }
    }
}

type Judged = (Vec<String>, std::sync::Arc<Scene>, Vec<Encounter>);

fn judged(entry: &Entry, ego: &EgoSelection, thresholds: &Thresholds) -> Result<Judged, Failure> {
    let (scene, mut said) = scene_and_doubts(entry, ego)?;
    said.extend(too_coarse(&entry.display(), scene.scenario.dt()));
    let (found, early) = encounters(entry, &scene, thresholds).map_err(Failure::input)?;
    said.extend(left_out(early).map(|words| {
        let name = output::visible(&entry.display());
        format!("nearmiss: {name}: {words}")
    }));
    Ok((said, scene, found))
}

/// The table for people.
fn text(rows: &[Row]) -> String {
    let column = |name: &'static str, kind, unit| Column {
        title: name.into(),
        decimals: Some(2),
        ..Column::new(name, kind, unit, "")
    };
    let mut columns = vec![
        column("scenario", Kind::Text, ""),
        column("obstacle", Kind::Integer, ""),
        column("at", Kind::Number, "s"),
        column("encounter", Kind::Text, ""),
        column("avoided by", Kind::Text, ""),
    ];
    columns.extend(
        DRIVERS
            .iter()
            .map(|driver| column(driver.id, Kind::Text, "")),
    );
    columns.push(column("n/a: not made for", Kind::Text, ""));
    if rows.is_empty() {
        return "no contact, conflict or near miss that someone could drive before\n".into();
    }
    format!(
        "{}\n{}\n",
        text_table(&columns, rows),
        "seconds: avoids the contact, and could still do so when it took over so long before; avoided: a near miss, or \
         another drive shows it; hits: closing speed at its contact; behind: hit from behind by traffic that does not see it brake"
    )
}

fn text_row(name: &str, scene: &Scene, one: &Encounter) -> Row {
    let found = &one.drivers;
    let severity = SEVERITY_NAMES[usize::from(one.severity)];
    let encounter = match found.closing_speed.filter(|_| one.severity == 0) {
        Some(speed) => format!("{severity} {speed:.1} m/s"),
        None => severity.to_owned(),
    };
    let cell = |verdict: &VerdictRecord| match (verdict.result, verdict.closing_speed) {
        (DriverOutcome::NotMadeFor, _) => "n/a".to_owned(),
        (DriverOutcome::HitFromBehind, _) => "behind".to_owned(),
        (_, Some(speed)) => match verdict.touches.filter(|other| *other != found.obstacle) {
            Some(other) => format!("hits {other} {speed:.1} m/s"),
            None => format!("hits {speed:.1} m/s"),
        },
        _ => match verdict.last_moment_step {
            Some(last) => format!("{:.1} s", (found.step - last) as f64 * scene.scenario.dt()),
            None => verdict.result.name().into(),
        },
    };
    let fixed = [
        output::visible(name).into(),
        Cell::Integer(found.obstacle),
        Cell::Number(scene.time_of(found.step)),
        encounter.into(),
        if found.people().any(VerdictRecord::decides) {
            format!("{} of {}", found.avoided, found.decided).into()
        } else {
            "no model".into()
        },
    ];
    let drivers = found.drivers.iter().map(|verdict| cell(verdict).into());
    let kinds = found.not_made_for().map_or(Cell::None(""), Cell::from);
    fixed.into_iter().chain(drivers).chain([kinds]).collect()
}

impl json::Output for DriverRecord {
    const NAME: &'static str = "drivers";
    const TITLE: &'static str = "`drivers --format json` without paths: one driver a line";
}

/// Lists the drivers.
fn list(arguments: &Drivers, format: PageFormat) -> Outcome {
    let target = arguments.output.begin()?;
    let text = match format {
        PageFormat::Table => page(),
        PageFormat::Json => {
            let lines =
                { DRIVERS.iter() }.map(|driver| output::document_line(&DriverRecord::from(driver)));
            lines.collect::<Result<String, Failure>>()?
        }
        _ => {
            return Err(Failure::input(
                "the list of drivers is text or json; name scenarios for a table",
            ));
        }
    };
    target.save(text.as_bytes())
}

/// The drivers in words: each with its formula, numbers, source and limits.
pub fn page() -> String {
    let words = |driver: &nearmiss_drive::driver::DriverModel| {
        let numbers = driver.parameters.iter().map(|p| {
            let value = format!("{:.3}", p.value);
            let value = value.trim_end_matches('0').trim_end_matches('.');
            format!("  {} = {value} {}: {}\n", p.symbol, p.unit, p.what)
        });
        let not_made: Vec<&str> = driver
            .not_made_for
            .iter()
            .map(|kind| kind.words())
            .collect();
        let not_made = match not_made.as_slice() {
            [] => String::new(),
            kinds => format!("  not made for: {}\n", kinds.join(", ")),
        };
        format!(
            "{}: {}\n  {}\n{}  source: {}\n  limits: {}\n{not_made}",
            driver.id,
            driver.name,
            driver.formula,
            numbers.collect::<String>(),
            driver.source,
            driver.limits
        )
    };
    let all: Vec<String> = DRIVERS.iter().map(words).collect();
    all.join("\n")
}
