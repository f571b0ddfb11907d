//! A driver's ride along the ego's path, and the first contact on it.

use nearmiss_base::geometry::{Placed, Sweep, Vector};
use nearmiss_scene::metrics::{ContactSide, DEEP, sides};
use nearmiss_scene::scenario::{Ego, Motion, Sample, Track, driven_way};

use super::field::{Field, Nearby, Other};
use super::model::{Driver, Now, Seen};

/// What became of a driver.
#[derive(Debug, Clone, PartialEq)]
pub struct Ride {
    /// Each step, from the one at which the driver takes the wheel until then.
    pub states: Vec<RideState>,
    /// The first step at which something made it react.
    pub reacts: Option<i64>,
    /// What it touches first.
    pub touch: Option<Touch>,
}

/// A step of a ride.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RideState {
    /// The step.
    pub step: i64,
    /// Where it is.
    pub spot: Spot,
    /// The acceleration along the path on the way there, m/s².
    pub acceleration: f64,
}

/// A contact on a ride.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// With whom.
    pub obstacle: i64,
    /// The first step at or after it.
    pub step: i64,
    /// The speed of one relative to the other, m/s.
    pub closing_speed: f64,
    /// The side of the ego that is touched.
    pub ego: ContactSide,
    /// The side of the other that is touched.
    pub other: ContactSide,
    /// Both velocities, m/s.
    pub velocities: [Vector; 2],
}

impl Touch {
    /// Whether the other's front runs into the ego's rear: not where the ego backs into it.
    #[must_use]
    pub fn is_from_behind(&self) -> bool {
        let [own, other] = self.velocities.map(|velocity| velocity.norm());
        self.ego == ContactSide::Rear && self.other == ContactSide::Front && other > own
    }
}

/// A place beside the ego's path, and how fast it is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Arc length, metres.
    pub s: f64,
    /// Offset to the left, metres.
    pub aside: f64,
    /// Heading from that of the path, radians.
    pub turned: f64,
    /// Speed along the path, m/s.
    pub speed: f64,
}

impl Spot {
    /// One on the path.
    pub(super) fn on_path(s: f64, speed: f64) -> Self {
        Self {
            s,
            aside: 0.0,
            turned: 0.0,
            speed,
        }
    }

    /// The speed along its own heading, m/s.
    fn own_speed(&self) -> f64 {
        self.speed / self.turned.cos()
    }
}

/// What is done until the next step.
enum Choice {
    /// As it was recorded.
    AsRecorded,
    /// As in ordinary driving.
    Ordinary,
    /// A driver's reaction, m/s².
    Reaction(f64),
}

/// Nobody changes speed more in ordinary driving, m/s²: the deceleration that is comfortable for most (AASHTO's Green
/// Book), from which on braking makes a conflict.
const ORDINARY: f64 = 3.4;

