//! The table of an experiment: every setting of a batch, once for files, command line, store, workbench and reports.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::matrix::Split;
use super::truth::TruthSource;
use crate::evaluation::report::{Comparison, PivotRequest};
use crate::evaluation::windows::{LEAD, WITHIN};
use crate::evaluation::{AxisValues, Lead, PAPER_STEPS, Protocol, Settings, default_frame};
use nearmiss_ask::llm::{Dialect, Effort, Endpoint, Parameters, ToolLimits};
use nearmiss_ask::prompts::{Library, MAX_DECIMALS, Pack, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_record::fields::{Fields, OneOrMore, Word};
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::metrics::MeasureList;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use toml::Value;

nearmiss_record::fields! {
    /// Questions about scenarios: prompt configurations, counting and cost. Fields that `grow` may be extended in a
    /// batch that has begun; those of a `run` and a `pin` are not what is asked; each value of an `axis` is a
    /// configuration.
    pub struct Experiment {
        "scenarios" {
            /// One-line title of the experiment.
            title: Option<String>;
            /// Scenario files and folders, relative to the folder of this file, and names of bundled scenarios.
            scenarios [required]: Vec<PathBuf>;
            /// Filter of the workbench's list that scenarios must match, such as `tag:cut_in risk<3`.
            select: Option<String>;
            /// Dev/test split: `{ test = 0.5, seed = 7 }`; the figures of the test split stay locked until all its
            /// questions are answered.
            split: Option<Split>;
            /// Ground truth [default: layout if its folders exist, else auto]: `auto` (exact geometry), `layout`
            /// (folders collision_scenarios and normal_scenarios), `score` or `score:paper` (risk score of TTC and
            /// MDC), or CSV files with labels.
            truth: Option<TruthSource>;
        }
        "questions" {
            /// Models, as provider/model.
            models [required, grows]: Vec<String>, Takes::Checked(model);
            /// Tasks: safety, collision or recording [default: safety].
            tasks: Vec<Task>;
            /// Frames of the description [default: that of the first task].
            frames: Vec<Frame>;
            /// Prompting techniques: base, cp, cot, icl, all, or combinations such as cp+cot [default: all].
            techniques [grows]: Vec<Techniques>;
            /// Answers to each question [default: 1].
            samples [grows]: Option<u32>, Takes::Whole(1, 1000);
            /// Ends of the dangerous windows of the safety task: seconds before the contact, or `end` [default: 1].
            leads [grows]: Vec<Lead>;
            /// Transforms of the scene under which every question is asked again: rotate:DEGREES, mirror, move:X,Y,
            /// renumber:SEED.
            transforms [grows]: Vec<Transform>;
        }
        "windows" {
            /// Windows and counting: `matched` (windows at leads, and similar safe ones) or `paper` (as in "From Words
            /// to Collisions", without leads and within) [default: matched].
            protocol: Protocol;
            /// Seconds after a window within which a contact of the ego makes it dangerous [default: 2].
            within: Option<f64>, Takes::Above(0.0, 10.0), "s";
            /// Ask about a window of every safe scenario, even if it is unlike all dangerous ones [default: false].
            every_scenario: bool;
            /// Steps in a window [default: from the template].
            history: Option<usize>, Takes::Whole(1, 100_000), "steps";
        }
        "description" {
            /// Radius around the ego in metres within which obstacles are described; farther ones only if they can
            /// reach it soon [default: from the template].
            radius: Option<f64>, Takes::Above(0.0, 1e6), "m";
            /// Decimal places of numbers [default: from the template].
            precision: Option<usize>, Takes::Whole(0, MAX_DECIMALS as i64);
            /// Wording of the description: compact or prose, or both [default: from the template, else compact].
            form [axis]: OneOrMore<Form>;
            /// Interval of described steps, one or several: 2 describes every second one [default: from the template,
            /// else 1].
            stride [axis]: OneOrMore<usize>, Takes::Whole(1, 1000);
            /// State whether bodies touch [default: from the template].
            contact: Option<bool>;
            /// Describe the road near the ego in the Cartesian frame [default: from the template, else false].
            road: Option<bool>;
            /// Axes of the ego frame: along the ego's `heading` or its `lane` [default: from the template, else
            /// heading].
            axes: Option<EgoAxes>;
            /// Measures of the metrics frame, such as `["ttc", "thw"]` [default: from the template].
            measures: Vec<String>;
            /// Template pack: `standard`, or `paper` for the prompts of "From Words to Collisions" [default: standard].
            pack: Pack;
        }
        "sampling" {
            /// Sampling temperature, one or several [default: from the template, else the server's].
            temperature [axis]: OneOrMore<f64>, Takes::Number(0.0, 2.0);
            /// Maximum number of tokens per answer [default: the server's].
            max_tokens: Option<u32>, Takes::Whole(1, 4_294_967_295);
            /// Reasoning effort, one or several [default: the server's].
            effort [axis]: OneOrMore<Effort>;
            /// Sampling seed, one or several, for servers that support it [default: none].
            seed [axis]: OneOrMore<u64>;
            /// Request the log probabilities of answers from models that support them [default: false].
            log_probabilities: bool;
            /// Let models call tools that compute; `[false, true]` asks with and without [default: false].
            tools [axis]: OneOrMore<bool>;
            /// Maximum number of requests per answer that may end in tool calls [default: 8].
            tool_rounds: u32 = ToolLimits::default().rounds, Takes::Whole(1, 100);
            /// Maximum number of tool calls per answer [default: 32].
            tool_calls: u32 = ToolLimits::default().calls, Takes::Whole(1, 1000);
        }
        "run" {
            /// Address of one server for all models, instead of the providers' own.
            base_url: Option<String>;
            /// API dialect of the server at base_url [default: that of the provider].
            dialect: Option<String>, Takes::Checked(dialect);
            /// Environment variable with the API key for base_url [default: those of the provider].
            key_env: Option<String>;
            /// Maximum cost of a run in US dollars [default: `budget` in config.toml].
            budget [run]: Option<f64>, Takes::Above(0.0, 1e9), "USD";
            /// Concurrent requests to each provider [default: `concurrency` in config.toml].
            concurrency [run]: Option<u32>, Takes::Whole(1, 4_294_967_295);
        }
        "comparison" {
            /// Model or prompt configuration to compare all others with, by its name in the tables.
            baseline: Option<String>;
            /// Primary comparison: two names. Its p-value is not adjusted for the other comparisons.
            compare: Option<(String, String)>;
            /// Tables over axes in reports of the batch, as with `report --rows`: `[{ rows = "techniques", columns =
            /// "model", measure = "f1", against = "base" }]`.
            tables: Vec<PivotRequest>;
        }
        "tuning" {
            /// Search settings of `tune`: `{ rounds = 4, candidates = 3, seed = 1, reflect = "provider/model",
            /// proposal_tokens = 8192 }`.
            tune [run]: TuneSettings;
        }
        "pins" {
            /// Templates of the experiment, as NAME@HASH; others are refused.
            templates [pin]: Vec<TemplatePin>;
            /// Contents of the scenarios, by name, as the start of their SHA-256; others are refused.
            hashes [pin]: BTreeMap<String, Hashes>;
        }
    }
}

nearmiss_record::fields! {
    /// How much a tune tries.
    pub struct TuneSettings {
        "tuning" {
            /// Maximum number of rounds.
            rounds: u32 = 4, Takes::Whole(1, 100);
            /// Templates proposed in each round.
            candidates: u32 = 3, Takes::Whole(1, 20);
            /// Seed for the parts of the dev split, the answers shown and the templates changed.
            seed: u64 = 1;
            /// Model that proposes templates, as provider/model [default: the one whose template is tuned].
            reflect: Option<String>, Takes::Checked(model);
            /// Maximum number of tokens per proposal, reasoning included.
            proposal_tokens: u32 = 8192, Takes::Whole(1, 4_294_967_295);
        }
    }
}

fn model(id: &str) -> Result<(), String> {
    match id.split_once('/') {
        Some((provider, model)) if !provider.is_empty() && !model.is_empty() => Ok(()),
        _ => Err(format!(
            "{id}: expected provider/model, such as openai/gpt-6-luna"
        )),
    }
}

fn dialect(word: &str) -> Result<(), String> {
    let known = Dialect::ALL.map(Dialect::name);
    if known.contains(&word) {
        Ok(())
    } else {
        Err(unknown("dialect", word, known))
    }
}

/// Digits of a hash that tell a template or a scenario from others.
pub const HASH_DIGITS: usize = 12;

/// The content of a file, by the start of its hash; several where files of one name differ.
pub type Hashes = OneOrMore<ContentHash>;

/// The start of a SHA-256, in small letters.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ContentHash(pub String);

impl Word for ContentHash {
    fn of_word(word: &str) -> Result<Self, String> {
        if word.len() >= HASH_DIGITS && word.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            Ok(Self(word.to_lowercase()))
        } else {
            Err(format!("expected {HASH_DIGITS} hexadecimal digits or more"))
        }
    }

    fn word(&self) -> String {
        self.0.clone()
    }
}

