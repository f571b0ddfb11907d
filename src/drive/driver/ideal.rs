//! The ideal driver: knows every future motion, reacts at once and uses all that its vehicle can. No model of a person,
//! but the bound that none can beat.
//!
//! Around an event of a recording it is looked for along the ego's path: one acceleration until a speed, and one offset to a
//! side, as far as the friction circle, the turning radius and the road let it. Where none of these avoids the contact, what
//! another driver does is tried: so none is better.

use nearmiss_base::geometry::{Area, Point};

use super::field::Field;
use super::model::{DriverModel, Parameter};
use super::ride::{Ride, RideState, Spot, Touch, advance};

/// A row of [`super::DRIVERS`].
pub const MODEL: DriverModel = DriverModel {
    id: "ideal",
    name: "ideal driver",
    formula: "one acceleration until a speed and one offset from the path, tried against the recorded future of all others",
    parameters: &[
        Parameter {
            symbol: "a",
            value: MOST,
            unit: "m/s²",
            what: "acceleration along and across together",
        },
        Parameter {
            symbol: "f",
            value: FORWARD,
            unit: "m/s²",
            what: "speeding up",
        },
        Parameter {
            symbol: "r",
            value: RADIUS,
            unit: "m",
            what: "least turning radius",
        },
    ],
    source: "CommonRoad vehicle 2 (Althoff and Würsching, 2020) for a; AASHTO's Green Book for r; the rest is ours",
    limits: "no person: it knows the future; that it finds nothing does not prove that there is nothing",
    not_made_for: &[],
    following_gap: None,
    begin: None,
};

const MOST: f64 = 11.5;
const FORWARD: f64 = 3.5;
const RADIUS: f64 = 5.9;

/// Accelerations (m/s²) and the share of the speed at which they end; mild ones last, so that hard cases are found early.
const ALONG: [(f64, f64); 11] = [
    (-MOST, 0.0),
    (-0.6 * MOST, 0.0),
    (-0.3 * MOST, 0.0),
    (0.0, 1.0),
    (-MOST, 0.5),
    (-0.6 * MOST, 0.7),
    (-0.15 * MOST, 0.0),
    (-MOST, 0.8),
    (FORWARD, 1.3),
    (FORWARD, 2.0),
    (0.5 * FORWARD, 1.3),
];

/// Offsets to either side, metres.
const ASIDE: [f64; 6] = [0.5, 1.0, 1.75, 2.5, 3.0, 3.5];

/// Shares of the friction circle for steering.
const GRIP: [f64; 2] = [0.5, 0.95];

/// The largest second derivative of the smooth step 10τ³ - 15τ⁴ + 6τ⁵, and the largest first one.
const BEND: f64 = 5.773_502_691_896_258;
const SLOPE: f64 = 1.875;

/// The largest angle to the path, as its tangent.
const STEEPEST: f64 = 0.5;

/// A motion of the ideal driver.
#[derive(Debug, Clone, Copy)]
struct Manoeuvre {
    acceleration: f64,
    until: f64,
    aside: f64,
    /// Over which way it gets to the side, metres.
    over: f64,
}

