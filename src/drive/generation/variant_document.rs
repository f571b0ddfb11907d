//! A variant's complete record, as JSON.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::variant::{OTHERS, PROGRAM};
use super::{
    AttackerEffect, Certificate, Consequence, Effect, EvasiveReview, EvasiveTrajectory, Finder,
    Refusal, RiskCurve, SearchEffort, Variant, VariantFiles,
};
use crate::simulation::{Collision, ContactSide, PlannerFault, Rollout};
use nearmiss_scene::scenario::ContentHash;
use nearmiss_scene::verdict::{Motion, NewMotion, TrajectoryAnswer};

/// The document of a variant that is saved in these files.
pub(super) fn variant_document(
    variant: &Variant<'_>,
    saved: &VariantFiles,
    files: &[(&PathBuf, Vec<u8>)],
) -> Value {
    let hash = |(path, bytes): &(&PathBuf, Vec<u8>)| {
        let hash = ContentHash::digest(bytes).to_string();
        (name(path), Value::String(hash))
    };
    let effect = variant.effect;
    let looked_for = variant.avoidability.is_looked_for();
    let original = variant.closed.scenario();
    let driver = variant.closed.driver();
    let settings = driver.settings();
    let baseline = variant.closed.baseline().drive();
    json!({
        "variant": name(&saved.scenario),
        "sha256": files.iter().map(hash).collect::<Map<_, _>>(),
        "benchmark_id": saved.id,
        "ego": name(&saved.ego),
        "solution": name(&saved.solution),
        "program": PROGRAM,
        "by": variant.by,
        "original": {
            "benchmark_id": original.header.benchmark_id,
            "sha256": original.hash.to_string(),
            "file": variant.file,
        },
        "other_traffic": OTHERS,
        "attacker": effect.main().obstacle,
        "attackers": attackers(variant),
        "asked": variant.asked.get(effect.main).map(asked),
        "change": {
            "from_step": effect.from,
            "until_step": variant.change.until_step(),
            "seconds_per_step": driver.dt(),
        },
        "planning": {
            "problem": driver.problem().id,
            "vehicle": settings.planner.vehicle.number(),
            "prediction": settings.forecast.name(),
            "replan": settings.replan,
            "horizon": settings.planner.horizon,
            "rules": settings.planner.rules.name(),
            "planner": planner(baseline),
        },
        "outcome": effect.consequence.name(),
        "collision": effect.contact.map(|c| collision(&c, effect)),
        "hit_from_behind": effect.is_hit_from_behind(),
        "planner_error": effect.breaks_planner().then(|| failure(&effect.drive)),
        "drive": drive(&effect.drive),
        "baseline": drive(baseline),
        "min_risk_before": effect.lowest_before(),
        "min_risk_after": effect.lowest_after(),
        "min_risk_of_anyone_before": effect.anyone_before,
        "min_risk_of_anyone_after": effect.anyone_after,
        "min_distance": effect.distance(),
        "touched_after_step": effect.touched_after_step(),
        "risk_before": curve(&effect.main().before),
        "risk_after": curve(&effect.main().after),
        "avoidable": looked_for.then(|| certificates(variant, saved)),
        "rejected": variant.refusals.iter().map(refusal).collect::<Vec<_>>(),
        "model": variant.author,
        "made": variant.made,
    })
}

/// The planner that is attacked: the built-in one, or a process with what it was told.
fn planner(baseline: &Rollout) -> Value {
    let Some(report) = &baseline.external else {
        return "nearmiss".into();
    };
    json!({
        "named": report.planner,
        "name": report.name,
        "version": report.version,
        "clock": report.clock.name(),
        "predictions": report.predictions,
        "history": report.history,
    })
}

/// How the planner's process failed: the fault, the time step, and what it wrote to standard error.
fn failure(drive: &Rollout) -> Option<Value> {
    let report = drive.external.as_ref()?;
    Some(json!({
        "error": report.fault.map(PlannerFault::name),
        "error_step": report.fault_step,
        "message": report.message,
        "stderr": report.stderr,
    }))
}

/// What each attacker does, and how near it comes.
fn attackers(variant: &Variant<'_>) -> Value {
    let all = variant
        .effect
        .attackers
        .iter()
        .zip(variant.asked)
        .map(|(effect, motion)| {
            let mut one = attacker(effect, motion);
            one["risk_before"] = curve(&effect.before);
            one["risk_after"] = curve(&effect.after);
            one
        });
    all.collect()
}

