//! Two participants at one moment: distance, time to collision, any measure of the registry, motion as predicted.

use nearmiss_base::geometry::{Contact, Footprint, Pose};
use nearmiss_record::fields::{FieldValue, Takes, Wrong};
use nearmiss_scene::metrics::{HORIZON, MEASURES, Reading, measure};
use nearmiss_scene::scenario::Motion;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};
use toml::Value as Toml;

use super::arguments::{ObstacleId, ParticipantId};
use super::instruments::at_a_moment;
use super::view::{Who, number, time};
use super::{Tool, ToolError, WindowView, answer, tool};

at_a_moment! {
    Pair {
        /// Id of the obstacle.
        obstacle [required]: ObstacleId;
        /// Id of a second obstacle, or 0 for the ego; the ego where it is left out.
        other: ParticipantId;
    }
}

#[derive(Serialize, JsonSchema)]
struct Apart {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// Between the nearest points of the bodies.
    #[schemars(extend("unit" = "m"))]
    distance: f64,
}

pub(super) const DISTANCE: Tool = tool::<Pair, Apart>(
    "distance",
    "Exact shortest distance between two bodies at a moment; 0 when they touch.",
    |view, text| answer(view, text, distance),
);

/// Both, where they are at the moment that is asked about.
type Both<'s> = [(&'s Motion, &'s Footprint); 2];

fn both<'s>(view: &WindowView<'s>, arguments: &Pair) -> Result<(i64, Both<'s>), ToolError> {
    let step = view.step(arguments.t)?;
    let (first, second) = (arguments.obstacle.0, arguments.other.0);
    if first == second {
        return Err(ToolError::new("`obstacle` and `other` are the same"));
    }
    let first: Who<'s> = view.participant(first)?;
    let second = view.participant(second)?;
    Ok((step, [view.at(&first, step)?, view.at(&second, step)?]))
}

fn distance(view: &WindowView<'_>, arguments: &Pair) -> Result<Apart, ToolError> {
    let (step, [(a, a_body), (b, b_body)]) = both(view, arguments)?;
    let apart = a_body.at(a.pose).distance(&b_body.at(b.pose));
    Ok(Apart {
        t: time(view.seconds(step)),
        distance: number(apart),
    })
}

#[derive(Serialize, JsonSchema)]
struct ToContact {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// Time to contact; 0 in contact; missing without a contact within 10 s.
    #[schemars(extend("unit" = "s"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    ttc: Option<f64>,
    /// Why there is no value; missing where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    none: Option<&'static str>,
}

pub(super) const TIME_TO_COLLISION: Tool = tool::<Pair, ToContact>(
    "time_to_collision",
    "Time until two bodies touch if both keep velocity and heading from a moment on; looked for within 10 s.",
    |view, text| answer(view, text, time_to_collision),
);

fn time_to_collision(view: &WindowView<'_>, arguments: &Pair) -> Result<ToContact, ToolError> {
    let (step, [(a, a_body), (b, b_body)]) = both(view, arguments)?;
    let (place, other) = (a_body.at(a.pose), b_body.at(b.pose));
    let ttc = match place.contact(&a.velocity_vector(), &other, &b.velocity_vector(), HORIZON) {
        Contact::Now => Some(0.0),
        Contact::In(seconds) => Some(number(seconds)),
        Contact::NotWithinHorizon => None,
    };
    Ok(ToContact {
        t: time(view.seconds(step)),
        ttc,
        none: ttc.is_none().then_some("no contact within 10 s"),
    })
}

/// The id of a measure that reads nothing after the step that it is asked at.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasureId(&'static str);

impl MeasureId {
    /// Those of the user are not offered: tools are the same for everyone.
    fn known() -> impl Iterator<Item = &'static str> {
        MEASURES.iter().filter(|m| !m.reads_ahead).map(|m| m.id)
    }
}

impl FieldValue for MeasureId {
    fn read(value: &Toml, _: &Takes) -> Result<Self, Wrong> {
        let found = Self::known().find(|id| value.as_str() == Some(id));
        found.map(Self).ok_or(Wrong::kind())
    }

    fn write(&self) -> Option<Toml> {
        Some(self.0.into())
    }

    fn describe(_: &Takes) -> (String, Value) {
        let known: Vec<_> = Self::known().collect();
        let expected = format!("one of {}", known.join(", "));
        (expected, json!({ "type": "string", "enum": known }))
    }
}

at_a_moment! {
    OfMeasure {
        /// Id of the measure.
        id [required]: MeasureId;
        /// Id of the obstacle.
        obstacle [required]: ObstacleId;
    }
}

#[derive(Serialize, JsonSchema)]
struct Measured {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// Name of the measure.
    name: &'static str,
    /// Its value in `unit`; missing where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    /// Why there is no value; missing where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    none: Option<&'static str>,
    /// Unit of the value; missing for scores and shares.
    #[serde(skip_serializing_if = "str::is_empty")]
    unit: &'static str,
}

