//! Progress of a tune: a bar for each template that is asked with, a line for each that was tried.

use crate::output;
use crate::progress::Progress;
use nearmiss_workflow::tune::TuneEvent;

/// The stage that is shown.
#[derive(Default)]
pub struct Stages {
    bar: Option<Progress>,
}

impl Stages {
    /// Shows an event.
    pub fn hear(&mut self, event: &TuneEvent<'_>) {
        match event {
            TuneEvent::Asking {
                candidate,
                part,
                done: 0,
                of,
            } => {
                let what = match candidate {
                    0 => format!("answers, base, {} part", part.name()),
                    n => format!("answers, candidate {n}, {} part", part.name()),
                };
                self.bar = Some(Progress::new(*of, &what, true));
            }
            TuneEvent::Asking { .. } => {
                if let Some(bar) = &self.bar {
                    bar.step();
                }
            }
            TuneEvent::Reflecting { .. } => self.bar = None,
            TuneEvent::Refused(refusal) => {
                self.bar = None;
                output::say(&format!(
                    "nearmiss: round {}, proposal {}: {}: {}",
                    refusal.round,
                    refusal.number,
                    or_dash(&refusal.change),
                    refusal.because
                ));
            }
            TuneEvent::Compared(candidate) => {
                self.bar = None;
                if candidate.number > 0 {
                    output::say(&format!(
                        "nearmiss: round {}, candidate {}: {}",
                        candidate.round,
                        candidate.number,
                        or_dash(&candidate.change)
                    ));
                }
            }
        }
    }
}

fn or_dash(text: &str) -> &str {
    if text.is_empty() { "–" } else { text }
}
