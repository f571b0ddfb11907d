//! Options of a description: contents and style.

use crate::scenario::{Motion, Participant, Scene, Window};

/// Contents, precision and form of a description.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Only obstacles whose centre is this near to the ego's, metres.
    pub radius: f64,
    /// Decimals of metres, m/s and m/s²; radians get one more.
    pub precision: usize,
    /// Every so many steps, counted back from the last one, which is always described; 0 is taken as 1.
    pub stride: usize,
    /// Sentences or a table.
    pub form: Form,
    /// Whether it is said that bodies touch, as direction and in words; the gaps tell it in any case.
    pub contact: bool,
    /// Only this obstacle; the trajectory frame needs one, and takes it however far away it is.
    pub obstacle: Option<i64>,
}

/// Form of a description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Form {
    /// Sentences.
    #[default]
    Prose,
    /// A table: one line of titles with units, one row a step and participant, `-` for no value.
    Compact,
}

impl Form {
    /// Every form.
    pub const ALL: [Self; 2] = [Self::Prose, Self::Compact];

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Prose => "prose",
            Self::Compact => "compact",
        }
    }

    /// The form with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            radius: 30.0,
            precision: 2,
            stride: 1,
            form: Form::Prose,
            contact: false,
            obstacle: None,
        }
    }
}

impl Options {
    /// The steps of a window that are described, in order.
    #[must_use]
    pub fn steps(&self, window: &Window) -> Vec<i64> {
        let stride = self.stride.max(1);
        let mut steps: Vec<i64> = window.steps().rev().step_by(stride).collect();
        steps.reverse();
        steps
    }

    /// The participants near the ego at `step`, with their motion, nearest first.
    pub(super) fn near<'a>(
        &self,
        scene: &'a Scene,
        step: i64,
    ) -> Vec<(Participant<'a>, &'a Motion)> {
        let Some(ego) = scene.ego.track.at(step) else {
            return Vec::new();
        };
        let distance = |m: &Motion| (m.pose.position - ego.pose.position).norm();
        let wanted = |p: &Participant<'_>| self.obstacle.is_none_or(|id| id == p.obstacle.id);
        let present = scene.participants().filter(wanted);
        let present = present.filter_map(|p| Some((p, p.at(step)?)));
        let mut near: Vec<_> = present
            .filter(|(_, m)| distance(m) <= self.radius)
            .collect();
        near.sort_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        near
    }

    /// The obstacles near at a described step, in the order in which they come near.
    pub(super) fn everyone<'a>(&self, scene: &'a Scene, window: &Window) -> Vec<Participant<'a>> {
        let mut seen = std::collections::HashSet::new();
        let mut everyone = Vec::new();
        for step in self.steps(window) {
            for (participant, _) in self.near(scene, step) {
                if seen.insert(participant.obstacle.id) {
                    everyone.push(participant);
                }
            }
        }
        everyone
    }
}
