//! Options of a description: its frame, contents and style.

use std::collections::HashMap;

use strum::{IntoStaticStr, VariantArray};

use super::nearby::{self, can_reach, centre_distance, first_to_touch};
use super::writer::written;
use crate::metrics::{Encounter, MeasureList};
use crate::scenario::{Motion, Participant, Scene, Window};

/// Farther away than this, metres between centres, what stands all the time is described once.
pub const STANDS_FAR: f64 = 20.0;

/// Seconds within which obstacles beyond the radius can reach the ego that are described, where no task has a horizon:
/// that of the safety task and of the judge.
const REACH: f64 = 2.0;

/// A participant that is described at a step, with its motion.
pub(super) type Near<'s> = (Participant<'s>, &'s Motion);

/// A described step.
pub(super) struct Moment<'s> {
    pub step: i64,
    /// Who is described at it, nearest first.
    pub near: Vec<Near<'s>>,
    /// Whether an obstacle nearby is left out that is described at a later step.
    pub left_out: bool,
}

/// Contents, precision and form of a description.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Obstacles whose centre is this near to the ego's, metres, and those of `reach`.
    pub radius: f64,
    /// Farther away, obstacles that can reach the ego within so many seconds as [`GIVE`](super::VELOCITY_TOLERANCE) has it, and the
    /// one of the lowest `ttc`; `None` for none of them, as in the paper.
    pub reach: Option<f64>,
    /// Decimals of metres, m/s and m/s²; radians get one more.
    pub precision: usize,
    /// Every so many steps, counted back from the last one, which is always described; 0 is taken as 1.
    pub stride: usize,
    /// At most so many times are described: in a longer window the stride grows. `None` for as many as there are.
    pub most_times: Option<usize>,
    /// Whether everyone is told that would be described at any step of the window, described or not, and in the ego
    /// frame the nearest moment of each.
    pub nearest: bool,
    /// Sentences or a table.
    pub form: Form,
    /// Whether it is said that bodies touch, as direction and in words; the distance tells it in any case.
    pub contact: bool,
    /// Whether the road near the ego is described too, in the Cartesian frame.
    pub road: bool,
    /// What the ego frame measures along and across.
    pub axes: EgoAxes,
    /// The measures of the metrics frame; `None` for its usual ones.
    pub measures: Option<MeasureList>,
    /// Only this obstacle; the trajectory frame needs one, and takes it however far away it is.
    pub obstacle: Option<i64>,
}

/// Form of a description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Form {
    /// Sentences.
    Prose,
    /// A table: one line of titles with units, one row a step and participant, `-` for no value.
    #[default]
    Compact,
}

nearmiss_record::named!(Form, "form");

/// The axes along and across which the ego frame measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum EgoAxes {
    /// The ego's heading.
    #[default]
    Heading,
    /// The ego's lane: s along its centre line, d to the left of it.
    Lane,
    /// The ego's heading, from centre to centre: neither distances nor gaps, so that no number says whether bodies touch.
    Centre,
}

nearmiss_record::named!(EgoAxes, "axes");

/// The frame that an option of one frame only is for, and the option's name.
pub const OF_ONE_FRAME: [(&str, Frame); 3] = [
    ("road", Frame::Cartesian),
    ("axes", Frame::Ego),
    ("measures", Frame::Metrics),
];

impl Default for Options {
    fn default() -> Self {
        Self {
            radius: 30.0,
            reach: Some(REACH),
            precision: 2,
            stride: 1,
            most_times: None,
            nearest: false,
            form: Form::default(),
            contact: false,
            road: false,
            axes: EgoAxes::default(),
            measures: None,
            obstacle: None,
        }
    }
}

impl Options {
    /// Steps between two described ones of a window: the stride, or more where that would describe too many times.
    #[must_use]
    pub fn spacing(&self, window: &Window) -> usize {
        let between = usize::try_from(window.last() - window.first()).unwrap_or(usize::MAX);
        let least = self.most_times.map_or(1, |most| between / most.max(1) + 1);
        self.stride.max(1).max(least)
    }

    /// The steps of a window that are described, in order.
    #[must_use]
    pub fn steps(&self, window: &Window) -> Vec<i64> {
        let stride = self.spacing(window);
        let mut steps: Vec<i64> = window.steps().rev().step_by(stride).collect();
        steps.reverse();
        steps
    }

