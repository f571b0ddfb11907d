//! Manoeuvres as events with parameters, each once, and how long and how far the egos drove to meet them.
//!
//! | event | moment | ends | parameters |
//! |---|---|---|---|
//! | cut-in, merging | the other's body first in the ego's lane | its centre in it | gap, closing, lateral speed, ego speed |
//! | cut-out | the body of the one ahead out of the ego's lane | the same | gap and closing to what it uncovers, lateral speed, ego speed |
//! | braking | the one ahead begins to brake | it ends to | gap, closing, mean and strongest deceleration, ego speed |
//!
//! Whose lane is whose is what [`Manoeuvre`] says of windows, over one second; a braking is that of stories. The other is the next
//! one ahead: who changes lanes farther ahead does nothing to this ego. It drives along the ego's way: who is turned by more than
//! 25° from it turns in or off, and changes no lanes. Gaps are along the ego's way, from its front to the other's
//! rear, of the exact bodies; below 0 the two are beside each other.
//!
//! The parameters are those of the cut-in, cut-out and deceleration scenarios of ISO 34502:2022 and of the models in UN Regulation
//! 157; initial and mean values as de Gelder et al. describe them ("Risk quantification for automated driving systems in real-world
//! driving scenarios", IEEE Access 9, 2021).

use std::cell::OnceCell;
use std::rc::Rc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use super::manoeuvre::{HALF_LANE, Manoeuvre, RoadType, TURN, in_line, is_inside};
use super::windows::{EgoWindows, STANDING, WindowEgo};
use crate::scenario::{ObstacleRole, ObstacleType};
use crate::story::{Braking, brakings};

/// What happens to an ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum EventKind {
    /// Another changes into the ego's lane, ahead of it.
    CutIn,
    /// Another comes from a lane that joins the ego's, ahead of it.
    Merging,
    /// The one ahead leaves the ego's lane.
    CutOut,
    /// The one ahead brakes, with at least 1 m/s² over 0.4 s.
    Braking,
}

nearmiss_record::named!(EventKind, "event");

/// Whose events are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Egos {
    /// The one that was recorded beside each scenario, or as it.
    Recorded,
    /// The other motor vehicles of the scenarios, each in turn.
    Obstacle,
}

nearmiss_record::named!(Egos, "ego_source");

/// What happened to an ego, once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Event {
    /// Whose event: recorded, the ego beside the scenario; obstacle, another motor vehicle.
    pub ego_source: Egos,
    /// Id of the ego.
    #[schemars(title = "ego")]
    pub ego_id: i64,
    /// Id of the other.
    #[schemars(title = "obstacle")]
    pub obstacle: i64,
    /// Its type.
    #[schemars(title = "type", with = "String")]
    #[serde(with = "type_word")]
    pub obstacle_type: ObstacleType,
    /// What happens: cut_in, merging, cut_out, braking.
    #[schemars(title = "manoeuvre")]
    pub manoeuvre: EventKind,
    /// Road under the ego.
    #[schemars(title = "road")]
    pub road: RoadType,
    /// Its moment.
    #[schemars(title = "step")]
    pub first_step: i64,
    /// Last step.
    pub last_step: i64,
    /// From the ego's front to the other's rear along the way; of a cut-out, to what it uncovers.
    #[schemars(title = "gap", extend("unit" = "m", "decimals" = 1))]
    pub gap: Option<f64>,
    /// The ego's speed minus that of the same, along the way.
    #[schemars(title = "closing", extend("unit" = "m/s", "decimals" = 1))]
    pub closing: Option<f64>,
    /// Mean speed of the other's centre across the way, between the body's and the centre's crossing of the lane's border.
    #[schemars(title = "lateral", extend("unit" = "m/s", "decimals" = 2))]
    pub lateral_speed: Option<f64>,
    /// The other's strongest deceleration over 0.4 s.
    #[schemars(title = "deceleration", extend("unit" = "m/s²", "decimals" = 1))]
    pub deceleration: Option<f64>,
    /// Its mean deceleration.
    #[schemars(title = "mean", extend("unit" = "m/s²", "decimals" = 1))]
    pub mean_deceleration: Option<f64>,
    /// The ego's speed.
    #[schemars(title = "ego speed", extend("unit" = "m/s", "decimals" = 1))]
    pub ego_speed: Option<f64>,
}

/// What an event is described by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Parameter {
    /// [`Event::gap`], metres.
    Gap,
    /// [`Event::closing`], m/s.
    Closing,
    /// [`Event::lateral_speed`], m/s.
    LateralSpeed,
    /// [`Event::deceleration`], m/s².
    Deceleration,
    /// [`Event::mean_deceleration`], m/s².
    MeanDeceleration,
    /// [`Event::ego_speed`], m/s.
    EgoSpeed,
}

