//! A part of a scenario: of its time, its area, its obstacles; what is left refers to nothing that is gone.

mod area;
mod problems;
mod time;

use std::collections::BTreeSet;
use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;
use std::sync::Arc;

use nearmiss_base::geometry::{Bounds, Point};

use super::{
    ContentHash, Ego, EgoSource, LaneletNetwork, Obstacle, RecordedEgo, Scenario, SceneError,
};
use area::Near;
use problems::Problems;
use time::Cut;

/// What of a scenario is kept.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Crop {
    /// Time steps, ends included; all where none are named.
    pub steps: Option<RangeInclusive<i64>>,
    /// An area.
    pub around: Option<Around>,
    /// These obstacles alone.
    pub keep: Option<BTreeSet<i64>>,
    /// All but these obstacles.
    pub drop: BTreeSet<i64>,
    /// Whether the first step that is kept becomes step 0; else steps keep their numbers.
    pub from_zero: bool,
}

/// Everything within so many metres of something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Around {
    /// Of what.
    pub centre: Centre,
    /// Metres, positive.
    pub metres: f64,
}

/// What an area is around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Centre {
    /// The way of the ego in the time that is kept.
    Ego,
    /// A point of the map, metres.
    At(Point),
}

/// What is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Cropped {
    /// The scenario; its hash is one of the original's and of what was kept.
    pub scenario: Arc<Scenario>,
    /// The ego.
    pub ego: Option<Ego>,
    /// How much is kept, and what became of planning problems, a sentence each.
    pub said: Vec<String>,
}

/// Why a part is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CropError {
    /// An obstacle that is kept or dropped is not there.
    #[error(transparent)]
    Obstacle(#[from] SceneError),
    /// The ego is not dropped.
    #[error("obstacle {0} is the ego and cannot be dropped")]
    Ego(i64),
    /// The area is around an ego, and there is none.
    #[error("there is no ego to be around; name a point: X,Y:60m")]
    NoEgo,
    /// The ego is elsewhere in time.
    #[error("the ego is there from step {} to {}, not from {} to {}", .there.start, .there.end - 1, .kept.start(), .kept.end())]
    EgoAway {
        /// Its steps.
        there: Range<i64>,
        /// The steps that were to be kept.
        kept: RangeInclusive<i64>,
    },
    /// One step shows no motion.
    #[error("step {0} alone is no scenario; keep at least two steps")]
    OneStep(i64),
    /// No road is within the area.
    #[error("no lanelet lies within {around}; the road has x from {:.0} to {:.0} and y from {:.0} to {:.0}", .road.min.x, .road.max.x, .road.min.y, .road.max.y)]
    NoRoad {
        /// The area.
        around: Around,
        /// The box around the road.
        road: Bounds,
    },
    /// No road user is left.
    #[error("nothing is left: no obstacle is there, and no ego")]
    Nothing,
}

