//! What monitors said of drives, in the table: columns, and the line below.

use super::driven::median;
use super::monitor_record::MonitorRecord;
use crate::output;

/// Names of the columns of a monitor in the table.
pub const HEADER: [&str; 7] = [
    "warnings",
    "first s",
    "lead s",
    "false/min",
    "latency s",
    "brakes s",
    "braked s",
];

/// The cells of these columns.
pub fn cells(report: &MonitorRecord) -> [String; 7] {
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or("-".into(), |value| format!("{value:.decimals$}"))
    };
    let warnings = match (report.warnings.len(), report.without_verdict) {
        (warnings, 0) => warnings.to_string(),
        (warnings, n) => format!("{warnings} ({n} unanswered)"),
    };
    [
        warnings,
        number(report.first_warning_seconds, 1),
        number(report.lead_seconds, 1),
        number(report.false_alarms_per_minute, 1),
        number(report.latency_in_force_seconds, 3),
        number(report.first_braking_seconds, 1),
        number(report.braked_seconds.filter(|s| *s > 0.0), 1),
    ]
}

/// What monitors said of all drives.
#[derive(Debug, Default)]
pub struct Totals {
    drives: usize,
    warnings: usize,
    false_alarms: usize,
    incidents: usize,
    leads: Vec<f64>,
    braked: usize,
    seconds: f64,
}

impl Totals {
    /// Counts a drive.
    pub fn add(&mut self, report: &MonitorRecord) {
        self.drives += 1;
        self.warnings += report.warnings.len();
        self.false_alarms += report.false_alarms;
        self.incidents += usize::from(report.incident.is_some());
        self.leads.extend(report.lead_seconds);
        self.braked += usize::from(report.braked_steps > 0);
        self.seconds += report.braked_seconds.unwrap_or(0.0);
    }

    /// The line below the table; nothing without a monitor.
    pub fn line(mut self) -> Option<String> {
        (self.drives > 0).then(|| {
            self.leads.sort_by(f64::total_cmp);
            let lead = median(&self.leads);
            let lead = lead.map_or(String::new(), |lead| format!(", median lead {lead:.1} s"));
            let braked = match self.braked {
                0 => String::new(),
                n => format!(
                    "; braked in {} for {:.1} s",
                    output::counted(n, "drive"),
                    self.seconds
                ),
            };
            format!(
                "monitor: {}, {}; warned before {} of {}{lead}{braked}\n",
                output::counted(self.warnings, "warning"),
                output::counted(self.false_alarms, "false alarm"),
                self.leads.len(),
                output::counted(self.incidents, "incident"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latency_in_force_and_the_braking_are_shown_and_all_drives_are_summed_up() {
        let one = MonitorRecord {
            warnings: vec![[3, 9]],
            first_warning_seconds: Some(0.3),
            lead_seconds: Some(1.2),
            false_alarms_per_minute: Some(0.0),
            median_latency_seconds: Some(0.001),
            latency_in_force_seconds: Some(0.4),
            incident: Some("contact".into()),
            braked_steps: 7,
            braked_seconds: Some(0.7),
            first_braking_seconds: Some(0.3),
            ..MonitorRecord::default()
        };
        let wanted = ["1", "0.3", "1.2", "0.0", "0.400", "0.3", "0.7"];
        assert_eq!(cells(&one), wanted);
        let quiet = MonitorRecord::default();
        assert_eq!(cells(&quiet), ["0", "-", "-", "-", "-", "-", "-"]);
        let mut totals = Totals::default();
        totals.add(&one);
        totals.add(&quiet);
        let line = totals.line().unwrap_or_default();
        let wanted = "monitor: 1 warning, 0 false alarms; warned before 1 of 1 incident, median lead 1.2 s; braked in 1 drive for 0.7 s\n";
        assert_eq!(line, wanted);
        assert_eq!(Totals::default().line(), None);
    }
}
