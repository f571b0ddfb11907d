//! How the other road user of an encounter moves with other parameters.
//!
//! A place moves along the ego's way by `d = (gap − gap₀) + (closing₀ − closing)·w`, on the arc of the way's curvature there, and
//! across it by `S(t; lateral_speed) − S(t; lateral_speed₀)`. `w` is how far it is from its place at the moment `t_m` of the
//! manoeuvre, along the way, over its speed at that moment: it is slower by the same share all the time, and stands where it stood.
//! `S` is the smooth step `3u² − 2u³` from the offset before the change of lane to that after it, as fast as fits the recorded one
//! best; `u` grows with the lateral speed, and is that of the recorded offset at `t_m`. With another start the motion is later as a
//! whole; gap and closing are then those to where the ego is at the later moment. Before and after its recording it keeps its speed.

use std::sync::OnceLock;

use nearmiss_base::geometry::{Point, Pose, ReferencePath, Vector, angle_between};
use nearmiss_formats::{Formula, VariedVertex};
use nearmiss_scene::corpus::{Event, EventKind};
use nearmiss_scene::metrics::Context;
use nearmiss_scene::scenario::{Motion, Obstacle};

use super::{Values, Varied};

/// A step of the recorded motion, and the ego's way beside it.
#[derive(Debug, Clone, Copy)]
struct Place {
    step: i64,
    motion: Motion,
    /// Direction (rad) and curvature (1/m) of the way, and the offset from it to the left (m).
    heading: f64,
    curvature: f64,
    offset: f64,
    /// How far it has come along the way, metres.
    along: f64,
}

impl Place {
    /// How much longer the way is at its offset.
    fn stretch(&self) -> f64 {
        (1.0 - self.curvature * self.offset).max(0.1)
    }

    /// Its speed along the ego's way and across it, m/s.
    fn speeds(&self) -> [f64; 2] {
        let (sin, cos) = self.heading.sin_cos();
        let velocity = self.motion.velocity_vector();
        let along = velocity.dot(&Vector::new(cos, sin)) / self.stretch();
        [along, velocity.dot(&Vector::new(-sin, cos))]
    }

    /// How far the next place is along the way, metres.
    fn way_to(&self, next: &Self) -> f64 {
        let turned = angle_between(self.heading, next.heading);
        let (sin, cos) = (self.heading + turned / 2.0).sin_cos();
        let moved = next.motion.pose.position - self.motion.pose.position;
        moved.dot(&Vector::new(cos, sin)) / f64::midpoint(self.stretch(), next.stretch())
    }
}

/// Direction (rad) and curvature (1/m) of a way around an arc length: the line through its directions 15 m before and after, as
/// lanes are drawn with corners.
fn direction(way: &ReferencePath, s: f64) -> [f64; 2] {
    const AROUND: i32 = 15;
    let middle = way.at(s).heading;
    let turned = |i: i32| angle_between(middle, way.at(s + f64::from(i)).heading);
    let around = -AROUND..=AROUND;
    let count = f64::from(2 * AROUND + 1);
    let mean = around.clone().map(turned).sum::<f64>() / count;
    let squares = around.clone().map(|i| f64::from(i * i)).sum::<f64>();
    let slope = around.map(|i| f64::from(i) * turned(i)).sum::<f64>() / squares;
    [middle + mean, slope]
}

/// A change of lane: the smooth step.
#[derive(Debug, Clone, Copy)]
struct Sideways {
    /// Offset before and after, metres.
    from: f64,
    to: f64,
    /// The step at which the offset stays what it is, in parts of steps.
    anchor: f64,
    /// The share of the time that is over then.
    share: f64,
    /// Shares of the time in a second, as recorded.
    rate: f64,
}

