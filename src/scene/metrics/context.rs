//! A scene prepared for measuring: shared intermediate results are computed once, on first use.

use std::cell::OnceCell;
use std::ops::Range;

use super::along::{LaneBody, LaneSet, Road};
use super::encounter::Pair;
use super::limits::Limits;
use super::recorded::{Starts, Swept};
use super::{Encounter, NoValue, Thresholds};
use crate::scenario::{Motion, Participant, RouteError, Scene, Window};
use nearmiss_base::geometry::{Footprint, Placed};

/// A participant at a step: motion and body.
pub(super) type BodyAtStep<'s> = (&'s Motion, &'s Footprint);

/// A scene prepared for measuring.
///
/// Values are computed lazily: asking for distances costs no more than the distances.
#[derive(Debug)]
pub struct Context<'s> {
    pub(super) scene: &'s Scene,
    pub(super) thresholds: &'s Thresholds,
    steps: Range<i64>,
    /// The ego by step; nothing in gaps of its recording.
    pub(super) ego: Vec<Option<BodyAtStep<'s>>>,
    participants: Vec<Participant<'s>>,
    pairs: Vec<Pair>,
    /// Whether nothing but `steps` may be known: then the road is the one ahead, not the one driven later.
    ends: bool,
    road: OnceCell<Result<Road, RouteError>>,
    ego_along: OnceCell<Vec<Option<LaneBody>>>,
    ego_lanes: Vec<OnceCell<LaneSet>>,
    /// The farthest that the ego's front has got along its route, by step.
    farthest: OnceCell<Vec<f64>>,
    pub(super) ego_swept: OnceCell<Swept>,
    pub(super) starts: OnceCell<Starts>,
}

impl<'s> Context<'s> {
    /// Prepares a scene, to be measured with the shipped thresholds.
    #[must_use]
    pub fn new(scene: &'s Scene) -> Self {
        Self::under(scene, Thresholds::shipped())
    }

    /// Prepares a scene, to be measured with these thresholds.
    #[must_use]
    pub fn under(scene: &'s Scene, thresholds: &'s Thresholds) -> Self {
        Self::over(scene, thresholds, scene.steps(), false)
    }

    /// The same scene as it is known at the end of a window: there are no other steps, and measures along the
    /// lane look along the road that the ego drove in it and then straight on.
    #[must_use]
    pub fn during(&self, window: &Window) -> Self {
        let steps = window.first()..window.last() + 1;
        Self::over(self.scene, self.thresholds, steps, true)
    }

    fn over(scene: &'s Scene, thresholds: &'s Thresholds, steps: Range<i64>, ends: bool) -> Self {
        let at = |step| Some((scene.ego.track.at(step)?, scene.ego_footprint_at(step)));
        let ego: Vec<_> = steps.clone().map(at).collect();
        let participants: Vec<_> = scene.participants().collect();
        Self {
            scene,
            thresholds,
            ego_lanes: vec![OnceCell::new(); ego.len()],
            pairs: participants.iter().map(|_| Pair::default()).collect(),
            steps,
            ego,
            participants,
            ends,
            road: OnceCell::new(),
            ego_along: OnceCell::new(),
            farthest: OnceCell::new(),
            ego_swept: OnceCell::new(),
            starts: OnceCell::new(),
        }
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The steps of the ego.
    #[must_use]
    pub fn steps(&self) -> Range<i64> {
        self.steps.clone()
    }

    /// The obstacles other than the ego, in the file's order.
    #[must_use]
    pub fn participants(&self) -> &[Participant<'s>] {
        &self.participants
    }

    /// The ego with the participant at a place of [`Self::participants`] at a step; nothing if one of them
    /// is not there.
    #[must_use]
    pub fn encounter(&self, participant: usize, step: i64) -> Option<Encounter<'_>> {
        let index = self.index(step)?;
        let (ego, ego_body) = self.ego[index]?;
        let (other, other_body) = self.other(participant, index)?;
        Some(Encounter::in_context(
            (ego, ego_body),
            (other, other_body),
            self,
            participant,
            index,
        ))
    }

