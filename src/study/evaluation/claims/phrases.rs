//! Phrases that claim something without a number: a standstill, no motion along an axis, a contact now.

use std::ops::Range;

use super::number::without_reference;
use super::place::{has_word, is_contracted};
use super::{ClaimedValue, Quantity};

/// A velocity of 0, as phrases state it.
pub const NOTHING: ClaimedValue = ClaimedValue::Number {
    value: 0.0,
    decimals: 1,
    rough: false,
    magnitude: true,
};

/// Words for a standstill.
const STILL: &[&str] = &[
    "stationary",
    "static",
    "standing still",
    "stands still",
    "stopped moving",
    "zero velocity",
    "no motion",
];

/// Words that weaken or move a phrase in time.
const DOUBTFUL: &[&str] = &[
    "not",
    "never",
    "if",
    "would",
    "could",
    "might",
    "may",
    "should",
    "was",
    "were",
    "will",
    "until",
    "initially",
    "previously",
    "becomes",
    "became",
    "appears",
    "assuming",
    "likely",
    "or",
    "either",
];

/// Where a sentence in lower case says that its obstacle does not move, or not along an axis.
pub fn find_standstill(lower: &str) -> Vec<(Range<usize>, Quantity)> {
    let mut found = Vec::new();
    for (from, clause) in clauses(lower) {
        if is_contracted(clause) || DOUBTFUL.iter().any(|word| has_word(clause, word)) {
            continue;
        }
        let phrase = STILL.iter().find_map(|word| {
            let at = clause.find(word)?;
            let (before, after) = (&clause[..at], &clause[at + word.len()..]);
            let whole = !before.ends_with(char::is_alphanumeric)
                && !after.starts_with(char::is_alphanumeric);
            let after = after.trim_start_matches([' ', '*']);
            // A field: "stationary: no".
            if after.starts_with(':') {
                return None;
            }
            let weakened = ["nearly", "almost", "relatively", "quasi"]
                .iter()
                .any(|word| before.trim_end().ends_with(word));
            let other = weakened
                || has_word(&without_reference(before), "ego")
                || has_word(before, "no")
                || ["ego", "longitud", "lateral", "relative", "toward"]
                    .iter()
                    .any(|word| after.starts_with(word));
            (whole && !other).then(|| from + at..from + at + word.len())
        });
        found.extend(phrase.map(|span| {
            let quantity = axis_before(&lower[..span.start]).unwrap_or(Quantity::Speed);
            (span, quantity)
        }));
        let placed = |words: &str| {
            let at = from + clause.find(words)?;
            Some(at..at + words.len())
        };
        let both = placed("no relative velocity");
        found.extend(both.map(|span| (span, Quantity::VelocityLong)));
        for (axis, velocity, gap) in [
            ("longitudinal", Quantity::VelocityLong, Quantity::GapLong),
            ("lateral", Quantity::VelocityLat, Quantity::GapLat),
        ] {
            let moves = [
                format!("no {axis} velocity"),
                format!("no {axis} motion"),
                format!("no {axis} movement"),
                format!("no {axis} relative motion"),
                format!("zero {axis} velocity"),
                format!("{axis} velocity is zero"),
            ];
            let phrase = moves.iter().find_map(|words| placed(words));
            found.extend(phrase.map(|span| (span, velocity)));
            let lies = [
                format!("no {axis} distance"),
                format!("zero {axis} distance"),
                format!("{axis} distance is zero"),
                format!("{axis} distance = 0)"),
            ];
            let phrase = lies.iter().find_map(|words| placed(words));
            found.extend(phrase.map(|span| (span, gap)));
        }
    }
    found
}

