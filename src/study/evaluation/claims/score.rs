//! Claims that numbers make with the words around them: risk scores, places on the map and divisions.

use std::ops::Range;

use nearmiss_scene::metrics::RiskAspect;

use super::number::{Number, Unit, axis, begins_with_word, divisions};
use super::tokens::{find_word, has_word, is_contracted};
use super::{ClaimedValue, Quantity};

/// A phrase, and what it says.
pub type Said = (Range<usize>, Quantity, ClaimedValue);

/// Classes of the risk score.
const CLASSES: &[(&str, u8)] = &[
    ("collision", 0),
    ("extreme", 1),
    ("high", 2),
    ("medium", 3),
    ("moderate", 3),
    ("low", 4),
    ("negligible", 5),
    ("no", 5),
];

/// Words with which a score is supposed, compared or told of several.
const UNSCORED: [&str; 22] = [
    "if",
    "would",
    "could",
    "reduces",
    "than",
    "between",
    "obstacles",
    "not",
    "may",
    "might",
    "whether",
    "lowest",
    "highest",
    "worst",
    "never",
    "had",
    "will",
    "excluded",
    "requires",
    "threshold",
    "scene",
    "scenario",
];

/// What stands before a score.
const SCORING: [&str; 20] = [
    "score of",
    "score is",
    "score",
    "scores",
    "score as",
    "score should be",
    "score remains",
    "rate it",
    "rated",
    "rate this",
    "rating of",
    "earns it a",
    "gets a",
    "gets",
    "gets a score of",
    "risk level",
    "risk of",
    "level of",
    "risk is",
    "it as",
];

/// The risk scores that are said: "overall risk: extreme (1)", "distance safety score: 4", "TTC 0.9 s (high risk)".
pub fn risks(lower: &str, above: &str, numbers: &[Number]) -> Vec<Said> {
    let mentioned = |text: &str| {
        [
            "score", "scores", "risk", "rate", "rated", "rating", "safety", "level",
        ]
        .iter()
        .any(|word| has_word(text, word))
    };
    if !mentioned(lower) && !mentioned(above) && !lower.contains("score") {
        return Vec::new();
    }
    let mut found: Vec<Said> = { numbers.iter() }
        .filter_map(|number| score(lower, above, number).or_else(|| graded(lower, above, number)))
        .collect();
    if found.is_empty() {
        found.extend(class_alone(lower, above).or_else(|| class_said(lower, above)));
    }
    found
}

/// The part of a sentence around a place that no comma or full stop divides.
fn around(lower: &str, at: usize) -> Range<usize> {
    let bytes = lower.as_bytes();
    let divides = |place: &usize| match bytes[*place] {
        b',' | b';' | b'|' => true,
        b'-' => *place > 0 && bytes[place - 1] == b' ' && bytes.get(place + 1) == Some(&b' '),
        b'.' => !bytes.get(place + 1).is_some_and(u8::is_ascii_digit),
        _ => false,
    };
    let from = (0..at).rfind(divides).map_or(0, |place| place + 1);
    let to = (at..lower.len()).find(divides).unwrap_or(lower.len());
    from..to
}

