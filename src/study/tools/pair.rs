//! Two participants at one moment: distance, time to collision, any measure of the registry, motion as predicted.

use nearmiss_base::geometry::{Contact, Pose};
use nearmiss_scene::metrics::{HORIZON, MEASURES, Reading, measure};
use nearmiss_scene::scenario::Motion;
use serde_json::{Value, json};

use super::instruments::{AT, OBSTACLE, PARTICIPANT, T};
use super::view::{Who, number, time};
use super::{Argument, ArgumentKind, Arguments, Field, Tool, ToolError, WindowView};

/// The second one of a pair.
const OTHER: Argument = Argument {
    name: "other",
    kind: ArgumentKind::Participant,
    unit: "",
    required: false,
    about: "Id of a second obstacle, or 0 for the ego; the ego where it is left out.",
};

/// Why there is no value.
const NONE: Field = Field::new(
    "none",
    "string",
    "",
    "Why there is no value; missing where there is one.",
);

pub(super) const DISTANCE: Tool = Tool {
    name: "distance",
    about: "Exact shortest distance between two bodies at a moment; 0 when they touch.",
    arguments: &[OBSTACLE, OTHER, T],
    result: &[
        AT,
        Field::new(
            "distance",
            "number",
            "m",
            "Between the nearest points of the bodies.",
        ),
    ],
    call: distance,
};

/// Both, where they are at the moment that is asked about.
type Both<'s> = [(
    &'s nearmiss_scene::scenario::Motion,
    &'s nearmiss_base::geometry::Footprint,
); 2];

fn both<'s>(view: &WindowView<'s>, arguments: &Arguments) -> Result<(i64, Both<'s>), ToolError> {
    let step = view.step(arguments.number("t"))?;
    let ids = [arguments.id("obstacle"), arguments.id("other")].map(|id| id.unwrap_or(0));
    if ids[0] == ids[1] {
        return Err(ToolError::new("`obstacle` and `other` are the same"));
    }
    let first: Who<'s> = view.participant(ids[0])?;
    let second = view.participant(ids[1])?;
    Ok((step, [view.at(&first, step)?, view.at(&second, step)?]))
}

fn distance(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let (step, [(a, a_body), (b, b_body)]) = both(view, arguments)?;
    let apart = a_body.at(a.pose).distance(&b_body.at(b.pose));
    Ok(json!({"t": time(view.seconds(step)), "distance": number(apart)}))
}

pub(super) const TIME_TO_COLLISION: Tool = Tool {
    name: "time_to_collision",
    about: "Time until two bodies touch if both keep velocity and heading from a moment on; looked for within 10 s.",
    arguments: &[OBSTACLE, OTHER, T],
    result: &[
        AT,
        Field::new(
            "ttc",
            "number",
            "s",
            "Time to contact; 0 in contact; missing without a contact within 10 s.",
        ),
        NONE,
    ],
    call: time_to_collision,
};

fn time_to_collision(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let (step, [(a, a_body), (b, b_body)]) = both(view, arguments)?;
    let (place, other) = (a_body.at(a.pose), b_body.at(b.pose));
    let contact = place.contact(&a.velocity_vector(), &other, &b.velocity_vector(), HORIZON);
    let t = time(view.seconds(step));
    Ok(match contact {
        Contact::Now => json!({"t": t, "ttc": 0.0}),
        Contact::In(seconds) => json!({"t": t, "ttc": number(seconds)}),
        Contact::NotWithinHorizon => json!({"t": t, "none": "no contact within 10 s"}),
    })
}

/// The result of a measure.
const READING: &[Field] = &[
    AT,
    Field::new("name", "string", "", "Name of the measure."),
    Field::new(
        "value",
        "number",
        "",
        "Its value in `unit`; missing where there is none.",
    ),
    Field::new(
        "unit",
        "string",
        "",
        "Unit of the value; missing for scores and shares.",
    ),
    NONE,
];

