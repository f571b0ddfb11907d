//! `nearmiss metrics --list`: every measure with its unit, meaning and danger threshold.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Metrics, Rows, measured};
use crate::output::TableFormat;
use crate::{Failure, Outcome, output};
use nearmiss_base::system::pad_end;
use nearmiss_scene::metrics::{Danger, SCENE_MEASURES, Threshold, Thresholds, measures};

/// One measure.
struct Line<'a> {
    id: &'static str,
    name: &'static str,
    unit: &'static str,
    danger: Danger,
    source: &'static str,
    thresholds: Vec<&'a Threshold>,
}

/// A measure for programs.
#[derive(Serialize, JsonSchema)]
pub struct ListDocument {
    /// Id of the measure.
    measure: &'static str,
    /// Name.
    name: &'static str,
    /// Unit.
    unit: &'static str,
    /// Which values are dangerous: low, high or none.
    dangerous: &'static str,
    /// Thresholds: name, value, strict and source.
    thresholds: Vec<ListedThreshold>,
    /// Source of the definition.
    source: &'static str,
}

#[derive(Serialize, JsonSchema)]
struct ListedThreshold {
    name: String,
    value: f64,
    strict: bool,
    source: String,
}

/// Prints the list.
pub(super) fn run(arguments: &Metrics, format: Option<TableFormat>) -> Outcome {
    let (rows, thresholds) = measured(arguments)?;
    let lines = lines(rows, &thresholds)?;
    match format {
        None => output::text(&output::visible(&table(&lines))),
        Some(TableFormat::Csv) => csv(&lines),
        Some(TableFormat::Json) => lines
            .iter()
            .try_for_each(|line| output::document(&line.document())),
        Some(TableFormat::Parquet | TableFormat::Arrow) => {
            Err(Failure::input("--list supports csv and json"))
        }
    }
}

fn lines(rows: Rows, thresholds: &Thresholds) -> Result<Vec<Line<'_>>, Failure> {
    let line = |id, name, unit, danger, source| Line {
        id,
        name,
        unit,
        danger,
        source,
        thresholds: thresholds.for_measure(id).collect(),
    };
    Ok(match rows {
        Rows::Exact => measures()
            .map(|m| line(m.id, m.name, m.unit, m.danger, m.source))
            .collect(),
        Rows::Scene => SCENE_MEASURES
            .iter()
            .map(|m| line(m.id, m.name, m.unit, m.danger, m.source))
            .collect(),
        Rows::Paper => {
            return Err(Failure::input(
                "--list and --convention paper exclude each other: the paper's columns are those of its tables",
            ));
        }
    })
}

/// Which values are dangerous, in a word.
fn direction(danger: Danger) -> &'static str {
    match danger {
        Danger::Low => "low",
        Danger::High => "high",
        Danger::Neutral => "none",
    }
}

impl Line<'_> {
    /// `≤ 1.5 s: critical`
    fn at(&self, threshold: &Threshold) -> String {
        let beyond = match (self.danger, threshold.strict) {
            (Danger::High, false) => "≥",
            (Danger::High, true) => ">",
            (_, false) => "≤",
            (_, true) => "<",
        };
        let Threshold { value, name, .. } = threshold;
        let space = if self.unit.is_empty() { "" } else { " " };
        format!("{beyond} {value}{space}{}: {name}", self.unit)
    }

    fn thresholds(&self) -> String {
        let all: Vec<String> = self.thresholds.iter().map(|t| self.at(t)).collect();
        all.join(", ")
    }

    fn document(&self) -> ListDocument {
        let thresholds = self.thresholds.iter().map(|t| ListedThreshold {
            name: t.name.clone(),
            value: t.value,
            strict: t.strict,
            source: t.source.clone(),
        });
        ListDocument {
            measure: self.id,
            name: self.name,
            unit: self.unit,
            dangerous: direction(self.danger),
            thresholds: thresholds.collect(),
            source: self.source,
        }
    }
}

/// Every built-in measure of an obstacle, then of a scene, with the shipped thresholds.
pub(crate) fn shipped() -> String {
    let thresholds = Thresholds::shipped();
    let all = [Rows::Exact, Rows::Scene].map(|rows| lines(rows, thresholds));
    let tables = all.iter().flatten().map(|lines| table(lines));
    tables.collect()
}

fn table(lines: &[Line<'_>]) -> String {
    let longest = lines.iter().map(|line| line.id.len() + 1).max();
    let width = longest.unwrap_or_default().max(16);
    let head = pad_end("measure", width);
    let mut text = format!("{head}{:<6}{:<6}{}\n", "unit", "bad", "what it is");
    for line in lines {
        text.push_str(&format!(
            "{}{:<6}{:<6}{}; {}\n",
            pad_end(line.id, width),
            line.unit,
            direction(line.danger),
            line.name,
            line.source
        ));
        for threshold in &line.thresholds {
            text.push_str(&format!(
                "{}{} ({})\n",
                " ".repeat(width + 12),
                line.at(threshold),
                threshold.source
            ));
        }
    }
    text
}

fn csv(lines: &[Line<'_>]) -> Outcome {
    let head = ["id", "name", "unit", "dangerous", "thresholds", "source"].map(String::from);
    let rows = lines.iter().map(|line| {
        let (direction, thresholds) = (direction(line.danger).into(), line.thresholds());
        let [id, name, unit, source] =
            [line.id, line.name, line.unit, line.source].map(String::from);
        [id, name, unit, direction, thresholds, source]
    });
    output::csv(std::iter::once(head).chain(rows))
}
