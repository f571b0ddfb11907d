//! Sentences of a text about a scene: the claims of each, and what it comes to as a whole.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use super::consistency::{Against, against_verdict, contradictions};
use super::number::{Number, Unit, numbers};
use super::tokens::{find_word, has_word, is_foreign};
use super::{CheckedClaim, ClaimedValue, Judgement, Quantity, Subject, checked, find};

/// What a sentence comes to.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    IntoStaticStr,
    VariantArray,
    Deserialize,
    Serialize,
    JsonSchema,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum SentenceOutcome {
    /// All of it was understood and holds.
    Right,
    /// A claim of it does not hold.
    Wrong,
    /// A claim of it cannot be decided.
    Open,
    /// It says something of the scene that was not understood, or not all of it was.
    NotUnderstood,
}

nearmiss_record::named!(SentenceOutcome);

/// A sentence, list item or table row that says something of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedSentence {
    /// Where it stands in the text, bytes.
    pub span: Range<usize>,
    /// What it comes to.
    pub outcome: SentenceOutcome,
    /// Its claims, in their order.
    pub claims: Vec<CheckedClaim>,
    /// The sentences that it contradicts, bytes.
    pub contradicts: Vec<Range<usize>>,
    /// The claims, by their place, whose number is invented: it does not hold, and what the model was shown does not have it.
    pub invented: Vec<usize>,
    /// What a second reader made of it, in the claim language; empty where only the rules read it.
    pub translated: Vec<String>,
}

impl CheckedSentence {
    /// Whether it came to anything.
    #[must_use]
    pub fn is_understood(&self) -> bool {
        self.outcome != SentenceOutcome::NotUnderstood
    }
}

/// Beginnings of words that state how something moves, in which lane it is, or that it touches.
const MOVING: &[&str] = &[
    "approach",
    "closing",
    "converging",
    "reced",
    "diverging",
    "away",
    "nearing",
    "brak",
    "deceleratin",
    "acceleratin",
    "slow",
    "stop",
    "stationary",
    "standing",
    "turn",
    "yield",
    "cut",
    "collid",
    "collision",
    "contact",
    "touch",
    "overlap",
    "lane",
    "overtak",
    "revers",
    "backward",
    "merg",
    "follow",
    "tailgat",
    "swerv",
    "rolling",
    "faster",
    "closer",
    "farther",
    "further",
    "nearest",
    "closest",
    "fastest",
    "slowest",
    "smallest",
    "lowest",
    "highest",
];

/// The same of places and numbers; a clause with a claim has them around it.
const PLACED: &[&str] = &[
    "moving",
    "distance",
    "gap",
    "clearance",
    "ttc",
    "speed",
    "velocity",
    "ahead",
    "behind",
    "front",
    "rear",
    "left",
    "right",
    "oncoming",
    "opposite",
    "direction",
];

/// The sentences of a text that say something of the scene, each with its claims checked.
///
/// A sentence is wrong if a claim of it is, else open if one is, and right only if nothing that it states is left over: a
/// number with a unit, or a clause that speaks of motion, place, lane, contact or risk.
#[must_use]
pub fn sentences(text: &str, subject: &Subject<'_>) -> Vec<CheckedSentence> {
    sentences_with(text, checked(text, subject), subject)
}

/// The same with the claims of the text.
pub(super) fn sentences_with(
    text: &str,
    mut claims: Vec<CheckedClaim>,
    subject: &Subject<'_>,
) -> Vec<CheckedSentence> {
    claims.sort_by_key(|checked| checked.claim.span.start);
    let mut found = Vec::new();
    let told = subject.prompt.map(|prompt| {
        let all = numbers(prompt).into_iter();
        all.map(|number| number.value).collect::<Vec<f64>>()
    });
    for Part { span, is_data } in parts(text) {
        let Range { start: begin, end } = span.clone();
        let own: Vec<CheckedClaim> = { claims.iter() }
            .filter(|c| (begin..end).contains(&c.claim.span.start))
            .cloned()
            .collect();
        if end - begin > find::LONGEST_SENTENCE {
            found.push(CheckedSentence {
                span,
                outcome: SentenceOutcome::NotUnderstood,
                claims: own,
                contradicts: Vec::new(),
                invented: Vec::new(),
                translated: Vec::new(),
            });
            continue;
        }
        let lower = text[begin..end].to_lowercase();
        let same_places = lower.len() == end - begin;
        let is_label = lower.trim_end_matches(['*', ' ']).ends_with(':') || lower.starts_with('#');
        if own.is_empty() && (is_data || is_label || !states(&lower)) {
            continue;
        }
        let rest = !same_places
            || own.iter().all(|one| one.claim.is_described)
            || is_left_over(&lower, begin, &own);
        let has = |is: fn(&Judgement) -> bool| own.iter().any(|c| is(&c.judgement));
        let outcome = if has(|j| *j == Judgement::Wrong) {
            SentenceOutcome::Wrong
        } else if has(|j| matches!(j, Judgement::Unknown(_))) {
            SentenceOutcome::Open
        } else if own.is_empty() || rest {
            SentenceOutcome::NotUnderstood
        } else {
            SentenceOutcome::Right
        };
        let invented = { own.iter().enumerate() }
            .filter(|(_, claim)| told.as_ref().is_some_and(|told| is_invented(claim, told)))
            .map(|(place, _)| place)
            .collect();
        found.push(CheckedSentence {
            span,
            outcome,
            claims: own,
            contradicts: Vec::new(),
            invented,
            translated: Vec::new(),
        });
    }
    let all: Vec<(Range<usize>, &[CheckedClaim])> = { found.iter() }
        .map(|one| (one.span.clone(), one.claims.as_slice()))
        .collect();
    let mut against = contradictions(&all);
    against.extend(against_verdict(text, &all));
    for Against {
        sentence,
        claim,
        other,
    } in against
    {
        let one = &mut found[sentence];
        if !one.contradicts.contains(&other) {
            one.contradicts.push(other.clone());
        }
        one.claims[claim]
            .contradicts
            .get_or_insert(text[other].to_owned());
    }
    for one in &mut found {
        one.contradicts.sort_by_key(|span| span.start);
    }
    found
}