/// A template and the start of its hash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TemplatePin {
    /// Its file name.
    pub name: String,
    /// The start of its hash.
    pub hash: String,
}

impl Word for TemplatePin {
    fn of_word(word: &str) -> Result<Self, String> {
        match word.split_once('@') {
            Some((name, hash)) if hash.len() >= HASH_DIGITS => Ok(Self {
                name: name.into(),
                hash: hash.into(),
            }),
            _ => Err(format!(
                "{word}: expected NAME@HASH, with {HASH_DIGITS} digits of the hash or more"
            )),
        }
    }

    fn word(&self) -> String {
        format!("{}@{}", self.name, self.hash)
    }
}

impl Experiment {
    /// Fills in what depends on other fields: task, frame, techniques, and windows as the protocol draws them. Gives what
    /// is wrong, each with its key.
    pub fn complete(&mut self, library: &Library) -> Vec<(&'static str, String)> {
        let mut mistakes = self.mistakes();
        if self.tasks.is_empty() {
            self.tasks = vec![Task::Safety];
        }
        if self.frames.is_empty() {
            self.frames = vec![default_frame(library, self.tasks[0])];
        }
        if self.techniques.is_empty() {
            self.techniques = vec![Techniques::ALL];
        }
        self.samples = self.samples.or(Some(1));
        self.draw_windows();
        let beyond = |lead: &&Lead| lead.is_beyond(self.within);
        if let Some(lead) = self.leads.iter().find(beyond) {
            let within = self.within.unwrap_or_default();
            let words = format!(
                "{lead}: the contact is later than within = {within} s, which makes the window safe"
            );
            mistakes.push(("leads", words));
        }
        if !self.leads.is_empty() && !self.tasks.contains(&Task::Safety) {
            mistakes.push(("leads", "leads are for the safety task".into()));
        }
        if let Some(why) = self.settings(None).misplaced(&self.frames, "") {
            mistakes.push(("frames", why));
        }
        if let Err(why) = self.check_size() {
            mistakes.push(("models", why));
        } else {
            mistakes.extend(self.unknown_names());
        }
        mistakes
    }

