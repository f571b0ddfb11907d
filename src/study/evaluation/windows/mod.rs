//! Windows of an evaluation: dangerous ones at their leads, and safe ones drawn to look like them.
//!
//! A window of the safety task is *dangerous* if the ego touches another body within the horizon after its last step,
//! and *safe* if the recording goes on for the whole horizon and shows that it does not. One of the collision task is
//! dangerous if the ego touches another body in it. Of each scenario that collides, one dangerous window is taken for
//! each lead. Each gets a safe window that is like it, of a scenario without a collision or from long before one: where
//! in the recording a window lies, how long it is, how much traffic is in it and how fast the ego drives are to say
//! nothing about the answer.

mod matching;
mod recording;

pub use matching::MATCHED_ON;
pub use recording::{CLEAR, Recording, Traffic};

use std::collections::BTreeSet;

use super::{Case, Label, Lead, Scored};
use matching::{Candidate, Source};
use nearmiss_scene::scenario::Window;
use strum::{IntoStaticStr, VariantArray};

/// The lead of batches that name none: late enough to be seen, early enough to brake.
pub const LEAD: Lead = Lead::Seconds(1.0);

/// How far after its last step the truth of a window looks in batches that say nothing else, seconds: as far as the
/// built-in judge.
pub const WITHIN: f64 = Case::HORIZON;

/// The rules of an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Protocol {
    /// Dangerous windows at a lead before the contact, and safe windows like them.
    #[default]
    Matched,
    /// Those of "From Words to Collisions": one window of each recording ([`Labelled::paper_window`]), and a yes of the
    /// safety task counts only if it names the obstacle that collides ([`Scored::require_naming`]).
    ///
    /// [`Labelled::paper_window`]: crate::evaluation::Labelled::paper_window
    /// [`Scored::require_naming`]: crate::evaluation::Scored::require_naming
    Paper,
}

impl Protocol {
    /// Makes an answer what counts as one.
    pub fn count(self, answer: &mut Scored) {
        if self == Self::Paper {
            answer.require_naming();
        }
    }
}

nearmiss_record::named!(Protocol, "protocol");

/// What windows are drawn for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// The safety task at this lead.
    Before(Lead),
    /// The collision task: dangerous windows hold the first contact.
    Contact,
}

/// By what the windows of an evaluation are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// What for.
    pub moment: Moment,
    /// Steps in a window, at least one; fewer where a recording begins later.
    pub history: usize,
    /// How far after its last step the truth of a window looks, seconds; of the collision task not at all.
    pub horizon: f64,
    /// Whether every safe recording has a window, also those for which no dangerous one is left: the one that is most
    /// like any of these.
    pub every_recording: bool,
}

/// A window that is asked about, and what is true about it.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledWindow {
    /// The place of its recording among those it was drawn from.
    pub recording: usize,
    /// Its steps.
    pub window: Window,
    /// Whether it is dangerous, and the obstacle of the truth.
    pub label: Label,
    /// Obstacles that the ego touches in the window or within the horizon, the first one first.
    pub critical: Vec<i64>,
}

/// Blocks that are matched each by itself have at most so many pairs of windows and recordings: the time of an
/// assignment grows with the cube of its size.
const MAX_PAIRS: usize = 1_000_000;

impl Sampling {
    /// Draws the windows. The same recordings, in whatever order, give the same ones. Where there is no collision, of
    /// every recording one safe window from anywhere.
    #[must_use]
    pub fn draw(&self, recordings: &[Recording]) -> Vec<SampledWindow> {
        let mut order: Vec<usize> = (0..recordings.len()).collect();
        order.sort_by(|&a, &b| recordings[a].name().cmp(recordings[b].name()));
        let dangerous = |&at: &usize| self.dangerous(at, &recordings[at]);
        let dangerous: Vec<SampledWindow> = order.iter().filter_map(dangerous).collect();
        let mut drawn: Vec<SampledWindow> = if order.iter().any(|&at| recordings[at].collides()) {
            self.like(&dangerous, &order, recordings)
        } else {
            let any = |&at: &usize| self.any(at, &recordings[at]);
            order.iter().filter_map(any).collect()
        };
        if self.every_recording {
            let others = self.others(&drawn, &dangerous, &order, recordings);
            drawn.extend(others);
        }
        drawn.extend(dangerous);
        drawn.sort_by_key(|one| (one.recording, one.window.last()));
        drawn
    }

