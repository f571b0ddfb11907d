//! Reads a planner's answers: the message in a line, its trajectory as states of the vehicle, or what is wrong and where.

use nearmiss_base::geometry::{Pose, Vector, angle_between, normalize_angle};
use nearmiss_scene::scenario::Motion;
use serde_json::Value;

use super::protocol::{
    Answer, OLDEST_PROTOCOL, PROTOCOL, PlannedState, Ready, ReferencePoint, Trajectory,
};
use super::{Fault, PlannerFault};
use crate::planner::{Limits, MOST_STEPS, VehicleState};

/// Longest text of a planner that is shown, characters.
const MAX_TEXT: usize = 300;

/// The answer in a line.
pub(super) fn answer(line: &str) -> Result<Answer, Fault> {
    let error = match serde_json::from_str(line) {
        Ok(answer) => return Ok(answer),
        Err(error) => error,
    };
    // What is no number of JSON stands there as text then, and can be named with its place.
    let object = serde_json::from_str::<Value>(&with_quoted_infinities(line))
        .ok()
        .filter(Value::is_object);
    let Some(object) = object else {
        let details = if line.trim_start().starts_with('{') {
            format!("no JSON: {error}: {}", shown(line))
        } else {
            format!("{error}: {}; logs belong on standard error", shown(line))
        };
        return Err(Fault::new(PlannerFault::Nonsense, details));
    };
    Err(match wrong_value(&object) {
        Some(wrong) if wrong.not_finite => Fault::new(PlannerFault::NotFinite, wrong.words),
        Some(wrong) => Fault::new(PlannerFault::Nonsense, wrong.words),
        None => Fault::new(PlannerFault::Nonsense, format!("{error}: {}", shown(line))),
    })
}

/// The answer to `hello`.
pub(super) fn ready(line: &str) -> Result<Ready, Fault> {
    // Another version may have another form: its number is looked at first.
    let said: Option<u64> = serde_json::from_str::<serde_json::Value>(line)
        .ok()
        .and_then(|value| value.get("protocol")?.as_u64());
    let spoken = u64::from(OLDEST_PROTOCOL)..=u64::from(PROTOCOL);
    if let Some(version) = said.filter(|version| !spoken.contains(version)) {
        let ours = if OLDEST_PROTOCOL == PROTOCOL {
            PROTOCOL.to_string()
        } else {
            format!("{OLDEST_PROTOCOL} to {PROTOCOL}")
        };
        let details = format!("version {version}; nearmiss speaks {ours}");
        return Err(Fault::new(PlannerFault::WrongVersion, details));
    }
    match answer(line)? {
        Answer::Ready(ready) => Ok(ready),
        Answer::Error(refusal) => Err(Fault::new(PlannerFault::Refused, shown(&refusal.message))),
        Answer::Trajectory(_) => {
            let details = "`trajectory` in answer to `hello`";
            Err(Fault::new(PlannerFault::Nonsense, details))
        }
    }
}

/// Text of a planner as it may be shown: without control characters, and not long.
pub(super) fn shown(text: &str) -> String {
    let mut chars = text
        .trim()
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c });
    let mut words: String = chars.by_ref().take(MAX_TEXT).collect();
    if chars.next().is_some() {
        words.push('…');
    }
    words
}

/// What a field holds.
#[derive(Clone, Copy)]
enum Holds {
    Number,
    Whole,
    Text,
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
}

