//! What a sentence claims in words: how its obstacle moves, in which lane it is, how risky it is, and whether it touches.

use std::ops::Range;

use super::number::{Number, Unit, axis, without_reference};
use super::phrases::clauses;
use super::place::{denies, find_word, has_word, is_contracted};
use super::{ClaimedValue, Predicate, Quantity};
use nearmiss_scene::metrics::RiskAspect;

/// A phrase in words, and what it says.
pub type Said = (Range<usize>, Quantity, ClaimedValue);

/// Words with which a clause supposes, guesses, or speaks of another time or of everyone.
const DOUBTFUL: &[&str] = &[
    "if",
    "unless",
    "would",
    "could",
    "might",
    "may",
    "can",
    "should",
    "potential",
    "potentially",
    "possible",
    "possibly",
    "likely",
    "unlikely",
    "appears",
    "appear",
    "seems",
    "seem",
    "assuming",
    "assume",
    "was",
    "were",
    "had",
    "initially",
    "previously",
    "earlier",
    "before",
    "until",
    "will",
    "or",
    "either",
    "whether",
    "none",
    "any",
    "obstacles",
    "vehicles",
    "others",
    "when",
    "once",
    "soon",
    "next",
    "after",
    "at first",
    "used to",
    "suddenly",
    "except",
    "hardly",
    "barely",
    "rarely",
    "only",
    "stop",
    "stops",
    "stopped",
    "towards obstacle",
    "toward obstacle",
];

/// So many words may stand between a denial and what it denies, and one more.
const NEAR: usize = 4;

/// What may follow "approaching" where the ego is approached, and nothing else.
const TOWARDS_THE_EGO: &[&str] = &[
    "the ego",
    "ego",
    "us",
    "you",
    "from",
    "at",
    "rapidly",
    "quickly",
    "slowly",
    "steadily",
    "gradually",
    "slightly",
    "fast",
    "directly",
    "head",
    "longitudinally",
    "laterally",
    "and",
    "but",
    "while",
    "with",
    "in",
    "on",
];

/// Phrases that say how the distance to the ego changes; those that name no one need [`TOWARDS_THE_EGO`] behind them.
const APPROACHES: &[(&str, bool)] = &[
    ("approaching", false),
    ("approaches", false),
    ("converging", false),
    ("closing in", false),
    ("closing", false),
    ("moving closer", false),
    ("getting closer", false),
    ("coming closer", false),
    ("drawing closer", false),
    ("moving toward the ego", true),
    ("moving towards the ego", true),
    ("moving toward ego", true),
    ("moving towards ego", true),
    ("moves toward the ego", true),
    ("moves towards the ego", true),
    ("heading toward the ego", true),
    ("heading towards the ego", true),
    ("driving toward ego", true),
    ("driving towards ego", true),
    ("driving toward the ego", true),
    ("driving towards the ego", true),
    ("approach)", true),
    ("toward ego)", true),
    ("towards ego)", true),
    ("toward the ego)", true),
    ("towards the ego)", true),
    ("closing the gap", true),
    ("closing distance", true),
    ("reducing the distance", true),
];

/// The same of growing distances.
const RECEDES: &[(&str, bool)] = &[
    ("moving away", true),
    ("away from ego)", true),
    ("away from the ego)", true),
    ("moves away", true),
    ("driving away", true),
    ("pulling away", true),
    ("drifting away", true),
    ("heading away", true),
    ("receding", true),
    ("diverging", false),
    ("moving further away", true),
    ("moving farther away", true),
    ("getting further away", true),
    ("getting farther away", true),
    ("falling back", true),
    ("increasing the distance", true),
];

