//! Whether an ideal driver could have avoided the collision, and what the evasive trajectory asks of its driver.
//!
//! The ego drives unchanged until the reaction time has passed since the last recorded state of the attacker; of several
//! that of the first one that moves otherwise, since a driver who saw it is alert to the others. From then
//! on it may use its vehicle's full limits and knows the future of all road users. The others follow their recording
//! and do not react: an ego that dodges the attacker and is then hit from behind has not avoided the collision.

use std::sync::Arc;

use nearmiss_scene::scenario::{RoadUser, Scenario};
use nearmiss_scene::traffic_rules::RuleReport;

use super::evasive_search::Search;
use super::{ClosedLoop, Effect, EvasiveManoeuvre};
use crate::planner::VehicleState;
use crate::simulation::{Collision, Driver, Outcome, Rollout};

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
    /// A verified trajectory avoids the collision.
    Avoided(Arc<EvasiveTrajectory>),
    /// The search found none, which does not prove that there is none.
    NotFound(NotFound),
}

/// A trajectory that touches no obstacle.
///
/// The finished trajectory has been checked against the exact bodies of all obstacles at and between all steps, against
/// the road and, after the reaction time, against the vehicle's limits. It ends at the goal at least a second after the
/// contact it avoids, at the problem's deadline, or when no obstacle is left. From its end the ego could drive straight
/// on for two seconds, braking or accelerating, without contact.
#[derive(Debug, Clone)]
pub struct EvasiveTrajectory {
    /// The ego from its start on.
    pub drive: Rollout,
    /// Up to this step it is the unchanged drive.
    pub reaction: i64,
    /// How it was found.
    pub found: Finder,
    /// The search effort until then.
    pub searched: SearchEffort,
}

/// The method that found a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finder {
    /// No reaction is needed: the unchanged drive touches no obstacle.
    Unchanged,
    /// One evasive manoeuvre, held to the end.
    Manoeuvre(EvasiveManoeuvre),
    /// The planner with known futures; its settings have this name.
    Planner(&'static str),
}

/// Extent of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
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
    /// The search effort.
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
    /// The planner's process failed, which says nothing about an ideal driver: nothing was tried.
    NotLookedFor,
}

impl Avoidability {
    /// Searches for each reaction time, the longest one first: what can be avoided late, can be by the same trajectory
    /// with a shorter reaction time.
    #[must_use]
    pub fn search(closed: &ClosedLoop, effect: &Effect) -> Self {
        let search = Search::new(closed, effect);
        let mut known: Option<Arc<EvasiveTrajectory>> = None;
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

    /// Without a search: nothing is known about an ideal driver.
    #[must_use]
    pub fn not_looked_for() -> Self {
        let nothing = NotFound {
            why: Unavoidable::NotLookedFor,
            searched: SearchEffort::default(),
        };
        Self {
            certificates: DELAYS.map(|delay| (delay, Certificate::NotFound(nothing))),
        }
    }

    /// Whether ways out were searched for.
    #[must_use]
    pub fn is_looked_for(&self) -> bool {
        let mut all = self.certificates.iter();
        !all.all(
            |(_, c)| matches!(c, Certificate::NotFound(n) if n.why == Unavoidable::NotLookedFor),
        )
    }

    /// The certificate for this one reaction time, seconds.
    #[must_use]
    pub fn with(closed: &ClosedLoop, effect: &Effect, delay: f64) -> Certificate {
        let search = Search::new(closed, effect);
        search.from(search.reaction(delay))
    }

    /// The longest reaction time (s) with which it can be avoided, and how.
    #[must_use]
    pub fn latest(&self) -> Option<(f64, &Arc<EvasiveTrajectory>)> {
        let mut all = self.certificates.iter().rev();
        all.find_map(|(delay, certificate)| Some((*delay, certificate.avoidance()?)))
    }

    /// Whether it can be avoided with this reaction time, seconds; `None` for delays other than [`DELAYS`].
    #[must_use]
    pub fn at(&self, delay: f64) -> Option<bool> {
        let found = self.certificates.iter().find(|(d, _)| *d == delay);
        found.map(|(_, certificate)| certificate.avoidance().is_some())
    }
}

impl Certificate {
    /// A drive of the whole problem by a driver who knows the future of all others, who do not react: from its start to its
    /// goal or deadline, without contact and on the road.
    #[must_use]
    pub fn of_problem(driver: &Driver, scenario: &Scenario) -> Self {
        let search = Search::of_problem(driver, scenario);
        search.from(search.reaction(0.0))
    }

