//! Measures of following the one ahead in the ego's lane: gaps, times and the accelerations that they need.
//!
//! Headway: the free distance along the lane to the one ahead, from the ego's front to the other's rear.
//!
//! Both ends are those of the real bodies: of a turned box, its corners. Source: Jansson, Collision Avoidance
//! Theory, 2005.
//!
//! Time gap: the headway over the ego's speed along the lane.
//!
//! t = Δs / ṡ_ego: the time in which the ego gets to where the other's rear is now, at its present speed.
//! Source: SUMO's device SSM (TGAP).
//!
//! Time headway: the time until the ego's front is where the rear of the one ahead is now, as recorded.
//!
//! THW = min { t ≥ 0 : front_ego(t₀ + t) ≥ rear_other(t₀) } along the route; between two recorded steps it goes evenly.
//! Source: Jansson, Collision Avoidance Theory, 2005.
//!
//! Time to collision along the lane, with acceleration.
//!
//! The first t > 0 with Δd + Δv·t + ½Δa·t² = 0, where Δd is the headway, Δv the other's speed along the route
//! minus the ego's and Δa the same of the accelerations, all kept; 0 while the bodies touch. Source: Jansson, Collision Avoidance Theory,
//! 2005, eq. 5.26. The root is written so that Δa = 0 needs no case of its own.
//!
//! Deceleration rate to avoid a crash, of the follower, with the one half.
//!
//! DRAC = ½·Δv² / Δd: constant braking that takes away the closing speed within the headway, the other keeping
//! its speed. Many papers leave out the half and get twice as much. Source: SUMO's device SSM; Almqvist,
//! Hydén and Risser 1991.
//!
//! Required lateral acceleration: the smallest one with which the ego just does not touch the one ahead.
//!
//! At the time to collision along the lane t the bodies must be clear across the route: with the way D to the
//! left (or right) that is missing and the lateral velocity v already there, a = 2(D − v·t)/t², 0 where none is
//! needed. A magnitude, whatever the side. Source: Jansson, Collision Avoidance Theory, 2005, section 5.3.8.
//!
//! Steer-threat number: the required lateral acceleration over the available one.
//!
//! STN = a_lat_req / a_lat,max, with a_lat,max the limit `steer_threat`; from 1 on steering alone does not help.
//! Source: Hosseini, Murgovski, de Campos and Sjöberg 2016.
//!
//! Required longitudinal acceleration: the constant one with which the ego just does not reach the other.
//!
//! a = min(a_other − Δv² / (2Δd), 0), while it closes in; negative is braking. The other's acceleration is
//! taken to last. Source: Jansson, Collision Avoidance Theory, 2005, section 5.3.5.
//!
//! Brake-threat number: the required longitudinal deceleration over the available one.
//!
//! BTN = a_long_req / −a_max, with a_max the limit `brake_threat`; from 1 on braking alone does not help. Source:
//! Åsljung, Nilsson and Fredriksson 2017.

use super::super::{Danger, Encounter, Measure, Reading};
use super::LaneBody;
use crate::metrics::{Context, NoValue};

/// The ego behind another in the same lane.
#[derive(Debug, Clone, Copy)]
pub(in crate::metrics) struct Following {
    /// From the ego's front to the other's rear along the route, metres, positive.
    pub gap: f64,
    /// The ego.
    pub ego: LaneBody,
    /// The other.
    pub other: LaneBody,
}

/// Shorter gaps are none, metres.
const TOUCHING: f64 = 1e-6;

/// Bodies farther apart across the route are on no common lane, metres: no lane is so wide.
const MAX_LATERAL_DISTANCE: f64 = 20.0;

/// Slower changes are none, m/s and m/s²: they are rounding.
const MIN_CHANGE: f64 = 1e-6;

impl Following {
    /// The two, if the other is ahead and stands on a lane that the ego stands on.
    pub fn find(context: &Context<'_>, participant: usize, index: usize) -> Result<Self, NoValue> {
        let ego = context.ego_along(index)?;
        let other = context.along(participant, index)?;
        if other.front < ego.rear {
            return Err(NoValue::Behind);
        }
        let gap = other.rear - ego.front;
        if gap <= TOUCHING {
            let touch = context.distances(participant)[index] == Some(0.0);
            return Err(if touch {
                NoValue::Contact
            } else {
                NoValue::Beside
            });
        }
        if ego.clearance(&other) > MAX_LATERAL_DISTANCE {
            return Err(NoValue::OtherLane);
        }
        let road = context.road().map_err(|_| NoValue::NoRoute)?;
        let lanes = context.ego_lanes(road, index);
        if !lanes.meets(context.lanes_of(participant, index)) {
            return Err(NoValue::OtherLane);
        }
        Ok(Self { gap, ego, other })
    }

