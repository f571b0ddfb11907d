//! Places of a map in metres: its zone of UTM, and its geometries in it.

use std::collections::HashMap;

use super::geopackage;
use super::record::Record;
use super::sqlite::Database;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::utm::TransverseMercator;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::plausibility::limits::MOST_PARTS;

/// Degrees on WGS 84.
pub const DEGREES: i64 = 4326;

/// The systems of UTM on WGS 84, northern and southern half, are these and the zone.
const NORTH: i64 = 32_600;
const SOUTH: i64 = 32_700;

/// The zone of a reference system.
pub fn zone(system: i64) -> Option<(i64, bool)> {
    [(NORTH, false), (SOUTH, true)]
        .into_iter()
        .find_map(|(base, south)| {
            let zone = system - base;
            (1..=60).contains(&zone).then_some((zone, south))
        })
}

/// The system in which the map is in metres, by its table `meta`.
pub fn projected(database: &Database) -> Result<(i64, (i64, bool)), ReadError> {
    let mut said = None;
    database.each("meta", &["key", "value"], &mut |row| {
        if row.text(0) == "projectedCoordSystem" {
            said = Some(row.text(1));
        }
        Ok(())
    })?;
    let said = said.ok_or_else(|| database.fail("table meta has no projectedCoordSystem"))?;
    let number = said.rsplit(':').next().and_then(|n| n.trim().parse().ok());
    let found = number.and_then(|system| Some((system, zone(system)?)));
    found.ok_or_else(|| {
        let said: String = said.chars().take(40).collect();
        database.fail(format!(
            "table meta, row projectedCoordSystem: `{said}` is not a zone of UTM on WGS 84, such as epsg:32611"
        ))
    })
}

/// The parts of a geometry, metres in UTM.
pub fn shape(
    row: &Record<'_>,
    systems: &HashMap<i64, i64>,
    projected: i64,
    (zone, south): (i64, bool),
) -> Result<Vec<Vec<Point>>, ReadError> {
    let read = geopackage::geometry(row.bytes(1)?).map_err(|why| row.at(1).fail(why))?;
    let number = i64::from(read.system);
    let system = systems.get(&number).copied().unwrap_or(number);
    if system != DEGREES && system != projected {
        let message = format!(
            "the reference system {system} is neither longitude and latitude (4326) nor that of the map ({projected})"
        );
        return Err(row.at(1).fail(message));
    }
    let point = |(x, y): &(f64, f64)| -> Result<Point, ReadError> {
        if system == projected {
            return row.at(1).point(*x, *y);
        }
        let middle = zone as f64 * 6.0 - 183.0;
        if y.abs() > 84.0 || (x - middle).abs() > 9.0 {
            let message =
                format!("longitude {x}, latitude {y} is not in or beside UTM zone {zone}");
            return Err(row.at(1).fail(message));
        }
        let (east, north) = TransverseMercator::utm(zone, south).forward(*y, *x);
        Ok(Point::new(east, north))
    };
    let count: usize = read.parts.iter().map(Vec::len).sum();
    if count > MOST_PARTS {
        return Err(row.at(1).fail(format!("more than {MOST_PARTS} points")));
    }
    let parts = read.parts.iter();
    parts.map(|part| part.iter().map(point).collect()).collect()
}
