//! What a description takes in, and how it writes numbers and names.

use std::fmt::Write;

use crate::scenario::{Motion, Participant, Scene, Window};

/// What to describe and how precisely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Only obstacles whose centre is this near to the ego's, metres.
    pub radius: f64,
    /// Decimals of metres, m/s and m/s²; radians get one more.
    pub precision: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            radius: 30.0,
            precision: 2,
        }
    }
}

impl Options {
    /// A number with the decimals asked for; never a negative zero.
    pub(super) fn number(&self, value: f64) -> String {
        fixed(value, self.precision)
    }

    /// An angle in radians.
    pub(super) fn angle(&self, value: f64) -> String {
        fixed(crate::geometry::normalize_angle(value), self.precision + 1)
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
        let present = scene.participants().filter_map(|p| Some((p, p.at(step)?)));
        let mut near: Vec<_> = present
            .filter(|(_, m)| distance(m) <= self.radius)
            .collect();
        near.sort_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        near
    }

    /// A line with the sizes of the ego and everyone who comes near during the window.
    pub(super) fn sizes(&self, scene: &Scene, window: &Window) -> String {
        let size = |length: f64, width: f64| {
            format!(
                "{} m long and {} m wide",
                self.number(length),
                self.number(width)
            )
        };
        let (length, width) = scene.ego.footprint.shape().size();
        let mut line = format!("Sizes: the ego is {}", size(length, width));
        let mut seen = Vec::new();
        for step in window.steps() {
            for (participant, _) in self.near(scene, step) {
                if !seen.contains(&participant.obstacle.id) {
                    seen.push(participant.obstacle.id);
                    let (length, width) = participant.footprint.shape().size();
                    let _ = write!(line, "; {} {}", name(&participant), size(length, width));
                }
            }
        }
        line.push_str(".\n");
        line
    }
}

/// What is said of a step that the ego's recording leaves out.
pub(super) const NO_EGO: &str = "  The ego is not recorded at this step.\n";

/// What an obstacle is called: its type and id.
pub(super) fn name(participant: &Participant<'_>) -> String {
    format!("{} {}", participant.obstacle.kind, participant.obstacle.id)
}

/// The head of one step.
pub(super) fn heading(scene: &Scene, step: i64) -> String {
    format!("Step {step}, t = {} s:\n", fixed(scene.time_of(step), 2))
}

/// The lanelets under a participant, for the end of a sentence.
pub(super) fn lanelets(scene: &Scene, motion: &Motion) -> String {
    let ids = scene.scenario.network.lanelets_at(&motion.pose.position);
    if ids.is_empty() {
        return "off the lanelets".into();
    }
    let ids: Vec<String> = ids.iter().map(i64::to_string).collect();
    format!("on lanelet {}", ids.join(" and "))
}

fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if zero {
        text.trim_start_matches('-').to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn no_negative_zero() {
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(fixed(-0.006, 2), "-0.01");
    }
}
