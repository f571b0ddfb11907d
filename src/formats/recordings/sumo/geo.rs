//! Floating car data in degrees (`--fcd-output.geo`): whether it is, and where it lies in metres.

use super::fcd::{Recorded, Vehicle};
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;
use crate::recordings::utm::TransverseMercator;
use nearmiss_base::geometry::Point;

/// What a net says about where it is.
#[derive(Debug, Clone, Default)]
pub struct Location {
    /// What is added to projected places, metres.
    pub offset: (f64, f64),
    /// The projection, in the words of PROJ; `!` where there is none, and `-` for SUMO's own simple one.
    pub projection: String,
    /// West, south, east and north of it in the coordinates that it was made of: degrees, where it has a projection.
    pub original: Option<[f64; 4]>,
}

/// Metres in a degree of latitude, about; and what SUMO's simple projection takes for it and one of longitude.
const DEGREE: f64 = 111_320.0;
const SIMPLE: (f64, f64) = (111_320.0, 111_136.0);

/// Distance that has to be driven for speeds to tell the unit of places, metres.
const TELLING: f64 = 1.0;

/// Whether places are in degrees, as far as the file tells: by how far the vehicles come at their speeds, else by the
/// options in the comment at its beginning. SUMO writes metres under the option where the net has no projection.
pub fn degrees(vehicles: &[Vehicle], time_step: f64, comment: &str) -> Option<bool> {
    let all = || vehicles.iter().flat_map(|vehicle| &vehicle.seen);
    if !all().all(|seen| seen.front.x.abs() <= 180.1 && seen.front.y.abs() <= 90.1) {
        return Some(false);
    }
    let (mut driven, mut moved, mut as_degrees) = (0.0, 0.0, 0.0);
    for vehicle in vehicles {
        for pair in vehicle.seen.windows(2) {
            if pair[1].step - pair[0].step != 1 {
                continue;
            }
            let by = pair[1].front - pair[0].front;
            driven += pair[1].speed.abs() * time_step;
            moved += by.norm();
            as_degrees += (by.x * pair[0].front.y.to_radians().cos()).hypot(by.y) * DEGREE;
        }
    }
    let fits = |distance: f64| (0.3..3.0).contains(&(distance / driven));
    match () {
        () if driven < TELLING => geo_option(comment),
        () if fits(as_degrees) && !fits(moved) => Some(true),
        () if moved > driven / 100.0 => Some(false),
        () => geo_option(comment),
    }
}

/// What SUMO's options say, where they are there.
fn geo_option(comment: &str) -> Option<bool> {
    let option = comment.split("<fcd-output.geo value=\"").nth(1);
    match option.and_then(|rest| rest.split('"').next()) {
        Some(value) => Some(matches!(value, "true" | "1" | "yes" | "on" | "x" | "t")),
        None => comment.contains("<fcd-output ").then_some(false),
    }
}

/// From the places of a file to metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Placement {
    /// They are metres.
    Metres,
    /// SUMO's simple projection, and what is added.
    Simple((f64, f64)),
    /// Another one, and what is added.
    Projected(TransverseMercator, (f64, f64)),
}

impl Placement {
    /// A place in metres.
    pub fn metres(&self, place: Point) -> Point {
        let ((x, y), offset) = match self {
            Self::Metres => return place,
            Self::Simple(offset) => {
                let along = place.x * SIMPLE.0 * place.y.to_radians().cos();
                ((along, place.y * SIMPLE.1), *offset)
            }
            Self::Projected(projection, offset) => (projection.forward(place.y, place.x), *offset),
        };
        Point::new(x + offset.0, y + offset.1)
    }

