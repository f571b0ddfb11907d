//! Ranks obstacles by how little their motion must change to reach the ego; physical limits of road users.

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{HumanLimits, Obstacle, ObstacleRole, ObstacleType, VehicleType};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::AttackContext;
use super::wish::AttackStyle;
use crate::planner::Limits;

/// An obstacle that could attack, and how much it would have to change.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "A possible attacker, by the reference.")]
pub struct Candidate {
    /// Its id.
    #[serde(rename = "id")]
    pub obstacle: i64,
    /// The least acceleration that brings it to the ego, m/s².
    // In any direction, constant for at most [`LOOKAHEAD`] seconds, the least one over all steps.
    pub acceleration: f64,
    /// When.
    pub step: i64,
    /// How near it is as recorded, metres.
    // Between the bodies, at that step.
    pub distance: f64,
    /// Whether it is near.
    // Within [`ATTACKER_DISTANCE`] metres in front of the ego or beside it there, as the paper asks.
    pub near: bool,
    /// Whether it comes from behind.
    // Behind the ego at every step.
    pub behind: bool,
    /// Whether it reaches the ego without reversing.
    // One that the ego is behind of can only fall back, by no more than it has driven.
    pub reaches: bool,
}

/// Longer than this no attacker is taken to prepare, seconds.
pub const LOOKAHEAD: f64 = 3.0;

/// An attacker is in front or to the side within this distance in the paper, metres.
pub const ATTACKER_DISTANCE: f64 = 30.0;

/// No obstacle attacks before it has been seen for so long, seconds.
const MIN_SEEN: f64 = 0.5;

/// An ego slower than this cannot be tested, m/s.
const MIN_EGO_SPEED: f64 = 2.0;

/// The obstacles that could attack, the least change first; ties in the file's order.
///
/// Steps at which the ego hardly moves do not count. Left out is what does not move by itself. An obstacle that is
/// only ever behind the ego comes late: a collision from behind tests the other one, and it would have to overtake
/// first. One that would have to reverse comes last.
#[must_use]
pub fn rank(stage: &AttackContext<'_>) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = stage
        .scenario
        .obstacles
        .iter()
        .filter(|obstacle| moves(stage, obstacle))
        .filter_map(|obstacle| candidate(stage, obstacle))
        .collect();
    found.sort_by(|a, b| {
        let order = (!a.reaches, a.behind).cmp(&(!b.reaches, b.behind));
        order.then(a.acceleration.total_cmp(&b.acceleration))
    });
    found
}

/// Why none of some obstacles, or of all where none is named, can reach the ego; `None` where one can.
#[must_use]
pub fn why_none(stage: &AttackContext<'_>, among: &[i64]) -> Option<&'static str> {
    if stage
        .ego
        .iter()
        .all(|(_, ego)| ego.velocity < MIN_EGO_SPEED)
    {
        return Some("the ego drives slower than 2 m/s at every step");
    }
    let may = |id: i64| among.is_empty() || among.contains(&id);
    let ranked = rank(stage).into_iter().filter(|c| may(c.obstacle));
    let reach: Vec<bool> = ranked.map(|c| c.reaches).collect();
    let obstacles = &stage.scenario.obstacles;
    if reach.contains(&true) {
        None
    } else if !reach.is_empty() {
        Some("the ego is reached only in reverse")
    } else if obstacles.iter().any(|o| may(o.id) && moves(stage, o)) {
        Some("none has been there for 0.5 s when the ego drives 2 m/s or faster")
    } else {
        Some("none moves by itself")
    }
}

fn moves(stage: &AttackContext<'_>, obstacle: &Obstacle) -> bool {
    obstacle.role == ObstacleRole::Dynamic
        && Capability::for_obstacle(obstacle, stage.style).is_some()
}

fn candidate(stage: &AttackContext<'_>, obstacle: &Obstacle) -> Option<Candidate> {
    let first = obstacle.track().steps().start;
    let mut best: Option<Candidate> = None;
    for (step, ego) in stage.ego.iter() {
        let Some(other) = obstacle.placed_at(step) else {
            continue;
        };
        let time = (step - first.max(*stage.steps.start())) as f64 * stage.dt();
        if time < MIN_SEEN || ego.velocity < MIN_EGO_SPEED {
            continue;
        }
        let own = stage.footprint.at(ego.pose);
        // An obstacle that has its middle behind the ego's rear is behind.
        let ahead = ego.pose.to_local(&other.pose.position).x;
        let behind = ahead < -stage.footprint.shape().size().0 / 2.0;
        let distance = own.distance(&other);
        let acceleration = 2.0 * distance / time.min(LOOKAHEAD).powi(2);
        let reaches = distance <= fall_back(stage, obstacle, step, &ego.pose.position);
        let better = |b: Candidate| {
            (!reaches, behind, acceleration) < (!b.reaches, b.behind, b.acceleration)
        };
        if best.is_none_or(better) {
            best = Some(Candidate {
                obstacle: obstacle.id,
                acceleration,
                step,
                distance,
                near: distance <= ATTACKER_DISTANCE && !behind,
                behind,
                reaches,
            });
        }
    }
    best
}

/// How far an obstacle can fall back to an ego behind it within [`LOOKAHEAD`] seconds until `step`, metres: as far as it
/// has driven. No bound where the ego is not behind it.
fn fall_back(stage: &AttackContext<'_>, obstacle: &Obstacle, step: i64, ego: &Point) -> f64 {
    let Some(now) = obstacle.motion_at(step) else {
        return f64::INFINITY;
    };
    let length = obstacle
        .footprint
        .as_ref()
        .map_or(0.0, |f| f.shape().size().0);
    if now.pose.to_local(ego).x >= -length / 2.0 {
        return f64::INFINITY;
    }
    let lately = obstacle
        .track()
        .during(&(step - stage.step_at(LOOKAHEAD)..=step));
    let first = lately.first().map_or(now, |(_, first)| first);
    (now.pose.position - first.pose.position).norm()
}

/// Physical limits of one road user, as a single-track vehicle of its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capability {
    /// Sizes, speeds, forces and steering.
    pub limits: Limits,
    /// The largest change of the acceleration along the heading, m/s³.
    pub jerk: f64,
    /// What a squared jerk costs beside a squared metre from where one is to be, m²/(m/s³)²: the more, the smoother one
    /// drives and the less exactly.
    pub jerk_cost: f64,
    /// The largest acceleration forward, m/s²; infinite where only engine and grip limit it.
    pub speeding_up: f64,
    /// The largest acceleration across the heading, m/s²; infinite where only the grip limits it.
    pub lateral: f64,
    /// Whether it has to stay on the road.
    pub on_road: bool,
}

