//! Obstacles mentioned in a sentence, and whether one of them is its subject.

use std::ops::Range;

use super::find::{MentionContext, ends_with_word};
use super::number::{Number, Unit};

/// An obstacle that is named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mention {
    /// Its id; `None` for one that the scenario does not have.
    pub id: Option<i64>,
    /// The number, bytes.
    pub span: Range<usize>,
    /// Whether something is only compared with it: "further away than 30301".
    pub compared: bool,
}

/// Nouns for obstacles.
const CALLED: &[&str] = &[
    "obstacle",
    "obstacles",
    "obstacleid",
    "obstacle id",
    "obstacle_id",
    "vehicle",
    "car",
    "truck",
    "id",
    "pedestrian",
    "bicycle",
    "motorcycle",
    "bus",
    "taxi",
    "train",
    "unknown",
    "construction zone",
    "road boundary",
    "building",
    "pillar",
    "median strip",
];

/// What stands before such a noun.
const BEFORE_NOUN: &[&str] = &[
    "the",
    "parked",
    "static",
    "dynamic",
    "stationary",
    "standing",
];

/// Words before an obstacle that is not the subject of the sentence.
const COMPARED: &[&str] = &[
    "than",
    "than that of",
    "unlike",
    "like",
    "as",
    "to that of",
    "compared to",
    "compared with",
    "comparable to",
    "comparison to",
    "comparison with",
    "relative to",
    "similar to",
    "similarly to",
    "contrast to",
    "opposed to",
    "versus",
    "vs",
    "vs.",
];

/// Words that may stand before the obstacle that a sentence begins with.
const OPENING: &[&str] = &[
    "the",
    "a",
    "an",
    "for",
    "of",
    "with",
    "on",
    "regarding",
    "consider",
    "considering",
    "obstacle",
    "obstacles",
    "id",
    "obstacleid",
    "vehicle",
    "car",
    "truck",
    "bus",
    "pedestrian",
    "bicycle",
    "motorcycle",
    "cyclist",
    "static",
    "dynamic",
    "parked",
    "priority",
    "taxi",
    "other",
    "however",
    "meanwhile",
    "similarly",
    "while",
    "although",
    "and",
    "but",
    "finally",
    "additionally",
    "also",
    "lastly",
    "analysis",
    "assessment",
    "evaluation",
    "risk",
    "safety",
    "high",
    "medium",
    "low",
    "extreme",
    "name",
    "number",
    "another",
];

/// The obstacles that a text names, each once; `lower` is the text in lower case.
pub fn mentions(lower: &str, all: &[Number], world: &MentionContext<'_>) -> Vec<Mention> {
    let mut found: Vec<Mention> = Vec::new();
    for (place, number) in all.iter().enumerate() {
        let Some(id) = number.as_integer() else {
            continue;
        };
        // "Obstacle 1 (30200)" counts, and names it in the bracket.
        let next = all.get(place + 1).filter(|next| {
            let between = lower.get(number.span.end..next.span.start).unwrap_or("?");
            between
                .trim_matches(['*', ' ', ':', '#'])
                .trim_end_matches("id")
                .trim_end()
                == "("
                || between.trim() == "(id:"
        });
        let is_counted = next
            .and_then(Number::as_integer)
            .is_some_and(|id| world.ids.contains(&id));
        if is_counted && !world.ids.contains(&id) {
            continue;
        }
        let before = lower[..number.span.start]
            .trim_end_matches(['*', ' ', '`', ':', '"', '#', '(', '_', '=']);
        let called = CALLED.iter().any(|word| before.ends_with(word));
        let other = ["lanelet", "step", "timestep", "score", "risk", "lanelets"]
            .iter()
            .any(|word| before.ends_with(word));
        let known = world.ids.contains(&id);
        if id == world.ego && !known || other {
            continue;
        }
        let id = match (known, called) {
            (true, true) => Some(id),
            // A bare number with many digits that is an id can hardly be anything else.
            (true, false) if id >= 100 || is_subject(lower, number) => Some(id),
            (false, true) => None,
            _ => continue,
        };
        if found.iter().all(|m| m.id != id) {
            let compared = is_compared(before);
            let span = number.span.clone();
            found.push(Mention { id, span, compared });
        }
    }
    found
}

/// Whether a bare number begins a clause as whom it is about: "39 approaches and 7 is behind".
fn is_subject(lower: &str, number: &Number) -> bool {
    const OPENS: [&str; 8] = [
        "and", "while", "but", "whereas", "that", "because", "when", "if",
    ];
    const PLURALS: &str = "vehicles cars trucks obstacles seconds steps lanes metres meters agents objects participants \
        pedestrians cyclists others times points units lanelets";
    let before = lower[..number.span.start].trim_end_matches([' ', '*', '`', '"']);
    let opens = before.is_empty()
        || before.ends_with([',', ';'])
        || OPENS.iter().any(|word| ends_with_word(before, word));
    let after = lower[number.span.end..].trim_start_matches(['*', '`', '"']);
    let next: String = { after.trim_start().chars() }
        .take_while(|c| c.is_alphabetic())
        .collect();
    let is_verb =
        next.len() > 1 && next.ends_with('s') && PLURALS.split(' ').all(|word| word != next);
    // "Behind 7", "closer than 52", "the nearest is 7": behind a word that leads to no number.
    const LEADS: [&str; 16] = [
        "ttc to",
        "ttc with",
        "distance to",
        "gap to",
        "clearance to",
        "headway to",
        "score of",
        "behind",
        "than",
        "ahead of",
        "in front of",
        "collision with",
        "contact with",
        "beside",
        "nearest is",
        "closest is",
    ];
    let is_led = LEADS.iter().any(|word| ends_with_word(before, word))
        && (after.trim_start().is_empty()
            || !after.starts_with(' ')
            || next.len() > 1 && (!next.ends_with('s') || ["is", "was", "has"].contains(&&*next)));
    number.unit == Unit::None
        && (is_led && !after.starts_with([':', '/', '%']) && number.decimals == 0
            || opens
                && (after.starts_with("'s")
                    || after.starts_with(' ') && (is_verb || next == "will")))
}