    /// That of a recording with a net, and whether the net's lanes are where it is. What is assumed is noted.
    pub fn new(recorded: &Recorded, net: Option<&Location>, report: &Report) -> (Self, bool) {
        let unprojected = net.is_some_and(|net| net.projection == "!");
        let degrees = match recorded.degrees {
            // Nothing moves: then SUMO's option counts only where the net has a projection.
            Some(degrees) => degrees,
            None => {
                net.is_some_and(|net| net.is_around_in_degrees(recorded)) || is_crammed(recorded)
            }
        };
        if !degrees {
            return (Self::Metres, true);
        }
        match net.and_then(Location::placement) {
            Some(placement) => {
                report.note(format!(
                    "positions are in degrees; projected as the net is, `{}`",
                    net.map_or("", |net| net.projection.as_str())
                ));
                (placement, true)
            }
            None => {
                let plane = "positions are in degrees; on a plane in metres around their middle";
                match net {
                    None => report.note(plane),
                    Some(_) if unprojected => report.at("").warn(format!(
                        "{plane}; the net has no projection, and its lanes are left out"
                    )),
                    Some(net) => report.at("").warn(format!(
                        "{plane}; the net's projection `{}` is not read, and its lanes are left out",
                        net.projection.chars().take(80).collect::<String>()
                    )),
                }
                (Self::around(recorded), net.is_none())
            }
        }
    }

    /// On a plane around the middle of a recording.
    fn around(recorded: &Recorded) -> Self {
        let [west, south, east, north] = extent(recorded);
        let middle = (f64::midpoint(south, north), f64::midpoint(west, east));
        let plane = TransverseMercator::around(middle.0, middle.1);
        Self::Projected(plane, (0.0, 0.0))
    }
}

/// Several vehicles within less than this cannot be in metres.
const CRAMMED: f64 = 0.2;

/// Whether vehicles that are not in one place would be in each other if their places were metres.
fn is_crammed(recorded: &Recorded) -> bool {
    let [west, south, east, north] = extent(recorded);
    let size = (east - west).max(north - south);
    recorded.vehicles.len() > 1 && 0.0 < size && size < CRAMMED
}

/// West, south, east and north of all places.
fn extent(recorded: &Recorded) -> [f64; 4] {
    let all = recorded.vehicles.iter().flat_map(|vehicle| &vehicle.seen);
    let none = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    all.fold(none, |[w, s, e, n], seen| {
        let (x, y) = (seen.front.x, seen.front.y);
        [w.min(x), s.min(y), e.max(x), n.max(y)]
    })
}

/// Vehicles may be so far outside the boundary of the nodes of a net, degrees.
const BOUNDARY_TOLERANCE: f64 = 0.001;

impl Location {
    /// Whether a recording is where the net is in degrees: a few thousandths of a degree, where hardly a vehicle is by chance.
    fn is_around_in_degrees(&self, recorded: &Recorded) -> bool {
        let of = extent(recorded);
        self.projection != "!"
            && self.original.is_some_and(|b| {
                let inside = |i: usize| {
                    of[i] >= b[i] - BOUNDARY_TOLERANCE && of[i + 2] <= b[i + 2] + BOUNDARY_TOLERANCE
                };
                inside(0) && inside(1)
            })
    }

    /// How places in degrees come onto the net; `None` where its projection is not read.
    fn placement(&self) -> Option<Placement> {
        if self.projection == "-" {
            return Some(Placement::Simple(self.offset));
        }
        projection(&self.projection).map(|read| Placement::Projected(read, self.offset))
    }
}

/// A projection in the words of PROJ; `None` where it is no transverse Mercator one of WGS 84.
fn projection(words: &str) -> Option<TransverseMercator> {
    let (mut kind, mut zone, mut south) = ("", None, false);
    let mut read = TransverseMercator::around(0.0, 0.0);
    for word in words.split_whitespace() {
        let (key, value) = word
            .trim_start_matches('+')
            .split_once('=')
            .unwrap_or((word, ""));
        let number = || value.parse::<f64>().ok().filter(|n| n.is_finite());
        match key.trim_start_matches('+') {
            "proj" => kind = value,
            "zone" => zone = value.parse::<i64>().ok(),
            "south" => south = true,
            "lon_0" => read.meridian = number()?,
            "lat_0" => read.latitude = number()?,
            "k" | "k_0" => read.scale = number()?,
            "x_0" => read.origin.0 = number()?,
            "y_0" => read.origin.1 = number()?,
            "ellps" | "datum" if matches!(value, "WGS84" | "GRS80" | "NAD83") => {}
            "towgs84" if value.split(',').all(|n| n.parse() == Ok(0.0)) => {}
            "units" if value == "m" => {}
            "no_defs" | "type" | "wktext" | "vunits" | "geoidgrids" => {}
            _ => return epsg(words),
        }
    }
    match kind {
        "utm" => {
            let zone = zone.filter(|zone| (1..=60).contains(zone))?;
            Some(TransverseMercator::utm(zone, south))
        }
        "tmerc" | "etmerc" => Some(read),
        _ => None,
    }
}

