//! Scored answers for tests.

use super::{AnswerStatus, PromptConfig, Scored};
use crate::store::Consumed;
use crate::verdict::{ObstacleRisk, Task, Verdict};

/// What a model says about a scenario: yes or no, and obstacles with their scores.
pub(crate) fn answer(scenario: &str, model: &str, dangerous: bool, risks: &[(i64, u8)]) -> Scored {
    let risk = |&(id, risk_score): &(i64, u8)| ObstacleRisk {
        id,
        risk_score,
        reason: String::new(),
    };
    let verdict = Verdict {
        task: Task::Safety,
        dangerous,
        obstacles: risks.iter().map(risk).collect(),
        justification: String::new(),
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
        way: PromptConfig {
            task: Task::Safety,
            frame: None,
            techniques: None,
            model: model.into(),
            template: None,
        },
        sample: 0,
        truth: None,
        status: AnswerStatus::Failed("cut".into()),
        reference: None,
        consumed: Consumed::default(),
        run: None,
    }
}