/// What its own speed does.
const SPEEDS: &[(&str, Predicate)] = &[
    ("decelerating", Predicate::Braking),
    ("decelerates", Predicate::Braking),
    ("slowing down", Predicate::Braking),
    ("slows down", Predicate::Braking),
    ("is braking", Predicate::Braking),
    ("brakes", Predicate::Braking),
    ("accelerating", Predicate::Accelerating),
    ("accelerates", Predicate::Accelerating),
    ("speeding up", Predicate::Accelerating),
    ("speeds up", Predicate::Accelerating),
    ("at a constant speed", Predicate::Steady),
    ("at a constant velocity", Predicate::Steady),
    ("at constant speed", Predicate::Steady),
    ("at constant velocity", Predicate::Steady),
    ("faster than the ego", Predicate::FasterThanEgo),
    ("faster than ego", Predicate::FasterThanEgo),
    ("slower than the ego", Predicate::SlowerThanEgo),
    ("slower than ego", Predicate::SlowerThanEgo),
];

/// Where it goes and in which lane it is.
const WAYS: &[(&str, Predicate)] = &[
    ("same direction", Predicate::SameWay),
    ("opposite direction", Predicate::Oncoming),
    ("oncoming", Predicate::Oncoming),
    ("same lanelet", Predicate::SameLanelet),
    ("ego's lanelet", Predicate::SameLanelet),
    ("ego vehicle's lanelet", Predicate::SameLanelet),
    ("same lane", Predicate::SameLane),
    ("ego's lane", Predicate::SameLane),
    ("ego vehicle's lane", Predicate::SameLane),
    ("ego lane", Predicate::SameLane),
    ("different lanelet", Predicate::OtherLanelet),
    ("another lanelet", Predicate::OtherLanelet),
    ("separate lanelet", Predicate::OtherLanelet),
    ("adjacent lanelet", Predicate::OtherLanelet),
    ("different lane", Predicate::OtherLane),
    ("another lane", Predicate::OtherLane),
    ("adjacent lane", Predicate::OtherLane),
    ("separate lane", Predicate::OtherLane),
    ("neighboring lane", Predicate::OtherLane),
    ("neighbouring lane", Predicate::OtherLane),
];

/// That the bodies do not touch now.
const APART: &[&str] = &[
    "does not touch",
    "doesn't touch",
    "do not touch",
    "is not touching",
    "not in contact",
    "has not collided",
    "not colliding",
    "is not in collision",
    "no contact with the ego",
    "no collision with the ego",
    "collision has not occurred",
    "collision has not yet occurred",
    "no collision has occurred",
    "no collision has happened",
    "no collision is occurring",
    "no collision occurs",
    "no collision detected",
    "no collision is detected",
    "no current collision",
    "no overlap",
];

/// That they will.
const AHEAD: &[&str] = &[
    "collision is imminent",
    "imminent collision",
    "collision course",
    "will collide",
    "collision is unavoidable",
    "collision is inevitable",
    "unavoidable collision",
    "inevitable collision",
];