pub(super) const MEASURE: Tool = tool::<OfMeasure, Measured>(
    "measure",
    "A safety measure of the ego and an obstacle at a moment, by its id: gaps (gap_long, gap_lat), times to collision \
     (ttc, ttc_long, ttc_lat, ttc_lane, wttc), time_gap, needed decelerations, RSS distances, risk score (0 collision to 5 \
     negligible). Measures along the lane look along the road ahead of the ego.",
    |view, text| answer(view, text, measured),
);

fn measured(view: &WindowView<'_>, arguments: &OfMeasure) -> Result<Measured, ToolError> {
    let step = view.step(arguments.t)?;
    let MeasureId(id) = arguments.id;
    let measure = measure(id).ok_or_else(|| ToolError::new(format!("no measure `{id}`")))?;
    let who = view.participant(arguments.obstacle.0)?;
    let Who::Other(place, _) = who else {
        return Err(ToolError::new(
            "a measure is of the ego and an obstacle; name one",
        ));
    };
    for one in [Who::Ego, who] {
        view.at(&one, step)?;
        if !view.knows_acceleration(&one, step) {
            return Err(ToolError::new(format!(
                "the acceleration of {}, which measures may use, is not known yet: its record begins without one at the end \
                 of the described window; distance and time_to_collision need none",
                one.name()
            )));
        }
    }
    let reading = view
        .context()
        .encounter(place, step)
        .map(|encounter| measure.evaluate(&encounter))
        .ok_or_else(|| ToolError::new("the two are not there together"))?;
    let (value, none) = match reading {
        Reading::Value(value) => (Some(number(value)), None),
        Reading::None(why) => (None, Some(why.reason())),
    };
    Ok(Measured {
        t: time(view.seconds(step)),
        name: measure.name,
        value,
        none,
        unit: measure.unit,
    })
}

at_a_moment! {
    Predict {
        /// Id of the obstacle, or 0 for the ego.
        participant [required]: ParticipantId;
    }
    /// How far it is predicted; 3 where it is left out.
    horizon: f64 = 3.0, Takes::Number(0.1, 10.0), "s";
    /// Between two positions; 0.5 where it is left out.
    interval: f64 = 0.5, Takes::Number(0.1, 10.0), "s";
}

#[derive(Serialize, JsonSchema)]
struct Predicted {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// From the moment on.
    positions: Vec<Position>,
}

#[derive(Serialize, JsonSchema)]
struct Position {
    /// Time after the moment.
    #[schemars(extend("unit" = "s"))]
    after: f64,
    /// Position on the map.
    #[schemars(extend("unit" = "m"))]
    x: f64,
    /// Position on the map.
    #[schemars(extend("unit" = "m"))]
    y: f64,
    /// Between the bodies; missing for the ego.
    #[schemars(extend("unit" = "m"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    distance_to_ego: Option<f64>,
}

pub(super) const PREDICT: Tool = tool::<Predict, Predicted>(
    "predict_constant_velocity",
    "Where the ego or an obstacle would be if it kept velocity and heading from a moment on, and how far the bodies of \
     obstacle and ego would then be apart if the ego did so too. A prediction, not the recording.",
    |view, text| answer(view, text, predict),
);

/// Most positions of one result.
const MAX_POSITIONS: usize = 60;

fn predict(view: &WindowView<'_>, arguments: &Predict) -> Result<Predicted, ToolError> {
    let step = view.step(arguments.t)?;
    let who = view.participant(arguments.participant.0)?;
    let (motion, body) = view.at(&who, step)?;
    let (horizon, interval) = (arguments.horizon, arguments.interval);
    let ego = match who {
        Who::Ego => None,
        Who::Other(..) => view.at(&Who::Ego, step).ok(),
    };
    // Half a microsecond covers the dust of binary fractions.
    let count = ((horizon + 5e-7) / interval).floor() as usize;
    if count > MAX_POSITIONS {
        return Err(ToolError::new(format!(
            "at most {MAX_POSITIONS} positions at once; choose a larger interval"
        )));
    }
    let position = |i: usize| {
        let after = i as f64 * interval;
        let there = moved(motion, after);
        let apart = |(ego, ego_body): (&Motion, &Footprint)| {
            body.at(there).distance(&ego_body.at(moved(ego, after)))
        };
        Position {
            after: number(after),
            x: number(there.position.x),
            y: number(there.position.y),
            distance_to_ego: ego.map(apart).map(number),
        }
    };
    Ok(Predicted {
        t: time(view.seconds(step)),
        positions: (0..=count).map(position).collect(),
    })
}

/// The pose after so many seconds of constant velocity.
fn moved(motion: &Motion, seconds: f64) -> Pose {
    Pose {
        position: motion.pose.position + motion.velocity_vector() * seconds,
        heading: motion.pose.heading,
    }
}
