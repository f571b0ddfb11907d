//! Geometries of a GeoPackage, a header and Well-Known Binary, and their places in metres.

use std::collections::HashMap;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::plausibility::MOST_PARTS;

use super::sqlite::{Database, Record};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::utm::TransverseMercator;

/// The parts of a geometry: lines, outer rings of polygons, and points alone. East and north, or longitude and latitude.
pub type Parts = Vec<Vec<(f64, f64)>>;

/// A geometry.
#[derive(Debug, PartialEq)]
pub struct Geometry {
    /// The number of its reference system in the file.
    pub system: i32,
    pub parts: Parts,
}

/// Collections in collections, at most.
const MAX_DEPTH: usize = 4;

/// Bytes that are read from the front.
struct Reader<'b> {
    bytes: &'b [u8],
    little: bool,
}

/// Reads a geometry.
///
/// # Errors
/// It is damaged, or of a kind that maps do not have: in words.
pub fn geometry(bytes: &[u8]) -> Result<Geometry, String> {
    let mut reader = Reader {
        bytes,
        little: true,
    };
    if reader.take::<2>()? != *b"GP" {
        return Err("not a geometry of a GeoPackage".into());
    }
    let [_version, flags] = reader.take::<2>()?;
    reader.little = flags & 1 == 1;
    let system = reader.integer()?.cast_signed();
    // Its bounds, of two, three or four dimensions.
    let bounds = match flags >> 1 & 7 {
        0 => 0,
        1 => 4,
        2 | 3 => 6,
        4 => 8,
        kind => return Err(format!("bounds of unknown kind {kind}")),
    };
    for _ in 0..bounds {
        reader.take::<8>()?;
    }
    let mut parts = Parts::new();
    // A flag says that there is nothing.
    if flags & 0x10 == 0 {
        reader.parts(&mut parts, MAX_DEPTH)?;
    }
    Ok(Geometry { system, parts })
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (taken, rest) = self
            .bytes
            .split_first_chunk::<N>()
            .ok_or("the geometry ends early")?;
        self.bytes = rest;
        Ok(*taken)
    }

    fn integer(&mut self) -> Result<u32, String> {
        let bytes = self.take()?;
        Ok(if self.little {
            u32::from_le_bytes(bytes)
        } else {
            u32::from_be_bytes(bytes)
        })
    }

    fn number(&mut self) -> Result<f64, String> {
        let bytes = self.take()?;
        let number = if self.little {
            f64::from_le_bytes(bytes)
        } else {
            f64::from_be_bytes(bytes)
        };
        if number.is_finite() {
            Ok(number)
        } else {
            Err(format!("a coordinate is {number}"))
        }
    }

    /// How many things of at least so many bytes follow.
    fn count(&mut self, each: usize) -> Result<usize, String> {
        let count = self.integer()? as usize;
        if count <= self.bytes.len() / each {
            Ok(count)
        } else {
            Err(format!("{count} parts, but the geometry ends early"))
        }
    }

    fn point(&mut self, dimensions: usize) -> Result<(f64, f64), String> {
        let (x, y) = (self.number()?, self.number()?);
        for _ in 2..dimensions {
            self.take::<8>()?;
        }
        Ok((x, y))
    }

    fn line(&mut self, dimensions: usize) -> Result<Vec<(f64, f64)>, String> {
        let count = self.count(8 * dimensions)?;
        (0..count).map(|_| self.point(dimensions)).collect()
    }

    fn parts(&mut self, parts: &mut Parts, deeper: usize) -> Result<(), String> {
        let [order] = self.take::<1>()?;
        self.little = order == 1;
        let kind = self.integer()?;
        // Heights and measures: as thousands by ISO, as the highest bits elsewhere.
        let (high, plain) = (kind >> 29, kind & 0x1fff_ffff);
        let iso = match plain / 1000 {
            0 => 0,
            1 | 2 => 1,
            3 => 2,
            _ => return Err(format!("a geometry of unknown kind {kind}")),
        };
        let dimensions = 2 + iso + (high >> 2 & 1) as usize + (high >> 1 & 1) as usize;
        if high & 1 == 1 {
            self.take::<4>()?;
        }
        match plain % 1000 {
            1 => {
                let point = self.point(dimensions)?;
                parts.push(vec![point]);
            }
            2 => {
                let line = self.line(dimensions)?;
                parts.push(line);
            }
            3 => {
                let rings = self.count(4)?;
                for ring in 0..rings {
                    let line = self.line(dimensions)?;
                    // The others are holes.
                    if ring == 0 {
                        parts.push(line);
                    }
                }
            }
            4..=7 if deeper > 0 => {
                for _ in 0..self.count(5)? {
                    self.parts(parts, deeper - 1)?;
                }
            }
            other => return Err(format!("a geometry of unknown kind {other}")),
        }
        Ok(())
    }
}

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
    let read = geometry(row.bytes(1)?).map_err(|why| row.at(1).fail(why))?;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn header(flags: u8, bounds: usize) -> Vec<u8> {
        let mut bytes = vec![b'G', b'P', 0, flags];
        let system = 4326_i32;
        bytes.extend(match flags & 1 {
            1 => system.to_le_bytes(),
            _ => system.to_be_bytes(),
        });
        bytes.extend(vec![0; bounds * 8]);
        bytes
    }

    fn wkb(kind: u32, count: &[u32], numbers: &[f64]) -> Vec<u8> {
        let mut bytes = vec![1];
        bytes.extend(kind.to_le_bytes());
        bytes.extend(count.iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        bytes
    }

    #[test]
    fn lines_polygons_and_points_of_two_to_four_dimensions() {
        let read = |bytes: Vec<u8>| geometry(&bytes).unwrap().parts;
        let line = [header(1, 0), wkb(2, &[2], &[1.0, 2.0, 3.0, 4.0])].concat();
        assert_eq!(read(line), [[(1.0, 2.0), (3.0, 4.0)]]);
        for kind in [1002, 2002, 0x8000_0002] {
            let numbers = [1.0, 2.0, 9.0, 3.0, 4.0, 9.0];
            let line = [header(3, 4), wkb(kind, &[2], &numbers)].concat();
            assert_eq!(read(line), [[(1.0, 2.0), (3.0, 4.0)]], "{kind}");
        }
        let ring = wkb(3, &[1, 3], &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let mut both = wkb(6, &[2], &[]);
        both.extend(ring.repeat(2));
        let parts = read([header(5, 6), both].concat());
        assert_eq!(parts, [[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]; 2]);
        let point = [header(1, 0), wkb(3001, &[], &[5.0, 6.0, 0.0, 0.0])].concat();
        assert_eq!(read(point), [[(5.0, 6.0)]]);
        // Big-endian throughout.
        let mut big = header(0, 0);
        big.extend([0, 0, 0, 0, 1]);
        big.extend(7.0_f64.to_be_bytes());
        big.extend(8.0_f64.to_be_bytes());
        let found = geometry(&big).unwrap();
        assert_eq!((found.system, found.parts), (4326, vec![vec![(7.0, 8.0)]]));
        assert!(read(header(0x11, 0)).is_empty());
    }

    #[test]
    fn damage_is_said() {
        let why = |bytes: Vec<u8>| geometry(&bytes).unwrap_err();
        assert!(why(b"GP".to_vec()).contains("ends early"));
        assert!(why(b"XP\0\0".to_vec()).contains("not a geometry"));
        let many = [header(1, 0), wkb(2, &[u32::MAX], &[1.0, 2.0])].concat();
        assert!(why(many).contains("ends early"));
        let curve = [header(1, 0), wkb(8, &[1], &[1.0, 2.0])].concat();
        assert!(why(curve).contains("unknown kind 8"));
        let nowhere = [header(1, 0), wkb(1, &[], &[f64::NAN, 2.0])].concat();
        assert!(why(nowhere).contains("NaN"));
        // Collections in collections, without end.
        let mut deep = header(1, 0);
        deep.extend(wkb(7, &[1], &[]).repeat(1000));
        assert!(why(deep).contains("unknown kind"));
    }
}
