//! Phrases for an obstacle's position, and for contact with the ego.

use std::ops::Range;

use super::Side;
use super::phrases::clauses;

const fn side(front: Option<bool>, left: Option<bool>) -> Side {
    Side { front, left }
}

/// Both axes; plain enough wherever they stand.
const CORNERS: &[(&str, Side)] = &[
    ("front-left", side(Some(true), Some(true))),
    ("front left", side(Some(true), Some(true))),
    ("front-right", side(Some(true), Some(false))),
    ("front right", side(Some(true), Some(false))),
    ("rear-left", side(Some(false), Some(true))),
    ("rear left", side(Some(false), Some(true))),
    ("rear-right", side(Some(false), Some(false))),
    ("rear right", side(Some(false), Some(false))),
];

/// One axis; of the ego, or as the whole of a field "position".
const SIDES: &[(&str, Side)] = &[
    ("in front of ", side(Some(true), None)),
    ("ahead of ", side(Some(true), None)),
    ("behind ", side(Some(false), None)),
    ("trailing ", side(Some(false), None)),
    ("to the left of ", side(None, Some(true))),
    ("to the right of ", side(None, Some(false))),
];

const FIELDS: &[(&str, Side)] = &[
    ("front", side(Some(true), None)),
    ("ahead", side(Some(true), None)),
    ("behind", side(Some(false), None)),
    ("left", side(None, Some(true))),
    ("right", side(None, Some(false))),
];

/// Words that weaken a statement.
const DOUBTFUL: &[&str] = &[
    "not",
    "no",
    "never",
    "if",
    "would",
    "could",
    "might",
    "may",
    "lane",
    "turn",
    "turning",
    "moving",
    "toward",
    "towards",
    "was",
    "were",
    "crossing",
    "neither",
    "steer",
    "steers",
    "another",
    "will",
    "axis",
    "initially",
    "originally",
    "previously",
];

/// Where the obstacle of a sentence is said to be; the sentence is in lower case.
pub fn side_in(lower: &str) -> Option<(Range<usize>, Side)> {
    if ["if", "neither"].iter().any(|word| has_word(lower, word)) {
        return None;
    }
    let plain = |(_, clause): &(usize, &str)| {
        !denies(clause)
            && !clause.contains("used to")
            && !DOUBTFUL.iter().any(|word| has_word(clause, word))
            && ![": no", ": false"]
                .iter()
                .any(|words| clause.trim_end_matches(['*', ' ', '.']).ends_with(words))
    };
    let mut found = clauses(lower)
        .into_iter()
        .filter(plain)
        .filter_map(|(from, clause)| {
            let (span, side) = match find_side(clause) {
                Some(found) => found,
                None => in_brackets(&lower[..from], clause)?,
            };
            // "Approaching from behind" is no place.
            let before = clause[..span.start].trim_end();
            let before = before.strip_suffix("directly").unwrap_or(before).trim_end();
            let before = before.strip_suffix("the").unwrap_or(before).trim_end();
            let whole = from + span.start..from + span.end;
            (!before.ends_with("from")).then_some((whole, side))
        });
    let first = found.next()?;
    // Two places say nothing certain.
    found.all(|(_, side)| side == first.1).then_some(first)
}

