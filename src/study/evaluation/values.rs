//! The template variables of a case, and of an attacker: every limit that the gate holds its motion against.

use nearmiss_ask::prompts;
use nearmiss_drive::generation::{Capability, SAME_PLACE, SAME_SPEED};
use nearmiss_scene::description::{Form, STANDS_FAR, VELOCITY_TOLERANCE, measure_column};
use nearmiss_scene::metrics::{Danger, Measure, RiskLevel, Thresholds, measures};
use nearmiss_scene::scenario::Transform;
use serde::Serialize;

use super::generating::unchanged_name;
use super::question::Case;

/// The values of a case.
#[derive(Debug, Serialize)]
pub(super) struct Values<'a> {
    task: &'static str,
    frame: &'static str,
    cp: bool,
    cot: bool,
    icl: bool,
    description: &'a str,
    /// `prose` or `compact`.
    form: &'static str,
    /// Along what the ego frame measures: `heading` or `lane`.
    axes: &'static str,
    /// Whether the Cartesian frame describes the road.
    road: bool,
    /// The chosen measures of the metrics frame; empty for its usual ones.
    measures: Vec<MeasureValues>,
    /// Whether the description says that bodies touch.
    contact: bool,
    /// Seconds after the window within which a contact is critical.
    horizon: f64,
    /// Seconds between two time steps.
    dt: f64,
    /// Seconds between two described steps.
    spacing: f64,
    radius: f64,
    /// Seconds within which obstacles beyond the radius can reach the ego that are described; none where none are.
    reach: Option<f64>,
    /// How far off velocities may be for that, m/s.
    give: f64,
    /// Metres beyond which what always stands is described once.
    far: f64,
    ego: i64,
    /// The obstacle that is described; none where all are.
    obstacle: Option<i64>,
    scenario: &'a str,
    window: WindowValues,
    risk_levels: &'a [RiskLevel],
    /// Critical values of measures.
    thresholds: Vec<ThresholdValues>,
    /// Those of the measures that the metrics frame describes.
    critical: Vec<ThresholdValues>,
    limits: LimitValues,
    /// What the obstacle that is described can do; none where all are described, or where it does not move by itself.
    attacker: Option<AttackerValues>,
    /// Reaction time of the ideal driver who has to avoid the attack, seconds.
    reaction: f64,
    /// The answer's form in readable JSON, and a line for each of its keys, both told from its schema.
    answer_form: String,
    answer_keys: String,
    /// The schema itself.
    answer_schema: String,
}

#[derive(Debug, Serialize)]
struct WindowValues {
    first: i64,
    last: i64,
    /// Steps in the window, described or not.
    steps: i64,
    /// Steps that are described.
    described: usize,
    seconds: f64,
    /// Seconds since time step 0 of the first described step and of the last, as the trajectory frame counts them.
    from: f64,
    until: f64,
}

/// A measure of the metrics frame, as its list in the prompt has it.
#[derive(Debug, Serialize)]
struct MeasureValues {
    id: &'static str,
    name: &'static str,
    unit: &'static str,
    /// What it is called in the description: the column of a table, the name in sentences.
    column: String,
    /// `low` or `high`; none where neither side is dangerous.
    dangerous: Option<&'static str>,
    source: &'static str,
}

impl MeasureValues {
    fn new(measure: &'static Measure, form: Form) -> Self {
        let column = match form {
            Form::Compact => measure_column(measure),
            Form::Prose => measure.name.to_string(),
        };
        Self {
            id: measure.id,
            name: measure.name,
            unit: measure.unit,
            column,
            dangerous: match measure.danger {
                Danger::Low => Some("low"),
                Danger::High => Some("high"),
                Danger::Neutral => None,
            },
            source: measure.source,
        }
    }
}

#[derive(Debug, Serialize)]
struct ThresholdValues {
    measure: &'static str,
    /// Whether values from it on are critical, not those up to it.
    from: bool,
    name: &'static str,
    value: f64,
    unit: &'static str,
    level: String,
    source: String,
}

impl<'a> Values<'a> {
    pub fn new(case: &'a Case, description: &'a str, schema: &serde_json::Value) -> Self {
        let (first, last) = (case.window.first(), case.window.last());
        let steps = last - first + 1;
        let described = case.options.steps(&case.window);
        let dt = case.scene.scenario.dt();
        let limits = &case.thresholds.limits;
        let attacker = AttackerValues::from_case(case);
        let chosen = case.options.measures;
        let told = chosen.map_or(USUAL_CRITICAL.to_vec(), |chosen| chosen.ids());
        let chosen = chosen.into_iter().flat_map(|chosen| chosen.iter());
        Self {
            task: case.task.name(),
            frame: case.frame.name(),
            cp: case.techniques.cp,
            cot: case.techniques.cot,
            icl: case.techniques.icl,
            description,
            form: case.options.form.name(),
            axes: case.options.axes.name(),
            road: case.options.road,
            measures: chosen
                .map(|measure| MeasureValues::new(measure, case.options.form))
                .collect(),
            contact: case.options.contact,
            horizon: plain(case.horizon),
            dt,
            spacing: plain(dt * case.options.spacing(&case.window) as f64),
            radius: case.options.radius,
            reach: case.options.reach.map(plain),
            give: VELOCITY_TOLERANCE,
            far: STANDS_FAR,
            ego: case.scene.ego.id,
            obstacle: case.options.obstacle,
            // That a scene was changed is for the store, not for a model.
            scenario: Transform::of_name(unchanged_name(&case.name)).0,
            window: WindowValues {
                first,
                last,
                steps,
                described: described.len(),
                seconds: plain(steps as f64 * dt),
                from: plain(
                    case.scene
                        .time_of(described.first().copied().unwrap_or(last)),
                ),
                until: plain(case.scene.time_of(last)),
            },
            risk_levels: &case.thresholds.risk.levels,
            thresholds: critical(&case.thresholds, None),
            critical: critical(&case.thresholds, Some(&told)),
            limits: match &attacker {
                Some(able) => able.limits(),
                None => LimitValues {
                    acceleration: limits.kick_down,
                    deceleration: limits.full_braking,
                    lateral: limits.evasion,
                    curvature: limits.tightest,
                },
            },
            attacker,
            reaction: plain(case.attack.delay),
            answer_form: prompts::answer_form(schema),
            answer_keys: prompts::answer_keys(schema),
            answer_schema: schema.to_string(),
        }
    }
}

