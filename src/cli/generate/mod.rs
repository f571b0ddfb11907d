//! `nearmiss generate`: turns safe scenarios into dangerous variants, all of which have passed the gate.

mod check;
mod line;
mod model;
mod resume;
mod settings;
mod summary;
mod table;
mod variant;

pub use check::CheckDocument;
pub use settings::keys;
pub use summary::GenerateReport;

use std::path::{Path, PathBuf};

use nearmiss_drive::driver::driver;
use nearmiss_drive::generation::{AttackStyle, Effort, Wish};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::commonroad::NewFile;
use nearmiss_settings::Config;
use nearmiss_study::evaluation::generating::Ranking;
use nearmiss_workflow::variant::{
    AttackRequest, attacker_count, attackers_together, candidate_count, distinct_attackers,
    reaction_time,
};

use super::ask::budget;
use super::ending::interrupted;
use super::many_files::{Job, ShardOption};
use super::open::{configuration, found};
use super::plan::{PlannerOptions, ProblemOption, identity};
use super::{Failure, Outcome, knobs, output};
use model::Writer;
use resume::EarlierRun;
use summary::Summary;
use table::Table;
use variant::{GenerateJob, Variants};

/// Arguments of `nearmiss generate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Outcomes: collision, near_miss (worst risk score of an attacker 0 or 1), planner_error (the planner's process fails \
under the attack), no_effect, none (no motion passed the gate). The ego replans against the changed traffic.\n\
Exit status: 0 every scenario ends in a collision, near miss or planner error; 1 some do not, could not be attacked, \
or --check finds an error; 2 usage or input error; 130 interrupted.")]
pub struct GenerateArguments {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Source of the attack: `search`, which needs no key, or provider/model.
    #[arg(long, default_value = SEARCH)]
    model: String,
    /// Server address, instead of the provider's own.
    #[arg(long, value_name = "URL")]
    base_url: Option<String>,
    /// Ask the model even if its answer is stored.
    #[arg(long)]
    fresh: bool,
    /// Plan the ego and print the maximum number of model requests and their cost; ask nothing.
    #[arg(long, conflicts_with_all = ["output", "report", "check", "format"])]
    dry_run: bool,
    /// Maximum cost of all answers in US dollars [default: `budget` in config.toml, else none].
    #[arg(long, value_name = "USD", allow_negative_numbers = true, value_parser = budget)]
    budget: Option<f64>,
    /// Let only these obstacles attack; several ids, separated by commas, attack together.
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    attacker: Vec<i64>,
    /// Restrict the search to attacks that match these terms: actor, manoeuvre, place, severity
    ///
    /// Example: "actor:car,truck manoeuvre:cut-in place:left-lane severe". `nearmiss help generating` lists the terms.
    #[arg(long, value_name = "TERMS", conflicts_with = "check")]
    wish: Option<Wish>,
    /// Prefer attacks that all of these driver models would avoid, such as cc,fsm; `nearmiss drivers` lists them. Same
    /// as --wish preventable-by:DRIVERS.
    #[arg(long, value_name = "DRIVERS", conflicts_with = "check", value_delimiter = ',', value_parser = driver_id)]
    preventable_by: Vec<&'static str>,
    /// Maximum number of obstacles that attack together, 1 to 3 [default: `attackers` in config.toml, else 1]
    ///
    /// More attackers are added only if they make the outcome worse. If --attacker names several, the default is their
    /// number. With --check: how many obstacles may be changed [default: 3].
    #[arg(long, value_name = "N", value_parser = attacker_count)]
    attackers: Option<usize>,
    /// Maximum number of motions to try per scenario.
    #[arg(long, value_name = "N", default_value_t = Effort::default().candidates, value_parser = candidate_count)]
    candidates: usize,
    /// Random seed; the same seed finds the same attacks.
    #[arg(long, value_name = "N", default_value_t = Effort::default().seed)]
    seed: u64,
    /// Reaction time in seconds with which an ideal driver must avoid the attack: 0, 0.5, 1 or 1.5.
    #[arg(long, value_name = "S", default_value = "0.5", allow_negative_numbers = true, value_parser = reaction_time)]
    survive: f64,
    /// Limits of attacker motion: as people drive in an emergency, or as far as vehicles can [default: `attack_style`
    /// in config.toml, else human; with --check that of the variant's manifest, else limit].
    #[arg(long, value_name = "STYLE")]
    style: Option<AttackStyle>,
    #[command(flatten)]
    how: ProblemOption,
    /// Change a setting of the planner (those of `plan`) or of the requests to a model
    ///
    /// Keys of the requests: votes (for the attacker), within (range of candidate attackers, metres), samples
    /// (motions), retries, feedback, grades and obey (on, off), rank (exact, model). See `nearmiss help generating`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::setting)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    planner: PlannerOptions,
    #[command(flatten)]
    format: output::FormatOption,
    /// Folder for the variants with their egos, solutions, certificates and manifests; created if missing.
    #[arg(short = 'o', long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Resume in the folder of -o: keep variants made with the same settings and count them. Replaces an earlier
    /// report.
    #[arg(long, requires = "output", conflicts_with_all = ["fresh", "check"])]
    resume: bool,
    #[command(flatten)]
    part: ShardOption,
    /// Write a JSON summary of all scenarios to FILE.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Check this variant, from any source, against the one given scenario; generate nothing.
    #[arg(long, value_name = "VARIANT", conflicts_with_all = ["output", "report", "attacker"])]
    check: Option<PathBuf>,
}

