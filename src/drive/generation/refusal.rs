//! Why the gate refuses a changed motion, and the worst of each reason.

use super::ChangeError;
use crate::planner::{Bound, Broken};

/// Why a changed motion, or the answer meant to give one, is refused.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// The reason.
    pub reason: Reason,
    /// The time step at which it is; of what concerns no step none.
    pub step: Option<i64>,
    /// The value that was found, in the unit of the reason.
    pub value: Option<f64>,
    /// The most that is allowed, in the same unit.
    pub limit: Option<f64>,
    /// The obstacle, where known.
    pub attacker: Option<i64>,
    /// The kind of motion, where known: see [`nearmiss_scene::verdict::Motion::name`].
    pub manoeuvre: Option<&'static str>,
}

/// The kinds of reasons.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// It does not begin exactly at a recorded state: metres, radians or m/s off, as the name in it says.
    Start(&'static str),
    /// A single-track vehicle of its kind cannot drive it.
    Kinematics(Bound),
    /// No obstacle's motion can be changed this way.
    Obstacle(ChangeError),
    /// This obstacle does not move by itself, or has no body of one size.
    Unable(i64),
    /// It speeds up more than people do, m/s².
    SpeedingUp,
    /// Its acceleration across the heading is more than people bear, m/s².
    Lateral,
    /// The acceleration changes too fast, m/s³.
    Jerk,
    /// The said acceleration is neither that of the step before nor that of the step after, m/s².
    Acceleration,
    /// It moves across its heading: the angle between the displacement and what the heading allows, radians.
    Heading,
    /// The said velocity is not that of the displacement, m/s.
    Velocity,
    /// It is farther on than its speed can have brought it: the displacement of the centre, metres.
    Jump,
    /// A step is missing in it, or it ends before it begins.
    Gap,
    /// Part of the body leaves the road, metres.
    OffRoad,
    /// The body overlaps an obstacle other than the ego, by id.
    Overlap(i64),
    /// The body overlaps the ego where its motion still is the recorded one.
    OverlapsEgo,
    /// A number that is none.
    NotANumber,
    /// This obstacle of the original is not in the variant.
    Missing(i64),
    /// This obstacle of the variant is not in the original.
    Added(i64),
    /// This obstacle is of another type, role or shape in the variant, or has its id twice.
    Reshaped(i64),
    /// More obstacles' motions were changed than may be.
    Several,
    /// No obstacle moves in another way in the variant.
    Unchanged,
    /// Another difference from the original.
    Differs(&'static str),
    /// An answer cannot be made into a motion, and why.
    Answer(String),
}

impl Reason {
    /// Its name in documents.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Start(_) => "start",
            Self::Kinematics(bound) => bound.name(),
            Self::Obstacle(_) | Self::Unable(_) => "obstacle",
            Self::SpeedingUp => "speeding up",
            Self::Lateral => "lateral acceleration",
            Self::Jerk => "jerk",
            Self::Acceleration => "said acceleration",
            Self::Heading => "heading along motion",
            Self::Velocity => "velocity of the displacement",
            Self::Jump => "jump",
            Self::Gap => "gap",
            Self::OffRoad => "off road",
            Self::Overlap(_) => "overlap",
            Self::OverlapsEgo => "overlap with the ego",
            Self::NotANumber => "not a number",
            Self::Missing(_) => "missing obstacle",
            Self::Added(_) => "added obstacle",
            Self::Reshaped(_) => "changed obstacle",
            Self::Several => "several changed obstacles",
            Self::Unchanged => "nothing changed",
            Self::Differs(_) => "changed scenario",
            Self::Answer(_) => "answer",
        }
    }

    /// The unit of value and limit.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Start("heading") | Self::Heading => "rad",
            Self::Start("velocity") | Self::Velocity => "m/s",
            Self::Start(_) | Self::Jump | Self::OffRoad => "m",
            Self::Kinematics(bound) => bound.unit(),
            Self::Jerk => "m/s³",
            Self::Acceleration | Self::SpeedingUp | Self::Lateral => "m/s²",
            Self::Gap => "steps",
            Self::Several => "obstacles",
            Self::Obstacle(_)
            | Self::Unable(_)
            | Self::Overlap(_)
            | Self::OverlapsEgo
            | Self::NotANumber
            | Self::Missing(_)
            | Self::Added(_)
            | Self::Reshaped(_)
            | Self::Unchanged
            | Self::Differs(_)
            | Self::Answer(_) => "",
        }
    }
}

impl Refusal {
    /// Refuses an answer that cannot be made into a motion, and says why.
    #[must_use]
    pub fn answer(words: impl Into<String>) -> Self {
        Self::whole_motion(Reason::Answer(words.into()))
    }

    /// A refusal without a step.
    #[must_use]
    pub fn whole_motion(reason: Reason) -> Self {
        Self {
            reason,
            step: None,
            value: None,
            limit: None,
            attacker: None,
            manoeuvre: None,
        }
    }

    /// A refusal at a step.
    #[must_use]
    pub fn at(step: i64, reason: Reason) -> Self {
        Self {
            step: Some(step),
            ..Self::whole_motion(reason)
        }
    }