/// What a sentence in lower case says in words of its obstacle; `above` is what it stands under.
pub fn in_words(lower: &str, above: &str, numbers: &[Number]) -> Vec<Said> {
    let mut found = Vec::new();
    for (from, clause) in clauses(lower) {
        contacts(clause, from, &mut found);
        if DOUBTFUL.iter().any(|word| has_word(clause, word)) {
            continue;
        }
        // "toward the ego" is no subject, "the ego slows down" has one.
        let of_ego = |before: &str| has_word(&without_reference(before), "ego");
        for (at, phrase) in phrases(clause, APPROACHES) {
            let before = &clause[..at];
            for axis in axes(lower, above, from + at, clause) {
                found.push(said(
                    from + at,
                    phrase,
                    before,
                    Predicate::Approaching(axis),
                ));
            }
        }
        for (at, phrase) in phrases(clause, RECEDES) {
            let before = &clause[..at];
            for axis in axes(lower, above, from + at, clause) {
                found.push(said(from + at, phrase, before, Predicate::Receding(axis)));
            }
        }
        if let Some((span, closes, verb)) = changes(clause) {
            let is_new = { found.iter() }.all(|(other, ..): &Said| {
                other.end <= from + span.start || from + span.end <= other.start
            });
            for axis in axes(lower, above, from + span.start, clause) {
                let predicate = if closes {
                    Predicate::Approaching(axis)
                } else {
                    Predicate::Receding(axis)
                };
                if is_new {
                    found.push(said(
                        from + span.start,
                        &clause[span.clone()],
                        &clause[..verb],
                        predicate,
                    ));
                }
            }
        }
        for (list, only_own) in [(SPEEDS, true), (WAYS, false)] {
            let mut taken: Option<Range<usize>> = None;
            for (phrase, predicate) in list {
                let Some(at) = find_word(clause, phrase) else {
                    continue;
                };
                let span = at..at + phrase.len();
                // "Same lane" is in "same lanelet".
                if taken
                    .as_ref()
                    .is_some_and(|t| t.start <= at && span.end <= t.end + 3)
                {
                    continue;
                }
                let before = &clause[..at];
                let noun = clause[span.end..].trim_start().split(' ').next();
                let of_another = only_own && of_ego(before)
                    || predicate.quantity() == Quantity::Way && !is_in(before, phrase)
                    || matches!(
                        noun,
                        Some(
                            "vehicles"
                                | "traffic"
                                | "obstacles"
                                | "rate"
                                | "trend"
                                | "lane"
                                | "lanes"
                        )
                    )
                    || clause[span.end..].starts_with(':');
                if !of_another {
                    found.push(said(from + at, phrase, before, *predicate));
                }
                taken = Some(span);
            }
        }
        if let Some((span, id)) = lanelet(clause)
            && !has_word(&clause[..span.start], "ego")
            && is_in(&clause[..span.start], "lanelet")
        {
            let before = &clause[..span.start];
            let words = &clause[span.clone()];
            found.push(said(
                from + span.start,
                words,
                before,
                Predicate::OnLanelet(id),
            ));
        }
    }
    found.extend(risk(lower, above, numbers));
    found.extend(written(lower, numbers));
    found
}

fn said(at: usize, phrase: &str, before: &str, predicate: Predicate) -> Said {
    // What is denied stands right behind the denial: "not currently moving away", and not "does not brake and is moving away".
    let near: Vec<&str> = before.split_whitespace().rev().take(NEAR).collect();
    let near = near
        .iter()
        .take_while(|word| !["and", "but"].contains(*word));
    let is_denied = { near }.any(|word| denies(word.trim_matches(['*', '`', '"', '('])));
    let quantity = predicate.quantity();
    let value = ClaimedValue::Word {
        predicate,
        is_denied,
    };
    (at..at + phrase.len(), quantity, value)
}

/// The phrases of a list in a clause, each once; those that name no one only where the ego is meant.
fn phrases<'p>(clause: &str, list: &[(&'p str, bool)]) -> Vec<(usize, &'p str)> {
    let mut found: Vec<(usize, &str)> = Vec::new();
    for (phrase, is_whole) in list {
        let Some(at) = find_word(clause, phrase) else {
            continue;
        };
        let after = clause[at + phrase.len()..].trim_start_matches([' ', '*']);
        let ends = after.is_empty() || after.starts_with(['.', ')', '"', '-', '–', '(', ',', ';']);
        let is_field = after.starts_with(':');
        let is_meant = !is_field
            && (*is_whole || ends || TOWARDS_THE_EGO.iter().any(|word| starts(after, word)));
        // "From approaching", "rate of closing": no statement; "moving away" again in "moving away from".
        let before = clause[..at].trim_end();
        let is_stated = ![" of", " from", " for", "avoid", " rate"]
            .iter()
            .any(|word| before.ends_with(word));
        let is_new = found
            .iter()
            .all(|(other, longer)| at + phrase.len() <= *other || other + longer.len() <= at);
        if is_meant && is_stated && is_new {
            found.push((at, *phrase));
        }
    }
    found
}