/// A field of a message: its name, what it holds, and whether it has to be there.
type Field = (&'static str, Holds, bool);

const READY: [Field; 8] = [
    ("protocol", Holds::Whole, true),
    ("name", Holds::Text, true),
    ("version", Holds::Text, false),
    (
        "reference_point",
        Holds::Word(&["rear_axle", "centre"]),
        false,
    ),
    ("predictions", Holds::Flag, false),
    ("history", Holds::Whole, false),
    ("reusable", Holds::Flag, false),
    ("stateless", Holds::Flag, false),
];

const TRAJECTORY: [Field; 1] = [("step", Holds::Whole, true)];

const ERROR: [Field; 2] = [
    ("message", Holds::Text, true),
    ("infeasible", Holds::Flag, false),
];

const STATE: [Field; 4] = [
    ("x", Holds::Number, true),
    ("y", Holds::Number, true),
    ("heading", Holds::Number, true),
    ("velocity", Holds::Number, true),
];

/// These may also be null.
const OF_STATES: [&str; 3] = ["t", "acceleration", "steering"];

/// The messages that a planner writes.
const TYPES: [&str; 3] = ["ready", "trajectory", "error"];

/// A value that is none of its field.
struct Wrong {
    /// Where it is, what it is, and what it should be.
    words: String,
    /// It is NaN or infinite.
    not_finite: bool,
}

/// The first value of a message that is wrong, with its path.
fn wrong_value(message: &Value) -> Option<Wrong> {
    let kind = ("type", Holds::Word(&TYPES), true);
    if let Some(wrong) = of_fields(message, "", &[kind]) {
        return Some(wrong);
    }
    match message["type"].as_str()? {
        "ready" => of_fields(message, "", &READY),
        "error" => of_fields(message, "", &ERROR),
        _ => of_trajectory(message),
    }
}

fn of_trajectory(message: &Value) -> Option<Wrong> {
    let of_message = of_fields(message, "", &TRAJECTORY);
    of_message
        .or_else(|| optional(message, "", "ms"))
        .or_else(|| {
            let Some(states) = message["states"].as_array() else {
                return Some(wrong("states", message.get("states"), "an array"));
            };
            states.iter().enumerate().find_map(|(place, state)| {
                let path = format!("states[{place}]");
                if !state.is_object() {
                    return Some(wrong(&path, Some(state), "an object"));
                }
                let path = format!("{path}.");
                let mut more = OF_STATES.iter();
                of_fields(state, &path, &STATE)
                    .or_else(|| more.find_map(|name| optional(state, &path, name)))
            })
        })
}

/// A number that may be left out or null.
fn optional(object: &Value, path: &str, name: &'static str) -> Option<Wrong> {
    let there = !object.get(name)?.is_null();
    there
        .then(|| of_fields(object, path, &[(name, Holds::Number, false)]))
        .flatten()
}

fn of_fields(object: &Value, path: &str, fields: &[Field]) -> Option<Wrong> {
    fields.iter().find_map(|(name, holds, needed)| {
        let value = object.get(name);
        let right = match (value, holds) {
            (None, _) => !needed,
            (Some(value), Holds::Number) => value.is_number(),
            (Some(value), Holds::Whole) => value.is_i64() || value.is_u64(),
            (Some(value), Holds::Text) => value.is_string(),
            (Some(value), Holds::Flag) => value.is_boolean(),
            (Some(value), Holds::Word(words)) => {
                value.as_str().is_some_and(|said| words.contains(&said))
            }
        };
        let expected = match holds {
            Holds::Number => "a number".into(),
            Holds::Whole => "a whole number".into(),
            Holds::Text => "text".into(),
            Holds::Flag => "true or false".into(),
            Holds::Word(words) => words.join(" or "),
        };
        (!right).then(|| wrong(&format!("{path}{name}"), value, &expected))
    })
}

fn wrong(path: &str, value: Option<&Value>, expected: &str) -> Wrong {
    let Some(value) = value else {
        return Wrong {
            words: format!("`{path}` is missing"),
            not_finite: false,
        };
    };
    let bare = value.as_str().filter(|text| is_infinite(text));
    match bare {
        Some(text) => Wrong {
            words: format!("`{path}` is {text}"),
            not_finite: true,
        },
        None => Wrong {
            words: format!("`{path}` is {}, expected {expected}", excerpt(value)),
            not_finite: false,
        },
    }
}

/// A value as it may be shown beside its path.
fn excerpt(value: &Value) -> String {
    let text = shown(&value.to_string());
    if text.chars().count() > MAX_EXCERPT {
        text.chars().take(MAX_EXCERPT).chain(['…']).collect()
    } else {
        text
    }
}

/// Characters of a wrong value that are shown.
const MAX_EXCERPT: usize = 40;

/// Whether a word is read as a number that is not finite: NaN, Infinity, or one that is too large.
fn is_infinite(word: &str) -> bool {
    word.parse::<f64>().is_ok_and(|number| !number.is_finite())
}

/// A line of JSON in which NaN, Infinity and numbers that are too large, which JSON has not, are texts.
fn with_quoted_infinities(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    let (mut word, mut inside, mut escaped) = (String::new(), false, false);
    let end = |word: &mut String, out: &mut String| {
        if is_infinite(word) {
            *out += &format!("\"{word}\"")
        } else {
            *out += word
        }
        word.clear();
    };
    for c in line.chars() {
        if !inside && (c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.')) {
            word.push(c);
            continue;
        }
        end(&mut word, &mut out);
        out.push(c);
        match c {
            _ if escaped => escaped = false,
            '\\' if inside => escaped = true,
            '"' => inside = !inside,
            _ => {}
        }
    }
    end(&mut word, &mut out);
    out
}

/// A trajectory may begin this far from the ego, metres.
const POSITION_TOLERANCE: f64 = 0.1;

/// The same for the heading, radians.
const HEADING: f64 = 0.05;

/// The same for the speed, m/s.
const SPEED: f64 = 0.2;

/// Below this way (m) in a step the heading tells nothing about the steering.
const MIN_MOVE: f64 = 0.01;

/// Times are multiples of the time step within this share of it.
const ROUNDING: f64 = 1e-6;

/// How a trajectory is read.
pub(super) struct Reader<'a> {
    pub limits: &'a Limits,
    pub dt: f64,
    pub point: ReferencePoint,
}