/// Change of a car's acceleration in an emergency braking, m/s³: brakes build up their force within a few tenths of a
/// second.
const JERK: f64 = 30.0;

/// Jerks cost next to nothing where a vehicle goes to its limits.
const JERK_COST: f64 = 2e-4;

/// Share of a long vehicle's length that lies between its axles, and from the rear axle to its middle.
const LONG_WHEELBASE: f64 = 0.5;
const LONG_REAR: f64 = 0.25;

impl Capability {
    /// That of an obstacle; `None` for what has no body of one size, or does not move by itself.
    ///
    /// Cars have the limits of CommonRoad's vehicle 2 (BMW 320i), whose axles they are given; trucks and buses those of
    /// vehicle 4 with axles by their length. Motorcycles, bicycles and pedestrians are single-track vehicles with
    /// numbers of our own: a pedestrian one that turns almost on the spot, and may leave the road.
    ///
    /// In [`AttackStyle::Human`], no more of it than [`HumanLimits`] allow.
    #[must_use]
    pub fn for_obstacle(obstacle: &Obstacle, style: AttackStyle) -> Option<Self> {
        let able = Self::of_vehicle(obstacle)?;
        Some(match style {
            AttackStyle::Human => able.of_person(&HumanLimits::for_kind(obstacle.kind)),
            AttackStyle::Limit => able,
        })
    }

    fn of_vehicle(obstacle: &Obstacle) -> Option<Self> {
        let (length, width) = obstacle.footprint.as_ref()?.shape().size();
        let car = Limits::for_vehicle(VehicleType::Bmw320i);
        let truck = Limits::for_vehicle(VehicleType::Truck);
        let sized = |limits: Limits| Limits {
            length,
            width,
            ..limits
        };
        let axles = |limits: Limits, wheelbase: f64, rear_to_centre: f64| Limits {
            wheelbase,
            rear_to_centre,
            ..sized(limits)
        };
        let small = |speed: f64, acceleration: f64, steering: f64, steering_rate: f64| Limits {
            acceleration,
            speed,
            switch_speed: speed,
            steering,
            steering_rate,
            ..axles(car, 0.6 * length, 0.3 * length)
        };
        let (limits, jerk, on_road) = match obstacle.kind {
            ObstacleType::Car
            | ObstacleType::Taxi
            | ObstacleType::PriorityVehicle
            | ObstacleType::ParkedVehicle => (sized(car), JERK, true),
            ObstacleType::Truck | ObstacleType::Bus => {
                let limits = axles(truck, LONG_WHEELBASE * length, LONG_REAR * length);
                (limits, JERK, true)
            }
            ObstacleType::Motorcycle => (small(50.0, 9.0, 0.6, 0.8), JERK, true),
            ObstacleType::Bicycle => (small(15.0, 5.0, 0.8, 1.0), JERK, true),
            ObstacleType::Pedestrian => (small(5.0, 4.0, 1.3, 5.0), JERK, false),
            _ => return None,
        };
        Some(Self {
            limits,
            jerk,
            jerk_cost: JERK_COST,
            speeding_up: f64::INFINITY,
            lateral: f64::INFINITY,
            on_road,
        })
    }

    /// The same with `share` (0 to 1) of what it can do: what is made within it passes the whole after rounding.
    #[must_use]
    pub fn scaled(self, share: f64) -> Self {
        Self {
            limits: self.limits.scaled(share),
            jerk: self.jerk * share,
            speeding_up: self.speeding_up * share,
            lateral: self.lateral * share,
            ..self
        }
    }
}
