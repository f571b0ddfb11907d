//! A variant as one JSON line.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::variant::Generated;
use crate::output;
use crate::plan::failed;
use crate::row_file::short_hash;
use nearmiss_drive::generation::{
    Attack, Avoidability, ClosedLoop, Effect, Plausibility, Refusal, VariantFiles, asked, attacker,
    attacker_document, refusal,
};
use nearmiss_scene::verdict::Motion;
use nearmiss_study::evaluation::generating::{Authored, ChosenBy};

/// The line of a scenario's variant with its refusals, and with where it was saved.
pub fn document(generated: &Generated, saved: Option<&VariantFiles>, mut line: Value) -> Value {
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
    let collision = effect.and_then(|e| e.contact);
    let main = chosen.zip(effect);
    let main = main.and_then(|(c, effect)| c.attack.asked.get(effect.main));
    let baseline = generated.workshop.closed.baseline();
    let driver = generated.workshop.closed.driver();
    let planner = driver
        .external()
        .map_or("nearmiss", |planner| planner.name());
    let beside_recorded = chosen.and_then(|c| generated.workshop.plausibility(&c.attack.change));
    let looked = chosen.filter(|c| c.avoidability.is_looked_for());
    let mut line = json!({
        "variant": null,
        "ego": null,
        "attacker": effect.map(|e| e.main().obstacle),
        "outcome": effect.map_or("none", |e| e.consequence.name()),
        "min_risk_before": effect.map_or(baseline.lowest(), |e| e.lowest_before()),
        "min_risk_after": effect.map_or(baseline.lowest(), |e| e.lowest_after()),
        "avoidable": looked.map(|c| avoidable(&c.avoidability)),
        "candidates": made.found.candidates,
        "rejected": null,
        "scenario": generated.name,
        "file": generated.file,
        "hash": short_hash(&generated.workshop.closed.scenario().hash),
        "id": null,
        "by": by,
        "attackers": chosen.map(|c| attackers(generated, &c.attack)),
        "manoeuvre": main.map(Motion::name),
        "asked": main.map(asked),
        "from_step": effect.map(|e| e.from),
        "until_step": chosen.and_then(|c| c.attack.change.until_step()),
        "collision_with": collision.map(|c| c.with),
        "collision_step": collision.map(|c| c.step),
        "ego_side": collision.map(|c| c.ego.name()),
        "other_side": collision.map(|c| c.other.name()),
        "min_distance": effect.and_then(Effect::distance),
        "touched_after_step": effect.and_then(Effect::touched_after_step),
        "min_risk_of_anyone_before": baseline.lowest(),
        "min_risk_of_anyone_after": effect.map_or(baseline.lowest(), |e| e.anyone_after),
    });
    let work = json!({
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
        "good_driver": chosen.zip(effect).and_then(|(c, effect)| {
            good_driver(&generated.workshop.closed, &c.avoidability, effect)
        }),
        "collision_kind": collision.map(|c| c.kind().name()),
        "reference_ranking": ranking(generated),
        "passed": made.found.attacks.len(),
        "driven": made.found.attacks.iter().filter(|a| a.effect.is_some()).count(),
        "model": generated.author(),
        "refused": refused(&made.found.refused),
        "taken_over": false,
        "seconds": (generated.took.as_secs_f64() * 1e3).round() / 1e3,
    });
    if let (Value::Object(line), Value::Object(work)) = (&mut line, work) {
        line.extend(work);
    }
    if let Some(report) = &baseline.drive().external {
        line["external_planner"] = json!({
            "name": output::visible(&report.name),
            "version": output::visible(&report.version),
        });
    }
    let broken = effect.filter(|effect| effect.breaks_planner());
    if let Some(report) = broken.and_then(|effect| effect.drive.external.as_ref())
        && let Some(fault) = report.fault
        && let Value::Object(failure) = failed(fault, report.fault_step, &report.stderr)
        && let Value::Object(planner) = &mut line["external_planner"]
    {
        planner.extend(failure);
    }
    line
}