/// The motion of the other road user.
#[derive(Debug)]
pub(super) struct Course {
    places: Vec<Place>,
    dt: f64,
    /// The moment of the manoeuvre, and what was measured then.
    moment: i64,
    recorded: Values,
    /// Whether gap and closing are held where the start is another one.
    is_ahead: bool,
    sideways: Option<Sideways>,
    /// The ego along its way: arc length (m) and speed (m/s) at its steps.
    ego: Vec<(i64, f64, f64)>,
    /// Starts, in steps, between which the ego's motion counts as even; 0 is among them.
    starts: Vec<i64>,
    /// The places as formulas of all parameters, once they were asked for.
    formulas: OnceLock<Vec<VariedVertex>>,
}

/// Slower is no change of lane, m/s, and a shorter one is none either, metres.
const SIDEWAYS: f64 = 0.1;
const ASIDE: f64 = 0.3;

/// What is slower along the way has no direction that follows from its speed, m/s.
const SLOWEST: f64 = 0.5;

/// What moves back no faster stands, m/s.
const STANDSTILL: f64 = 1e-3;

/// A way that bends less is straight, 1/m.
const STRAIGHT: f64 = 1e-7;

impl Course {
    pub fn new(
        context: &Context<'_>,
        obstacle: &Obstacle,
        event: Option<&Event>,
    ) -> Result<Self, String> {
        let scene = context.scene();
        let driven = scene.ego.track.path();
        let way = match context.road() {
            Ok(road) => Some(&road.route.path),
            Err(_) => driven.as_ref(),
        };
        let no_way = || "the ego stands, and has no way".to_owned();
        let way = way.ok_or_else(no_way)?;
        let beside = |point: &Point| way.project_point(point).ok();
        // Where it is not beside the way, the nearest place counts at which it is.
        let mut known = { obstacle.track().iter() }
            .find_map(|(_, motion)| beside(&motion.pose.position))
            .ok_or_else(|| format!("{} is never beside the ego's way", obstacle.id))?;
        let places = obstacle.track().iter().map(|(step, motion)| {
            known = beside(&motion.pose.position).unwrap_or(known);
            let (at, _) = known;
            let [heading, curvature] = direction(way, at.s);
            Place {
                step,
                motion: *motion,
                heading,
                curvature,
                offset: at.d,
                along: 0.0,
            }
        });
        let mut places: Vec<Place> = places.collect();
        for i in 1..places.len() {
            places[i].along = places[i - 1].along + places[i - 1].way_to(&places[i]);
        }
        let ego = scene.ego.track.iter().filter_map(|(step, motion)| {
            let (at, along) = beside(&motion.pose.position)?;
            let speed = motion.velocity * (motion.pose.heading - along.heading).cos();
            Some((step, at.s, speed / along.stretch(at).ok()?))
        });
        let is_ahead = event.is_some_and(|e| e.manoeuvre != EventKind::CutOut);
        let measured = |value: fn(&Event) -> Option<f64>| event.and_then(value).unwrap_or_default();
        let mut course = Self {
            dt: scene.scenario.dt(),
            moment: event.map_or(0, |event| event.first_step),
            recorded: [
                measured(|e| e.gap),
                measured(|e| e.closing),
                measured(|e| e.lateral_speed),
                0.0,
            ],
            is_ahead,
            sideways: None,
            ego: ego.collect(),
            starts: vec![0],
            formulas: OnceLock::new(),
            places,
        };
        if event.is_some_and(|event| event.lateral_speed.is_some_and(|speed| speed > SIDEWAYS)) {
            let length = obstacle
                .footprint
                .as_ref()
                .map(|body| body.shape().size().0);
            // Who comes in crosses the border with its front first, who leaves with its rear last.
            let half = length.unwrap_or_default() / if is_ahead { 2.0 } else { -2.0 };
            course.sideways = course.change_of_lane(half);
        }
        Ok(course)
    }

    fn at_moment(&self) -> Option<&Place> {
        self.places.iter().find(|place| place.step == self.moment)
    }

    /// Whether it drives along the way at the moment.
    pub fn drives(&self) -> bool {
        self.at_moment()
            .is_some_and(|place| place.speeds()[0] > SLOWEST)
    }

