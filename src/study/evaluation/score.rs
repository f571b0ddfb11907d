//! Truth by the risk score from time and distance to a collision (TTC and MDC): what is of extreme risk is critical.
//!
//! So does the paper: obstacles of score 0 (collision) and 1 (extreme) endanger the ego. The score is the same quantity
//! that the metrics frame prints; [`says_the_score`] tells whether a question holds it.

use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::paper::TooLarge;
use nearmiss_scene::metrics::{MeasureList, RiskConvention, ScoreAt, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;

use super::windows::Recording;
use super::{Label, PromptConfig};

/// When which obstacles are of extreme risk in a recording, by step.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CriticalMoments(Vec<ScoreAt>);

impl CriticalMoments {
    /// Those of a scene; the thresholds count for the exact convention alone.
    ///
    /// # Errors
    /// The scene cannot be scored by the paper's convention: nothing is known of it.
    pub fn new(
        convention: RiskConvention,
        scene: &Scene,
        thresholds: &Thresholds,
    ) -> Result<Self, TooLarge> {
        let scores = convention.scores_up_to(Task::HIGH_RISK, scene, thresholds);
        scores.map(Self)
    }

    /// Those of a scene by exact geometry, which scores every scene.
    #[must_use]
    pub fn exact(scene: &Scene, thresholds: &Thresholds) -> Self {
        let high = Task::HIGH_RISK;
        Self(RiskConvention::exact_up_to(high, scene, thresholds))
    }

    /// What windows of the safety task are drawn from: dangerous ones come before the first of these moments.
    #[must_use]
    pub fn recording(&self, name: &str, scene: &Scene, radius: f64) -> Recording {
        let moments = self.0.iter().map(|at| (at.step, at.obstacle));
        Recording::of_moments(name, scene, moments.collect(), radius)
    }

    /// Whether the whole recording is of high risk, and the obstacles that make it so, the first one first.
    #[must_use]
    pub fn of_recording(&self) -> (Label, Vec<i64>) {
        self.within(i64::MIN..=i64::MAX)
    }

    /// Whether one of these moments is within the horizon after a window, seconds, and whose.
    #[must_use]
    pub fn after(&self, window: &Window, horizon: f64, dt: f64) -> (Label, Vec<i64>) {
        let after = (horizon / dt).round() as i64;
        self.within(window.last() + 1..=window.last().saturating_add(after))
    }

    fn within(&self, steps: std::ops::RangeInclusive<i64>) -> (Label, Vec<i64>) {
        let mut critical = Vec::new();
        for at in self.0.iter().filter(|at| steps.contains(&at.step)) {
            if !critical.contains(&at.obstacle) {
                critical.push(at.obstacle);
            }
        }
        match critical.first() {
            Some(first) => (Label::Collision(Some(*first)), critical),
            None => (Label::Safe, critical),
        }
    }
}

/// Whether the description of a way's questions prints risk scores: those of the described steps, and the lowest of the
/// window. `measures` are those chosen for the metrics frame, if any.
#[must_use]
pub fn says_the_score(configuration: &PromptConfig, measures: Option<&MeasureList>) -> bool {
    let printed = match measures {
        Some(chosen) => chosen.ids().contains(&"risk"),
        // The templates of the recording task choose measures without it.
        None => configuration.task != Task::Recording,
    };
    configuration.frame.and_then(Frame::words) == Some(Frame::Metrics) && printed
}

/// The note of a report on answers whose truth is a risk score and whose questions print it: how they were asked, and the
/// measures that were chosen for the metrics frame, if any.
#[must_use]
pub fn note_on_score<'a>(
    configurations: impl IntoIterator<Item = (&'a PromptConfig, Option<&'a MeasureList>)>,
) -> Option<String> {
    let mut tasks: Vec<Task> = Vec::new();
    for (configuration, measures) in configurations {
        if says_the_score(configuration, measures) && !tasks.contains(&configuration.task) {
            tasks.push(configuration.task);
        }
    }
    tasks.sort_unstable();
    tasks.retain(|task| *task != Task::Collision);
    (!tasks.is_empty()).then(|| {
        format!(
            "The truth of the {} task is a risk score, and its metrics frame prints risk scores: these answers can read \
             off what answers in other frames have to work out. Do not compare them.",
            Task::names(&tasks).replace(" or ", " and ")
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn moments(all: &[(i64, u8, i64)]) -> CriticalMoments {
        let at = |&(step, score, obstacle): &(i64, u8, i64)| ScoreAt {
            step,
            score,
            obstacle,
        };
        CriticalMoments(all.iter().map(at).collect())
    }

    #[test]
    fn a_window_is_critical_if_an_extreme_moment_follows_within_the_horizon() {
        let found = moments(&[(30, 1, 7), (31, 0, 8), (31, 1, 7), (60, 1, 9)]);
        let hit = |id, critical: &[i64]| (Label::Collision(Some(id)), critical.to_vec());
        assert_eq!(found.of_recording(), hit(7, &[7, 8, 9]));
        let after = |last| found.after(&Window::within(&(0..100), last, 10), 1.0, 0.1);
        assert_eq!(after(19), (Label::Safe, vec![]), "eleven steps before");
        assert_eq!(after(20), hit(7, &[7]));
        assert_eq!(after(25), hit(7, &[7, 8]));
        assert_eq!(after(31), (Label::Safe, vec![]), "the present is past");
        assert_eq!(after(55), hit(9, &[9]));
        assert_eq!(moments(&[]).of_recording(), (Label::Safe, vec![]));
    }

    #[test]
    fn only_the_metrics_frame_with_the_risk_score_tells_the_truth() {
        let configuration = |task, frame| PromptConfig {
            task,
            frame: Some(frame),
            techniques: None,
            model: "lab/a".into(),
            settings: crate::evaluation::AxisValues::default(),
            template: None,
        };
        let metrics = configuration(Task::Safety, Frame::Metrics);
        let with = MeasureList::parse("ttc,risk").unwrap();
        let without = MeasureList::parse("ttc").unwrap();
        assert!(says_the_score(&metrics, None));
        assert!(says_the_score(&metrics, Some(&with)));
        assert!(!says_the_score(&metrics, Some(&without)));
        assert!(!says_the_score(
            &configuration(Task::Safety, Frame::Ego),
            None
        ));
        let recording = configuration(Task::Recording, Frame::Metrics);
        assert!(!says_the_score(&recording, None));
        assert!(says_the_score(&recording, Some(&with)));
        assert_eq!(note_on_score([(&recording, None)]), None);
        let note = note_on_score([(&recording, Some(&with)), (&metrics, None)]).unwrap();
        assert!(note.contains("safety and recording task"), "{note}");
    }

    /// The bundled cut-in with one state of an obstacle beyond all numbers, as no file may hold it.
    fn beyond() -> Scene {
        use nearmiss_base::geometry::Point;
        use nearmiss_scene::scenario::{Position, Prediction, Scenario};
        let entry = nearmiss_formats::bundled().into_iter();
        let entry = { entry }.find(|e| e.name.contains("CutIn")).unwrap();
        let mut scenario = Scenario::clone(&entry.read().unwrap());
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        let is_driven = |p: &Prediction| matches!(p, Prediction::Trajectory(_));
        let other = { scenario.obstacles.iter_mut() }.find(|o| is_driven(&o.prediction));
        let Prediction::Trajectory(states) = &mut other.unwrap().prediction else {
            unreachable!()
        };
        states[3].position = Some(Position::Point(Point::new(1.7e308, -1.7e308)));
        Scene::new(std::sync::Arc::new(scenario), ego)
    }

    #[test]
    fn what_the_papers_tables_cannot_hold_is_not_scored_instead_of_safe() {
        use crate::evaluation::batch::Truth;
        let (scene, shipped) = (beyond(), Thresholds::shipped());
        let paper = RiskConvention::Paper;
        assert!(CriticalMoments::new(paper, &scene, shipped).is_err());
        assert!(CriticalMoments::new(RiskConvention::Exact, &scene, shipped).is_ok());
        let entry = nearmiss_formats::Entry::of_argument(std::path::Path::new("beyond.xml"));
        let window = Window::full(&scene);
        let told = |truth: &Truth, task| {
            truth.of_question(task, (&entry, Some(&scene)), (&window, 2.0), shipped)
        };
        for task in [Task::Safety, Task::Recording] {
            assert_eq!(told(&Truth::Score(paper), task), None);
            assert!(told(&Truth::Score(RiskConvention::Exact), task).is_some());
        }
        let why = Truth::Score(paper).not_scored(&scene, shipped).unwrap();
        assert!(why.starts_with("not scored, so left out"), "{why}");
        assert_eq!(Truth::Geometry.not_scored(&scene, shipped), None);
    }
}