/// The score that a number states.
fn score(lower: &str, above: &str, number: &Number) -> Option<Said> {
    // "Safety score: 5.0".
    let is_whole = number.decimals == 0
        || number.decimals == 1 && number.value.fract() == 0.0 && has_word(lower, "score");
    let is_score = number.unit == Unit::None && (0.0..=5.0).contains(&number.value) && is_whole;
    if !is_score {
        return None;
    }
    let part = around(lower, number.span.start);
    let words = &lower[part.clone()];
    let near: Vec<&str> = lower[part.start..number.span.start]
        .split_whitespace()
        .rev()
        .take(5)
        .collect();
    let near = near.join(" ");
    if UNSCORED.iter().any(|word| has_word(&near, word))
        || is_contracted(words)
        || ["if", "scene", "scenario"]
            .iter()
            .any(|word| has_word(words, word))
    {
        return None;
    }
    let head = &lower[part.start..number.span.start];
    let before = head.trim_end_matches(MARKUP);
    let after = lower[number.span.end..].trim_start_matches(MARKUP);
    // A range, another scale, an index.
    if [
        "to ", "out of", "/", "-", "–", "or ", "obstacle", "vehicle", ". ",
    ]
    .iter()
    .any(|word| after.starts_with(word))
    {
        return None;
    }
    let said = { CLASSES.iter() }.find(|(class, _)| {
        let bracket = after
            .strip_prefix('(')
            .map(|rest| rest.trim_start_matches(MARKUP));
        bracket.is_some_and(|rest| begins_with_word(rest, class))
    });
    let in_brackets = before.ends_with('(') && class_before(before).is_some();
    let is_field = before.ends_with([':', '=']) && {
        let label = before.trim_end_matches([':', '=', ' ', '*', '"']);
        ["score", "risk", "overallriskscore", "level"]
            .iter()
            .any(|word| label.ends_with(word))
            || label.contains("score")
            || has_word(label, "risk")
    };
    // "The risk score of obstacle 7 is 3".
    let is_owned = { before.strip_suffix("is").or(before.strip_suffix(':')) }
        .and_then(|rest| rest.rsplit_once("score of "))
        .is_some_and(|(_, who)| who.split_whitespace().count() <= 3);
    let is_said = is_owned
        || SCORING.iter().any(|words| {
            let bare = before.trim_end_matches(['*', ':', ' ', '=', '"']);
            bare.strip_suffix(words)
                .is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
        })
        || has_word(before, "score") && has_word(before, "for") && before.ends_with(':')
        || before.is_empty() && has_word(after, "for") && has_word(before, "score");
    if !(is_field || is_said || in_brackets || said.is_some()) {
        return None;
    }
    let value = number.value as u8;
    // A class that says something else.
    let class = said
        .map(|said| said.1)
        .or_else(|| class_before(before).filter(|_| in_brackets));
    if class.is_some_and(|class| class != value) {
        return None;
    }
    // "At 0.5 m lateral distance I rate it 2": a score that is given is of all but what stands right before the word.
    let words: Vec<&str> = head.split_whitespace().collect();
    let near = words[words.len().saturating_sub(6)..].join(" ");
    let given = ["rate", "rated", "gets", "earns", "assign"]
        .iter()
        .any(|word| has_word(&near, word));
    let of = match given {
        true => RiskAspect::Overall,
        // "TTC < 0.5 s indicates extreme risk (score 1)" is the grade of that time.
        false
            if is_said
                && !is_owned
                && !["indicat", "suggest", "correspond", "fall", "put"]
                    .iter()
                    .any(|word| head.contains(word)) =>
        {
            aspect(&near, above)?
        }
        false => aspect(head, above)?,
    };
    Some((
        number.span.clone(),
        Quantity::Risk,
        ClaimedValue::Score { score: value, of },
    ))
}

/// A class behind the number that it grades: "TTC 0.9 s (high risk)", "TTC 0.9 s → high risk".
fn graded(lower: &str, above: &str, number: &Number) -> Option<Said> {
    let behind = lower[number.span.end..].trim_start_matches(MARKUP);
    let marks = ["(", "→", "->", "=>"];
    let rest = marks.iter().find_map(|mark| behind.strip_prefix(mark))?;
    let rest = rest.trim_start_matches(MARKUP);
    let start = lower.len() - rest.len();
    let (class, score) = CLASSES
        .iter()
        .find(|(class, _)| begins_with_word(rest, class))?;
    let risk = rest[class.len()..].trim_start().strip_prefix("risk")?;
    let head = &lower[around(lower, number.span.start).start..number.span.start];
    let axis = axis(head).or_else(|| axis(above));
    let of = match number.unit {
        Unit::Second => RiskAspect::Time(axis),
        Unit::Metre => RiskAspect::Distance(axis),
        _ => return None,
    };
    let value = ClaimedValue::Score { score: *score, of };
    Some((start..lower.len() - risk.len(), Quantity::Risk, value))
}