    pub fn goes_sideways(&self) -> bool {
        self.sideways.is_some()
    }

    /// Makes room for these starts, seconds.
    pub fn allow(&mut self, starts: &[f64]) {
        let steps = starts.iter().map(|start| self.steps(*start));
        self.starts.extend(steps.collect::<Vec<_>>());
        self.starts.sort_unstable();
        self.starts.dedup();
        self.formulas = OnceLock::new();
    }

    fn steps(&self, seconds: f64) -> i64 {
        (seconds / self.dt).round() as i64
    }

    /// The smooth step that fits the change of lane around the moment best. What crosses the border is so far ahead of the centre
    /// (m): as it turns less where it changes lanes slowly, its centre stays where it is once that far on.
    fn change_of_lane(&self, ahead: f64) -> Option<Sideways> {
        let at = { self.places.iter() }.position(|place| place.step == self.moment)?;
        let offset = |place: usize| self.places[place].offset;
        let last = self.places.len() - 1;
        let side = (offset((at + 1).min(last)) - offset(at.saturating_sub(1))).signum();
        let moves = |pair: &[Place]| (pair[1].offset - pair[0].offset) * side > SIDEWAYS * self.dt;
        let before = { self.places[..=at].windows(2).rev() }.take_while(|pair| moves(pair));
        let first = at - before.count();
        let after = self.places[at..].windows(2).take_while(|pair| moves(pair));
        let end = at + after.count();
        let (from, to) = (offset(first), offset(end));
        if (to - from) * side < ASIDE {
            return None;
        }
        // The body crosses the border between two steps.
        let earlier = at.saturating_sub(1).max(first);
        let crossing = f64::midpoint(offset(earlier), offset(at));
        let anchor = f64::midpoint(self.places[earlier].step as f64, self.moment as f64);
        let wanted = ((crossing - from) / (to - from)).clamp(0.0, 1.0);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if smooth(middle) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        let with = |rate: f64| Sideways {
            from,
            to,
            anchor,
            share: low,
            rate,
        };
        let off = |sideways: &Sideways| -> f64 {
            let places = &self.places[first..=end];
            let squares = places.iter().map(|place| {
                let u = sideways.share + sideways.rate * (place.step as f64 - anchor) * self.dt;
                (from + (to - from) * smooth(u.clamp(0.0, 1.0)) - place.offset).powi(2)
            });
            squares.sum()
        };
        // From a change that takes 20 s to one that takes 0.2 s.
        let rates = (0..=400).map(|i| with(0.05 * 100_f64.powf(f64::from(i) / 400.0)));
        let best = rates.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let seconds = ahead / self.places[at].speeds()[0].max(SLOWEST);
        Some(Sideways {
            anchor: anchor + seconds / self.dt,
            share: best.share + best.rate * seconds,
            ..best
        })
    }

    /// How far the ego is along its way at a moment from that of the manoeuvre on (m), and how much faster (m/s): so many steps
    /// later.
    fn ego_later(&self, steps: i64) -> [f64; 2] {
        let at = |step: i64| {
            let (first, last) = (self.ego.first()?, self.ego.last()?);
            let near = step.clamp(first.0, last.0);
            let place = self.ego.partition_point(|(step, ..)| *step < near);
            let (there, s, speed) = self.ego.get(place)?;
            Some((s + speed * (step - there) as f64 * self.dt, *speed))
        };
        match (at(self.moment), at(self.moment + steps)) {
            (Some(now), Some(later)) => [later.0 - now.0, later.1 - now.1],
            _ => [0.0; 2],
        }
    }

