//! Scored answers for tests.

use super::{AnswerStatus, Label, PromptConfig, Scored};
use nearmiss_scene::verdict::{ObstacleRisk, Task, Verdict};
use nearmiss_store::Consumed;

/// What a model says about a scenario: yes or no, and obstacles with their scores.
pub(crate) fn answer(scenario: &str, model: &str, dangerous: bool, risks: &[(i64, u8)]) -> Scored {
    let risk = |&(id, risk_score): &(i64, u8)| ObstacleRisk {
        id,
        risk_score,
        reason: String::new(),
        written_score: None,
    };
    let verdict = Verdict {
        task: Task::Safety,
        dangerous,
        obstacles: risks.iter().map(risk).collect(),
        justification: String::new(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    };
    Scored {
        status: AnswerStatus::Verdict(verdict),
        ..failed(scenario, model)
    }
}

/// No answer of a model about a scenario.
pub(super) fn failed(scenario: &str, model: &str) -> Scored {
    Scored {
        scenario: scenario.into(),
        configuration: PromptConfig {
            task: Task::Safety,
            frame: None,
            techniques: None,
            model: model.into(),
            settings: crate::evaluation::AxisValues::default(),
            template: None,
        },
        sample: 0,
        truth: None,
        critical: Vec::new(),
        status: AnswerStatus::Failed("cut".into()),
        reference: None,
        window: None,
        consumed: Consumed::default(),
        most_usd: None,
        superseded: Vec::new(),
        run: None,
        claims: nearmiss_store::ClaimCounts::default(),
        cluster: crate::evaluation::Cluster::default(),
    }
}

/// As many scenarios with a collision: the model calls the first `found` of them dangerous.
pub(crate) fn collisions_found(model: &str, found: u32, all: u32) -> Vec<Scored> {
    let one = |i: u32| {
        let verdict = Verdict {
            task: Task::Safety,
            dangerous: i < found,
            obstacles: Vec::new(),
            justification: String::new(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        };
        Scored::built_in(
            &format!("S{i}"),
            model,
            Task::Safety,
            Some(Label::Collision(None)),
            AnswerStatus::Verdict(verdict),
        )
    };
    (0..all).map(one).collect()
}