/// The velocity of 0 that a standstill comments on, of the words before it: "longitudinal velocity: 0.0 m/s (stationary)".
/// Nothing where both axes, another number or other words come before: a body that stands has a velocity relative to the
/// ego.
fn axis_before(before: &str) -> Option<Quantity> {
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

/// Where a sentence in lower case says that a gap never closes, or takes no time to: "infinite lateral TTC".
pub fn times(lower: &str) -> Vec<(Range<usize>, Quantity, ClaimedValue)> {
    let never = ClaimedValue::Number {
        value: f64::INFINITY,
        decimals: 0,
        rough: false,
        magnitude: true,
    };
    let mut found = Vec::new();
    for (from, clause) in clauses(lower) {
        if DOUBTFUL.iter().any(|word| has_word(clause, word)) {
            continue;
        }
        let mut add = |words: &str, quantity, value| {
            if let Some(at) = clause.find(words) {
                let at = from + at;
                found.push((at..at + words.len(), quantity, value));
            }
        };
        let axes = [
            ("longitudinal", "ttclong", Quantity::TtcLong),
            ("lateral", "ttclat", Quantity::TtcLat),
        ];
        for (axis, name, quantity) in axes {
            add(&format!("infinite {axis} ttc"), quantity, never);
            add(&format!("{axis} ttc is infinite"), quantity, never);
            add(&format!("{name} is infinite"), quantity, never);
            add(&format!("zero {axis} ttc"), quantity, NOTHING);
            add("infinite ttc in both", quantity, never);
        }
    }
    found
}

/// Phrases for a contact at the present.
const TOUCHES: &[&str] = &[
    "has collided with the ego",
    "is colliding with the ego",
    "currently colliding with the ego",
    "in a collision with the ego",
    "in collision with the ego",
    "in direct collision with the ego",
    "indicating a collision with the ego",
];

/// Words with which a contact is only feared.
const FEARED: &[&str] = &[
    "no",
    "not",
    "if",
    "would",
    "could",
    "might",
    "may",
    "potential",
    "potentially",
    "risk of",
    "likely",
    "imminent",
    "possible",
    "avoid",
    "will",
    "or",
    "nearly",
    "almost",
    "predicted",
];

/// Where a sentence in lower case says that its obstacle touches the ego now.
pub fn touches_now(lower: &str) -> Option<Range<usize>> {
    if FEARED.iter().any(|word| has_word(lower, word)) {
        return None;
    }
    let said = TOUCHES.iter().find_map(|words| {
        let at = lower.find(words)?;
        Some(at..at + words.len())
    });
    said.or_else(|| {
        // A field: "location: collision".
        let at = ["position", "location", "direction"]
            .iter()
            .find_map(|field| Some(lower.find(field)? + field.len()))?;
        let rest = lower[at..].trim_start_matches([':', '*', ' ', '"', '`']);
        let start = lower.len() - rest.len();
        let after = rest.strip_prefix("collision")?;
        let ends = after.trim_matches(['*', ' ', '"', '`', '.']).is_empty();
        (ends && start > at).then(|| start..start + "collision".len())
    })
}

/// The clauses of a sentence with the places where they begin.
pub fn clauses(lower: &str) -> Vec<(usize, &str)> {
    const JOINTS: &[&str] = &[
        " but ",
        " while ",
        " although ",
        " with ",
        " and moving",
        " and driving",
        " and approaching",
        " and poses",
    ];
    let mut starts: Vec<usize> = vec![0];
    starts.extend(
        lower
            .match_indices([',', ';', '(', ')'])
            .map(|(at, mark)| at + mark.len()),
    );
    for joint in JOINTS {
        starts.extend(lower.match_indices(joint).map(|(at, _)| at));
    }
    starts.sort_unstable();
    starts.dedup();
    let ends = starts.iter().skip(1).copied().chain([lower.len()]);
    starts
        .iter()
        .copied()
        .zip(ends)
        .map(|(from, to)| (from, &lower[from..to]))
        .collect()
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
        "at ", "and ", "with ", "but ", "in the ", "on the ", "while ",
    ]
    .iter()
    .any(|word| more.starts_with(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standstill_is_said_of_the_obstacle_and_now() {
        for said in [
            "obstacle 7 is stationary in the same lane",
            "static obstacle at (1, 2), safe",
            "- **reason**: zero velocity.",
        ] {
            let found = find_standstill(said);
            assert_eq!(found.len(), 1, "{said}: {found:?}");
            assert_eq!(found[0].1, Quantity::Speed);
        }
        for unsaid in [
            "it is not stationary",
            "if it is stationary, the ego brakes",
            "the ego is stationary",
            "it was stationary before",
            "zero velocity laterally",
            "quasistatic",
        ] {
            assert_eq!(find_standstill(unsaid), [], "{unsaid}");
        }
        for (said, quantity) in [
            (
                "longitudinal velocity: 0.0 m/s (stationary)",
                Quantity::VelocityLong,
            ),
            ("lateral speed is 0, static", Quantity::VelocityLat),
            (
                "longitudinal velocity 0, lateral velocity 0 (stationary)",
                Quantity::Speed,
            ),
            (
                "its longitudinal velocity is 0, so the cyclist is stationary",
                Quantity::Speed,
            ),
            (
                "longitudinal velocity: -8.3 m/s (stationary)",
                Quantity::Speed,
            ),
            (
                "longitudinal velocity of 0 m/s, 30309 is stationary",
                Quantity::Speed,
            ),
        ] {
            let found = find_standstill(said);
            assert_eq!(found.len(), 1, "{said}: {found:?}");
            assert_eq!(found[0].1, quantity, "{said}");
        }
        let axis = find_standstill("driving toward the ego, no lateral motion.");
        assert_eq!(axis, [(24..41, Quantity::VelocityLat)]);
    }

    #[test]
    fn a_contact_now_is_told_from_a_feared_one() {
        for said in [
            "obstacle 7 has collided with the ego vehicle.",
            "- **location:** collision",
            "it is currently colliding with the ego",
        ] {
            assert!(touches_now(said).is_some(), "{said}");
        }
        for unsaid in [
            "no obstacle has collided with the ego",
            "it may have collided with the ego; it has collided with the ego if",
            "risk of colliding with the ego",
            "location: collision course",
        ] {
            assert_eq!(touches_now(unsaid), None, "{unsaid}");
        }
    }
}
