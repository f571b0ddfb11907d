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
const ASIDE: [f64; 6] = [0.5, 1.0, 1.75, 2.5, 3.0, FARTHEST];

/// No driver gets farther beside the path, metres.
pub(super) const FARTHEST: f64 = 3.5;

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

impl Manoeuvre {
    /// The place at an arc length (m) of who began it at `start`.
    fn spot(&self, start: f64, s: f64, speed: f64) -> Spot {
        if self.aside == 0.0 {
            return Spot::on_path(s, speed);
        }
        let t = ((s - start) / self.over).clamp(0.0, 1.0);
        let slope = 30.0 * t * t * (1.0 - t) * (1.0 - t) / self.over;
        Spot {
            s,
            aside: self.aside * t * t * t * (10.0 + t * (6.0 * t - 15.0)),
            turned: (self.aside * slope).atan(),
            speed,
        }
    }

    /// The acceleration at a speed, m/s².
    fn acceleration_at(&self, speed: f64, dt: f64) -> f64 {
        let left = (self.until - speed) / dt;
        match self.acceleration {
            a if a < 0.0 => a.max(left).min(0.0),
            a => a.min(left).max(0.0),
        }
    }
}

impl Field<'_> {
    /// The ideal driver from a step on: its ride without contact, if one is found, else that of the lowest closing speed.
    #[must_use]
    pub fn ideal_ride(&self, from: i64) -> Option<Ride> {
        let at = usize::try_from(from - self.first).ok()?;
        let (s, speed) = *self.ego.get(at)?;
        let begin = RideState {
            step: from,
            spot: Spot::on_path(s, speed),
            acceleration: 0.0,
        };
        let ride = |states: Vec<RideState>, touch: Option<Touch>| Ride {
            states,
            reacts: Some(from),
            touch,
        };
        if let Some(touch) = self.overlap(from, s, speed) {
            return Some(ride(vec![begin], Some(touch)));
        }
        let mut contacts: Vec<(Manoeuvre, i64, f64)> = Vec::new();
        for manoeuvre in manoeuvres(speed) {
            match self.first_contact(&manoeuvre, begin) {
                Some((step, least)) => contacts.push((manoeuvre, step, least)),
                None => {
                    let states = self.states(&manoeuvre, begin, self.last);
                    if self.keeps_to_road(&states) {
                        return Some(ride(states, None));
                    }
                }
            }
        }
        // The way of a contact and the road are dear: they are looked at of those alone that may be the slowest.
        let mut best: Option<(usize, Ride, f64)> = None;
        let mut order: Vec<usize> = (0..contacts.len()).collect();
        order.sort_by(|a, b| contacts[*a].2.total_cmp(&contacts[*b].2));
        for place in order {
            let (manoeuvre, step, least) = &contacts[place];
            if best
                .as_ref()
                .is_some_and(|(_, _, slowest)| *least > slowest + ROUNDING)
            {
                break;
            }
            let states = self.states(manoeuvre, begin, *step);
            let [before @ .., was, now] = &states[..] else {
                continue;
            };
            let Some(touch) = self.touch(was.step, &was.spot, &now.spot) else {
                continue;
            };
            // Of equals the first one.
            let is_better = best.as_ref().is_none_or(|(known, _, slowest)| {
                (touch.closing_speed, place) < (*slowest, *known)
            });
            let speed = touch.closing_speed;
            if is_better && self.keeps_to_road(before) && self.keeps_to_road(&[*was]) {
                best = Some((place, ride(states, Some(touch)), speed));
            }
        }
        best.map(|(_, ride, _)| ride)
    }

    /// The first step after which a manoeuvre has touched another road user, and its least closing speed then (m/s).
    fn first_contact(&self, manoeuvre: &Manoeuvre, begin: RideState) -> Option<(i64, f64)> {
        let mut was = begin;
        (begin.step..self.last).find_map(|step| {
            let now = self.next(manoeuvre, &begin, &was);
            let least = self.least_closing_speed(step, &was.spot, &now.spot);
            was = now;
            Some((step + 1, least?))
        })
    }

    /// The states of a manoeuvre until a step.
    fn states(&self, manoeuvre: &Manoeuvre, begin: RideState, until: i64) -> Vec<RideState> {
        let next = |was: &RideState| Some(self.next(manoeuvre, &begin, was));
        let all = std::iter::successors(Some(begin), next);
        all.take_while(|state| state.step <= until).collect()
    }

    /// The state a step later.
    fn next(&self, manoeuvre: &Manoeuvre, begin: &RideState, was: &RideState) -> RideState {
        let dt = self.lookout.dt;
        let acceleration = manoeuvre.acceleration_at(was.spot.speed, dt);
        let (s, speed) = advance(was.spot.s, was.spot.speed, acceleration, dt);
        RideState {
            step: was.step + 1,
            spot: manoeuvre.spot(begin.spot.s, s, speed),
            acceleration,
        }
    }

    /// Whether all of a ride that leaves the path is on the road; its end, which is farthest from the path, first.
    fn keeps_to_road(&self, states: &[RideState]) -> bool {
        let mut aside = { states.iter().rev() }.filter(|state| state.spot.aside != 0.0);
        aside.all(|state| self.is_on_road(&state.spot))
    }

    /// Whether the ego's body is on the road there, as far as it is known and the ego itself keeps to it.
    fn is_on_road(&self, spot: &Spot) -> bool {
        let Some(body) = self.own_at(spot) else {
            return false;
        };
        let [lanelets, road] = &self.road;
        let lanelets = lanelets.get_or_init(|| self.find_road(0.0));
        // Gaps are dear to close.
        lanelets.as_ref().is_some_and(|area| area.covers(&body)) || {
            road.get_or_init(|| self.find_road(GAP))
        }
        .as_ref()
        .is_none_or(|area| area.covers(&body))
    }

    /// The lanelets near the path, with gaps (m) between them closed; `None` without a map, or where the ego starts off the
    /// road.
    fn find_road(&self, gap: f64) -> Option<Area> {
        let end = self.ego.last()?.0;
        let at = |s: f64| Some(self.lookout.path.at(s)?.position);
        let around = [0.0, end / 2.0, end].map(at);
        let far = end / 2.0 + NEAR;
        let near = |p: &Point| around.iter().flatten().any(|at| (at - p).norm() <= far);
        // Of what lies farther beside the path no body is.
        let beside = FARTHEST + self.body.reach() + STRIDE;
        let strides = (0..=((end + far) / STRIDE) as usize).filter_map(|n| at(n as f64 * STRIDE));
        let strides: Vec<Point> = strides.collect();
        let is_beside = |ring: &[Point]| {
            let first = ring.first().copied().unwrap_or_default();
            let low = ring.iter().fold(first, |low, p| low.inf(p));
            let high = ring.iter().fold(first, |high, p| high.sup(p));
            let apart = |p: &Point| (p - p.sup(&low).inf(&high)).norm();
            strides.iter().any(|p| apart(p) <= beside)
        };
        let lanelets = self.scene.scenario.network.lanelets.iter();
        let rings = lanelets.map(|lanelet| lanelet.ring());
        let rings: Vec<_> = rings
            .filter(|ring| ring.iter().any(near) && is_beside(ring))
            .collect();
        let area = Area::union(rings.iter().map(Vec::as_slice), gap);
        let starts_on = area.covers(&self.own_at(&Spot::on_path(self.ego[0].0, 0.0))?);
        starts_on.then_some(area)
    }
}

/// Lanelets are looked at within this of the path, metres.
const NEAR: f64 = 40.0;

/// The path is looked along in steps of this, metres.
const STRIDE: f64 = 5.0;

/// Gaps between lanelets up to this are road, metres.
const GAP: f64 = 0.1;

/// Closing speeds that differ by less are worked out, m/s.
const ROUNDING: f64 = 1e-9;

/// Straight on first, and to the sides then.
/// The speed at which an acceleration ends, m/s: who stands can drive away.
fn until(acceleration: f64, share: f64, speed: f64) -> f64 {
    let share_of = share * speed;
    if acceleration > 0.0 {
        share_of.max(speed + 10.0 * (share - 1.0))
    } else {
        share_of
    }
}

fn manoeuvres(speed: f64) -> impl Iterator<Item = Manoeuvre> {
    let straight = ALONG
        .into_iter()
        .map(move |(acceleration, share)| Manoeuvre {
            acceleration,
            until: until(acceleration, share, speed),
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
                    until: until(acceleration, share, speed),
                    aside,
                    over,
                })
        })
    });
    straight.chain(steered)
}
