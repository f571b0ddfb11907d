//! Why a changed motion is refused.

use crate::planner::{Bound, Broken};

/// What is wrong with a changed motion, or with the answer that was to give one.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// What is wrong.
    pub reason: Reason,
    /// The time step at which it is; of what concerns no step none.
    pub step: Option<i64>,
    /// The value that was found, in the unit of the reason.
    pub value: Option<f64>,
    /// The most that is allowed, in the same unit.
    pub limit: Option<f64>,
}

/// The kinds of reasons.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// It does not begin exactly at a recorded state: metres, radians or m/s off, as the name in it says.
    Start(&'static str),
    /// A single-track vehicle of its kind cannot drive it.
    Kinematics(Bound),
    /// The acceleration changes too fast, m/s³.
    Jerk,
    /// It moves across its heading: the angle between the displacement and what the heading allows, radians.
    Heading,
    /// The said velocity is not that of the displacement, m/s.
    Velocity,
    /// A step is missing in it, or it ends before it begins.
    Gap,
    /// Part of the body leaves the road, metres.
    OffRoad,
    /// The body overlaps somebody other than the ego, by id.
    Overlap(i64),
    /// The body overlaps the ego where its motion still is the recorded one.
    OverlapsEgo,
    /// A number that is none.
    NotANumber,
    /// What an answer says cannot be made into a motion: in words.
    Answer(String),
}

impl Reason {
    /// Its name in documents.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Start(_) => "start",
            Self::Kinematics(bound) => bound.name(),
            Self::Jerk => "jerk",
            Self::Heading => "heading along motion",
            Self::Velocity => "velocity of the displacement",
            Self::Gap => "gap",
            Self::OffRoad => "off road",
            Self::Overlap(_) => "overlap",
            Self::OverlapsEgo => "overlap with the ego",
            Self::NotANumber => "not a number",
            Self::Answer(_) => "answer",
        }
    }

    /// The unit of value and limit.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Start("heading") | Self::Heading => "rad",
            Self::Start("velocity") | Self::Velocity => "m/s",
            Self::Start(_) | Self::OffRoad => "m",
            Self::Kinematics(bound) => bound.unit(),
            Self::Jerk => "m/s³",
            Self::Gap
            | Self::Overlap(_)
            | Self::OverlapsEgo
            | Self::NotANumber
            | Self::Answer(_) => "",
        }
    }
}

impl Refusal {
    /// What cannot be made into a motion, in words.
    #[must_use]
    pub fn answer(words: impl Into<String>) -> Self {
        Self {
            reason: Reason::Answer(words.into()),
            step: None,
            value: None,
            limit: None,
        }
    }
}

impl From<Broken> for Refusal {
    fn from(broken: Broken) -> Self {
        Self {
            reason: Reason::Kinematics(broken.bound),
            step: Some(broken.step),
            value: Some(broken.value),
            limit: Some(broken.most),
        }
    }
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(step) = self.step {
            write!(f, "step {step}: ")?;
        }
        match &self.reason {
            Reason::Start(what) => write!(f, "{what} at the start is not the recorded one")?,
            Reason::Overlap(id) => write!(f, "overlap with {id}")?,
            Reason::Answer(words) => f.write_str(words)?,
            other => f.write_str(other.name())?,
        }
        let unit = self.reason.unit();
        let space = if unit.is_empty() { "" } else { " " };
        if let Some(value) = self.value {
            write!(f, " {value:.4}{space}{unit}")?;
        }
        if let Some(limit) = self.limit {
            write!(f, ", at most {limit:.4}")?;
        }
        Ok(())
    }
}