pub(super) const MEASURE: Tool = Tool {
    name: "measure",
    about: "A safety measure of the ego and an obstacle at a moment, by its id: gaps (gap_long, gap_lat), times to \
            collision (ttc, ttc_long, ttc_lat, ttc_lane, wttc), time_gap, needed decelerations, RSS distances, risk \
            score (0 collision to 5 negligible). Measures along the lane look along the road ahead of the ego.",
    arguments: &[
        Argument {
            name: "id",
            kind: ArgumentKind::Word(without_future),
            unit: "",
            required: true,
            about: "Id of the measure.",
        },
        OBSTACLE,
        T,
    ],
    result: READING,
    call: measured,
};

/// The measures that read nothing after the step that they are asked at.
fn without_future() -> Vec<&'static str> {
    MEASURES
        .iter()
        .filter(|m| !m.reads_ahead)
        .map(|m| m.id)
        .collect()
}

fn measured(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let id = arguments.text("id").unwrap_or_default();
    let measure = measure(id)
        .filter(|m| !m.reads_ahead)
        .ok_or_else(|| ToolError::new(format!("no measure `{id}`")))?;
    let obstacle = arguments.id("obstacle").unwrap_or(0);
    let who = view.participant(obstacle)?;
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
    Ok(reading_result(view.seconds(step), measure, reading))
}

/// A reading as a result.
fn reading_result(
    seconds: f64,
    measure: &nearmiss_scene::metrics::Measure,
    reading: Reading,
) -> Value {
    let mut said = json!({"t": time(seconds), "name": measure.name});
    match reading {
        Reading::Value(value) => said["value"] = number(value),
        Reading::None(why) => said["none"] = why.reason().into(),
    }
    if !measure.unit.is_empty() {
        said["unit"] = measure.unit.into();
    }
    said
}

pub(super) const PREDICT: Tool = Tool {
    name: "predict_constant_velocity",
    about: "Where the ego or an obstacle would be if it kept velocity and heading from a moment on, and how far the \
            bodies of obstacle and ego would then be apart if the ego did so too. A prediction, not the recording.",
    arguments: &[
        PARTICIPANT,
        T,
        Argument {
            name: "horizon",
            kind: ArgumentKind::Number(0.1, 10.0),
            unit: "s",
            required: false,
            about: "How far it is predicted; 3 where it is left out.",
        },
        Argument {
            name: "interval",
            kind: ArgumentKind::Number(0.1, 10.0),
            unit: "s",
            required: false,
            about: "Between two positions; 0.5 where it is left out.",
        },
    ],
    result: &[
        AT,
        Field::list(
            "positions",
            "From the moment on.",
            &[
                Field::new("after", "number", "s", "Time after the moment."),
                Field::new("x", "number", "m", "Position on the map."),
                Field::new("y", "number", "m", "Position on the map."),
                Field::new(
                    "distance_to_ego",
                    "number",
                    "m",
                    "Between the bodies; missing for the ego.",
                ),
            ],
        ),
    ],
    call: predict,
};

/// Most positions of one result.
const MAX_POSITIONS: usize = 60;

fn predict(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let who = view.participant(arguments.id("participant").unwrap_or(0))?;
    let (motion, body) = view.at(&who, step)?;
    let horizon = arguments.number("horizon").unwrap_or(3.0);
    let interval = arguments.number("interval").unwrap_or(0.5);
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
        let mut said = json!({
            "after": number(after),
            "x": number(there.position.x),
            "y": number(there.position.y),
        });
        if let Some((ego, ego_body)) = ego {
            let apart = body.at(there).distance(&ego_body.at(moved(ego, after)));
            said["distance_to_ego"] = number(apart);
        }
        said
    };
    let positions: Vec<Value> = (0..=count).map(position).collect();
    Ok(json!({"t": time(view.seconds(step)), "positions": positions}))
}

/// The pose after so many seconds of constant velocity.
fn moved(motion: &Motion, seconds: f64) -> Pose {
    Pose {
        position: motion.pose.position + motion.velocity_vector() * seconds,
        heading: motion.pose.heading,
    }
}
