//! Claims of the displayed answers, checked against the geometry.

use std::cell::RefCell;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

use crate::model::{Model, ShownAnswer};
use crate::widgets::long_text::{MarkedClaims, folds_at};
use nearmiss_study::evaluation::claims::{
    CheckedClaim, CheckedSentence, Judgement, TimeOrigin, shown_text,
};

/// Claims that are known, by what they were found in.
#[derive(Debug, Default)]
pub struct Claims {
    /// The newest last; `None` while they are being checked.
    known: Vec<(u64, Option<TextClaims>)>,
    /// The picked one: in which text, and which of its claims.
    pub picked: Option<(u64, usize)>,
    /// Answers that were read lately, beside what they were made of; the newest last.
    documents: RefCell<Vec<(Source, Arc<Document>)>>,
}

/// What was found in a text.
#[derive(Debug, Default)]
pub struct TextClaims {
    /// Its claims, in its order.
    pub checked: Vec<CheckedClaim>,
    /// The places of those that differ, the wrong ones first and the right ones last, and how often each stands there.
    pub listed: Vec<(usize, usize)>,
    /// Its sentences with an obstacle and a quantity that were not understood, bytes.
    pub unread: Vec<Range<usize>>,
}

impl TextClaims {
    /// Of the sentences of a text.
    #[must_use]
    pub fn new(sentences: Vec<CheckedSentence>) -> Self {
        let unread = { sentences.iter() }
            .filter(|one| one.claims.is_empty())
            .map(|one| one.span.clone())
            .collect();
        let checked: Vec<CheckedClaim> = { sentences.into_iter() }
            .flat_map(|one| one.claims)
            .collect();
        let mut listed: Vec<(usize, usize)> = Vec::new();
        for (place, claim) in checked.iter().enumerate() {
            let same = |other: &CheckedClaim| other.line() == claim.line();
            match listed.iter_mut().find(|(first, _)| same(&checked[*first])) {
                Some((_, times)) => *times += 1,
                None => listed.push((place, 1)),
            }
        }
        listed.sort_by_key(|(place, _)| match checked[*place].judgement {
            Judgement::Wrong => 0,
            Judgement::Unknown(_) => 1,
            Judgement::Right => 2,
        });
        Self {
            checked,
            listed,
            unread,
        }
    }
}

/// The parts of an answer as displayed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Parts<'a> {
    reasoning: &'a str,
    text: &'a str,
    window: Option<(i64, i64)>,
    times: TimeOrigin,
    complete: bool,
    /// As it was sent, its reasons inside its JSON.
    raw: bool,
}

/// The same, kept. To compare it costs little, to make the document of a long answer does not.
#[derive(Debug)]
struct Source {
    reasoning: String,
    text: String,
    window: Option<(i64, i64)>,
    times: TimeOrigin,
    complete: bool,
    raw: bool,
    scene: Option<(String, String)>,
}

impl Source {
    fn is(&self, parts: &Parts<'_>, scene: &Option<(String, String)>) -> bool {
        (self.window, self.times, self.complete, self.raw)
            == (parts.window, parts.times, parts.complete, parts.raw)
            && self.text == parts.text
            && self.reasoning == parts.reasoning
            && self.scene == *scene
    }
}

/// An answer as it is read: safe to show, in one piece.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document {
    /// Reasoning and answer.
    pub text: String,
    /// The steps that it is about, where they are known.
    pub window: Option<(i64, i64)>,
    /// What the times in it count from.
    pub times: TimeOrigin,
    /// Whether all of it is here.
    pub complete: bool,
    /// Identifies text, window and scene.
    pub key: u64,
}

impl Document {
    /// Whether a byte is in JSON that folds.
    #[must_use]
    pub fn folds_at(&self, byte: usize) -> bool {
        folds_at(&self.text, byte)
    }
}

/// Texts whose claims are kept.
const MAX_KEPT: usize = 100;

impl Claims {
    /// The claims of a text, in its order; none until they were checked.
    #[must_use]
    pub fn get(&self, key: u64) -> &[CheckedClaim] {
        self.found(key).map_or(&[], |claims| &claims.checked)
    }

    /// The places of the claims of a text that differ, the wrong ones first, and how often each stands there.
    #[must_use]
    pub fn listed(&self, key: u64) -> &[(usize, usize)] {
        self.found(key).map_or(&[], |claims| &claims.listed)
    }

