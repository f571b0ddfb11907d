//! The built-in reference judge: exact geometry instead of a language model, without a network.

mod collision;
mod safety;

pub use collision::{CollisionPrediction, Criterion, judge as judge_collision};
pub use safety::verdict_by;

use std::collections::BTreeMap;

use super::metrics::{
    Contact, Encounter, RISK_LEVELS, Reading, RiskConvention, ScoreAt, Thresholds, measure,
};
use super::scenario::{Participant, Scene, Window};
use super::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};

/// The model id under which the judge's answers are shown and stored.
pub const MODEL: &str = "reference/geometry";

/// Its name for people.
pub const NAME: &str = "built-in judge";

/// How an answer of this model came about, where no prompt had a part in it.
#[must_use]
pub fn how(model: &str) -> Option<&'static str> {
    (model == MODEL).then_some("exact geometry")
}

/// What an answer of this model looks at, where that is not the window of the question: the collision and the recording
/// task are judged from all recorded steps.
#[must_use]
pub fn looks_at(model: &str, task: Task) -> Option<&'static str> {
    (model == MODEL && task.is_about_all_steps()).then_some("all recorded steps")
}

/// The judge's verdict, and its reasoning.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// The way to it, with steps and numbers, as Markdown.
    pub reasoning: String,
    /// The step that decided: first contact, first step of the lowest score, or the present of a prediction.
    pub decisive_step: Option<i64>,
    /// What was predicted about the obstacles of the verdict, in its order; nothing for tasks about all steps.
    pub prospects: Vec<CollisionPrediction>,
}

/// Judges a scene, with the shipped thresholds; see [`judge_under`].
///
/// ```
/// use nearmiss_formats::bundled;
/// use nearmiss_scene::judge::judge;
/// use nearmiss_scene::scenario::{Scene, Window};
/// use nearmiss_scene::verdict::Task;
///
/// # let entry = &bundled()[0];
/// # let scenario = entry.read()?;
/// # let ego = entry.recorded_ego(&scenario)?.expect("recorded beside it");
/// # let scene = Scene::new(scenario, ego);
/// let window = Window::ending_at(&scene, scene.last_step(), 10);
/// let judgement = judge(&scene, Task::Collision, &window);
/// assert_eq!(judgement.verdict.dangerous, judgement.decisive_step.is_some());
/// println!("{}", judgement.verdict.justification);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn judge(scene: &Scene, task: Task, window: &Window) -> Judgement {
    judge_under(scene, task, window, Thresholds::shipped())
}

/// Judges a scene.
///
/// Whether a recording is of high risk depends on the thresholds, as the risk scores do; the other decisions do not.
///
/// The collision and the recording task look at every recorded step of the ego, whatever the window. The safety task predicts from
/// `window` alone, never from anything beyond it: see [`Criterion::REFERENCE`].
/// The tasks without a yes or no start from the same prediction: for them this is the judgement of safety, and says so.
#[must_use]
pub fn judge_under(
    scene: &Scene,
    task: Task,
    window: &Window,
    thresholds: &Thresholds,
) -> Judgement {
    match task {
        Task::Collision => judge_collision(scene, thresholds),
        Task::Recording => judge_recording(scene, thresholds),
        Task::Safety | Task::Attacker | Task::Trajectory => {
            safety::judge(scene, window, thresholds)
        }
    }
}

/// `car 30308`.
fn name(participant: &Participant<'_>) -> String {
    let obstacle = participant.obstacle;
    format!("{} {}", obstacle.kind.words(), obstacle.id)
}

/// The finding, a line for each obstacle, and how it was judged.
fn reasoning(finding: &str, lines: impl Iterator<Item = String>, how: &str) -> String {
    let lines: String = lines.map(|line| format!("- {line}\n")).collect();
    format!("{finding}\n\n{lines}\n{how}")
}

/// `step 143 (14.3 s)`.
fn moment(scene: &Scene, step: i64) -> String {
    format!("step {step} ({:.1} s)", scene.time_of(step))
}

/// `at step 143 (14.3 s)`, or `between steps 3 and 4, at 1.75 s`.
fn touching(scene: &Scene, contact: &Contact) -> String {
    if contact.overlaps {
        format!("at {}", moment(scene, contact.step))
    } else {
        format!(
            "between steps {} and {}, at {:.2} s",
            contact.step - 1,
            contact.step,
            contact.time
        )
    }
}

/// A distance; to the millimetre where centimetres would read as contact.
fn metres(distance: f64) -> String {
    if distance > 0.0 && distance < 0.1 {
        format!("{distance:.3} m")
    } else {
        format!("{distance:.2} m")
    }
}

/// With two decimals; what rounds to nothing has no sign.
fn number(value: f64) -> String {
    format!("{:.2}", (value * 100.0).round() / 100.0 + 0.0)
}