nearmiss_record::named!(Parameter);

impl Parameter {
    /// Its value; what the event has none of, or what could not be measured, is missing.
    #[must_use]
    pub fn of(self, event: &Event) -> Option<f64> {
        match self {
            Self::Gap => event.gap,
            Self::Closing => event.closing,
            Self::LateralSpeed => event.lateral_speed,
            Self::Deceleration => event.deceleration,
            Self::MeanDeceleration => event.mean_deceleration,
            Self::EgoSpeed => event.ego_speed,
        }
    }

    /// Whether lower values are more extreme, or higher ones; `None` where neither is.
    #[must_use]
    pub fn extreme_is_low(self) -> Option<bool> {
        match self {
            Self::Gap => Some(true),
            Self::EgoSpeed => None,
            _ => Some(false),
        }
    }
}

/// Types of obstacles by their names.
mod type_word {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    use super::ObstacleType;

    pub fn serialize<S: Serializer>(kind: &ObstacleType, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(kind.name())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<ObstacleType, D::Error> {
        let word = String::deserialize(from)?;
        ObstacleType::parse(&word).ok_or_else(|| D::Error::custom(format!("unknown type {word}")))
    }
}

/// How long and how far egos drove.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Exposure {
    /// How many they are.
    pub egos: u64,
    /// Seconds.
    pub seconds: f64,
    /// Metres.
    pub metres: f64,
}

impl Exposure {
    /// Adds that of others.
    pub fn add(&mut self, more: &Self) {
        self.egos += more.egos;
        self.seconds += more.seconds;
        self.metres += more.metres;
    }
}

/// What happened to the egos of a scenario, and how far they drove: motor vehicles that move.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    /// Of the ego that was recorded beside the scenario, or as it.
    pub recorded: Exposure,
    /// Of its obstacles.
    pub obstacles: Exposure,
    /// In the order of egos, others and steps.
    pub events: Vec<Event>,
}

/// The same with the scenario that it is of, as an index has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScenarioDriven {
    /// The file's name without its ending.
    pub scenario: String,
    /// Path as it was found.
    pub file: String,
    /// SHA-256 of its content; empty in an index that does not have it.
    #[serde(default)]
    pub sha256: String,
    /// Whether it is a part of a long recording, around one track: then it is about that track alone.
    pub is_window: bool,
    /// The events and the way.
    #[serde(flatten)]
    pub driven: Driven,
}

impl Event {
    /// The same with its parameters rounded.
    #[must_use]
    pub fn rounded(self, round: impl Fn(f64) -> f64) -> Self {
        let round = |value: Option<f64>| value.map(&round);
        Self {
            gap: round(self.gap),
            closing: round(self.closing),
            lateral_speed: round(self.lateral_speed),
            deceleration: round(self.deceleration),
            mean_deceleration: round(self.mean_deceleration),
            ego_speed: round(self.ego_speed),
            ..self
        }
    }
}

impl Driven {
    /// Those of these egos.
    #[must_use]
    pub fn exposure(&self, egos: Egos) -> &Exposure {
        match egos {
            Egos::Recorded => &self.recorded,
            Egos::Obstacle => &self.obstacles,
        }
    }

    /// Adds an ego.
    pub(super) fn add(&mut self, ego: &EgoWindows<'_, '_, '_>) {
        let exposure = match ego.ego {
            WindowEgo::Recorded => &mut self.recorded,
            WindowEgo::Obstacle(id) => {
                let obstacle = ego.scene.scenario.obstacle(id);
                if obstacle.is_none_or(|obstacle| !is_driven(obstacle.kind)) {
                    return;
                }
                &mut self.obstacles
            }
        };
        let track = &ego.scene.ego.track;
        if track
            .iter()
            .all(|(_, motion)| motion.velocity.abs() < STANDING)
        {
            return;
        }
        let (seconds, metres) = track.driven(ego.scene.scenario.dt());
        exposure.add(&Exposure {
            egos: 1,
            seconds,
            metres,
        });
        self.events.extend(ego.events());
    }
}

/// Whether one drives it: tables of tracks may not say what it is.
fn is_driven(kind: ObstacleType) -> bool {
    use ObstacleType as Type;
    matches!(
        kind,
        Type::Car
            | Type::Truck
            | Type::Bus
            | Type::Motorcycle
            | Type::PriorityVehicle
            | Type::Taxi
            | Type::Unknown
    )
}

/// Who was in a lane so many seconds before is compared with now.
const BEFORE: f64 = 1.0;

