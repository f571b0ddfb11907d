//! A second reader: sentences that the rules do not understand, put into the claim language by a model; geometry decides.
//!
//! What a model writes is read by the same rules, and a number that the sentence does not have is refused: a translation can
//! leave something out, but not make up a value.

use std::ops::Range;

use nearmiss_scene::verdict::object_in;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::find::{LONGEST_SENTENCE, LONGEST_TEXT};
use super::language::{samples, written};
use super::number::{Unit, WORDS, numbers};
use super::tokens::has_word;
use super::{
    CheckedClaim, CheckedSentence, Claim, ClaimedValue, Judgement, SentenceOutcome, Subject,
    TimeOrigin, sentences,
};

/// Sentences in a question at most.
const MOST: usize = 16;

/// Bytes before the first sentence of a question that are quoted: they say who "it" is.
const BEFORE: usize = 1500;

/// Some sentences of a text that were not understood, as a model is asked about them.
#[derive(Debug, Clone, PartialEq)]
pub struct Untranslated {
    /// Their places among the sentences of the text.
    pub places: Vec<usize>,
    /// The part of the text that is quoted, bytes.
    quoted: Range<usize>,
    /// What the model is told of the task.
    pub system: String,
    /// The quoted text with the sentences marked, and who is there.
    pub user: String,
}

/// What a model answers: the claims of each marked sentence.
#[derive(Debug, Deserialize, Serialize, JsonSchema)]
struct Translations {
    sentences: Vec<Translation>,
}

/// A marked sentence in the claim language.
#[derive(Debug, Deserialize, Serialize, JsonSchema)]
struct Translation {
    /// Its number.
    number: usize,
    /// Its claims, a sentence of the claim language each; none where it says nothing of the scene.
    claims: Vec<String>,
}

/// The form of an answer, as a JSON schema.
#[must_use]
pub fn translation_schema() -> Value {
    schemars::schema_for!(Translations).to_value()
}

/// The questions about the sentences of a text that were not understood.
#[must_use]
pub fn untranslated(
    text: &str,
    found: &[CheckedSentence],
    subject: &Subject<'_>,
) -> Vec<Untranslated> {
    let places: Vec<usize> = { found.iter().enumerate() }
        .filter(|(_, one)| one.outcome == SentenceOutcome::NotUnderstood)
        .filter(|(_, one)| one.span.len() <= LONGEST_SENTENCE && one.span.end <= LONGEST_TEXT)
        .map(|(place, _)| place)
        .collect();
    let mut all = Vec::new();
    let mut rest = places.as_slice();
    while let [first, ..] = rest {
        // Far sentences are quoted apart, so that what is between them costs nothing.
        let begin = found[*first].span.start;
        let many = { rest.iter().take(MOST) }
            .take_while(|place| found[**place].span.end - begin <= 4 * BEFORE)
            .count()
            .max(1);
        let (own, later) = rest.split_at(many);
        all.push(Untranslated::new(text, found, own, subject));
        rest = later;
    }
    all
}

impl Untranslated {
    fn new(text: &str, found: &[CheckedSentence], own: &[usize], subject: &Subject<'_>) -> Self {
        let spans: Vec<&Range<usize>> = own.iter().map(|place| &found[*place].span).collect();
        let (begin, end) = match (spans.first(), spans.last()) {
            (Some(first), Some(last)) => (first.start, last.end),
            _ => (0, 0),
        };
        let from = text.floor_char_boundary(begin.saturating_sub(BEFORE));
        let mut quoted = String::new();
        let mut at = from;
        for (number, span) in spans.iter().enumerate() {
            let number = number + 1;
            quoted += &text[at..span.start];
            quoted += &format!("⟦{number}: {}⟧", &text[(*span).clone()]);
            at = span.end;
        }
        Self {
            places: own.to_vec(),
            quoted: from..end,
            system: system(),
            user: format!("{}\n\nThe text:\n\n{quoted}\n", scene(subject)),
        }
    }

    /// Whether an answer is of the form that was asked for.
    #[must_use]
    pub fn is_answer(answer: &str) -> bool {
        translations(answer).is_ok()
    }

    /// Reads a model's answer into the sentences; how many were put into claims. What is no sentence of the language is left
    /// out, and the sentence stays not understood.
    ///
    /// # Errors
    /// The answer is not of the form that was asked for.
    pub fn read(
        &self,
        (text, found): (&str, &mut [CheckedSentence]),
        answer: &str,
        subject: &Subject<'_>,
    ) -> Result<usize, String> {
        let mut read = 0;
        for one in translations(answer)? {
            let place = one.number.checked_sub(1).and_then(|n| self.places.get(n));
            let sentence = place.and_then(|place| found.get_mut(*place));
            // A sentence is translated once.
            let Some(sentence) = sentence.filter(|one| one.translated.is_empty()) else {
                continue;
            };
            let known = Known {
                sentence: &text[sentence.span.clone()],
                quoted: &text[self.quoted.clone()],
            };
            read += usize::from(known.add(sentence, &one.claims, subject));
        }
        Ok(read)
    }
}

fn translations(answer: &str) -> Result<Vec<Translation>, String> {
    let object = object_in(answer).ok_or("no JSON object in the answer")?;
    let all: Translations = serde_json::from_value(object).map_err(|why| why.to_string())?;
    Ok(all.sentences)
}

/// What a translation may take its numbers from.
struct Known<'a> {
    sentence: &'a str,
    quoted: &'a str,
}

