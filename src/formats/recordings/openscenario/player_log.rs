//! What a player has recorded of a scenario: esmini's CSV, a row a step with the entities that are there.

use std::collections::BTreeMap;

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;
use nearmiss_base::geometry::{Point, Pose};

/// A state of an entity.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Seconds.
    pub time: f64,
    pub pose: Pose,
    /// m/s.
    pub speed: f64,
    /// The middle of its body, from its position, and its length and width, metres.
    pub body: (Point, f64, f64),
}

/// Reads a log; entities by name.
pub fn read(text: &str, report: &Report) -> Result<BTreeMap<String, Vec<Seen>>, ReadError> {
    let mut lines = text.lines().enumerate();
    let header = lines
        .by_ref()
        .find(|(_, line)| line.contains("TimeStamp"))
        .ok_or_else(|| {
            report.fail("no line with `TimeStamp`; not a log of esmini (--csv_logger)")
        })?;
    let names: Vec<&str> = header.1.split(',').map(str::trim).collect();
    let own: Vec<&str> = names.iter().filter_map(|n| n.strip_prefix("#1 ")).collect();
    let column = |name: &str| {
        own.iter().position(|n| n.starts_with(name)).ok_or_else(|| {
            report
                .row(header.0 + 1, name)
                .fail("no such column; write the log with esmini --csv_logger")
        })
    };
    let place = column("Entity_Name")?;
    let wanted = [
        "World_Position_X",
        "World_Position_Y",
        "World_Heading_Angle",
        "Current_Speed",
        "bb_x",
        "bb_y",
        "bb_length",
        "bb_width",
    ];
    let wanted: Vec<usize> = wanted.iter().map(|n| column(n)).collect::<Result<_, _>>()?;
    let time = names
        .iter()
        .position(|n| n.starts_with("TimeStamp"))
        .unwrap_or(1);
    let first = names.iter().position(|n| n.starts_with("#1 ")).unwrap_or(2);
    let mut all: BTreeMap<String, Vec<Seen>> = BTreeMap::new();
    for (i, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() <= first {
            continue;
        }
        let number = |at: usize| -> Result<f64, ReadError> {
            let cell = cells.get(at).copied().unwrap_or_default();
            let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| {
                let shown: String = cell.chars().take(40).collect();
                report
                    .row(i + 1, names.get(at).copied().unwrap_or("column"))
                    .fail(format!("`{shown}` is not a number"))
            })
        };
        let now = number(time)?;
        let mut at = first;
        while at + own.len() <= cells.len() {
            let name = cells[at + place];
            let mut values = [0.0; 8];
            for (value, column) in values.iter_mut().zip(&wanted) {
                *value = number(at + column)?;
            }
            let [x, y, heading, speed, bx, by, length, width] = values;
            let row = report.row(i + 1, name);
            let position = row.point(x, y)?;
            let seen = Seen {
                time: now,
                pose: Pose { position, heading },
                speed,
                body: (Point::new(bx, by), length, width),
            };
            all.entry(name.to_string()).or_default().push(seen);
            at += own.len();
            // Entities end with an empty cell.
            while cells.get(at).is_some_and(|c| c.is_empty()) {
                at += 1;
            }
        }
    }
    Ok(all)
}
