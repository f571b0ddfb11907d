//! What the map shows: layers, details of obstacles, the tape, and its image.

pub mod foresight;
pub mod moment;

use nearmiss_base::geometry::{Gap, Placed, Point, Tip};
use nearmiss_render::Picture;
use nearmiss_scene::metrics::{Encounter, Relation};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Prediction, Scene, State};
use ratatui::layout::Position;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use crate::loaded::Opened;
use crate::model::Model;
use crate::pixels::{Encoder, ImageRequest, MapImage};
use crate::widgets::words::{hundredths, number};

pub use foresight::{Foresight, Future, PathRequest};
pub use moment::{DrivenBy, Moment, SecondMap, Strip};

/// The tools of the map.
#[derive(Debug, Default)]
pub struct Tools {
    /// Visible layers; saved with the session.
    pub layers: Layers,
    /// Paths into the future, as far as they are shown.
    pub foresight: Foresight,
    /// The second map.
    pub second: SecondMap,
    /// The map as an image.
    pub images: Images,
    /// The measuring tape, if it is out.
    pub tape: Option<Tape>,
    /// Where the mouse took hold of the map, and whether it moved since.
    pub held: Option<(Position, bool)>,
}

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
        lines.title(format!("{} {}", obstacle.kind.words(), obstacle.id));
        what(&mut lines, obstacle);
        lines.title(format!("at {:.1} s, step {step}", self.clock.time()));
        now(&mut lines, opened, obstacle, step);
        if let Some(scene) = opened.scene.as_deref() {
            lines.title("seen from the ego".into());
            seen(&mut lines, opened, scene, obstacle, step);
        }
        lines.title("in the recording".into());
        full_details(&mut lines, opened, obstacle, dt);
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

fn full_details(lines: &mut Lines, opened: &Opened, obstacle: &Obstacle, dt: f64) {
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

/// The map as an image, where the terminal shows images.
#[derive(Debug, Default)]
pub struct Images {
    /// How images are sent; `None` where the terminal shows none.
    pub encoder: Option<Encoder>,
    /// What is shown.
    pub shown: Option<MapImage>,
    requested: Option<(Picture, f64, (u16, u16))>,
    is_pending: bool,
    count: u64,
}

impl Images {
    /// The request for a picture, unless it is that of the last one, or one is being made: the next frame asks anew.
    pub fn request(
        &mut self,
        picture: Picture,
        dpi: f64,
        cells: (u16, u16),
    ) -> Option<ImageRequest> {
        let encoder = self.encoder.clone()?;
        let last = self.requested.as_ref();
        let known =
            last.is_some_and(|(last, at, size)| (last, at, size) == (&picture, &dpi, &cells));
        if self.is_pending || known {
            return None;
        }
        self.is_pending = true;
        self.count += 1;
        self.requested = Some((picture.clone(), dpi, cells));
        Some(ImageRequest {
            picture,
            dpi,
            cells,
            count: self.count,
            encoder,
        })
    }

    /// Takes an image; the first one that cannot be made ends them.
    ///
    /// # Errors
    /// It could not be made.
    pub fn take(&mut self, image: Result<MapImage, String>) -> Result<(), String> {
        self.is_pending = false;
        match image {
            Ok(image) => self.shown = Some(image),
            Err(why) => {
                self.forget();
                self.encoder = None;
                return Err(why);
            }
        }
        Ok(())
    }

    /// The terminal has lost its images, or the map is drawn in another way.
    pub fn forget(&mut self) {
        self.shown = None;
        self.requested = None;
    }
}

/// Selects the obstacles whose predicted paths are drawn.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Foreseen {
    /// No paths.
    #[default]
    Off,
    /// The picked obstacle's.
    #[strum(to_string = "of the picked one")]
    Picked,
    /// Those of all near the ego, and the ego's own.
    #[strum(to_string = "of all near the ego")]
    Near,
}

nearmiss_record::named!(Foreseen);

/// Selects whose trails are drawn.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "lowercase", from = "SavedTrails")]
#[strum(serialize_all = "lowercase")]
pub enum Trails {
    /// Of no obstacle.
    Off,
    /// The ego's and the picked obstacle's.
    #[default]
    #[strum(to_string = "of the ego and the picked one")]
    Picked,
    /// All of them.
    #[strum(to_string = "of all")]
    All,
}

