//! Numbers with comparison, unit and measure: `TTC under 1.5 s`, `within a metre and a half`, `between 1 and 2 s`.

use super::items::{Item, What};
use super::lexicon::{Bound, Meaning, Unit};
use nearmiss_scene::metrics::{Danger, measure};

/// A measure or another number, and the unit of its values.
pub type Named = (&'static str, Unit);

/// What was said before a quantity: measures that one without a measure may be of.
#[derive(Debug, Clone, Copy, Default)]
pub struct Before {
    /// The measure of the quantity right before it.
    pub joined: Option<Named>,
    /// The last measure without a number.
    pub waiting: Option<Named>,
}

/// A quantity that was read.
#[derive(Debug)]
pub struct Quantity {
    /// The terms; nothing where the filter language has none for it.
    pub terms: Option<Vec<String>>,
    /// Items that belong to it.
    pub length: usize,
    /// The measure that it is of.
    pub named: Option<Named>,
}

const RISK: Named = ("risk", Unit::None);

/// Numbers of which few are many: a window can have exactly this one.
const SCORES: [&str; 2] = [RISK.0, "severity"];

/// Reads a quantity that begins at the first item: with its measures, its comparison, `between`, or its number.
/// Nothing if none begins there.
pub fn read(items: &[Item], before: Before) -> Option<Quantity> {
    let mut at = 0;
    let mut extreme = None;
    if let Some(bound) = bound(items, 0)
        && named(items, 1).is_some()
    {
        (extreme, at) = (Some(bound), 1);
    }
    let (mut measures, mut alternatives) = (Vec::new(), false);
    if let Some(first) = named(items, at) {
        measures.push(first);
        at += 1;
        while let (true, Some(next)) = (joins(items, at), named(items, at + 1)) {
            alternatives |= is(items, at, Meaning::Or);
            measures.push(next);
            at += 2;
        }
    }
    let mut foreign = measures.is_empty() && is(items, at, Meaning::Foreign);
    at += usize::from(foreign);
    let compare = compared(items, &mut at);
    let between = matches!(compare, Some(How::Between));
    let value = number(items, &mut at, matches!(compare, Some(How::Sign(..))))?;
    let (value, end) = range(items, &mut at, value, between, compare.is_none())?;
    let mut beyond = beyond(items, &mut at);
    if measures.first().is_some_and(|(id, _)| *id == "obstacles")
        && (value.unit.is_some() || named(items, at).is_some())
    {
        // `vehicles closer than 5 m`: how many is not said.
        measures.clear();
    }
    if measures.is_empty()
        && let Some(behind) = behind(items, at, &value)
    {
        if foreign {
            return None;
        }
        measures.push(behind);
        at += 1;
    } else if measures.is_empty() && is(items, at, Meaning::Foreign) && !pauses(items, at) {
        foreign = true;
        at += 1;
    }
    let implied = match compare {
        Some(How::Sign(_, implied)) => implied,
        _ => None,
    };
    if measures.is_empty() && !foreign {
        let counts = value.unit.is_none() && counts_next(items, at);
        let fits = |named: &Named| !counts && of(Some(*named), None, value.unit).is_some();
        let same = |(_, unit): &Named| value.unit.is_none_or(|said| said == *unit);
        let joined = before.joined.filter(fits).filter(same);
        measures.extend(joined.or(before.waiting.filter(fits)));
    }
    beyond = beyond.or(self::beyond(items, &mut at));
    let ids: Option<Vec<&'static str>> = match &measures[..] {
        [] => of(None, implied, value.unit).map(|id| vec![id]),
        all => all
            .iter()
            .map(|one| of(Some(*one), None, value.unit))
            .collect(),
    };
    let ids = ids
        .filter(|_| !foreign && !alternatives)
        .unwrap_or_default();
    let of_id = |id: &'static str| terms(id, &value, end.as_ref(), compare, beyond, extreme);
    let terms: Option<Vec<Vec<String>>> = ids.iter().map(|id| of_id(id)).collect();
    let terms = terms
        .map(|terms| terms.concat())
        .filter(|terms| !terms.is_empty());
    let usual = ids.last().and_then(|id| usual(id));
    Some(Quantity {
        terms,
        length: at,
        named: measures.last().copied().or(usual),
    })
}