    /// The recorded motion, and so much before and after it that every start has a place for each step.
    fn extended(&self) -> Vec<Place> {
        let reach = self
            .starts
            .iter()
            .map(|start| start.abs())
            .max()
            .unwrap_or(0);
        let (Some(first), Some(last)) = (self.places.first(), self.places.last()) else {
            return Vec::new();
        };
        let moved = |place: &Place, steps: i64| {
            let mut moved = *place;
            moved.step += steps;
            moved.motion.acceleration = 0.0;
            let seconds = steps as f64 * self.dt;
            moved.motion.pose.position += place.motion.velocity_vector() * seconds;
            moved.along += place.speeds()[0] * seconds;
            moved
        };
        let before = (1..=reach).rev().map(|steps| moved(first, -steps));
        let after = (1..=reach).map(|steps| moved(last, steps));
        before
            .chain(self.places.iter().copied())
            .chain(after)
            .collect()
    }

    /// The places of its trajectory as formulas of these parameters, in this order.
    pub fn vertices(&self, varied: &[Varied]) -> Vec<VariedVertex> {
        let value = |of: Varied| match varied.iter().position(|one| *one == of) {
            Some(place) => Formula::parameter(place, of.name()),
            None => self.recorded[of as usize].into(),
        };
        let [gap, closing, lateral, start] = Varied::ALL.map(value);
        let nearer = gap - self.recorded[Varied::Gap as usize];
        let slower = closing * -1.0 + self.recorded[Varied::Closing as usize];
        let follows = self.is_ahead && varied.contains(&Varied::Start);
        let hinges = if follows {
            self.hinges(&start)
        } else {
            Vec::new()
        };
        let moment = self.at_moment();
        let [here, fast] = moment.map_or([0.0, SLOWEST], |at| [at.along, at.speeds()[0]]);
        let vertex = |place: &Place| {
            let [forwards, across] = place.speeds();
            let (since, share) = ((place.along - here) / fast, forwards / fast);
            let mut along = &nearer + &slower * since;
            let mut faster = slower.clone();
            for (over, [way, speed]) in &hinges {
                along = along + over * (way + speed * since);
                faster = faster + over * *speed;
            }
            let stretch = place.stretch();
            let along = along * stretch;
            let (mut aside, mut outwards) = (Formula::from(0.0), Formula::from(0.0));
            if let Some(sideways) = self
                .sideways
                .filter(|_| varied.contains(&Varied::LateralSpeed))
            {
                let measured = self.recorded[Varied::LateralSpeed as usize];
                let at =
                    |lateral: &Formula| sideways.at(place.step, self.dt, &(lateral / measured));
                let ([to, speed], [before, speed_before]) = (at(&lateral), at(&measured.into()));
                (aside, outwards) = (to - before, speed - speed_before);
            }
            let curvature = place.curvature / stretch;
            let bends = curvature.abs() > STRAIGHT;
            let turned = if bends {
                &along * curvature
            } else {
                0.0.into()
            };
            if bends {
                aside = aside + &along * &along * (curvature / 2.0);
            }
            let Pose { position, heading } = place.motion.pose;
            let (sin, cos) = place.heading.sin_cos();
            let towards =
                |forwards: Formula, across: Formula| (across / forwards.at_least(SLOWEST)).atan();
            let before = towards((forwards * stretch).into(), across.into());
            let after = towards((faster * share + forwards) * stretch, outwards + across);
            VariedVertex {
                step: place.step,
                later: start.clone(),
                x: &along * cos - &aside * sin + position.x,
                y: along * sin + aside * cos + position.y,
                heading: after - before + turned + heading,
            }
        };
        self.extended().iter().map(vertex).collect()
    }

