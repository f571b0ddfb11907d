//! Oracles: the recorded future, measures that read it, the first contact, the built-in judge.

use serde_json::{Value, json};

use super::instruments::{AT, OBSTACLE, PARTICIPANT, T};
use super::pair::{READING, said};
use super::view::{Who, number, time};
use super::{Argument, ArgumentKind, Arguments, Field, Kind, Tool, ToolError, WindowView};
use crate::judge::{self, judge_under};
use crate::metrics::{Contact, Context, MEASURES, measure};
use crate::verdict::Task;

pub(super) const RECORDED_FUTURE: Tool = Tool {
    name: "recorded_future",
    about: "Recorded motion of the ego or of an obstacle after the end of the window.",
    kind: Kind::Oracle,
    arguments: &[
        PARTICIPANT,
        Argument {
            name: "horizon",
            kind: ArgumentKind::Number(0.0, 60.0),
            unit: "s",
            required: false,
            about: "How far after the window; 3 where it is left out.",
        },
    ],
    result: &[Field::list(
        "states",
        "At the recorded steps from the end of the window on, at most 600.",
        &[
            AT,
            Field::new("x", "number", "m", "Position on the map."),
            Field::new("y", "number", "m", "Position on the map."),
            Field::new(
                "heading",
                "number",
                "°",
                "Counter-clockwise from the x axis.",
            ),
            Field::new("speed", "number", "m/s", "Along the heading."),
        ],
    )],
    call: recorded_future,
};

/// Most states of one result.
const MOST: usize = 600;

fn recorded_future(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let (scene, _, window) = view.recording();
    let horizon = arguments.number("horizon").unwrap_or(3.0);
    let id = arguments.id("participant").unwrap_or(0);
    let track = match id {
        0 => &scene.ego.track,
        id => match scene.participants().find(|p| p.obstacle.id == id) {
            Some(found) => found.obstacle.track(),
            None => return Err(ToolError::new(format!("no obstacle {id} in the scenario"))),
        },
    };
    let until = window.last() + (horizon / scene.scenario.dt()).floor() as i64;
    let states = track.during(&(window.last()..=until)).iter().take(MOST);
    let states: Vec<Value> = states
        .map(|(step, motion)| {
            json!({
                "t": time(view.seconds(*step)),
                "x": number(motion.pose.position.x),
                "y": number(motion.pose.position.y),
                "heading": number(motion.pose.heading.to_degrees()),
                "speed": number(motion.velocity),
            })
        })
        .collect();
    Ok(json!({"states": states}))
}

pub(super) const MEASURE_RECORDED: Tool = Tool {
    name: "measure_recorded",
    about: "A measure that reads the recording after the moment it is asked at: closest encounter (dce, ttce), \
            encroachment (et, pet), times to brake, kick down, steer and react, thw, tet, tit, cpi.",
    kind: Kind::Oracle,
    arguments: &[
        Argument {
            name: "id",
            kind: ArgumentKind::Word(with_future),
            unit: "",
            required: true,
            about: "Id of the measure.",
        },
        OBSTACLE,
        T,
    ],
    result: READING,
    call: measure_recorded,
};

fn with_future() -> Vec<&'static str> {
    MEASURES
        .iter()
        .filter(|m| m.reads_ahead)
        .map(|m| m.id)
        .collect()
}

fn measure_recorded(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let (scene, thresholds, _) = view.recording();
    let step = view.step(arguments.number("t"))?;
    let id = arguments.word("id").unwrap_or_default();
    let measure = measure(id).filter(|m| m.reads_ahead);
    let measure = measure.ok_or_else(|| ToolError::new(format!("no measure `{id}`")))?;
    let Who::Other(place, _) = view.who(arguments.id("obstacle").unwrap_or(0))? else {
        return Err(ToolError::new(
            "a measure is of the ego and an obstacle; name one",
        ));
    };
    let context = Context::under(scene, thresholds);
    let reading = context
        .encounter(place, step)
        .map(|encounter| measure.of(&encounter));
    let reading = reading.ok_or_else(|| ToolError::new("the two are not there together"))?;
    Ok(said(view.seconds(step), measure, reading))
}

pub(super) const FIRST_CONTACT: Tool = Tool {
    name: "first_contact",
    about: "When the recorded bodies of the ego and of an obstacle first touch, at a step or between two.",
    kind: Kind::Oracle,
    arguments: &[],
    result: &[
        Field::new("contact", "boolean", "", "Whether there is one."),
        AT,
        Field::new(
            "obstacle",
            "integer",
            "",
            "The obstacle; missing without contact.",
        ),
        Field::new(
            "possible",
            "boolean",
            "",
            "Whether the obstacle is a region there that it may cover or not.",
        ),
    ],
    call: first_contact,
};

fn first_contact(view: &WindowView<'_>, _: &Arguments) -> Result<Value, ToolError> {
    let (scene, ..) = view.recording();
    let contacts = scene.participants();
    let contacts = contacts.filter_map(|other| Contact::first(scene, &other));
    let first = contacts.min_by(|a, b| a.time.total_cmp(&b.time));
    Ok(match first {
        Some(contact) => json!({
            "contact": true,
            "t": time(contact.time),
            "obstacle": contact.obstacle,
            "possible": contact.is_possible,
        }),
        None => json!({"contact": false}),
    })
}

pub(super) const JUDGE: Tool = Tool {
    name: "judge",
    about: "Verdict of the built-in judge: exact geometry of the recording (collision), or its prediction (safety).",
    kind: Kind::Oracle,
    arguments: &[Argument {
        name: "task",
        kind: ArgumentKind::Word(|| Task::VERDICTS.map(Task::name).to_vec()),
        unit: "",
        required: false,
        about: "The question; safety where it is left out.",
    }],
    result: &[
        Field::new(
            "judge",
            "string",
            "",
            "The judge, so that the verdict is not taken for a model's.",
        ),
        Field::new(
            "dangerous",
            "boolean",
            "",
            "Collision, safety-critical or of high risk, by the task.",
        ),
        Field::new("justification", "string", "", "Why."),
        Field::list(
            "obstacles",
            "Those that decide, worst first.",
            &[
                Field::new("id", "integer", "", "Its id."),
                Field::new("risk_score", "integer", "", "0 collision to 5 negligible."),
            ],
        ),
    ],
    call: judged,
};

fn judged(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let (scene, thresholds, window) = view.recording();
    let task = arguments
        .word("task")
        .and_then(Task::parse)
        .unwrap_or(Task::Safety);
    let verdict = judge_under(scene, task, &window, thresholds).verdict;
    let obstacles = verdict.obstacles.iter();
    let obstacles: Vec<Value> = obstacles
        .map(|o| json!({"id": o.id, "risk_score": o.risk_score}))
        .collect();
    Ok(json!({
        "judge": judge::MODEL,
        "dangerous": verdict.dangerous,
        "justification": verdict.justification,
        "obstacles": obstacles,
    }))
}
