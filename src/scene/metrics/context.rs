//! A scene prepared for measuring: the ego with each other participant; shared results are computed once, on first use.

use std::cell::OnceCell;
use std::ops::Range;

use nearmiss_base::geometry::{Footprint, Placed, ReferencePath};

use super::along::{Exposure, Following, LaneBody, LaneSet, Road};
use super::limits::Limits;
use super::recorded::{Closest, Conflict, Starts, Swept};
use super::{Contact, NoValue, Relation, Thresholds};
use crate::scenario::{Motion, ObstacleRole, Participant, RouteError, Scene, Window};

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
    /// What the ego drove, where there is no route.
    driven: OnceCell<Option<ReferencePath>>,
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
            driven: OnceCell::new(),
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

    /// The ego and another along the ego's way at a step: its route, or where there is none what it drove, straight on
    /// behind its ends. Nothing where one of them is not there or not beside it.
    pub(crate) fn along_way(&self, participant: usize, step: i64) -> Option<[LaneBody; 2]> {
        let index = self.index(step)?;
        if self.road().is_ok() {
            let ego = self.ego_along(index).ok()?;
            return Some([ego, self.along(participant, index).ok()?]);
        }
        let path = self.driven.get_or_init(|| self.scene.ego.track.path());
        let along = |(motion, body)| LaneBody::beside(path.as_ref()?, motion, body);
        // Without a route, nothing else is known along it.
        let rows = || self.ego.iter().map(|here| along((*here)?)).collect();
        let ego = self.ego_along.get_or_init(rows)[index]?;
        Some([ego, along(self.other(participant, index)?)?])
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

/// The ego and another participant, at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Encounter<'a> {
    /// The ego's motion.
    pub ego: &'a Motion,
    /// The ego's body.
    pub ego_body: &'a Footprint,
    /// The other's motion.
    pub other: &'a Motion,
    /// The other's body.
    pub other_body: &'a Footprint,
    thresholds: &'a Thresholds,
    place: Place<'a>,
}

/// The source of the remaining recording.
#[derive(Debug, Clone, Copy)]
enum Place<'a> {
    /// Prepared, with the places of the other and of the step.
    Context(&'a Context<'a>, usize, usize),
    /// Not prepared, with the other and the step.
    Scene(&'a Scene, Participant<'a>, i64),
    /// None.
    #[cfg(test)]
    Nowhere,
}

impl<'a> Encounter<'a> {
    /// The encounter of a scene's ego with `other` at `step`; nothing if one of them is not there.
    ///
    /// Measures that look along the road or into the recording prepare the scene anew for each such
    /// encounter: for more than a few of those, make a [`Context`] once and ask it.
    #[must_use]
    pub fn at(scene: &'a Scene, other: &Participant<'a>, step: i64) -> Option<Self> {
        Some(Self {
            ego: scene.ego.track.at(step)?,
            ego_body: scene.ego_footprint_at(step),
            other: other.at(step)?,
            other_body: other.footprint_at(step),
            thresholds: Thresholds::shipped(),
            place: Place::Scene(scene, *other, step),
        })
    }

    /// The same, measured with these thresholds instead of the shipped ones.
    #[must_use]
    pub fn under(self, thresholds: &'a Thresholds) -> Self {
        Self { thresholds, ..self }
    }

    /// The thresholds that it is measured with.
    #[must_use]
    pub fn thresholds(&self) -> &'a Thresholds {
        self.thresholds
    }

    pub(super) fn in_context(
        (ego, ego_body): (&'a Motion, &'a Footprint),
        (other, other_body): (&'a Motion, &'a Footprint),
        context: &'a Context<'a>,
        participant: usize,
        index: usize,
    ) -> Self {
        Self {
            ego,
            ego_body,
            other,
            other_body,
            thresholds: context.thresholds,
            place: Place::Context(context, participant, index),
        }
    }

    #[cfg(test)]
    pub(super) fn nowhere(
        (ego, ego_body): (&'a Motion, &'a Footprint),
        (other, other_body): (&'a Motion, &'a Footprint),
    ) -> Self {
        Self {
            ego,
            ego_body,
            other,
            other_body,
            thresholds: Thresholds::shipped(),
            place: Place::Nowhere,
        }
    }

    /// Whether the other is a region of an occupancy set, which has a place and no velocity.
    #[must_use]
    pub fn is_with_occupancy(&self) -> bool {
        match self.place {
            Place::Context(context, participant, index) => {
                let other = &context.participants()[participant];
                other.obstacle.is_occupancy_at(context.step(index))
            }
            Place::Scene(_, other, step) => other.obstacle.is_occupancy_at(step),
            #[cfg(test)]
            Place::Nowhere => false,
        }
    }

    /// The ego where it stands.
    #[must_use]
    pub fn ego_placed(&self) -> Placed<'a> {
        self.ego_body.at(self.ego.pose)
    }

    /// The other where it stands.
    #[must_use]
    pub fn other_placed(&self) -> Placed<'a> {
        self.other_body.at(self.other.pose)
    }

    /// Exact distance between the two bodies, metres; 0 when they touch.
    #[must_use]
    pub fn distance(&self) -> f64 {
        let known = match self.place {
            Place::Context(context, participant, index) => context.distances(participant)[index],
            _ => None,
        };
        known.unwrap_or_else(|| self.ego_placed().distance(&self.other_placed()))
    }

    /// The contact at the step or on the way to it from the step before, if there is one.
    #[must_use]
    pub fn contact(&self) -> Option<Contact> {
        match self.place {
            Place::Context(context, participant, index) => {
                context.contact_at(participant, index).copied()
            }
            Place::Scene(scene, other, step) => Contact::at(scene, &other, step),
            #[cfg(test)]
            Place::Nowhere => None,
        }
    }

    /// Position and motion of the other relative to the ego.
    #[must_use]
    pub fn relation(&self) -> Relation {
        let known = match self.place {
            Place::Context(context, participant, index) => context.relation(participant, index),
            _ => None,
        };
        known.unwrap_or_else(|| Relation::new(self))
    }

    /// Asks the whole recording: `question` is given the places of the other and of the step.
    pub(super) fn ask<T>(
        &self,
        question: impl FnOnce(&Context<'_>, usize, usize) -> Result<T, NoValue>,
    ) -> Result<T, NoValue> {
        match self.place {
            Place::Context(context, participant, index) => question(context, participant, index),
            Place::Scene(scene, other, step) => {
                let context = Context::under(scene, self.thresholds);
                let mut all = context.participants().iter();
                let place = all.position(|p| p.obstacle.id == other.obstacle.id);
                let (participant, index) = place.zip(context.index(step)).ok_or(NoValue::Absent)?;
                question(&context, participant, index)
            }
            #[cfg(test)]
            Place::Nowhere => Err(NoValue::Absent),
        }
    }
}

