//! The table of variants: one line a scenario, printed as it finishes, and what is to be noted of it.

use nearmiss_drive::generation::{Consequence, Effect};
use nearmiss_drive::simulation::{Collision, CollisionKind};
use nearmiss_formats::Entry;

use super::check::Gone;
use super::line::VariantLine;
use super::variant::Generated;
use crate::files::Labels;
use crate::output;
use crate::output::Align::{Left, Right};

/// Longer names push the columns behind them.
const WIDEST: usize = 48;

/// Below the table: what its column says.
pub const PLAUSIBILITY: &str = "plausibility: log-likelihood of the attackers' motions minus that of the recorded ones, nats/s; 0 is like them, less is stranger\n";

/// Width of the first column, and whether the header is written.
#[derive(Debug)]
pub struct Table {
    labels: Labels,
    width: usize,
    /// Most obstacles that attack together.
    together: usize,
    begun: bool,
}

impl Table {
    /// A table of these scenarios, with room for so many attackers.
    pub fn new(entries: &[Entry], together: usize) -> Self {
        let labels = Labels::new(entries);
        Self {
            width: labels.longest().clamp("scenario".len(), WIDEST),
            labels,
            together: together.max(1),
            begun: false,
        }
    }

    /// The line of a scenario, the first time with the header.
    pub fn row(&mut self, figures: &VariantLine) -> String {
        let mut text = String::new();
        if !std::mem::replace(&mut self.begun, true) {
            let cells = [
                "outcome",
                "drive ends",
                "attacker",
                "manoeuvre",
                "attacker risk",
                "avoidable",
                "plausibility",
                "took s",
                "written",
            ];
            text.push_str(&self.line("scenario", &cells));
        }
        let score = |score: Option<u8>| score.map_or("-".into(), |s| s.to_string());
        let made = figures.attacker.is_some();
        let risk = if made {
            format!(
                "{} → {}",
                score(figures.min_risk_before),
                score(figures.min_risk_after)
            )
        } else {
            "-".into()
        };
        let avoidable = match figures.latest() {
            _ if !figures.outcome.is_effective() || figures.avoidable.is_none() => "-".into(),
            Some(delay) => format!("up to {delay} s"),
            None => "not found".into(),
        };
        let plausible = figures.plausibility.map_or("-".into(), |likelihoods| {
            format!("{:+.1}", likelihoods.attacker - likelihoods.recorded)
        });
        let ids: Vec<String> = figures.ids().iter().map(i64::to_string).collect();
        let attackers = if ids.is_empty() {
            "-".into()
        } else {
            ids.join("+")
        };
        let written = figures.id.as_deref().map(output::visible);
        let taken_over = figures.taken_over.then(|| "reused".into());
        let good_driver = { figures.good_driver_note() }.filter(|_| figures.outcome.is_effective());
        let said = [written, taken_over, figures.note.clone(), good_driver];
        let said: Vec<String> = said.into_iter().flatten().collect();
        let manoeuvres = figures.manoeuvres();
        let cells = [
            figures.outcome.name(),
            figures.drive.as_deref().unwrap_or("-"),
            &attackers,
            manoeuvres.as_deref().unwrap_or("-"),
            &risk,
            &avoidable,
            &plausible,
            &format!("{:.1}", figures.seconds),
            &said.join("; "),
        ];
        let file = figures.file.as_str();
        let label = self.labels.of(&figures.scenario, file);
        text.push_str(&self.line(&label, &cells));
        text
    }

    fn line(&self, scenario: &str, cells: &[&str; 9]) -> String {
        let columns = [
            Left(self.width),
            Left(9),
            Left(10),
            // Ids of five digits, joined by +.
            Right(8.max(6 * self.together - 1)),
            Left(13 + 16 * (self.together - 1).min(1)),
            Left(13),
            Left(11),
            Right(12),
            Right(6),
        ];
        let cells: Vec<&str> = std::iter::once(scenario)
            .chain(cells.iter().copied())
            .collect();
        output::line("  ", &columns, &cells)
    }
}

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

    use nearmiss_drive::generation::{AttackerRecord, LogLikelihoods, OutcomeName};
    use nearmiss_drive::simulation::ContactSide;

    use super::*;

    fn attacker(id: i64, manoeuvre: &str) -> AttackerRecord {
        AttackerRecord {
            id,
            manoeuvre: manoeuvre.into(),
            ..AttackerRecord::default()
        }
    }

    #[test]
    fn a_row_says_how_the_drive_ended_and_what_is_to_be_noted() {
        let avoidable = [("0.0", true), ("0.5", true), ("1.0", false)];
        let mut line = VariantLine {
            scenario: "a".into(),
            outcome: OutcomeName::NearMiss,
            attacker: Some(7),
            attackers: Some(vec![attacker(7, "cut-in")]),
            min_risk_before: Some(1),
            min_risk_after: Some(0),
            avoidable: Some(avoidable.map(|(delay, is)| (delay.into(), is)).into()),
            plausibility: Some(LogLikelihoods {
                attacker: -4.5,
                recorded: 4.0,
            }),
            id: Some("B_T-2".into()),
            note: Some("not safe as it is".into()),
            drive: Some("off_road".into()),
            taken_over: true,
            seconds: 1.25,
            ..VariantLine::default()
        };
        let mut table = Table::new(&[], 2);
        let text = table.row(&line);
        let rows: Vec<&str> = text.lines().collect();
        assert!(rows[0].starts_with("scenario  outcome    drive"));
        let cells: Vec<&str> = rows[1].split("  ").filter(|c| !c.is_empty()).collect();
        let cells: Vec<&str> = cells.iter().map(|c| c.trim()).collect();
        let wanted = [
            "a",
            "near_miss",
            "off_road",
            "7",
            "cut-in",
            "1 → 0",
            "up to 0.5 s",
            "-8.5",
            "1.2",
            "B_T-2; reused; not safe as it is",
        ];
        assert_eq!(cells, wanted);
        // Columns lie under their names.
        let drive = rows[0].find("drive").expect("a column");
        assert_eq!(rows[1].find("off_road"), Some(drive));
        line.attackers = Some(vec![attacker(9, "drift"), attacker(7, "cut-in")]);
        let text = table.row(&line);
        assert!(
            text.contains("9+7") && text.contains("drift + cut-in"),
            "{text}"
        );
        // Two long ids leave the columns behind them in their places.
        line.attackers = Some(vec![
            attacker(20055, "run-the-light"),
            attacker(20044, "door-to-door"),
        ]);
        let text = table.row(&line);
        let place = rows[0].find("attacker risk");
        assert_eq!(text.find("1 → 0"), place, "{text}");
    }

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
