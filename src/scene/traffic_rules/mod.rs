//! Traffic rules: which hold along a way, and which of them a drive broke.
//!
//! The rules are those formalised for CommonRoad: general ones (R-G) by Maierhofer, Rettinger, Mayer and Althoff,
//! Formalization of Interstate Traffic Rules in Temporal Logic, IV 2020, and those of intersections (R-IN) by
//! Maierhofer, Moosbrugger and Althoff, Formalization of Intersection Traffic Rules in Temporal Logic, IV 2022. What a
//! map does not say is not guessed: a rule that cannot be decided is reported as such.
//!
//! [`Regulations`] are the facts of the map along a way: speed limits, lights, stop signs, and at each intersection
//! the lanes that have to be given way to. The planner obeys them, and [`RuleReport`] holds any drive to them.

mod distance;
mod junction;
mod regulations;
mod right_of_way;
mod stopping;

pub use junction::{Passage, Rival, Turn};
pub use regulations::{LimitedStretch, Regulations};
pub use right_of_way::SignRank;
pub use stopping::{LightLine, StopSignLine};

use std::collections::BTreeSet;

use nearmiss_base::geometry::{Point, ReferencePath};
use strum::{IntoStaticStr, VariantArray};

use super::scenario::{Route, RouteError, Scene};

/// What became of all rules in a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleReport {
    /// One for each rule, in the order of [`Rule::ALL`].
    pub findings: Vec<Finding>,
}

/// What became of a rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The rule.
    pub rule: Rule,
    /// What became of it.
    pub status: RuleStatus,
    /// Why it did not apply or cannot be decided.
    pub reason: Option<&'static str>,
    /// Each time that it was broken, in order.
    pub violations: Vec<Violation>,
}

/// A rule that was broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Violation {
    /// The first time step.
    pub from: i64,
    /// The last time step.
    pub until: i64,
    /// Where the ego was at the worst moment, metres.
    pub at: Point,
    /// Its lanelet there.
    pub lanelet: Option<i64>,
    /// The obstacle that the rule protects, if it is about one.
    pub obstacle: Option<i64>,
    /// By how much at the worst moment, in [`Rule::unit`]: metres that were missing to the safe distance, m/s² of braking
    /// beyond what is not abrupt, m/s above the limit, seconds that were missing to the time at a stop sign or to the
    /// time between two vehicles, speed (m/s) at a red light.
    pub amount: f64,
}

impl RuleReport {
    /// The report of a scene's ego, recorded or planned.
    #[must_use]
    pub fn from_scene(scene: &Scene) -> Self {
        let ego = match EgoAlong::new(scene) {
            Ok(ego) => ego,
            Err(_) => return Self::all_undecided("the lanes of the ego are not known"),
        };
        if ego.moments.len() < 2 {
            return Self::all_undecided("the ego does not move along its lanes");
        }
        let mut findings = distance::findings(&ego);
        findings.push(distance::finding(&ego));
        findings.extend(stopping::findings(&ego));
        findings.extend(right_of_way::findings(&ego));
        Self { findings }
    }

    /// The same without judging the ego at these steps: a rule that was broken at them alone cannot be decided.
    #[must_use]
    pub fn unjudged_at(mut self, steps: &BTreeSet<i64>, reason: &'static str) -> Self {
        for finding in &mut self.findings {
            let judged =
                |one: &Violation| !(one.from..=one.until).all(|step| steps.contains(&step));
            if finding.status != RuleStatus::Broken {
                continue;
            }
            finding.violations.retain(judged);
            if finding.violations.is_empty() {
                *finding = Finding::undecided(finding.rule, reason);
            }
        }
        self
    }

    fn all_undecided(reason: &'static str) -> Self {
        let findings = Rule::ALL.map(|rule| Finding::undecided(rule, reason));
        Self {
            findings: findings.into(),
        }
    }

    /// The rules that were broken.
    pub fn broken(&self) -> impl Iterator<Item = Rule> + '_ {
        self.with(RuleStatus::Broken)
    }

    /// The rules of which is not known whether they were broken.
    pub fn undecided(&self) -> impl Iterator<Item = Rule> + '_ {
        self.with(RuleStatus::Undecided)
    }

    fn with(&self, status: RuleStatus) -> impl Iterator<Item = Rule> + '_ {
        let all = self.findings.iter();
        all.filter(move |finding| finding.status == status)
            .map(|finding| finding.rule)
    }

    /// What became of a rule.
    #[must_use]
    pub fn finding(&self, rule: Rule) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.rule == rule)
    }
}

