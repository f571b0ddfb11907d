//! What is to be noted of a variant: why nothing was tried, and what its outcome does not say.

use super::check::Gone;
use super::variant::Generated;
use crate::output;
use nearmiss_drive::generation::{Consequence, Effect};
use nearmiss_drive::simulation::{Collision, CollisionKind};

impl Generated {
    /// Why nothing was tried, where nothing was, that the original is not safe, where it is not, and contacts that do
    /// not count.
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
                output::counted(made.found.candidates, "motion"),
                reason.count,
                output::visible(&reason.worst.to_string())
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
            // Of a planner that is a process: ours plans only what the vehicle can do.
            if effect.drive.external.is_some()
                && let Some(beyond) = effect.drive.beyond_vehicle()
            {
                notes.push(format!(
                    "the planner asks for what the vehicle cannot do at {}",
                    output::counted(beyond.steps, "step")
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
            let why = output::visible(&why);
            notes.push(format!(
                "{} ended with an error of the planner: {why}",
                output::counted(count, "drive")
            ));
        }
        (!notes.is_empty()).then(|| notes.join("; "))
    }
}

impl Generated {
    /// That several were asked to attack and one does, though it reaches no collision that a good driver avoids with the
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

/// How many drives of a summary were hit from behind, and had contacts that no step shows.
pub fn contacts(from_behind: usize, between: usize) -> String {
    let lines = [
        (from_behind, "hit from behind (no effect)"),
        (between, "contact only between two time steps"),
    ];
    let lines = lines.iter().filter(|(n, _)| *n > 0);
    let line = |(n, what): &(usize, &str)| format!("{what}: {}\n", output::counted(*n, "drive"));
    lines.map(line).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_drive::simulation::ContactSide;

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
        assert_eq!(output::of_scenarios(1, 1), "the scenario");
        assert_eq!(output::of_scenarios(1, 3), "1 of 3 scenarios");
        let wanted = "hit from behind (no effect): 2 drives\n";
        assert_eq!(
            (contacts(2, 0), contacts(0, 0)),
            (wanted.into(), String::new())
        );
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