    /// What the start adds to the way (m) and speed (m/s) of the ego at the moment: so much for each second beyond a start.
    fn hinges(&self, start: &Formula) -> Vec<(Formula, [f64; 2])> {
        let mut hinges = Vec::new();
        let outwards = [
            self.starts
                .iter()
                .copied()
                .filter(|start| *start >= 0)
                .collect::<Vec<_>>(),
            self.starts
                .iter()
                .rev()
                .copied()
                .filter(|start| *start <= 0)
                .collect(),
        ];
        for starts in outwards {
            let mut before = [0.0; 2];
            for pair in starts.windows(2) {
                let seconds = (pair[1] - pair[0]) as f64 * self.dt;
                let (from, to) = (self.ego_later(pair[0]), self.ego_later(pair[1]));
                let slope = [0, 1].map(|i| (to[i] - from[i]) / seconds);
                let over = start - pair[0] as f64 * self.dt;
                let over = if seconds > 0.0 {
                    over.at_least(0.0)
                } else {
                    over.at_most(0.0)
                };
                hinges.push((over, [slope[0] - before[0], slope[1] - before[1]]));
                before = slope;
            }
        }
        hinges
    }

    /// The motion with these values, at the recorded steps.
    pub fn motion(&self, values: &Values) -> Vec<(i64, Motion)> {
        let vertices = self.formulas.get_or_init(|| self.vertices(&Varied::ALL));
        let poses = vertices.iter().map(|vertex| {
            let [x, y, heading] = [&vertex.x, &vertex.y, &vertex.heading].map(|f| f.value(values));
            Pose::new(x, y, heading)
        });
        let (poses, places) = (poses.collect::<Vec<_>>(), self.extended());
        let recorded: Vec<Pose> = places.iter().map(|place| place.motion.pose).collect();
        // Speeds and accelerations are the recorded ones, and what differences of places add.
        let (now, then) = (self.speeds(&poses), self.speeds(&recorded));
        let speed = |i: usize| {
            let before = places[i].motion.velocity;
            let speed = before + now[i] - then[i];
            // Where it stops, differences over a step are rough.
            let is_forwards = before >= 0.0 && now[i] >= -STANDSTILL;
            if is_forwards { speed.max(0.0) } else { speed }
        };
        let speeds: Vec<f64> = (0..places.len()).map(speed).collect();
        let added: Vec<f64> = { speeds.iter().zip(&places) }
            .map(|(speed, place)| speed - place.motion.velocity)
            .collect();
        let later = self.steps(values[Varied::Start as usize]);
        let offset = self.places.first().map_or(0, |first| {
            places
                .iter()
                .position(|place| place.step == first.step)
                .unwrap_or(0)
        });
        let at = |(i, place): (usize, &Place)| {
            let from = usize::try_from((i + offset) as i64 - later).ok()?;
            let [a, b] = beside(from, places.len());
            let seconds = (b - a).max(1) as f64 * self.dt;
            let motion = Motion {
                pose: *poses.get(from)?,
                velocity: speeds[from],
                acceleration: places[from].motion.acceleration + (added[b] - added[a]) / seconds,
            };
            Some((place.step, motion))
        };
        self.places.iter().enumerate().filter_map(at).collect()
    }

    /// Speeds along the headings, m/s.
    fn speeds(&self, poses: &[Pose]) -> Vec<f64> {
        let speed = |i: usize| {
            let [a, b] = beside(i, poses.len());
            let seconds = (b - a).max(1) as f64 * self.dt;
            (poses[b].position - poses[a].position).dot(&poses[i].forward()) / seconds
        };
        (0..poses.len()).map(speed).collect()
    }
}

/// The places before and after one of so many.
fn beside(place: usize, count: usize) -> [usize; 2] {
    [place.saturating_sub(1), (place + 1).min(count - 1)]
}

fn smooth(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

impl Sideways {
    /// How far it has come (m) and how fast it is (m/s) across the way at a step, so many times as fast as recorded.
    fn at(&self, step: i64, dt: f64, faster: &Formula) -> [Formula; 2] {
        let since = (step as f64 - self.anchor) * dt * self.rate;
        let u = (faster * since + self.share).at_least(0.0).at_most(1.0);
        let way = self.to - self.from;
        [
            &u * &u * (&u * -2.0 + 3.0) * way,
            &u * (&u * -1.0 + 1.0) * faster * (6.0 * way * self.rate),
        ]
    }
}
