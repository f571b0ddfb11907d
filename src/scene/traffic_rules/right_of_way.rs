//! R-IN3 to R-IN5: the right of way of others at intersections, and who goes first.
//!
//! A vehicle with the right of way is endangered (not_endanger_intersection of R-IN3 to R-IN5) if it follows into the area
//! of conflict within [`YIELD_BEFORE`] after the ego left it, if the ego enters it within [`YIELD_AFTER`] after the other
//! left, or if the other brakes for the ego there.

use nearmiss_base::geometry::{Point, angle_between};

use super::junction::{Rival, Turn};
use super::{EgoAlong, Finding, Rule, Violation, YIELD_AFTER, YIELD_BEFORE};
use crate::scenario::{
    Lanelet, LaneletNetwork, ObstacleRole, ObstacleType, Participant, SignMeaning,
};

/// The rules of this file.
const RULES: [Rule; 3] = [Rule::RightBeforeLeft, Rule::Priority, Rule::LeftTurn];

/// A vehicle whose middle is farther beside that of a lane is not on it, metres; nor is one that points elsewhere.
pub const MAX_LATERAL_OFFSET: f64 = 1.75;
pub const ALONG: f64 = std::f64::consts::FRAC_PI_4;

/// Braking for the ego: at least so much (m/s², a_br) no farther than this before the area (m, d_br).
const BRAKING: f64 = -1.0;
const BRAKING_WITHIN: f64 = 15.0;

/// A vehicle that is on a lane along its way, at some steps.
struct Visit {
    /// Steps in the area of conflict, first and last.
    inside: (i64, i64),
    /// Steps at which it brakes shortly before it.
    brakes: Vec<i64>,
}

pub(super) fn findings(ego: &EgoAlong<'_>) -> Vec<Finding> {
    if ego.scene.scenario.network.intersections.is_empty() {
        let why = "the map names no intersections";
        return RULES.map(|rule| Finding::undecided(rule, why)).into();
    }
    let mut applied: [Option<Vec<Violation>>; 3] = [None, None, None];
    for passage in &ego.regulations.passages {
        if !ego.comes_near(passage.line, OCCASION) {
            continue;
        }
        // While the lights change between on and off, those at the line count.
        let entry = ego
            .passes(passage.line)
            .map_or(0, |place| ego.moments[place].step);
        let lit = passage.lights && ego.regulations.is_lit(passage, entry);
        for rival in &passage.rivals {
            let Some(rule) = rival.rule(lit) else {
                continue;
            };
            let Some(place) = RULES.iter().position(|r| *r == rule) else {
                continue;
            };
            let found = applied[place].get_or_insert_with(Vec::new);
            found.extend(endangered(ego, rival));
        }
    }
    let none = "the map has no lane on the route that has priority by this rule";
    let mut findings = Vec::new();
    for (rule, violations) in RULES.into_iter().zip(applied) {
        findings.push(match violations {
            None => Finding::not_applicable(rule, none),
            Some(mut violations) => {
                violations.sort_by_key(|v| (v.from, v.obstacle));
                // One vehicle may be on two lanes that overlap.
                violations.dedup_by_key(|v| (v.from, v.obstacle));
                Finding::applied(rule, violations)
            }
        });
    }
    findings
}

/// An ego that never comes nearer to an intersection has no occasion there, metres.
const OCCASION: f64 = 30.0;

