//! `nearmiss annex`: holds planners to a requirement, beside drivers and baselines, and writes it up for a safety case.

use std::path::{Path, PathBuf};

use nearmiss_drive::planner::Cancel;
use nearmiss_record::CaptionedTable;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_settings::TextFile;
use nearmiss_study::evaluation::AnswerPage;
use nearmiss_workflow::annex::{Annex, PlannerFindings, Role, SafetyRequirement, held};
use nearmiss_workflow::tables::too_coarse;
use nearmiss_workflow::{read_events, selected};

use super::ending::interrupted;
use super::files::Inputs;
use super::many_files::{Job, NEXT};
use super::open::{configuration, found, user_thresholds};
use super::output::{self, Target};
use super::{Failure, Outcome};

/// Arguments of `annex`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit status: 0 every planner meets the requirement in every scenario; 1 one does not, or a finding is open; \
2 usage or input error; 130 interrupted.")]
pub struct AnnexArguments {
    /// Requirement file (TOML); see `nearmiss help requirements`.
    file: PathBuf,
    #[command(flatten)]
    format: output::FormatOption,
    /// Also write the annex to FILE (.html, .tex, .md or .json); repeat for several formats from the same drives.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Replace existing files.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

/// What a file is written as.
#[derive(Debug, Clone, Copy)]
enum AnnexFormat {
    Html,
    Latex,
    Markdown,
    Json,
}

const ENDINGS: &[(&str, AnnexFormat)] = &[
    ("html", AnnexFormat::Html),
    ("htm", AnnexFormat::Html),
    ("tex", AnnexFormat::Latex),
    ("md", AnnexFormat::Markdown),
    ("json", AnnexFormat::Json),
];

/// Runs `annex`.
pub fn run(arguments: &AnnexArguments) -> Outcome {
    let text = TextFile::read(&arguments.file)
        .map_err(Failure::input)?
        .text;
    let requirement = SafetyRequirement::read(&text, &arguments.file).map_err(Failure::input)?;
    let (folders, config) = configuration()?;
    let thresholds = user_thresholds(&folders)?;
    let of_file = |why: &dyn std::fmt::Display| {
        Failure::input(format!("{}: {why}", arguments.file.display()))
    };
    let who = requirement
        .who_drives(&config)
        .map_err(|why| of_file(&why))?;
    let index = match &requirement.index {
        Some(folder) => Some(read_events(folder).map_err(|why| of_file(&format!("index: {why}")))?),
        None => None,
    };
    let entries = found(&requirement.scenarios)
        .map_err(|failure| of_file(&format!("scenarios: {}", failure.message)))?;
    let listed = entries.len();
    let entries = selected(entries, requirement.select.as_deref(), &thresholds)
        .map_err(|why| of_file(&why))?;
    let files = begun(arguments, &entries)?;
    let stop = interrupted(true);
    let cancel = Cancel::from_flag(&stop);
    let mut annex = Annex {
        file_sha256: ContentHash::digest(text.as_bytes()).to_string(),
        program_sha256: std::env::current_exe().and_then(std::fs::read).map_or_else(
            |_| "not known".into(),
            |bytes| ContentHash::digest(&bytes).to_string(),
        ),
        day: jiff::Timestamp::now().strftime("%Y-%m-%d").to_string(),
        who: { who.iter() }
            .map(|(planner, role)| (planner.name.clone(), *role))
            .collect(),
        listed,
        held: Vec::new(),
        copies: Vec::new(),
        missed: Vec::new(),
        requirement,
    };
    let requirement = annex.requirement.clone();
    let done = Job::new("scenarios", &stop).run(
        &entries,
        |entry| {
            held(
                &requirement,
                &who,
                entry,
                (index.as_ref(), &thresholds),
                &cancel,
            )
            .transpose()
        },
        |entry, held| {
            match held {
                Ok(held) => {
                    let name = held.scenario.scenario.clone();
                    if let Some(other) = annex.with_content_of(&held) {
                        let words = format!("{name}: left out, the content of {}", other.file);
                        output::say(&format!("nearmiss: {}", output::visible(&words)));
                        annex.copies.push(name);
                    } else {
                        let coarse = too_coarse(&held.scenario.file, held.scenario.time_step);
                        coarse.iter().for_each(|words| output::say(words));
                        annex.held.push(held);
                    }
                }
                Err(error) => {
                    output::say(&format!("nearmiss: {error}"));
                    annex
                        .missed
                        .push((output::visible(&entry.name), error.to_string()));
                }
            }
            NEXT
        },
    );
    done.end("no file was written")?;
    if annex.held.is_empty() {
        return Err(Failure::input(format!(
            "none of the {} could be driven",
            output::counted(entries.len(), "scenario")
        )));
    }
    for (target, format) in files {
        target.save(written(&annex, format)?.as_bytes())?;
    }
    let planners = annex.planners();
    let held: Vec<&PlannerFindings> = { planners.iter() }
        .filter(|one| one.role == Role::Planner)
        .collect();
    if arguments.format.is_json() {
        output::json(&annex.record())?;
    } else {
        let table = CaptionedTable::of("", "", &planners).map_err(Failure::input)?;
        let sentences = held.iter().map(|one| one.sentence() + "\n");
        output::text(&format!(
            "{}\n{}",
            table.text(),
            sentences.collect::<String>()
        ))?;
    }
    verdict(&annex, &held)
}

/// The files, begun before anything is driven.
fn begun(
    arguments: &AnnexArguments,
    entries: &[nearmiss_formats::Entry],
) -> Result<Vec<(Target, AnnexFormat)>, Failure> {
    let begin = |file: &PathBuf| {
        let format = output::format_of_name(file, ENDINGS).ok_or_else(|| {
            Failure::input(format!(
                "{}: unknown file extension; known are .html, .tex, .md and .json",
                file.display()
            ))
        })?;
        Inputs::of(entries).spare(Some(file))?;
        if is_same(file, &arguments.file) {
            return Err(Failure::input(format!(
                "{}: is the requirement",
                file.display()
            )));
        }
        Ok((Target::begin(Some(file), arguments.overwrite)?, format))
    };
    let names: Vec<PathBuf> = { arguments.output.iter() }
        .map(|file| std::path::absolute(file).unwrap_or_else(|_| file.clone()))
        .collect();
    let all = arguments.output.iter().enumerate();
    let twice = { all }.find(|(place, _)| names[..*place].contains(&names[*place]));
    if let Some((_, file)) = twice {
        return Err(Failure::input(format!(
            "-o {}: named twice",
            file.display()
        )));
    }
    arguments.output.iter().map(begin).collect()
}

fn is_same(one: &Path, other: &Path) -> bool {
    let whole = |path: &Path| std::fs::canonicalize(path).ok();
    whole(one).is_some() && whole(one) == whole(other)
}

fn written(annex: &Annex, format: AnnexFormat) -> Result<String, Failure> {
    Ok(match format {
        AnnexFormat::Html => annex.document().html(&AnswerPage::default()),
        AnnexFormat::Latex => annex.document().latex_article(),
        AnnexFormat::Markdown => annex.document().markdown(),
        AnnexFormat::Json => output::json_line(&annex.record())?,
    })
}

fn verdict(annex: &Annex, held: &[&PlannerFindings]) -> Outcome {
    let failing = held.iter().filter(|one| one.met == Some(false));
    let failing: Vec<&str> = failing.map(|one| one.planner.as_str()).collect();
    let open: usize = held.iter().map(|one| one.open).sum();
    let missed = annex.missed.len();
    if failing.is_empty() && open == 0 && missed == 0 {
        return Ok(());
    }
    let mut words = Vec::new();
    if !failing.is_empty() {
        words.push(format!(
            "{} not met by {}",
            annex.requirement.id,
            failing.join(", ")
        ));
    }
    if open > 0 {
        words.push(format!("{} open", output::counted(open, "drive")));
    }
    if missed > 0 {
        words.push(format!(
            "{} not driven",
            output::counted(missed, "scenario")
        ));
    }
    Err(Failure::finding(words.join("; ")))
}
