//! Checks a variant from another source against its original: all findings of the gate.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use crate::open::resolved;
use crate::{Failure, Outcome, output};
use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_drive::generation::{
    AttackStyle, Gate, MOST_ATTACKERS, Refusal, RefusalRecord, attacked_planner,
};
use nearmiss_formats::Entry;
use nearmiss_workflow::variant::Gone;
use nearmiss_workflow::{VariantOrigin, VariantProofs, verify_variant};

/// Files round to four digits, mostly: half of the last one.
const ROUNDING: f64 = 5e-5;

/// Exports for simulators move places by 0.1 mm, and add what is relative: half a digit more.
const SIMULATOR_ROUNDING: f64 = 1.5e-4;

/// What the gate finds, for programs.
#[derive(Serialize, JsonSchema)]
pub struct CheckDocument {
    /// Whether the variant passes the gate and what its manifest claims holds.
    passed: bool,
    /// Whose limits it is held to: human or limit.
    style: &'static str,
    rejected: Vec<RefusalRecord>,
    /// Changed motions: obstacle, first_changed_step, passed, rejected and more.
    changed: Vec<CheckedMotion>,
    /// What the manifest beside the variant claims, verified; null without one.
    manifest: Option<CheckedManifest>,
}

/// The files that a manifest names, and the drives of its ideal drivers.
#[derive(Serialize, JsonSchema)]
struct CheckedManifest {
    /// Files whose SHA-256 was compared.
    files: usize,
    /// What is wrong with them.
    changed_files: Vec<String>,
    certificates: Vec<CheckedCertificate>,
    /// Which drivers avoid its contact or near miss, looked at anew; null where that is not what the manifest says.
    preventability: Option<PreventabilityRecord>,
    /// Why it is not.
    preventability_fault: Option<String>,
}

/// An ideal driver's drive: it has to touch no obstacle, at the steps and between them, and to stay on the road.
#[derive(Serialize, JsonSchema)]
struct CheckedCertificate {
    /// Seconds.
    reaction_time: String,
    file: String,
    passed: bool,
    /// What is wrong with it.
    fault: Option<String>,
}

impl CheckedManifest {
    fn of(proofs: &VariantProofs) -> Self {
        let certificates = proofs.certificates.iter().map(|one| CheckedCertificate {
            reaction_time: one.delay.clone(),
            file: one.file.clone(),
            passed: one.result.is_ok(),
            fault: one.result.clone().err(),
        });
        let drivers = proofs.drivers.as_ref();
        Self {
            files: proofs.files,
            changed_files: proofs.changed.clone(),
            certificates: certificates.collect(),
            preventability: drivers.and_then(|found| found.clone().ok()),
            preventability_fault: drivers.and_then(|found| found.clone().err()),
        }
    }
}

/// A changed motion.
#[derive(Serialize, JsonSchema)]
struct CheckedMotion {
    obstacle: i64,
    first_changed_step: i64,
    ends_early: Option<i64>,
    gone_from_step: Option<i64>,
    gone_seconds_early: Option<f64>,
    passed: bool,
    rejected: Vec<RefusalRecord>,
}