fn endangered(ego: &EgoAlong<'_>, rival: &Rival) -> Vec<Violation> {
    let (from, to) = rival.conflict.own;
    let inside = |place: &usize| ego.moments[*place].front > from && ego.moments[*place].rear < to;
    let mut places = (0..ego.moments.len()).filter(inside);
    let Some(first) = places.next() else {
        return Vec::new();
    };
    // An ego that begins there has not decided to be there.
    if first == 0 {
        return Vec::new();
    }
    let last = places.next_back().unwrap_or(first);
    let (enters, leaves) = (ego.moments[first].step, ego.moments[last].step);
    let ends = last + 1 == ego.moments.len();
    let middle = ego.path.pose_at(f64::midpoint(from, to)).position;
    let others = ego.scene.participants();
    let moving = others.filter(|other| other.obstacle.role == ObstacleRole::Dynamic);
    let vehicles = moving.filter(|other| other.obstacle.kind != ObstacleType::Pedestrian);
    let found = vehicles.filter_map(|other| {
        let visit = visit(ego, rival, &middle, &other)?;
        let dt = ego.dt();
        let (arrives, gone) = visit.inside;
        let missing = if enters <= arrives {
            let gap = (arrives - leaves) as f64 * dt;
            let caused = visit
                .brakes
                .iter()
                .any(|step| (enters..=leaves).contains(step));
            // A drive that ends in the area is there at least as long as it lasts.
            let missing = YIELD_BEFORE - gap;
            if caused { missing.max(dt) } else { missing }
        } else {
            YIELD_AFTER - (enters - gone) as f64 * dt
        };
        let counts = missing > ROUNDING && !(ends && arrives > leaves);
        counts.then_some((other.obstacle.id, missing))
    });
    let moment = &ego.moments[first];
    let violations = found.map(|(obstacle, amount)| Violation {
        from: enters,
        until: leaves,
        at: moment.position,
        lanelet: ego.lanelet(moment),
        obstacle: Some(obstacle),
        amount,
    });
    violations.collect()
}

/// Rounding of sums of steps, seconds.
const ROUNDING: f64 = 1e-6;

/// A vehicle farther from the area of conflict than this at all steps does not visit it, metres.
const MAX_CONFLICT_DISTANCE: f64 = 60.0;

fn visit(
    ego: &EgoAlong<'_>,
    rival: &Rival,
    middle: &Point,
    other: &Participant<'_>,
) -> Option<Visit> {
    let (length, _) = other.footprint.shape().size();
    let mut inside: Option<(i64, i64)> = None;
    let mut brakes = Vec::new();
    for (step, motion) in other.obstacle.track().iter() {
        if (motion.pose.position - middle).norm() > MAX_CONFLICT_DISTANCE {
            continue;
        }
        let on = rival.centre.project(&motion.pose.position);
        let along = rival.centre.pose_at(on.s).heading;
        let turn = angle_between(along, motion.pose.heading);
        if on.d.abs() > MAX_LATERAL_OFFSET || turn.abs() > ALONG {
            continue;
        }
        let (front, rear) = (on.s + length / 2.0, on.s - length / 2.0);
        let (from, to) = rival.conflict.other;
        if front > from && rear < to {
            let known = inside.get_or_insert((step, step));
            known.1 = step;
        } else if front <= from && from - front <= BRAKING_WITHIN && motion.acceleration <= BRAKING
        {
            brakes.push(step);
        }
    }
    // What it does before or after the drive does not count.
    let steps = ego.scene.steps();
    let inside = inside.filter(|(from, _)| steps.contains(from))?;
    Some(Visit { inside, brakes })
}

/// What the signs of a road that leads into an intersection say about precedence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SignRank {
    /// Stop and give way.
    Stop,
    /// Give way.
    Yield,
    /// Nothing, or that it is right before left.
    Unsigned,
    /// Right of way here, or a priority road.
    Priority,
}

impl SignRank {
    /// Of lanelets with their signs: the strictest that is said.
    pub(super) fn from_signs<'a>(
        network: &LaneletNetwork,
        lanelets: impl IntoIterator<Item = &'a Lanelet>,
    ) -> Self {
        let mut rank = Self::Unsigned;
        let mut prior = false;
        for id in lanelets.into_iter().flat_map(|l| &l.signs) {
            let sign = network.signs.iter().find(|sign| sign.id == *id);
            for element in sign.into_iter().flat_map(|sign| &sign.elements) {
                match element.meaning() {
                    Some(SignMeaning::Words("stop")) => rank = Self::Stop,
                    Some(SignMeaning::Words("yield")) => rank = rank.min(Self::Yield),
                    Some(SignMeaning::Words("right of way" | "priority road")) => prior = true,
                    _ => {}
                }
            }
        }
        if rank == Self::Unsigned && prior {
            Self::Priority
        } else {
            rank
        }
    }

    /// The number that decides for a turn, after the table of R-IN4: the higher one goes first.
    fn number(self, turn: Turn) -> u8 {
        match self {
            Self::Stop => 1,
            Self::Yield => 2,
            Self::Unsigned => 3,
            Self::Priority if turn == Turn::Straight => 5,
            Self::Priority => 4,
        }
    }
}

