//! Calibration in a report: tables and figures of probabilities beside the truth.

use super::contents::WayTable;
use super::document::{Figure, Table};
use super::names::{self, number};
use super::{Cell, methods, plot};
use nearmiss_scene::verdict::Task;

pub(super) fn probabilities(task: Task, cells: &[&Cell]) -> Table {
    let titles = [
        "Verdicts",
        "Stated",
        "Of obstacles",
        "Of tokens",
        "Of scores",
        "Of yes or no",
        "Brier",
        "AUROC",
        "ECE",
    ];
    let caption = "Calibration of probabilities";
    let mut filled = WayTable::new(task, cells, (caption, "-calibration"), &titles);
    filled.table.notes = vec![methods::calibration()];
    for cell in cells {
        let mut row = filled.way(cell);
        row.push(cell.calibration.n().to_string());
        row.extend(cell.sources.map(|n| n.to_string()));
        row.push(number(cell.calibration.brier(), 3));
        row.push(number(cell.calibration.auroc(), 3));
        row.push(number(cell.calibration.error(), 3));
        filled.table.rows.push(row);
    }
    filled.table
}

/// The same of log probabilities, whatever the answers state beside them; nothing where none were given.
pub(super) fn token_probabilities(task: Task, cells: &[&Cell]) -> Option<Table> {
    if cells.iter().all(|cell| cell.token_calibration.n() == 0) {
        return None;
    }
    let titles = ["Verdicts", "Brier", "AUROC", "ECE"];
    let caption = "Calibration of log probabilities";
    let mut filled = WayTable::new(task, cells, (caption, "-log-probabilities"), &titles);
    filled.table.notes = vec![methods::token_calibration()];
    for cell in cells {
        let calibration = &cell.token_calibration;
        let mut row = filled.way(cell);
        row.push(calibration.n().to_string());
        row.push(number(calibration.brier(), 3));
        row.push(number(calibration.auroc(), 3));
        row.push(number(calibration.error(), 3));
        filled.table.rows.push(row);
    }
    Some(filled.table)
}

pub(super) fn calibrations(cells: &[&Cell]) -> Vec<Figure> {
    let scored = cells.iter().filter(|c| c.calibration.n() > 0);
    let figure = |cell: &&Cell| {
        let caption = names::way(&cell.way);
        Figure {
            svg: plot::calibration(
                &format!("Share of true collisions by probability: {caption}"),
                &cell.calibration,
            ),
            caption,
        }
    };
    scored.map(figure).collect()
}
