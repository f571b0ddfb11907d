//! What an attack is wished to be: who attacks, with which manoeuvre, from where, how hard, and how attackers move.

use std::fmt;
use std::str::FromStr;

use strum::{IntoStaticStr, VariantArray};

use nearmiss_base::geometry::{Placed, Point, angle_between};
use nearmiss_base::system::available;
use nearmiss_scene::scenario::{HumanLimits, ObstacleType};
use nearmiss_scene::verdict::ManoeuvreKind;

use super::attacker::{Candidate, LOOKAHEAD};
use super::{AttackContext, Capability};
use crate::driver::driver;
use crate::planner::Limits;

/// A wish; what is empty may be anything.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wish {
    /// Kinds of obstacles that may attack.
    pub actors: Vec<ObstacleType>,
    /// Manoeuvres that they may use.
    pub manoeuvres: Vec<ManoeuvreKind>,
    /// Where they come from; each of these places has to hold.
    pub places: Vec<AttackPlace>,
    /// Drivers that are to avoid it, by id.
    pub preventable_by: Vec<&'static str>,
    /// Of contacts that are as good otherwise, the hardest: the one with the highest risk of a serious injury.
    pub severe: bool,
}

/// Where an attacker comes from, as the ego sees it in the seconds before they could meet, while nothing is changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum AttackPlace {
    /// It drives across the ego's heading, to the right.
    FromLeft,
    /// It drives across the ego's heading, to the left.
    FromRight,
    /// It drives the other way.
    Oncoming,
    /// It is ahead and drives the same way.
    Ahead,
    /// It is behind the ego's rear and drives the same way.
    Behind,
    /// It is on a lane to the left, and drives the same way.
    LeftLane,
    /// It is on a lane to the right, and drives the same way.
    RightLane,
    /// A standing vehicle hides it from the ego.
    Hidden,
}

nearmiss_record::named!(AttackPlace);

/// Headings less apart than this are the same way, and than this from the opposite one the other way, radians.
const SAME_WAY: f64 = std::f64::consts::FRAC_PI_4;

/// One whose middle is farther to a side than this is on another lane, metres.
const LANE_OFFSET: f64 = 1.75;

/// Slower vehicles stand, m/s.
const STANDING: f64 = 0.5;

/// Between points of a line of sight that are looked at, metres.
const SIGHT: f64 = 0.25;

impl Wish {
    /// Whether nothing is wished.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether an obstacle may attack.
    #[must_use]
    pub fn allows(&self, stage: &AttackContext<'_>, candidate: &Candidate) -> bool {
        let Some(obstacle) = stage.scenario.obstacle(candidate.obstacle) else {
            return false;
        };
        let is_actor = self.actors.is_empty() || self.actors.contains(&obstacle.kind);
        is_actor
            && self
                .places
                .iter()
                .all(|place| comes(stage, candidate, *place))
    }

    /// Whether an obstacle is where it is wished at the step at which its attack begins.
    #[must_use]
    pub fn allows_begin(&self, stage: &AttackContext<'_>, obstacle: i64, step: i64) -> bool {
        let mut places = self.places.iter();
        places.all(|place| is_at(stage, obstacle, *place, step))
    }

    /// Whether a manoeuvre may be used.
    #[must_use]
    pub fn allows_manoeuvre(&self, kind: ManoeuvreKind) -> bool {
        self.manoeuvres.is_empty() || self.manoeuvres.contains(&kind)
    }
}

/// Which attacks a search may use.
#[derive(Debug, Clone, Copy, Default)]
pub struct AllowedAttacks<'a> {
    /// Only these obstacles may attack, any where that is empty.
    pub among: &'a [i64],
    /// What an attack is wished to be.
    pub wish: Option<&'a Wish>,
}

impl AllowedAttacks<'_> {
    /// The drivers that are to avoid it.
    pub(super) fn preventable_by(&self) -> &[&'static str] {
        self.wish.map_or(&[], |wish| &wish.preventable_by)
    }

    /// Whether the hardest contact is wished.
    pub(super) fn severe(&self) -> bool {
        self.wish.is_some_and(|wish| wish.severe)
    }

    /// Whether an obstacle may attack.
    pub(super) fn allow(&self, stage: &AttackContext<'_>, candidate: &Candidate) -> bool {
        let is_named = self.among.is_empty() || self.among.contains(&candidate.obstacle);
        is_named && self.wish.is_none_or(|wish| wish.allows(stage, candidate))
    }

    /// Whether an attack of an obstacle may begin at a step.
    pub(super) fn allow_begin(&self, stage: &AttackContext<'_>, obstacle: i64, step: i64) -> bool {
        let wish = self.wish;
        wish.is_none_or(|wish| wish.allows_begin(stage, obstacle, step))
    }

    /// Whether a manoeuvre may be used.
    pub(super) fn allow_manoeuvre(&self, kind: ManoeuvreKind) -> bool {
        self.wish.is_none_or(|wish| wish.allows_manoeuvre(kind))
    }
}