impl Field<'_> {
    /// The steps at which a driver can take the wheel.
    #[must_use]
    pub fn steps(&self) -> std::ops::Range<i64> {
        self.first..self.first + self.ego.len() as i64
    }

    /// The ego as it was recorded, from the first step on.
    #[must_use]
    pub fn recorded(&self) -> Ride {
        self.follow(self.first, |_, _| Choice::AsRecorded)
    }

    /// Puts a driver in the seat at a step. Until something makes it react it drives as the ego was recorded, but brakes
    /// no harder than in ordinary driving: the ego's own evasion is not the driver's. A reaction only makes it slower, and
    /// afterwards it keeps its speed, or gets as slow as the ego got in ordinary driving.
    pub fn ride(&self, driver: &mut dyn Driver, from: i64) -> Ride {
        let mut seen: Vec<Seen> = Vec::with_capacity(self.others.len());
        self.follow(from, |step, (s, speed, acceleration)| {
            self.see(step, s, &mut seen);
            let wanted = driver.react(&Now {
                dt: self.lookout.dt,
                speed,
                acceleration,
                others: &seen,
                alarmed: false,
            });
            wanted.map_or(Choice::Ordinary, Choice::Reaction)
        })
    }

    /// Drives from a step on: `choose` is told the step, arc length, speed and acceleration.
    fn follow(&self, from: i64, mut choose: impl FnMut(i64, (f64, f64, f64)) -> Choice) -> Ride {
        let mut ride = Ride {
            states: Vec::with_capacity((self.last - from + 1).max(0) as usize),
            reacts: None,
            touch: None,
        };
        let recorded = |step: i64| self.ego.get((step - self.first) as usize).copied();
        let Some((mut s, mut speed)) = recorded(from) else {
            return ride;
        };
        let before = recorded(from - 1).map_or(speed, |(_, before)| before);
        let mut acceleration = (speed - before) / self.lookout.dt;
        ride.touch = self.overlap(from, s, speed);
        ride.states.push(RideState {
            step: from,
            spot: Spot::on_path(s, speed),
            acceleration,
        });
        let mut is_as_recorded = true;
        let dt = self.lookout.dt;
        let most = ORDINARY * dt;
        for step in from..self.last {
            if ride.touch.is_some() {
                break;
            }
            let was = Spot::on_path(s, speed);
            let choice = choose(step, (s, speed, acceleration));
            let next = recorded(step + 1);
            if let Choice::Reaction(_) = choice {
                ride.reacts.get_or_insert(step);
            }
            (s, speed) = match (choice, next) {
                (Choice::AsRecorded, Some(next)) => next,
                (Choice::Ordinary, Some(next)) if is_as_recorded && next.1 >= speed - most => next,
                (choice, next) => {
                    is_as_recorded = false;
                    let ordinary = next.map_or(speed, |(_, wanted)| wanted.max(speed - most));
                    let wanted = match choice {
                        Choice::Reaction(acceleration) => speed + acceleration * dt,
                        // Who reacted does not speed up again.
                        _ if ride.reacts.is_some() => speed,
                        _ => speed + most,
                    };
                    advance(s, speed, (wanted.min(ordinary) - speed) / dt, dt)
                }
            };
            acceleration = (speed - was.speed) / dt;
            let now = Spot::on_path(s, speed);
            ride.touch = self.touch(step, &was, &now);
            ride.states.push(RideState {
                step: step + 1,
                spot: now,
                acceleration,
            });
        }
        ride
    }

    /// The ego as a ride moves it: as it was recorded until then.
    #[must_use]
    pub fn ego_of(&self, ride: &Ride) -> Ego {
        let own = &self.scene.ego;
        let backwards = own.track.at(self.first).is_some_and(|m| m.velocity < 0.0);
        let sign = if backwards { -1.0 } else { 1.0 };
        let from = ride.states.first().map_or(i64::MAX, |state| state.step);
        let recorded = { own.track.iter() }.filter(|(step, _)| *step <= from);
        let before = recorded.map(|(step, motion)| (step, *motion));
        let after = ride.states.iter().skip(1).filter_map(|state| {
            let motion = Motion {
                pose: self.pose(&state.spot)?,
                velocity: sign * state.spot.own_speed(),
                acceleration: sign * state.acceleration,
            };
            Some((state.step, motion))
        });
        let samples = before.chain(after).map(|(step, motion)| Sample {
            step,
            position: motion.pose.position,
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        });
        Ego {
            track: Track::new(samples.collect(), self.lookout.dt, None),
            ..own.clone()
        }
    }

    /// What overlaps the ego at a step already.
    pub(super) fn overlap(&self, step: i64, s: f64, speed: f64) -> Option<Touch> {
        let spot = Spot::on_path(s, speed);
        self.touch(step - 1, &spot, &spot).filter(|touch| {
            let other = self
                .others
                .iter()
                .find(|o| o.participant.obstacle.id == touch.obstacle);
            let place = other.and_then(|o| o.places[(step - self.first) as usize]);
            let (own, footprint) = (
                self.own_at(&spot),
                other.map(|o| o.participant.footprint_at(step)),
            );
            match (own, place, footprint) {
                (Some(own), Some(place), Some(footprint)) => {
                    own.distance(&footprint.at(place.pose)) <= 0.0
                }
                _ => false,
            }
        })
    }

    /// The first contact on the way from a step to the next.
    pub(super) fn touch(&self, step: i64, was: &Spot, now: &Spot) -> Option<Touch> {
        let mut first: Option<(f64, Touch)> = None;
        self.each_near(step, [was, now], |other, ends| {
            let touch = self.touch_with(other, step, [(was, ends[0]), (now, ends[1])]);
            if let Some((share, touch)) = touch
                && first.as_ref().is_none_or(|(earliest, _)| share < *earliest)
            {
                first = Some((share, touch));
            }
        });
        first.map(|(_, touch)| touch)
    }

    /// The contact with an obstacle on the last step of a ride: it may touch another one in the same step first.
    pub(super) fn last_touch_with(&self, obstacle: i64, ride: &Ride) -> Option<Touch> {
        let [.., was, now] = &ride.states[..] else {
            return ride.touch.filter(|touch| touch.obstacle == obstacle);
        };
        let (mut found, spots) = (None, [&was.spot, &now.spot]);
        self.each_near(was.step, spots, |other, ends| {
            if other.participant.obstacle.id == obstacle {
                let ways = [(spots[0], ends[0]), (spots[1], ends[1])];
                found = self.touch_with(other, was.step, ways);
            }
        });
        found.map(|(_, touch)| touch)
    }

    /// Whether there is a contact on the way from a step to the next, and the least closing speed (m/s) that it may have.
    pub(super) fn least_closing_speed(&self, step: i64, was: &Spot, now: &Spot) -> Option<f64> {
        let at = usize::try_from(step + 1 - self.first).ok()?;
        let (mut least, mut touches) = (f64::INFINITY, false);
        self.each_near(step, [was, now], |other, ends| {
            let Some(to) = other.places[at].as_ref() else {
                return;
            };
            let body = other.participant.footprint_at(step + 1).at(to.pose);
            // Who is in it at the end touched it on the way.
            touches = touches || ends[1].overlap(&body) > INSIDE || {
                self.touch_with(other, step, [(was, ends[0]), (now, ends[1])])
            }
            .is_some();
            let before = at.checked_sub(1).and_then(|at| other.places[at].as_ref());
            let velocity = before.map_or(to.velocity, |before| before.velocity);
            let forward = ends[1].pose.forward();
            let apart = forward * was.own_speed() - velocity;
            let change = forward * now.own_speed() - to.velocity - apart;
            let share = match change.norm_squared() {
                0.0 => 0.0,
                length => (-apart.dot(&change) / length).clamp(0.0, 1.0),
            };
            least = least.min((apart + change * share).norm());
        });
        touches.then_some(least)
    }

    /// Whether a place lies on the ego's path, not beyond its end: where the way goes on there is not known, and others than the
    /// one in the encounter do not count.
    #[must_use]
    pub fn is_on_way(&self, spot: &Spot) -> bool {
        spot.s <= self.lookout.path.length()
    }

    /// All road users that the ego may touch on the way from a step to the next, with its body at both.
    fn each_near<'f>(
        &'f self,
        step: i64,
        [was, now]: [&Spot; 2],
        mut work: impl FnMut(&'f Other<'f>, [Placed<'f>; 2]),
    ) {
        let at = usize::try_from(step + 1 - self.first).ok();
        let all = at.and_then(|at| self.near.get(at)).into_iter().flatten();
        let moved = (now.s - was.s).abs();
        let is_known = self.is_on_way(now);
        let counts = |near: &Nearby| {
            is_known || self.others[near.other].participant.obstacle.id == self.obstacle
        };
        let reached = all.filter(|near| near.is_reached(now, moved));
        let mut near = reached.filter(|near| counts(near)).peekable();
        if near.peek().is_none() {
            return;
        }
        let (Some(from), Some(to)) = (self.own_at(was), self.own_at(now)) else {
            return;
        };
        let own = self.body.between(&from.pose, &to.pose);
        for near in near {
            if !near.body.as_ref().is_some_and(|body| own.is_apart(body)) {
                work(&self.others[near.other], [from, to]);
            }
        }
    }

    fn touch_with(
        &self,
        other: &Other<'_>,
        step: i64,
        [(was, own_from), (now, own)]: [(&Spot, Placed<'_>); 2],
    ) -> Option<(f64, Touch)> {
        let at = (step + 1 - self.first) as usize;
        let to = other.places.get(at)?.as_ref()?;
        let body = other.participant.footprint_at(step + 1).at(to.pose);
        let earlier = at.checked_sub(1).and_then(|at| other.places[at].as_ref());
        let from = earlier.map(|from| other.participant.footprint_at(step).at(from.pose));
        let way = from.and_then(|from| driven_way(from, body, self.lookout.dt));
        let (share, sides_at, velocity) = match way {
            Some(way) => {
                let own_way = Sweep::new(own_from, own);
                let share = own_way.first_touch(&way)?;
                let deep = (share + DEEP).min(1.0);
                let before = earlier.map_or(to.velocity, |from| from.velocity);
                let velocity = before + (to.velocity - before) * share;
                (share, sides(&own_way.at(deep), &way.at(deep)), velocity)
            }
            None => {
                (own.distance(&body) <= 0.0).then_some(())?;
                (1.0, sides(&own, &body), to.velocity)
            }
        };
        let speed = was.own_speed() + (now.own_speed() - was.own_speed()) * share;
        let mine = own.pose.forward() * speed;
        let touch = Touch {
            obstacle: other.participant.obstacle.id,
            step: step + 1,
            closing_speed: (mine - velocity).norm(),
            ego: sides_at[0],
            other: sides_at[1],
            velocities: [mine, velocity],
        };
        Some((share, touch))
    }
}

/// Bodies that are deeper in each other overlap for sure, metres.
const INSIDE: f64 = 1e-6;

/// Arc length and speed a step later: evenly faster or slower, to a standstill at most.
pub(super) fn advance(s: f64, speed: f64, acceleration: f64, dt: f64) -> (f64, f64) {
    let next = speed + acceleration * dt;
    if next >= 0.0 {
        return (s + f64::midpoint(speed, next) * dt, next);
    }
    // It stands before the step is over.
    (s + speed * speed / (-2.0 * acceleration), 0.0)
}
