//! Manoeuvres with parameters: a target for the attacker at each step, and the space that is searched.

use nearmiss_base::geometry::{Point, Polyline};
use nearmiss_scene::scenario::{Motion, Obstacle};
use nearmiss_scene::verdict::{Manoeuvre, ManoeuvreKind};

use super::attack::MAX_WAY_LENGTH;
use super::attacker::Candidate;
use super::{AttackContext, TrackingTarget};
use crate::planner::Polynomial;

/// Targets from a step on.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The step that it departs from.
    pub from: i64,
    /// The targets at the following steps.
    pub wanted: Vec<Option<TrackingTarget>>,
}

/// Why a manoeuvre is impossible.
pub type Impossible = String;

/// An obstacle that comes this close to the ego's way crosses it or is on it, metres.
const ON_THE_WAY: f64 = 1.5;

/// A standing start: an obstacle that is slower pulls out, m/s.
const STANDING: f64 = 1.0;

/// The speed that an obstacle pulls out with where none is said, m/s.
const PULLING_OUT: f64 = 4.0;

/// A change of lane is done in the last part of the manoeuvre, which is no longer than this, seconds; a drift takes all
/// of it.
const SIDEWAYS: f64 = 1.8;

/// An obstacle that drifts stays there for so long before it goes back to its way, seconds.
const STAY: f64 = 1.0;

/// What is wanted of `obstacle` for a manoeuvre, until the end of its recording or of the ego's motion, whichever is
/// later. `way` names the way it takes among those of [`AttackContext::ways`] where it crosses the ego's: 0 is the
/// first of them that does.
///
/// Gaps are between the bodies, with the ego where it is while no obstacle attacks it: behind the attacker's rear for
/// cutting in; to the side for drifting and door-to-door (without one, a drift aims at the ego's own line); before the
/// crossing for those who cross the ego's way, who then arrive when the ego has this left to it, whatever the duration
/// says.
///
/// # Errors
/// The obstacle is not there, or its ways do not allow it.
pub fn plan(
    stage: &AttackContext<'_>,
    obstacle: &Obstacle,
    manoeuvre: &Manoeuvre,
    way: usize,
) -> Result<Plan, Impossible> {
    let from = stage.step_at(manoeuvre.start);
    let now = *obstacle.track().at(from).ok_or_else(|| {
        format!(
            "obstacle {} is absent when its manoeuvre should start",
            obstacle.id
        )
    })?;
    let ways = stage.ways(obstacle, from);
    let recorded = ways
        .first()
        .ok_or_else(|| format!("obstacle {} has no route", obstacle.id))?;
    let last = obstacle.track().steps().end - 1;
    let aim = Aim {
        stage,
        obstacle,
        manoeuvre,
        from,
        now,
        steps: (last.max(*stage.steps.end()) - from).max(0) as usize,
    };
    let wanted = match manoeuvre.kind {
        ManoeuvreKind::HardBrake => {
            let speed = manoeuvre.speed.unwrap_or(0.0);
            if speed >= now.velocity {
                return Err(format!(
                    "obstacle {} is too slow to brake: the target speed is not below its own",
                    obstacle.id
                ));
            }
            aim.along(recorded, manoeuvre.duration, speed)
        }
        ManoeuvreKind::CutIn => aim.cut_in(recorded)?,
        ManoeuvreKind::Drift => aim.drift(recorded)?,
        ManoeuvreKind::DoorToDoor => aim.door_to_door(recorded)?,
        ManoeuvreKind::RunTheLight => aim.cross(std::slice::from_ref(recorded), 0)?,
        ManoeuvreKind::LateTurn => aim.cross(&ways[1..], way)?,
        ManoeuvreKind::PullOut => {
            if now.velocity > STANDING {
                return Err(format!(
                    "obstacle {} is not standing when it should pull out",
                    obstacle.id
                ));
            }
            aim.cross(&ways, way)?
        }
    };
    Ok(Plan { from, wanted })
}

struct Aim<'s> {
    stage: &'s AttackContext<'s>,
    obstacle: &'s Obstacle,
    manoeuvre: &'s Manoeuvre,
    from: i64,
    now: Motion,
    /// Steps that are wanted.
    steps: usize,
}

