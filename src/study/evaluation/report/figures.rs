//! The figures of a report: what is right as bars, confusion matrices, calibration.

use super::document::Figure;
use super::{Cell, names, plot};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;

pub(super) fn bars(task: Task, cells: &[&Cell]) -> Figure {
    let bar = |cell: &&Cell| plot::Bar {
        name: names::way(&cell.way),
        value: cell.right_of_all,
        interval: cell.right_of_all_ci,
        other: cell.way.model == judge::MODEL,
    };
    let title = format!(
        "Right of all asked with intervals of 95 %, {} task",
        task.name()
    );
    Figure {
        svg: plot::bars(&title, &cells.iter().map(bar).collect::<Vec<_>>()),
        caption: String::new(),
    }
}

pub(super) fn matrices(cells: &[&Cell]) -> Vec<Figure> {
    let figure = |cell: &&Cell| {
        let aside = match cell.unparsed + cell.failed + cell.unasked {
            0 => String::new(),
            aside => format!("; {aside} without a verdict"),
        };
        let caption = format!("{}{aside}", names::way(&cell.way));
        Figure {
            svg: plot::confusion(
                &format!("Truth in rows, verdict in columns: {caption}"),
                &cell.confusion,
            ),
            caption,
        }
    };
    cells.iter().map(figure).collect()
}

pub(super) fn calibrations(cells: &[&Cell]) -> Vec<Figure> {
    let scored = cells.iter().filter(|c| c.calibration.fit.n > 0);
    let figure = |cell: &&Cell| {
        let caption = names::way(&cell.way);
        Figure {
            svg: plot::calibration(
                &format!("Share of true collisions by probability: {caption}"),
                &cell.calibration.fit.bins,
            ),
            caption,
        }
    };
    scored.map(figure).collect()
}
