//! The answer of `ask` as one JSON line.

use serde_json::{Value, json};

use super::{past, words};
use crate::cli::{cost, time};
use crate::evaluation::{Answer, Case, Judge, JudgeOutcome};
use crate::judge;
use crate::verdict::Task;

/// The verdict, its cost and where it is stored; the same keys with or without a verdict.
pub(super) fn document(answer: &Answer, case: &Case, judge: &Judge) -> Value {
    let mut value = match &answer.judged {
        JudgeOutcome::Verdict(parsed) => {
            json!(parsed.verdict)
        }
        JudgeOutcome::Other(reading) => json!(reading.said),
        JudgeOutcome::Missing(missing) => json!({
            "verdict": null,
            "problem": words::missing(missing),
            "answer": answer.text,
            "reasoning": answer.reasoning,
        }),
    };
    let how = match &answer.judged {
        JudgeOutcome::Missing(_) => None,
        _ if answer.repairs().is_empty() => Some("strict"),
        _ => Some("repaired"),
    };
    value["how"] = json!(how);
    value["repaired"] = json!(answer.repairs());
    if let Some(why) = answer.cut_off() {
        value["cut_off"] = json!(why);
    }
    value["run"] = json!(answer.run.map(|run| run.0));
    let consumed = &answer.consumed;
    value["usage"] = json!({
        "input_tokens": consumed.input_tokens,
        "output_tokens": consumed.output_tokens,
        "reasoning_tokens": consumed.reasoning_tokens,
        "cached_tokens": consumed.cached_tokens,
    });
    let returned = answer.model_returned.as_deref();
    let worked_out = past::worked_out(answer, judge);
    value["cost"] = match consumed.cost_usd {
        Some(usd) => json!({"usd": usd, "source": answer.price_source}),
        None if answer.model == judge::MODEL => json!({"usd": 0, "source": "built in"}),
        None => match worked_out {
            Some((usd, how)) => json!({"usd": usd, "source": how}),
            None => {
                json!({"usd": null, "unknown": cost::unknown(consumed, &answer.model, returned)})
            }
        },
    };
    value["model"] = json!(answer.model);
    if let Some(returned) = &answer.model_returned {
        value["model_returned"] = json!(returned);
    }
    if let (Some(past), Some(run)) = (&answer.past, answer.run) {
        value["stored"] = json!({
            "run": run.0,
            "asked": time::rfc3339(past.created_ms),
            "asked_as": answer.model,
            "origin": past.origin.name(),
            "sample": past.sample,
        });
    }
    if answer.model == judge::MODEL && case.task == Task::Safety {
        value["prediction"] = prediction(case);
    }
    value
}

/// The basis of the built-in judge's verdict on safety.
fn prediction(case: &Case) -> Value {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let judgement = case.judgement();
    let obstacles = judgement.prospects.iter().map(|p| {
        json!({
            "id": p.id,
            "probability": rounded(p.probability),
            "time": p.time.map(rounded),
        })
    });
    json!({
        "horizon": judge::Criterion::REFERENCE.horizon,
        "threshold": judge::Criterion::REFERENCE.threshold,
        "first_step": case.window.first(),
        "last_step": case.window.last(),
        "obstacles": obstacles.collect::<Vec<_>>(),
    })
}
