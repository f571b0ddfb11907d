//! Phrases that state a number without one: no motion along an axis, a gap that never closes, a length from the ego.

use std::ops::Range;

use super::{ClaimedValue, Quantity};

/// A velocity of 0, as phrases state it.
pub const NOTHING: ClaimedValue = ClaimedValue::Number {
    value: 0.0,
    decimals: 1,
    rough: false,
    magnitude: true,
};

/// A time that never comes.
const NEVER: ClaimedValue = ClaimedValue::Number {
    value: f64::INFINITY,
    decimals: 0,
    rough: false,
    magnitude: true,
};

/// What phrases state of the axes, each where it stands in a sentence in lower case: "no lateral velocity", "infinite
/// longitudinal TTC".
pub fn stated(lower: &str) -> Vec<(Range<usize>, Quantity, ClaimedValue)> {
    const AXES: [(&str, &str, [Quantity; 3]); 2] = [
        (
            "longitudinal",
            "ttclong",
            [Quantity::VelocityLong, Quantity::GapLong, Quantity::TtcLong],
        ),
        (
            "lateral",
            "ttclat",
            [Quantity::VelocityLat, Quantity::GapLat, Quantity::TtcLat],
        ),
    ];
    let mut found = Vec::new();
    let mut add = |words: &str, quantity, value| {
        if let Some(at) = lower.find(words) {
            found.push((at..at + words.len(), quantity, value));
        }
    };
    add("no relative velocity", Quantity::VelocityLong, NOTHING);
    for (_, _, [_, gap, _]) in AXES {
        add("exact alignment in both", gap, NOTHING);
    }
    if !lower.contains("longitudinal") && !lower.contains("lat") && !lower.contains("infinite") {
        return found;
    }
    for (axis, name, [velocity, gap, ttc]) in AXES {
        for noun in ["velocity", "motion", "movement", "relative motion"] {
            add(&format!("no {axis} {noun}"), velocity, NOTHING);
            add(&format!("no relative {axis} {noun}"), velocity, NOTHING);
        }
        for number in ["zero", "0", "no"] {
            for noun in ["longitudinal and lateral", "lateral and longitudinal"] {
                add(&format!("{number} {noun} distance"), gap, NOTHING);
            }
        }
        add(&format!("zero {axis} velocity"), velocity, NOTHING);
        add(&format!("{axis} velocity is zero"), velocity, NOTHING);
        for noun in ["distance", "separation", "offset", "gap"] {
            add(&format!("no {axis} {noun}"), gap, NOTHING);
        }
        add(&format!("zero {axis} distance"), gap, NOTHING);
        add(&format!("{axis} distance is zero"), gap, NOTHING);
        add(&format!("zero {axis} offset"), gap, NOTHING);
        for word in ["exact", "perfect", "direct"] {
            add(&format!("{word} {axis} alignment"), gap, NOTHING);
        }
        add(&format!("{axis} distance = 0)"), gap, NOTHING);
        add(&format!("infinite {axis} ttc"), ttc, NEVER);
        add(&format!("{axis} ttc is infinite"), ttc, NEVER);
        add(&format!("{name} is infinite"), ttc, NEVER);
        add(&format!("zero {axis} ttc"), ttc, NOTHING);
        add("infinite ttc in both", ttc, NEVER);
    }
    found
}

/// The velocity of 0 that a standstill comments on, of the words before it: "longitudinal velocity: 0.0 m/s (stationary)".
/// Nothing where both axes, another number or other words come before: a body that stands has a velocity relative to the
/// ego.
pub fn axis_before(before: &str) -> Option<Quantity> {
    let own = before.rsplit([';', '\n']).next().unwrap_or(before);
    let ends = ["velocity", "speed", "movement", "motion"];
    let at = |axis: &str| {
        let words = ends.map(|noun| format!("{axis} {noun}"));
        words
            .iter()
            .filter_map(|words| Some(own.rfind(words.as_str())? + words.len()))
            .max()
    };
    let (quantity, end) = match (at("longitudinal"), at("lateral")) {
        (Some(end), None) => (Quantity::VelocityLong, end),
        (None, Some(end)) => (Quantity::VelocityLat, end),
        _ => return None,
    };
    let between = own[end..].replace("m/s", "");
    let words = between.split(|c: char| !(c.is_alphanumeric() || c == '.'));
    let mut words = words.filter(|word| !word.is_empty()).peekable();
    let is_nothing = |word: &str| word.parse() == Ok(0.0_f64);
    let is_zero = words.peek().is_none()
        || words
            .all(|word| is_nothing(word) || ["of", "is", "and", "hence", "i.e."].contains(&word));
    is_zero.then_some(quantity)
}

/// Whether what follows a length makes it the distance from the ego: "away", "from the ego". "3 m away from the kerb" and
/// "3 m from the front" are other lengths.
pub fn away_from_the_ego(after: &str) -> bool {
    let rest = after.strip_prefix("away").map(str::trim_start);
    let of = rest.unwrap_or(after);
    match of.strip_prefix("from ") {
        Some(of) => {
            let of = of.strip_prefix("the ").unwrap_or(of);
            of.strip_prefix("ego")
                .is_some_and(|more| !more.starts_with(['\'', '’']))
        }
        None => rest.is_some_and(|more| !more.starts_with(char::is_alphabetic) || is_end(more)),
    }
}

/// Whether the words after "away" say when or what else, and not from what.
fn is_end(more: &str) -> bool {
    [
        "at ", "and ", "with ", "but ", "in the ", "on the ", "while ", "in total", "now", "so ",
        "yet ",
    ]
    .iter()
    .any(|word| more.starts_with(word))
}