    /// What is wrong about fields as they were said, each with its key.
    #[must_use]
    pub fn mistakes(&self) -> Vec<(&'static str, String)> {
        let mut mistakes = Vec::new();
        let own = "protocol = \"paper\" has windows of its own; remove one of the two";
        if self.protocol == Protocol::Paper {
            let given = [
                ("leads", !self.leads.is_empty()),
                ("within", self.within.is_some()),
            ];
            let given = given.into_iter().filter(|(_, given)| *given);
            mistakes.extend(given.map(|(key, _)| (key, own.into())));
        }
        if let Some(task) = self
            .tasks
            .iter()
            .find(|task| !Task::VERDICTS.contains(task))
        {
            let (task, known) = (task.name(), Task::names(&Task::VERDICTS));
            let words = format!("{task} cannot be evaluated: it has no yes or no; use {known}");
            mistakes.push(("tasks", words));
        }
        let measures = self.measures.iter().map(String::as_str);
        if let Err(why) = MeasureList::from_ids(measures) {
            mistakes.extend((!self.measures.is_empty()).then_some(("measures", why)));
        }
        let secret = |url: &String| Endpoint::new("", url.as_str()).has_secret_address();
        if self.base_url.as_ref().is_some_and(secret) {
            let words = "contains a password or key, which the batch would store; set base_url of the provider in \
                         config.toml, or name the key with key_env";
            mistakes.push(("base_url", words.into()));
        }
        if self.base_url.is_none() {
            let given = [
                ("dialect", self.dialect.is_some()),
                ("key_env", self.key_env.is_some()),
            ];
            let given = given.into_iter().filter(|(_, given)| *given);
            let needed = "needs base_url; a provider has its own in config.toml";
            mistakes.extend(given.map(|(key, _)| (key, needed.into())));
        }
        let with_tools = self.tools.is_axis() || self.tools.one() == Some(true);
        for key in ["tool_rounds", "tool_calls"] {
            if !with_tools && self.get(key).is_some() {
                let needed = "limits tools, which are off; set tools = true, too";
                mistakes.push((key, needed.into()));
            }
        }
        for table in &self.tables {
            if let Err((part, words)) = table.check() {
                mistakes.push(("tables", format!("{part}: {words}")));
            }
        }
        mistakes
    }

    /// Declared names that no way of asking has.
    fn unknown_names(&self) -> Option<(&'static str, String)> {
        let (comparison, configurations) = (self.comparison(), self.configurations());
        let configurations: Vec<_> = configurations.iter().collect();
        let name = (*comparison.unknown(&configurations).first()?).to_string();
        let key = if self.baseline.as_ref() == Some(&name) {
            "baseline"
        } else {
            "compare"
        };
        let models = self.models.join(", ");
        let example = configurations
            .iter()
            .find(|configuration| configuration.frame.is_some());
        let example = example.map_or(String::new(), |configuration| {
            format!(
                "; a prompt configuration is called as in tables, such as `{}`",
                crate::evaluation::report::configuration_name(configuration)
            )
        });
        let words = format!(
            "{name}: no such model or prompt configuration in this experiment; the models are {models}{example}"
        );
        Some((key, words))
    }

