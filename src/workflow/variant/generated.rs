//! The variant that was made of a scenario: what is to be noted of it, and its files.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nearmiss_base::system::counted;
use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_drive::generation::{
    Consequence, Effect, GateResult, Refusal, Selection, Variant, VariantFiles, VariantGenerator,
};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Collision, CollisionKind};
use nearmiss_formats::Entry;
use nearmiss_formats::commonroad::{self, WriteError};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::ImpactRecord;
use nearmiss_scene::scenario::identity::other_traffic;
use nearmiss_scene::scenario::{ContentHash, Scenario, Scene};
use nearmiss_study::evaluation::generating::{Authored, AuthoredRecord};
use serde_json::json;

use super::{AttackRequest, GenerationSettings, VariantLine};
use crate::generate::{AttackSource, AttackWriter, GenerateRequest, generate};
use crate::plan::{PlanError, PreparedPlan};

/// The generated variant of one scenario.
#[derive(Debug)]
pub struct Generated {
    /// The scenario's name.
    pub name: String,
    /// Its file, or that it is bundled.
    pub file: String,
    /// The original with the ego's drive in it.
    pub workshop: VariantGenerator,
    /// Everything that was tried, and what was taken.
    pub made: Selection,
    /// A model's output and consumption.
    pub authored: Option<Authored>,
    /// How long it took.
    pub took: Duration,
    /// The settings it was generated with.
    pub settings: GenerationSettings,
    /// Drivers that are wished to avoid the contact.
    pub preventable_by: Vec<&'static str>,
}

impl Generated {
    /// A model's choice, output and consumption.
    #[must_use]
    pub fn author(&self) -> Option<AuthoredRecord> {
        let taken = self.made.chosen.as_ref().map(|chosen| &chosen.attack);
        let authored = self.authored.as_ref()?;
        Some(authored.record(taken))
    }

    /// Why motions were refused: of a model's answers all reasons, of a search's motions the first.
    #[must_use]
    pub fn refusals(&self) -> Vec<Refusal> {
        match &self.authored {
            Some(authored) => authored.refusals(),
            None => self.made.found.refused.clone(),
        }
    }

    /// Makes a variant of a scenario: `settings` are those of the request for its planning problem, `model` writes the
    /// attack in place of the search. Nothing where `cancel` asked for an end before it was done.
    ///
    /// # Errors
    /// See [`generate`].
    pub fn make(
        entry: &Entry,
        prepared: PreparedPlan,
        (attack, settings): (&AttackRequest, GenerationSettings),
        model: Option<&dyn AttackWriter>,
        cancel: &Cancel,
    ) -> Result<Option<Self>, PlanError> {
        let began = Instant::now();
        let prepared = prepared.driven_by(attack.planner.clone());
        let request = GenerateRequest {
            prepared: &prepared,
            attackers: &attack.only,
            wish: attack.wish.as_ref(),
            delay: attack.effort.delay,
            style: attack.style,
            source: match model {
                Some(model) => AttackSource::Model(model),
                None => AttackSource::Search(&attack.effort),
            },
        };
        let generation = generate(&request, cancel, &mut |_| {})?;
        Ok(generation.map(|generation| Self {
            name: visible(&entry.name).into_owned(),
            file: entry.display(),
            workshop: generation.workshop,
            made: generation.made,
            authored: generation.authored,
            took: began.elapsed(),
            settings,
            preventable_by: { attack.wish.as_ref() }
                .map_or_else(Vec::new, |wish| wish.preventable_by.clone()),
        }))
    }

    /// The motions that were chosen `by` their author, with all that is known of them; nothing where none has passed the gate.
    #[must_use]
    pub fn variant<'a>(&'a self, by: &'a str) -> Option<Variant<'a>> {
        let chosen = self.made.chosen.as_ref()?;
        Some(Variant {
            file: &self.file,
            closed: &self.workshop.closed,
            change: &chosen.attack.change,
            asked: &chosen.attack.asked,
            effect: chosen.attack.effect.as_ref()?,
            avoidability: &chosen.avoidability,
            refusals: &[],
            by,
            author: None,
            made: None,
        })
    }