impl Reader<'_> {
    /// The states of a trajectory, one a step from `now` on, which is exactly the first of them.
    ///
    /// # Errors
    /// It is empty, has numbers that are not finite or times that do not increase, or does not begin at `now`.
    pub fn states(
        &self,
        trajectory: &Trajectory,
        now: &VehicleState,
    ) -> Result<Vec<VehicleState>, Fault> {
        let planned = &trajectory.states;
        if planned.is_empty() {
            return Err(Fault::new(PlannerFault::Empty, ""));
        }
        let times = self.times(planned)?;
        for (place, state) in planned.iter().enumerate() {
            if let Some((field, value)) = not_finite(state) {
                let details = format!("`states[{place}].{field}` is {value}");
                return Err(Fault::new(PlannerFault::NotFinite, details));
            }
        }
        let poses: Vec<Pose> = planned.iter().map(|state| self.rear(state)).collect();
        self.begins(&poses[0], &planned[0], now)?;
        let resampled = self.at_steps(planned, &times, &poses);
        let mut states = self.complete(&resampled, now);
        states[0] = *now;
        Ok(states)
    }

    /// Seconds of each state from now.
    fn times(&self, planned: &[PlannedState]) -> Result<Vec<f64>, Fault> {
        let times = planned.iter().enumerate();
        let times: Vec<f64> = times
            .map(|(place, state)| state.t.unwrap_or(place as f64 * self.dt))
            .collect();
        if let Some(place) = times.iter().position(|t| !t.is_finite()) {
            let details = format!("`states[{place}].t` is {}", times[place]);
            return Err(Fault::new(PlannerFault::NotFinite, details));
        }
        if times[0].abs() > self.dt * ROUNDING {
            let details = format!("the first state is at {} s, not 0", times[0]);
            return Err(Fault::new(PlannerFault::WrongTimes, details));
        }
        match times.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => Ok(times),
            Some(place) => {
                let (before, after) = (times[place], times[place + 1]);
                let details = format!("`states[{}].t`: {after} s after {before} s", place + 1);
                Err(Fault::new(PlannerFault::WrongTimes, details))
            }
        }
    }

    fn rear(&self, state: &PlannedState) -> Pose {
        let pose = Pose::new(state.x, state.y, normalize_angle(state.heading));
        match self.point {
            ReferencePoint::RearAxle => pose,
            ReferencePoint::Centre => {
                let motion = Motion {
                    pose,
                    velocity: 0.0,
                    acceleration: 0.0,
                };
                VehicleState::of_centre(&motion, 0.0, self.limits).rear
            }
        }
    }

    fn begins(&self, rear: &Pose, first: &PlannedState, now: &VehicleState) -> Result<(), Fault> {
        let off = (rear.position - now.rear.position).norm();
        let turned = angle_between(now.rear.heading, rear.heading).abs();
        let faster = (first.velocity - now.velocity).abs();
        let wrong = match () {
            () if off > POSITION_TOLERANCE => {
                Some(format!("{off:.2} m away, at most {POSITION_TOLERANCE} m"))
            }
            () if turned > HEADING => Some(format!("turned {turned:.3} rad, at most {HEADING}")),
            () if faster > SPEED => Some(format!(
                "{faster:.2} m/s another speed, at most {SPEED} m/s"
            )),
            () => None,
        };
        wrong.map_or(Ok(()), |details| {
            Err(Fault::new(PlannerFault::WrongStart, details))
        })
    }

    /// The states at the time steps: between two given ones on a straight line.
    fn at_steps(&self, planned: &[PlannedState], times: &[f64], poses: &[Pose]) -> Vec<Sampled> {
        let last = times.last().copied().unwrap_or(0.0);
        let steps = ((last / self.dt + ROUNDING).floor() as usize).min(MOST_STEPS);
        let mut place = 0;
        let at = (0..=steps).map(|step| {
            let t = step as f64 * self.dt;
            while place + 2 < times.len() && times[place + 1] <= t {
                place += 1;
            }
            let next = (place + 1).min(times.len() - 1);
            let span = times[next] - times[place];
            let share = if span > 0.0 {
                ((t - times[place]) / span).clamp(0.0, 1.0)
            } else {
                0.0
            };
            Sampled::between(
                (&planned[place], &poses[place]),
                (&planned[next], &poses[next]),
                share,
            )
        });
        at.collect()
    }

    /// With the accelerations and curvatures that were not said.
    fn complete(&self, sampled: &[Sampled], now: &VehicleState) -> Vec<VehicleState> {
        let mut curvature = now.curvature;
        let count = sampled.len();
        let states = (0..count).map(|place| {
            let (here, next) = (&sampled[place], sampled.get(place + 1));
            let before = place.checked_sub(1).map(|before| &sampled[before]);
            let acceleration = here.acceleration.unwrap_or_else(|| match (next, before) {
                (Some(next), _) => (next.velocity - here.velocity) / self.dt,
                (None, Some(before)) => (here.velocity - before.velocity) / self.dt,
                (None, None) => now.acceleration,
            });
            curvature = match here.steering {
                Some(angle) => angle.tan() / self.limits.wheelbase,
                None => turn(before.unwrap_or(here), next.unwrap_or(here)).unwrap_or(curvature),
            };
            VehicleState {
                rear: here.rear,
                velocity: here.velocity,
                acceleration,
                curvature,
            }
        });
        states.collect()
    }
}

