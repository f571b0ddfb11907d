//! `nearmiss metrics --list`: every measure with its unit, meaning and danger threshold.

use serde_json::{Value, json};

use super::{Format, Metrics, Rows, measured};
use crate::cli::{Failure, Outcome, json, output};
use crate::metrics::{Danger, MEASURES, SCENE_MEASURES, Threshold, Thresholds};

/// One measure.
struct Line<'a> {
    id: &'static str,
    name: &'static str,
    unit: &'static str,
    danger: Danger,
    source: &'static str,
    thresholds: Vec<&'a Threshold>,
}

/// Prints the list.
pub(super) fn run(arguments: &Metrics, format: Option<Format>) -> Outcome {
    let (rows, thresholds) = measured(arguments)?;
    let lines = lines(rows, &thresholds)?;
    match format {
        None => output::text(&output::visible(&table(&lines))),
        Some(Format::Csv) => csv(&lines),
        Some(Format::Json) => lines
            .iter()
            .map(Line::json)
            .try_for_each(|l| output::json(&l)),
        Some(Format::Parquet) => Err(Failure::input("--list is written as csv or json")),
    }
}

fn lines(rows: Rows, thresholds: &Thresholds) -> Result<Vec<Line<'_>>, Failure> {
    Ok(match rows {
        Rows::Exact => MEASURES
            .iter()
            .map(|m| Line {
                id: m.id,
                name: m.name,
                unit: m.unit,
                danger: m.danger,
                source: m.source,
                thresholds: thresholds.for_measure(m.id).collect(),
            })
            .collect(),
        Rows::Scene => SCENE_MEASURES
            .iter()
            .map(|m| Line {
                id: m.id,
                name: m.name,
                unit: m.unit,
                danger: m.danger,
                source: m.source,
                thresholds: thresholds.for_measure(m.id).collect(),
            })
            .collect(),
        Rows::Paper => {
            return Err(Failure::input(
                "--list does not go with --convention paper, whose columns are those of the published tables; leave \
                 one out",
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

    fn json(&self) -> Value {
        let thresholds = self.thresholds.iter().map(|t| {
            json!({
                "name": t.name,
                "value": t.value,
                "strict": t.strict,
                "source": t.source,
            })
        });
        let mut value = json!({
            "measure": self.id,
            "name": self.name,
            "unit": self.unit,
            "dangerous": direction(self.danger),
            "thresholds": thresholds.collect::<Vec<_>>(),
            "source": self.source,
        });
        json::with_old_names(&mut value, &[("id", "measure")]);
        value
    }
}

fn table(lines: &[Line<'_>]) -> String {
    let mut text = format!(
        "{:<16}{:<6}{:<6}{}\n",
        "measure", "unit", "bad", "what it is"
    );
    for line in lines {
        text.push_str(&format!(
            "{:<16}{:<6}{:<6}{}; {}\n",
            line.id,
            line.unit,
            direction(line.danger),
            line.name,
            line.source
        ));
        for threshold in &line.thresholds {
            text.push_str(&format!(
                "{:<28}{} ({})\n",
                "",
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