    /// The changed scenario as it would be saved in an empty folder, with the ego's drive in it; nothing where no motion has
    /// passed the gate.
    ///
    /// # Errors
    /// The scenario cannot be written as CommonRoad.
    pub fn scene(&self, by: &str) -> Result<Option<Scene>, WriteError> {
        let Some(variant) = self.variant(by) else {
            return Ok(None);
        };
        let original = &variant.closed.scenario().header.benchmark_id;
        let mut scenario = variant.scenario(&other_traffic(original, 1));
        scenario.hash = ContentHash::digest(&commonroad::write(&scenario)?);
        let driver = variant.closed.driver();
        let ego = variant
            .effect
            .drive
            .ego(driver.problem(), driver.settings());
        Ok(Some(Scene::new(Arc::new(scenario), ego)))
    }

    /// Saves what was made, with its line for runs that continue this one, under the first id that is free in `folder`,
    /// which exists; nothing where no motion has passed the gate.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn save(&self, folder: &Path, line: &VariantLine) -> Result<Option<VariantFiles>, String> {
        let Some(variant) = self.variant(&line.by) else {
            return Ok(None);
        };
        // The search has asked the gate; nothing is written that it does not let through here, too.
        if let Err(refusals) = self.workshop.gate().check_joint(variant.change, None) {
            return Err(format!(
                "{}: internal error: the chosen motion does not pass the gate ({}); not written",
                self.file, refusals[0]
            ));
        }
        let made = json!({
            "settings": self.settings,
            // The manifest has the rejected motions itself.
            "line": VariantLine { rejected: None, ..line.clone() },
        });
        let author = self.author().map(|author| json!(author));
        let variant = Variant {
            refusals: &self.refusals(),
            author: author.as_ref(),
            made: Some(&made),
            ..variant
        };
        let id = variant.free_id(folder);
        let saved = variant.save(folder, &id, false);
        saved.map(Some).map_err(|error| error.to_string())
    }
}

impl Generated {
    /// That drivers which are wished to avoid it do not: a wish orders what is found, it forces nothing.
    #[must_use]
    pub fn unmet(&self, found: &PreventabilityRecord) -> Option<String> {
        if !self.preventable_by.is_empty() && found.closing_speed.is_none() {
            return Some("preventable-by is not met: the ego avoids it itself".into());
        }
        let verdicts = self.preventable_by.iter().filter_map(|id| found.by(id));
        let words = verdicts.filter(|verdict| !verdict.avoids()).map(|verdict| {
            let does_not = || format!("{} does not avoid it", verdict.driver);
            verdict.why_undecided().unwrap_or_else(does_not)
        });
        let words: Vec<String> = words.collect();
        (!words.is_empty()).then(|| format!("preventable-by is not met: {}", words.join(", ")))
    }

    /// Why nothing was tried, where nothing was, that the original is not safe, where it is not, and contacts that do
    /// not count.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        if let Some(collision) = self.workshop.unsafe_already() {
            return Some(format!("not safe as recorded: the ego touches {collision}"));
        }
        let mut notes = Vec::new();
        let made = &self.made;
        if made.found.candidates == 0 && made.chosen.is_none() {
            let stopped = self.authored.as_ref().is_some_and(|a| a.stopped.is_some());
            let wish = self.settings.wish.as_deref();
            let why = if stopped {
                "the model gave no motion".into()
            } else {
                self.workshop.why_untried(&self.settings.attacker, wish)
            };
            notes.push(why);
        }
        if let Some(reason) = made.found.all_refused() {
            notes.push(format!(
                "all {} were rejected, {} of them: {}",
                counted(made.found.candidates, "motion"),
                reason.count,
                visible(&reason.worst.to_string())
            ));
        }
        let lowest = self.workshop.closed.baseline().lowest();
        if let Some(lowest) = lowest.filter(|_| !self.workshop.is_safe()) {
            notes.push(format!(
                "not safe as recorded: the worst risk score is {lowest} (0 = collision)"
            ));
        }
        let effect = made.chosen.as_ref().and_then(|c| c.attack.effect.as_ref());
        if let Some(effect) = effect {
            notes.extend(uncounted(effect));
            let impact = effect
                .impact
                .as_ref()
                .filter(|_| uncounted(effect).is_none());
            notes.extend(impact.map(|impact| ImpactRecord::from(impact).to_string()));
            // Of a planner that is a process: ours plans only what the vehicle can do.
            if effect.drive.external.is_some()
                && let Some(beyond) = effect.drive.beyond_vehicle()
            {
                notes.push(format!(
                    "the planner asks for what the vehicle cannot do at {}",
                    counted(beyond.steps, "step")
                ));
            }
            let between = effect.contact.filter(|contact| contact.between);
            notes.extend(between.map(|contact| between_words(&contact)));
            let original = self.workshop.closed.scenario();
            let gone = effect.attackers.iter().filter_map(|attacker| {
                let gone = Gone::after(attacker.obstacle, attacker.until, original)?;
                Some(format!("attacker {} {gone}", attacker.obstacle))
            });
            notes.extend(gone);
        }
        notes.extend(self.alone_after_all());
        if let Some((count, why)) = made.found.planner_errors() {
            let why = visible(&why);
            notes.push(format!(
                "{} ended with an error of the planner: {why}",
                counted(count, "drive")
            ));
        }
        (!notes.is_empty()).then(|| notes.join("; "))
    }
}