/// Says what is wrong with `variant` beside the one scenario of `entries`.
pub fn run(
    entries: &[Entry],
    variant: &Path,
    (style, attackers): (Option<AttackStyle>, Option<usize>),
    as_json: bool,
) -> Outcome {
    let [entry] = entries else {
        return Err(Failure::input(format!(
            "--check compares a variant with one scenario, not {}",
            entries.len()
        )));
    };
    let original = entry.read().map_err(Failure::input)?;
    let variant_entry = Entry::of_argument(&resolved(variant)?);
    let changed = variant_entry.read().map_err(Failure::input)?;
    let is_commonroad = changed.header.other_format.is_none();
    let gate = Gate::new(&original).rounded_to(if is_commonroad {
        ROUNDING
    } else {
        SIMULATOR_ROUNDING
    });
    // What is wrong with it is said below, as one of the proofs.
    let made = VariantOrigin::read(&variant_entry).ok().flatten();
    let made = made.and_then(|origin| origin.style());
    let (style, whence) = match (style, made) {
        (Some(style), _) => (style, "--style"),
        (None, Some(style)) => (style, "of the manifest beside it"),
        (None, None) => (
            AttackStyle::Limit,
            "no manifest beside it; --style human holds it to what people do",
        ),
    };
    let judged = format!("held to the limits of style {style} ({whence})");
    let gate = gate
        .of_style(style)
        .with_attackers(attackers.unwrap_or(MOST_ATTACKERS));
    let found = gate.compare(&changed, None);
    let proofs = verify_variant(variant);
    let manifest = variant.with_extension("json");
    // A manifest is of the CommonRoad file, which an export may lie beside.
    if proofs.is_none() && is_commonroad && manifest.is_file() {
        return Err(Failure::input(format!(
            "{}: not a manifest of {}: it is damaged, or of another variant; restore it, or move it away to check the motion alone",
            manifest.display(),
            variant.display()
        )));
    }
    if as_json {
        let motions = found.changed.iter().map(|one| {
            let wrong = one.verdict.as_ref().err();
            let rejected = wrong
                .into_iter()
                .flatten()
                .map(|r| RefusalRecord::from(&r.clone().about(one.change.obstacle, None)));
            let gone = Gone::of(one, &original);
            CheckedMotion {
                obstacle: one.change.obstacle,
                first_changed_step: one.from,
                ends_early: one.verdict.as_ref().ok().map(|p| p.early),
                gone_from_step: gone.map(|gone| gone.from),
                gone_seconds_early: gone.map(|gone| gone.seconds),
                passed: wrong.is_none(),
                rejected: rejected.collect(),
            }
        });
        output::document(&CheckDocument {
            passed: found.passed() && proofs.as_ref().is_none_or(VariantProofs::hold),
            style: style.name(),
            rejected: found.refusals.iter().map(RefusalRecord::from).collect(),
            changed: motions.collect(),
            manifest: proofs.as_ref().map(CheckedManifest::of),
        })?;
    } else {
        let mut words = format!("{judged}\n");
        if let Some(planner) = attacked_planner(&changed) {
            let planner = output::visible(planner);
            words.push_str(&format!("attacked planner: {planner}\n"));
        }
        let line = |refusal: &Refusal| format!("  {}\n", output::visible(&refusal.to_string()));
        for refusal in &found.refusals {
            words.push_str(&line(refusal));
        }
        for one in &found.changed {
            let id = one.change.obstacle;
            match &one.verdict {
                Ok(passed) => {
                    words.push_str(&format!(
                        "obstacle {id}, changed after step {}: passes; {} checked, {} left as recorded, at most {:.0} % of the friction circle{}\n",
                        one.from - 1,
                        output::counted(passed.steps, "step"),
                        passed.exempt,
                        100.0 * passed.friction,
                        // The check solves for the inputs of the vehicle, which rounded states say roughly.
                        if passed.friction >= 1.005 {
                            ", as estimated from rounded states; the drivability check passes" } else { "" },
                    ));
                    if let Some(gone) = Gone::of(one, &original) {
                        words.push_str(&format!("  NOTE: obstacle {id} {gone}\n"));
                    }
                }
                Err(refusals) => {
                    words.push_str(&format!(
                        "obstacle {id}, changed after step {}: {}\n",
                        one.from - 1,
                        output::counted(refusals.len(), "refusal")
                    ));
                    refusals.iter().for_each(|r| words.push_str(&line(r)));
                }
            }
        }
        if let Some(proofs) = &proofs {
            words.push_str(&manifest_words(proofs));
        }
        output::text(&words)?;
    }
    if !found.passed() {
        return Err(Failure::finding("the variant does not pass the gate"));
    }
    if proofs.is_none_or(|proofs| proofs.hold()) {
        Ok(())
    } else {
        Err(Failure::finding(
            "the manifest beside the variant does not hold",
        ))
    }
}

fn manifest_words(proofs: &VariantProofs) -> String {
    let mut words = match proofs.changed.len() {
        0 => format!(
            "manifest: {} as written\n",
            output::counted(proofs.files, "file")
        ),
        _ => String::new(),
    };
    for changed in &proofs.changed {
        words.push_str(&format!("manifest: {}\n", output::visible(changed)));
    }
    for one in &proofs.certificates {
        let said = match &one.result {
            Ok(steps) => format!(
                "touches nothing and stays on the road, {}",
                output::counted(*steps, "step")
            ),
            Err(fault) => output::visible(fault),
        };
        words.push_str(&format!(
            "ideal driver with a reaction time of {} s: {said}\n",
            one.delay
        ));
    }
    match &proofs.drivers {
        Some(Ok(found)) => words.push_str(&format!("{}\n", found.words())),
        Some(Err(fault)) => words.push_str(&format!("drivers: {}\n", output::visible(fault))),
        None => {}
    }
    words
}
