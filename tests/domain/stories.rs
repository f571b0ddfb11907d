//! Stories: every fact of a sentence is worked out again from recorded places, without the library's measures.

#![allow(clippy::unwrap_used)]

use crate::support::recorded::shared;

use nearmiss::formats::{EgoSelection, Entry, bundled, find};
use nearmiss::metrics::{Context, Direction};
use nearmiss::scenario::{Motion, Obstacle, Scene};
use nearmiss::story::{Action, Beside, Course, Fact, Story, Who};

/// A point or vector.
type Xy = (f64, f64);

/// The place of one at a step, with its outline around it.
#[derive(Clone)]
struct Body {
    x: f64,
    y: f64,
    heading: f64,
    speed: f64,
    outline: Vec<Xy>,
}

impl Body {
    fn new(motion: &Motion, corners: &[Xy]) -> Self {
        Self {
            x: motion.pose.position.x,
            y: motion.pose.position.y,
            heading: motion.pose.heading,
            speed: motion.velocity,
            outline: corners.to_vec(),
        }
    }

    fn corners(&self) -> Vec<Xy> {
        let (sin, cos) = self.heading.sin_cos();
        let place = |&(x, y): &Xy| (self.x + x * cos - y * sin, self.y + x * sin + y * cos);
        self.outline.iter().map(place).collect()
    }

    /// After some seconds straight on.
    fn after(&self, seconds: f64) -> Self {
        let way = self.speed * seconds;
        Self {
            x: self.x + way * self.heading.cos(),
            y: self.y + way * self.heading.sin(),
            ..self.clone()
        }
    }

    /// A share of the way to the next.
    fn towards(&self, next: &Self, share: f64) -> Self {
        Self {
            x: self.x + (next.x - self.x) * share,
            y: self.y + (next.y - self.y) * share,
            heading: self.heading + wrapped(next.heading - self.heading) * share,
            ..self.clone()
        }
    }

    fn reach(&self) -> f64 {
        self.outline
            .iter()
            .map(|(x, y)| x.hypot(*y))
            .fold(0.0, f64::max)
    }

    fn distance(&self, other: &Self) -> f64 {
        let (a, b) = (self.corners(), other.corners());
        if inside(&a, b[0]) || inside(&b, a[0]) {
            return 0.0;
        }
        let mut least = f64::INFINITY;
        for i in 0..a.len() {
            let one = (a[i], a[(i + 1) % a.len()]);
            for k in 0..b.len() {
                let two = (b[k], b[(k + 1) % b.len()]);
                if cross(one, two) {
                    return 0.0;
                }
                least = least
                    .min(to_segment(one.0, two))
                    .min(to_segment(two.0, one));
            }
        }
        least
    }

    fn is_far(&self, other: &Self, metres: f64) -> bool {
        (self.x - other.x).hypot(self.y - other.y) > self.reach() + other.reach() + metres
    }

    fn touches(&self, other: &Self) -> bool {
        !self.is_far(other, 0.0) && self.distance(other) == 0.0
    }
}

fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

