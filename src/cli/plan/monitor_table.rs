//! What monitors said of drives, in the table: columns, and the line below.

use serde_json::Value;

use super::driven::median;
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

/// The cells of these columns, of what [`super::monitor::document`] says.
pub fn cells(report: &Value) -> [String; 7] {
    let number = |key: &str, decimals: usize| {
        let value = report[key].as_f64();
        value.map_or("-".into(), |value| format!("{value:.decimals$}"))
    };
    let warnings = report["warnings"].as_array().map_or(0, Vec::len);
    let warnings = match report["without_verdict"].as_u64() {
        None | Some(0) => warnings.to_string(),
        Some(n) => format!("{warnings} ({n} unanswered)"),
    };
    let braked = report["braked_seconds"].as_f64();
    // Drives of earlier versions have the measured latency alone.
    let latency = if report["latency_in_force_seconds"].is_null() {
        "median_latency_seconds"
    } else {
        "latency_in_force_seconds"
    };
    [
        warnings,
        number("first_warning_seconds", 1),
        number("lead_seconds", 1),
        number("false_alarms_per_minute", 1),
        number(latency, 3),
        number("first_braking_seconds", 1),
        { braked.filter(|braked| *braked > 0.0) }
            .map_or("-".into(), |braked| format!("{braked:.1}")),
    ]
}

/// What monitors said of all drives.
#[derive(Debug, Default)]
pub struct Totals {
    drives: usize,
    warnings: usize,
    false_alarms: u64,
    incidents: usize,
    leads: Vec<f64>,
    braked: usize,
    seconds: f64,
}

impl Totals {
    /// Counts a drive, of what [`super::monitor::document`] says.
    pub fn add(&mut self, report: &Value) {
        if !report.is_object() {
            return;
        }
        self.drives += 1;
        self.warnings += report["warnings"].as_array().map_or(0, Vec::len);
        self.false_alarms += report["false_alarms"].as_u64().unwrap_or(0);
        self.incidents += usize::from(report["incident"].is_string());
        self.leads.extend(report["lead_seconds"].as_f64());
        self.braked += usize::from(report["braked_steps"].as_u64().unwrap_or(0) > 0);
        self.seconds += report["braked_seconds"].as_f64().unwrap_or(0.0);
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
                output::counted(self.false_alarms as usize, "false alarm"),
                self.leads.len(),
                output::counted(self.incidents, "incident"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_latency_in_force_and_the_braking_are_shown_and_all_drives_are_summed_up() {
        let one = json!({
            "warnings": [[3, 9]], "first_warning_seconds": 0.3, "lead_seconds": 1.2, "false_alarms": 0,
            "false_alarms_per_minute": 0.0, "median_latency_seconds": 0.001, "latency_in_force_seconds": 0.4,
            "incident": "contact", "braked_steps": 7, "braked_seconds": 0.7, "first_braking_seconds": 0.3,
        });
        let wanted = ["1", "0.3", "1.2", "0.0", "0.400", "0.3", "0.7"];
        assert_eq!(cells(&one), wanted);
        let earlier = json!({
            "warnings": [], "false_alarms": 0, "median_latency_seconds": 0.002, "incident": null, "braked_steps": 0,
        });
        assert_eq!(cells(&earlier), ["0", "-", "-", "-", "0.002", "-", "-"]);
        let mut totals = Totals::default();
        totals.add(&one);
        totals.add(&earlier);
        totals.add(&Value::Null);
        let line = totals.line().unwrap_or_default();
        let wanted = "monitor: 1 warning, 0 false alarms; warned before 1 of 1 incident, median lead 1.2 s; braked in 1 drive for 0.7 s\n";
        assert_eq!(line, wanted);
        assert_eq!(Totals::default().line(), None);
    }
}