/// Its terms, as they are written.
impl fmt::Display for Wish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let any = |key: &str, words: Vec<&str>| {
            (!words.is_empty()).then(|| format!("{key}:{}", words.join(",")))
        };
        let actors = self.actors.iter().map(|kind| kind.name()).collect();
        let manoeuvres = self.manoeuvres.iter().map(|kind| kind.name()).collect();
        let places = self.places.iter();
        let terms = [any("actor", actors), any("manoeuvre", manoeuvres)]
            .into_iter()
            .flatten()
            .chain(places.map(|place| format!("place:{}", place.name())))
            .chain(any("preventable-by", self.preventable_by.clone()))
            .chain(self.severe.then(|| SEVERE.into()));
        f.write_str(&terms.collect::<Vec<_>>().join(" "))
    }
}

impl FromStr for Wish {
    type Err = String;

    /// Reads terms, separated by spaces: `actor:` and `manoeuvre:` with alternatives separated by commas, `place:`, and
    /// `preventable-by:` with drivers that all have to avoid it, and `severe`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut wish = Self::default();
        for term in text.split_whitespace() {
            let (key, value) = term.split_once(':').unwrap_or((term, ""));
            match key {
                "actor" => {
                    for word in value.split(',') {
                        let kind = named(key, word, &ObstacleType::ALL, ObstacleType::name)?;
                        wish.actors.push(kind);
                    }
                }
                "manoeuvre" => {
                    for word in value.split(',') {
                        let kind = named(key, word, &ManoeuvreKind::ALL, ManoeuvreKind::name)?;
                        wish.manoeuvres.push(kind);
                    }
                }
                "place" => {
                    let place = named(key, value, &AttackPlace::ALL, AttackPlace::name)?;
                    wish.places.push(place);
                }
                "preventable-by" => {
                    let drivers = value.split(',').map(|id| Ok(driver(id)?.id));
                    let drivers: Vec<&str> = drivers.collect::<Result<_, String>>()?;
                    wish.preventable_by.extend(drivers);
                }
                _ if term == SEVERE => wish.severe = true,
                _ => {
                    return Err(format!(
                        "unknown term `{term}`; available: actor: manoeuvre: place: preventable-by: {SEVERE}, such as {EXAMPLE}"
                    ));
                }
            }
        }
        if wish.is_empty() {
            Err(format!("expected terms, such as {EXAMPLE}"))
        } else {
            Ok(wish)
        }
    }
}

/// The term that asks for the hardest contact.
const SEVERE: &str = "severe";

/// Terms that show how they are written.
const EXAMPLE: &str = "actor:car,truck manoeuvre:cut-in place:left-lane";

/// What a word of a term names, in any case, with `_`, `-` or neither.
fn named<T: Copy>(
    key: &str,
    word: &str,
    all: &[T],
    name: fn(T) -> &'static str,
) -> Result<T, String> {
    let plain = |word: &str| word.replace(['-', '_'], "").to_lowercase();
    let found = all.iter().find(|one| plain(name(**one)) == plain(word));
    let known = all.iter().map(|one| name(*one));
    found.copied().ok_or_else(|| {
        let known = available(word, known);
        format!("unknown value `{word}` of `{key}:`{known}")
    })
}

/// Whether an obstacle is at such a place at any step within [`LOOKAHEAD`] before it could meet the ego.
fn comes(stage: &AttackContext<'_>, candidate: &Candidate, place: AttackPlace) -> bool {
    let from = candidate.step - stage.step_at(LOOKAHEAD);
    (from.max(*stage.steps.start())..=candidate.step)
        .any(|step| is_at(stage, candidate.obstacle, place, step))
}