impl Aim<'_> {
    fn size(&self) -> (f64, f64) {
        let shape = self.obstacle.footprint.as_ref().map(|f| f.shape().size());
        shape.unwrap_or((0.0, 0.0))
    }

    /// Seconds after the start, step by step.
    fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let dt = self.stage.dt();
        (1..=self.steps).map(move |k| k as f64 * dt)
    }

    /// Along a way: to `speed` within `duration`, and on with it. Where the way ends nothing more is wanted.
    fn along(&self, way: &Polyline, duration: f64, speed: f64) -> Vec<Option<TrackingTarget>> {
        let profile = Polynomial::quartic([0.0, self.now.velocity, 0.0], [speed, 0.0], duration);
        self.follow(way, |t| course(&profile, t, duration, speed))
    }

    fn follow(
        &self,
        way: &Polyline,
        at: impl Fn(f64) -> (f64, f64),
    ) -> Vec<Option<TrackingTarget>> {
        let wanted = self.times().map(|t| {
            let (s, v) = at(t);
            (s <= way.length()).then(|| wanted(way.pose_at(s.max(0.0)).position, Some(v)))
        });
        wanted.take_while(Option::is_some).collect()
    }

    /// The place of the ego's centre along its way at the end of the manoeuvre, and its speed.
    fn ego_at_end(&self) -> Result<(f64, f64), Impossible> {
        let step = self.from + self.stage.step_at(self.manoeuvre.duration);
        let ego = self.stage.ego_at(step).ok_or("the ego is absent")?;
        let beyond = (step - self.stage.steps.end()).max(0) as f64 * self.stage.dt();
        let s = self.stage.line.project(&ego.pose.position).s;
        Ok((s + ego.velocity * beyond, ego.velocity))
    }

    fn ego_size(&self) -> (f64, f64) {
        self.stage.footprint.shape().size()
    }

    fn cut_in(&self, way: &Polyline) -> Result<Vec<Option<TrackingTarget>>, Impossible> {
        let (ego, ego_speed) = self.ego_at_end()?;
        let lengths = f64::midpoint(self.size().0, self.ego_size().0);
        let gap = self.manoeuvre.gap.unwrap_or(1.0);
        let speed = self.manoeuvre.speed.unwrap_or(ego_speed);
        let here = self.stage.line.project(&self.now.pose.position).s;
        let distance = ego + lengths + gap - here;
        if distance < 0.0 {
            return Err("it would have to drive backwards to get in front of the ego".into());
        }
        Ok(self.lateral_targets(way, Some((distance, speed)), 0.0, None))
    }

    fn drift(&self, way: &Polyline) -> Result<Vec<Option<TrackingTarget>>, Impossible> {
        let to_side = match self.manoeuvre.gap {
            Some(gap) => self.side(way) * (f64::midpoint(self.size().1, self.ego_size().1) + gap),
            None => 0.0,
        };
        let until = self.manoeuvre.duration + STAY;
        Ok(self.lateral_targets(way, None, to_side, Some(until)))
    }

    fn door_to_door(&self, way: &Polyline) -> Result<Vec<Option<TrackingTarget>>, Impossible> {
        let (ego, ego_speed) = self.ego_at_end()?;
        let here = self.stage.line.project(&self.now.pose.position).s;
        if ego < here {
            return Err("it would have to drive backwards to get level with the ego".into());
        }
        let widths = f64::midpoint(self.size().1, self.ego_size().1);
        let to_side = self.side(way) * (widths + self.manoeuvre.gap.unwrap_or(0.3));
        let speed = self.manoeuvre.speed.unwrap_or(ego_speed);
        Ok(self.lateral_targets(way, Some((ego - here, speed)), to_side, None))
    }

    /// 1 where it is on the left of the ego's way, else -1.
    fn side(&self, way: &Polyline) -> f64 {
        let d = self.stage.line.project(&way.pose_at(0.0).position).d;
        1.0_f64.copysign(d)
    }

    /// From its own way to the ego's, `to_side` metres to the left of it, within the duration; back again at `until`
    /// seconds where that is said. `end` are the distance and the speed at the end of the duration, where they are
    /// asked for.
    fn lateral_targets(
        &self,
        way: &Polyline,
        end: Option<(f64, f64)>,
        to_side: f64,
        until: Option<f64>,
    ) -> Vec<Option<TrackingTarget>> {
        let duration = self.manoeuvre.duration;
        let now = self.now.velocity;
        let speed = end.map_or(self.manoeuvre.speed.unwrap_or(now), |(_, v)| v);
        let profile = match end {
            Some((distance, _)) => {
                Polynomial::quintic([0.0, now, 0.0], [distance, speed, 0.0], duration)
            }
            None => Polynomial::quartic([0.0, now, 0.0], [speed, 0.0], duration),
        };
        let line = &self.stage.line;
        let sideways = match self.manoeuvre.kind {
            ManoeuvreKind::Drift => duration,
            _ => duration.min(SIDEWAYS),
        };
        let wanted = self.times().map(|t| {
            let (s, v) = course(&profile, t, duration, speed);
            if s > way.length() {
                return None;
            }
            let own = way.pose_at(s.max(0.0)).position;
            let foot = line.pose_at(line.project(&own).s);
            let there = foot.position + foot.left() * to_side;
            let back = until.map_or(0.0, |until| smooth((t - until) / sideways));
            let share = smooth((t - duration + sideways) / sideways) * (1.0 - back);
            Some(wanted(own + (there - own) * share, Some(v)))
        });
        wanted.take_while(Option::is_some).collect()
    }

    /// Along the `nth` of `ways` that crosses the ego's, so as to be there when the ego has the gap left to it.
    fn cross(
        &self,
        ways: &[Polyline],
        nth: usize,
    ) -> Result<Vec<Option<TrackingTarget>>, Impossible> {
        let crossing = ways
            .iter()
            .filter_map(|way| Some((way, self.crossing(way)?)));
        let (way, (own, ego)) = { crossing }
            .nth(nth)
            .ok_or("none of its routes crosses the ego's")?;
        let duration = match self.manoeuvre.gap {
            Some(gap) => self.arrival(ego - gap)?,
            None => self.manoeuvre.duration,
        };
        let now = self.now.velocity;
        let said = self.manoeuvre.speed;
        let speed = said.unwrap_or(if now > STANDING { now } else { PULLING_OUT });
        let profile = Polynomial::quintic([0.0, now, 0.0], [own, speed, 0.0], duration);
        Ok(self.follow(way, |t| course(&profile, t, duration, speed)))
    }

    /// Where a way first comes onto the ego's: along it, and along the ego's way, metres. Nothing where it begins
    /// there.
    fn crossing(&self, way: &Polyline) -> Option<(f64, f64)> {
        let line = &self.stage.line;
        let places = (0..=way.length().min(MAX_WAY_LENGTH) as usize).map(|s| s as f64);
        let mut on = places.map(|s| (s, line.project(&way.pose_at(s).position)));
        let (_, first) = on.next()?;
        if first.d.abs() <= ON_THE_WAY {
            return None;
        }
        let at = on.find(|(_, there)| there.d.abs() <= ON_THE_WAY)?;
        Some((at.0, at.1.s))
    }

    /// Seconds from the start until the ego's front is at `s` metres of its way.
    fn arrival(&self, s: f64) -> Result<f64, Impossible> {
        let front = self.ego_size().0 / 2.0;
        let steps = self.from + 1..=*self.stage.steps.end();
        let mut later = steps.filter_map(|step| Some((step, self.stage.ego_at(step)?)));
        let there = later.find(|(_, m)| self.stage.line.project(&m.pose.position).s + front >= s);
        let (step, _) = there.ok_or("the ego does not reach the crossing")?;
        Ok((step - self.from) as f64 * self.stage.dt())
    }
}

