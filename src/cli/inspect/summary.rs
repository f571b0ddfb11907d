//! A scenario's contents in a few lines for people.

use crate::{output, routes};
use nearmiss_formats::{EgoError, Entry};
use nearmiss_scene::scenario::{Ego, Scenario, in_short};

pub fn summary(entry: &Entry, scenario: &Scenario, ego: &Result<Option<Ego>, EgoError>) -> String {
    let id = match scenario.header.benchmark_id.as_str() {
        "" => "(no benchmark id)",
        id => id,
    };
    let mut text = format!("{id}\n");
    let mut line = |word: &str, said: &str| text.push_str(&format!("  {word:<11} {said}\n"));
    line("file", &entry.display());
    line("hash", &scenario.hash.to_string());
    for (word, said) in scenario.summary() {
        line(word, &said);
    }
    let possible = scenario.possible_egos();
    match ego {
        Ok(Some(ego)) => {
            let (first, last) = (ego.track.steps().start, ego.track.steps().end - 1);
            line(
                "ego",
                &format!("{}, {}, steps {first} to {last}", ego.id, ego.source),
            );
            for (_, doubt) in in_short(&ego.diagnostics) {
                line("", &doubt);
            }
        }
        Ok(None) => line("ego", "no recording found"),
        Err(error) => line("ego", &format!("cannot be read: {error}")),
    }
    if possible.is_empty() {
        line("as ego", "no obstacle has a trajectory");
    } else {
        let ids: Vec<String> = possible.iter().map(i64::to_string).collect();
        line(
            "as ego",
            &format!("--ego takes obstacle {}", ids.join(", ")),
        );
    }
    text.push_str(&routes::summary(scenario));
    if scenario.diagnostics.is_empty() {
        text.push_str("  diagnostics none\n");
    }
    for (_, diagnostic) in in_short(&scenario.diagnostics) {
        text.push_str(&format!("  {diagnostic}\n"));
    }
    output::visible(&text)
}
