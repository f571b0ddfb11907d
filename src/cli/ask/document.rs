//! The answer of `ask` as one JSON line.

use serde_json::{Value, json};

use super::{past, words};
use crate::{cost, time};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::{Answer, Case, Judge, JudgeOutcome, Question};

/// The verdict, its cost and where it is stored; the same keys with or without a verdict.
pub(super) fn document(answer: &Answer, question: &Question, judge: &Judge) -> Value {
    let case = &question.case;
    let (verdict, problem) = match &answer.judged {
        JudgeOutcome::Verdict(parsed) => (json!(parsed.verdict), None),
        JudgeOutcome::Other(reading) => (json!(reading.said), None),
        JudgeOutcome::Missing(missing) => (Value::Null, Some(words::missing(missing))),
    };
    let dangerous = match &answer.judged {
        JudgeOutcome::Verdict(parsed) => Some(parsed.verdict.dangerous),
        _ => None,
    };
    let reading = match (&problem, answer.repairs().is_empty()) {
        (Some(_), _) => None,
        (None, true) => Some("strict"),
        (None, false) => Some("repaired"),
    };
    let consumed = &answer.consumed;
    let (cost_usd, price_source) = match (consumed.cost_usd, past::worked_out(answer, judge)) {
        (Some(usd), _) => (Some(usd), answer.price_source.clone()),
        (None, _) if answer.model == judge::MODEL => (Some(0.0), Some("built in".into())),
        (None, Some((usd, how))) => (Some(usd), Some(how)),
        (None, None) => (None, None),
    };
    let returned = answer.model_returned.as_deref();
    let rounds = &answer.tool_rounds;
    let mut value = json!({
        "run": answer.run.map(|run| run.0),
        "scenario": case.name,
        "task": case.task.name(),
        "frame": case.frame.name(),
        "techniques": case.techniques.to_string(),
        "window": answer.window,
        "template": question.template,
        "template_hash": question.template_hash,
        "model": answer.model,
        "model_returned": returned,
        "dangerous": dangerous,
        "verdict": verdict,
        "reading": reading,
        "repaired": answer.repairs(),
        "flags": answer.flags(&case.scene.scenario),
        "cut_off": answer.cut_off(),
        "problem": problem,
        "answer": answer.text,
        "reasoning": answer.reasoning,
        "input_tokens": consumed.input_tokens,
        "output_tokens": consumed.output_tokens,
        "reasoning_tokens": consumed.reasoning_tokens,
        "cached_tokens": consumed.cached_tokens,
        "cost_usd": cost_usd,
        "price_source": price_source,
        "cost_unknown": cost_usd
            .is_none()
            .then(|| cost::unknown(consumed, &answer.model, returned)),
        "stored": null,
        "prediction": null,
    });
    if !rounds.is_empty() {
        value["tool_rounds"] = json!(rounds);
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