    /// Windows as the protocol draws them: by default dangerous ones and safe ones like them.
    pub fn draw_windows(&mut self) {
        if self.protocol == Protocol::Paper {
            self.leads.clear();
            self.within = None;
            self.history = self.history.or(Some(PAPER_STEPS));
            return;
        }
        if self.leads.is_empty() && self.tasks.contains(&Task::Safety) {
            self.leads = vec![LEAD];
        }
        self.within = self.within.or(Some(WITHIN));
    }

    /// Where windows of the safety task end first; `None` for the usual end, two steps before the last recorded one.
    #[must_use]
    pub fn lead(&self) -> Option<Lead> {
        self.leads.first().copied()
    }

    /// Answers to each question.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples.unwrap_or(1)
    }

    /// The leads beside the first.
    #[must_use]
    pub fn more_leads(&self) -> &[Lead] {
        self.leads.get(1..).unwrap_or_default()
    }

    /// The measures of the metrics frame; `None` for those of the template.
    #[must_use]
    pub fn measures(&self) -> Option<MeasureList> {
        let ids = self.measures.iter().map(String::as_str);
        (!self.measures.is_empty()).then(|| MeasureList::from_ids(ids).ok())?
    }

    /// Which comparisons matter.
    #[must_use]
    pub fn comparison(&self) -> Comparison {
        Comparison {
            baseline: self.baseline.clone(),
            primary: self.compare.clone(),
        }
    }

    /// What is asked, without how it is run and what it was written with.
    #[must_use]
    pub fn asked(&self) -> Self {
        Self {
            budget: None,
            concurrency: None,
            tune: TuneSettings::default(),
            templates: Vec::new(),
            hashes: BTreeMap::new(),
            ..self.clone()
        }
    }

    /// The settings that determine a scene's description; those of axes are in each way of asking.
    #[must_use]
    pub fn settings(&self, techniques: Option<Techniques>) -> Settings {
        Settings {
            history: self.history,
            radius: self.radius,
            precision: self.precision,
            contact: self.contact,
            form: self.form.one(),
            stride: self.stride.one(),
            road: self.road,
            axes: self.axes,
            measures: self.measures(),
            techniques,
            ..Settings::default()
        }
    }

    /// The parameters sent beside the messages; those of axes are in each way of asking.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        let limits = ToolLimits {
            rounds: self.tool_rounds,
            calls: self.tool_calls,
        };
        Parameters {
            temperature: self.temperature.one(),
            max_tokens: self.max_tokens,
            seed: self.seed.one(),
            effort: self.effort.one(),
            log_probabilities: self.log_probabilities,
            tools: (self.tools.is_axis() || self.tools.one() == Some(true)).then_some(limits),
        }
    }

    /// Each setting with several values, and these.
    pub fn several(&self) -> impl Iterator<Item = (&'static str, Vec<Value>)> {
        AxisValues::rows().iter().filter_map(|row| {
            let value = self.get(row.key)?;
            Some((row.key, value.as_array()?.clone()))
        })
    }

    /// The same for programs.
    #[must_use]
    pub fn axes_as_json(&self) -> BTreeMap<&'static str, serde_json::Value> {
        let mut all = self.to_json();
        let keys = self.several().map(|(key, _)| key);
        keys.filter_map(|key| Some((key, all.remove(key)?)))
            .collect()
    }

    /// Every combination of values of settings with several, in the order of the lists; without any one that says
    /// nothing.
    #[must_use]
    pub fn axis_values(&self) -> Vec<AxisValues> {
        let mut all = vec![AxisValues::default()];
        for (key, values) in self.several() {
            let with = |one: &AxisValues, value| {
                let mut one = *one;
                // A value of the experiment is one of its axis.
                let _ = one.set(key, value);
                one
            };
            all = all
                .iter()
                .flat_map(|one| values.iter().map(move |value| with(one, value)))
                .collect();
        }
        all
    }

    /// Adds what is not there yet.
    pub fn extend(&mut self, more: &Self) {
        add(&mut self.models, &more.models);
        add(&mut self.techniques, &more.techniques);
        add(&mut self.leads, &more.leads);
        add(&mut self.transforms, &more.transforms);
        self.samples = self.samples.max(more.samples);
    }
}

fn add<T: Clone + PartialEq>(to: &mut Vec<T>, more: &[T]) {
    for one in more {
        if !to.contains(one) {
            to.push(one.clone());
        }
    }
}
