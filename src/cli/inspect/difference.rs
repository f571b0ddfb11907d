//! `nearmiss inspect A B --diff`: what differs between two scenarios, and the moment that matters of each.

use nearmiss_scene::scenario::{Changed, Differences, ElementDifferences, FieldDifference};
use nearmiss_workflow::ScenarioRow;
use schemars::JsonSchema;
use serde::Serialize;

use super::{Inspect, Looked, look, moment_words};
use crate::output::PageFormat;
use crate::{Failure, Outcome, output};

/// What differs between two scenarios.
#[derive(Serialize, JsonSchema)]
pub struct DifferenceDocument {
    /// Whether nothing differs: no element, and no number by 0.001 m, rad, m/s or m/s² or more.
    equal: bool,
    /// The first scenario: the row that it has among several, with the moment that matters.
    a: ScenarioRow,
    /// The second one.
    b: ScenarioRow,
    #[serde(flatten)]
    differences: Differences,
}

/// Compares the two scenarios; that they differ is a finding.
pub(super) fn run(arguments: &Inspect, format: PageFormat) -> Outcome {
    let [a, b] = arguments.files.as_slice() else {
        return Err(Failure::input(format!(
            "--diff compares two scenarios, not {}",
            arguments.files.len()
        )));
    };
    if matches!(
        format,
        PageFormat::Csv | PageFormat::Parquet | PageFormat::Arrow
    ) {
        return Err(Failure::input(
            "--diff is text or JSON: --format table or json",
        ));
    }
    let (a, b) = (look(a, arguments)?, look(b, arguments)?);
    for looked in [&a, &b] {
        if let Err(error) = &looked.ego {
            return Err(Failure::input(error));
        }
    }
    let differences = Differences::between((&a.scenario, a.ego()), (&b.scenario, b.ego()));
    let document = DifferenceDocument {
        equal: differences.is_empty(),
        a: a.row()?,
        b: b.row()?,
        differences,
    };
    let text = match format {
        PageFormat::Json => output::document_line(&document)?,
        _ => output::visible(&page(&a, &b, &document)),
    };
    arguments.output.begin()?.save(text.as_bytes())?;
    if document.equal {
        Ok(())
    } else {
        Err(Failure::finding("the scenarios differ"))
    }
}

/// The most elements of a kind that text has, and ids in a line.
const MOST: usize = 12;

fn page(a: &Looked, b: &Looked, document: &DifferenceDocument) -> String {
    let mut text = String::new();
    let mut line = |word: &str, said: &str| text.push_str(&format!("{word:<14} {said}\n"));
    for (side, looked) in [("A", a), ("B", b)] {
        let hash = &looked.scenario.hash;
        line(side, &format!("{} ({hash})", looked.entry.display()));
    }
    if document.equal {
        line("equal", "no element, and no number by more than 0.001");
    }
    for field in &document.differences.about {
        line(field.field, &words(field));
    }
    for of_kind in &document.differences.elements {
        elements(of_kind, &mut line);
    }
    let (first, second) = (moment(&document.a), moment(&document.b));
    if first == second {
        line("moment", &first);
    } else {
        line("moment A", &first);
        line("moment B", &second);
    }
    text
}

fn elements(of_kind: &ElementDifferences, line: &mut impl FnMut(&str, &str)) {
    let kind = of_kind.kind;
    for (side, only) in [("A", &of_kind.only_in_a), ("B", &of_kind.only_in_b)] {
        if !only.is_empty() {
            let ids: Vec<String> = only.iter().take(MOST).map(i64::to_string).collect();
            let more = match only.len().saturating_sub(MOST) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let count = output::counted(only.len(), kind);
            line(
                &format!("only in {side}"),
                &format!("{count}: {}{more}", ids.join(", ")),
            );
        }
    }
    for Changed { id, fields } in of_kind.changed.iter().take(MOST) {
        let said: Vec<String> = fields.iter().map(words_of_field).collect();
        line(&format!("{kind} {id}"), &said.join("; "));
    }
    if let more @ 1.. = of_kind.changed.len().saturating_sub(MOST) {
        let count = output::counted(more, kind);
        line(
            "",
            &format!("and {count} more that differ; --format json has all"),
        );
    }
}

fn words_of_field(field: &FieldDifference) -> String {
    format!("{} {}", field.field, words(field))
}

/// How a property differs: `1.250 m at step 32`, or what both say.
fn words(field: &FieldDifference) -> String {
    let at = field
        .step
        .map_or(String::new(), |step| format!(" at step {step}"));
    match (field.by, &field.a, &field.b) {
        (Some(by), ..) => {
            let number = format!("by {by:.3} {}", field.unit.unwrap_or_default());
            format!("{}{at}", number.trim_end())
        }
        (None, None, None) => format!("different{at}"),
        (None, a, b) => {
            let said = |words: &Option<String>| words.clone().unwrap_or_else(|| "none".into());
            format!("{} | {}", said(a), said(b))
        }
    }
}

/// The moment that matters with its figures.
fn moment(row: &ScenarioRow) -> String {
    let Some(mut said) = moment_words(row) else {
        return match row.ego {
            Some(_) => "none: no road user comes near the ego".into(),
            None => format!("none: {}", row.ego_source),
        };
    };
    for (name, value, unit) in [
        ("ttc", row.ttc, "s"),
        ("distance", row.distance, "m"),
        ("contact", row.contact_speed, "m/s"),
    ] {
        let figure = value.map(|value| format!("; {name} {value:.2} {unit}"));
        said.extend(figure);
    }
    said
}
