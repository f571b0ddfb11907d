//! A generation in which a language model writes the attacks: its settings, progress and complete output.

use nearmiss_ask::prompts::Library;
use nearmiss_study::evaluation::Settings as Asked;
use nearmiss_study::evaluation::generating::{Authored, Method, Progress, Source};

/// The model that writes attacks, and its request settings.
#[derive(Debug, Clone)]
pub struct Writer {
    /// Its id, `provider/model`.
    pub model: String,
    /// The scenario's name in the store.
    pub name: String,
    /// The templates.
    pub library: Library,
    /// The user's settings for descriptions and techniques.
    pub settings: Asked,
    /// How often it is asked, and what for.
    pub method: Method,
    /// Whether it is asked even where the store has its answers.
    pub fresh: bool,
}

/// Progress of a model's authoring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AuthoringProgress {
    /// Votes for the attacker that were asked for.
    pub votes: u32,
    /// Votes in all.
    pub of_votes: u32,
    /// Conversations that have begun; 0 while the attacker is chosen.
    pub begun: u32,
    /// How often the last answer that was asked for had been sent back before.
    pub retry: u32,
    /// Motions that passed the gate.
    pub passed: u32,
    /// Answers that were refused.
    pub refused: u32,
    /// Motions that went back to the model with what came of the drive.
    pub told: u32,
    /// Whether the ego is driven against a motion now.
    pub driving: bool,
    /// Grades that were asked for, and motions in all that are to be graded.
    pub grades: (usize, usize),
    /// Conversations in all.
    pub of: u32,
}

impl AuthoringProgress {
    /// Takes note of what happens.
    pub fn hear(&mut self, progress: &Progress, method: &Method) {
        self.of = method.samples;
        match progress {
            Progress::Choosing { vote, of } => {
                self.votes = self.votes.max(vote + 1);
                self.of_votes = *of;
            }
            Progress::Writing { sample, retry } => {
                self.begun = self.begun.max(sample + 1);
                self.retry = *retry;
                self.driving = false;
            }
            Progress::Made(_) => self.passed += 1,
            Progress::Refused(_) => self.refused += 1,
            Progress::Driving(_) => self.driving = true,
            Progress::ToldOfDrive(_) => self.told += 1,
            Progress::Grading { motion, of } => {
                self.driving = false;
                self.grades = (self.grades.0.max(motion + 1), *of);
            }
            Progress::Ended { .. } => self.driving = false,
            Progress::Chosen(_) | Progress::Heard { .. } | Progress::Answered { .. } => {}
        }
    }
}

/// A model's choice and output.
#[derive(Debug)]
pub struct Authorship {
    /// Its id.
    pub model: String,
    /// The one obstacle that was allowed to attack.
    pub only: Option<i64>,
    /// Everything that it wrote; attacks that were driven against come first, the best of all first.
    pub authored: Authored,
    /// The answer that was taken.
    pub taken: Option<Source>,
}

impl Authorship {
    /// Why there is no variant.
    pub(super) fn nothing(&self) -> String {
        let (authored, model) = (&self.authored, &self.model);
        let (passed, answers) = (authored.attacks.len(), authored.candidates());
        if let (Some(why), 0) = (&authored.stopped, passed) {
            return format!("{model} wrote nothing: {why}");
        }
        if authored.choice.attacker.is_none() {
            return format!("{model} was not asked: no moving obstacle can come near the ego");
        }
        if passed > 0 {
            return format!(
                "{model} found nothing dangerous: {passed} of its {answers} motions passed the gate, but the ego got away or was only hit from behind"
            );
        }
        let last = authored
            .declined
            .last()
            .and_then(|d| d.refusals.first())
            .map_or(String::new(), |why| format!("; the last: {why}"));
        format!("{model} found nothing dangerous: all of its {answers} answers were rejected{last}")
    }

    /// Whether it could not do its work, and not only did it badly.
    #[must_use]
    pub fn failed(&self) -> bool {
        self.authored.stopped.is_some() && self.authored.attacks.is_empty()
    }
}
