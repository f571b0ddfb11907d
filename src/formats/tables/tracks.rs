//! Our own table of tracks, as CSV, JSON lines or Parquet.

use std::borrow::Cow;

use nearmiss_record::{Cell, Column, Format, Kind, Row, Table, TableWriter};

use super::{Recording, TableError, WrittenTables};

/// Its columns. The reader knows a table that has just these, with their units and places in the middle of bodies.
pub const COLUMNS: [&str; 11] = [
    "time",
    "id",
    "x",
    "y",
    "heading",
    "speed",
    "acceleration",
    "length",
    "width",
    "class",
    "ego",
];

/// Kinds, units and meanings, in the same order.
const MEANINGS: [(Kind, &str, &str); 11] = [
    (Kind::Number, "s", "since step 0 of the scenario"),
    (Kind::Integer, "", "the road user"),
    (Kind::Number, "m", "the middle of the body"),
    (Kind::Number, "m", "the middle of the body"),
    (Kind::Number, "rad", "counterclockwise from the x-axis"),
    (Kind::Number, "m/s", "along the heading"),
    (Kind::Number, "m/s²", "along the heading"),
    (Kind::Number, "m", "of the body"),
    (Kind::Number, "m", "of the body"),
    (Kind::Text, "", "kind of road user, as in CommonRoad"),
    (Kind::Truth, "", "whether it is the ego"),
];

/// A row a road user and step, in these columns.
pub fn rows(recording: &Recording) -> (Table, Vec<Row>) {
    let named = COLUMNS.into_iter().zip(MEANINGS);
    let columns = named.map(|(name, (kind, unit, source))| match name {
        "time" => Column::clock(name, source),
        _ => Column::new(name, kind, unit, source),
    });
    let table = Table::new("tracks", columns.collect());
    let mut rows: Vec<Row> = Vec::new();
    for user in &recording.users {
        rows.extend(user.states.iter().map(|(step, motion)| {
            let pose = motion.pose;
            let numbers = [
                pose.position.x,
                pose.position.y,
                pose.heading,
                motion.velocity,
                motion.acceleration,
                user.length,
                user.width,
            ];
            let mut row = vec![Cell::Number(recording.time(*step)), Cell::Integer(user.id)];
            row.extend(numbers.map(Cell::finite));
            row.push(Cell::Text(Cow::Borrowed(user.kind.name())));
            row.push(Cell::Truth(user.is_ego));
            row
        }));
    }
    (table, rows)
}

pub fn write(recording: &Recording, format: Format) -> Result<WrittenTables, TableError> {
    let (table, rows) = rows(recording);
    let mut writer = TableWriter::begin(Vec::new(), format, &table)?;
    writer.write(table.encode(format, rows))?;
    Ok(WrittenTables {
        files: vec![("", writer.finish()?)],
        notes: Vec::new(),
    })
}
