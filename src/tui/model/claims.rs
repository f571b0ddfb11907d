//! The claims of the answers that are looked at, held against the geometry.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::{Model, Shown};
use crate::evaluation::claims::{Checked, Judgement};
use crate::text::visible;

/// Claims that are known, by what they were found in.
#[derive(Debug, Default)]
pub struct Claims {
    /// The newest last.
    known: Vec<(u64, Vec<Checked>)>,
    /// The picked one: in which text, and which of its claims.
    pub picked: Option<(u64, usize)>,
}

/// An answer as it is read: safe to show, in one piece.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// Reasoning and answer.
    pub text: String,
    /// The steps that it is about, where they are known.
    pub window: Option<(i64, i64)>,
    /// Whether all of it is here.
    pub whole: bool,
    /// Identifies text, window and scene.
    pub key: u64,
}

/// Texts whose claims are kept.
const MOST: usize = 12;

/// What stands between reasoning and answer.
const ANSWER: &str = "── answer ──";

/// What stands before reasoning.
const REASONING: &str = "── reasoning ──";

impl Claims {
    /// The claims of a text, in its order; none where they were not looked for.
    #[must_use]
    pub fn of(&self, key: u64) -> &[Checked] {
        let found = self.known.iter().find(|(known, _)| *known == key);
        found.map_or(&[], |(_, claims)| claims)
    }

    /// Whether they were looked for.
    #[must_use]
    pub fn is_known(&self, key: u64) -> bool {
        self.known.iter().any(|(known, _)| *known == key)
    }

    /// Takes the claims of a text.
    pub fn take(&mut self, key: u64, claims: Vec<Checked>) {
        if self.known.len() >= MOST {
            self.known.remove(0);
        }
        self.known.push((key, claims));
    }

    /// The picked claim of a text, by its place.
    #[must_use]
    pub fn picked_of(&self, key: u64) -> Option<usize> {
        self.picked
            .filter(|(of, _)| *of == key)
            .map(|(_, place)| place)
    }
}

/// How many are right, wrong, and cannot be told.
#[must_use]
pub fn counted(claims: &[Checked]) -> (usize, usize, usize) {
    let count = |is: fn(&Judgement) -> bool| claims.iter().filter(|c| is(&c.judgement)).count();
    (
        count(|j| *j == Judgement::Right),
        count(|j| *j == Judgement::Wrong),
        count(|j| matches!(j, Judgement::Unknown(_))),
    )
}

impl Model {
    /// An answer as it is read; nothing where there is none.
    #[must_use]
    pub fn document(&self, shown: Shown) -> Option<Document> {
        let (text, window, whole) = match shown {
            Shown::Reference => {
                let judgement = self.answers.reference.as_ref()?;
                let window = self.window().map(|w| (w.first(), w.last()));
                (visible(&judgement.reasoning).into_owned(), window, true)
            }
            Shown::Column(place) => {
                let column = self.answers.columns.get(place)?;
                let text = match (column.reasoning.is_empty(), column.text.is_empty()) {
                    (true, _) => column.text.clone(),
                    // The heading is there from the start, so that nothing moves when the answer begins.
                    (false, true) => format!("{REASONING}\n{}", column.reasoning),
                    (false, false) => format!(
                        "{REASONING}\n{}\n\n{ANSWER}\n{}",
                        column.reasoning, column.text
                    ),
                };
                (
                    visible(&text).into_owned(),
                    column.steps,
                    !column.is_running(),
                )
            }
        };
        let mut hasher = DefaultHasher::new();
        (&text, window).hash(&mut hasher);
        if let Some(scene) = self.scene() {
            scene.scenario.hash.to_string().hash(&mut hasher);
            scene.ego.to_string().hash(&mut hasher);
        }
        Some(Document {
            text,
            window,
            whole,
            key: hasher.finish(),
        })
    }
}