impl Field<'_> {
    /// The ideal driver from a step on: its ride without contact, if one is found, else that of the lowest closing speed.
    #[must_use]
    pub fn ideal_ride(&self, from: i64) -> Option<Ride> {
        let at = usize::try_from(from - self.first).ok()?;
        let (s, speed) = *self.ego.get(at)?;
        let mut best: Option<Ride> = None;
        let road = std::cell::OnceCell::new();
        for manoeuvre in manoeuvres(speed) {
            let Some(ride) = self.manoeuvre(&manoeuvre, from, s, speed, &road) else {
                continue;
            };
            let Some(touch) = &ride.touch else {
                return Some(ride);
            };
            let harm = |ride: &Ride| ride.touch.as_ref().map_or(0.0, |t: &Touch| t.closing_speed);
            if best
                .as_ref()
                .is_none_or(|best| touch.closing_speed < harm(best))
            {
                best = Some(ride);
            }
        }
        best
    }

    /// `None` where it leaves the road.
    fn manoeuvre(
        &self,
        manoeuvre: &Manoeuvre,
        from: i64,
        mut s: f64,
        mut speed: f64,
        road: &std::cell::OnceCell<Option<Area>>,
    ) -> Option<Ride> {
        let start = s;
        let spot = |s: f64, speed: f64| {
            if manoeuvre.aside == 0.0 {
                return Spot::on_path(s, speed);
            }
            let t = ((s - start) / manoeuvre.over).clamp(0.0, 1.0);
            let slope = 30.0 * t * t * (1.0 - t) * (1.0 - t) / manoeuvre.over;
            Spot {
                s,
                aside: manoeuvre.aside * t * t * t * (10.0 + t * (6.0 * t - 15.0)),
                turned: (manoeuvre.aside * slope).atan(),
                speed,
            }
        };
        let mut ride = Ride {
            states: Vec::new(),
            reacts: Some(from),
            touch: None,
        };
        ride.touch = self.overlap(from, s, speed);
        let mut was = spot(s, speed);
        ride.states.push(RideState {
            step: from,
            spot: was,
            acceleration: 0.0,
        });
        for step in from..self.last {
            if ride.touch.is_some() {
                break;
            }
            let a = manoeuvre.acceleration;
            let left = (manoeuvre.until - speed) / self.lookout.dt;
            let used = if a < 0.0 {
                a.max(left).min(0.0)
            } else {
                a.min(left).max(0.0)
            };
            (s, speed) = advance(s, speed, used, self.lookout.dt);
            let now = spot(s, speed);
            ride.touch = self.touch(step, &was, &now);
            if now.aside != 0.0 && ride.touch.is_none() && !self.is_on_road(&now, road) {
                return None;
            }
            ride.states.push(RideState {
                step: step + 1,
                spot: now,
                acceleration: used,
            });
            was = now;
        }
        Some(ride)
    }

    /// Whether the ego's body is on the road there, as far as it is known and the ego itself keeps to it.
    fn is_on_road(&self, spot: &Spot, road: &std::cell::OnceCell<Option<Area>>) -> bool {
        let road = road.get_or_init(|| self.road());
        let Some(road) = road else {
            return true;
        };
        let body = self.own_at(spot);
        body.is_some_and(|body| road.covers(&body))
    }

    /// The lanelets near the path; `None` without a map, or where the ego starts off the road.
    fn road(&self) -> Option<Area> {
        let end = self.ego.last()?.0;
        let near = |p: &Point| {
            [0.0, end / 2.0, end]
                .iter()
                .filter_map(|s| self.lookout.path.at(*s))
                .any(|pose| (pose.position - p).norm() <= end / 2.0 + NEAR)
        };
        let lanelets = self
            .scene
            .scenario
            .network
            .lanelets
            .iter()
            .map(|l| l.ring());
        let rings: Vec<_> = lanelets.filter(|ring| ring.iter().any(near)).collect();
        let area = Area::union(rings.iter().map(Vec::as_slice), GAP);
        let starts_on = area.covers(&self.own_at(&Spot::on_path(self.ego[0].0, 0.0))?);
        starts_on.then_some(area)
    }
}

/// Lanelets are looked at within this of the path, metres; gaps between them up to that are road.
const NEAR: f64 = 40.0;
const GAP: f64 = 0.1;

/// Straight on first, and to the sides then.
fn manoeuvres(speed: f64) -> impl Iterator<Item = Manoeuvre> {
    let straight = ALONG
        .into_iter()
        .map(move |(acceleration, share)| Manoeuvre {
            acceleration,
            until: share * speed,
            aside: 0.0,
            over: 1.0,
        });
    let sides = ASIDE.into_iter().flat_map(|aside| [aside, -aside]);
    let steered = sides.flat_map(move |aside: f64| {
        GRIP.into_iter().flat_map(move |grip| {
            let across = grip * MOST;
            let bend = BEND * aside.abs();
            // As short as friction, turning radius and angle to the path let it be.
            let over = (speed * (bend / across).sqrt())
                .max((bend * RADIUS).sqrt())
                .max(SLOPE * aside.abs() / STEEPEST);
            let room = (MOST * MOST - across * across).sqrt();
            ALONG
                .into_iter()
                .map(move |(acceleration, share)| Manoeuvre {
                    acceleration: acceleration.max(-room),
                    until: share * speed,
                    aside,
                    over,
                })
        })
    });
    straight.chain(steered)
}
