//! What a tune is given, what it tells on the way, and how it fails.

use std::sync::Arc;

use super::candidate::{Candidate, Refusal};
use super::divide::DevPart;
use crate::batch::BatchControl;
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::{Judge, ModelJudge};

/// Who is asked, within one budget, and where answers are kept.
pub struct TuneModels {
    /// Who answers the questions.
    pub judge: Arc<Judge>,
    /// Who proposes templates.
    pub reflect: Box<ModelJudge>,
    /// Requests on their way at once.
    pub at_once: usize,
    /// Where answers are kept, and looked for.
    pub store: Arc<Store>,
    /// Stops the tune.
    pub control: BatchControl,
}

/// Events of a tune.
#[derive(Debug)]
pub enum TuneEvent<'a> {
    /// Questions are asked with a template.
    Asking {
        /// The number of the candidate; of a proposal the number that it will have.
        candidate: usize,
        /// About which part.
        part: DevPart,
        /// Answers so far.
        done: usize,
        /// Questions.
        of: usize,
    },
    /// A better template is asked for.
    Reflecting {
        /// The round, from 1.
        round: u32,
        /// The proposal in it, from 1.
        number: u32,
        /// The candidate that is to be bettered.
        parent: usize,
    },
    /// A proposal did not become a candidate.
    Refused(&'a Refusal),
    /// A candidate was asked with on the whole selection part.
    Compared(&'a Candidate),
}

/// Why there is no outcome.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    /// The user ended it.
    #[error("interrupted")]
    Interrupted,
    /// It ended before the base was measured.
    #[error("the base template could not be measured: {0}")]
    NoBase(String),
    /// The store refused.
    #[error(transparent)]
    Store(#[from] StoreError),
}