    /// The road along which measures look: the route that the ego drove, or else the one it was to drive.
    ///
    /// # Errors
    /// Why there is no route along what the ego drove.
    pub fn road(&self) -> Result<&Road, &RouteError> {
        let road = self.road.get_or_init(|| {
            if self.ends {
                let poses: Vec<_> = self.ego.iter().flatten().map(|(m, _)| m.pose).collect();
                Road::ahead(self.scene, &poses)
            } else {
                Road::from_scene(self.scene)
            }
        });
        road.as_ref()
    }

    pub(super) fn limits(&self) -> &Limits {
        &self.thresholds.limits
    }

    /// Place of a step among the ego's.
    pub(super) fn index(&self, step: i64) -> Option<usize> {
        let index = usize::try_from(step.checked_sub(self.steps.start)?).ok()?;
        (index < self.ego.len()).then_some(index)
    }

    pub(super) fn step(&self, index: usize) -> i64 {
        self.steps.start + index as i64
    }

    /// How many steps there are.
    pub(super) fn length(&self) -> usize {
        self.ego.len()
    }

    pub(super) fn dt(&self) -> f64 {
        self.scene.scenario.dt()
    }

    /// Seconds from a step's place to a later moment, in places.
    pub(super) fn time(&self, from: usize, to: f64) -> f64 {
        (to - from as f64) * self.dt()
    }

    pub(super) fn other(&self, participant: usize, index: usize) -> Option<BodyAtStep<'s>> {
        let participant = self.participants.get(participant)?;
        let step = self.step(index);
        Some((participant.at(step)?, participant.footprint_at(step)))
    }

    /// Both where they stand; nothing if one of them is not there.
    pub(super) fn placed(
        &self,
        participant: usize,
        index: usize,
    ) -> Option<(Placed<'s>, Placed<'s>)> {
        let (ego, ego_body) = self.ego.get(index).copied()??;
        let (other, other_body) = self.other(participant, index)?;
        Some((ego_body.at(ego.pose), other_body.at(other.pose)))
    }

    /// The recorded motions of another: all of them, or where nothing after a window may be known those in it.
    pub(super) fn motions(&self, participant: usize) -> &'s [(i64, Motion)] {
        let track = self.participants[participant].obstacle.track();
        if self.ends {
            track.during(&(self.steps.start..=self.steps.end - 1))
        } else {
            track.during(&(i64::MIN..=i64::MAX))
        }
    }

    pub(super) fn pair(&self, participant: usize) -> &Pair {
        &self.pairs[participant]
    }

    /// The ego along its route.
    pub(super) fn ego_along(&self, index: usize) -> Result<LaneBody, NoValue> {
        let road = self.road().map_err(|_| NoValue::NoRoute)?;
        let all = self.ego_along.get_or_init(|| {
            let along =
                |here: &Option<BodyAtStep<'_>>| here.and_then(|(m, body)| road.along(m, body));
            self.ego.iter().map(along).collect()
        });
        all[index].ok_or(NoValue::OffRoute)
    }

    /// The first place from `index` on at which the ego's front is at arc length `s` or beyond.
    pub(super) fn ego_reaches(&self, s: f64, index: usize) -> Option<usize> {
        let front = |index| self.ego_along(index).map_or(f64::MIN, |ego| ego.front);
        let farthest = self.farthest.get_or_init(|| {
            let mut most = f64::MIN;
            let steps = 0..self.length();
            steps
                .map(|index| {
                    most = most.max(front(index));
                    most
                })
                .collect()
        });
        let reached = farthest.partition_point(|&f| f < s);
        if reached >= index {
            return (reached < self.length()).then_some(reached);
        }
        // It was there before and went back.
        (index..self.length()).find(|&index| front(index) >= s)
    }

    /// The lanes that the ego stands on.
    pub(super) fn ego_lanes(&self, road: &Road, index: usize) -> LaneSet {
        *self.ego_lanes[index].get_or_init(|| {
            let here = self.ego[index];
            here.map_or(LaneSet::default(), |(m, body)| {
                road.lanes_under(self.scene, &body.at(m.pose))
            })
        })
    }
}