/// The place that a clause states.
fn find_side(clause: &str) -> Option<(Range<usize>, Side)> {
    let mut found = CORNERS.iter().filter_map(|(words, side)| {
        let at = clause.find(words)?;
        let end = at + words.len();
        let ends = !clause[end..].starts_with(char::is_alphanumeric);
        ends.then_some((at..end, *side))
    });
    if let Some(first) = found.next() {
        return found.all(|(_, s)| s == first.1).then_some(first);
    }
    if let Some(both) = joined(clause) {
        return Some(both);
    }
    let mut found = SIDES.iter().filter_map(|(words, side)| {
        let at = clause.find(words)?;
        let rest = clause[at + words.len()..]
            .trim_start_matches("the ")
            .trim_start_matches("current ");
        let ego = rest.starts_with("ego") || rest.starts_with("you");
        ego.then_some((at..at + words.trim_end().len(), *side))
    });
    if let Some(first) = found.next() {
        return found.next().is_none().then_some(first);
    }
    // "In the same lanelet as ego, but far behind".
    let end = clause.trim_end_matches([' ', '.', ',', ';', '*', '"']);
    for (words, front) in [
        ("far behind", false),
        ("directly behind", false),
        ("directly ahead", true),
        ("directly in front", true),
        ("and in front", true),
    ] {
        if end.ends_with(words) {
            return Some((end.len() - words.len()..end.len(), side(Some(front), None)));
        }
    }
    // A field: "position: behind".
    let at = ["position", "location", "direction"]
        .iter()
        .find_map(|field| Some(clause.find(field)? + field.len()))?;
    let rest = clause[at..].trim_start_matches([':', '*', ' ', '"', '`', '=']);
    let start = clause.len() - rest.len();
    let (word, side) = FIELDS.iter().find(|(word, _)| {
        let after = rest.strip_prefix(word);
        after.is_some_and(|a| {
            let rest = a.trim_start_matches(['*', ' ', '"', '`', '.']);
            let of = rest.strip_prefix("of ").unwrap_or(rest);
            rest.is_empty()
                || rest.starts_with('(')
                || of.trim_start_matches("the ").starts_with("ego")
        })
    })?;
    Some((start..start + word.len(), *side))
}

/// "Ahead and slightly to the left of the ego": both axes, in words.
fn joined(clause: &str) -> Option<(Range<usize>, Side)> {
    for (word, front) in [("ahead", true), ("in front", true), ("behind", false)] {
        for (words, left) in [("to the left", true), ("to the right", false)] {
            let Some(at) = clause.find(&format!("{word} and ")) else {
                continue;
            };
            let rest = &clause[at + word.len() + " and ".len()..];
            // An adverb may stand between.
            let rest = match rest.split_once(' ') {
                Some((adverb, further)) if adverb.ends_with("ly") => further,
                _ => rest,
            };
            let Some(after) = rest.strip_prefix(words) else {
                continue;
            };
            let of = after
                .trim_start()
                .strip_prefix("of ")
                .map(|of| of.trim_start_matches("the "));
            let ends = after.trim_matches([' ', '.', '*', '"']).is_empty();
            if ends || of.is_some_and(|of| of.starts_with("ego")) {
                let end = clause.len() - after.len();
                return Some((at..end, side(Some(front), Some(left))));
            }
        }
    }
    None
}

/// The place in brackets behind the name of an obstacle or a length: "obstacle 7 (left)", "20 m (ahead)".
fn in_brackets(before: &str, clause: &str) -> Option<(Range<usize>, Side)> {
    let before = before.strip_suffix('(')?.trim_end_matches([' ', '*']);
    let length = ["m", "meters", "metres"].iter().any(|unit| {
        before
            .strip_suffix(unit)
            .is_some_and(|b| b.trim_end().ends_with(|c: char| c.is_ascii_digit()))
    });
    if !length && !before.ends_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let rest = clause.strip_prefix("directly ").unwrap_or(clause);
    let start = clause.len() - rest.len();
    let (word, side) = FIELDS.iter().find(|(word, _)| {
        let after = rest.strip_prefix(word);
        after.is_some_and(|a| {
            a.trim_matches([' ', ')', ',']).is_empty() || a.starts_with(" -") || a.starts_with(" –")
        })
    })?;
    Some((start..start + word.len(), *side))
}

/// Words that say that two bodies touch, right before the time.
const TOUCHES: &[&str] = &[
    "collides at",
    "collided at",
    "collides with the ego at",
    "collides with the ego vehicle at",
    "collided with the ego vehicle at",
    "collided with the ego at",
    "collision at",
    "collision occurs at",
    "collision occurred at",
    "collision happens at",
    "contact at",
    "contact occurs at",
    "touches the ego at",
    "touches the ego vehicle at",
];

