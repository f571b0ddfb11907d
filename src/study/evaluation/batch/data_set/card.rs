//! The files beside the rows of a data set: its card for the Hugging Face Hub, and `eval.yaml`, which makes it a benchmark.

use nearmiss_base::system::visible;
use nearmiss_record::{CaptionedTable, NONE, columns, escaped_markdown, row};
use nearmiss_scene::verdict::Task;
use nearmiss_store::SplitPart;
use schemars::JsonSchema;
use serde_json::Value;

use super::{DataSetAnswer, DataSetFacts, DataSetQuestion};
use crate::evaluation::batch::Spec;
use crate::evaluation::{Provenance, note_on_score};

/// What the texts of a data set are made from.
#[derive(Debug)]
pub struct DataSetCard<'a> {
    /// The batch's specification, in the portable form.
    pub spec: &'a Spec,
    /// What the rows hold.
    pub facts: &'a DataSetFacts,
    /// Where they are from.
    pub provenance: &'a Provenance,
    /// What else to know, a sentence each.
    pub notes: Vec<String>,
}

/// The config of the questions; programs take it where none is named.
const QUESTIONS: &str = "default";

/// The config of the answers.
const ANSWERS: &str = "answers";

impl DataSetCard<'_> {
    /// The file of a part's questions, below the folder of the data set.
    #[must_use]
    pub fn questions_file(part: &str) -> String {
        format!("data/{part}.parquet")
    }

    /// The file of a part's answers.
    #[must_use]
    pub fn answers_file(part: &str) -> String {
        format!("answers/{part}.parquet")
    }

    /// Every file that a data set may have beside its card and `eval.yaml`.
    #[must_use]
    pub fn all_files() -> Vec<String> {
        let parts = SplitPart::ALL.iter().map(|part| part.name());
        parts
            .flat_map(|part| [Self::questions_file(part), Self::answers_file(part)])
            .collect()
    }

    /// Its title: that of the experiment, else what it asks.
    fn title(&self) -> String {
        let title = self.spec.experiment.title.as_deref().map(visible);
        title.map_or_else(|| format!("Driving scenes: {}", self.tasks()), Into::into)
    }

    fn tasks(&self) -> String {
        let names: Vec<&str> = self.facts.tasks.iter().map(|task| task.name()).collect();
        names.join(", ")
    }

    fn truth(&self) -> String {
        visible(&self.spec.truth_summary()).into_owned()
    }

    /// The parts with questions; the one that figures are published of stands first.
    fn parts(&self) -> impl Iterator<Item = (&'static str, (usize, usize))> {
        self.facts
            .parts
            .iter()
            .rev()
            .map(|(part, rows)| (*part, *rows))
    }

    /// `README.md`: the card, with what the Hub reads in front.
    #[must_use]
    pub fn readme(&self) -> String {
        let mut text = format!("---\n{}---\n\n", self.front());
        text += &format!("# {}\n\n", escaped_markdown(&self.title()));
        text += "Yes-or-no questions about driving scenes, each with the true answer, and the answers of language \
                 models. Written by nearmiss.\n";
        text += &self.rows().markdown();
        text += "\n## Questions\n\nA row is one window of a scenario in one wording, whoever was asked.\n";
        text += &described::<DataSetQuestion>("Columns of the questions").markdown();
        text += "\n## Answers\n\nA row is one answer of one model.\n";
        text += &described::<DataSetAnswer>("Columns of the answers").markdown();
        text += &self.truth_section();
        text += &self.benchmark_section();
        text += "\n## Licence\n\nThis card names no licence. The scenes belong to those who published them, whose terms \
                 hold for descriptions of them, too; the terms of the providers hold for the answers. Before you publish \
                 the folder, add `license:` to the first lines.\n";
        text += &self.provenance_section();
        text
    }

    /// The metadata in front of the card.
    fn front(&self) -> String {
        let mut text = format!("pretty_name: {}\n", quoted(&self.title()));
        text += "task_categories:\n- question-answering\n";
        if self.facts.with_pictures {
            text += "- visual-question-answering\n";
        }
        text += "tags:\n- autonomous-driving\n- traffic-safety\n- nearmiss\n";
        let questions = self.parts().map(|(_, (questions, _))| questions).sum();
        text += &format!("size_categories:\n- {}\nconfigs:\n", size(questions));
        let questions = self
            .parts()
            .map(|(part, _)| (part, Self::questions_file(part)));
        text += &config(QUESTIONS, true, questions);
        let answers = self.parts().filter(|(_, (_, answers))| *answers > 0);
        text + &config(
            ANSWERS,
            false,
            answers.map(|(part, _)| (part, Self::answers_file(part))),
        )
    }

    /// How many rows each part has.
    fn rows(&self) -> CaptionedTable {
        let of = |config: &str, part: &str, rows: usize| {
            vec![config.into(), part.into(), rows.to_string()]
        };
        let questions = self.parts().map(|(part, rows)| of(QUESTIONS, part, rows.0));
        let answers = self.parts().map(|(part, rows)| of(ANSWERS, part, rows.1));
        CaptionedTable {
            caption: "Rows".into(),
            columns: headings(&[("config", false), ("split", false), ("rows", true)]),
            rows: questions
                .chain(answers)
                .filter(|row| row[2] != "0")
                .collect(),
            ..CaptionedTable::default()
        }
    }

    fn truth_section(&self) -> String {
        let mut text = String::from("\n## Truth\n\n`target` is `true` if\n\n");
        for task in &self.facts.tasks {
            text += &format!("- {}: {}\n", task.name(), self.meaning(*task));
        }
        text += &format!("\nSource: {}.\n", escaped_markdown(&self.truth()));
        let ways = self.facts.ways.iter();
        let measures = self.spec.experiment.measures();
        let by_score = ways.filter(|way| self.spec.truth().is_score(way.task));
        let settings = visible(&self.spec.request_summary(None)).into_owned();
        let notes = std::iter::once(settings)
            .chain(note_on_score(by_score.map(|way| (way, measures.as_ref()))))
            .chain(self.notes.iter().cloned())
            .chain(self.left_out());
        for note in notes {
            text += &format!("\n{}\n", escaped_markdown(&note));
        }
        text
    }

    /// What a yes says.
    fn meaning(&self, task: Task) -> String {
        match (task, self.spec.experiment.within) {
            _ if self.spec.truth().is_score(task) => {
                format!(
                    "an obstacle has a risk score of at most {}",
                    Task::HIGH_RISK
                )
            }
            (Task::Collision, _) => {
                "the ego's body touches another body at one of the described times".into()
            }
            (Task::Safety, Some(horizon)) => {
                format!("the ego's body touches another body in the {horizon} s after the window")
            }
            _ => "the recording is labelled dangerous".into(),
        }
    }

    /// What the batch has and the data set has not.
    fn left_out(&self) -> Option<String> {
        let each = self.facts.left_out.iter();
        let each: Vec<String> = each
            .map(|(why, count)| format!("{count} {}", why.label()))
            .collect();
        (!each.is_empty())
            .then(|| format!("Left out of the batch's questions: {}.", each.join("; ")))
    }

    fn benchmark_section(&self) -> String {
        let Some(pattern) = self.pattern() else {
            return String::new();
        };
        let tools = if self.facts.with_tools {
            " Models of rows `with_tools` had tools, which it does not offer."
        } else {
            ""
        };
        format!(
            "\n## Benchmark\n\nOnce the folder is on the Hub, `eval.yaml` makes the questions a benchmark of Inspect:\n\n\
             ```sh\ninspect eval hf/OWNER/NAME --model PROVIDER/MODEL\n```\n\nIt scores yes or no alone: the last match of \
             `{pattern}` in an answer beside `target`. nearmiss reads other forms of an answer, too.{tools}\n"
        )
    }

    fn provenance_section(&self) -> String {
        // A record of plain values can be written as JSON.
        let cells = row(self.provenance).unwrap_or_default();
        let mut text = String::from("\n## Provenance\n\n");
        for (column, cell) in columns::<Provenance>().iter().zip(cells) {
            let value = match cell.text(column.kind) {
                None => NONE.into(),
                // A list of nothing.
                Some(value) if value.is_empty() => "none".into(),
                Some(value) => escaped_markdown(&value),
            };
            text += &format!(
                "- `{}`: {value}. {}\n",
                column.name,
                escaped_markdown(&column.source)
            );
        }
        text
    }

    /// `eval.yaml`; `None` where no pattern finds yes or no in the answers to all questions.
    #[must_use]
    pub fn eval_yaml(&self) -> Option<String> {
        let pattern = quoted(&self.pattern()?);
        let about = format!(
            "Yes-or-no questions about driving scenes ({}). Truth: {}.",
            self.tasks(),
            self.truth()
        );
        let mut text = format!(
            "name: {}\ndescription: {}\nevaluation_framework: inspect-ai\n\ntasks:\n",
            quoted(&self.title()),
            quoted(&about)
        );
        for (part, _) in self.parts() {
            text += &format!(
                "  - id: {part}\n    config: {QUESTIONS}\n    split: {part}\n    field_spec:\n      input: user\n      \
                 target: target\n"
            );
            if self.facts.with_pictures {
                text += "      input_image: image\n";
            }
            text += "      metadata: [id, scenario, system]\n    solvers:\n";
            if self.facts.with_system {
                text += "      - name: system_message\n        args:\n          template: \"{system}\"\n";
            }
            text += &format!(
                "      - name: generate\n    scorers:\n      - name: pattern\n        args:\n          pattern: {pattern}\n"
            );
        }
        Some(text)
    }

    /// The regular expression that takes the last yes or no of an answer, as nearmiss does.
    fn pattern(&self) -> Option<String> {
        let keys: Vec<&str> = self.facts.keys.iter().copied().collect();
        (self.facts.without_key == 0).then(|| {
            format!(
                "[\\s\\S]*\"(?:{})\"\\s*:\\s*\"?(true|false)",
                keys.join("|")
            )
        })
    }
}

