//! The measuring tape: two ends in world coordinates, each free or attached to a moving body.

use crate::loaded::Opened;
use nearmiss_base::geometry::{Gap, Placed, Point, Tip};
use nearmiss_scene::scenario::Motion;

/// Attachment of a tape end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum On {
    /// The ego.
    Ego,
    /// The obstacle with this id.
    Obstacle(i64),
}

/// An end of the tape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Where it was put.
    pub point: Point,
    /// The body that it moves with.
    pub on: Option<On>,
}

/// The tape, pulled out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tape {
    /// Where it is held.
    pub from: End,
    /// The end that moves.
    pub to: End,
}

/// The tape's measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// The distance and where it was taken.
    pub gap: Gap,
    /// How many of the two ends are on bodies.
    pub bodies: usize,
    /// Seconds at the ego's speed, where it drives.
    pub seconds: Option<f64>,
    /// The ego's speed, m/s.
    pub speed: Option<f64>,
}

/// Slower than this, m/s, the ego stands.
const STANDING: f64 = 0.1;

impl Opened {
    /// The motion of the ego or of an obstacle at a step; what stands, stands always.
    #[must_use]
    pub fn motion_of(&self, on: On, step: i64) -> Option<&Motion> {
        match on {
            On::Ego => self.scene.as_ref()?.ego.track.at(step),
            On::Obstacle(id) => self.scenario.obstacle(id)?.motion_at(step),
        }
    }

    /// The body of the ego or of an obstacle at a step.
    #[must_use]
    pub fn body_of(&self, on: On, step: i64) -> Option<Placed<'_>> {
        match on {
            On::Ego => self.scene.as_ref()?.ego_at(step),
            On::Obstacle(id) => self.scenario.obstacle(id)?.placed_at(step),
        }
    }

    /// The body that is nearest to a point and how far it is, metres; among equals the first one in the file.
    #[must_use]
    pub fn nearest_body(&self, point: &Point, step: i64, ego_too: bool) -> Option<(On, f64)> {
        let ego = self.scene.as_ref().map(|s| s.ego.id);
        let others = self
            .scenario
            .obstacles
            .iter()
            .filter(|o| Some(o.id) != ego)
            .filter_map(|o| Some((On::Obstacle(o.id), o.placed_at(step)?)));
        let own = ego_too
            .then(|| self.body_of(On::Ego, step))
            .flatten()
            .map(|body| (On::Ego, body));
        let distance =
            |body: Placed<'_>| Gap::between(&Tip::Body(body), &Tip::Point(*point)).metres;
        own.into_iter()
            .chain(others)
            .map(|(on, body)| (on, distance(body)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl End {
    /// On a body where it is.
    #[must_use]
    pub fn on(opened: &Opened, on: On, step: i64) -> Option<Self> {
        let motion = opened.motion_of(on, step)?;
        Some(Self {
            point: motion.pose.position,
            on: Some(on),
        })
    }

    /// At a point, or on the body that is within `reach` metres of it.
    #[must_use]
    pub fn near(opened: &Opened, point: Point, step: i64, reach: f64) -> Self {
        let body = opened.nearest_body(&point, step, true);
        let on = body.filter(|(_, d)| *d <= reach).map(|(on, _)| on);
        Self { point, on }
    }

    fn tip<'a>(&self, opened: &'a Opened, step: i64) -> Tip<'a> {
        let body = self.on.and_then(|on| opened.body_of(on, step));
        body.map_or(Tip::Point(self.point), Tip::Body)
    }
}

impl Tape {
    /// The measurement at a step. An end whose body is absent stays where it was put.
    #[must_use]
    pub fn measure(&self, opened: &Opened, step: i64) -> Measurement {
        let tips = (self.from.tip(opened, step), self.to.tip(opened, step));
        let gap = Gap::between(&tips.0, &tips.1);
        let body = |tip: &Tip<'_>| usize::from(matches!(tip, Tip::Body(_)));
        let speed = opened.motion_of(On::Ego, step).map(|m| m.velocity.abs());
        Measurement {
            gap,
            bodies: body(&tips.0) + body(&tips.1),
            seconds: speed.filter(|v| *v > STANDING).map(|v| gap.metres / v),
            speed,
        }
    }
}