/// A body does not cross the border of a lane for longer, seconds.
const LONGEST: f64 = 5.0;

/// Who is farther behind does nothing to the ego within a second, metres.
const BEHIND: f64 = 10.0;

/// The next one ahead: its place among the others.
type Leader = Option<usize>;

impl EgoWindows<'_, '_, '_> {
    /// What happens to the ego.
    pub(super) fn events(&self) -> Vec<Event> {
        let steps = self.scene.steps();
        let leaders: Vec<OnceCell<Leader>> = steps.map(|_| OnceCell::new()).collect();
        let mut found = Vec::new();
        for place in 0..self.context.participants().len() {
            let before = found.len();
            self.changes(place, &leaders, &mut found);
            self.brakings(place, &leaders, &mut found);
            found[before..].sort_by_key(|event| (event.first_step, event.last_step));
        }
        found
    }

    /// An event; `of` is whose gap and closing speed it has.
    fn event(
        &self,
        manoeuvre: EventKind,
        place: usize,
        of: Option<usize>,
        steps: (i64, i64),
    ) -> Event {
        let other = self.context.participants()[place].obstacle;
        let along = of.and_then(|of| self.context.along_way(of, steps.0));
        Event {
            ego_source: match self.ego {
                WindowEgo::Recorded => Egos::Recorded,
                WindowEgo::Obstacle(_) => Egos::Obstacle,
            },
            ego_id: self.scene.ego.id,
            obstacle: other.id,
            obstacle_type: other.kind,
            manoeuvre,
            road: self.road(steps.0),
            first_step: steps.0,
            last_step: steps.1,
            gap: along.map(|[ego, other]| other.rear - ego.front),
            closing: along.map(|[ego, other]| ego.velocity.x - other.velocity.x),
            lateral_speed: None,
            deceleration: None,
            mean_deceleration: None,
            ego_speed: self.scene.ego.track.at(steps.0).map(|ego| ego.velocity),
        }
    }

    /// Its cut-ins, mergings and cut-outs.
    fn changes(&self, place: usize, leaders: &[OnceCell<Leader>], found: &mut Vec<Event>) {
        if self.context.participants()[place].obstacle.role == ObstacleRole::Static {
            return;
        }
        let steps = self.scene.steps();
        let before = self.count(BEFORE);
        let inside: Vec<Option<bool>> =
            steps.clone().map(|step| self.inside(place, step)).collect();
        // From where on another change of the same kind is another event.
        let (mut free_in, mut free_out) = (i64::MIN, i64::MIN);
        for step in steps.start + before..steps.end {
            let index = |step: i64| usize::try_from(step - steps.start).unwrap_or_default();
            let (was, is) = (inside[index(step - before)], inside[index(step)]);
            let (Some(was), Some(is)) = (was, is) else {
                continue;
            };
            if was == is || step < if is { free_in } else { free_out } {
                continue;
            }
            let Some(pair) = self.motion(place, step - before, step) else {
                continue;
            };
            if is {
                let kind = match Manoeuvre::classify(&pair) {
                    Manoeuvre::CutIn => EventKind::CutIn,
                    Manoeuvre::Merging => EventKind::Merging,
                    _ => continue,
                };
                if self.leader(step, leaders) != Some(place) {
                    continue;
                }
                let first = self.comes_in(place, step);
                let is_new = first >= free_in;
                free_in = step + before;
                if is_new && self.goes_along(place, [first, step]) {
                    found.push(Event {
                        lateral_speed: self.lateral_speed(place, [first, step]),
                        ..self.event(kind, place, Some(place), (first, step))
                    });
                }
            } else if pair.cuts_out() && self.leader(step - before, leaders) == Some(place) {
                let last = self.goes_out(place, step);
                free_out = last.unwrap_or(step) + before;
                if let Some(last) = last.filter(|last| self.goes_along(place, [step, *last])) {
                    let uncovered = self.leader(last, leaders);
                    found.push(Event {
                        lateral_speed: self.lateral_speed(place, [step, last]),
                        ..self.event(EventKind::CutOut, place, uncovered, (last, last))
                    });
                }
            }
        }
    }

    /// Whether the other changes lanes along the ego's way, and does not turn into it or off it.
    fn goes_along(&self, place: usize, steps: [i64; 2]) -> bool {
        let is_along = |step| {
            let Some([_, other]) = self.context.along_way(place, step) else {
                return true;
            };
            other.velocity.y.abs() <= TURN.tan() * other.velocity.x
                || other.velocity.norm() < STANDING
        };
        steps.into_iter().all(is_along)
    }

    /// The other's mean speed across the way between two steps, m/s; at a single one, its speed across.
    fn lateral_speed(&self, place: usize, [first, last]: [i64; 2]) -> Option<f64> {
        let at = |step| Some(self.context.along_way(place, step)?[1]);
        let (from, to) = (at(first)?, at(last)?);
        Some(match (last - first) as f64 * self.scene.scenario.dt() {
            0.0 => to.velocity.y.abs(),
            seconds => (to.at.d - from.at.d).abs() / seconds,
        })
    }

    /// The first step at which its body is in the ego's lane, before its centre is.
    fn comes_in(&self, place: usize, crossing: i64) -> i64 {
        let before = (1..=self.count(LONGEST)).map(|count| crossing - count);
        let mut on = before.take_while(|step| self.body_inside(place, *step) == Some(true));
        on.by_ref().last().unwrap_or(crossing)
    }

    /// The first step at which its body is out of the ego's lane, after its centre is; nothing where it stays on the border.
    fn goes_out(&self, place: usize, crossing: i64) -> Option<i64> {
        let mut after = crossing..=crossing + self.count(LONGEST);
        after.find(|step| self.body_inside(place, *step) == Some(false))
    }

    /// The brakings of the one ahead.
    fn brakings(&self, place: usize, leaders: &[OnceCell<Leader>], found: &mut Vec<Event>) {
        let obstacle = self.context.participants()[place].obstacle;
        if obstacle.role == ObstacleRole::Static {
            return;
        }
        let known = self.shared.brakings.borrow().get(&obstacle.id).cloned();
        let all: Rc<[Braking]> = known.unwrap_or_else(|| {
            let all: Rc<[Braking]> = brakings(obstacle.track(), self.scene.scenario.dt()).into();
            let mut shared = self.shared.brakings.borrow_mut();
            shared.insert(obstacle.id, Rc::clone(&all));
            all
        });
        for braking in all.iter() {
            if self.leader(braking.steps.0, leaders) == Some(place) {
                found.push(Event {
                    deceleration: Some(braking.most),
                    mean_deceleration: Some(braking.mean),
                    ..self.event(EventKind::Braking, place, Some(place), braking.steps)
                });
            }
        }
    }

    /// How many steps so many seconds are.
    fn count(&self, seconds: f64) -> i64 {
        ((seconds / self.scene.scenario.dt()).round() as i64).max(1)
    }

    /// The next one ahead in the ego's lane and on its way that stands or drives along it: where lanes lie over each other, those
    /// under its centre alone do not say which one it is on.
    fn leader(&self, step: i64, leaders: &[OnceCell<Leader>]) -> Leader {
        let index = usize::try_from(step - self.scene.steps().start).ok()?;
        *leaders.get(index)?.get_or_init(|| {
            let all = 0..self.context.participants().len();
            let ahead = all.filter_map(|place| {
                if self.inside(place, step) != Some(true) {
                    return None;
                }
                let [own, theirs] = self.context.along_way(place, step)?;
                let is_on_way = theirs.right < HALF_LANE && theirs.left > -HALF_LANE;
                let speed = theirs.velocity;
                let is_along = speed.x > -STANDING && speed.y.abs() <= speed.x.max(STANDING);
                let is_ahead = theirs.at.s > own.at.s;
                (is_on_way && is_along && is_ahead).then_some((theirs.rear, place))
            });
            let next = ahead.min_by(|a, b| a.0.total_cmp(&b.0));
            next.map(|(_, place)| place)
        })
    }

    /// Whether its centre is in the ego's lane; nothing where one of them is not there, or they are too far apart.
    fn inside(&self, place: usize, step: i64) -> Option<bool> {
        let ego = self.scene.ego.track.at(step)?;
        let other = self.context.participants()[place].at(step)?;
        if (other.pose.position - ego.pose.position).norm() > self.options.radius {
            return None;
        }
        match self.relation(step, other) {
            Some(lane) => Some(in_line(lane)),
            None if ego.pose.to_local(&other.pose.position).x < -BEHIND => None,
            None => self.aside(place, step).map(is_inside),
        }
    }

    /// The same of a part of its body, however far apart they are.
    fn body_inside(&self, place: usize, step: i64) -> Option<bool> {
        let body = self.context.participants()[place].placed_at(step)?;
        if let Some(lanes) = self.lanes_at(step) {
            let under = self.shared.lanes.network.lanelets_under(&body);
            if !under.is_empty() {
                return lanes.relation_to(&under).map(in_line);
            }
        }
        let [ego, other] = self.context.along_way(place, step)?;
        let (right, left) = (other.right - ego.at.d, other.left - ego.at.d);
        Some(right < HALF_LANE && left > -HALF_LANE)
    }
}
