//! A scene as known at the end of a window, without any later motion.

use std::ops::RangeInclusive;

use nearmiss_base::geometry::{Footprint, Placed};

use crate::scenario::{
    LaneletNetwork, Motion, Obstacle, ObstacleRole, ObstacleType, Scenario, Scene, Window,
};

/// The road, and the motion of all road users during a window.
///
/// It holds slices that end at the window's last step instead of the tracks themselves, so code that is given
/// a history cannot look into the future of the ego or of an obstacle. It does not hold the ego's goal either.
#[derive(Debug, Clone)]
pub struct ObservedHistory<'a> {
    network: &'a LaneletNetwork,
    now: i64,
    ego: Option<Observed<'a>>,
    others: Vec<Observed<'a>>,
    sets: Vec<&'a Obstacle>,
}

/// An obstacle without its future motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackedObject {
    /// Its id.
    pub id: i64,
    /// Its type; `None` for the ego.
    pub kind: Option<ObstacleType>,
    /// Whether it stands for ever.
    pub parked: bool,
}

/// A participant during a window, there at its last step.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// The object.
    pub who: TrackedObject,
    /// The region it covers now, in its own frame.
    pub footprint: &'a Footprint,
    /// Now.
    pub motion: &'a Motion,
    /// Steps and motions of the window, in order; the last is now. Never empty.
    pub motions: &'a [(i64, Motion)],
    /// Seconds between two time steps.
    pub dt: f64,
}

impl<'a> Observed<'a> {
    /// Its body now.
    #[must_use]
    pub fn placed(&self) -> Placed<'a> {
        self.footprint.at(self.motion.pose)
    }

    /// Seconds from `step` to now.
    #[must_use]
    pub fn ago(&self, step: i64) -> f64 {
        let now = self.motions.last().map_or(step, |(now, _)| *now);
        (now - step) as f64 * self.dt
    }

    fn at_end(
        who: TrackedObject,
        footprint: &'a Footprint,
        motions: &'a [(i64, Motion)],
        end: Option<i64>,
        dt: f64,
    ) -> Option<Self> {
        let (step, motion) = motions.last()?;
        end.is_none_or(|end| end == *step).then_some(Self {
            who,
            footprint,
            motion,
            motions,
            dt,
        })
    }
}

impl<'a> ObservedHistory<'a> {
    /// The history of `scene` up to the end of `window`.
    #[must_use]
    pub fn from_window(scene: &'a Scene, window: &Window) -> Self {
        let (now, dt, steps) = (window.last(), scene.scenario.dt(), window.steps());
        let who = TrackedObject {
            id: scene.ego.id,
            kind: None,
            parked: false,
        };
        let ego = scene.ego.track.during(&steps);
        let (sets, others): (Vec<_>, Vec<_>) = scene
            .participants()
            .partition(|p| p.obstacle.is_set_based());
        let others = others
            .into_iter()
            .filter_map(|p| observed(p.obstacle, p.footprint_at(now), &steps, dt));
        Self {
            network: &scene.scenario.network,
            now,
            ego: Observed::at_end(who, scene.ego_footprint_at(now), ego, Some(now), dt),
            others: others.collect(),
            sets: sets.into_iter().map(|p| p.obstacle).collect(),
        }
    }

    /// What was known of everyone in `scenario` but `without` during `steps`, the last of which is now; none is the
    /// ego.
    #[must_use]
    pub fn of_traffic(
        scenario: &'a Scenario,
        steps: RangeInclusive<i64>,
        without: Option<i64>,
    ) -> Self {
        let (now, dt) = (*steps.end(), scenario.dt());
        let obstacles = scenario.obstacles.iter();
        let others = obstacles.filter_map(|obstacle| {
            let bodily = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
            let footprint = obstacle.footprint_at(now)?;
            let there = bodily && Some(obstacle.id) != without;
            there.then(|| observed(obstacle, footprint, &steps, dt))?
        });
        Self {
            network: &scenario.network,
            now,
            ego: None,
            others: others.collect(),
            sets: Vec::new(),
        }
    }

    /// Those whose occupancy sets say where they may be, which is a prediction and known now.
    #[must_use]
    pub fn sets(&self) -> &[&'a Obstacle] {
        &self.sets
    }

    /// The road.
    #[must_use]
    pub fn network(&self) -> &'a LaneletNetwork {
        self.network
    }

    /// The present: the window's last step.
    #[must_use]
    pub fn now(&self) -> i64 {
        self.now
    }

    /// The ego; nothing in a gap of its recording.
    #[must_use]
    pub fn ego(&self) -> Option<&Observed<'a>> {
        self.ego.as_ref()
    }

    /// The other road users present now, in the file's order.
    #[must_use]
    pub fn others(&self) -> &[Observed<'a>] {
        &self.others
    }
}

/// An obstacle during `steps`; `None` if it is absent at the last one.
fn observed<'a>(
    obstacle: &'a Obstacle,
    footprint: &'a Footprint,
    steps: &RangeInclusive<i64>,
    dt: f64,
) -> Option<Observed<'a>> {
    let parked = obstacle.role == ObstacleRole::Static;
    let who = TrackedObject {
        id: obstacle.id,
        kind: Some(obstacle.kind),
        parked,
    };
    let track = obstacle.track();
    // An obstacle that stands for ever has one state, which holds at all times.
    let (motions, end) = if parked {
        (track.during(&(i64::MIN..=i64::MAX)), None)
    } else {
        (track.during(steps), Some(*steps.end()))
    };
    Observed::at_end(who, footprint, motions, end, dt)
}