fn is_at(stage: &AttackContext<'_>, id: i64, place: AttackPlace, step: i64) -> bool {
    let obstacle = stage.scenario.obstacle(id);
    let both = stage
        .ego_at(step)
        .zip(obstacle.and_then(|o| o.motion_at(step)));
    let Some((ego, other)) = both else {
        return false;
    };
    let there = ego.pose.to_local(&other.pose.position);
    let turn = angle_between(ego.pose.heading, other.pose.heading);
    let same = turn.abs() < SAME_WAY;
    let opposite = turn.abs() > std::f64::consts::PI - SAME_WAY;
    let across = !same && !opposite;
    let half = stage.footprint.shape().size().0 / 2.0;
    match place {
        AttackPlace::FromLeft => across && turn < 0.0,
        AttackPlace::FromRight => across && turn > 0.0,
        AttackPlace::Oncoming => opposite && there.x > 0.0,
        AttackPlace::Ahead => same && there.x > half,
        AttackPlace::Behind => same && there.x < -half,
        AttackPlace::LeftLane => same && there.y > LANE_OFFSET,
        AttackPlace::RightLane => same && there.y < -LANE_OFFSET,
        AttackPlace::Hidden => is_hidden(stage, id, (ego.pose.position, other.pose.position), step),
    }
}

/// Whether the body of a standing vehicle is between two points.
fn is_hidden(stage: &AttackContext<'_>, id: i64, (from, to): (Point, Point), step: i64) -> bool {
    let far = (to - from).norm();
    let points = (far / SIGHT).ceil().clamp(1.0, 1e4) as usize;
    let between = |body: &Placed<'_>| {
        (1..points).any(|n| {
            let at = from + (to - from) * (n as f64 / points as f64);
            body.holds(&at)
        })
    };
    let mut others = stage.scenario.obstacles.iter().filter(|o| o.id != id);
    others.any(|other| {
        let stands = other
            .motion_at(step)
            .is_some_and(|m| m.velocity.abs() < STANDING);
        let hides = !matches!(other.kind, ObstacleType::Pedestrian | ObstacleType::Bicycle);
        stands
            && hides
            && other.placed_at(step).is_some_and(|body| {
                let middle = body.pose.position;
                let reach = body.footprint.reach();
                (middle - from).norm() <= far + reach && between(&body)
            })
    })
}

/// The limits that attackers keep.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray, strum::Display,
)]
#[strum(serialize_all = "lowercase")]
pub enum AttackStyle {
    /// Those of people, by kind of road user; see [`HumanLimits`].
    #[default]
    Human,
    /// Those of the vehicle.
    Limit,
}

nearmiss_record::named!(AttackStyle, "style");

/// What squared jerks of people cost: 2 m/s³ as much as 0.2 m off the way.
const JERK_COST: f64 = 1e-2;

impl Capability {
    /// What is left of it to a person who keeps these limits.
    #[must_use]
    pub fn of_person(self, person: &HumanLimits) -> Self {
        let limits = &self.limits;
        Self {
            limits: Limits {
                acceleration: limits.acceleration.min(person.braking),
                steering: limits
                    .steering
                    .min((limits.wheelbase / person.radius).atan()),
                speed: limits.speed.min(person.speed),
                ..*limits
            },
            jerk: self.jerk.min(person.jerk),
            jerk_cost: JERK_COST,
            speeding_up: self.speeding_up.min(person.speeding_up),
            lateral: self.lateral.min(person.lateral),
            ..self
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_read_and_written_alike() {
        for (text, written) in [
            ("actor:bicycle place:hidden", "actor:bicycle place:hidden"),
            (
                "place:left-lane  manoeuvre:Cut_In,drift actor:car,truck",
                "actor:car,truck manoeuvre:cut-in,drift place:left-lane",
            ),
            ("place:ahead place:hidden", "place:ahead place:hidden"),
            ("actor:priority_vehicle", "actor:priorityVehicle"),
            ("severe place:ahead", "place:ahead severe"),
        ] {
            let wish: Wish = text.parse().unwrap();
            assert_eq!(wish.to_string(), written);
            assert_eq!(written.parse(), Ok(wish));
        }
        for place in AttackPlace::ALL {
            assert_eq!(
                format!("place:{}", place.name())
                    .parse::<Wish>()
                    .unwrap()
                    .places,
                [place]
            );
        }
    }

    #[test]
    fn what_is_no_term_is_named_with_what_there_is() {
        for (text, says) in [
            ("", "such as actor:car"),
            (
                "a car cuts in",
                "unknown term `a`; available: actor: manoeuvre: place:",
            ),
            ("who:car", "unknown term `who:car`"),
            ("severe:very", "unknown term `severe:very`"),
            ("actor:car,giraffe", "unknown value `giraffe` of `actor:`"),
            ("actor:car, manoeuvre:drift", "unknown value `` of `actor:`"),
            ("manoeuvre:cutin2", "did you mean `cut-in`?"),
            (
                "place:ahead,hidden",
                "unknown value `ahead,hidden` of `place:`; did you mean `ahead`",
            ),
            ("place:", "unknown value `` of `place:`"),
        ] {
            let error = text.parse::<Wish>().unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