/// Whether the words before a lane say that it is in it: "in the ego's lane", not "into the ego's lane" or "leaves".
fn is_in(before: &str, phrase: &str) -> bool {
    if !phrase.contains("lane") {
        return true;
    }
    let words = before.trim_end_matches(['*', ' ']);
    let words = ["the", "a", "an", "its"]
        .iter()
        .find_map(|word| words.strip_suffix(word).filter(|rest| rest.ends_with(' ')))
        .unwrap_or(words)
        .trim_end();
    let places = [
        "in",
        "on",
        "within",
        "along",
        "shares",
        "sharing",
        "occupies",
        "occupying",
        "uses",
        "using",
    ];
    words.is_empty()
        || words.ends_with(['(', ':', '-'])
        || places.iter().any(|word| {
            words
                .strip_suffix(word)
                .is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
        })
}

/// The axes along which something is said to approach: those that the clause names, or that the words before a bracket do.
fn axes(lower: &str, above: &str, at: usize, clause: &str) -> Vec<Option<bool>> {
    let names = |words: &str| {
        [("longitudinal", true), ("lateral", false)]
            .into_iter()
            .filter(|(word, _)| words.contains(word))
            .map(|(_, long)| Some(long))
            .collect::<Vec<_>>()
    };
    let own = names(clause);
    let dimensions = ["both dimensions", "both directions", "both axes", "in both"];
    if own.is_empty() && dimensions.iter().any(|words| clause.contains(words)) {
        return vec![Some(true), Some(false)];
    }
    match own.len() {
        1 => return own,
        // Which of two it is cannot be told.
        2 if clause.contains("both")
            || clause.contains("and lateral")
            || clause.contains("and longitudinal") =>
        {
            return own;
        }
        2 => return Vec::new(),
        _ => {}
    }
    let before = &lower[..at];
    if let Some((words, _)) = before
        .rsplit_once('(')
        .filter(|(_, inside)| inside.trim().is_empty())
    {
        let part = words.rsplit([',', ';']).next().unwrap_or(words);
        return vec![axis(part).or_else(|| axis(above))];
    }
    vec![axis(above)]
}

/// Contact denied now, and contact to come.
fn contacts(clause: &str, from: usize, found: &mut Vec<Said>) {
    const SUPPOSED: &[&str] = &[
        "if",
        "would",
        "could",
        "might",
        "may",
        "potential",
        "potentially",
        "possible",
        "possibly",
        "likely",
        "risk of",
        "unless",
        "avoid",
        "prevent",
        "whether",
        "or",
        "suggests",
        "suggesting",
        "approaches",
    ];
    if SUPPOSED.iter().any(|word| has_word(clause, word)) {
        return;
    }
    let apart = APART
        .iter()
        .find_map(|phrase| Some((find_word(clause, phrase)?, *phrase)));
    if let Some((at, phrase)) = apart {
        let value = ClaimedValue::Word {
            predicate: Predicate::Touches,
            is_denied: true,
        };
        found.push((
            from + at..from + at + phrase.len(),
            Quantity::Contact,
            value,
        ));
        return;
    }
    let ahead = AHEAD
        .iter()
        .find_map(|phrase| Some((find_word(clause, phrase)?, *phrase)));
    if let Some((at, phrase)) = ahead {
        found.push(said(from + at, phrase, &clause[..at], Predicate::WillTouch));
    }
}

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
const UNSCORED: &[&str] = &[
    "if",
    "would",
    "could",
    "reduces",
    "than",
    "between",
    "lower the",
    "obstacles",
    "not",
    "may",
    "might",
    "whether",
    "worst",
    "lowest",
    "highest",
    "never",
    "had",
    "will",
    "excluded",
    "requires",
    "threshold",
    "above",
    "below",
    "scene",
    "scenario",
    "or",
];