/// A zone of UTM by its number: on WGS 84 in the north and south, and on ETRS 89.
fn epsg(words: &str) -> Option<TransverseMercator> {
    let lower = words.trim().to_lowercase();
    let number = lower.trim_start_matches("+init=").strip_prefix("epsg:")?;
    let number: i64 = number.parse().ok()?;
    let zone = [(32_600, false), (32_700, true), (25_800, false)];
    zone.into_iter().find_map(|(base, south)| {
        let zone = number - base;
        (1..=60)
            .contains(&zone)
            .then(|| TransverseMercator::utm(zone, south))
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::fcd::VehicleAtStep;
    use super::*;

    fn vehicle(fronts: &[(f64, f64)], speed: f64) -> Vehicle {
        let seen = fronts.iter().zip(0..).map(|(front, step)| VehicleAtStep {
            step,
            front: Point::new(front.0, front.1),
            heading: 0.0,
            speed,
            acceleration: None,
        });
        Vehicle {
            name: "a".into(),
            kind: String::new(),
            seen: seen.collect(),
        }
    }

    #[test]
    fn speeds_tell_the_unit_and_options_where_nothing_moves() {
        let geo = "<fcd-output value=\"x\"/><fcd-output.geo value=\"true\"/>";
        let plain = "<fcd-output value=\"x\"/>";
        let told = |fronts: &[(f64, f64)], speed, comment| {
            degrees(&[vehicle(fronts, speed)], 1.0, comment)
        };
        let moving_degrees = [(11.0, 48.0), (11.000_134, 48.0), (11.000_269, 48.0)];
        let moving_metres = [(11.0, 48.0), (21.0, 48.0), (31.0, 48.0)];
        for comment in ["", geo, plain] {
            assert_eq!(told(&moving_degrees, 10.0, comment), Some(true));
            assert_eq!(told(&moving_metres, 10.0, comment), Some(false));
        }
        // A crawl in metres is no drive in degrees.
        let crawl = [(11.0, 48.0), (11.2, 48.0), (11.4, 48.0), (11.6, 48.0)];
        assert_eq!(told(&crawl, 0.2, ""), None);
        assert_eq!(told(&crawl, 0.5, ""), Some(false));
        let standing = [(11.0, 48.0); 3];
        assert_eq!(told(&standing, 0.0, geo), Some(true));
        assert_eq!(told(&standing, 0.0, plain), Some(false));
        assert_eq!(told(&standing, 0.0, ""), None);
        assert_eq!(told(&[(200.0, 48.0), (210.0, 48.0)], 0.0, geo), Some(false));
    }

    #[test]
    fn projections_of_nets() {
        let utm = projection("+proj=utm +zone=32 +ellps=WGS84 +datum=WGS84 +units=m +no_defs");
        assert_eq!(utm, Some(TransverseMercator::utm(32, false)));
        assert_eq!(
            projection("EPSG:32733"),
            Some(TransverseMercator::utm(33, true))
        );
        let own = projection(
            "+proj=tmerc +lat_0=48 +lon_0=11 +k=1 +x_0=5 +y_0=0 +datum=WGS84 +units=m +no_defs",
        )
        .unwrap()
        .forward(48.0, 11.0);
        assert!((own.0 - 5.0).abs() < 1e-9 && own.1.abs() < 1e-9);
        for other in [
            "!",
            "",
            "+proj=lcc +lat_1=1",
            "+proj=tmerc +lat_0=0 +lon_0=9 +k=1 +ellps=bessel +datum=potsdam",
            "+proj=utm +zone=99",
        ] {
            assert_eq!(projection(other), None, "{other}");
        }
    }
}
