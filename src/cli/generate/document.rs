//! The line of a variant, from what was generated.

use std::collections::BTreeMap;

use super::line::{
    ComparedSamples, ExternalPlannerRecord, GoodDriver, RankedAttacker, VariantLine,
};
use super::variant::Generated;
use crate::output;
use crate::plan::PlannerFailure;
use crate::row_file::short_hash;
use nearmiss_drive::generation::{
    Attack, AttackerRecord, Avoidability, ClosedLoop, Effect, LogLikelihoods, OutcomeName,
    Plausibility, Refusal, VariantFiles, attacker,
};
use nearmiss_study::evaluation::generating::{Authored, ChosenBy};

impl VariantLine {
    /// The same, saved in these files.
    pub fn saved_as(mut self, saved: &VariantFiles) -> Self {
        let path = |path: &std::path::Path| Some(output::visible(&path.display().to_string()));
        self.variant = path(&saved.scenario);
        self.ego = path(&saved.ego);
        self.id = Some(saved.id.clone());
        self
    }

    /// That of a variant that is not saved yet, without its rejected motions.
    pub fn new(generated: &Generated, by: &str) -> Self {
        let made = &generated.made;
        let workshop = &generated.workshop;
        let chosen = made.chosen.as_ref();
        let effect = chosen.and_then(|c| c.attack.effect.as_ref());
        let contact = effect.and_then(|e| e.contact);
        let main = chosen.zip(effect);
        let main = main.and_then(|(c, effect)| c.attack.asked.get(effect.main));
        let baseline = workshop.closed.baseline();
        let driver = workshop.closed.driver();
        let planner = driver
            .external()
            .map_or("nearmiss", |planner| planner.name());
        let plausible = chosen.and_then(|c| workshop.plausibility(&c.attack.change));
        let driven = made.found.attacks.iter().filter(|a| a.effect.is_some());
        let process = baseline.drive().external.as_ref();
        let broken = effect.filter(|effect| effect.breaks_planner());
        let broken = broken.and_then(|effect| effect.drive.external.as_ref());
        Self {
            scenario: generated.name.clone(),
            file: generated.file.clone(),
            hash: short_hash(&workshop.closed.scenario().hash),
            by: by.into(),
            outcome: effect.map_or(OutcomeName::None, |e| (&e.consequence).into()),
            attacker: effect.map(|e| e.main().obstacle),
            attackers: chosen.map(|c| attackers(generated, &c.attack)),
            manoeuvre: main.map(|motion| motion.name().into()),
            asked: main.map(Into::into),
            from_step: effect.map(|e| e.from),
            until_step: chosen.and_then(|c| c.attack.change.until_step()),
            min_risk_before: effect.map_or(baseline.lowest(), |e| e.lowest_before()),
            min_risk_after: effect.map_or(baseline.lowest(), |e| e.lowest_after()),
            min_risk_of_anyone_before: baseline.lowest(),
            min_risk_of_anyone_after: effect.map_or(baseline.lowest(), |e| e.anyone_after),
            min_distance: effect.and_then(Effect::distance),
            collision_with: contact.map(|c| c.with),
            collision_step: contact.map(|c| c.step),
            collision_kind: contact.map(|c| c.kind().name().into()),
            ego_side: contact.map(|c| c.ego.name().into()),
            other_side: contact.map(|c| c.other.name().into()),
            touched_after_step: effect.and_then(Effect::touched_after_step),
            avoidable: { chosen.filter(|c| c.avoidability.is_looked_for()) }
                .map(|c| avoidable(&c.avoidability)),
            good_driver: { chosen.zip(effect) }
                .and_then(|(c, effect)| GoodDriver::new(&workshop.closed, &c.avoidability, effect)),
            style: workshop.style().name().into(),
            plausibility: plausible.as_ref().map(|(own, _)| likelihoods(own)),
            motion_samples: plausible.as_ref().map(|(own, recorded)| ComparedSamples {
                attacker: own.samples.clone(),
                recorded: recorded.samples().clone(),
            }),
            note: generated.note(),
            safe_before: workshop.is_safe(),
            baseline: baseline.drive().outcome.name().into(),
            drive: effect.map(|e| e.drive.outcome.name().into()),
            planner: output::visible(planner),
            external_planner: process.map(|report| ExternalPlannerRecord {
                name: output::visible(&report.name),
                version: output::visible(&report.version),
                failure: broken.and_then(|report| {
                    let fault = report.fault?;
                    Some(PlannerFailure::new(
                        fault,
                        report.fault_step,
                        &report.stderr,
                    ))
                }),
            }),
            reference_ranking: ranking(generated),
            candidates: made.found.candidates,
            passed: made.found.attacks.len(),
            driven: driven.count(),
            refused: refused(&made.found.refused),
            model: generated.author(),
            seconds: (generated.took.as_secs_f64() * 1e3).round() / 1e3,
            ..Self::default()
        }
    }
}

/// Log-likelihood of the attackers' motions, and that of recorded ones on average.
fn likelihoods(own: &Plausibility) -> LogLikelihoods {
    LogLikelihoods {
        attacker: own.log_likelihood,
        recorded: own.recorded,
    }
}

/// What each attacker does, how near it comes, and how plausible it is.
fn attackers(generated: &Generated, attack: &Attack) -> Vec<AttackerRecord> {
    let effects = attack.effect.iter().flat_map(|effect| &effect.attackers);
    let all = effects.zip(attack.acts()).map(|(effect, (asked, change))| {
        let own = generated
            .workshop
            .plausibility_of(std::slice::from_ref(change));
        AttackerRecord {
            plausibility: own.map(|(own, _)| likelihoods(&own)),
            ..AttackerRecord::new(effect, asked)
        }
    });
    all.collect()
}

/// Who could reach the ego with the least change, by the reference.
fn ranking(generated: &Generated) -> Vec<RankedAttacker> {
    let ranked = generated.workshop.on(|ground| attacker::rank(ground.stage));
    let ranked = ranked.unwrap_or_default().into_iter();
    let ranked = ranked.map(|c| RankedAttacker {
        id: c.obstacle,
        acceleration: c.acceleration,
        step: c.step,
        distance: c.distance,
        near: c.near,
        behind: c.behind,
        reaches: c.reaches,
    });
    ranked.collect()
}

/// Notes on a model's work beside the table.
pub fn authoring_notes(authored: &Authored) -> Vec<String> {
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

impl GoodDriver {
    /// The one with the longest reaction time who survives.
    fn new(closed: &ClosedLoop, avoidability: &Avoidability, effect: &Effect) -> Option<Self> {
        let (delay, way) = avoidability.latest()?;
        let review = way.review(closed, effect);
        let names = |rules: Vec<&'static str>| rules.into_iter().map(String::from).collect();
        Some(Self {
            reaction_time: delay,
            drive: way.drive.outcome.name().into(),
            found_by: way.found.to_string(),
            max_acceleration: Some(review.acceleration),
            rules_broken: names(review.broken()),
            rules_undecided: names(review.undecided()),
            leaves_roadway_step: review.leaves_roadway,
        })
    }
}

fn avoidable(avoidability: &Avoidability) -> BTreeMap<String, bool> {
    let all = avoidability.certificates.iter();
    all.map(|(delay, certificate)| (format!("{delay:.1}"), certificate.avoidance().is_some()))
        .collect()
}

/// How many motions were refused for each reason; of each motion the first counts.
fn refused(refusals: &[Refusal]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for refusal in refusals {
        *counts.entry(refusal.reason.name().into()).or_default() += 1;
    }
    counts
}