/// The risk score that is said: "overall risk: extreme (1)", "distance safety score: 4", "TTC 0.9 s (high risk)".
fn risk(lower: &str, above: &str, numbers: &[Number]) -> Option<Said> {
    if UNSCORED.iter().any(|word| has_word(lower, word)) || is_contracted(lower) {
        return None;
    }
    let label = lower.find("safety score").or_else(|| lower.find("risk"))?;
    let rest = &lower[label..];
    // What follows the words: "risk score for obstacle 7: 4 (low risk)".
    let field = rest.find([':', '=']).map(|at| label + at + 1);
    let head = &lower[..field.unwrap_or(label)];
    let of = aspect(head, above)?;
    let scored = numbers.iter().find(|number| {
        let is_score = number.unit == Unit::None
            && number.decimals == 0
            && (0.0..=5.0).contains(&number.value);
        let before = lower[..number.span.start].trim_end_matches(MARKUP);
        let is_after = field.is_some_and(|field| {
            let between = lower.get(field..number.span.start);
            between.is_some_and(|between| {
                let between = between.trim_matches(MARKUP);
                between.is_empty() || before.ends_with('(') && class_before(before).is_some()
            })
        });
        let of = [
            "score of",
            "score is",
            "risk score",
            "safety score",
            "score as",
        ];
        let of = of.iter().any(|words| before.ends_with(words));
        let in_brackets = before.ends_with('(') && class_before(before).is_some();
        is_score && number.span.end > label.saturating_sub(12) && (is_after || in_brackets || of)
    });
    if let Some(number) = scored {
        let score = number.value as u8;
        let after = lower[number.span.end..].trim_start_matches(MARKUP);
        // A range, another scale, or a class that says something else.
        let class = after
            .strip_prefix('(')
            .map(|rest| rest.trim_start_matches(MARKUP));
        let class = class.and_then(|rest| CLASSES.iter().find(|(class, _)| starts(rest, class)));
        let differs = class.is_some_and(|(_, other)| *other != score);
        if differs
            || ["to ", "out of", "/", "-", "–"]
                .iter()
                .any(|word| after.starts_with(word))
        {
            return None;
        }
        return Some((
            number.span.clone(),
            Quantity::Risk,
            ClaimedValue::Score { score, of },
        ));
    }
    // A class in brackets behind the number that it grades: "TTC 0.9 s (high risk)".
    let graded = numbers.iter().find_map(|number| {
        let rest = lower[number.span.end..]
            .trim_start_matches(MARKUP)
            .strip_prefix('(')?;
        let start = lower.len() - rest.len();
        let (class, score) = CLASSES.iter().find(|(class, _)| starts(rest, class))?;
        let risk = rest[class.len()..].trim_start().strip_prefix("risk")?;
        let axis = axis(&lower[..number.span.start]).or_else(|| axis(above));
        let of = match number.unit {
            Unit::Second => RiskAspect::Time(axis),
            Unit::Metre => RiskAspect::Distance(axis),
            _ => return None,
        };
        let end = lower.len() - risk.len();
        Some((
            start..end,
            Quantity::Risk,
            ClaimedValue::Score { score: *score, of },
        ))
    });
    if graded.is_some() {
        return graded;
    }
    // A field with a class alone: "overall risk: low".
    let field = field?;
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
    if says(&["velocity", "acceleration", "mdc", "direction"]) {
        return None;
    }
    if says(&["distance", "distances"]) {
        return Some(RiskAspect::Distance(axis));
    }
    if says(&["time", "ttc"]) {
        return Some(RiskAspect::Time(axis));
    }
    if axis.is_some() {
        return None;
    }
    let stands_under = |words: &[&str]| words.iter().any(|word| said(above, word));
    (!stands_under(&["distance", "time", "ttc", "mdc", "longitudinal", "lateral"]))
        .then_some(RiskAspect::Overall)
}

/// The class that words end with, before a bracket: "extreme risk (".
fn class_before(before: &str) -> Option<u8> {
    let word = before.trim_end_matches(['(', ' ', '*']);
    let word = word
        .strip_suffix("risk")
        .unwrap_or(word)
        .trim_end_matches(MARKUP);
    let found = CLASSES.iter().find(|(class, _)| word.ends_with(class))?;
    Some(found.1)
}