impl Known<'_> {
    /// Adds the claims of a translation to a sentence; whether it is understood now.
    fn add(&self, sentence: &mut CheckedSentence, said: &[String], subject: &Subject<'_>) -> bool {
        let mut is_whole = !said.is_empty();
        let mut claims = Vec::new();
        for one in said {
            let one = one.trim();
            let own = self.heard(one, subject);
            is_whole &= !own.is_empty() && { own.iter() }.all(CheckedSentence::is_understood);
            for mut claim in own.into_iter().flat_map(|one| one.claims) {
                claim.claim.span = sentence.span.clone();
                let is_there =
                    { sentence.claims.iter().chain(&claims) }.any(|c| is_same(c, &claim));
                if !is_there {
                    claims.push(claim);
                }
            }
            sentence.translated.push(one.to_owned());
        }
        sentence.claims.extend(claims);
        let has = |is: fn(&Judgement) -> bool| sentence.claims.iter().any(|c| is(&c.judgement));
        sentence.outcome = if has(|j| *j == Judgement::Wrong) {
            SentenceOutcome::Wrong
        } else if has(|j| matches!(j, Judgement::Unknown(_))) {
            SentenceOutcome::Open
        } else if is_whole && !sentence.claims.is_empty() {
            SentenceOutcome::Right
        } else {
            SentenceOutcome::NotUnderstood
        };
        sentence.is_understood()
    }

    /// What the rules make of a sentence of the language; nothing where it has numbers of its own.
    fn heard(&self, said: &str, subject: &Subject<'_>) -> Vec<CheckedSentence> {
        if said.len() > LONGEST_SENTENCE || said.contains('\n') {
            return Vec::new();
        }
        let told = values(self.sentence);
        // Times and steps may stand above the sentence.
        let quoted = values(self.quoted);
        let is_known = numbers(said).iter().all(|number| {
            let before = said[..number.span.start].trim_end().to_lowercase();
            let is_id = before.ends_with("obstacle") && number.unit == Unit::None;
            let among = match number.unit {
                Unit::Second | Unit::None => &quoted,
                _ => &told,
            };
            let mut among = among.iter();
            is_id || among.any(|value| (value.abs() - number.value.abs()).abs() < 1e-9)
        });
        if is_known {
            sentences(said, subject)
        } else {
            Vec::new()
        }
    }
}

/// The numbers of a text, with points and with commas before their decimals, and those in words.
fn values(text: &str) -> Vec<f64> {
    let lower = text.to_lowercase();
    let in_words = { WORDS.iter() }
        .filter(|(word, _)| has_word(&lower, word))
        .map(|(_, value)| *value);
    let none = has_word(&lower, "no").then_some(0.0);
    let all = numbers(text)
        .into_iter()
        .chain(numbers(&text.replace(',', ".")));
    all.map(|number| number.value)
        .chain(in_words)
        .chain(none)
        .collect()
}

/// Whether two claims say the same.
fn is_same(one: &CheckedClaim, other: &CheckedClaim) -> bool {
    let (a, b) = (&one.claim, &other.claim);
    a.obstacle == b.obstacle && a.quantity == b.quantity && a.stated == b.stated && a.step == b.step
}

/// What a model is told of the task.
fn system() -> String {
    let is_denied = |claim: &Claim| {
        matches!(
            claim.stated,
            ClaimedValue::Word {
                is_denied: true,
                ..
            }
        )
    };
    let examples: Vec<String> = { samples(7, 8, 0).into_iter() }
        .filter(|claim| !is_denied(claim))
        .map(|claim| format!("- {}", written(&claim)))
        .collect();
    format!(
        "\
You translate sentences about a traffic scene into a small language of claims. A program checks the claims; you do not.

The text was written about one moment of a recorded scene with an ego vehicle and obstacles. Sentences between ⟦n: and ⟧ are to be \
translated; the rest tells who \"it\" is and when. Of each marked sentence write what it states about the scene, a sentence of the \
language for each claim:

{}

Rules:
- What has no number can be denied: \"Obstacle 7 is not braking.\", \"Obstacle 7 does not touch the ego.\"
- Write only what the sentence states, true or not. Do not judge, correct, complete or compute.
- Copy numbers and units as they are in the sentence (50 km/h stays 50 km/h); add none.
- Name obstacles by their ids, also where the sentence says \"the lead vehicle\" or \"it\"; leave out a claim whose obstacle is not clear.
- Begin with \"At 2.4 s,\" or \"At step 24,\" where the text names another time than the present, as it is written there.
- No claims for opinions, advice, plans, conditions, rules and questions.
- A sentence of which the language cannot hold a part: write the claims that it can hold, and \"?\" for the part.

Answer with one JSON object: {{\"sentences\": [{{\"number\": 1, \"claims\": [\"…\"]}}]}}",
        examples.join("\n")
    )
}

/// Who is there, and when it is.
fn scene(subject: &Subject<'_>) -> String {
    let scene = subject.scene;
    let present = subject.present();
    let when = match subject.times {
        TimeOrigin::Recording => format!("step {present}, {:.1} s", scene.time_of(present)),
        TimeOrigin::WindowEnd => "0 s; earlier times are negative".into(),
    };
    let all = scene.scenario.obstacles.iter();
    let all: Vec<String> = all
        .map(|one| format!("{} ({})", one.id, one.kind))
        .collect();
    format!(
        "The present is {when}. A step is {} s. The ego's id is {}. Obstacles: {}.",
        scene.scenario.dt(),
        scene.ego.id,
        all.join(", ")
    )
}