fn side_of(a: Xy, b: Xy, p: Xy) -> f64 {
    (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
}

fn cross(one: (Xy, Xy), two: (Xy, Xy)) -> bool {
    side_of(one.0, one.1, two.0) * side_of(one.0, one.1, two.1) < 0.0
        && side_of(two.0, two.1, one.0) * side_of(two.0, two.1, one.1) < 0.0
}

fn inside(ring: &[Xy], p: Xy) -> bool {
    let mut odd = false;
    for i in 0..ring.len() {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        if (a.1 > p.1) != (b.1 > p.1) && p.0 < a.0 + (p.1 - a.1) / (b.1 - a.1) * (b.0 - a.0) {
            odd = !odd;
        }
    }
    odd
}

fn to_segment(p: Xy, (a, b): (Xy, Xy)) -> f64 {
    let (x, y) = (b.0 - a.0, b.1 - a.1);
    let length = x * x + y * y;
    let share = if length > 0.0 {
        (((p.0 - a.0) * x + (p.1 - a.1) * y) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p.0 - a.0 - x * share).hypot(p.1 - a.1 - y * share)
}

/// Both with their places by step.
struct Pair {
    name: String,
    dt: f64,
    /// First and last second of the story.
    span: (f64, f64),
    ego: Vec<(i64, Body)>,
    other: Vec<(i64, Body)>,
    wrong: Vec<String>,
    checked: usize,
}

fn at(all: &[(i64, Body)], step: i64) -> Option<&Body> {
    let place = all.binary_search_by_key(&step, |(at, _)| *at).ok()?;
    Some(&all[place].1)
}

/// Speed around a step from places alone, m/s, over two steps each way where there are so many.
fn speed(all: &[(i64, Body)], step: i64, dt: f64) -> Option<f64> {
    let from = [step - 1, step]
        .into_iter()
        .find_map(|s| Some((s, at(all, s)?)))?;
    let to = [step + 1, step]
        .into_iter()
        .find_map(|s| Some((s, at(all, s)?)))?;
    let seconds = (to.0 - from.0) as f64 * dt;
    (seconds > 0.0).then(|| (to.1.x - from.1.x).hypot(to.1.y - from.1.y) / seconds)
}

/// The direction of the way around a step from places at least so many metres apart.
fn way(all: &[(i64, Body)], step: i64, forwards: bool, metres: f64) -> Option<f64> {
    let here = at(all, step)?;
    let sign = if forwards { 1 } else { -1 };
    (1..100).find_map(|k| {
        let there = at(all, step + sign * k)?;
        let (x, y) = (there.x - here.x, there.y - here.y);
        (x.hypot(y) >= metres).then(|| (y * sign as f64).atan2(x * sign as f64))
    })
}

impl Pair {
    fn new(name: &str, scene: &Scene, obstacle: &Obstacle) -> Self {
        let corners = |points: &[nearmiss::geometry::Point]| -> Vec<Xy> {
            points.iter().map(|p| (p.x, p.y)).collect()
        };
        let ego = scene.ego.track.iter().map(|(step, motion)| {
            let footprint = scene.ego_footprint_at(step);
            (step, Body::new(motion, &corners(footprint.corners())))
        });
        let ego: Vec<(i64, Body)> = ego.collect();
        let steps = scene.steps().start - 2000..scene.steps().end + 2000;
        let other = steps.filter_map(|step| {
            let footprint = obstacle.footprint_at(step)?;
            let motion = obstacle.motion_at(step)?;
            Some((step, Body::new(motion, &corners(footprint.corners()))))
        });
        Self {
            name: name.into(),
            dt: scene.scenario.dt(),
            span: (0.0, 0.0),
            ego,
            other: other.collect(),
            wrong: Vec::new(),
            checked: 0,
        }
    }

    fn step(&self, time: f64) -> i64 {
        (time / self.dt).round() as i64
    }

    fn of(&self, who: Who) -> &[(i64, Body)] {
        match who {
            Who::Ego => &self.ego,
            Who::Other => &self.other,
        }
    }

    fn common(&self) -> impl Iterator<Item = (i64, &Body, &Body)> {
        let ego = self.ego.iter();
        ego.filter_map(|(step, ego)| Some((*step, ego, at(&self.other, *step)?)))
    }

    fn is(&mut self, what: &str, said: f64, found: f64, within: f64) {
        self.checked += 1;
        if (said - found).abs() > within {
            self.wrong
                .push(format!("{}: {what}: {said} is {found}", self.name));
        }
    }

    fn holds(&mut self, what: &str, holds: bool) {
        self.checked += 1;
        if !holds {
            self.wrong.push(format!("{}: {what}", self.name));
        }
    }

    /// Seconds until both touch if they go straight on, looked at so often.
    fn ttc(&self, step: i64, every: f64, most: f64) -> Option<f64> {
        let (ego, other) = (at(&self.ego, step)?, at(&self.other, step)?);
        let looks = (most / every).ceil() as i64;
        let mut times = (0..=looks).map(|k| k as f64 * every);
        times.find(|t| ego.after(*t).touches(&other.after(*t)))
    }

    fn is_speed(&mut self, what: &str, who: Who, time: f64, said: f64) {
        let found = speed(self.of(who), self.step(time), self.dt);
        if let Some(found) = found {
            self.is(what, said, found, 0.6 + 0.06 * said);
        }
    }

    fn place(&mut self, what: &str, step: i64, said: Direction) {
        let (Some(ego), Some(other)) = (at(&self.ego, step), at(&self.other, step)) else {
            self.wrong.push(format!("{}: {what}: nobody", self.name));
            return;
        };
        let gap = |axis: Xy| {
            let ends = |body: &Body| {
                let along = body
                    .corners()
                    .into_iter()
                    .map(|c| c.0 * axis.0 + c.1 * axis.1);
                let along: Vec<f64> = along.collect();
                (
                    along.iter().copied().fold(f64::INFINITY, f64::min),
                    along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                )
            };
            let (mine, theirs) = (ends(ego), ends(other));
            if theirs.0 > mine.1 {
                theirs.0 - mine.1
            } else if theirs.1 < mine.0 {
                theirs.1 - mine.0
            } else {
                0.0
            }
        };
        let (sin, cos) = ego.heading.sin_cos();
        let (long, lat) = (gap((cos, sin)), gap((-sin, cos)));
        use Direction as D;
        let holds = match said {
            D::Front => long > -0.01 && lat.abs() < 0.01,
            D::Behind => long < 0.01 && lat.abs() < 0.01,
            D::FrontLeft => long > -0.01 && lat > -0.01,
            D::FrontRight => long > -0.01 && lat < 0.01,
            D::RearLeft => long < 0.01 && lat > -0.01,
            D::RearRight => long < 0.01 && lat < 0.01,
            D::Left => long.abs() < 0.01 && lat > -0.01,
            D::Right => long.abs() < 0.01 && lat < 0.01,
            D::Contact => ego.distance(other) < 0.01,
        };
        self.holds(&format!("{what}: {said:?} is {long:.2} {lat:.2}"), holds);
    }

    fn check(&mut self, fact: &Fact) {
        match *fact {
            Fact::Begin {
                time,
                ego_speed,
                other_speed,
                distance,
                place,
                course,
                ..
            } => {
                let step = self.step(time);
                self.is_speed("ego at first", Who::Ego, time, ego_speed);
                self.is_speed("other at first", Who::Other, time, other_speed);
                let apart = at(&self.ego, step)
                    .unwrap()
                    .distance(at(&self.other, step).unwrap());
                self.is("distance at first", distance, apart, 0.02);
                self.place("at first", step, place);
                if course == Course::Stands {
                    self.holds("stands", other_speed < 0.5);
                } else if let Some(way) = way(&self.other, step, true, 0.1) {
                    let ego = at(&self.ego, step).unwrap().heading;
                    let angle = wrapped(way - ego).to_degrees();
                    let holds = match course {
                        Course::SameWay => angle.abs() < 65.0,
                        Course::Towards => angle.abs() > 115.0,
                        Course::ToTheLeft => angle > 20.0 && angle < 160.0,
                        _ => angle < -20.0 && angle > -160.0,
                    };
                    self.holds(&format!("{course:?} is {angle:.0}°"), holds);
                }
            }
            Fact::Does {
                who,
                from,
                to,
                action,
            } => self.check_action(who, (from, to), action),
            Fact::Pass {
                first,
                left,
                entered,
            } => self.check_pass(first, left, entered),
            Fact::LowestTtc {
                time,
                seconds,
                is_outside,
                ..
            } => {
                let here = self.ttc(self.step(time), 0.005, seconds + 0.1);
                self.is("ttc", seconds, here.unwrap_or(99.0), 0.011);
                let steps: Vec<i64> = self.common().map(|(step, ..)| step).collect();
                let lower = steps
                    .into_iter()
                    .filter(|s| is_outside || self.is_told(*s))
                    .find(|s| self.ttc(*s, 0.05, seconds - 0.06).is_some());
                self.holds(
                    &format!("a lower ttc at {lower:?}"),
                    lower.is_none() || seconds < 0.06,
                );
            }
            Fact::ShortTtc { time, until } => {
                let step = self.step(time);
                let mut all = step..=self.step(until);
                let long = all.find(|step| self.ttc(*step, 0.01, 3.02).is_none());
                self.holds(&format!("a long ttc at {long:?}"), long.is_none());
                let before = at(&self.ego, step - 1).zip(at(&self.other, step - 1));
                let is_short = before.is_some() && self.ttc(step - 1, 0.01, 2.98).is_some();
                self.holds("not before", !is_short);
            }
            Fact::NoCourse => {
                let steps: Vec<i64> = self.common().map(|(step, ..)| step).collect();
                let touch = steps
                    .into_iter()
                    .find(|s| self.ttc(*s, 0.05, 9.9).is_some());
                self.holds(&format!("a course at {touch:?}"), touch.is_none());
            }
            Fact::Contact {
                time,
                closing_speed,
                ..
            } => {
                let step = self.step(time) - 1;
                let mut least = f64::INFINITY;
                for step in [step - 1, step, step + 1] {
                    let ends = |all: &[(i64, Body)]| {
                        let here = at(all, step)?.clone();
                        let next = at(all, step + 1).cloned();
                        Some((here.clone(), next.unwrap_or(here)))
                    };
                    if let (Some(ego), Some(other)) = (ends(&self.ego), ends(&self.other)) {
                        for share in 0..=100 {
                            let share = f64::from(share) / 100.0;
                            let (ego, other) = (
                                ego.0.towards(&ego.1, share),
                                other.0.towards(&other.1, share),
                            );
                            least = least.min(ego.distance(&other));
                        }
                    }
                }
                self.is("distance in contact", 0.0, least, 0.05);
                let early = self
                    .common()
                    .find(|(s, ego, other)| *s < step && ego.touches(other));
                let early = early.map(|(step, ..)| step);
                self.holds(&format!("an earlier contact at {early:?}"), early.is_none());
                let velocity = |all: &[(i64, Body)]| {
                    let to = at(all, step + 1).or_else(|| at(all, step))?;
                    let from = at(all, step - 1).or_else(|| at(all, step))?;
                    let steps = i64::from(at(all, step + 1).is_some())
                        + i64::from(at(all, step - 1).is_some());
                    let seconds = steps.max(1) as f64 * self.dt;
                    Some(((to.x - from.x) / seconds, (to.y - from.y) / seconds))
                };
                if let (Some(ego), Some(other)) = (velocity(&self.ego), velocity(&self.other)) {
                    let found = (other.0 - ego.0).hypot(other.1 - ego.1);
                    self.is("closing speed", closing_speed, found, 1.0 + 0.1 * found);
                }
            }
            Fact::Nearest {
                time,
                distance,
                place,
                is_outside,
            } => {
                let step = self.step(time);
                let here = at(&self.ego, step)
                    .unwrap()
                    .distance(at(&self.other, step).unwrap());
                self.is("nearest", distance, here, 0.011);
                let nearer = self.common().find(|(step, ego, other)| {
                    (is_outside || self.is_told(*step))
                        && !ego.is_far(other, distance)
                        && ego.distance(other) < distance - 0.02
                });
                let nearer = nearer.map(|(step, ..)| step);
                self.holds(&format!("nearer at {nearer:?}"), nearer.is_none());
                self.place("nearest", step, place);
            }
            Fact::Uncertain { overlap } => {
                self.holds(
                    &format!("an overlap of {overlap:.2} m"),
                    (0.0..0.5).contains(&overlap),
                );
            }
            Fact::SpeedsOff { who, by } => {
                // Of one that stands, what it did 5 s before, too.
                let steps = self.step(self.span.0 - 5.0)..=self.step(self.span.1);
                let all = self.of(who);
                let off = steps.filter_map(|step| {
                    Some((at(all, step)?.speed.abs() - speed(all, step, self.dt)?).abs())
                });
                let most = off.fold(0.0, f64::max);
                self.is("off its places", by, most, 1.0 + 0.3 * by);
            }
        }
    }

    fn is_told(&self, step: i64) -> bool {
        (self.step(self.span.0)..=self.step(self.span.1)).contains(&step)
    }

    fn check_action(&mut self, who: Who, (from, to): (f64, f64), action: Action) {
        let steps = (self.step(from), self.step(to));
        let within = |speed: f64| 0.6 + 0.06 * speed;
        match action {
            Action::Turn { degrees } => {
                let all = self.of(who);
                let (first, last) = (way(all, steps.0, false, 1.0), way(all, steps.1, true, 1.0));
                if let (Some(first), Some(last)) = (first, last) {
                    let turned = wrapped(last - first).to_degrees();
                    let off = (turned - degrees + 540.0).rem_euclid(360.0) - 180.0;
                    self.is("turn", 0.0, off, 25.0);
                }
            }
            Action::Brake {
                from_speed,
                to_speed,
                most,
            } => {
                self.is_speed("speed before braking", who, from, from_speed);
                self.is_speed("speed after braking", who, to, to_speed);
                self.holds("slower", to_speed < from_speed && from < to);
                let mean = (from_speed - to_speed) / (to - from);
                self.holds("mean braking", (0.8..=most + 0.1).contains(&mean));
                let hardest = self.hardest(who, steps.0, steps.1);
                self.is("braking", most, hardest, 1.0 + 0.25 * most);
            }
            Action::SpeedUp {
                from_speed,
                to_speed,
            } => {
                self.is_speed("speed before the rise", who, from, from_speed);
                self.is_speed("speed after the rise", who, to, to_speed);
                self.holds("faster", to_speed >= from_speed + 0.5 && from < to);
            }
            Action::SlowDown {
                from_speed,
                to_speed,
            } => {
                self.is_speed("speed before the fall", who, from, from_speed);
                self.is_speed("speed after the fall", who, to, to_speed);
                self.holds("slower", to_speed <= from_speed - 0.5 && from < to);
            }
            Action::ChangeLanes { lane } => {
                let second = (1.0 / self.dt).round() as i64;
                let all = self.of(who);
                let at = |step: i64| at(all, step);
                if let (Some(before), Some(after)) = (at(steps.0 - second), at(steps.0 + second)) {
                    let (sin, cos) = before.heading.sin_cos();
                    let aside = (after.y - before.y) * cos - (after.x - before.x) * sin;
                    let holds = match lane {
                        Beside::Left => aside > 0.0,
                        Beside::Right => aside < 0.0,
                        Beside::Oncoming | Beside::Own => aside.abs() > 0.3,
                    };
                    self.holds(&format!("to the lane {lane:?}: {aside:.2} m"), holds);
                }
            }
            Action::NotBrake => {
                let hardest = self.hardest(who, steps.0, steps.1);
                self.holds(&format!("no braking is {hardest:.1}"), hardest < 2.0);
            }
            Action::KeepOn { low, high } => {
                let all = (steps.0..=steps.1).filter_map(|step| speed(self.of(who), step, self.dt));
                let all: Vec<f64> = all.collect();
                let least = all.iter().copied().fold(f64::INFINITY, f64::min);
                let most = all.iter().copied().fold(0.0, f64::max);
                self.is("lowest speed", low, least, within(low));
                self.is("highest speed", high, most, within(high));
            }
        }
    }

    /// The hardest braking between two steps from places alone: of speeds half a second apart.
    fn hardest(&self, who: Who, from: i64, to: i64) -> f64 {
        let half = (0.2 / self.dt).round().max(1.0) as i64;
        let at = |step: i64| speed(self.of(who), step.clamp(from, to), self.dt);
        let all = (from..=to).filter_map(|step| {
            let steps = (step + half).min(to) - (step - half).max(from);
            Some((at(step - half)? - at(step + half)?) / (steps as f64 * self.dt))
        });
        all.fold(0.0, f64::max)
    }

    /// All that one covers over its whole recording, ten places between two steps.
    fn swept(&self, who: Who) -> Vec<(f64, Body)> {
        let all = self.of(who);
        let mut swept = Vec::new();
        for pair in all.windows(2) {
            let [(step, here), (next, there)] = pair else {
                continue;
            };
            for k in 0..10 {
                let share = f64::from(k) / 10.0;
                let place = if next - step == 1 {
                    here.towards(there, share)
                } else {
                    here.clone()
                };
                swept.push(((*step as f64 + share) * self.dt, place));
            }
        }
        swept.extend(
            all.last()
                .map(|(step, body)| (*step as f64 * self.dt, body.clone())),
        );
        swept
    }

    fn check_pass(&mut self, first: Who, left: f64, entered: f64) {
        let second = match first {
            Who::Ego => Who::Other,
            Who::Other => Who::Ego,
        };
        let (one, two) = (self.swept(first), self.swept(second));
        let covers =
            |all: &[(f64, Body)], body: &Body| all.iter().any(|(_, other)| body.touches(other));
        let slack = 1.5 * self.dt;
        let after = one.iter().filter(|(time, _)| *time > left + slack);
        let after = after.clone().step_by(5).any(|(_, body)| covers(&two, body));
        let before = two.iter().filter(|(time, _)| *time < entered - slack);
        let before = before
            .clone()
            .step_by(5)
            .any(|(_, body)| covers(&one, body));
        let near = |all: &[(f64, Body)], when: f64, with: &[(f64, Body)]| {
            let there = all.iter().filter(|(time, _)| (time - when).abs() <= slack);
            there.clone().any(|(_, body)| covers(with, body))
        };
        self.holds("still there after leaving", !after);
        self.holds("there before entering", !before);
        self.holds("never left there", near(&one, left, &two));
        self.holds("never came there", near(&two, entered, &one));
        self.holds("in turn", left < entered);
    }
}

/// The story of a scenario with its ego, checked; nothing where it has none.
fn checked(entry: &Entry, ego: &EgoSelection) -> Option<(String, Pair)> {
    let scenario = entry.read().ok()?;
    let ego = ego.resolve(entry, &scenario).ok()??;
    let scene = Scene::new(scenario, ego);
    let context = Context::new(&scene);
    let story = Story::new(&context)?;
    let obstacle = scene.scenario.obstacle(story.obstacle).unwrap();
    if obstacle.is_set_based() {
        return None;
    }
    let mut pair = Pair::new(&entry.name, &scene, obstacle);
    pair.span = story.span;
    assert!((1..=4).contains(&story.sentences.len()), "{}", story.text());
    for sentence in &story.sentences {
        assert!(sentence.text.ends_with('.') && !sentence.text.contains("NaN"));
        for fact in &sentence.facts {
            pair.check(fact);
        }
    }
    let data = serde_json::to_value(&story.sentences).unwrap();
    let facts = data
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|s| s["facts"].as_array().unwrap());
    let mut does = facts.filter(|fact| fact["fact"] == "does");
    assert!(
        does.all(|fact| fact["from"].is_number() && fact["to"].is_number()),
        "{data}"
    );
    let all = story.sentences.iter().flat_map(|s| &s.facts);
    let touched = all.clone().find_map(|fact| match fact {
        Fact::Contact { time, .. } => Some(*time),
        _ => None,
    });
    let ends = all.filter_map(|fact| match fact {
        Fact::Does { to, .. } => Some(*to),
        _ => None,
    });
    let ends = ends.fold(0.0, f64::max);
    pair.holds(
        &format!("told until {ends}"),
        touched.is_none_or(|at| ends <= at),
    );
    Some((story.text(), pair))
}

fn check_all(entries: &[Entry]) -> usize {
    let all: Vec<(String, Pair)> = { entries.iter() }
        .filter_map(|entry| checked(entry, &EgoSelection::Beside))
        .collect();
    let wrong: Vec<&String> = all.iter().flat_map(|(_, pair)| &pair.wrong).collect();
    let facts: usize = all.iter().map(|(_, pair)| pair.checked).sum();
    for (text, pair) in &all {
        println!("{}: {text}", pair.name);
    }
    assert!(wrong.is_empty(), "{} of {facts}: {wrong:#?}", wrong.len());
    all.len()
}

#[test]
fn every_fact_of_the_bundled_stories_holds() {
    assert_eq!(check_all(&bundled()), 8);
}

#[test]
fn every_fact_of_sixty_published_stories_holds() {
    let Some(folder) = shared("from-words-to-collisions/Scenarios") else {
        return;
    };
    let found = find(&[folder]).unwrap().entries;
    let every = (found.len() / 70).max(1);
    let some: Vec<Entry> = found.into_iter().step_by(every).collect();
    assert!(check_all(&some) >= 60);
}

#[test]
fn a_story_of_one_that_is_always_there_ends() {
    let Some(file) = shared("commonroad-crime/ZAM_Urban-3_3_Repair.xml") else {
        return;
    };
    let (text, pair) = checked(&Entry::of_file(&file), &EgoSelection::Obstacle(8)).unwrap();
    assert!(text.contains("parked vehicle 6") && text.contains("keeps on with 8.7 to 9.0 m/s"));
    assert!(pair.wrong.is_empty(), "{:#?}", pair.wrong);
}