impl Finding {
    /// Of a rule that applied.
    fn applied(rule: Rule, violations: Vec<Violation>) -> Self {
        let status = if violations.is_empty() {
            RuleStatus::Obeyed
        } else {
            RuleStatus::Broken
        };
        Self {
            rule,
            status,
            reason: None,
            violations,
        }
    }

    fn not_applicable(rule: Rule, reason: &'static str) -> Self {
        Self {
            status: RuleStatus::NotApplicable,
            ..Self::undecided(rule, reason)
        }
    }

    fn undecided(rule: Rule, reason: &'static str) -> Self {
        Self {
            rule,
            status: RuleStatus::Undecided,
            reason: Some(reason),
            violations: Vec::new(),
        }
    }
}

/// Violations of moments that follow each other, as one: the worst amount decides where. `amount` is what a moment breaks
/// a rule by, and towards which obstacle; nothing where it does not.
fn merged(
    ego: &EgoAlong<'_>,
    mut amount: impl FnMut(usize, &Moment) -> Option<(f64, Option<i64>)>,
) -> Vec<Violation> {
    let mut found: Vec<Violation> = Vec::new();
    for (place, moment) in ego.moments.iter().enumerate() {
        let Some((amount, obstacle)) = amount(place, moment) else {
            continue;
        };
        let now = Violation {
            from: moment.step,
            until: moment.step,
            at: moment.position,
            lanelet: ego.lanelet(moment),
            obstacle,
            amount,
        };
        match found.last_mut() {
            Some(last) if last.until + 1 == moment.step && last.obstacle == obstacle => {
                let (from, worse) = (last.from, amount > last.amount);
                if worse {
                    *last = now;
                }
                (last.from, last.until) = (from, moment.step);
            }
            _ => found.push(now),
        }
    }
    found
}

/// A rule of the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Rule {
    /// R-G1: enough distance to the vehicle in front to stop behind it.
    SafeDistance,
    /// R-G2: no abrupt braking without a reason.
    UnnecessaryBraking,
    /// R-G3: no faster than the limit of the lane.
    SpeedLimit,
    /// R-IN1: a stop at the line of a stop sign.
    StopSign,
    /// R-IN2: no crossing of the line at red, nor at yellow where a comfortable stop is possible.
    RedLight,
    /// R-IN3: right before left, where neither signs nor lights decide.
    RightBeforeLeft,
    /// R-IN4: the right of way of others by signs.
    Priority,
    /// R-IN5: oncoming traffic before one's own left turn.
    LeftTurn,
}

nearmiss_record::named!(Rule);

/// What became of a rule in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum RuleStatus {
    /// It was broken.
    Broken,
    /// It applied, and was obeyed.
    Obeyed,
    /// There was no occasion for it.
    NotApplicable,
    /// The scenario does not say what is needed to decide it.
    Undecided,
}

nearmiss_record::named!(RuleStatus);

/// Below this speed a vehicle stands, m/s: recordings are noisy.
pub const STANDING: f64 = 0.1;

/// Seconds that a vehicle has to stand at a stop sign (t_slw of the implementations of R-IN1; the law asks for a
/// standstill without saying how long).
pub const STOP_SECONDS: f64 = 3.0;

/// Seconds within which another vehicle must not follow into an area of conflict (t_ib of R-IN3 to R-IN5).
pub const YIELD_BEFORE: f64 = 1.0;

/// Seconds for which an area of conflict is not entered after another vehicle left it (t_ia).
pub const YIELD_AFTER: f64 = 0.5;

impl Rule {
    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::SafeDistance => "safe distance",
            Self::UnnecessaryBraking => "unnecessary braking",
            Self::SpeedLimit => "speed limit",
            Self::StopSign => "stop sign",
            Self::RedLight => "red light",
            Self::RightBeforeLeft => "right before left",
            Self::Priority => "priority",
            Self::LeftTurn => "left turn",
        }
    }

    /// Its number in the formalisation.
    #[must_use]
    pub fn number(self) -> &'static str {
        match self {
            Self::SafeDistance => "R-G1",
            Self::UnnecessaryBraking => "R-G2",
            Self::SpeedLimit => "R-G3",
            Self::StopSign => "R-IN1",
            Self::RedLight => "R-IN2",
            Self::RightBeforeLeft => "R-IN3",
            Self::Priority => "R-IN4",
            Self::LeftTurn => "R-IN5",
        }
    }

    /// What a violation is measured in.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::SafeDistance => "m",
            Self::UnnecessaryBraking => "m/s²",
            Self::SpeedLimit | Self::RedLight => "m/s",
            Self::StopSign | Self::RightBeforeLeft | Self::Priority | Self::LeftTurn => "s",
        }
    }
}

