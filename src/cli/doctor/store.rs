//! Checks the store of runs.

use super::Finding;
use nearmiss_settings::Folders;
use nearmiss_store::Health;

const AREA: &str = "store";

pub fn look(folders: &Folders) -> Vec<Finding> {
    let path = folders.store();
    let shown = path.display();
    let other = "move it away, or set NEARMISS_DATA to another folder";
    let health = match Health::inspect(&path) {
        Ok(Some(health)) => health,
        Ok(None) => {
            let words = format!("no {shown} yet; the first question creates it");
            return vec![Finding::ok(AREA, words)];
        }
        Err(error) => return vec![Finding::problem(AREA, format!("{shown}: {error}"), other)],
    };
    let mut found = Vec::new();
    let (version, known) = (health.version, health.known);
    found.push(match version.cmp(&known) {
        std::cmp::Ordering::Greater => Finding::problem(
            AREA,
            format!("{shown} has version {version}, this program knows {known}"),
            "update nearmiss, or set NEARMISS_DATA to another folder",
        ),
        std::cmp::Ordering::Less if version > 0 => Finding::problem(
            AREA,
            format!("{shown} has version {version}, this program knows {known}"),
            other,
        ),
        _ => {
            let runs = health.runs.unwrap_or_default();
            let kib = health.bytes.div_ceil(1024);
            Finding::ok(
                AREA,
                format!("{shown}: version {version}, {kib} KiB, {runs} runs"),
            )
        }
    });
    if health.damage.is_empty() {
        found.push(Finding::ok(AREA, "quick check passed"));
    }
    for line in &health.damage {
        let todo = format!("`nearmiss runs export -o FILE` saves what can be read; then {other}");
        found.push(Finding::problem(AREA, format!("damaged: {line}"), todo));
    }
    found.push(match health.locked {
        None => Finding::ok(AREA, "it can be written"),
        Some(why) if why.contains("locked") || why.contains("busy") => Finding::warning(
            AREA,
            format!("locked by another program ({why})"),
            "runs are stored when it is done",
        ),
        Some(why) => Finding::problem(
            AREA,
            format!("not writable: {why}"),
            "runs are not stored; make it writable, or set NEARMISS_DATA to another folder",
        ),
    });
    found
}