/// Trails as sessions hold them; older ones say whether there are any.
#[derive(Deserialize)]
#[serde(untagged)]
enum SavedTrails {
    Any(bool),
    Whose(SavedWhose),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum SavedWhose {
    Off,
    Picked,
    All,
}

impl From<SavedTrails> for Trails {
    fn from(saved: SavedTrails) -> Self {
        match saved {
            SavedTrails::Any(false) | SavedTrails::Whose(SavedWhose::Off) => Self::Off,
            SavedTrails::Any(true) | SavedTrails::Whose(SavedWhose::Picked) => Self::Picked,
            SavedTrails::Whose(SavedWhose::All) => Self::All,
        }
    }
}

nearmiss_record::named!(Trails);

/// The layers of the map.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Layers {
    /// Markings of lanes and crossings.
    pub lanes: bool,
    /// Traffic signs.
    pub signs: bool,
    /// Traffic lights and stop lines.
    pub lights: bool,
    /// Whose past and recorded future is drawn.
    pub trails: Trails,
    /// Predicted and counterfactual paths.
    pub paths: Foreseen,
    /// Occupancy sets.
    pub occupancy: bool,
    /// Names beside vehicles.
    pub labels: bool,
    /// Goals of the planning problems.
    pub goal: bool,
    /// The planner's choice, and the recorded ego beside the planned one.
    pub planner: bool,
    /// The planner's candidates, drivable and rejected, and the bodies that it expects.
    #[serde(rename = "rejected")]
    pub candidates: bool,
    /// The two motions of a variant's attacker.
    pub variant: bool,
    /// The picture that models are shown in place of the map, in terminals that show images.
    pub shown: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            lanes: true,
            signs: true,
            lights: true,
            trails: Trails::Picked,
            paths: Foreseen::Off,
            occupancy: true,
            labels: true,
            goal: true,
            planner: true,
            candidates: false,
            variant: true,
            shown: false,
        }
    }
}

impl Layers {
    /// How many layers there are.
    pub const COUNT: usize = 12;

    /// Every layer: what it is, and how it is switched.
    #[must_use]
    pub fn rows(&self) -> [(&'static str, &'static str); Self::COUNT] {
        let on = |on: bool| if on { "on" } else { "off" };
        [
            ("lane markings", on(self.lanes)),
            ("signs", on(self.signs)),
            ("lights and stop lines", on(self.lights)),
            ("trails", self.trails.name()),
            ("predicted paths", self.paths.name()),
            ("occupancy sets", on(self.occupancy)),
            ("labels", on(self.labels)),
            ("goals", on(self.goal)),
            ("planner's choice", on(self.planner)),
            ("planner's candidates", on(self.candidates)),
            ("both motions of a variant's attacker", on(self.variant)),
            ("the picture for models, as an image", on(self.shown)),
        ]
    }

    /// Switches the layer in this row of [`Layers::rows`].
    pub fn switch(&mut self, row: usize) {
        let layer = match row {
            0 => &mut self.lanes,
            1 => &mut self.signs,
            2 => &mut self.lights,
            3 => {
                self.trails = self.trails.next();
                return;
            }
            4 => {
                self.paths = self.paths.next();
                return;
            }
            5 => &mut self.occupancy,
            6 => &mut self.labels,
            7 => &mut self.goal,
            8 => &mut self.planner,
            9 => &mut self.candidates,
            10 => &mut self.variant,
            11 => &mut self.shown,
            _ => return,
        };
        *layer = !*layer;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_row_switches_what_it_names_and_is_kept() {
        for row in 0..Layers::COUNT {
            let mut layers = Layers::default();
            layers.switch(row);
            let changed =
                (0..Layers::COUNT).filter(|&r| layers.rows()[r] != Layers::default().rows()[r]);
            assert_eq!(changed.collect::<Vec<_>>(), [row]);
            let saved = toml::to_string(&layers).unwrap();
            assert_eq!(toml::from_str::<Layers>(&saved).unwrap(), layers);
        }
        let old: Layers = toml::from_str("signs = false").unwrap();
        assert!(!old.signs && old.lanes, "what is not said is as usual");
        // Sessions written before trails were chosen said only whether there are any.
        for (saved, trails) in [
            ("true", Trails::Picked),
            ("false", Trails::Off),
            ("\"all\"", Trails::All),
        ] {
            let old: Layers = toml::from_str(&format!("trails = {saved}")).unwrap();
            assert_eq!(old.trails, trails);
        }
    }
}
