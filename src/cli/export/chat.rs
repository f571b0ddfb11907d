//! Examples for fine-tuning: right answers as chats, in a file for training, one for validation, and a manifest.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use schemars::JsonSchema;
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::ending::interrupted;
use crate::filters::LockedAnswers;
use crate::output::{Progress, refused};
use crate::report::truth;
use crate::{Failure, Outcome, json, output};
use nearmiss_base::system::NewFile;
use nearmiss_scene::description::{Frame, escaped_json};
use nearmiss_store::{Outcome as Run, RunId, SplitPart, Store};
use nearmiss_study::evaluation::batch::Split;
use nearmiss_study::evaluation::report::stored;
use nearmiss_study::evaluation::{
    AxisValues, ExampleRules, Examples, NoExample, Pictures, PromptConfig, Provenance,
    ReasoningForm, note_on_score,
};

/// Options of `--format chat`.
#[derive(Debug, clap::Args)]
pub struct ChatOptions {
    /// Chat: ground truth for the answers, as in `report --truth` [default: batch,auto].
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "CSV|batch|auto|score|FOLDER"
    )]
    truth: Vec<PathBuf>,
    /// Chat: keep answers with at most N wrong claims [default: 0].
    #[arg(long, value_name = "N")]
    allow_wrong_claims: Option<u32>,
    /// Chat: share of maps that go to validation, 0 to below 1 [default: 0.1].
    #[arg(long, value_name = "SHARE", value_parser = share)]
    validation: Option<f64>,
    /// Chat: seed of the validation split, as in `split` of an experiment [default: 1].
    #[arg(long, value_name = "N")]
    split_seed: Option<u64>,
    /// Chat: place of the model's reasoning: <think> before the answer, the field reasoning_content, or none [default:
    /// think].
    #[arg(long, value_name = "think|field|none")]
    reasoning: Option<ReasoningForm>,
    /// Chat: leave out answers about pictures, which only vision models can be trained on.
    #[arg(long)]
    no_pictures: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..1.0).contains(&share) => Ok(share),
        _ => Err("expected a share from 0 to below 1".into()),
    }
}

impl ChatOptions {
    /// An option that is given, which other formats do not have.
    pub fn given(&self) -> Option<&'static str> {
        let mut given = [
            (!self.truth.is_empty(), "--truth"),
            (self.allow_wrong_claims.is_some(), "--allow-wrong-claims"),
            (self.validation.is_some(), "--validation"),
            (self.split_seed.is_some(), "--split-seed"),
            (self.reasoning.is_some(), "--reasoning"),
            (self.no_pictures, "--no-pictures"),
        ]
        .into_iter()
        .filter(|(is_given, _)| *is_given);
        given.next().map(|(_, name)| name)
    }

    fn rules(&self) -> ExampleRules {
        ExampleRules {
            wrong_claims: self.allow_wrong_claims.unwrap_or(0),
            reasoning: self.reasoning.unwrap_or_default(),
            pictures: !self.no_pictures,
            split: Split {
                test: self.validation.unwrap_or(0.1),
                seed: self.split_seed.unwrap_or(Split::SEED),
            },
        }
    }
}

/// What stands beside the examples, whose files hold nothing but chats.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ChatManifest {
    /// What the answers were compared with, in words.
    truth: String,
    /// The most wrong claims of an example.
    allowed_wrong_claims: u32,
    /// Where the reasoning stands: think, field or none.
    reasoning_form: &'static str,
    /// Share of the maps whose examples are for validation.
    validation_share: f64,
    /// Seed of the split by map.
    split_seed: u64,
    /// The files of examples.
    files: Vec<ChatFile>,
    /// Answers that are no example, by reason.
    left_out: BTreeMap<&'static str, usize>,
    /// What to know before numbers are compared.
    notes: Vec<String>,
    /// Program, models, templates and scenarios behind the examples.
    provenance: Provenance,
}

/// One file of examples.
#[derive(Debug, Serialize, JsonSchema)]
struct ChatFile {
    /// Its name.
    file: String,
    /// SHA-256 of its bytes.
    sha256: String,
    /// How many of its examples have a picture.
    with_pictures: usize,
    /// In how many of them no claim was found to be checked.
    without_claims: usize,
    /// The stored run of each line, in order.
    run_ids: Vec<i64>,
    /// Names of the scenarios.
    scenario_names: Vec<String>,
}

