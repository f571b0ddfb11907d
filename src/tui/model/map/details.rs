//! Details of the picked obstacle at the cursor, as lines for the window and the clipboard.

use super::Model;
use crate::loaded::Opened;
use crate::widgets::words::{hundredths, number};
use nearmiss_scene::metrics::{Encounter, Relation};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Prediction, Scene, State};

/// A line of the details.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Detail {
    /// A title of the following lines.
    Title(String),
    /// A name and its value.
    Said(&'static str, String),
}

/// Details as plain text, a line each.
#[must_use]
pub fn as_text(details: &[Detail]) -> String {
    let line = |detail: &Detail| match detail {
        Detail::Title(title) => format!("{title}\n"),
        Detail::Said(name, said) => format!("  {name}: {said}\n"),
    };
    details.iter().map(line).collect()
}

impl Model {
    /// The details of the picked obstacle at the cursor; `None` if none is picked.
    #[must_use]
    pub fn details(&self) -> Option<Vec<Detail>> {
        let opened = self.opened.as_deref()?;
        let obstacle = opened.scenario.obstacle(self.picked?)?;
        let step = self.clock.step();
        let dt = opened.scenario.dt();
        let mut lines = Lines(Vec::new());
        lines.title(format!("{} {}", obstacle.kind, obstacle.id));
        what(&mut lines, obstacle);
        lines.title(format!("at {:.1} s, step {step}", self.clock.time()));
        now(&mut lines, opened, obstacle, step);
        if let Some(scene) = opened.scene.as_deref() {
            lines.title("seen from the ego".into());
            seen(&mut lines, opened, scene, obstacle, step);
        }
        lines.title("in the recording".into());
        whole(&mut lines, opened, obstacle, dt);
        Some(lines.0)
    }
}

struct Lines(Vec<Detail>);

impl Lines {
    fn title(&mut self, title: String) {
        self.0.push(Detail::Title(title));
    }

    fn say(&mut self, name: &'static str, said: String) {
        self.0.push(Detail::Said(name, said));
    }
}

fn what(lines: &mut Lines, obstacle: &Obstacle) {
    lines.say("role", obstacle.role.to_string());
    lines.say(
        "size",
        match &obstacle.footprint {
            Some(body) => {
                let (length, width) = body.shape().size();
                format!("{} m long, {} m wide", number(length), number(width))
            }
            None => "not recorded".into(),
        },
    );
}

fn motion_words(motion: &Motion) -> Vec<(&'static str, String)> {
    let p = motion.pose.position;
    vec![
        ("position", format!("{:.2}, {:.2} m", p.x, p.y)),
        (
            "heading",
            format!("{:.1}°", motion.pose.heading.to_degrees()),
        ),
        (
            "speed",
            format!(
                "{} m/s ({:.0} km/h)",
                hundredths(motion.velocity),
                motion.velocity * 3.6
            ),
        ),
    ]
}

fn now(lines: &mut Lines, opened: &Opened, obstacle: &Obstacle, step: i64) {
    let motion = obstacle.motion_at(step);
    let Some(motion) = motion.filter(|_| !obstacle.is_occupancy_at(step)) else {
        let why = match &obstacle.prediction {
            Prediction::Occupancies(_) => "given as regions (occupancy sets), not states",
            _ => "absent at this step",
        };
        return lines.say("state", why.into());
    };
    for (name, said) in motion_words(motion) {
        lines.say(name, said);
    }
    lines.say(
        "acceleration",
        format!("{} m/s²", hundredths(motion.acceleration)),
    );
    if obstacle.role != ObstacleRole::Static {
        let yaw_rate = obstacle.yaw_rate_at(step, opened.scenario.dt());
        let rate = yaw_rate.map_or("not recorded".into(), |(rate, said)| {
            let how = if said { "" } else { ", from the headings" };
            format!("{} °/s{how}", hundredths(rate.to_degrees()))
        });
        lines.say("yaw rate", rate);
    }
    let lanelets = opened.scenario.network.lanelets_at(&motion.pose.position);
    lines.say(
        "lanelets",
        if lanelets.is_empty() {
            "none under its centre".into()
        } else {
            joined(lanelets.iter().map(i64::to_string))
        },
    );
    lines.say("signals", signals(obstacle, step));
}

