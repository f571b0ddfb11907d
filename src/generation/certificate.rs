//! Whether a good driver could have avoided the collision: for several reaction times an escape, or what was searched.
//!
//! The ego drives as if nothing had changed until the reaction time has passed since the last recorded state of the
//! attacker; from there on it may do whatever its vehicle can do, and knows everyone's future. The others drive as
//! recorded and do not react: an ego that dodges the attacker and is then hit from behind has not avoided the
//! collision.

use std::sync::Arc;

use super::escape::Search;
use super::{ClosedLoop, Effect, Evasion};
use crate::simulation::{Collision, Outcome, Rollout};

/// The reaction times that are looked at, seconds.
pub const DELAYS: [f64; 4] = [0.0, 0.5, 1.0, 1.5];

/// For each reaction time whether the harm can be avoided, and the proof.
#[derive(Debug, Clone)]
pub struct Avoidability {
    /// Reaction times (s) in the order of [`DELAYS`], each with its certificate.
    pub certificates: [(f64, Certificate); 4],
}

/// Result of the search for one reaction time.
#[derive(Debug, Clone)]
pub enum Certificate {
    /// This trajectory avoids it. It has been verified: see [`Avoidance`].
    Avoided(Arc<Avoidance>),
    /// No trajectory was found. That proves nothing but that these were not it.
    NotFound(NotFound),
}

/// A trajectory that touches no obstacle.
///
/// It was held, once it was finished, against the exact bodies of everyone at every step and between two steps, against
/// the road, and, from
/// the end of the reaction time on, against the limits of the vehicle. It ends at the goal, at least a second after
/// the contact that it avoids; or at the problem's deadline; or when no obstacle is left to be touched. From its
/// end on it could go straight on for two seconds, braking or accelerating, without being touched.
#[derive(Debug, Clone)]
pub struct Avoidance {
    /// The ego from its start on.
    pub drive: Rollout,
    /// Up to this step it is the unchanged drive.
    pub reaction: i64,
    /// How it was found.
    pub found: Finder,
    /// What had been searched by then.
    pub searched: SearchEffort,
}

/// The method that found a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finder {
    /// Nothing has to be done: who drives on as if nothing had changed touches no obstacle.
    Unchanged,
    /// One manoeuvre that is kept up.
    Evasion(Evasion),
    /// The planner, told everyone's future; with settings of this name.
    Planner(&'static str),
}

/// Extent of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SearchEffort {
    /// Manoeuvres that were driven to their end or to a contact.
    pub manoeuvres: usize,
    /// Drives of the planner.
    pub drives: usize,
    /// Their planning cycles.
    pub cycles: usize,
    /// The candidates in these.
    pub candidates: usize,
    /// Trajectories that touched no obstacle and failed the check at the end.
    pub refused: usize,
}

/// Why there is no trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotFound {
    /// Why.
    pub why: Unavoidable,
    /// What was searched.
    pub searched: SearchEffort,
}

/// The kinds of reasons.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unavoidable {
    /// The contact comes before the driver can react.
    TooEarly(Collision),
    /// The unchanged drive comes to such an end before the driver can react.
    Ended(Outcome),
    /// Everything that was tried ends badly.
    NothingFound,
}

impl Avoidability {
    /// Searches for each reaction time, the longest one first: what can be avoided late, can be by the same trajectory
    /// with a shorter reaction time.
    #[must_use]
    pub fn search(closed: &ClosedLoop, effect: &Effect) -> Self {
        let search = Search::new(closed, effect);
        let mut known: Option<Arc<Avoidance>> = None;
        let mut certificates = DELAYS.map(|delay| {
            let nothing = NotFound {
                why: Unavoidable::NothingFound,
                searched: SearchEffort::default(),
            };
            (delay, Certificate::NotFound(nothing))
        });
        for (delay, certificate) in certificates.iter_mut().rev() {
            let reaction = search.reaction(*delay);
            // Also what lies between the two reaction times has to be within the vehicle's limits.
            let inherited = known
                .clone()
                .filter(|longer| search.verify(longer, reaction));
            *certificate = match inherited {
                Some(longer) => Certificate::Avoided(longer),
                None => search.from(reaction),
            };
            if let Certificate::Avoided(avoidance) = certificate {
                known = Some(Arc::clone(avoidance));
            }
        }
        Self { certificates }
    }

    /// Whether it can be avoided with this one reaction time, seconds.
    #[must_use]
    pub fn with(closed: &ClosedLoop, effect: &Effect, delay: f64) -> bool {
        let search = Search::new(closed, effect);
        let found = search.from(search.reaction(delay));
        found.avoidance().is_some()
    }

    /// Whether it can be avoided with this reaction time, seconds; of other ones than [`DELAYS`] nothing is known.
    #[must_use]
    pub fn at(&self, delay: f64) -> Option<bool> {
        let found = self.certificates.iter().find(|(d, _)| *d == delay);
        found.map(|(_, certificate)| certificate.avoidance().is_some())
    }
}

impl Certificate {
    /// The trajectory, if there is one.
    #[must_use]
    pub fn avoidance(&self) -> Option<&Arc<Avoidance>> {
        match self {
            Self::Avoided(avoidance) => Some(avoidance),
            Self::NotFound(_) => None,
        }
    }

    /// What was searched.
    #[must_use]
    pub fn searched(&self) -> SearchEffort {
        match self {
            Self::Avoided(avoidance) => avoidance.searched,
            Self::NotFound(nothing) => nothing.searched,
        }
    }
}

impl std::fmt::Display for Finder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unchanged => f.write_str("driving on as if nothing had changed"),
            Self::Planner(name) => write!(f, "planner, {name}"),
            Self::Evasion(m) => write!(
                f,
                "manoeuvre: {:.2} m/s² until {:.1} m/s, {:.2} m left of the path, {:.0} % of the friction to steer with",
                m.acceleration,
                m.until,
                m.offset,
                m.grip * 100.0
            ),
        }
    }
}

impl std::fmt::Display for SearchEffort {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} manoeuvres of one acceleration and one offset, {} drives of the planner with everyone's future known \
             ({} cycles, {} candidates), {} trajectories refused by the last check",
            self.manoeuvres, self.drives, self.cycles, self.candidates, self.refused
        )
    }
}

impl std::fmt::Display for Unavoidable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooEarly(collision) => {
                write!(f, "contact before the driver can react: {collision}")
            }
            Self::Ended(outcome) => write!(f, "over before the driver can react: {outcome}"),
            Self::NothingFound => f.write_str("nothing that was tried avoids it"),
        }
    }
}