impl Generated {
    /// That several were asked to attack and one does, though it reaches no collision that an ideal driver avoids with the
    /// reaction time that was asked for.
    fn alone_after_all(&self) -> Option<String> {
        let chosen = self.made.chosen.as_ref()?;
        let effect = chosen.attack.effect.as_ref()?;
        let asked = self.settings.attackers;
        let survived = chosen.avoidability.at(self.settings.survive);
        let best =
            matches!(effect.consequence, Consequence::Collision(_)) && survived == Some(true);
        (asked > 1 && effect.attackers.len() == 1 && !best)
            .then(|| "no second attacker makes it worse".into())
    }
}

/// A contact at the end of the drive that is no consequence of the attack.
fn uncounted(effect: &Effect) -> Option<String> {
    let contact = effect.contact?;
    let counts = matches!(effect.consequence, Consequence::Collision(_));
    (!counts).then(|| contact_words(&contact))
}

fn contact_words(contact: &Collision) -> String {
    let (with, step) = (contact.with, contact.step);
    match contact.kind() {
        CollisionKind::RearEnded => {
            format!("hit from behind by {with} at step {step}: no effect")
        }
        _ => format!("touched by {with}, which does not attack, at step {step}: no effect"),
    }
}

/// That the steps do not show the contact.
fn between_words(contact: &Collision) -> String {
    let (with, step) = (contact.with, contact.step);
    format!(
        "contact with {with} only between steps {} and {step}",
        step - 1
    )
}

/// An obstacle that vanishes before its recorded motion ends: no limit is broken by that, and no road user can do it.
#[derive(Debug, Clone, Copy)]
pub struct Gone {
    /// The first step at which it is not there any more.
    pub from: i64,
    /// The last step of its recording.
    recorded: i64,
    /// How much earlier that is, steps.
    early: i64,
    /// The same as a time.
    pub seconds: f64,
}

impl Gone {
    /// Of a motion that the gate lets through.
    #[must_use]
    pub fn of(judged: &GateResult, original: &Scenario) -> Option<Self> {
        let early = judged.verdict.as_ref().ok()?.early;
        Self::early(judged.change.obstacle, early, original)
    }

    /// Of an obstacle whose new motion ends with step `until`.
    #[must_use]
    pub fn after(id: i64, until: i64, original: &Scenario) -> Option<Self> {
        let recorded = original.obstacle(id)?.track().steps().end - 1;
        Self::early(id, recorded - until, original)
    }

    fn early(id: i64, early: i64, original: &Scenario) -> Option<Self> {
        let obstacle = original.obstacle(id)?;
        let recorded = obstacle.track().steps().end - 1;
        (early > 0).then(|| Self {
            from: recorded - early + 1,
            recorded,
            early,
            seconds: early as f64 * original.dt(),
        })
    }
}

impl std::fmt::Display for Gone {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let steps = if self.early == 1 { "step" } else { "steps" };
        write!(
            f,
            "is gone from step {} on, {} {steps} ({:.1} s) before its recording ends at step {}",
            self.from, self.early, self.seconds, self.recorded
        )
    }
}

#[cfg(test)]
mod tests {
    use nearmiss_drive::simulation::ContactSide;

    use super::*;

    #[test]
    fn contacts_that_do_not_count_are_named_with_obstacle_and_step() {
        let contact = Collision {
            step: 54,
            with: 30661,
            between: false,
            ego: ContactSide::Rear,
            other: ContactSide::Front,
            is_possible: false,
        };
        assert_eq!(
            contact_words(&contact),
            "hit from behind by 30661 at step 54: no effect"
        );
        let side = Collision {
            ego: ContactSide::Left,
            ..contact
        };
        assert!(contact_words(&side).starts_with("touched by 30661, which does not attack"));
        assert_eq!(
            between_words(&Collision {
                with: 7,
                step: 80,
                between: true,
                ..contact
            }),
            "contact with 7 only between steps 79 and 80"
        );
    }
}