/// The measures of the usual metrics frame whose critical values its prompt names.
const USUAL_CRITICAL: [&str; 3] = ["ttc", "time_gap", "drac"];

fn critical(thresholds: &Thresholds, of: Option<&[&str]>) -> Vec<ThresholdValues> {
    let wanted = |measure: &&Measure| {
        // Those of the user are told where they are asked for, so that prompts do not depend on them.
        of.map_or(measure.formula().is_none(), |ids| ids.contains(&measure.id))
    };
    let of = measures().filter(wanted).flat_map(|measure| {
        thresholds
            .for_measure(measure.id)
            .map(|threshold| ThresholdValues {
                measure: measure.id,
                from: measure.danger == Danger::High,
                name: measure.name,
                value: threshold.value,
                unit: measure.unit,
                level: threshold.name.clone(),
                source: threshold.source.clone(),
            })
    });
    of.collect()
}

/// Without the dust of binary fractions.
pub(super) fn plain(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Limits that templates of all tasks know, m/s² and 1/m.
#[derive(Debug, Serialize)]
pub(super) struct LimitValues {
    pub acceleration: f64,
    pub deceleration: f64,
    pub lateral: f64,
    pub curvature: f64,
}

/// What one road user can do in its style, as the gate of changed motions asks it.
#[derive(Debug, Serialize)]
pub(super) struct AttackerValues {
    /// Its type, such as `car`.
    kind: &'static str,
    /// The style: `human` or `limit`.
    style: &'static str,
    /// Speeding up, m/s².
    acceleration: f64,
    /// Above this speed (m/s) the engine allows less: `power` over the speed, m/s².
    switch_speed: f64,
    /// m²/s³.
    power: f64,
    /// Braking, m/s².
    braking: f64,
    /// Across the heading, m/s².
    lateral: f64,
    /// Acceleration along and across together, m/s².
    friction: f64,
    /// Change of the acceleration along the heading, m/s³.
    jerk: f64,
    /// Speed, m/s.
    speed: f64,
    /// Smallest radius of the rear axle's way, m, and the curvature that is, 1/m.
    radius: f64,
    curvature: f64,
    /// Largest steering angle, rad.
    steering: f64,
    /// Change of the steering angle, rad/s.
    steering_rate: f64,
    /// Between the axles, m.
    wheelbase: f64,
    /// From the rear axle to the centre of the body, m.
    rear_to_centre: f64,
    /// Whether it has to stay on the road.
    on_road: bool,
    /// Less than this differs from the recorded motion nowhere: m and m/s.
    least_distance: f64,
    least_speed: f64,
}

impl AttackerValues {
    /// Those of the obstacle that a case describes.
    pub fn from_case(case: &Case) -> Option<Self> {
        let obstacle = case.scene.scenario.obstacle(case.options.obstacle?)?;
        let able = Capability::for_obstacle(obstacle, case.attack.style)?;
        let limits = &able.limits;
        let friction = limits.acceleration;
        let curvature = limits.curvature();
        Some(Self {
            kind: obstacle.kind.name(),
            style: case.attack.style.name(),
            acceleration: short(able.speeding_up.min(friction)),
            switch_speed: short(limits.switch_speed),
            power: short(friction * limits.switch_speed),
            braking: short(friction),
            lateral: short(able.lateral.min(friction)),
            friction: short(friction),
            jerk: short(able.jerk),
            speed: short(limits.speed),
            radius: up(1.0 / curvature),
            curvature: short(curvature),
            steering: short(limits.steering),
            steering_rate: plain(limits.steering_rate),
            wheelbase: plain(limits.wheelbase),
            rear_to_centre: plain(limits.rear_to_centre),
            on_road: able.on_road,
            least_distance: SAME_PLACE,
            least_speed: SAME_SPEED,
        })
    }

    /// The limits that templates of all tasks know.
    pub fn limits(&self) -> LimitValues {
        LimitValues {
            acceleration: self.acceleration,
            deceleration: self.braking,
            lateral: self.lateral,
            curvature: self.curvature,
        }
    }
}

/// A limit with three decimals, rounded to the safe side: what keeps to the number keeps to the limit.
fn short(limit: f64) -> f64 {
    (limit * 1e3 + 1e-6).floor() / 1e3
}

fn up(limit: f64) -> f64 {
    (limit * 1e3 - 1e-6).ceil() / 1e3
}