/// A class that is stated of an obstacle: "it poses an extreme risk".
fn class_said(lower: &str, above: &str) -> Option<Said> {
    const STATES: [&str; 20] = [
        "reflects",
        "reflecting",
        "shows",
        "showing",
        "is",
        "warrant",
        "poses",
        "posing",
        "presents",
        "presenting",
        "indicates",
        "indicating",
        "represents",
        "representing",
        "classified",
        "warrants",
        "suggests",
        "suggesting",
        "as",
        "remains",
    ];
    const GIVES: [&str; 3] = ["assessment is", "rating is", "level is"];
    let plain = lower.replace(['*', '"', '`'], " ");
    let (class, score, at) = CLASSES.iter().skip(1).take(5).find_map(|(class, score)| {
        let risk = ["risk", "-risk"];
        let at = find_word(&plain, class)?;
        let after = plain[at + class.len()..].trim_start();
        let after = after
            .strip_prefix("collision")
            .unwrap_or(after)
            .trim_start();
        risk.iter()
            .any(|word| after.starts_with(word))
            .then_some((class, score, at))
    })?;
    let words: Vec<&str> = plain[..at].split_whitespace().rev().take(4).collect();
    let after = plain[at..]
        .split_once("risk")
        .map_or("", |(_, after)| after.trim_start());
    let is_stated = words.iter().any(|word| STATES.contains(word))
        || GIVES.iter().any(|words| after.starts_with(words));
    let part = &plain[around(&plain, at)];
    let is_doubted = UNSCORED.iter().any(|word| has_word(part, word))
        || has_word(part, "no")
        || has_word(part, "potentially");
    if !is_stated || is_doubted {
        return None;
    }
    let of = aspect(&plain[around(&plain, at).start..at], above)?;
    let value = ClaimedValue::Score { score: *score, of };
    // "An extreme risk of collision" is no collision.
    let risk = lower[at..]
        .find("risk")
        .map_or(class.len(), |end| end + "risk".len());
    let of_what = ["of collision", "of a collision", "of contact"];
    let rest = &lower[at + risk..];
    let more = of_what
        .iter()
        .find(|words| rest.trim_start().starts_with(**words));
    let end = at
        + risk
        + more.map_or(0, |words| {
            rest.len() - rest.trim_start().len() + words.len()
        });
    Some((at..end, Quantity::Risk, value))
}

/// A field with a class alone: "overall risk: low".
fn class_alone(lower: &str, above: &str) -> Option<Said> {
    let label = lower.find("safety score").or_else(|| lower.find("risk"))?;
    let field = label + lower[label..].find([':', '='])? + 1;
    if UNSCORED.iter().any(|word| has_word(&lower[..field], word)) {
        return None;
    }
    let of = aspect(&lower[..field], above)?;
    let words = lower[field..]
        .trim_matches(MARKUP)
        .trim_end_matches('.')
        .trim_end_matches(MARKUP);
    let words = words.strip_suffix("risk").unwrap_or(words).trim_end();
    let (class, score) = CLASSES.iter().find(|(class, _)| words == *class)?;
    let at = field + lower[field..].find(class)?;
    let value = ClaimedValue::Score { score: *score, of };
    Some((at..at + class.len(), Quantity::Risk, value))
}

/// What may stand around words and numbers.
const MARKUP: [char; 6] = ['*', ' ', '`', '"', '\'', '<'];

/// What a score with such words before it is of; nothing where that is something else.
fn aspect(head: &str, above: &str) -> Option<RiskAspect> {
    let said = |text: &str, word: &str| has_word(text, word);
    let axis = axis(head);
    let says = |words: &[&str]| words.iter().any(|word| said(head, word));
    if says(&["velocity", "acceleration", "direction"]) {
        return None;
    }
    if says(&["distance", "distances"]) {
        return Some(RiskAspect::Distance(axis));
    }
    if says(&["mdc"]) {
        return None;
    }
    if says(&["time", "ttc"]) {
        return Some(RiskAspect::Time(axis));
    }
    if axis.is_some() {
        return None;
    }
    // What it stands under says it where it does not.
    let above_says = |words: &[&str]| words.iter().any(|word| said(above, word));
    if above_says(&["mdc"]) {
        return None;
    }
    if above_says(&["time", "ttc"]) {
        return Some(RiskAspect::Time(super::number::axis(above)));
    }
    if above_says(&["distance"]) {
        return Some(RiskAspect::Distance(super::number::axis(above)));
    }
    (!above_says(&["longitudinal", "lateral"])).then_some(RiskAspect::Overall)
}

/// The class that words end with, before a bracket: "extreme risk (".
fn class_before(before: &str) -> Option<u8> {
    let word = before.trim_end_matches(['(', ' ', '*']);
    let word = ["risk", "band", "category", "class"]
        .iter()
        .find_map(|noun| word.strip_suffix(noun))
        .unwrap_or(word)
        .trim_end_matches(MARKUP);
    let found = CLASSES.iter().find(|(class, _)| word.ends_with(class))?;
    Some(found.1)
}