/// A state at a time step.
struct Sampled {
    rear: Pose,
    velocity: f64,
    acceleration: Option<f64>,
    steering: Option<f64>,
}

impl Sampled {
    fn between(a: (&PlannedState, &Pose), b: (&PlannedState, &Pose), share: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * share;
        let both = |from: Option<f64>, to: Option<f64>| Some(mix(from?, to?));
        let turned = angle_between(a.1.heading, b.1.heading) * share;
        Self {
            rear: Pose {
                position: a.1.position + (b.1.position - a.1.position) * share,
                heading: normalize_angle(a.1.heading + turned),
            },
            velocity: mix(a.0.velocity, b.0.velocity),
            acceleration: both(a.0.acceleration, b.0.acceleration),
            steering: both(a.0.steering, b.0.steering),
        }
    }
}

/// The curvature of the way between two states, 1/m; nothing where it is too short to tell.
fn turn(from: &Sampled, to: &Sampled) -> Option<f64> {
    let way = (to.rear.position - from.rear.position).norm();
    (way > MIN_MOVE).then(|| angle_between(from.rear.heading, to.rear.heading) / way)
}

/// The first field of a state that is not finite, and its value.
fn not_finite(state: &PlannedState) -> Option<(&'static str, f64)> {
    let numbers = [
        ("x", Some(state.x)),
        ("y", Some(state.y)),
        ("heading", Some(state.heading)),
        ("velocity", Some(state.velocity)),
        ("acceleration", state.acceleration),
        ("steering", state.steering),
    ];
    let mut said = { numbers.into_iter() }.filter_map(|(name, value)| Some((name, value?)));
    // Larger than this, sums of squares are not finite either.
    said.find(|(_, number)| !number.is_finite() || number.abs() >= 1e12)
}