/// Where the other is, how far, and how fast it comes, in half a sentence.
fn situation(encounter: &Encounter<'_>) -> String {
    let relation = encounter.relation();
    if encounter.is_with_occupancy() {
        return format!(
            "{}, distance {}, gaps {} m along and {} m across, a region of no known velocity",
            relation.direction.name().to_lowercase(),
            metres(encounter.distance()),
            number(relation.gap_long),
            number(relation.gap_lat),
        );
    }
    format!(
        "{}, distance {}, gaps {} m along and {} m across, relative velocity {} m/s along and {} m/s across",
        relation.direction.name().to_lowercase(),
        metres(encounter.distance()),
        number(relation.gap_long),
        number(relation.gap_lat),
        number(relation.velocity.x),
        number(relation.velocity.y),
    )
}

/// `1 (extreme)`.
fn risk(score: u8) -> String {
    let name = RISK_LEVELS
        .level(score)
        .map_or("", |level| level.name.as_str());
    format!("{score} ({name})")
}

/// The value of a measure in an encounter.
fn value(id: &str, encounter: &Encounter<'_>) -> Option<f64> {
    let measure = measure(id)?;
    match measure.evaluate(encounter) {
        Reading::Value(value) => Some(value),
        Reading::None(_) => None,
    }
}

/// Obstacles listed beside those of high risk.
const MOST_LISTED: usize = 5;

/// The score of no influence; obstacles that never have a lower one are not listed.
const NEGLIGIBLE: u8 = 5;

/// Judges the recording task: whether the lowest risk score of all obstacles at all recorded steps of the ego is at
/// most [`Task::HIGH_RISK`].
#[must_use]
pub fn judge_recording(scene: &Scene, thresholds: &Thresholds) -> Judgement {
    let scores = RiskConvention::exact_up_to(NEGLIGIBLE - 1, scene, thresholds);
    let mut worst: BTreeMap<i64, ScoreAt> = BTreeMap::new();
    for &at in &scores {
        let known = worst.entry(at.obstacle).or_insert(at);
        if at.score < known.score {
            *known = at;
        }
    }
    let mut worst: Vec<ScoreAt> = worst.into_values().collect();
    worst.sort_by_key(|at| (at.score, at.step, at.obstacle));
    let high = |at: &ScoreAt| at.score <= Task::HIGH_RISK;
    let critical = first_times(&scores);
    let many = critical.len();
    worst.truncate(many.max(MOST_LISTED));
    let dangerous = many > 0;

    let how = format!(
        "Risk scores of real bodies at every step, {} to {}; the ego is {}. High risk: a score of at most {}.",
        moment(scene, scene.steps().start),
        moment(scene, scene.last_step()),
        scene.ego.source.short(),
        risk(Task::HIGH_RISK),
    );
    let lines = worst.iter().filter_map(|at| line(scene, *at));
    let justification = match worst.first() {
        Some(at) if high(at) => format!(
            "The lowest risk score is {}, of obstacle {} at {}: high risk.",
            risk(at.score),
            at.obstacle,
            moment(scene, at.step),
        ),
        Some(at) => format!(
            "The lowest risk score is {}, of obstacle {} at {}: safe.",
            risk(at.score),
            at.obstacle,
            moment(scene, at.step),
        ),
        None => format!(
            "No obstacle ever has a risk score below {}: safe.",
            risk(NEGLIGIBLE)
        ),
    };
    Judgement {
        reasoning: reasoning(&justification, lines, &how),
        decisive_step: worst.first().filter(|at| high(at)).map(|at| at.step),
        verdict: Verdict {
            task: Task::Recording,
            dangerous,
            obstacles: worst.iter().map(|at| entry(scene, *at)).collect(),
            justification,
            critical: Some(critical),
            probability: Some(if dangerous { 1.0 } else { 0.0 }),
            token_probability: None,
            unknown: Vec::new(),
        },
        prospects: Vec::new(),
    }
}

/// The obstacles of high risk, in the order in which they first are.
fn first_times(scores: &[ScoreAt]) -> Vec<CriticalObstacle> {
    let mut found: Vec<CriticalObstacle> = Vec::new();
    for at in scores.iter().filter(|at| at.score <= Task::HIGH_RISK) {
        if found.iter().all(|known| known.id != at.obstacle) {
            found.push(CriticalObstacle {
                id: at.obstacle,
                probability: Some(1.0),
            });
        }
    }
    found
}

fn entry(scene: &Scene, at: ScoreAt) -> ObstacleRisk {
    ObstacleRisk {
        id: at.obstacle,
        risk_score: at.score,
        reason: format!("lowest at {}", moment(scene, at.step)),
        written_score: None,
    }
}

fn line(scene: &Scene, at: ScoreAt) -> Option<String> {
    let who = scene
        .participants()
        .find(|other| other.obstacle.id == at.obstacle)?;
    let encounter = Encounter::at(scene, &who, at.step)?;
    Some(format!(
        "{}: lowest risk score {} at {}: {}.",
        name(&who),
        risk(at.score),
        moment(scene, at.step),
        situation(&encounter),
    ))
}