/// Whether a number of a claim that does not hold is none of those that were told, as they were printed or rounded.
fn is_invented(checked: &CheckedClaim, told: &[f64]) -> bool {
    let ClaimedValue::Number {
        value, decimals, ..
    } = checked.claim.stated
    else {
        return false;
    };
    let half = 0.5 * 10_f64.powi(-i32::from(decimals)) + 1e-9;
    let is_told = |told: &f64| (told.abs() - value.abs()).abs() <= half;
    checked.judgement != Judgement::Right
        && value.is_finite()
        && !matches!(
            checked.claim.quantity,
            Quantity::Plan | Quantity::Arithmetic
        )
        && !told.iter().any(is_told)
}

/// A sentence, list item or table row, and whether it is data: code or JSON.
pub struct Part {
    pub span: Range<usize>,
    pub is_data: bool,
}

/// The parts of a text, without the space around them; fences of code are none.
pub fn parts(text: &str) -> Vec<Part> {
    let mut found = Vec::new();
    let (mut at, mut is_code) = (0, false);
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let bare = line.trim_start();
        if bare.starts_with("```") {
            is_code = !is_code;
            continue;
        }
        let parts = if bare.starts_with('|') {
            vec![(0, line)]
        } else {
            find::sentences(line)
        };
        found.extend(parts.into_iter().map(|(from, part)| {
            let begin = start + from + (part.len() - part.trim_start().len());
            Part {
                span: begin..start + from + part.trim_end().len(),
                is_data: is_code || part.trim_start().starts_with(['{', '}', '"', '[', ']']),
            }
        }));
    }
    found
}

/// Whether a text in lower case states something of a scene: a heading, a plan or advice does not.
fn states(lower: &str) -> bool {
    if is_foreign(lower) {
        return true;
    }
    let has_unit = numbers(lower)
        .iter()
        .any(|number| number.unit != Unit::None && !is_time(lower, number));
    has_unit || { words(lower) }.any(|(_, word)| begins(word, MOVING) || begins(word, PLACED))
}

/// Whether a number says when or how long.
fn is_time(lower: &str, number: &Number) -> bool {
    const BEFORE: [&str; 20] = [
        "at", "t =", "t=", "time", "until", "after", "from", "to", "step", "(", "last", "within",
        "for", "over", "past", "every", "next", "per", "in", "one",
    ];
    let before = lower[..number.span.start].trim_end();
    number.unit == Unit::Second && BEFORE.iter().any(|word| before.ends_with(word))
}