/// Distance and speed after `t` seconds, with constant speed after the duration.
fn course(profile: &Polynomial, t: f64, duration: f64, speed: f64) -> (f64, f64) {
    let [s, v, _] = profile.at(t.min(duration));
    if t <= duration {
        (s, v.max(0.0))
    } else {
        (s + speed * (t - duration), speed)
    }
}

/// From 0 to 1 without a jerk at either end.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
}

fn wanted(position: Point, velocity: Option<f64>) -> TrackingTarget {
    TrackingTarget {
        position,
        velocity,
        heading: None,
        weight: 1.0,
    }
}

/// Numbers of a manoeuvre: start (s), duration (s), gap (m), speed (m/s).
pub(super) type Numbers = [f64; 4];

/// One obstacle and one kind of manoeuvre, with a normal distribution over its parameters.
#[derive(Debug, Clone)]
pub(super) struct ManoeuvreSpace {
    /// The obstacle's id.
    pub obstacle: i64,
    /// The kind of manoeuvre.
    pub kind: ManoeuvreKind,
    /// Which of its ways that cross the ego's.
    pub way: usize,
    mean: Numbers,
    spread: Numbers,
    lowest: Numbers,
    highest: Numbers,
}

/// No manoeuvre takes less, seconds.
const MIN_DURATION: f64 = 0.8;