/// The ego and one other, by step of the ego.
#[derive(Debug, Default)]
pub(super) struct Pair {
    distances: OnceCell<Vec<Option<f64>>>,
    pub(super) contacts: OnceCell<Vec<Contact>>,
    relations: OnceCell<Vec<Option<Relation>>>,
    closest: OnceCell<Vec<Option<Closest>>>,
    along: OnceCell<Vec<Option<LaneBody>>>,
    following: OnceCell<Vec<Result<Following, NoValue>>>,
    exposure: OnceCell<Vec<Exposure>>,
    conflict: OnceCell<Conflict>,
    starts: OnceCell<Starts>,
    /// The lanes of a static obstacle.
    standing_lanes: OnceCell<LaneSet>,
}

impl Context<'_> {
    /// Exact distances of the bodies, metres, by step.
    pub(super) fn distances(&self, participant: usize) -> &[Option<f64>] {
        self.pair(participant).distances.get_or_init(|| {
            let distance = |index| {
                let (ego, other) = self.placed(participant, index)?;
                Some(ego.distance(&other))
            };
            (0..self.length()).map(distance).collect()
        })
    }

    pub(super) fn relation(&self, participant: usize, index: usize) -> Option<Relation> {
        let rows = self.pair(participant).relations.get_or_init(|| {
            let relation = |index| {
                let encounter = self.encounter(participant, self.step(index))?;
                Some(Relation::new(&encounter))
            };
            (0..self.length()).map(relation).collect()
        });
        rows[index]
    }

    /// The closest that the recorded bodies come from a step on, at steps and between them.
    pub(super) fn closest(&self, participant: usize, index: usize) -> Option<Closest> {
        let rows = self
            .pair(participant)
            .closest
            .get_or_init(|| Closest::rows(self, participant));
        rows[index]
    }

    /// The other along the ego's route.
    pub(super) fn along(&self, participant: usize, index: usize) -> Result<LaneBody, NoValue> {
        let road = self.road().map_err(|_| NoValue::NoRoute)?;
        let rows = self.pair(participant).along.get_or_init(|| {
            let along = |index| {
                let (motion, body) = self.other(participant, index)?;
                road.along(motion, body)
            };
            if self.stands(participant) {
                return vec![along(0); self.length()];
            }
            // No pair exists at steps without the ego.
            let asked = |index: usize| self.ego[index].and_then(|_| along(index));
            (0..self.length()).map(asked).collect()
        });
        rows[index].ok_or(NoValue::OffRoute)
    }

    /// The other ahead in the ego's lane, or why it is not.
    pub(super) fn following(&self, participant: usize, index: usize) -> Result<Following, NoValue> {
        let rows = self.pair(participant).following.get_or_init(|| {
            let rows = 0..self.length();
            rows.map(|index| Following::find(self, participant, index))
                .collect()
        });
        rows[index]
    }

    pub(super) fn exposure(&self, participant: usize, index: usize) -> Result<Exposure, NoValue> {
        self.road().map_err(|_| NoValue::NoRoute)?;
        let rows = self
            .pair(participant)
            .exposure
            .get_or_init(|| Exposure::rows(self, participant));
        Ok(rows[index])
    }

    pub(super) fn conflict(&self, participant: usize) -> &Conflict {
        let conflict = &self.pair(participant).conflict;
        conflict.get_or_init(|| Conflict::new(self, participant))
    }

    /// The latest starts of manoeuvres that avoid this one.
    pub(super) fn starts_before(&self, participant: usize) -> &Starts {
        let starts = &self.pair(participant).starts;
        starts.get_or_init(|| Starts::new(self, participant..participant + 1))
    }

    /// The latest starts of manoeuvres that avoid all obstacles.
    pub(super) fn starts(&self) -> &Starts {
        self.starts
            .get_or_init(|| Starts::new(self, 0..self.participants().len()))
    }

    /// The lanes that the other stands on.
    pub(super) fn lanes_of(&self, participant: usize, index: usize) -> LaneSet {
        let (Ok(road), Some((motion, body))) = (self.road(), self.other(participant, index)) else {
            return LaneSet::default();
        };
        let lanes = || road.lanes_under(self.scene, &body.at(motion.pose));
        if self.stands(participant) {
            return *self.pair(participant).standing_lanes.get_or_init(lanes);
        }
        lanes()
    }

    pub(super) fn stands(&self, participant: usize) -> bool {
        self.participants()[participant].obstacle.role == ObstacleRole::Static
    }
}