/// The id of a driver.
fn driver_id(word: &str) -> Result<&'static str, String> {
    driver(word.trim()).map(|driver| driver.id)
}

impl GenerateArguments {
    /// What attacks are wished to be.
    fn wished(&self) -> Option<Wish> {
        if self.preventable_by.is_empty() {
            return self.wish.clone();
        }
        let mut wish = self.wish.clone().unwrap_or_default();
        wish.preventable_by.extend(&self.preventable_by);
        Some(wish)
    }
}

/// A file of this name is never written.
const PROBE: &str = ".nearmiss-can-write";

/// The search's name among the models.
const SEARCH: &str = "search";

impl GenerateArguments {
    /// The file for a summary of all scenarios.
    pub fn report(&self) -> Option<&Path> {
        self.report.as_deref()
    }
}

/// The style that is asked for, else that of the configuration.
fn style_of(arguments: &GenerateArguments, config: &Config) -> AttackStyle {
    arguments.style.or(config.attack_style).unwrap_or_default()
}

/// Runs it.
pub fn run(arguments: &GenerateArguments) -> Outcome {
    let (folders, config) = configuration()?;
    let (planning, asking) = settings::read(&arguments.set, &config)?;
    let reacts =
        |(key, value): &(String, String)| key == "traffic" && value == TrafficMode::Reactive.name();
    if arguments.set.iter().any(reacts) {
        return Err(Failure::input(
            "--set traffic=reactive is not for `generate`: variants are recordings, in which only the attackers move otherwise; \
             leave it out. `nearmiss plan VARIANT --set traffic=reactive` shows whether the attack succeeds where others react",
        ));
    }
    let settings = Settings {
        traffic: TrafficMode::Recorded,
        ..Settings::from(&planning)
    };
    let entries = found(&arguments.paths)?;
    if let Some(variant) = &arguments.check {
        let gate = (arguments.style, arguments.attackers);
        return check::run(&entries, variant, gate, arguments.format.is_json());
    }
    if asking.rank == Ranking::Model && !asking.grades {
        return Err(Failure::input(
            "rank=model ranks by the grades of the model; leave out grades=off",
        ));
    }
    let effort = Effort {
        candidates: arguments.candidates,
        seed: arguments.seed,
        delay: arguments.survive,
        together: attackers_asked_for(arguments, &config).map_err(Failure::input)?,
        ..Effort::default()
    };
    let style = style_of(arguments, &config);
    let searching = arguments.model == SEARCH;
    let wish = arguments.wished();
    if wish.is_some() && !searching {
        return Err(Failure::input(
            "--wish is for the search, not for a model, and so is --preventable-by: leave out --model, or change the model's template",
        ));
    }
    let writer = (!searching)
        .then(|| Writer::new(arguments, &asking, &folders, &config))
        .transpose()?;
    let entries = arguments
        .part
        .of(settings::originals(entries, &arguments.paths)?);
    if entries.is_empty() {
        return Ok(());
    }
    let past = prepared(arguments)?;
    let chosen = arguments.planner.only(&config, planning.timeout)?;
    let settings = Settings {
        policy: chosen.as_ref().and_then(|planner| planner.policy),
        ..settings
    };
    let planner = chosen.and_then(|planner| planner.external);
    let problem = arguments.how.planning_problem;
    let stop = interrupted(true);
    let cancel = Cancel::from_flag(&stop);
    let asked = planner.as_ref().filter(|_| past.is_some());
    let identity =
        asked.and_then(|planner| identity(&entries, problem, &settings, planner, &cancel));
    let wanted = GenerateJob {
        writer,
        problem,
        identity,
        attack: AttackRequest {
            settings,
            planner,
            effort,
            style,
            only: distinct_attackers(&arguments.attacker),
            wish,
        },
        past,
    };
    let by = match &wanted.writer {
        Some(writer) => writer.id().to_owned(),
        None => wanted.attack.search_in_words(),
    };
    if arguments.dry_run {
        return model::dry_run(&entries, &wanted);
    }
    let mut job = Variants {
        folder: arguments.output.as_deref(),
        json: arguments.format.is_json(),
        by: &by,
        unheard: arguments.output.is_some() || arguments.report.is_some(),
        summary: Summary::new(entries.len()),
        table: Table::new(&entries, wanted.attack.effort.together),
    };
    let done = Job::new("scenarios", &stop).keeping_finished().run(
        &entries,
        |entry| variant::make(entry, &wanted, &cancel),
        |entry, made| job.take(entry, made),
    );
    let summary = job.summary;
    if !arguments.format.is_json() && done.count > 0 {
        output::text(&summary.words())?;
    }
    if let Some(path) = &arguments.report {
        summary.save(path, done.count < entries.len(), arguments.resume)?;
    }
    done.end(if arguments.output.is_some() {
        "finished variants are kept; the same command with --resume continues"
    } else {
        "nothing was written (-o FOLDER keeps variants, and --resume continues with them)"
    })?;
    summary.outcome()
}