    /// The same with a value and its limit.
    #[must_use]
    pub fn with(self, value: f64, limit: f64) -> Self {
        Self {
            value: Some(value),
            limit: Some(limit),
            ..self
        }
    }

    /// The same with whose motion it is, and of what kind where there is one.
    #[must_use]
    pub fn about(self, attacker: i64, manoeuvre: Option<&'static str>) -> Self {
        Self {
            attacker: Some(attacker),
            manoeuvre,
            ..self
        }
    }
}

impl From<Broken> for Refusal {
    fn from(broken: Broken) -> Self {
        Self::at(broken.step, Reason::Kinematics(broken.bound)).with(broken.value, broken.most)
    }
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(step) = self.step {
            write!(f, "step {step}: ")?;
        }
        match &self.reason {
            Reason::Start(what) => write!(f, "{what} at the start differs from the recorded one")?,
            Reason::Overlap(id) => write!(f, "overlap with {id}")?,
            Reason::Obstacle(why) => write!(f, "{why}")?,
            Reason::Unable(id) => write!(
                f,
                "obstacle {id} does not move by itself, or its body has no fixed size"
            )?,
            Reason::Missing(id) => write!(f, "obstacle {id} of the original is missing")?,
            Reason::Added(id) => write!(f, "obstacle {id} is not in the original")?,
            Reason::Reshaped(id) => {
                write!(f, "obstacle {id} has another type, role or shape")?;
            }
            Reason::Unchanged => f.write_str("no obstacle moves differently from the original")?,
            Reason::Differs(what) => write!(f, "{what} differs from the original")?,
            Reason::Answer(words) => f.write_str(words)?,
            other => f.write_str(other.name())?,
        }
        // Things that are counted have no digits after the point.
        if let (Reason::Several | Reason::Gap, Some(value)) = (&self.reason, self.value) {
            let of = match self.reason {
                Reason::Gap => " steps",
                _ => "",
            };
            write!(f, ": {value:.0}{of}")?;
            return self
                .limit
                .map_or(Ok(()), |limit| write!(f, ", at most {limit:.0}"));
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

/// All refusals for one reason.
#[derive(Debug, Clone, PartialEq)]
pub struct RefusalSummary {
    /// The one that is farthest above its limit; of those without numbers the first.
    pub worst: Refusal,
    /// How many there are.
    pub count: usize,
    /// The first step of them, where they concern steps.
    pub first: Option<i64>,
}

/// Refusals summed up by their reasons, in the order in which these come first.
#[must_use]
pub fn summarize(refusals: &[Refusal]) -> Vec<RefusalSummary> {
    let mut all: Vec<RefusalSummary> = Vec::new();
    for refusal in refusals {
        let same = |s: &&mut RefusalSummary| s.worst.reason == refusal.reason;
        let Some(known) = all.iter_mut().find(same) else {
            all.push(RefusalSummary {
                worst: refusal.clone(),
                count: 1,
                first: refusal.step,
            });
            continue;
        };
        known.count += 1;
        if excess(refusal) > excess(&known.worst) {
            known.worst = refusal.clone();
        }
    }
    all
}

/// How many times the limit is exceeded.
fn excess(refusal: &Refusal) -> f64 {
    let value = refusal.value.unwrap_or(0.0);
    let limit = refusal.limit.unwrap_or(0.0);
    value.abs() / limit.abs().max(1e-12)
}

impl std::fmt::Display for RefusalSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.worst)?;
        match (self.count, self.first) {
            (1, _) => Ok(()),
            (count, Some(first)) => write!(f, ", the worst of {count} steps from {first} on"),
            (count, None) => write!(f, ", {count} times"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reason;
    use super::*;

    #[test]
    fn why_nothing_passed_is_the_most_frequent_reason() {
        let jerk = |step, value| Refusal::at(step, Reason::Jerk).with(value, 30.0);
        let refused = vec![
            Refusal::at(9, Reason::Overlap(7)),
            jerk(3, 40.0),
            jerk(4, 90.0),
        ];
        let mut found = super::super::SearchResult {
            candidates: refused.len(),
            refused,
            ..Default::default()
        };
        let why = found.all_refused().map(|why| (why.count, why.worst.step));
        assert_eq!(why, Some((2, Some(4))));
        found.candidates += 1;
        assert_eq!(found.all_refused(), None, "one passed");
    }

    #[test]
    fn of_each_reason_the_worst_is_told() {
        let jerk = |step, value| Refusal::at(step, Reason::Jerk).with(value, 30.0);
        let overlap = Refusal::at(9, Reason::Overlap(7));
        let all = [jerk(3, 40.0), overlap.clone(), jerk(4, 90.0), jerk(5, 50.0)];
        let summed = summarize(&all);
        assert_eq!((summed[0].worst.step, summed[0].count), (Some(4), 3));
        let words: Vec<String> = summed.iter().map(ToString::to_string).collect();
        assert_eq!(
            words,
            [
                "step 4: jerk 90.0000 m/s³, at most 30.0000, the worst of 3 steps from 3 on",
                "step 9: overlap with 7"
            ]
        );
    }
}
