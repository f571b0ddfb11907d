//! Floating car data as a table, which SUMO writes where the output is called `….csv`.

use super::fcd::{Collector, Recorded, Row, seconds};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::columns;
use crate::recordings::report::Report;

/// The columns that tell such a table.
const TELLING: [&str; 4] = ["timestep_time", "vehicle_id", "vehicle_x", "vehicle_y"];

/// What is used of a vehicle or person.
const USED: [&str; 8] = [
    "id",
    "type",
    "lane",
    "x",
    "y",
    "angle",
    "speed",
    "acceleration",
];

/// Whether a file that begins so has floating car data.
pub fn begins(head: &[u8]) -> bool {
    let (_, names) = columns::of(head);
    TELLING.iter().all(|name| names.iter().any(|n| n == name))
}

/// Reads a file; `file` names it in errors.
pub fn read(bytes: &[u8], file: &str) -> Result<Recorded, ReadError> {
    let report = Report::about(file);
    let (separator, names) = columns::of(bytes);
    let mut table = csv::ReaderBuilder::new()
        .delimiter(separator)
        .flexible(true)
        .from_reader(bytes);
    let place = |name: &str| names.iter().position(|n| n == name);
    let mut all = Collector::default();
    let mut rows = 0;
    let mut record = csv::StringRecord::new();
    loop {
        let more = table.read_record(&mut record);
        let line = record.position().map_or(0, csv::Position::line);
        let row = |column: &str| {
            report.row(
                usize::try_from(line).unwrap_or(0),
                if column.is_empty() {
                    String::new()
                } else {
                    format!("column {column}")
                },
            )
        };
        if !more.map_err(|error| row("").fail(error.to_string()))? {
            break;
        }
        rows += 1;
        let text = |name: &str| {
            let field = place(name).and_then(|place| record.get(place));
            field.unwrap_or_default().trim()
        };
        let wrong = |name: &str, what: &str| {
            let shown: String = text(name).chars().take(40).collect();
            row(name).fail(format!("`{shown}` is not {what}"))
        };
        let optional = |name: &str| match text(name) {
            "" => Ok(None),
            said => match said.parse::<f64>() {
                Ok(value) if value.is_finite() && value.abs() <= 1e9 => Ok(Some(value)),
                _ => Err(wrong(name, "a number")),
            },
        };
        let need = |name: &str| optional(name)?.ok_or_else(|| row(name).fail("missing"));
        let time = seconds(text("timestep_time"))
            .ok_or_else(|| wrong("timestep_time", "a time in seconds"))?;
        let fail = |message: String| row("").fail(message);
        // A row is one vehicle, or a time without any.
        if all.last_time() != Some(time) {
            all.time(time).map_err(fail)?;
        }
        for kind in ["vehicle", "person"] {
            let of = |what: &str| format!("{kind}_{what}");
            let name = text(&of("id"));
            if name.is_empty() {
                continue;
            }
            let row = Row {
                name,
                kind: text(&of("type")),
                is_person: kind == "person",
                lane: text(&of("lane")),
                front: (need(&of("x"))?, need(&of("y"))?),
                angle: need(&of("angle"))?,
                speed: need(&of("speed"))?,
                acceleration: optional(&of("acceleration"))?,
            };
            all.row(&row).map_err(fail)?;
        }
    }
    let used = |name: &str| {
        let of = |kind| {
            name.strip_prefix(kind)
                .is_some_and(|what| USED.contains(&what))
        };
        name == TELLING[0] || of("vehicle_") || of("person_")
    };
    for name in names.iter().filter(|name| !used(name)) {
        let kind = format!("column {name}");
        all.leftovers.add_times(&kind, rows, || 1);
    }
    all.finish(String::new())
        .map_err(|message| report.fail(message))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_a_vehicle_or_a_time_without_one() {
        let table = "timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;vehicle_type;vehicle_speed;vehicle_lane\n\
            0.00;a;1.00;2.00;90.00;car;3.00;e_0\n0.00;b;9.00;2.00;90.00;;3.00;f_1_0\n1.00\n2.00;a;4.00;2.00;90.00;car;3.00;e_0\n";
        assert!(begins(table.as_bytes()));
        let read = read(table.as_bytes(), "x.csv").unwrap();
        assert_eq!(read.times, [0.0, 1.0, 2.0]);
        let [a, b] = &read.vehicles[..] else { panic!() };
        assert_eq!((a.span(), b.span()), ((0, 2), (0, 0)));
        assert_eq!((&*a.kind, &*b.kind), ("car", "DEFAULT_VEHTYPE"));
        assert_eq!(read.edges.iter().collect::<Vec<_>>(), ["e", "f_1"]);
        let broken = table.replace("9.00", "9,00");
        let error = super::read(broken.as_bytes(), "x.csv")
            .err()
            .unwrap()
            .to_string();
        assert!(
            error.contains(":3") && error.contains("column vehicle_x: `9,00` is not a number"),
            "{error}"
        );
    }
}
