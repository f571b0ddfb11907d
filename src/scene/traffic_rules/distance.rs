//! R-G1 to R-G3: the safe distance to the vehicle in front, braking without a reason, and the speed limit.

use nearmiss_base::geometry::angle_between;

use super::stopping::AT_LINE;
use super::{EgoAlong, Finding, Moment, Rule, merged};
use crate::scenario::{ObstacleRole, ObstacleType};

/// Braking of both vehicles in an emergency, m/s², and the reaction time of the ego, seconds: those of the CommonRoad
/// monitor of these rules.
const EMERGENCY: f64 = 10.5;
const REACTION: f64 = 0.4;

/// After another vehicle cuts in, the distance may be too short for this time, seconds (t_c).
const AFTER_CUT_IN: f64 = 3.0;

/// Braking harder than this is abrupt, m/s² (a_abrupt).
const ABRUPT: f64 = 2.0;

/// A vehicle whose middle is farther beside the way is not in the lane, metres.
const MAX_LATERAL_OFFSET: f64 = 1.5;

/// Vehicles farther ahead are not looked at, metres.
const LOOKAHEAD: f64 = 100.0;

/// The vehicle in front.
#[derive(Debug, Clone, Copy)]
struct Leader {
    id: i64,
    gap: f64,
    velocity: f64,
    acceleration: f64,
}

impl Leader {
    /// Metres that are missing to the safe distance behind it.
    fn missing(&self, velocity: f64) -> f64 {
        let stop = |v: f64| v * v / (2.0 * EMERGENCY);
        let safe = stop(velocity) - stop(self.velocity.max(0.0)) + velocity * REACTION;
        safe.max(0.0) - self.gap
    }
}

pub(super) fn findings(ego: &EgoAlong<'_>) -> Vec<Finding> {
    let leaders: Vec<Option<Leader>> = ego.moments.iter().map(|m| leader(ego, m)).collect();
    vec![safe_distance(ego, &leaders), unnecessary(ego, &leaders)]
}

fn safe_distance(ego: &EgoAlong<'_>, leaders: &[Option<Leader>]) -> Finding {
    if leaders.iter().all(Option::is_none) {
        return Finding::not_applicable(Rule::SafeDistance, "no vehicle in front");
    }
    let grace = (AFTER_CUT_IN / ego.dt()).round() as i64;
    let mut since: Option<(i64, i64)> = None;
    let mut before = true;
    let violations = merged(ego, |place, moment| {
        let leader = leaders[place];
        // One that is there from the beginning has not cut in; nor has one that the ego has caught up with.
        let new = leader.filter(|l| since.is_none_or(|(id, _)| id != l.id));
        if let Some(new) = new {
            let cut_in = !before && cuts_in(ego, new.id, moment);
            since = Some((new.id, if cut_in { moment.step } else { i64::MIN / 2 }));
        }
        before = false;
        let leader = leader?;
        let (_, from) = since?;
        let missing = leader.missing(moment.velocity);
        let excused = moment.step.saturating_sub(from) <= grace;
        (missing > 0.0 && !excused && moment.velocity > 0.0).then_some((missing, Some(leader.id)))
    });
    Finding::applied(Rule::SafeDistance, violations)
}

/// Whether an obstacle came into the lane from beside it within the last second.
fn cuts_in(ego: &EgoAlong<'_>, id: i64, moment: &Moment) -> bool {
    let back = (1.0 / ego.dt()).round() as i64;
    let obstacle = ego.scene.scenario.obstacle(id);
    let earlier = obstacle.and_then(|o| o.motion_at(moment.step - back));
    earlier.is_none_or(|motion| {
        let at = ego
            .path
            .project_near(&motion.pose.position, moment.front, LOOKAHEAD + 50.0);
        at.is_ok_and(|at| at.d.abs() > MAX_LATERAL_OFFSET)
    })
}

