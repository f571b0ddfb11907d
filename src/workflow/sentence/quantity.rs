//! Numbers with comparison, unit and measure: `TTC under 1.5 s`, `within a metre and a half`, `between 1 and 2 s`.

use super::lexicon::{Meaning, Unit};
use super::reading::{Item, What};

/// A number that was read: terms, or nothing where it makes no sense, and how many items it took.
pub struct Quantity {
    /// The terms.
    pub terms: Vec<String>,
    /// Items that belong to it.
    pub length: usize,
}

/// Reads a quantity that begins at the first item: with its measure, its comparison, `between`, or its number.
/// Nothing if none begins there. Without terms its words are not understood.
pub fn read(items: &[Item]) -> Option<Quantity> {
    let mut at = 0;
    let mut measure = match items.first()?.what {
        What::Means(Meaning::Measure(id, unit)) => Some((id, unit)),
        What::Means(Meaning::Risk) => Some(("severity", Unit::None)),
        _ => None,
    };
    at += usize::from(measure.is_some());
    let between = is(items, at, Meaning::Between);
    let mut compare = None;
    if between {
        at += 1;
    } else if let Some(What::Means(Meaning::Compare(sign, implied))) = what(items, at) {
        compare = Some((sign, implied));
        at += 1;
    }
    let first = number(items, &mut at, compare.is_some());
    let mut value = first?;
    let mut second = None;
    if between {
        if !is(items, at, Meaning::And) {
            return None;
        }
        at += 1;
        let more = number(items, &mut at, false)?;
        // `between 1 and 2 s`: the unit is that of both.
        if value.unit.is_none() {
            value.value *= more.factor;
            value.unit = more.unit;
        }
        second = Some(more);
    }
    let beyond = match what(items, at) {
        Some(What::Means(Meaning::OrMore)) => Some(">="),
        Some(What::Means(Meaning::OrLess)) => Some("<="),
        // A worse score is a lower one.
        Some(What::Means(Meaning::OrWorse)) => Some("<="),
        _ => None,
    };
    at += usize::from(beyond.is_some());
    if measure.is_none()
        && let Some(What::Means(Meaning::Measure(id, unit))) = what(items, at)
        // One with a number of its own is not this one's.
        && (value.unit.is_some() || unit == Unit::None || !begins_number(items, at + 1))
    {
        measure = Some((id, unit));
        at += 1;
    }
    let sign = match (compare, beyond) {
        (Some((sign, _)), None) => Some(sign),
        (None, Some(sign)) => Some(sign),
        (None, None) => None,
        (Some(_), Some(_)) => {
            return Some(Quantity {
                terms: Vec::new(),
                length: at,
            });
        }
    };
    let implied = compare.and_then(|(_, implied)| implied);
    let id = measured(measure, implied, value.unit);
    let terms = id.map_or_else(Vec::new, |id| match (second, sign) {
        (Some(end), _) => vec![
            format!("{id}>={}", shown(value.value)),
            format!("{id}<={}", shown(end.value)),
        ],
        (None, Some(sign)) => vec![format!("{id}{sign}{}", shown(value.value))],
        // Scores and counts may be equal to a number; a time never is.
        (None, None) if id == "severity" => vec![format!("severity={}", shown(value.value))],
        (None, None) => Vec::new(),
    });
    Some(Quantity { terms, length: at })
}

/// A number in base units.
struct Value {
    value: f64,
    unit: Option<Unit>,
    factor: f64,
}

/// A number and its unit; a unit alone is one of it where `alone`.
fn number(items: &[Item], at: &mut usize, alone: bool) -> Option<Value> {
    let mut value = match what(items, *at)? {
        What::Number(number) => {
            *at += 1;
            number
        }
        What::Means(Meaning::Unit(..)) if alone => 1.0,
        _ => return None,
    };
    let half = |at: &mut usize| {
        let is_half = is(items, *at, Meaning::And)
            && matches!(what(items, *at + 1), Some(What::Number(n)) if n == 0.5);
        *at += if is_half { 2 } else { 0 };
        is_half
    };
    if half(at) {
        value += 0.5;
    }
    let (mut unit, mut factor) = (None, 1.0);
    if let Some(What::Means(Meaning::Unit(base, of_base))) = what(items, *at) {
        (unit, factor) = (Some(base), of_base);
        *at += 1;
        if half(at) {
            value += 0.5;
        }
    }
    Some(Value {
        value: value * factor,
        unit,
        factor,
    })
}

/// The measure that is meant: the one that is named, else the one that the comparison implies, else the usual one of
/// the unit; nothing where the unit is of something else.
fn measured(
    named: Option<(&'static str, Unit)>,
    implied: Option<&'static str>,
    unit: Option<Unit>,
) -> Option<&'static str> {
    match (named, unit) {
        // A gap in seconds.
        (Some(("distance", _)), Some(Unit::Seconds)) => Some("time_gap"),
        (Some((id, of_measure)), Some(unit)) => (of_measure == unit).then_some(id),
        (Some((id, _)), None) => Some(id),
        (None, unit) => match (implied, unit?) {
            (Some("duration"), Unit::Seconds) => Some("duration"),
            (_, Unit::Seconds) => Some("ttc"),
            (_, Unit::Metres) => Some("distance"),
            (_, Unit::Acceleration) => Some("drac"),
            (_, Unit::None) => None,
        },
    }
}

fn begins_number(items: &[Item], at: usize) -> bool {
    matches!(
        what(items, at),
        Some(What::Number(_) | What::Means(Meaning::Compare(..) | Meaning::Between))
    )
}

fn what(items: &[Item], at: usize) -> Option<What> {
    items.get(at).map(|item| item.what.clone())
}

fn is(items: &[Item], at: usize, meaning: Meaning) -> bool {
    what(items, at) == Some(What::Means(meaning))
}

/// A number without digits that come from arithmetic.
fn shown(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    format!("{rounded}")
}