    /// The trajectory, if there is one.
    #[must_use]
    pub fn avoidance(&self) -> Option<&Arc<EvasiveTrajectory>> {
        match self {
            Self::Avoided(avoidance) => Some(avoidance),
            Self::NotFound(_) => None,
        }
    }

    /// The search effort until it was found, or in all.
    #[must_use]
    pub fn searched(&self) -> &SearchEffort {
        match self {
            Self::Avoided(avoidance) => &avoidance.searched,
            Self::NotFound(nothing) => &nothing.searched,
        }
    }
}

impl SearchEffort {
    /// In the unit of [`Effect::work`].
    #[must_use]
    pub fn work(&self) -> usize {
        self.manoeuvres / 30 + self.cycles / 2 + self.candidates / 1000
    }
}

impl std::fmt::Display for Finder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unchanged => f.write_str("driving on as if nothing had changed"),
            Self::Planner(name) => write!(f, "planner, {name}"),
            Self::Manoeuvre(m) => {
                let side = match m.offset {
                    offset if offset.abs() < 0.005 => "on the path".to_owned(),
                    offset if offset > 0.0 => format!("{offset:.2} m left of the path"),
                    offset => format!("{:.2} m right of the path", -offset),
                };
                write!(
                    f,
                    "manoeuvre: {:.2} m/s² until {:.1} m/s, {side}, {:.0} % of the friction to steer with",
                    m.acceleration,
                    m.until,
                    m.grip * 100.0
                )
            }
        }
    }
}

impl std::fmt::Display for SearchEffort {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counted = |count: usize, noun: &str, nouns: &str| match count {
            1 => format!("1 {noun}"),
            _ => format!("{count} {nouns}"),
        };
        write!(
            f,
            "{} of one acceleration and one offset, {} of the built-in planner with all futures known ({}, {}), {} rejected by the final check",
            counted(self.manoeuvres, "manoeuvre", "manoeuvres"),
            counted(self.drives, "drive", "drives"),
            counted(self.cycles, "cycle", "cycles"),
            counted(self.candidates, "candidate", "candidates"),
            counted(self.refused, "trajectory", "trajectories"),
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
            Self::NothingFound => f.write_str("no avoiding motion found"),
            Self::NotLookedFor => f.write_str("not looked for, since the planner failed"),
        }
    }
}

/// What it asks.
#[derive(Debug, Clone)]
pub struct EvasiveReview {
    /// The largest acceleration after the reaction, along and across together, m/s².
    pub acceleration: f64,
    /// Which traffic rules apply to it, and which it breaks.
    pub rules: RuleReport,
    /// The first step after the reaction at which the body, until then on lanelets of cars, is partly on one that no car
    /// may use: a sidewalk or a bicycle path.
    pub leaves_roadway: Option<i64>,
}

impl EvasiveTrajectory {
    /// Reviews it in the scenario of `effect`.
    #[must_use]
    pub fn review(&self, closed: &ClosedLoop, effect: &Effect) -> EvasiveReview {
        let driver = closed.driver();
        let later = { self.drive.states.iter() }.filter(|(step, _)| *step > self.reaction);
        let used = later.map(|(_, state)| {
            let across = state.velocity * state.velocity * state.curvature;
            state.acceleration.hypot(across)
        });
        EvasiveReview {
            acceleration: used.fold(0.0, f64::max),
            rules: self
                .drive
                .rules(&effect.scenario, driver.problem(), driver.settings()),
            leaves_roadway: self.leaves_roadway(closed, effect),
        }
    }

    fn leaves_roadway(&self, closed: &ClosedLoop, effect: &Effect) -> Option<i64> {
        let network = &effect.scenario.network;
        if network.lanelets.iter().all(|l| l.may_use(RoadUser::Car)) {
            // It is on the road all the time.
            return None;
        }
        let roadway = network.drivable_area(Some(RoadUser::Car));
        let body = closed.driver().road().body();
        let is_on =
            |state: &VehicleState| roadway.covers(&body.at(state.centre(&self.drive.limits).pose));
        let (until, later): (Vec<_>, Vec<_>) =
            { self.drive.states.iter() }.partition(|(step, _)| *step <= self.reaction);
        until.last().filter(|(_, state)| is_on(state))?;
        let left = later.iter().find(|(_, state)| !is_on(state));
        left.map(|(step, _)| *step)
    }
}

impl EvasiveReview {
    /// The names of the rules that it breaks.
    #[must_use]
    pub fn broken(&self) -> Vec<&'static str> {
        self.rules.broken().map(|rule| rule.name()).collect()
    }

    /// The names of the rules that cannot be judged.
    #[must_use]
    pub fn undecided(&self) -> Vec<&'static str> {
        self.rules.undecided().map(|rule| rule.name()).collect()
    }
}