/// Creates the folder for variants, and checks now, not at the end, whether files can be written. Returns the earlier
/// run to resume.
fn prepared(arguments: &GenerateArguments) -> Result<Option<EarlierRun>, Failure> {
    let mut past = None;
    if let Some(folder) = &arguments.output {
        let shown = folder.display();
        if folder.exists() && !folder.is_dir() {
            return Err(Failure::input(format!("-o {shown}: not a folder")));
        }
        std::fs::create_dir_all(folder).map_err(|e| Failure::system(shown, &e))?;
        drop(
            NewFile::begin(&folder.join(PROBE), true).map_err(|e| {
                Failure::input(format!("-o {}: not writable: {e}", folder.display()))
            })?,
        );
        if arguments.resume {
            let (found, doubts) = EarlierRun::read(folder)?;
            for doubt in doubts {
                output::say(&format!("nearmiss: {doubt}"));
            }
            past = Some(found);
        }
    }
    if let Some(path) = &arguments.report {
        if path.exists() {
            resume::is_report(path).map_err(Failure::input)?;
            if !arguments.resume {
                return Err(Failure::input(format!(
                    "{}: the report of an earlier run, left unchanged; --resume continues that run and replaces it, or name another file",
                    path.display()
                )));
            }
        }
        drop(NewFile::begin(path, arguments.resume).map_err(Failure::input)?);
    }
    Ok(past)
}

/// How many obstacles attack together at most.
///
/// # Errors
/// More than are named, or more than one where a language model writes the attack.
fn attackers_asked_for(arguments: &GenerateArguments, config: &Config) -> Result<usize, String> {
    let ids = distinct_attackers(&arguments.attacker).len();
    if arguments.model != SEARCH {
        let several = match (arguments.attackers, ids) {
            (Some(n @ 2..), _) => format!("--attackers {n}"),
            (_, n @ 2..) => format!("--attacker with {n} ids"),
            // The configuration is about searches.
            _ => return Ok(1),
        };
        return Err(format!(
            "{several}: a language model writes the motion of one attacker; several attack with --model {SEARCH}"
        ));
    }
    let options = ("--attackers ", "--attacker");
    attackers_together(arguments.attackers, ids, config.attackers, options)
}