/// One of two vehicles that meet: the heading with which it enters (radians), where it turns to, and its signs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Party {
    pub heading: f64,
    pub turn: Turn,
    pub rank: SignRank,
}

/// Half of the angle within which others are opposite, radians; and the least angle from which they come from a side.
const OPPOSITE: f64 = std::f64::consts::FRAC_PI_4;
const HEADING_TOLERANCE: f64 = std::f64::consts::FRAC_PI_6;

/// The rule by which the first has to give way to the second; `None` where it need not. With `lights` on its own lane
/// only an oncoming vehicle comes before its left turn: the others have red.
pub(super) fn gives_way(own: &Party, other: &Party, lights: bool) -> Option<Rule> {
    let turn = angle_between(own.heading, other.heading);
    let opposite = turn.abs() > std::f64::consts::PI - OPPOSITE;
    let before_left = opposite && own.turn == Turn::Left && other.turn != Turn::Left;
    if lights {
        return before_left.then_some(Rule::LeftTurn);
    }
    let (mine, theirs) = (own.rank.number(own.turn), other.rank.number(other.turn));
    let both_prior = own.rank == SignRank::Priority && other.rank == SignRank::Priority;
    if both_prior && opposite {
        return before_left.then_some(Rule::LeftTurn);
    }
    if mine != theirs {
        return (mine < theirs).then_some(Rule::Priority);
    }
    if before_left {
        return Some(Rule::LeftTurn);
    }
    // It comes from the right: it drives to the left as seen from here.
    let from_right = turn > HEADING_TOLERANCE && !opposite;
    from_right.then_some(Rule::RightBeforeLeft)
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::f64::consts::{FRAC_PI_2, PI};

    fn party(heading: f64, turn: Turn, rank: SignRank) -> Party {
        Party {
            heading,
            turn,
            rank,
        }
    }

    #[test]
    fn signs_come_first_then_left_turns_then_the_right() {
        use SignRank::*;
        use Turn::*;
        let own = |turn, rank| party(FRAC_PI_2, turn, rank);
        let right = |turn, rank| party(PI, turn, rank);
        let left = |turn, rank| party(0.0, turn, rank);
        let oncoming = |turn, rank| party(-FRAC_PI_2, turn, rank);
        for (mine, other, lights, rule) in [
            (
                own(Straight, Unsigned),
                right(Straight, Unsigned),
                false,
                Some(Rule::RightBeforeLeft),
            ),
            (
                own(Straight, Unsigned),
                left(Straight, Unsigned),
                false,
                None,
            ),
            (
                own(Straight, Unsigned),
                oncoming(Left, Unsigned),
                false,
                None,
            ),
            (
                own(Left, Unsigned),
                oncoming(Straight, Unsigned),
                false,
                Some(Rule::LeftTurn),
            ),
            (own(Left, Unsigned), oncoming(Left, Unsigned), false, None),
            (
                own(Straight, Yield),
                left(Straight, Priority),
                false,
                Some(Rule::Priority),
            ),
            (
                own(Straight, Stop),
                left(Straight, Yield),
                false,
                Some(Rule::Priority),
            ),
            (own(Straight, Priority), right(Straight, Yield), false, None),
            (
                own(Left, Priority),
                oncoming(Straight, Priority),
                false,
                Some(Rule::LeftTurn),
            ),
            (
                own(Straight, Priority),
                oncoming(Left, Priority),
                false,
                None,
            ),
            (
                own(Straight, Unsigned),
                right(Straight, Unsigned),
                true,
                None,
            ),
            (
                own(Left, Unsigned),
                oncoming(Right, Unsigned),
                true,
                Some(Rule::LeftTurn),
            ),
        ] {
            assert_eq!(gives_way(&mine, &other, lights), rule, "{mine:?} {other:?}");
        }
    }
}
