//! What an entity does in a storyboard: where it begins, what it follows, when it is there, and the triggers of that.

use nearmiss_base::geometry::Pose;

use super::trajectory::{Followed, SAME_TIME};
use crate::commonroad::ReadError;
use crate::recordings::opendrive::tree::Node;

/// What an entity does.
#[derive(Debug, Clone, Default)]
pub struct Motions {
    /// Where it begins.
    pub start: Option<Pose>,
    /// Where it is put later, and when, seconds.
    pub placed: Vec<(f64, Pose)>,
    /// Its speed at first, m/s.
    pub speed: f64,
    pub followed: Vec<Followed>,
    /// Moments at which it appears and vanishes, seconds.
    pub appears: Vec<f64>,
    pub vanishes: Vec<f64>,
    /// Whether it is not there at first.
    pub is_late: bool,
    /// What it does that only a player works out, in words.
    pub other: Option<String>,
    /// Whether a controller that may move it is active.
    pub is_controlled: bool,
}

impl Motions {
    /// Whether it follows nothing, but begins with a speed or has a controller: a driver drives it.
    pub fn is_free(&self) -> bool {
        self.followed.is_empty() && (self.drives() || self.is_controlled)
    }

    /// Whether it begins with a speed.
    pub fn drives(&self) -> bool {
        self.speed.abs() > 1e-3
    }

    /// What it does that only a player works out, in words; `None` where the file tells its motion.
    pub fn unknown(&self) -> Option<String> {
        if let Some(other) = &self.other {
            return Some(other.clone());
        }
        let speed = self.speed;
        if self.followed.is_empty() {
            return match (self.drives(), self.is_controlled) {
                (true, _) => Some(format!("begins at {speed} m/s and drives on by itself")),
                (false, true) => Some("is moved by a controller".into()),
                (false, false) => None,
            };
        }
        let first = self
            .followed
            .iter()
            .map(Followed::begins)
            .fold(f64::INFINITY, f64::min);
        let waits = self.drives() && !self.is_late && first > MAX_WAIT;
        waits.then(|| format!("drives at {speed} m/s until its trajectory begins at {first} s"))
    }

    /// Whether a step ends before a moment at which something is done, or at it: players do what is triggered at a moment
    /// in the step that begins there.
    fn done(moments: &[f64], time: f64, dt: f64) -> usize {
        moments.iter().filter(|m| **m < time - dt / 2.0).count()
    }

    /// Whether it is there at a moment, in steps of `dt` seconds.
    pub fn is_there(&self, time: f64, dt: f64) -> bool {
        let came = Self::done(&self.appears, time, dt);
        let went = Self::done(&self.vanishes, time, dt);
        if self.is_late {
            came > went
        } else {
            came >= went
        }
    }

    /// Where it is at a moment: where it was put last, on the trajectory that it began to follow last, or at its end.
    pub fn pose_at(&self, time: f64) -> Option<Pose> {
        let mut last = self.start.map(|pose| (f64::NEG_INFINITY, pose));
        let placed = self.placed.iter().map(|(at, pose)| (*at, Some(*pose)));
        let followed = self.followed.iter().map(|f| (f.begins(), f.at(time)));
        for (begins, pose) in placed.chain(followed) {
            let is_later = last.is_none_or(|(before, _)| begins >= before);
            if begins <= time + SAME_TIME && is_later {
                last = pose.map(|pose| (begins, pose)).or(last);
            }
        }
        last.map(|(_, pose)| pose)
    }

    /// Whether it is on one of its trajectories at a moment.
    pub fn is_on_its_way(&self, time: f64) -> bool {
        self.followed
            .iter()
            .any(|f| f.begins() <= time + SAME_TIME && time <= f.ends() + SAME_TIME)
    }

    /// The last moment at which it does something, seconds; 0 where it does nothing.
    pub fn until(&self) -> f64 {
        let ends = self.followed.iter().map(Followed::ends);
        let events = self.appears.iter().chain(&self.vanishes).copied();
        ends.chain(events).fold(0.0, f64::max)
    }

    /// When its last trajectory ends, where it is still moving then and there later than that, seconds.
    pub fn halts(&self, until: f64, dt: f64) -> Option<f64> {
        let last = self
            .followed
            .iter()
            .max_by(|a, b| a.ends().total_cmp(&b.ends()))?;
        let rests = last.ends() + dt;
        let moves = last.last_speed() > STANDSTILL_SPEED;
        (moves && rests <= until + SAME_TIME && self.is_there(rests, dt)).then_some(last.ends())
    }
}

/// Seconds in which an entity that waits for its trajectory gets nowhere.
const MAX_WAIT: f64 = 0.05;

/// Slower is standing, m/s.
const STANDSTILL_SPEED: f64 = 0.1;

/// When a trigger fires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fires {
    /// At a moment, seconds.
    At(f64),
    /// Never.
    Never,
    /// When something happens that only a player works out.
    Depends,
}

impl Fires {
    /// When both this one and another one have fired.
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Never, _) | (_, Self::Never) => Self::Never,
            (Self::Depends, _) | (_, Self::Depends) => Self::Depends,
            (Self::At(a), Self::At(b)) => Self::At(a.max(b)),
        }
    }

    fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Never, fires) | (fires, Self::Never) => fires,
            (Self::Depends, _) | (_, Self::Depends) => Self::Depends,
            (Self::At(a), Self::At(b)) => Self::At(a.min(b)),
        }
    }
}