impl ManoeuvreSpace {
    /// What a candidate can try, all of it.
    #[must_use]
    pub fn all(stage: &AttackContext<'_>, candidate: &Candidate) -> Vec<Self> {
        let Some(obstacle) = stage.scenario.obstacle(candidate.obstacle) else {
            return Vec::new();
        };
        let dt = stage.dt();
        let track = obstacle.track().steps();
        let first = track.start.max(*stage.steps.start()) as f64 * dt;
        let last = (track.end - 2).min(*stage.steps.end()) as f64 * dt;
        let met = candidate.step as f64 * dt;
        let ego = stage.ego_at(candidate.step).map_or(0.0, |m| m.velocity);
        let standing = obstacle
            .motion_at(candidate.step)
            .is_some_and(|m| m.velocity < 1.0);
        let arm = |kind, way, mean: Numbers, spread, low: Numbers, high: Numbers| Self {
            obstacle: candidate.obstacle,
            kind,
            way,
            mean,
            spread,
            lowest: [first, MIN_DURATION, low[2], low[3]],
            highest: [(last - MIN_DURATION).max(first), high[1], high[2], high[3]],
        };
        use ManoeuvreKind as Kind;
        let most = ego + 5.0;
        let beside = |kind, gap: f64, low: f64, high: f64| {
            arm(
                kind,
                0,
                [met - 2.5, 2.5, gap, ego * 0.8],
                [2.0, 0.8, (high - low) / 3.0, 3.0],
                [0.0, 0.0, low, 0.0],
                [0.0, 5.0, high, most],
            )
        };
        let cross = |kind, way, speed: f64| {
            arm(
                kind,
                way,
                [met - 2.5, 2.5, 4.0, speed],
                [1.5, 0.8, 5.0, 3.0],
                [0.0, 0.0, 0.0, 1.0],
                [0.0, 6.0, 20.0, 15.0],
            )
        };
        let mut arms = vec![
            // An ego that brakes is farther back than where it would be without the attack.
            beside(Kind::CutIn, 0.0, -5.0, 5.0),
            beside(Kind::Drift, -0.5, -1.5, 0.8),
            beside(Kind::DoorToDoor, 0.1, 0.0, 0.8),
            arm(
                Kind::HardBrake,
                0,
                [met - 1.5, 1.6, 0.0, 0.5],
                [1.5, 0.6, 0.0, 1.5],
                [0.0, 0.0, 0.0, 0.0],
                [0.0, 3.0, 0.0, 5.0],
            ),
            cross(Kind::RunTheLight, 0, 8.0),
            cross(Kind::LateTurn, 0, 6.0),
            cross(Kind::LateTurn, 1, 6.0),
        ];
        if standing {
            arms.push(cross(Kind::PullOut, 0, 5.0));
        }
        arms.retain(|arm| arm.is_possible(stage, obstacle));
        arms
    }

    /// Whether it can be done at all, at its usual time or some time around it.
    fn is_possible(&self, stage: &AttackContext<'_>, obstacle: &Obstacle) -> bool {
        let around = [0.0, -1.0, 1.0, -2.0, 2.0];
        around.into_iter().any(|off| {
            let mut numbers = self.mean;
            numbers[0] += off * self.spread[0];
            let manoeuvre = self.manoeuvre(&mut numbers);
            plan(stage, obstacle, &manoeuvre, self.way).is_ok()
        })
    }

    /// Numbers from the distribution.
    pub fn sample(&self, random: &mut fastrand::Rng) -> Numbers {
        self.around(&self.mean, 1.0, random)
    }

    /// Numbers around others, with a share of the spread.
    pub fn around(&self, mean: &Numbers, share: f64, random: &mut fastrand::Rng) -> Numbers {
        let mut x = *mean;
        for (x, spread) in x.iter_mut().zip(self.spread) {
            *x += share * spread * normal(random);
        }
        x
    }

    /// How far numbers are from others, in spreads.
    pub fn apart(&self, x: &Numbers, y: &Numbers) -> f64 {
        let parts = x.iter().zip(y).zip(self.spread);
        let apart = parts.filter(|(_, spread)| *spread > 0.0);
        let squares = apart.map(|((x, y), spread)| ((x - y) / spread).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// The manoeuvre with these numbers, which are taken into their bounds.
    /// A drift with a gap below 0 has none, nor has a kind that does not know one.
    pub fn manoeuvre(&self, x: &mut Numbers) -> Manoeuvre {
        for (i, x) in x.iter_mut().enumerate() {
            *x = x.clamp(self.lowest[i], self.highest[i]);
        }
        let has_gap = match self.kind {
            ManoeuvreKind::HardBrake => false,
            ManoeuvreKind::Drift => x[2] >= 0.0,
            _ => true,
        };
        let gap = has_gap.then_some(x[2]);
        Manoeuvre {
            kind: self.kind,
            start: x[0],
            duration: x[1],
            gap,
            speed: Some(x[3]),
        }
    }
}

/// A standard normal number (Box and Muller 1958).
fn normal(random: &mut fastrand::Rng) -> f64 {
    let (u, v) = (1.0 - random.f64(), random.f64());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
