//! Floating car data, as SUMO writes it with `--fcd-output`: who is where at each time step.

use std::collections::{BTreeSet, HashMap};

use super::geo;
use crate::recordings::leftovers::Leftovers;
use crate::recordings::steps::Steps;
use nearmiss_base::geometry::{Point, normalize_angle};
use nearmiss_scene::scenario::plausibility::limits::{MOST_PARTS, refused_coordinate};

/// What is in a file.
pub struct Recorded {
    /// The comment at its beginning, which has SUMO's options.
    pub comment: String,
    /// Seconds.
    pub times: Vec<f64>,
    /// The steps of these times.
    pub steps: Steps,
    /// In the order in which they first appear.
    pub vehicles: Vec<Vehicle>,
    /// The edges of the lanes that vehicles are on.
    pub edges: BTreeSet<String>,
    /// Whether places are in degrees, as far as the file tells it.
    pub degrees: Option<bool>,
    /// What stands in the file and is not used.
    pub leftovers: Leftovers,
}

/// A vehicle or a person.
pub struct Vehicle {
    pub name: String,
    /// The name of its type.
    pub kind: String,
    /// In order.
    pub seen: Vec<Seen>,
}

/// A vehicle at a step.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub step: i64,
    /// The middle of its front: metres, or longitude and latitude in degrees.
    pub front: Point,
    /// Radians, counterclockwise from the x-axis.
    pub heading: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: Option<f64>,
}

impl Recorded {
    /// When the first step is, seconds.
    pub fn start(&self) -> f64 {
        self.steps.start
    }

    /// Seconds between two steps.
    pub fn time_step(&self) -> f64 {
        self.steps.time_step
    }

    /// Bytes, about.
    pub fn size(&self) -> usize {
        let states: usize = self.vehicles.iter().map(|v| v.seen.capacity()).sum();
        let each = size_of::<Vehicle>() + 64;
        self.comment.len()
            + self.times.len() * (size_of::<f64>() + size_of::<i64>())
            + self.vehicles.len() * each
            + self.edges.len() * 64
            + states * size_of::<Seen>()
    }
}

impl Vehicle {
    /// Its first and last step.
    pub fn span(&self) -> (i64, i64) {
        let step = |seen: Option<&Seen>| seen.map_or(0, |s| s.step);
        (step(self.seen.first()), step(self.seen.last()))
    }
}

/// Most states of a file.
const MOST_STATES: usize = 20 * MOST_PARTS;

/// What a file says of a vehicle at a time.
pub struct Row<'r> {
    pub name: &'r str,
    /// The name of its type; empty where the file has none.
    pub kind: &'r str,
    pub is_person: bool,
    /// The lane that it is on; empty where the file has none.
    pub lane: &'r str,
    /// As in the file.
    pub front: (f64, f64),
    /// Degrees, clockwise from north.
    pub angle: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: Option<f64>,
}

/// Puts the rows of a file together, in the order of the file.
#[derive(Default)]
pub struct Collector {
    times: Vec<f64>,
    places: HashMap<String, usize>,
    vehicles: Vec<Vehicle>,
    edges: BTreeSet<String>,
    count: usize,
    /// What stands in the file and is not used.
    pub leftovers: Leftovers,
}

impl Collector {
    /// The next time, seconds.
    ///
    /// # Errors
    /// It is not after the one before, or they are too many.
    pub fn time(&mut self, time: f64) -> Result<(), String> {
        if self.times.last().is_some_and(|last| *last >= time) {
            return Err(format!("time {time} s does not follow the one before"));
        }
        if self.times.len() == MOST_PARTS {
            return Err(format!("more than {MOST_PARTS} time steps"));
        }
        self.times.push(time);
        Ok(())
    }

    /// The time of the rows that came last; `None` before the first one.
    pub fn last_time(&self) -> Option<f64> {
        self.times.last().copied()
    }

    /// A vehicle at the last time.
    ///
    /// # Errors
    /// Its place is implausible, or there are too many.
    pub fn row(&mut self, row: &Row<'_>) -> Result<(), String> {
        self.count += 1;
        if self.count > MOST_STATES {
            return Err(format!("more than {MOST_STATES} vehicles and steps"));
        }
        let (x, y) = row.front;
        if let Some(why) = refused_coordinate(x).or_else(|| refused_coordinate(y)) {
            return Err(why);
        }
        if let Some((edge, _)) = row.lane.rsplit_once('_')
            && !self.edges.contains(edge)
        {
            self.edges.insert(edge.to_string());
        }
        let place = match self.places.get(row.name) {
            Some(place) => *place,
            None => {
                let default = ["DEFAULT_VEHTYPE", "DEFAULT_PEDTYPE"][usize::from(row.is_person)];
                self.vehicles.push(Vehicle {
                    name: row.name.to_string(),
                    kind: if row.kind.is_empty() {
                        default
                    } else {
                        row.kind
                    }
                    .to_string(),
                    seen: Vec::new(),
                });
                let place = self.vehicles.len() - 1;
                self.places.insert(row.name.to_string(), place);
                place
            }
        };
        self.vehicles[place].seen.push(Seen {
            // The place of its time, until steps are known.
            step: i64::try_from(self.times.len()).unwrap_or(i64::MAX) - 1,
            front: Point::new(x, y),
            heading: normalize_angle((90.0 - row.angle).to_radians()),
            speed: row.speed,
            acceleration: row.acceleration,
        });
        Ok(())
    }

    /// Everything, with the comment at the beginning of the file.
    ///
    /// # Errors
    /// Its times are no steps.
    pub fn finish(mut self, comment: String) -> Result<Recorded, String> {
        let steps = Steps::of(&self.times)?;
        for vehicle in &mut self.vehicles {
            for seen in &mut vehicle.seen {
                let place = usize::try_from(seen.step).unwrap_or(0);
                seen.step = steps.steps[place];
            }
        }
        Ok(Recorded {
            degrees: geo::degrees(&self.vehicles, steps.time_step, &comment),
            comment,
            times: self.times,
            steps,
            vehicles: self.vehicles,
            edges: self.edges,
            leftovers: self.leftovers,
        })
    }
}

/// A time, seconds: `12.50`, or as `--human-readable-time` writes it, `0:00:12.50` and with days `1:00:00:12.50`.
pub fn seconds(text: &str) -> Option<f64> {
    let (sign, rest) = match text.trim().strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.trim()),
    };
    let pieces: Vec<&str> = rest.split(':').collect();
    let (last, before) = pieces.split_last()?;
    let factors: &[f64] = match before.len() {
        0 => &[],
        2 => &[3600.0, 60.0],
        3 => &[86_400.0, 3600.0, 60.0],
        _ => return None,
    };
    let mut sum = last.parse::<f64>().ok().filter(|s| *s >= 0.0)?;
    for (piece, factor) in before.iter().zip(factors) {
        sum += f64::from(piece.parse::<u32>().ok()?) * factor;
    }
    Some(sign * sum).filter(|s| s.is_finite() && s.abs() <= 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_seconds_or_a_clock() {
        let all = [
            ("12.50", Some(12.5)),
            ("00:00:04.50", Some(4.5)),
            ("23:59:58", Some(86_398.0)),
            ("24:00:00", Some(86_400.0)),
            ("1:00:00:01", Some(86_401.0)),
            ("-0:00:01.00", Some(-1.0)),
            ("1:30", None),
            ("0:x:1", None),
            ("noon", None),
            ("1e300", None),
        ];
        for (text, expected) in all {
            assert_eq!(seconds(text), expected, "{text}");
        }
    }
}