/// The measure that a quantity without one was taken to be of.
fn usual(id: &'static str) -> Option<Named> {
    let unit = match id {
        "ttc" | "time_gap" | "duration" => Unit::Seconds,
        "distance" => Unit::Metres,
        "drac" => Unit::Acceleration,
        _ => return None,
    };
    Some((id, unit))
}

/// How a number compares.
#[derive(Debug, Clone, Copy)]
enum How {
    /// A sign, and the measure that is meant where none is named.
    Sign(&'static str, Option<&'static str>),
    /// More dangerous.
    Worse,
    /// In a range.
    Between,
}

/// What stands behind a number.
#[derive(Debug, Clone, Copy)]
enum Beyond {
    More,
    Less,
    Worse,
}

fn terms(
    id: &'static str,
    value: &Value,
    end: Option<&Value>,
    compare: Option<How>,
    beyond: Option<Beyond>,
    extreme: Option<Bound>,
) -> Option<Vec<String>> {
    let danger = measure(id).map(|measure| measure.danger);
    let low = danger == Some(Danger::Low) || SCORES.contains(&id);
    // An index has the most dangerous value of a window, not the other extreme.
    let kept = match (extreme, danger) {
        (Some(Bound::Least), Some(_)) => low,
        (Some(Bound::Most), Some(_)) => danger == Some(Danger::High),
        _ => true,
    };
    let first = shown(value.value);
    if let (Some(end), true) = (end, kept) {
        return Some(vec![
            format!("{id}>={first}"),
            format!("{id}<={}", shown(end.value)),
        ]);
    }
    let sign = match (compare, beyond) {
        (Some(How::Sign(sign, _)), None) => sign,
        (Some(How::Worse), None) if low => "<",
        (Some(How::Worse), None) => ">",
        (None, Some(Beyond::More)) => ">=",
        (None, Some(Beyond::Less)) => "<=",
        (None, Some(Beyond::Worse)) if low => "<=",
        (None, Some(Beyond::Worse)) => ">=",
        (None, None) => match extreme {
            Some(Bound::Least) => ">=",
            Some(Bound::Most) => "<=",
            // Scores may be equal to a number; a time never is.
            _ if SCORES.contains(&id) => "=",
            _ => return None,
        },
        _ => return None,
    };
    // `maximum distance 5 m` is a limit, `maximum distance under 5 m` another value than that of the index.
    let limits = compare.is_none() && beyond.is_none();
    (kept || limits).then(|| vec![format!("{id}{sign}{first}")])
}

fn compared(items: &[Item], at: &mut usize) -> Option<How> {
    let how = match what(items, *at)? {
        What::Means(Meaning::Between) => How::Between,
        What::Means(Meaning::Compare(sign, implied)) => How::Sign(sign, *implied),
        What::Means(Meaning::Worse) => How::Worse,
        What::Means(Meaning::Extreme(Bound::Least)) => How::Sign(">=", None),
        What::Means(Meaning::Extreme(Bound::Most)) => How::Sign("<=", None),
        _ => return None,
    };
    *at += 1;
    Some(how)
}

fn beyond(items: &[Item], at: &mut usize) -> Option<Beyond> {
    let beyond = match what(items, *at)? {
        What::Means(Meaning::OrMore) => Beyond::More,
        What::Means(Meaning::OrLess) => Beyond::Less,
        What::Means(Meaning::OrWorse) => Beyond::Worse,
        _ => return None,
    };
    *at += 1;
    Some(beyond)
}

/// The measure behind a number, unless a number of its own follows it.
fn behind(items: &[Item], at: usize, value: &Value) -> Option<Named> {
    let (id, unit) = named(items, at)?;
    let own = begins_number(items, at + 1);
    let fits = of(Some((id, unit)), None, value.unit).is_some();
    let its = value.unit.is_some() && !pauses(items, at) || unit == Unit::None || !own;
    (fits && its).then_some((id, unit))
}

/// A number in base units.
struct Value {
    value: f64,
    unit: Option<Unit>,
    factor: f64,
}