/// A part of the examples while it is written.
struct Part {
    path: PathBuf,
    file: BufWriter<NewFile>,
    hash: Sha256,
    runs: Vec<RunId>,
    with_pictures: usize,
    without_claims: usize,
    scenarios: BTreeSet<String>,
}

/// Writes the examples among these runs into a folder.
pub fn run(
    options: &ChatOptions,
    (folder, overwrite): (Option<&Path>, bool),
    store: &Store,
    mut runs: Vec<Run>,
    locked: &LockedAnswers,
) -> Outcome {
    let Some(folder) = folder else {
        return Err(Failure::input(
            "--format chat writes train.jsonl, validation.jsonl and manifest.json: name a folder with -o FOLDER",
        ));
    };
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::input(format!(
            "{}: is a file; --format chat writes into a folder",
            folder.display()
        )));
    }
    let rules = options.rules();
    locked.say("exports");
    runs.retain(|run| !locked.has(run.run));
    let sources = if options.truth.is_empty() {
        [truth::BATCH, truth::AUTO].map(PathBuf::from).to_vec()
    } else {
        options.truth.clone()
    };
    let unchecked = truth::complete_claims(store, &mut runs, truth::claimed_files(&sources))?;
    let known = truth::truth(&sources, store, &runs)?;
    let mut examples = Examples::default();
    let mut chosen = Vec::new();
    for run in &runs {
        match rules.refuses(run, &known) {
            Some(why) => examples.leave_out(why),
            None => chosen.push(run),
        }
    }
    chosen.sort_by_key(|run| run.run);
    if chosen.is_empty() {
        return Err(nothing(&examples, unchecked.as_deref()));
    }
    let asides = store.asides().map_err(Failure::input)?;
    let words = truth::truth_description(&sources, &stored(&runs, &known, &asides), store)?;
    let is_new = !folder.exists();
    fs::create_dir_all(folder).map_err(|error| Failure::system(folder.display(), &error))?;
    let stop = interrupted(true);
    let mut parts = [
        Part::begin(folder, "train.jsonl", overwrite)?,
        Part::begin(folder, "validation.jsonl", overwrite)?,
    ];
    let manifest = folder.join("manifest.json");
    let manifest = NewFile::begin(&manifest, overwrite).map_err(|error| refused(&error))?;
    let progress = Progress::new(chosen.len(), "answers", true);
    for outcome in &chosen {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::interrupted("no file was written"));
        }
        progress.step();
        let Some(run) = store.run(outcome.run).map_err(Failure::input)? else {
            // It is gone meanwhile.
            continue;
        };
        let pictures = pictures(store, &run)?;
        let line = examples
            .line(&rules, &run, &pictures)
            .map_err(Failure::input)?;
        if let Some(line) = line {
            let part = match rules.part(&outcome.scenario) {
                SplitPart::Dev => &mut parts[0],
                SplitPart::Test => &mut parts[1],
            };
            part.write(&line, outcome)?;
            part.with_pictures += usize::from(!pictures.is_empty());
        }
    }
    drop(progress);
    let [train, validation] = [parts[0].runs.len(), parts[1].runs.len()];
    let seeing = parts[0].with_pictures + parts[1].with_pictures;
    if train + validation == 0 {
        drop((parts, manifest));
        if is_new {
            // Left where something else has been put into it meanwhile.
            let _ = fs::remove_dir(folder);
        }
        return Err(nothing(&examples, unchecked.as_deref()));
    }
    let written = parts.iter().flat_map(|part| part.runs.iter().copied());
    let provenance = Provenance::of_runs(store, &written.collect()).map_err(Failure::input)?;
    let by_score = chosen.iter().filter(|run| known.is_score(run));
    let ways: Vec<_> = by_score
        .map(|run| (way(run), known.asked_as(run.run).measures))
        .collect();
    let ways = ways.iter().map(|(way, measures)| (way, measures.as_ref()));
    let score_note = note_on_score(ways);
    let document = ChatManifest {
        truth: words,
        allowed_wrong_claims: rules.wrong_claims,
        reasoning_form: rules.reasoning.name(),
        validation_share: rules.split.test,
        split_seed: rules.split.seed,
        left_out: examples
            .left_out
            .iter()
            .map(|(why, count)| (why.name(), *count))
            .collect(),
        notes: score_note.into_iter().chain(unchecked.clone()).collect(),
        provenance,
        files: parts
            .into_iter()
            .map(Part::finish)
            .collect::<Result<_, _>>()?,
    };
    save_manifest(manifest, &document)?;
    say_left_out(&examples, unchecked.as_deref());
    output::say(&format!(
        "{} for training and {} for validation in {}",
        output::counted(train, "example"),
        validation,
        folder.display()
    ));
    if seeing > 0 {
        let examples = output::counted(seeing, "example");
        output::say(&format!(
            "nearmiss: {examples} with a picture: only models that see can be trained on them; --no-pictures leaves them out"
        ));
    }
    Ok(())
}