/// Log-likelihood of the attackers' motions, nats per second, and that of recorded ones on average.
fn plausibility(own: &Plausibility) -> Value {
    json!({
        "log_likelihood_per_second": own.log_likelihood,
        "recorded_log_likelihood_per_second": own.recorded,
    })
}

/// What each attacker does, how near it comes, and how plausible it is.
fn attackers(generated: &Generated, attack: &Attack) -> Value {
    let effects = attack.effect.iter().flat_map(|effect| &effect.attackers);
    let all = effects.zip(attack.acts()).map(|(effect, (asked, change))| {
        let mut one = attacker_document(effect, asked);
        let own = generated
            .workshop
            .plausibility_of(std::slice::from_ref(change));
        one["plausibility"] = own.map_or(Value::Null, |(own, _)| plausibility(&own));
        one
    });
    all.collect()
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
            "reaches": c.reaches,
        })
    });
    ranked.collect()
}

/// Notes on a model's work beside the table.
pub fn said(authored: &Authored) -> Vec<String> {
    let proposal = authored.choice.proposal.as_ref();
    let instead = match authored.choice.by {
        ChosenBy::NoAttacker => "nothing is generated (obey=on)",
        _ => "the first of the reference ranking attacks",
    };
    let choice = proposal
        .and_then(|p| p.refused.as_ref())
        .map(|why| format!("attacker rejected: {why}; {instead}"));
    let not_asked = { authored.choice.not_asked() }
        .map(|why| format!("{why}: the model is not asked who attacks; {instead}"));
    let choice = choice.or(not_asked);
    let tally = authored.choice.tally();
    let disagree = (tally.len() > 1).then(|| {
        let votes = tally.iter().map(|(id, votes)| format!("{id} ({votes})"));
        let votes: Vec<String> = votes.collect();
        let tie = if authored.choice.tied.is_empty() {
            ""
        } else {
            "; a tie, decided by the reference ranking"
        };
        format!("votes for the attacker: {}{tie}", votes.join(", "))
    });
    let void = authored
        .choice
        .votes
        .iter()
        .filter(|v| v.refused.is_some())
        .count();
    let void = (void > 0 && void < authored.choice.votes.len())
        .then(|| format!("{void} of {} votes rejected", authored.choice.votes.len()));
    let differ = authored.agreement().filter(|agreement| !agreement.agrees).map(|agreement| {
        format!(
            "best motion by the model's grades: answer {}, try {}; by the exact ranking: answer {}, try {}",
            agreement.model.sample + 1,
            agreement.model.retry + 1,
            agreement.exact.sample + 1,
            agreement.exact.retry + 1
        )
    });
    let refused = authored.declined.iter().map(|d| {
        let why = d.refusals.first().map(ToString::to_string);
        format!(
            "answer {}, try {}: {}: {}",
            d.source.sample + 1,
            d.source.retry + 1,
            if d.arrived { "rejected" } else { "failed" },
            why.unwrap_or_default()
        )
    });
    let stopped = authored.stopped.iter().map(|why| format!("stopped: {why}"));
    let about_choice = choice.into_iter().chain(disagree).chain(void);
    about_choice
        .chain(refused)
        .chain(differ)
        .chain(stopped)
        .collect()
}

/// The good driver with the longest reaction time (s) who survives, as `drive` is the planner that is attacked.
fn good_driver(closed: &ClosedLoop, avoidability: &Avoidability, effect: &Effect) -> Option<Value> {
    let (delay, way) = avoidability.latest()?;
    let review = way.review(closed, effect);
    Some(json!({
        "reaction_time": delay,
        "drive": way.drive.outcome.name(),
        "found_by": way.found.to_string(),
        "max_acceleration": review.acceleration,
        "rules_broken": review.broken(),
        "rules_undecided": review.undecided(),
        "leaves_roadway_step": review.leaves_roadway,
    }))
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