/// The columns of a record, with their units and meanings.
fn described<R: JsonSchema>(caption: &str) -> CaptionedTable {
    let rows = columns::<R>().into_iter().map(|column| {
        vec![
            column.name.to_string(),
            column.unit.to_string(),
            column.source.to_string(),
        ]
    });
    CaptionedTable {
        caption: caption.into(),
        columns: headings(&[("column", false), ("unit", false), ("meaning", false)]),
        rows: rows.collect(),
        ..CaptionedTable::default()
    }
}

fn headings(titles: &[(&str, bool)]) -> Vec<(String, bool)> {
    let titles = titles.iter();
    titles
        .map(|(title, is_number)| ((*title).to_string(), *is_number))
        .collect()
}

/// A config of the card, with the file of each split; nothing without one.
fn config(
    name: &str,
    is_default: bool,
    files: impl Iterator<Item = (&'static str, String)>,
) -> String {
    let files: String = files
        .map(|(split, path)| format!("  - split: {split}\n    path: {path}\n"))
        .collect();
    if files.is_empty() {
        return files;
    }
    let default = if is_default { "  default: true\n" } else { "" };
    format!("- config_name: {name}\n{default}  data_files:\n{files}")
}

/// A text in YAML, which takes the strings of JSON.
fn quoted(text: &str) -> String {
    Value::from(&*visible(text)).to_string()
}

/// The Hub's word for so many rows.
fn size(rows: usize) -> &'static str {
    match rows {
        ..1_000 => "n<1K",
        1_000..10_000 => "1K<n<10K",
        10_000..100_000 => "10K<n<100K",
        100_000..1_000_000 => "100K<n<1M",
        _ => "1M<n<10M",
    }
}
