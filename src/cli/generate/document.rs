//! A variant as one JSON line.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::variant::Generated;
use crate::cli::output;
use crate::evaluation::generating::Authored;
use crate::generation::{
    Avoidability, Plausibility, Refusal, VariantFiles, asked, attacker, refusal,
};

/// Documents a scenario's variant.
pub fn document(generated: &Generated, saved: Option<&VariantFiles>, by: &str) -> Value {
    let mut line = unsaved(generated, by);
    line["rejected"] = generated.refusals().iter().map(refusal).collect();
    if let Some(saved) = saved {
        place(&mut line, &saved.id, &saved.scenario, &saved.ego);
    }
    line
}

/// Says in a line where the variant lies.
pub fn place(line: &mut Value, id: &str, scenario: &Path, ego: &Path) {
    let path = |path: &Path| Value::String(output::visible(&path.display().to_string()));
    line["variant"] = path(scenario);
    line["ego"] = path(ego);
    line["id"] = id.into();
}

/// The same before it is saved and without refusals, as in the manifest, which records those elsewhere.
pub fn unsaved(generated: &Generated, by: &str) -> Value {
    let made = &generated.made;
    let chosen = made.chosen.as_ref();
    let effect = chosen.and_then(|c| c.attack.effect.as_ref());
    let collision = effect.and_then(|e| e.collision());
    let baseline = generated.workshop.closed.baseline();
    let driver = generated.workshop.closed.driver();
    let planner = driver
        .external()
        .map_or("nearmiss", |planner| planner.name());
    let beside_recorded = chosen.and_then(|c| generated.workshop.plausibility(&c.attack.change));
    json!({
        "variant": null,
        "ego": null,
        "attacker": effect.map(|e| e.attacker),
        "outcome": effect.map_or("none", |e| e.consequence.name()),
        "min_risk_before": effect.map_or(baseline.lowest(), |e| e.lowest_before()),
        "min_risk_after": effect.map_or(baseline.lowest(), |e| e.lowest_after()),
        "avoidable": chosen.map(|c| avoidable(&c.avoidability)),
        "candidates": made.found.candidates,
        "rejected": null,
        "scenario": generated.name,
        "file": generated.file,
        "id": null,
        "by": by,
        "manoeuvre": chosen.map(|c| c.attack.asked.name()),
        "asked": chosen.map(|c| asked(&c.attack.asked)),
        "from_step": effect.map(|e| e.from),
        "until_step": chosen.and_then(|c| c.attack.change.until()),
        "collision_with": collision.map(|c| c.with),
        "collision_step": collision.map(|c| c.step),
        "ego_side": collision.map(|c| c.ego.name()),
        "other_side": collision.map(|c| c.other.name()),
        "min_distance": effect.and_then(|e| e.distance),
        "touched_after_step": effect.and_then(|e| e.between),
        "min_risk_of_anyone_before": baseline.lowest(),
        "min_risk_of_anyone_after": effect.map_or(baseline.lowest(), |e| e.anyone_after),
        "style": generated.workshop.style().name(),
        "plausibility": beside_recorded.as_ref().map(|(own, _)| plausibility(own)),
        "motion_samples": beside_recorded.as_ref().map(|(own, recorded)| {
            json!({ "attacker": own.samples, "recorded": recorded.samples() })
        }),
        "note": generated.note(),
        "safe_before": generated.workshop.is_safe(),
        "baseline": baseline.drive().outcome.name(),
        "drive": effect.map(|e| e.drive.outcome.name()),
        "planner": output::visible(planner),
        "collision_kind": collision.map(|c| c.kind().name()),
        "reference_ranking": ranking(generated),
        "passed": made.found.attacks.len(),
        "driven": made.found.attacks.iter().filter(|a| a.effect.is_some()).count(),
        "model": generated.author(),
        "refused": refused(&made.found.refused),
        "taken_over": false,
        "seconds": (generated.took.as_secs_f64() * 1e3).round() / 1e3,
    })
}

/// Log-likelihood of the attacker's motion, nats per second, and that of recorded ones on average.
fn plausibility(own: &Plausibility) -> Value {
    json!({
        "log_likelihood_per_second": own.log_likelihood,
        "recorded_log_likelihood_per_second": own.recorded,
    })
}

/// Who could reach the ego with the least change, by the reference: the acceleration (m/s²) that it takes, and when.
fn ranking(generated: &Generated) -> Value {
    let ranked = generated.workshop.on(|ground| attacker::rank(ground.stage));
    let ranked = ranked.unwrap_or_default();
    let ranked = ranked.iter().map(|c| {
        json!({
            "id": c.obstacle,
            "acceleration": c.acceleration,
            "step": c.step,
            "distance": c.distance,
            "near": c.near,
            "behind": c.behind,
        })
    });
    ranked.collect()
}

/// Notes on a model's work beside the table.
pub fn said(authored: &Authored) -> Vec<String> {
    let proposal = authored.choice.proposal.as_ref();
    let choice = proposal.and_then(|p| p.refused.as_ref()).map(|why| {
        format!(
            "attacker rejected: {why}; chosen instead by: {}",
            authored.choice.by.name()
        )
    });
    let refused = authored.declined.iter().map(|d| {
        let why = d.refusals.first().map(ToString::to_string);
        format!(
            "answer {}, try {}: rejected: {}",
            d.source.sample + 1,
            d.source.retry + 1,
            why.unwrap_or_default()
        )
    });
    let stopped = authored.stopped.iter().map(|why| format!("stopped: {why}"));
    choice.into_iter().chain(refused).chain(stopped).collect()
}

fn avoidable(avoidability: &Avoidability) -> Value {
    let all = avoidability.certificates.iter();
    let pairs = all.map(|(delay, certificate)| {
        let found = certificate.avoidance().is_some();
        (format!("{delay:.1}"), Value::Bool(found))
    });
    Value::Object(pairs.collect::<Map<_, _>>())
}

/// How many motions were refused for each reason; of each motion the first counts.
fn refused(refusals: &[Refusal]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for refusal in refusals {
        *counts.entry(refusal.reason.name()).or_default() += 1;
    }
    counts
}