    /// The sentences of a text that were not understood, bytes.
    #[must_use]
    pub fn unread(&self, key: u64) -> &[Range<usize>] {
        self.found(key).map_or(&[], |claims| &claims.unread)
    }

    fn found(&self, key: u64) -> Option<&TextClaims> {
        let mut known = self.known.iter();
        let (_, claims) = known.find(|(known, _)| *known == key)?;
        claims.as_ref()
    }

    /// Whether they were checked.
    #[must_use]
    pub fn is_known(&self, key: u64) -> bool {
        let known = |(known, claims): &(u64, Option<_>)| *known == key && claims.is_some();
        self.known.iter().any(known)
    }

    /// Notes that the claims of a text are being checked; whether that was not requested before.
    pub fn request(&mut self, key: u64) -> bool {
        if self.known.iter().any(|(known, _)| *known == key) {
            return false;
        }
        if self.known.len() >= MAX_KEPT {
            self.known.remove(0);
        }
        self.known.push((key, None));
        true
    }

    /// Takes the claims of a text that were requested.
    pub fn take(&mut self, key: u64, claims: TextClaims) {
        if let Some((_, place)) = self.known.iter_mut().find(|(known, _)| *known == key) {
            *place = Some(claims);
        }
    }

    /// What is marked in a text.
    #[must_use]
    pub fn marks(&self, key: u64) -> MarkedClaims<'_> {
        MarkedClaims {
            claims: self.get(key),
            key,
            picked: self.picked_of(key),
            unread: self.unread(key),
        }
    }

    /// The picked claim of a text, by its place.
    #[must_use]
    pub fn picked_of(&self, key: u64) -> Option<usize> {
        self.picked
            .filter(|(of, _)| *of == key)
            .map(|(_, place)| place)
    }
}

impl Model {
    /// An answer as it is read; `None` if there is none.
    #[must_use]
    pub fn document(&self, shown: ShownAnswer) -> Option<Arc<Document>> {
        let parts = match shown {
            ShownAnswer::Reference => Parts {
                reasoning: "",
                text: &self.answers.reference.as_ref()?.reasoning,
                window: self.window().map(|w| (w.first(), w.last())),
                times: TimeOrigin::Recording,
                complete: true,
                raw: true,
            },
            ShownAnswer::Column(place) => {
                let column = self.answers.columns.get(place)?;
                // That a model reasons at all tells its kind; what says nothing else is shown all the same.
                let hides = self.compare.hides() && !column.text.trim().is_empty();
                Parts {
                    reasoning: if hides { "" } else { &column.reasoning },
                    text: &column.text,
                    window: column.steps,
                    times: column.times,
                    complete: !column.is_running(),
                    raw: self.reading.raw,
                }
            }
        };
        let scene = self
            .scene()
            .map(|s| (s.scenario.hash.to_string(), s.ego.to_string()));
        let mut kept = self.claims.documents.borrow_mut();
        if let Some((_, known)) = kept.iter().find(|(source, _)| source.is(&parts, &scene)) {
            return Some(known.clone());
        }
        let document = Arc::new(document(&parts, scene.as_ref()));
        if kept.len() >= MAX_KEPT {
            kept.remove(0);
        }
        let source = Source {
            reasoning: parts.reasoning.into(),
            text: parts.text.into(),
            window: parts.window,
            times: parts.times,
            complete: parts.complete,
            raw: parts.raw,
            scene,
        };
        // Of one that arrives the latest state is enough.
        kept.retain(|(s, _)| s.complete || !source.text.starts_with(&s.text));
        kept.push((source, document.clone()));
        Some(document)
    }
}

fn document(parts: &Parts<'_>, scene: Option<&(String, String)>) -> Document {
    let Parts {
        reasoning,
        text,
        window,
        times,
        complete,
        raw,
    } = *parts;
    let text = shown_text(reasoning, text, raw);
    let mut hasher = DefaultHasher::new();
    (&text, window, times).hash(&mut hasher);
    if let Some((scenario, ego)) = scene {
        scenario.hash(&mut hasher);
        ego.hash(&mut hasher);
    }
    Document {
        text,
        window,
        times,
        complete,
        key: hasher.finish(),
    }
}