/// Whether two numbers are said to be x and y: "(1.2, 3.4)", "x: 1.2, y: 3.4".
fn is_pair(before: &str, between: &str, after: &str) -> bool {
    let bare = |text: &str| {
        text.replace([':', '=', ' ', '*', ','], "")
            .replace("and", "")
    };
    let x = before
        .trim_end_matches([':', '=', ' ', '*'])
        .strip_suffix('x');
    let names_x = x.is_some_and(|rest| !rest.ends_with(char::is_alphanumeric));
    before.ends_with('(') && between == "," && after.starts_with(')')
        || names_x && bare(between) == "y"
}

/// The place on the map that is said, (x, y), and the division that is written down.
pub fn written(lower: &str, numbers: &[Number]) -> Vec<Said> {
    let mut found = Vec::new();
    for pair in numbers.windows(2) {
        let [x, y] = pair else { continue };
        let (before, between, after) = (
            lower[..x.span.start].trim_end(),
            lower.get(x.span.end..y.span.start).unwrap_or("?").trim(),
            lower[y.span.end..].trim_start(),
        );
        let is_place =
            x.decimals > 0 && y.decimals > 0 && x.unit == Unit::None && y.unit == Unit::None;
        let spaced = before.replace('_', " ");
        let mut near = spaced.split_whitespace().rev().take(4);
        let is_velocity = near.any(|word| ["v", "rel", "vrel", "velocity"].contains(&word));
        let is_pair = is_pair(before, between, after);
        if is_place && is_pair && is_velocity {
            for (number, quantity) in [(x, Quantity::VelocityLong), (y, Quantity::VelocityLat)] {
                let value = ClaimedValue::Number {
                    value: number.value,
                    decimals: number.decimals,
                    rough: false,
                    magnitude: false,
                };
                found.push((number.span.clone(), quantity, value));
            }
        } else if is_place && is_pair && !before.ends_with("min(") && !before.ends_with("max(") {
            let value = ClaimedValue::Place(x.value, y.value, x.decimals.min(y.decimals));
            found.push((x.span.start..y.span.end, Quantity::Position, value));
        }
    }
    for (_, parts) in divisions(lower, numbers) {
        let [a, b, c] = parts else { continue };
        let fits = matches!(a.unit, Unit::Metre | Unit::None)
            && matches!(b.unit, Unit::Speed | Unit::None)
            && matches!(c.unit, Unit::Second | Unit::None);
        if fits {
            let value = ClaimedValue::Quotient([a, b, c].map(|n| (n.value, n.decimals)));
            found.push((a.span.start..b.span.end, Quantity::Arithmetic, value));
        }
    }
    found
}

/// That a time to collision never ends: "TTC: not applicable", "infinite".
pub fn never(lower: &str, above: &str) -> Option<Said> {
    const NEVER: [&str; 9] = [
        "not applicable",
        "n/a",
        "infinite",
        "infinity",
        "inf",
        "undefined",
        "not defined",
        "none",
        "∞",
    ];
    let (word, at) = NEVER
        .iter()
        .find_map(|word| Some((word, find_word(lower, word).or_else(|| lower.find('∞'))?)))?;
    let before = &lower[..at];
    let bare = before.trim_end_matches([' ', '*', ':', '=', '`', '≈', '(']);
    let is_value = bare.len() < before.trim_end().len()
        || bare.ends_with("is")
        || bare.ends_with("are")
        || bare.is_empty();
    let is_time = ["ttc", "time to collision", "time-to-collision"]
        .iter()
        .any(|words| before.contains(words) || above.contains(words) && bare.len() < 30);
    if !is_value || !is_time || before.contains("mdc") || before.contains("distance") {
        return None;
    }
    let quantity = match axis(before).or_else(|| axis(above)) {
        None => Quantity::Ttc,
        Some(true) => Quantity::TtcLong,
        Some(false) => Quantity::TtcLat,
    };
    // What is not applicable may only not have been computed.
    let value = ClaimedValue::Number {
        value: f64::INFINITY,
        decimals: 0,
        rough: ["not applicable", "n/a", "none"].contains(word),
        magnitude: true,
    };
    Some((at..at + word.len(), quantity, value))
}