fn leader(ego: &EgoAlong<'_>, moment: &Moment) -> Option<Leader> {
    let others = ego.scene.participants();
    // No rule is broken towards a region that an obstacle may cover: its speed is not known.
    let bodies = others.filter(|o| {
        o.obstacle.kind != ObstacleType::Pedestrian && !o.obstacle.is_occupancy_at(moment.step)
    });
    let ahead = bodies.filter_map(|other| {
        let motion = other.at(moment.step)?;
        if (motion.pose.position - moment.position).norm() > LOOKAHEAD {
            return None;
        }
        let at = ego
            .path
            .project_near(&motion.pose.position, moment.front, LOOKAHEAD + 20.0)
            .ok()?;
        let turn = angle_between(ego.path.at(at.s).heading, motion.pose.heading);
        let moves = other.obstacle.role == ObstacleRole::Dynamic;
        let against = moves && turn.abs() > std::f64::consts::FRAC_PI_4;
        let (length, _) = other.footprint_at(moment.step).shape().size();
        if at.d.abs() > MAX_LATERAL_OFFSET
            || against
            || at.s <= f64::midpoint(moment.front, moment.rear)
        {
            return None;
        }
        Some(Leader {
            id: other.obstacle.id,
            gap: at.s - length / 2.0 - moment.front,
            velocity: if moves { motion.velocity } else { 0.0 },
            acceleration: if moves { motion.acceleration } else { 0.0 },
        })
    });
    ahead.min_by(|a, b| a.gap.total_cmp(&b.gap))
}

/// R-G2 is decided where nothing but the vehicle in front can be a reason to brake.
fn unnecessary(ego: &EgoAlong<'_>, leaders: &[Option<Leader>]) -> Finding {
    let abrupt = |m: &Moment| m.acceleration < -ABRUPT;
    if !ego.moments.iter().any(abrupt) {
        return Finding::applied(Rule::UnnecessaryBraking, Vec::new());
    }
    let mut undecided = false;
    let violations = merged(ego, |place, moment| {
        if !abrupt(moment) {
            return None;
        }
        let reasonable = leaders[place].is_some_and(|leader| {
            leader.missing(moment.velocity) > 0.0
                || moment.acceleration - leader.acceleration >= -ABRUPT
        });
        if reasonable {
            return None;
        }
        if may_have_a_reason(ego, moment) {
            undecided = true;
            return None;
        }
        Some((-moment.acceleration - ABRUPT, None))
    });
    match (violations.is_empty(), undecided) {
        (true, true) => Finding::undecided(
            Rule::UnnecessaryBraking,
            "lines, bends, limits or others nearby may be the reason to brake",
        ),
        _ => Finding::applied(Rule::UnnecessaryBraking, violations),
    }
}

/// Others within this distance may be a reason to brake, metres.
const NEARBY: f64 = 40.0;

/// Curvature that may be a reason to brake, 1/m.
const BEND: f64 = 0.01;

fn may_have_a_reason(ego: &EgoAlong<'_>, moment: &Moment) -> bool {
    let reach = moment.front + NEARBY;
    let ahead = |s: f64| s > moment.front - AT_LINE && s < reach;
    let rules = &ego.regulations;
    let lines = rules.lights.iter().any(|line| ahead(line.s))
        || rules.stops.iter().any(|line| ahead(line.s))
        || rules
            .passages
            .iter()
            .any(|p| p.until > moment.rear && p.line < reach);
    let limits = rules
        .limits
        .iter()
        .filter(|l| l.to > moment.rear && l.from < reach);
    let slower = { limits }.any(|limit| limit.speed < moment.velocity);
    let mut places = (0..=NEARBY as usize).map(|n| moment.rear + n as f64);
    let bends = places.any(|s| ego.path.at(s).curvature.abs() > BEND);
    let mut others = ego.scene.participants();
    let near = others.any(|other| {
        let at = other.at(moment.step);
        at.is_some_and(|at| (at.pose.position - moment.position).norm() < NEARBY)
    });
    lines || slower || bends || near
}

/// Speeds above the limit by no more than this are rounding of recordings, m/s.
const TOLERANCE: f64 = 0.1;

pub(super) fn finding(ego: &EgoAlong<'_>) -> Finding {
    if ego.scene.scenario.network.signs.is_empty() {
        return Finding::undecided(Rule::SpeedLimit, "the map has no signs");
    }
    let mut limited = false;
    let violations = merged(ego, |_, moment| {
        let middle = f64::midpoint(moment.front, moment.rear);
        let limit = ego.regulations.limit_at(middle)?;
        limited = true;
        let over = moment.velocity - limit.speed;
        (over > TOLERANCE).then_some((over, None))
    });
    if limited {
        Finding::applied(Rule::SpeedLimit, violations)
    } else {
        Finding::not_applicable(Rule::SpeedLimit, "no limit on the lanes driven")
    }
}