    /// The participants that are described at `step`, with their motion, nearest first.
    pub(super) fn near<'a>(&self, scene: &'a Scene, step: i64) -> Vec<Near<'a>> {
        let Some(ego) = scene.ego.track.at(step) else {
            return Vec::new();
        };
        let first = self.reach.and_then(|_| first_to_touch(scene, step));
        let reaches = |p: &Participant<'_>| {
            let encounter = || Encounter::at(scene, p, step);
            let within = |seconds| encounter().is_some_and(|e| can_reach(&e, seconds));
            first == Some(p.obstacle.id) || self.reach.is_some_and(within)
        };
        let wanted = |p: &Participant<'_>| self.obstacle.is_none_or(|id| id == p.obstacle.id);
        let present = scene
            .participants()
            .filter(wanted)
            // Those have neither heading nor velocity, and a sentence of their own.
            .filter(|p| !p.obstacle.is_occupancy_at(step))
            .filter_map(|p| Some((p, p.at(step)?)));
        let mut near: Vec<_> = present
            .filter(|(p, m)| centre_distance(ego, m) <= self.radius || reaches(p))
            .collect();
        near.sort_by(|a, b| centre_distance(ego, a.1).total_cmp(&centre_distance(ego, b.1)));
        near
    }

    /// The described steps, in order, each with the participants that are described at it, nearest first.
    ///
    /// One whose speed is written as 0 and whose centre is more than [`STANDS_FAR`] from the ego's whenever it is near
    /// is described only at the last of these steps.
    pub(super) fn described<'a>(&self, scene: &'a Scene, window: &Window) -> Vec<Moment<'a>> {
        let steps = self.steps(window).into_iter();
        let moment = |step| Moment {
            step,
            near: self.near(scene, step),
            left_out: false,
        };
        let mut all: Vec<Moment<'a>> = steps.map(moment).collect();
        // By id: whether it stands far away all the time, and its last step.
        let mut known: HashMap<i64, (bool, i64)> = HashMap::new();
        for Moment { step, near, .. } in &all {
            let ego = scene.ego.track.at(*step);
            for (participant, motion) in near {
                let stands = written(motion.velocity, self.precision) == 0.0;
                let far = ego.is_some_and(|ego| centre_distance(ego, motion) > STANDS_FAR);
                let entry = known
                    .entry(participant.obstacle.id)
                    .or_insert((true, *step));
                *entry = (entry.0 && stands && far, *step);
            }
        }
        for moment in &mut all {
            let before = moment.near.len();
            moment.near.retain(|(participant, _)| {
                let known = known.get(&participant.obstacle.id);
                known.is_none_or(|(far, last)| !far || *last == moment.step)
            });
            moment.left_out = moment.near.len() < before;
        }
        all
    }
}

/// The obstacles that are described, in the order in which they come near.
pub(super) fn everyone<'a>(
    scene: &'a Scene,
    window: &Window,
    options: &Options,
    described: &[Moment<'a>],
) -> Vec<Participant<'a>> {
    if options.nearest {
        return nearby::came_near(scene, window, options);
    }
    let mut seen = std::collections::HashSet::new();
    let all = described.iter().flat_map(|moment| &moment.near);
    let first = all.filter(|(participant, _)| seen.insert(participant.obstacle.id));
    first.map(|(participant, _)| *participant).collect()
}

/// Kinds of description of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Frame {
    /// Gaps and motion seen from the ego.
    Ego,
    /// Positions on the map.
    Cartesian,
    /// Safety measures of all obstacles near.
    Metrics,
    /// What one obstacle and the ego did, and the road.
    Trajectory,
    /// A picture from above, with what is needed to read it.
    Picture,
    /// [`Frame::Ego`], and the picture.
    #[strum(to_string = "ego+picture")]
    EgoPicture,
    /// [`Frame::Cartesian`], and the picture.
    #[strum(to_string = "cartesian+picture")]
    CartesianPicture,
    /// [`Frame::Metrics`], and the picture.
    #[strum(to_string = "metrics+picture")]
    MetricsPicture,
    /// [`Frame::Trajectory`], and the picture.
    #[strum(to_string = "trajectory+picture")]
    TrajectoryPicture,
}

nearmiss_record::named!(Frame, "frame");

impl Frame {
    /// The frame of its words; `None` for the picture alone.
    #[must_use]
    pub fn words(self) -> Option<Self> {
        match self {
            Self::Picture => None,
            Self::EgoPicture => Some(Self::Ego),
            Self::CartesianPicture => Some(Self::Cartesian),
            Self::MetricsPicture => Some(Self::Metrics),
            Self::TrajectoryPicture => Some(Self::Trajectory),
            words => Some(words),
        }
    }

    /// Whether a picture belongs to it.
    #[must_use]
    pub fn has_picture(self) -> bool {
        self.words() != Some(self)
    }

    /// Whether it is about one obstacle, which has to be named, in times and coordinates of the recording.
    #[must_use]
    pub fn is_of_one_obstacle(self) -> bool {
        self.words() == Some(Self::Trajectory)
    }

    /// Whether positions in it are those on the map, so that north is up in its picture.
    #[must_use]
    pub fn is_on_the_map(self) -> bool {
        matches!(self.words(), Some(Self::Cartesian | Self::Trajectory))
    }

    /// The names of every frame, for help and errors.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_window_has_no_more_times_than_wanted_and_always_its_last() {
        for (steps, stride, most, wanted) in [
            (150, 1, None, 150),
            (150, 1, Some(30), 30),
            (151, 1, Some(30), 26),
            (30, 1, Some(30), 30),
            (10, 1, Some(30), 10),
            (150, 10, Some(30), 15),
            (150, 1, Some(1), 1),
            (1, 1, Some(30), 1),
        ] {
            let options = Options {
                stride,
                most_times: most,
                ..Options::default()
            };
            let window = Window::within(&(0..1000), 500, steps);
            let described = options.steps(&window);
            assert_eq!(described.len(), wanted, "{steps} {stride} {most:?}");
            assert_eq!(described.last(), Some(&500));
            let spacing = options.spacing(&window) as i64;
            assert!(described.windows(2).all(|two| two[1] - two[0] == spacing));
        }
    }
}