/// Whether something that a sentence states is in none of its claims.
fn is_left_over(lower: &str, begin: usize, claims: &[CheckedClaim]) -> bool {
    let covers = |span: &Range<usize>| {
        claims.iter().any(|checked| {
            let own = &checked.claim.span;
            own.start < begin + span.end && begin + span.start < own.end
        })
    };
    let numbers = numbers(lower);
    let number = numbers.iter().any(|number| {
        number.unit != Unit::None && !is_time(lower, number) && !covers(&number.span)
    });
    // "Only 301 is ahead", "the only one ahead": of the others it is not read.
    let is_alone = lower.match_indices("only ").any(|(at, only)| {
        let next = lower[at + only.len()..]
            .split(|c: char| !c.is_alphanumeric())
            .next()
            .unwrap_or_default();
        const LENGTHS: [&str; 14] = [
            "about", "just", "half", "a", "some", "roughly", "around", "at", "by", "with", "in",
            "slightly", "now", "slowly",
        ];
        let is_value = numbers
            .iter()
            .any(|n| n.unit != Unit::None && n.span.start == at + only.len());
        !is_value && !LENGTHS.contains(&next)
    });
    let unread = ["ft", "feet", "hundred", "thousand", "mm", "ms"];
    let unread = unread
        .iter()
        .any(|word| find_word(lower, word).is_some_and(|at| !covers(&(at..at + word.len()))));
    // A clause with a claim is understood, but for what moves or touches beside it.
    let cells = lower.match_indices('|').map(|(at, _)| at + 1);
    let cells: Vec<usize> = std::iter::once(0).chain(cells).collect();
    let cells = { cells.iter().enumerate() }.map(|(place, from)| {
        let to = cells.get(place + 1).map_or(lower.len(), |next| next - 1);
        (*from, &lower[*from..to])
    });
    let parts = cells.flat_map(|(at, cell)| {
        let parts = clauses(cell).into_iter();
        parts.map(move |(from, clause)| (at + from, clause))
    });
    // What stands before the first colon is a label, where it says nothing.
    let label = lower.find(':').unwrap_or(0);
    let says = |text: &str| {
        ["is", "are", "has", "have"]
            .iter()
            .any(|verb| has_word(text, verb))
    };
    let label = if says(&lower[..label]) { 0 } else { label };
    let is_timed = claims.iter().any(|checked| {
        let quantity = checked.claim.quantity;
        matches!(
            quantity,
            Quantity::Ttc | Quantity::TtcLong | Quantity::TtcLat
        )
    });
    let clause = { parts }.any(|(from, clause)| {
        // "Speeds: ego (9.1 m/s)": the number of the bracket is of its noun.
        let opens = usize::from(clause.ends_with('('));
        let has_claim = covers(&(from..from + clause.len() + opens));
        let is_vague = is_vague(clause);
        { words(clause) }.any(|(at, word)| {
            let own = from + at..from + at + word.len();
            let before = clause[..at].trim_end_matches([' ', '-']);
            let is_time = ["time to", "time-to"]
                .iter()
                .any(|words| before.ends_with(words));
            (begins(word, MOVING) || !has_claim && begins(word, PLACED) && !is_vague)
                && own.start >= label
                && !(is_time && is_timed)
                && !covers(&own)
                && !is_of_number(clause, at, word)
        }) && !is_comment(clause, has_claim)
    });
    number || unread || is_alone || clause
}

/// The clauses of a sentence with the places where they begin.
fn clauses(lower: &str) -> Vec<(usize, &str)> {
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

/// Whether a word belongs to a number beside it: "3 m away", "a closing speed of 2 m/s".
fn is_of_number(clause: &str, at: usize, word: &str) -> bool {
    let (before, after) = (
        clause[..at].trim_end(),
        clause[at + word.len()..].trim_start(),
    );
    let has_unit = ["m", "cm", "km", "meters", "metres", "meter", "metre"]
        .iter()
        .any(|unit| {
            before
                .strip_suffix(unit)
                .is_some_and(|rest| rest.trim_end().ends_with(|c: char| c.is_ascii_digit()))
        });
    word == "away" && (has_unit || before.ends_with("far"))
        || ["speed", "velocity"]
            .iter()
            .any(|noun| after.starts_with(noun))
}

fn begins(word: &str, stems: &[&str]) -> bool {
    stems.iter().any(|stem| word.starts_with(stem))
}

/// Whether a clause says of a quantity only how large it seems: "the lateral distance is significant".
fn is_vague(clause: &str) -> bool {
    const SIZES: [&str; 22] = [
        "large",
        "small",
        "significant",
        "safe",
        "sufficient",
        "minimal",
        "negligible",
        "low",
        "high",
        "moderate",
        "short",
        "long",
        "adequate",
        "considerable",
        "substantial",
        "close",
        "manageable",
        "far",
        "great",
        "slow",
        "fast",
        "tight",
    ];
    let has_number = clause.contains(|c: char| c.is_ascii_digit());
    !has_number && SIZES.iter().any(|word| has_word(clause, word))
}

/// Whether a clause without a claim says what another means: "indicating a low risk".
fn is_comment(clause: &str, has_claim: bool) -> bool {
    !has_claim
        && [
            "indicating",
            "suggesting",
            "which means",
            "meaning",
            "posing",
            "poses",
        ]
        .iter()
        .any(|word| has_word(clause, word))
        && !numbers(clause)
            .iter()
            .any(|number| number.unit != Unit::None)
}

/// The words of a text with their places.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    // "ZAM_CutIn-1" is a name.
    let is_letter = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    text.split(move |c: char| !is_letter(c)).map(move |word| {
        let from = at;
        at += word.len();
        at += text[at..].chars().next().map_or(0, char::len_utf8);
        (from, word)
    })
}