/// A trajectory that counts from its state `late` on, after the vehicle went on from `actual`: what is between them
/// goes to nothing within `within` seconds. Also the distance between them, metres.
pub(super) fn joined(
    planned: &[VehicleState],
    actual: &[VehicleState],
    late: usize,
    dt: f64,
    within: f64,
) -> (Vec<VehicleState>, f64) {
    let mut states: Vec<VehicleState> = actual.to_vec();
    let (Some(meant), Some(here)) = (planned.get(late), actual.get(late)) else {
        return (states, 0.0);
    };
    let off: Vector = here.rear.position - meant.rear.position;
    let turned = angle_between(meant.rear.heading, here.rear.heading);
    let faster = here.velocity - meant.velocity;
    for (place, state) in planned.iter().enumerate().skip(late + 1) {
        let gone = (place - late) as f64 * dt / within;
        let left = (1.0 - gone).max(0.0);
        states.push(VehicleState {
            rear: Pose {
                position: state.rear.position + off * left,
                heading: normalize_angle(state.rear.heading + turned * left),
            },
            velocity: state.velocity + faster * left,
            ..*state
        });
    }
    (states, off.norm())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_wrong_value_is_named_with_its_path() {
        let state = r#"{"x":1,"y":2,"heading":0,"velocity":3}"#;
        for (states, fault, words) in [
            (
                r#"{"x":null,"y":2,"heading":0,"velocity":3}"#,
                PlannerFault::Nonsense,
                "`states[1].x` is null, expected a number",
            ),
            (
                r#"{"x":1,"y":NaN,"heading":0,"velocity":3}"#,
                PlannerFault::NotFinite,
                "`states[1].y` is NaN",
            ),
            (
                r#"{"x":1,"y":2,"heading":-Infinity,"velocity":3}"#,
                PlannerFault::NotFinite,
                "`states[1].heading` is -Infinity",
            ),
            (
                r#"{"x":1,"y":2,"heading":0,"velocity":1e999}"#,
                PlannerFault::NotFinite,
                "`states[1].velocity` is 1e999",
            ),
            (
                r#"{"x":1,"y":2,"heading":0,"velocity":3,"t":"soon"}"#,
                PlannerFault::Nonsense,
                r#"`states[1].t` is "soon", expected a number"#,
            ),
            (
                r#"{"x":1,"y":2,"heading":0}"#,
                PlannerFault::Nonsense,
                "`states[1].velocity` is missing",
            ),
            (
                "7",
                PlannerFault::Nonsense,
                "`states[1]` is 7, expected an object",
            ),
        ] {
            let line = format!(r#"{{"type":"trajectory","step":0,"states":[{state},{states}]}}"#);
            let found = answer(&line).unwrap_err();
            assert_eq!(
                (found.fault, found.details.as_str()),
                (fault, words),
                "{line}"
            );
        }
        for (line, words) in [
            (r#"{"type":"trajectory","states":[]}"#, "`step` is missing"),
            (
                r#"{"type":"trajectory","step":1.5,"states":[]}"#,
                "`step` is 1.5, expected a whole number",
            ),
            (
                r#"{"type":"trajectory","step":1,"states":{}}"#,
                "`states` is {}, expected an array",
            ),
            (
                r#"{"type":"go"}"#,
                r#"`type` is "go", expected ready or trajectory or error"#,
            ),
            (r#"{"step":1}"#, "`type` is missing"),
            (r#"{"type":"error"}"#, "`message` is missing"),
        ] {
            let found = answer(line).unwrap_err();
            assert_eq!(
                (found.fault, found.details.as_str()),
                (PlannerFault::Nonsense, words)
            );
        }
        let log = answer("planning NaN ...").unwrap_err();
        assert!(
            log.details.contains("logs belong on standard error"),
            "{log:?}"
        );
        // A name is no number.
        let ready = r#"{"type":"ready","protocol":1,"name":"nan \" inf","version":"NaN"}"#;
        assert!(answer(ready).is_ok());
    }
}