/// Whether the words before a time say that two bodies touch then; gives where they begin.
pub fn touches_before(lower: &str) -> Option<usize> {
    const UNSURE: &[&str] = &[
        "no",
        "not",
        "if",
        "would",
        "could",
        "might",
        "may",
        "possible",
        "potential",
        "imminent",
        "risk",
        "indicating",
        "nearly",
        "without",
        "avoid",
        "predicted",
        "ttc",
        "likely",
    ];
    if UNSURE.iter().any(|word| has_word(lower, word)) {
        return None;
    }
    let trimmed = lower.trim_end_matches(['*', ' ', '~', '`']);
    let trimmed = ["time step", "timestep", "time", "step", "t =", "t="]
        .iter()
        .find_map(|word| trimmed.strip_suffix(word))
        .unwrap_or(trimmed)
        .trim_end_matches(['*', ' ', '~', '`']);
    let words = TOUCHES.iter().find(|words| trimmed.ends_with(*words))?;
    Some(trimmed.len() - words.len())
}

/// Whether a text denies: with a word of its own, or a contraction.
pub fn denies(text: &str) -> bool {
    const DENIALS: [&str; 12] = [
        "not", "no", "never", "nor", "neither", "without", "cannot", "nowhere", "hardly", "barely",
        "rarely", "lacks",
    ];
    DENIALS.iter().any(|word| has_word(text, word)) || is_contracted(text)
}

/// Whether a text has a contraction that denies: "isn't".
pub fn is_contracted(text: &str) -> bool {
    text.contains("n't") || text.contains("n’t")
}

/// Words with which a sentence supposes, asks, quotes, or denies as a whole.
const UNSAID: [&str; 30] = [
    "suppose",
    "imagine",
    "hypothetically",
    "hypothetical",
    "provided that",
    "in case",
    "given that",
    "doubt",
    "statement",
    "myth",
    "option",
    "previous answer",
    "question",
    "false that",
    "true that",
    "case that",
    "rather than",
    "far from",
    "refrain",
    "refrains",
    "ceases",
    "ceased",
    "ceasing",
    "stops approaching",
    "stop approaching",
    "only approaching",
    "anything but",
    "excluded",
    "once the",
    "should the",
];

/// Whether nothing that a sentence says is claimed by it.
pub fn is_unsaid(lower: &str) -> bool {
    lower.trim_end_matches(['*', ' ', '"']).ends_with('?')
        || UNSAID.iter().any(|words| has_word(lower, words))
        || lower
            .trim_start_matches(['*', ' ', '-', '"'])
            .starts_with("had ")
        || lower
            .trim_start_matches(['*', ' ', '-', '"'])
            .starts_with("assume")
}

/// Whether a word occurs, not as a part of another.
pub fn has_word(lower: &str, word: &str) -> bool {
    find_word(lower, word).is_some()
}

/// Where words stand in a text, not as a part of others.
pub fn find_word(lower: &str, word: &str) -> Option<usize> {
    lower.match_indices(word).map(|(at, _)| at).find(|at| {
        let part = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
        let end = at + word.len();
        !part(lower[..*at].chars().next_back()) && !part(lower[end..].chars().next())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_where_they_are_plain() {
        let read = |text: &str| side_in(text).map(|(_, side)| side.to_string());
        let some = |words: &str| Some(words.to_string());
        assert_eq!(
            read("obstacle 7 is directly in front of the ego."),
            some("in front")
        );
        assert_eq!(read("- **position**: rear-left"), some("rear left"));
        assert_eq!(
            read("- **position**: behind (longitudinal -3 m)"),
            some("behind")
        );
        assert_eq!(read("located behind the ego vehicle"), some("behind"));
        for doubtful in [
            "not in front of the ego",
            "approaching from behind",
            "it could be behind the ego",
            "position: front or behind",
            "between front-left and rear-left",
        ] {
            assert_eq!(read(doubtful), None, "{doubtful}");
        }
        assert!(touches_before("obstacle 7 collides with the ego at time step ").is_some());
        assert!(touches_before("no collision at ").is_none());
    }
}