/// Whether the words before a name only compare.
fn is_compared(before: &str) -> bool {
    let words = without_noun(before);
    COMPARED.iter().any(|word| ends_with_word(words, word))
}

/// The words before a name without what the obstacle is called.
fn without_noun(before: &str) -> &str {
    let mut words = before;
    while let Some(rest) = CALLED
        .iter()
        .chain(BEFORE_NOUN)
        .find_map(|word| ends_with_word(words, word).then(|| &words[..words.len() - word.len()]))
    {
        words = rest.trim_end_matches(['*', ' ', '`', ':', '"', '#', '(', '_']);
    }
    words
}

/// Whether a sentence begins with a name: nothing but what obstacles are called, a label, or a time stands before it.
pub fn begins_with(lower: &str, mention: &Mention) -> bool {
    if mention.compared {
        return false;
    }
    let before = &lower[..mention.span.start];
    // "At t = 3.4 s, obstacle 7 …", "- **Distance risk reason**: Obstacle 7 …", "Safety analysis for 6.4 s: Obstacle
    // 7 …"
    let places = before.match_indices([',', ':']);
    let mut starts = std::iter::once(0).chain(places.map(|(at, _)| at + 1));
    starts.any(|from| {
        let called = before[from..].trim_end_matches(['*', ' ', '`', ':', '"', '#', '(', '_']);
        let mut words = without_noun(called)
            .split(|c: char| !c.is_alphabetic())
            .filter(|word| !word.is_empty());
        let opens = words.all(|word| OPENING.contains(&word));
        opens && is_introduction(&before[..from])
    })
}

/// Whether what stands before a comma or colon says when, or how something continues, and mentions no participant.
fn is_introduction(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let few = words.by_ref().take(8).count() < 8;
    let spoken = ["its ", " it ", " is ", " this obstacle"];
    few && !spoken.iter().any(|word| format!("{text} ").contains(word))
}

/// Whether nothing but a name and its markup stands in a line: what a heading would say.
pub fn is_label(lower: &str, mention: &Mention) -> bool {
    let rest = lower[mention.span.end..].trim_matches(['*', ' ', ':', '.', '`', '"', ')', ',']);
    begins_with(lower, mention) && !rest.chars().any(char::is_alphanumeric)
        || begins_with(lower, mention) && lower.trim_end_matches(['*', ' ']).ends_with(':')
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use nearmiss_scene::scenario::ObstacleType;

    use super::super::number::numbers;
    use super::*;

    fn read(text: &str) -> Vec<(Option<i64>, bool, bool)> {
        let ids = BTreeSet::from([7, 301, 302]);
        let world = MentionContext {
            subject: None,
            present: 0,
            has_trajectory: false,
            ids: &ids,
            ego: 9,
            dt: 0.1,
            steps: 0..50,
            now: None,
        };
        let all = mentions(text, &numbers(text), &world);
        let begins = |m: &Mention| (m.id, m.compared, begins_with(text, m));
        all.iter().map(begins).collect()
    }

    #[test]
    fn the_subject_is_told_from_a_mention() {
        for begins in [
            "obstacle 301 is near",
            "- **obstacle id: 301**",
            "at t=3.4s, obstacle 301 is near",
            "- **reason**: obstacle 301 is near",
            "however, the obstacle 301 is near",
        ] {
            assert_eq!(read(begins), [(Some(301), false, true)], "{begins}");
        }
        for compared in [
            "a lower risk compared to obstacle 301",
            "further away than 301",
            "similar to the obstacle 301, it is far",
        ] {
            assert_eq!(read(compared), [(Some(301), true, false)], "{compared}");
        }
        assert_eq!(
            read("it is near and cuts off obstacle 301"),
            [(Some(301), false, false)]
        );
        assert_eq!(read("obstacle 777 is near"), [(None, false, true)]);
        assert_eq!(read("ttc to 7 is about 1.7 s"), [(Some(7), false, false)]);
        assert_eq!(read("a gap of 7 is small"), []);
    }

    #[test]
    fn every_type_of_obstacle_is_a_noun() {
        for kind in ObstacleType::ALL {
            let text = format!("• {} 7 touches the ego", kind.words());
            assert_eq!(read(&text), [(Some(7), false, true)], "{text}");
        }
    }
}
