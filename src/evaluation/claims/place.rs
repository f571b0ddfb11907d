//! Phrases for an obstacle's position, and for contact with the ego.

use std::ops::Range;

use super::Side;

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
    "from",
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
    if DOUBTFUL.iter().any(|word| has_word(lower, word)) {
        return None;
    }
    let mut found = CORNERS.iter().filter_map(|(words, side)| {
        let at = lower.find(words)?;
        let end = at + words.len();
        let ends = !lower[end..].starts_with(char::is_alphanumeric);
        ends.then_some((at..end, *side))
    });
    if let Some(first) = found.next() {
        // Two corners say nothing certain.
        return found.all(|(_, s)| s == first.1).then_some(first);
    }
    let mut found = SIDES.iter().filter_map(|(words, side)| {
        let at = lower.find(words)?;
        let rest = lower[at + words.len()..].trim_start_matches("the ");
        let ego = rest.starts_with("ego") || rest.starts_with("you");
        ego.then_some((at..at + words.trim_end().len(), *side))
    });
    if let Some(first) = found.next() {
        return found.next().is_none().then_some(first);
    }
    // A field: "position: behind".
    let at = lower.find("position")? + "position".len();
    let rest = lower[at..].trim_start_matches([':', '*', ' ', '"', '`', '=']);
    let start = lower.len() - rest.len();
    let (word, side) = FIELDS.iter().find(|(word, _)| {
        let after = rest.strip_prefix(word);
        after.is_some_and(|a| {
            a.trim_start_matches(['*', ' ', '"', '`', '.']).is_empty()
                || a.trim_start().starts_with('(')
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

/// Whether a word occurs, not as a part of another.
pub fn has_word(lower: &str, word: &str) -> bool {
    lower.match_indices(word).any(|(at, _)| {
        let before = lower[..at].chars().next_back();
        let after = lower[at + word.len()..].chars().next();
        let part = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
        !part(before) && !part(after)
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