    /// Velocity of the other minus the ego's along the route, m/s; negative when closing.
    pub fn velocity(&self) -> f64 {
        without_rounding(self.other.velocity.x - self.ego.velocity.x)
    }

    /// Acceleration of the other minus the ego's along the route, m/s².
    pub fn acceleration(&self) -> f64 {
        without_rounding(self.other.acceleration - self.ego.acceleration)
    }

    /// Closing speed, m/s.
    pub fn closing(&self) -> Result<f64, NoValue> {
        let closing = -self.velocity();
        (closing > 0.0)
            .then_some(closing)
            .ok_or(NoValue::NotApproaching)
    }
}

fn without_rounding(value: f64) -> f64 {
    if value.abs() < MIN_CHANGE { 0.0 } else { value }
}

/// What follows from the one that is followed.
fn of_following(
    encounter: &Encounter<'_>,
    value: impl FnOnce(&Following) -> Result<f64, NoValue>,
) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following.and_then(|following| value(&following)).into()
}

pub(in crate::metrics) const HEADWAY: Measure = Measure::new(
    "headway",
    "headway",
    "m",
    Danger::Low,
    "gap along the lane, front to rear (Jansson 2005)",
    |e| of_following(e, |f| Ok(f.gap)),
);

pub(in crate::metrics) const TIME_GAP: Measure = Measure::new(
    "time_gap",
    "time gap",
    "s",
    Danger::Low,
    "headway over the ego's speed (TGAP of SUMO)",
    |e| {
        of_following(e, |f| {
            let speed = f.ego.velocity.x;
            if speed < STANDSTILL_SPEED {
                Err(NoValue::Standing)
            } else {
                Ok(f.gap / speed)
            }
        })
    },
);

/// Slower than this a vehicle stands, m/s.
const STANDSTILL_SPEED: f64 = 0.1;

pub(in crate::metrics) const TIME_HEADWAY: Measure = Measure::new(
    "thw",
    "time headway",
    "s",
    Danger::Low,
    "recorded time until the ego is where the other's rear is now (Jansson 2005)",
    |e| e.ask(time_until_there).into(),
)
.reading_ahead();

fn time_until_there(
    context: &Context<'_>,
    participant: usize,
    index: usize,
) -> Result<f64, NoValue> {
    let rear = context.following(participant, index)?.other.rear;
    let reached = context
        .ego_reaches(rear, index)
        .ok_or(NoValue::NotReached)?;
    // On the way to that step; a gap in the recording before it hides when.
    let front = |index| context.ego_along(index).map(|ego| ego.front);
    let before = reached.checked_sub(1).filter(|before| *before >= index);
    let late = match (before.and_then(|before| front(before).ok()), front(reached)) {
        (Some(before), Ok(front)) if front > before => (front - rear) / (front - before),
        _ => 0.0,
    };
    Ok(context.time(index, reached as f64 - late.clamp(0.0, 1.0)))
}

pub(in crate::metrics) const LANE_TTC: Measure = Measure::new(
    "ttc_lane",
    "time to collision along the lane",
    "s",
    Danger::Low,
    "headway, speeds and accelerations along the lane (Jansson 2005, eq. 5.26); up to 100 s",
    lane_ttc,
);

/// Later collisions are none, seconds.
const HORIZON: f64 = 100.0;

fn lane_ttc(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    match following {
        Err(NoValue::Contact) => Reading::Value(0.0),
        following => following.and_then(|f| lane_time_to_collision(&f)).into(),
    }
}

/// The time to collision of a follower, seconds.
pub(super) fn lane_time_to_collision(following: &Following) -> Result<f64, NoValue> {
    let (velocity, acceleration) = (following.velocity(), following.acceleration());
    match root(following.gap, velocity, acceleration) {
        Some(time) if time <= HORIZON => Ok(time),
        Some(_) => Err(NoValue::NoContact),
        None if velocity < 0.0 => Err(NoValue::NoContact),
        None => Err(NoValue::NotApproaching),
    }
}