impl Crop {
    /// Whether nothing is left out.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let all = self.keep.is_none() && self.drop.is_empty();
        all && self.steps.is_none() && self.around.is_none()
    }

    /// The steps of a scenario and its ego, of which some are kept.
    #[must_use]
    pub fn steps_of(scenario: &Scenario, ego: Option<&Ego>) -> Range<i64> {
        let all = scenario.steps();
        match ego.map(|ego| ego.track.steps()) {
            Some(own) if scenario.obstacles.is_empty() && scenario.recorded_ego.is_none() => own,
            Some(own) => all.start.min(own.start)..all.end.max(own.end),
            None => all,
        }
    }

    /// The part of a scenario and its ego.
    ///
    /// States outside the time go, and obstacles that are never inside time and area, or only for a moment: a motion
    /// has two states. The others keep all their states of that time. Lanelets outside the area go, with the signs and
    /// lights of theirs alone, the references to them, and goals there. A planning problem that began before begins
    /// with the ego, or goes where there is none.
    ///
    /// # Errors
    /// See [`CropError`].
    pub fn apply(&self, scenario: &Scenario, ego: Option<&Ego>) -> Result<Cropped, CropError> {
        self.check(scenario, ego)?;
        let all = Self::steps_of(scenario, ego);
        let cut = Cut::new(self.steps.as_ref(), self.from_zero, scenario.dt());
        let away = |ego: &Ego| CropError::EgoAway {
            there: ego.track.steps(),
            kept: cut.steps(),
        };
        let driven = ego.map(|ego| cut.ego(ego).ok_or_else(|| away(ego)));
        let mut kept_ego = driven.transpose()?;
        let near = self.near(kept_ego.as_ref())?;
        let taken = kept_ego.as_ref().and_then(taken);
        let wanted = scenario.obstacles.iter().filter(|o| self.wants(o, taken));
        let inside = |o: &Obstacle| {
            Some(o.id) == taken || near.as_ref().is_none_or(|near| near.meets_obstacle(o))
        };
        let obstacles: Vec<Obstacle> = wanted
            .filter_map(|o| cut.obstacle(o))
            .filter(inside)
            .collect();
        let inner = near.as_ref().map(|near| near.network(&scenario.network));
        let network = cut.network(inner.unwrap_or_else(|| scenario.network.clone()));
        if let (Some(road), Some(around)) = (scenario.network.bounds(), self.around)
            && network.lanelets.is_empty()
        {
            return Err(CropError::NoRoad { around, road });
        }
        let own = scenario.recorded_ego.as_ref().and_then(|own| {
            Some(RecordedEgo {
                obstacle: cut.obstacle(&own.obstacle)?,
                file: own.file.clone(),
            })
        });
        if obstacles.is_empty() && kept_ego.is_none() && own.is_none() {
            return Err(CropError::Nothing);
        }
        let mut problems = Problems::new(&cut, near.as_ref(), kept_ego.as_ref(), &network);
        let kept_problems = problems.kept(&scenario.planning_problems);
        let last = cut.steps().end().saturating_add(1);
        let steps = all.start.max(*cut.steps().start())..all.end.min(last);
        let count = |steps: &Range<i64>| usize::try_from(steps.end - steps.start).unwrap_or(0);
        let lanelets = |road: &LaneletNetwork| road.lanelets.len();
        let mut said = vec![format!(
            "kept {}, {}, {}{}",
            part(count(&steps), count(&all), "step"),
            part(obstacles.len(), scenario.obstacles.len(), "obstacle"),
            part(lanelets(&network), lanelets(&scenario.network), "lanelet"),
            cut.renumbered().unwrap_or_default(),
        )];
        said.append(&mut problems.said);
        let kept = Scenario {
            network,
            obstacles,
            planning_problems: kept_problems,
            recorded_ego: own,
            hash: ContentHash::digest(format!("{} {self:?}", scenario.hash).as_bytes()),
            ..scenario.clone()
        };
        if let (Some(ego), Some(id)) = (&mut kept_ego, taken) {
            let obstacle = kept.obstacle(id).ok_or_else(|| away(ego))?;
            // The two are one vehicle, to the last digit.
            ego.track = obstacle.track().clone();
        }
        Ok(Cropped {
            scenario: Arc::new(kept),
            ego: kept_ego,
            said,
        })
    }

    /// The area; nothing where none is asked for.
    fn near(&self, ego: Option<&Ego>) -> Result<Option<Near>, CropError> {
        let Some(Around { centre, metres }) = self.around else {
            return Ok(None);
        };
        let way = match centre {
            Centre::At(point) => vec![point],
            Centre::Ego => {
                let motions = ego.into_iter().flat_map(|ego| ego.track.iter());
                motions.map(|(_, motion)| motion.pose.position).collect()
            }
        };
        Near::new(way, metres).map(Some).ok_or(CropError::NoEgo)
    }

    /// Refuses ids that are not there, the ego among those that go, and a single step.
    fn check(&self, scenario: &Scenario, ego: Option<&Ego>) -> Result<(), CropError> {
        let mut named = self.keep.iter().flatten().chain(&self.drop);
        let unknown = named.find(|id| scenario.obstacle(**id).is_none());
        if let Some(id) = unknown {
            return Err(scenario.no_such_obstacle(*id).into());
        }
        if let Some(id) = ego.and_then(taken).filter(|id| self.drop.contains(id)) {
            return Err(CropError::Ego(id));
        }
        match &self.steps {
            Some(steps) if steps.start() >= steps.end() => Err(CropError::OneStep(*steps.start())),
            _ => Ok(()),
        }
    }

    /// Whether an obstacle is among those that are wanted; the ego always is.
    fn wants(&self, obstacle: &Obstacle, taken: Option<i64>) -> bool {
        let id = obstacle.id;
        let kept = self.keep.as_ref().is_none_or(|keep| keep.contains(&id));
        Some(id) == taken || kept && !self.drop.contains(&id)
    }
}

fn part(kept: usize, of: usize, noun: &str) -> String {
    let plural = if of == 1 { "" } else { "s" };
    format!("{kept} of {of} {noun}{plural}")
}

/// The obstacle that an ego is.
fn taken(ego: &Ego) -> Option<i64> {
    match ego.source {
        EgoSource::Obstacle(id) => Some(id),
        _ => None,
    }
}

/// A text that names no area.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected ego or a point and metres: ego:60m or 12.5,-3:60m")]
pub struct AroundError;

impl FromStr for Around {
    type Err = AroundError;

    fn from_str(text: &str) -> Result<Self, AroundError> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        let (centre, metres) = text.rsplit_once(':').ok_or(AroundError)?;
        let centre = match centre.split_once(',') {
            None if centre == "ego" => Some(Centre::Ego),
            None => None,
            Some((x, y)) => number(x)
                .zip(number(y))
                .map(|(x, y)| Centre::At(Point::new(x, y))),
        };
        let metres = number(metres.strip_suffix('m').unwrap_or(metres)).filter(|m| *m > 0.0);
        let (centre, metres) = centre.zip(metres).ok_or(AroundError)?;
        Ok(Self { centre, metres })
    }
}

impl fmt::Display for Around {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.centre {
            Centre::Ego => write!(f, "ego:{}m", self.metres),
            Centre::At(point) => write!(f, "{},{}:{}m", point.x, point.y, self.metres),
        }
    }
}

impl serde::Serialize for Around {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