/// The ego of a scene along the way that it drove.
#[derive(Debug)]
struct EgoAlong<'a> {
    scene: &'a Scene,
    path: ReferencePath,
    regulations: Regulations,
    /// Its moments, one a step.
    moments: Vec<Moment>,
}

/// The ego at a step.
#[derive(Debug, Clone, Copy)]
struct Moment {
    step: i64,
    /// Arc lengths of the body's front and rear, metres.
    front: f64,
    rear: f64,
    /// m/s and m/s².
    velocity: f64,
    acceleration: f64,
    position: Point,
}

/// From one step to the next the place on the path moves less than this, metres.
const HINT: f64 = 25.0;

impl<'a> EgoAlong<'a> {
    /// Finds the way of a scene's ego.
    ///
    /// # Errors
    /// It is on no lanes, or they are not connected.
    fn new(scene: &'a Scene) -> Result<Self, RouteError> {
        let network = &scene.scenario.network;
        let graph = network.lane_graph(None);
        let poses = scene.ego.track.iter().map(|(_, motion)| motion.pose);
        let route: Route = graph.route_along(poses)?;
        let regulations = Regulations::along(network, &route, &route.path);
        let (length, _) = scene.ego.footprint.shape().size();
        let mut hint = route.start;
        let moments = scene
            .ego
            .track
            .iter()
            .filter_map(|(step, motion)| {
                let position = motion.pose.position;
                let at = route.path.project_near(&position, hint, HINT).ok()?;
                hint = at.s;
                Some(Moment {
                    step,
                    front: at.s + length / 2.0,
                    rear: at.s - length / 2.0,
                    velocity: motion.velocity,
                    acceleration: motion.acceleration,
                    position,
                })
            })
            .collect();
        Ok(Self {
            scene,
            regulations,
            moments,
            path: route.path,
        })
    }

    /// Seconds between two steps.
    fn dt(&self) -> f64 {
        self.scene.scenario.dt()
    }

    /// The place of the moment at which the front passes an arc length; nothing where it begins beyond it or never does.
    fn passes(&self, s: f64) -> Option<usize> {
        let beyond = self.moments.iter().position(|m| m.front > s)?;
        (beyond > 0).then_some(beyond)
    }

    /// Whether the front comes within so many metres of an arc length that is ahead of it at first.
    fn comes_near(&self, s: f64, within: f64) -> bool {
        let first = self.moments.first();
        first.is_some_and(|m| m.front <= s) && self.moments.iter().any(|m| m.front > s - within)
    }

    /// The lanelet of the way under the middle of the ego.
    fn lanelet(&self, moment: &Moment) -> Option<i64> {
        self.regulations
            .lanelet_at(f64::midpoint(moment.front, moment.rear))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_that_is_broken_at_unjudged_steps_alone_is_undecided() {
        let broken = |from, until| Violation {
            from,
            until,
            at: Point::new(0.0, 0.0),
            lanelet: None,
            obstacle: None,
            amount: 1.0,
        };
        let report = RuleReport {
            findings: vec![
                Finding::applied(Rule::UnnecessaryBraking, vec![broken(3, 4)]),
                Finding::applied(Rule::SpeedLimit, vec![broken(3, 4), broken(4, 5)]),
                Finding::applied(Rule::RedLight, Vec::new()),
            ],
        };
        let judged = report.unjudged_at(&BTreeSet::from([3, 4]), "jumps");
        let status: Vec<RuleStatus> = judged.findings.iter().map(|one| one.status).collect();
        let wanted = [
            RuleStatus::Undecided,
            RuleStatus::Broken,
            RuleStatus::Obeyed,
        ];
        assert_eq!(status, wanted);
        assert_eq!(judged.findings[0].reason, Some("jumps"));
        assert_eq!(judged.findings[1].violations, [broken(4, 5)]);
    }
}