fn signals(obstacle: &Obstacle, step: i64) -> String {
    let Some(state) = obstacle.signals_at(step) else {
        return "not recorded".into();
    };
    let on = state.signals.iter().filter(|(_, on)| *on);
    match joined(on.map(|(signal, _)| signal.to_string())) {
        none if none.is_empty() => "all off".into(),
        on => on,
    }
}

fn joined(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(", ")
}

fn seen(lines: &mut Lines, opened: &Opened, scene: &Scene, obstacle: &Obstacle, step: i64) {
    let participant = scene.participants().find(|p| p.obstacle.id == obstacle.id);
    let Some(participant) = participant else {
        return lines.say("relation", "the ego itself, or without a body".into());
    };
    let Some(encounter) = Encounter::at(scene, &participant, step) else {
        return lines.say("relation", "not present at the same time".into());
    };
    let relation = Relation::new(&encounter);
    lines.say("direction", relation.direction.name().to_lowercase());
    let reading = |measure| {
        opened
            .series
            .as_ref()
            .map(|s| s.at(measure, obstacle.id, step))
    };
    for (measure, unit) in [("distance", " m"), ("ttc", " s"), ("risk", "")] {
        let Some(reading) = reading(measure) else {
            continue;
        };
        let said = match (reading.value(), reading) {
            (Some(value), _) if measure == "risk" => format!("{value:.0}"),
            (Some(value), _) => format!("{}{unit}", hundredths(value)),
            (None, nearmiss_scene::metrics::Reading::None(why)) => format!("– {}", why.reason()),
            (None, _) => continue,
        };
        lines.say(measure, said);
    }
    lines.say(
        "gaps",
        format!(
            "{} m along, {} m across",
            hundredths(relation.gap_long),
            hundredths(relation.gap_lat)
        ),
    );
    lines.say(
        "velocity",
        format!(
            "{} m/s along, {} m/s across, minus the ego's",
            hundredths(relation.velocity.x),
            hundredths(relation.velocity.y)
        ),
    );
}

fn whole(lines: &mut Lines, opened: &Opened, obstacle: &Obstacle, dt: f64) {
    let at = |step: i64| format!("step {step} ({:.1} s)", step as f64 * dt);
    match &obstacle.prediction {
        _ if obstacle.role == ObstacleRole::Static => {
            lines.say("there", "at all times".into());
        }
        Prediction::Occupancies(regions) => {
            let from = regions.iter().map(|r| r.time.from).min();
            let to = regions.iter().map(|r| r.time.to).max();
            if let (Some(from), Some(to)) = (from, to) {
                let count = regions.len();
                lines.say("regions", format!("{count}, {} to {}", at(from), at(to)));
            }
        }
        _ => {
            let steps = obstacle.track().steps();
            if !steps.is_empty() {
                lines.say("appears", at(steps.start));
                lines.say("leaves", format!("after {}", at(steps.end - 1)));
            }
        }
    }
    if let Some(initial) = &obstacle.initial {
        lines.say("initial", initial_words(initial));
    }
    if let Some(series) = &opened.series {
        let row = series.steps().zip(series.row("distance", obstacle.id));
        let values = row.filter_map(|(step, reading)| Some((reading.value()?, step)));
        if let Some((least, step)) = values.min_by(|a, b| a.0.total_cmp(&b.0)) {
            lines.say(
                "nearest",
                format!("{} m at {}", hundredths(least), at(step)),
            );
        }
    }
}

fn initial_words(state: &State) -> String {
    let mut words = Vec::new();
    if let Some(p) = state.middle() {
        words.push(format!("{:.2}, {:.2} m", p.x, p.y));
    }
    if let Some(v) = state.velocity {
        words.push(format!("{} m/s", hundredths(v.middle())));
    }
    if words.is_empty() {
        return "neither position nor speed recorded".into();
    }
    words.join(", ")
}
