//! The table of variants: one line a scenario, printed as it finishes, and what is to be noted of it.

use nearmiss_formats::Entry;
use nearmiss_workflow::variant::VariantLine;

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
        let drivers = figures.preventability.as_ref().map(|found| found.words());
        let drivers = drivers.filter(|_| figures.outcome.is_effective());
        let said = [
            written,
            taken_over,
            figures.note.clone(),
            drivers,
            good_driver,
        ];
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

#[cfg(test)]
mod tests {

    use nearmiss_drive::generation::{AttackerRecord, LogLikelihoods, OutcomeName};

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
    fn contacts_that_do_not_count_are_summed_up() {
        assert_eq!(output::of_scenarios(1, 1), "the scenario");
        assert_eq!(output::of_scenarios(1, 3), "1 of 3 scenarios");
        let wanted = "hit from behind (no effect): 2 drives\n";
        assert_eq!(
            (contacts(2, 0), contacts(0, 0)),
            (wanted.into(), String::new())
        );
    }
}