/// The pictures that a run was asked with, as far as the store has them.
fn pictures(store: &Store, run: &nearmiss_store::Run) -> Result<Pictures, Failure> {
    let mut found = Pictures::new();
    for hash in run.question.image_hashes() {
        if let Some(image) = store.image(&hash).map_err(Failure::input)? {
            found.insert(hash, image);
        }
    }
    Ok(found)
}

/// How an answer was asked for, as far as its description matters.
fn way(run: &Run) -> PromptConfig {
    PromptConfig {
        task: run.task,
        frame: Frame::parse(&run.frame),
        techniques: None,
        model: run.model.clone(),
        settings: AxisValues::default(),
        template: None,
    }
}

fn save_manifest(mut file: NewFile, document: &ChatManifest) -> Outcome {
    let document = json::Output::document(document).map_err(Failure::input)?;
    let text = serde_json::to_string_pretty(&json::versioned(document)).map_err(Failure::input)?;
    let done = file.write_all(format!("{}\n", escaped_json_lines(&text)).as_bytes());
    done.map_err(|error| Failure::system("manifest.json", &error))?;
    file.finish().map_err(Failure::input)
}

/// Escaped line by line: the line breaks between keys stay.
fn escaped_json_lines(text: &str) -> String {
    let lines: Vec<String> = text.lines().map(escaped_json).collect();
    lines.join("\n")
}

/// Says why no answer is an example, and what helps.
fn nothing(examples: &Examples, unchecked: Option<&str>) -> Failure {
    say_left_out(examples, unchecked);
    let mut message = String::from("no answer can be an example; nothing was written");
    if examples.left_out.contains_key(&NoExample::NoTruth) {
        message.push_str("; --truth CSV|auto|score|FOLDER says what answers are compared with");
    }
    if examples.left_out.contains_key(&NoExample::NoMessages) {
        message.push_str(
            "; recorded answers that were imported have no messages and can never be examples: ask a model (nearmiss evaluate)",
        );
    }
    Failure::finding(message)
}

/// Says how many answers were left out, and why.
fn say_left_out(examples: &Examples, unchecked: Option<&str>) {
    for (why, count) in &examples.left_out {
        let answers = output::counted(*count, "answer");
        output::say(&format!("nearmiss: left out {answers} {}", why.label()));
    }
    if let Some(words) = unchecked {
        output::say(&format!("nearmiss: {words}"));
    }
}

impl Part {
    fn begin(folder: &Path, name: &str, overwrite: bool) -> Result<Self, Failure> {
        let path = folder.join(name);
        let file = NewFile::begin(&path, overwrite).map_err(|error| refused(&error))?;
        Ok(Self {
            path,
            file: BufWriter::new(file),
            hash: Sha256::new(),
            runs: Vec::new(),
            with_pictures: 0,
            without_claims: 0,
            scenarios: BTreeSet::new(),
        })
    }

    fn write(&mut self, line: &str, outcome: &Run) -> Outcome {
        let line = format!("{}\n", escaped_json(line));
        self.hash.update(&line);
        self.runs.push(outcome.run);
        self.scenarios.insert(outcome.scenario.clone());
        self.without_claims += usize::from(outcome.claims.known() == Some([0; 3]));
        let done = self.file.write_all(line.as_bytes());
        done.map_err(|error| Failure::system(self.path.display(), &error))
    }

    fn finish(self) -> Result<ChatFile, Failure> {
        let whole = self
            .file
            .into_inner()
            .map_err(|error| Failure::system(self.path.display(), &error.into_error()))?;
        whole.finish().map_err(Failure::input)?;
        let name = self.path.file_name().unwrap_or_default();
        Ok(ChatFile {
            file: name.to_string_lossy().into_owned(),
            sha256: self
                .hash
                .finalize()
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect(),
            with_pictures: self.with_pictures,
            without_claims: self.without_claims,
            run_ids: self.runs.iter().map(|run| run.0).collect(),
            scenario_names: self.scenarios.into_iter().collect(),
        })
    }
}