/// The place on the map that is said, (x, y), and the division that is written down.
fn written(lower: &str, numbers: &[Number]) -> Vec<Said> {
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
        let of_ego = has_word(&without_reference(before), "ego");
        if is_place && before.ends_with('(') && between == "," && after.starts_with(')') && !of_ego
        {
            let value = ClaimedValue::Place(x.value, y.value, x.decimals.min(y.decimals));
            found.push((x.span.start..y.span.end, Quantity::Position, value));
        }
    }
    for three in numbers.windows(3) {
        let [a, b, c] = three else { continue };
        let between = |from: &Number, to: &Number| {
            lower
                .get(from.span.end..to.span.start)
                .unwrap_or("?")
                .trim_matches([' ', '*', '|', '`', ')', '(', '~'])
                .to_owned()
        };
        let divides = ["/", "÷"].contains(&between(a, b).as_str());
        let gives = ["=", "≈", "= ~", "=~", "= approx.", "= approximately", "≈ ~"]
            .contains(&between(b, c).as_str());
        let fits = matches!(a.unit, Unit::Metre | Unit::None)
            && matches!(b.unit, Unit::Speed | Unit::None);
        if divides && gives && fits && matches!(c.unit, Unit::Second | Unit::None) {
            let value = ClaimedValue::Quotient([a, b, c].map(|n| (n.value, n.decimals)));
            found.push((a.span.start..b.span.end, Quantity::Arithmetic, value));
        }
    }
    found
}

/// How a distance is said to change: "the longitudinal gap to car 7 is increasing".
fn changes(clause: &str) -> Option<(Range<usize>, bool, usize)> {
    const LENGTHS: [&str; 4] = ["distance", "gap", "separation", "clearance"];
    const VERBS: [(&str, bool); 12] = [
        ("increasing", false),
        ("increases", false),
        ("growing", false),
        ("grows", false),
        ("widening", false),
        ("widens", false),
        ("decreasing", true),
        ("decreases", true),
        ("shrinking", true),
        ("shrinks", true),
        ("closing", true),
        ("narrowing", true),
    ];
    let length = LENGTHS
        .iter()
        .filter_map(|word| Some((find_word(clause, word)?, word)))
        .min()?;
    let (at, closes, verb) = VERBS
        .iter()
        .find_map(|(verb, closes)| Some((find_word(clause, verb)?, *closes, verb)))?;
    let near = at > length.0 && at - length.0 < 60;
    // "Increasing distance" says it as well.
    let before = at < length.0 && length.0 - (at + verb.len()) < 14;
    let own = clause[..length.0].trim_end();
    let others = [
        "stopping",
        "braking",
        "safe",
        "travelled",
        "traveled",
        "following",
        "safety",
    ];
    if others.iter().any(|word| own.ends_with(word)) || clause.contains("speed is") {
        return None;
    }
    (near || before).then(|| {
        (
            at.min(length.0)..(at + verb.len()).max(length.0 + length.1.len()),
            closes,
            at,
        )
    })
}

/// The lanelet that a clause puts its obstacle on: "in lanelet 120", "lanelet id: 120.0".
fn lanelet(clause: &str) -> Option<(Range<usize>, i64)> {
    let at = find_word(clause, "lanelet")?;
    let rest = &clause[at + "lanelet".len()..];
    let tail = rest.trim_start_matches([' ', ':', '*', '#']);
    let tail = tail
        .strip_prefix("id")
        .unwrap_or(tail)
        .trim_start_matches([' ', ':', '*', '=']);
    let digits = tail.bytes().take_while(u8::is_ascii_digit).count();
    let id = tail[..digits].parse().ok()?;
    let after = tail[digits..].strip_prefix(".0").unwrap_or(&tail[digits..]);
    // One of several, or the first of two that it passes.
    if after.starts_with(|c: char| c.is_alphanumeric())
        || after.trim_start().starts_with("to ")
        || after.trim_start().starts_with("and ")
    {
        return None;
    }
    Some((at..clause.len() - after.len(), id))
}

fn starts(text: &str, word: &str) -> bool {
    text.strip_prefix(word)
        .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
}
