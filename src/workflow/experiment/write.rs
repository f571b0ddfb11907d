//! Writes an experiment as TOML.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::{Experiment, HASH_DIGITS};
use nearmiss_ask::llm::ToolLimits;
use nearmiss_ask::prompts::Pack;
use nearmiss_study::evaluation::batch::{Split, TruthSource};
use nearmiss_study::evaluation::report::{Axis, PivotRequest};
use nearmiss_study::evaluation::{Lead, Protocol};

impl Experiment {
    /// The same as a file in a folder: paths below the folder are written relative to it, all others absolute.
    ///
    /// # Errors
    /// A path is not UTF-8.
    pub fn to_toml(&self, folder: &Path) -> Result<String, String> {
        let mut table = Table::new();
        let mut set = |key: &str, value: Option<Value>| {
            if let Some(value) = value {
                table.insert(key.into(), value);
            }
        };
        let texts = |all: Vec<String>| {
            let all: Vec<Value> = all.into_iter().map(Value::String).collect();
            (!all.is_empty()).then_some(Value::Array(all))
        };
        let relative = |path: &PathBuf| {
            let below = path.strip_prefix(folder).unwrap_or(path);
            let text = below.to_str().map(str::to_string);
            text.ok_or_else(|| format!("{}: not UTF-8, which TOML needs", path.display()))
        };
        let (matrix, request) = (&self.matrix, &self.matrix.request);
        set("title", self.title.clone().map(Value::String));
        set(
            "scenarios",
            texts(self.paths.iter().map(relative).collect::<Result<_, _>>()?),
        );
        set("select", self.subset.select.clone().map(Value::String));
        set("split", self.subset.split.map(written_split));
        set(
            "truth",
            match &self.truth {
                Some(TruthSource::Files(files)) => {
                    texts(files.iter().map(relative).collect::<Result<_, _>>()?)
                }
                Some(source) => texts(source.sources()),
                None => None,
            },
        );
        set("models", texts(matrix.models.clone()));
        set("tasks", texts(words(&matrix.tasks, |task| task.name())));
        set("frames", texts(words(&matrix.frames, |frame| frame.name())));
        set(
            "techniques",
            texts(words(&matrix.techniques, ToString::to_string)),
        );
        set("samples", Some(i64::from(matrix.samples).into()));
        let leads: Vec<Value> = request
            .lead
            .iter()
            .chain(&matrix.more_leads)
            .map(written)
            .collect();
        set("leads", (!leads.is_empty()).then_some(Value::Array(leads)));
        set("within", request.within.map(Value::Float));
        let protocol = request.protocol;
        set(
            "protocol",
            (protocol != Protocol::default()).then(|| protocol.name().into()),
        );
        set(
            "transforms",
            texts(words(&matrix.transforms, ToString::to_string)),
        );
        set(
            "history",
            request
                .history
                .and_then(|steps| i64::try_from(steps).ok())
                .map(Value::Integer),
        );
        set("radius", request.radius.map(Value::Float));
        let axes = &matrix.axes;
        set(
            "temperature",
            one_or_each(request.temperature, &axes.temperatures, Value::Float),
        );
        set(
            "max_tokens",
            request.max_tokens.map(|most| i64::from(most).into()),
        );
        set(
            "effort",
            one_or_each(request.effort, &axes.efforts, |effort| effort.name().into()),
        );
        set(
            "form",
            one_or_each(request.form, &axes.forms, |form| form.name().into()),
        );
        set(
            "stride",
            one_or_each(request.stride, &axes.strides, integer),
        );
        set("road", request.road.map(Value::Boolean));
        set("axes", request.axes.map(|axes| axes.name().into()));
        let ids = request.measures.map_or(Vec::new(), |all| all.ids());
        set("measures", texts(words(&ids, |id| *id)));
        let pack = request.pack;
        set(
            "pack",
            (pack != Pack::default()).then(|| pack.name().into()),
        );
        set("seed", one_or_each(request.seed, &axes.seeds, integer));
        let limits = request.tools;
        let tools = match (axes.tools.is_empty(), limits) {
            (true, None) => None,
            (true, Some(_)) => Some(Value::Boolean(true)),
            (false, _) => {
                let values = axes.tools.iter().copied().map(Value::Boolean);
                Some(Value::Array(values.collect()))
            }
        };
        set("tools", tools);
        let usual = ToolLimits::default();
        let limits = limits.unwrap_or(usual);
        let unusual = |most: u32, usual: u32| (most != usual).then(|| i64::from(most).into());
        set("tool_rounds", unusual(limits.rounds, usual.rounds));
        set("tool_calls", unusual(limits.calls, usual.calls));
        set(
            "log_probabilities",
            request.log_probabilities.then_some(Value::Boolean(true)),
        );
        set("base_url", self.base_url.clone().map(Value::String));
        set("budget", self.budget.map(Value::Float));
        set(
            "baseline",
            self.comparison.baseline.clone().map(Value::String),
        );
        set(
            "compare",
            self.comparison
                .primary
                .clone()
                .and_then(|(a, b)| texts(vec![a, b])),
        );
        let tables: Vec<Value> = self.comparison.tables.iter().map(written_table).collect();
        set(
            "tables",
            (!tables.is_empty()).then_some(Value::Array(tables)),
        );
        let templates = self
            .templates
            .iter()
            .map(|(name, hash)| format!("{name}@{}", hash.get(..HASH_DIGITS).unwrap_or(hash)));
        set("templates", texts(templates.collect()));
        let hashes = self.hashes.iter().map(|(name, hashes)| {
            let value = match hashes.as_slice() {
                [one] => one.clone().into(),
                several => several.to_vec().into(),
            };
            (name.clone(), value)
        });
        let hashes: Table = hashes.collect();
        set(
            "hashes",
            (!hashes.is_empty()).then_some(Value::Table(hashes)),
        );
        toml::to_string(&table).map_err(|error| error.to_string())
    }
}

fn words<T, S: ToString>(values: &[T], word: impl Fn(&T) -> S) -> Vec<String> {
    values.iter().map(|value| word(value).to_string()).collect()
}

fn written(lead: &Lead) -> Value {
    match lead {
        Lead::Paper => "end".into(),
        Lead::Seconds(seconds) => (*seconds).into(),
    }
}

/// The value of a setting, or those of its axis.
fn one_or_each<T: Copy>(one: Option<T>, each: &[T], value: impl Fn(T) -> Value) -> Option<Value> {
    match one {
        Some(one) => Some(value(one)),
        None => {
            (!each.is_empty()).then(|| Value::Array(each.iter().map(|each| value(*each)).collect()))
        }
    }
}

/// A number that TOML can write; no setting takes larger ones.
fn integer(number: impl TryInto<i64>) -> Value {
    Value::Integer(number.try_into().unwrap_or(i64::MAX))
}

fn written_table(table: &PivotRequest) -> Value {
    let entries = [
        ("rows", Some(table.rows.name())),
        ("columns", table.columns.map(Axis::name)),
        ("measure", Some(table.measure.name())),
        ("against", table.against.as_deref()),
    ]
    .into_iter();
    Value::Table(
        entries
            .filter_map(|(key, value)| Some((key.to_string(), value?.into())))
            .collect(),
    )
}

fn written_split(split: Split) -> Value {
    let entries = [
        ("test", Value::Float(split.test)),
        ("seed", integer(split.seed)),
    ];
    Value::Table(
        entries
            .map(|(key, value)| (key.to_string(), value))
            .into_iter()
            .collect(),
    )
}