/// What one attacker does, and how near it comes.
#[must_use]
pub fn attacker(effect: &AttackerEffect, motion: &Motion) -> Value {
    json!({
        "id": effect.obstacle,
        "manoeuvre": motion.name(),
        "asked": asked(motion),
        "from_step": effect.from,
        "until_step": effect.until,
        "min_risk_before": effect.lowest_before(),
        "min_risk_after": effect.lowest_after(),
        "min_distance": effect.distance,
        "outcome_without": effect.without.as_ref().map(Consequence::name),
    })
}

/// The request to an attacker, as a model would write it.
#[must_use]
pub fn asked(motion: &Motion) -> Value {
    let answer = TrajectoryAnswer::from(NewMotion {
        obstacle: 0,
        motion: motion.clone(),
        justification: String::new(),
    });
    json!({ "manoeuvre": answer.manoeuvre, "waypoints": answer.waypoints })
}

/// Files lie beside the document: only the name counts.
fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn drive(drive: &Rollout) -> Value {
    json!({
        "ended_with": drive.outcome.name(),
        "first_step": drive.states.first().map(|(step, _)| step),
        "last_step": drive.states.last().map(|(step, _)| step),
    })
}

fn collision(collision: &Collision, effect: &Effect) -> Value {
    json!({
        "with": collision.with,
        "with_attacker": effect.is_attacker(collision.with),
        "step": collision.step,
        "ego_side": ContactSide::name(collision.ego),
        "other_side": ContactSide::name(collision.other),
    })
}

fn curve(curve: &RiskCurve) -> Value {
    json!(
        curve
            .iter()
            .map(|(step, score)| json!([step, score]))
            .collect::<Vec<_>>()
    )
}

/// An answer for each reaction time, each with its proof.
fn certificates(variant: &Variant<'_>, saved: &VariantFiles) -> Value {
    let all = variant.avoidability.certificates.iter();
    // Several reaction times often share a trajectory.
    let mut last: Option<(&Arc<EvasiveTrajectory>, EvasiveReview)> = None;
    let all = all.map(|(delay, certificate)| {
        let file = saved.avoiding.iter().find(|(of, _)| of == delay);
        let answer = match certificate {
            Certificate::Avoided(avoidance) => {
                let file = file.map(|(_, path)| name(path));
                let known = last
                    .take()
                    .filter(|(known, _)| Arc::ptr_eq(known, avoidance));
                let review = known.map(|(_, review)| review);
                let review =
                    review.unwrap_or_else(|| avoidance.review(variant.closed, variant.effect));
                let answer = avoided(avoidance, &review, file);
                last = Some((avoidance, review));
                answer
            }
            Certificate::NotFound(nothing) => json!({
                "avoided": false,
                "why": nothing.why.to_string(),
                "searched": searched(&nothing.searched),
            }),
        };
        (format!("{delay:.1}"), answer)
    });
    Value::Object(all.collect())
}

fn avoided(avoidance: &EvasiveTrajectory, review: &EvasiveReview, file: Option<String>) -> Value {
    let manoeuvre = match avoidance.found {
        Finder::Manoeuvre(m) => Some(json!({
            "acceleration": m.acceleration,
            "until_speed": m.until,
            "offset": m.offset,
            "grip": m.grip,
        })),
        Finder::Unchanged | Finder::Planner(_) => None,
    };
    json!({
        "avoided": true,
        "trajectory": file,
        // Who drives on as if nothing had changed departs from nothing.
        "departs_after_step": (avoidance.found != Finder::Unchanged).then_some(avoidance.reaction),
        "found_by": avoidance.found.to_string(),
        "manoeuvre": manoeuvre,
        "ends": drive(&avoidance.drive),
        "max_acceleration": review.acceleration,
        "rules_broken": review.broken(),
        "rules_undecided": review.undecided(),
        "leaves_roadway_step": review.leaves_roadway,
        "searched": searched(&avoidance.searched),
    })
}

fn searched(searched: &SearchEffort) -> Value {
    json!({
        "manoeuvres": searched.manoeuvres,
        "drives": searched.drives,
        "cycles": searched.cycles,
        "candidates": searched.candidates,
        "refused": searched.refused,
        "words": searched.to_string(),
    })
}

/// A refusal: reason, step, limit and value with unit, and whose motion it was.
#[must_use]
pub fn refusal(refusal: &Refusal) -> Value {
    json!({
        "reason": refusal.reason.name(),
        "step": refusal.step,
        "limit": refusal.limit,
        "value": refusal.value,
        "unit": refusal.reason.unit(),
        "words": refusal.to_string(),
        "attacker": refusal.attacker,
        "manoeuvre": refusal.manoeuvre,
    })
}