/// When an act or an event begins: at once, where nothing tells it.
pub fn start(of: &Node) -> Result<Fires, ReadError> {
    match of.child("StartTrigger") {
        Some(trigger) if trigger.has("ConditionGroup") => fires(trigger),
        _ => Ok(Fires::At(0.0)),
    }
}

/// When a trigger fires: any of its groups, all conditions of a group.
pub fn fires(trigger: &Node) -> Result<Fires, ReadError> {
    let mut any = Fires::Never;
    for group in trigger.all("ConditionGroup") {
        let mut all = Fires::At(0.0);
        let mut passes = false;
        for condition in group.all("Condition") {
            let (fires, is_short) = self::condition(condition)?;
            all = all.and(fires);
            passes |= is_short;
        }
        // What holds for a while only may be over when another condition is met.
        let alone = group.all("Condition").count() < 2;
        any = any.or(if passes && !alone {
            Fires::Depends
        } else {
            all
        });
    }
    Ok(any)
}

/// When a condition is met, and whether only for a while.
fn condition(condition: &Node) -> Result<(Fires, bool), ReadError> {
    let by_value =
        condition.first(|c| c.name == "ByValueCondition" && c.has("SimulationTimeCondition"));
    let Some(time) = by_value.and_then(|c| c.child("SimulationTimeCondition")) else {
        return Ok((Fires::Depends, false));
    };
    let delay = condition.or_zero("delay")?;
    let value = time.needed_number("value")?;
    let falls = condition.text("conditionEdge") == Some("falling");
    Ok(match time.text("rule") {
        _ if falls => (Fires::Depends, false),
        Some("lessThan" | "lessOrEqual") if value < 0.0 => (Fires::Never, false),
        Some("lessThan" | "lessOrEqual") => (Fires::At(delay), true),
        Some("equalTo") => (Fires::At(value + delay), true),
        Some("notEqualTo") => (Fires::Depends, false),
        _ => (Fires::At(value + delay), false),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::trajectory::TimedVertex;
    use super::*;
    use crate::recordings::opendrive::tree;

    fn line(triggered: f64, vertices: &[(f64, f64)]) -> Followed {
        let told = vertices.iter().map(|(time, x)| TimedVertex {
            time: *time,
            pose: Pose::new(*x, 0.0, 0.0),
            has_heading: true,
        });
        Followed::through(told.collect(), triggered).unwrap()
    }

    #[test]
    fn an_entity_waits_at_its_place_and_stays_at_the_end() {
        let motion = Motions {
            start: Some(Pose::new(-5.0, 0.0, 0.0)),
            followed: vec![
                line(0.0, &[(1.0, 0.0), (2.0, 10.0)]),
                line(4.0, &[(0.0, 0.0), (6.0, 60.0)]),
            ],
            placed: vec![(8.0, Pose::new(-9.0, 0.0, 0.0))],
            ..Motions::default()
        };
        let x = |t: f64| motion.pose_at(t).unwrap().position.x;
        assert_eq!(
            [0.0, 1.0, 1.5, 2.0, 3.9, 4.0, 5.0, 7.0, 8.0, 9.0].map(x),
            [-5.0, 0.0, 5.0, 10.0, 10.0, 40.0, 50.0, 60.0, -9.0, -9.0]
        );
        assert_eq!(motion.halts(9.0, 0.1), Some(6.0));
        assert_eq!(motion.halts(6.05, 0.1), None);
        let gone = Motions {
            vanishes: vec![6.0],
            ..motion
        };
        assert_eq!(gone.halts(9.0, 0.1), None);
        assert!(gone.is_there(6.0, 0.1) && !gone.is_there(6.1, 0.1));
    }

    fn time(rule: &str, value: f64, delay: f64) -> String {
        format!(
            r#"<Condition delay="{delay}"><ByValueCondition><SimulationTimeCondition rule="{rule}" value="{value}"/></ByValueCondition></Condition>"#
        )
    }

    fn of(groups: &[&[String]]) -> Fires {
        let groups: String = groups
            .iter()
            .map(|g| format!("<ConditionGroup>{}</ConditionGroup>", g.concat()))
            .collect();
        let text = format!("<Event><StartTrigger>{groups}</StartTrigger></Event>");
        start(&tree::read(text.as_bytes(), "x", "Event").unwrap()).unwrap()
    }

    #[test]
    fn triggers_fire_at_moments_or_depend_on_others() {
        let later = |value| time("greaterOrEqual", value, 0.5);
        let entity = "<Condition><ByEntityCondition/></Condition>".to_string();
        assert_eq!(of(&[]), Fires::At(0.0));
        assert_eq!(of(&[&[later(2.0)]]), Fires::At(2.5));
        assert_eq!(of(&[&[later(2.0), later(4.0)]]), Fires::At(4.5));
        assert_eq!(of(&[&[later(2.0)], &[later(4.0)]]), Fires::At(2.5));
        assert_eq!(of(&[&[later(2.0), entity.clone()]]), Fires::Depends);
        assert_eq!(of(&[&[later(2.0)], &[entity]]), Fires::Depends);
        assert_eq!(of(&[&[time("lessThan", 9.0, 1.0)]]), Fires::At(1.0));
        assert_eq!(
            of(&[&[time("lessThan", 9.0, 0.0), later(99.0)]]),
            Fires::Depends
        );
        assert_eq!(of(&[&[time("lessThan", -1.0, 0.0)]]), Fires::Never);
    }
}