    /// Safe windows that are like the dangerous ones.
    fn like(
        &self,
        dangerous: &[SampledWindow],
        order: &[usize],
        recordings: &[Recording],
    ) -> Vec<SampledWindow> {
        let pairs = dangerous.len() * order.len();
        let blocks = (pairs as f64 / MAX_PAIRS as f64).sqrt().ceil().max(1.0) as usize;
        let part = |all: usize, block: usize| all * block / blocks..all * (block + 1) / blocks;
        let mut drawn = Vec::new();
        for block in 0..blocks {
            let dangerous = &dangerous[part(dangerous.len(), block)];
            let targets = dangerous.iter();
            let targets: Vec<Candidate> = targets
                .map(|one| recordings[one.recording].candidate(&one.window))
                .collect();
            let places: Vec<usize> = order[part(order.len(), block)]
                .iter()
                .copied()
                .filter(|&at| self.moment != Moment::Contact || !recordings[at].collides())
                .collect();
            let sources: Vec<Source> = places
                .iter()
                .map(|&at| Source {
                    pool: self.pool(&recordings[at], &targets),
                    target: dangerous.iter().position(|one| one.recording == at),
                    collides: recordings[at].collides(),
                })
                .collect();
            for one in matching::matched(&targets, &sources) {
                let at = places[one.source];
                let window = recordings[at].window(one.window.last, one.window.steps);
                drawn.push(safe_window(at, window));
            }
        }
        drawn
    }

    /// Safe windows of the safe recordings that have none yet: of each the one that is most like a dangerous window.
    fn others(
        &self,
        drawn: &[SampledWindow],
        dangerous: &[SampledWindow],
        order: &[usize],
        recordings: &[Recording],
    ) -> Vec<SampledWindow> {
        let has: BTreeSet<usize> = drawn.iter().map(|one| one.recording).collect();
        let targets = dangerous.iter();
        let targets: Vec<Candidate> = targets
            .map(|one| recordings[one.recording].candidate(&one.window))
            .collect();
        let other = |&at: &usize| {
            let recording = &recordings[at];
            if recording.collides() || has.contains(&at) {
                return None;
            }
            match matching::nearest_to_any(&targets, &self.pool(recording, &targets)) {
                Some(one) => Some(safe_window(at, recording.window(one.last, one.steps))),
                None => self.any(at, recording),
            }
        };
        order.iter().filter_map(other).collect()
    }

    fn dangerous(&self, at: usize, recording: &Recording) -> Option<SampledWindow> {
        let window = recording.dangerous_window(self.moment, self.history)?;
        let (label, critical) = match self.moment {
            // The paper's windows end where the recording does, however early the contact was.
            Moment::Before(Lead::Paper) => recording.truth_of_all(),
            moment => recording.truth(moment, &window, self.horizon),
        };
        Some(SampledWindow {
            recording: at,
            window,
            label,
            critical,
        })
    }

    /// A safe window from anywhere in a recording, by its name alone.
    fn any(&self, at: usize, recording: &Recording) -> Option<SampledWindow> {
        let ends = recording.safe_ends(self.history, self.after());
        let place = recording.random().usize(0..ends.len().max(1));
        let last = *ends.get(place)?;
        Some(safe_window(at, recording.window(last, self.history)))
    }

    /// The safe windows of a recording that have as many steps as a target.
    fn pool(&self, recording: &Recording, targets: &[Candidate]) -> Vec<Candidate> {
        let lengths: BTreeSet<usize> = targets.iter().map(|target| target.steps).collect();
        let of = |&steps: &usize| {
            let ends = recording.safe_ends(steps, self.after()).into_iter();
            ends.map(move |last| recording.candidate(&recording.window(last, steps)))
        };
        lengths.iter().flat_map(of).collect()
    }

    fn after(&self) -> f64 {
        match self.moment {
            Moment::Before(_) => self.horizon,
            Moment::Contact => 0.0,
        }
    }
}

fn safe_window(recording: usize, window: Window) -> SampledWindow {
    SampledWindow {
        recording,
        window,
        label: Label::Safe,
        critical: Vec::new(),
    }
}