/// The first time after now at which gap + v·t + ½a·t² is 0.
fn root(gap: f64, v: f64, a: f64) -> Option<f64> {
    let inside = v * v - 2.0 * a * gap;
    if inside < 0.0 {
        return None;
    }
    let below = inside.sqrt() - v;
    (below > 0.0).then(|| 2.0 * gap / below)
}

pub(in crate::metrics) const DRAC: Measure = Measure::new(
    "drac",
    "deceleration rate to avoid a crash",
    "m/s²",
    Danger::High,
    "½·Δv²/Δd, with the half as in SUMO",
    |e| of_following(e, deceleration_rate),
);

/// The deceleration, m/s², positive.
pub(super) fn deceleration_rate(following: &Following) -> Result<f64, NoValue> {
    let closing = following.closing()?;
    Ok(closing * closing / (2.0 * following.gap))
}

pub(in crate::metrics) const LATERAL_ACCELERATION: Measure = Measure::new(
    "a_lat_req",
    "required lateral acceleration",
    "m/s²",
    Danger::High,
    "to be clear of the other's side at ttc_lane (Jansson 2005, 5.3.8); a magnitude",
    |e| of_following(e, lateral_acceleration_required),
);

/// The required acceleration, m/s², not negative.
fn lateral_acceleration_required(following: &Following) -> Result<f64, NoValue> {
    let time = lane_time_to_collision(following)?;
    let (ego, other) = (&following.ego, &following.other);
    let leftward = ego.velocity.y - other.velocity.y;
    let needed = |way: f64, velocity: f64| (2.0 * (way - velocity * time) / (time * time)).max(0.0);
    let left = needed(other.left - ego.right, leftward);
    let right = needed(ego.left - other.right, -leftward);
    Ok(left.min(right))
}

pub(in crate::metrics) const STEER_THREAT: Measure = Measure::new(
    "stn",
    "steer-threat number",
    "",
    Danger::High,
    "a_lat_req over steer_threat (Hosseini 2016)",
    |e| {
        let most = e.thresholds().limits.steer_threat;
        of_following(e, |f| Ok(lateral_acceleration_required(f)? / most))
    },
);

pub(in crate::metrics) const LONGITUDINAL_ACCELERATION: Measure = Measure::new(
    "a_long_req",
    "required longitudinal acceleration",
    "m/s²",
    Danger::Low,
    "a_other − Δv²/(2Δd), at most 0 (Jansson 2005, 5.3.5); negative is braking",
    |e| of_following(e, longitudinal_acceleration_required),
);

/// The required acceleration, m/s², not positive.
fn longitudinal_acceleration_required(following: &Following) -> Result<f64, NoValue> {
    let closing = following.closing()?;
    Ok((following.other.acceleration - closing * closing / (2.0 * following.gap)).min(0.0))
}

pub(in crate::metrics) const BRAKE_THREAT: Measure = Measure::new(
    "btn",
    "brake-threat number",
    "",
    Danger::High,
    "a_long_req over −brake_threat (Åsljung 2017)",
    |e| {
        let most = e.thresholds().limits.brake_threat;
        of_following(e, |f| {
            Ok(longitudinal_acceleration_required(f)? / -most + 0.0)
        })
    },
);

#[cfg(test)]
mod tests {
    use super::root;

    #[test]
    fn roots_solve_the_equation() {
        for (gap, v, a) in [
            (20., -5., 0.),
            (20., -5., 0.4),
            (20., 3., -1.),
            (20., -5., -1.),
            (20., 0., -2.),
        ] {
            let t: f64 = root(gap, v, a).unwrap_or_else(|| panic!("{gap} {v} {a}"));
            assert!(
                t > 0.0 && (gap + v * t + a * t * t / 2.0).abs() < 1e-9,
                "{t}"
            );
        }
        assert_eq!(root(20., 5., 0.), None, "moving apart");
        assert_eq!(root(20., -5., 2.), None, "the other speeds up in time");
        // 10 m at 5 m/s and −1 m/s²: 10 − 5t + t²/2 has no double root, its first is 5 − √5.
        assert!(root(10., -5., 1.).is_some_and(|t| (t - (5.0 - 5.0_f64.sqrt())).abs() < 1e-12));
    }
}