/// The value and the end of its range: `between 1 and 2 s`, `1-2 s`.
fn range(
    items: &[Item],
    at: &mut usize,
    mut value: Value,
    between: bool,
    alone: bool,
) -> Option<(Value, Option<Value>)> {
    let mut next = *at;
    if between {
        next += usize::from(is(items, next, Meaning::And));
    } else if !alone || pauses(items, next) || !matches!(what(items, next), Some(What::Number(_))) {
        return Some((value, None));
    }
    let Some(end) = number(items, &mut next, false) else {
        return (!between).then_some((value, None));
    };
    *at = next;
    // `between 1 and 2 s`: the unit is that of both.
    if value.unit.is_none() {
        value.value *= end.factor;
        value.unit = end.unit;
    }
    Some((value, Some(end)))
}

/// A number and its unit; a unit alone is one of it where `alone`.
fn number(items: &[Item], at: &mut usize, alone: bool) -> Option<Value> {
    let mut value = match what(items, *at)? {
        What::Number(number) => {
            *at += 1;
            *number
        }
        What::Means(Meaning::Unit(..)) if alone => 1.0,
        _ => return None,
    };
    let half = |at: &mut usize| {
        let is_half = is(items, *at, Meaning::And)
            && matches!(what(items, *at + 1), Some(What::Number(n)) if *n == 0.5);
        *at += if is_half { 2 } else { 0 };
        is_half
    };
    if half(at) {
        value += 0.5;
    }
    let (mut unit, mut factor) = (None, 1.0);
    if let Some(What::Means(Meaning::Unit(base, of_base))) = what(items, *at) {
        (unit, factor) = (Some(*base), *of_base);
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
fn of(
    named: Option<Named>,
    implied: Option<&'static str>,
    unit: Option<Unit>,
) -> Option<&'static str> {
    match (named, unit) {
        // A gap in seconds, a headway in metres.
        (Some(("distance", _)), Some(Unit::Seconds)) => Some("time_gap"),
        (Some(("thw", _)), Some(Unit::Metres)) => Some("headway"),
        (Some((id, of_measure)), Some(unit)) => (of_measure == unit).then_some(id),
        (Some((id, _)), None) => Some(id),
        (None, unit) => match (implied, unit?) {
            (Some("duration"), Unit::Seconds) => Some("duration"),
            (_, Unit::Seconds) => Some("ttc"),
            (_, Unit::Metres) => Some("distance"),
            (_, Unit::Acceleration) => Some("drac"),
            (_, Unit::Speed | Unit::Other | Unit::None) => None,
        },
    }
}

/// Whether a number without unit counts what is next: `more than 3 pedestrians`.
fn counts_next(items: &[Item], at: usize) -> bool {
    let counted = matches!(
        what(items, at),
        Some(What::Means(Meaning::Term("actor", _) | Meaning::Terms(_)) | What::Unknown)
    );
    counted && !pauses(items, at)
}

fn bound(items: &[Item], at: usize) -> Option<Bound> {
    match what(items, at)? {
        What::Means(Meaning::Extreme(bound)) => Some(*bound),
        _ => None,
    }
}

fn named(items: &[Item], at: usize) -> Option<Named> {
    match what(items, at)? {
        What::Means(Meaning::Measure(id, unit)) => Some((id, *unit)),
        What::Means(Meaning::Risk) => Some(RISK),
        _ => None,
    }
}

fn begins_number(items: &[Item], at: usize) -> bool {
    matches!(
        what(items, at),
        Some(What::Number(_) | What::Means(Meaning::Compare(..) | Meaning::Between))
    )
}

fn joins(items: &[Item], at: usize) -> bool {
    is(items, at, Meaning::And) || is(items, at, Meaning::Or)
}

fn pauses(items: &[Item], at: usize) -> bool {
    items.get(at).is_some_and(|item| item.pause)
}

fn what(items: &[Item], at: usize) -> Option<&What> {
    items.get(at).map(|item| &item.what)
}

fn is(items: &[Item], at: usize, meaning: Meaning) -> bool {
    what(items, at) == Some(&What::Means(meaning))
}

/// A number without digits that come from arithmetic.
fn shown(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    format!("{rounded}")
}
