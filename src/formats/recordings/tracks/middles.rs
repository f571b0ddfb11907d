//! From where places of a table are to the middles of bodies, and the sizes of these.

use std::collections::BTreeMap;

use nearmiss_base::geometry::{Point, Vector, angle_between};
use nearmiss_scene::scenario::{ObstacleType, Severity};

use super::batch::shown;
use super::columns::{Convention, Role};
use super::guess::{self, HeadingForm, Pair};
use super::motion;
use super::states::signed;
use super::table::{Trust, Work};
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly;

/// So far is the middle of a body before its rear axle, in its lengths.
const REAR_AXLE: f64 = 0.28;

/// So far is it behind its front.
const FRONT: f64 = -0.5;

/// Classes that say that the class is not known.
const UNKNOWN: [&str; 4] = ["unknown", "other", "none", "nan"];

/// So many classes are named.
const MAX_CLASSES: usize = 5;

impl Work<'_> {
    /// Moves places from the front, rear axle or corner of a body to its middle; steps are `dt` seconds long, the first
    /// one is at `start`.
    pub(super) fn move_to_middles(&mut self, form: Option<HeadingForm>, start: f64, dt: f64) {
        let columns = self.columns;
        let is_corner = columns.has(Convention::Corner);
        let guesses = !is_corner && self.said.trust == Trust::Nothing;
        let ahead = if let Some(decided) = self.said.decided {
            decided.ahead
        } else if columns.has(Convention::Front) {
            Some(FRONT)
        } else if columns.has(Convention::RearAxle) {
            Some(REAR_AXLE)
        } else if guesses && form.is_some_and(|form| guess::is_front(&self.turns(form))) {
            self.report
                .note("places are those of the front: so they move in turns; moved to the middle");
            Some(FRONT)
        } else {
            if guesses {
                self.report.note(
                    "places are taken as the middles of bodies; [front], [rear-axle] or [corner] behind the column of x says otherwise",
                );
            }
            None
        };
        self.ahead = ahead;
        self.fill_sizes();
        if is_corner {
            for (row, track) in self.rows.track.iter().enumerate() {
                let (length, width) = self.sizes[*track as usize];
                // The upper left one: lengths are along the x-axis.
                self.places[row] += Vector::new(length / 2.0, -width / 2.0);
            }
        }
        let Some(part) = ahead else {
            return;
        };
        self.followed = vec![f64::NAN; self.places.len()];
        for (track, rows) in self.order.iter().enumerate() {
            let length = self.sizes[track].0;
            let given = |row: u32| form.map_or(f64::NAN, |form| self.heading(form, row));
            let mut headings: Vec<f64> = rows.iter().map(|row| given(*row)).collect();
            if headings.iter().any(|heading| heading.is_nan()) {
                let places: Vec<Point> = rows.iter().map(|r| self.places[*r as usize]).collect();
                let step = |row: &u32| ((self.times[*row as usize] - start) / dt).round() as i64;
                let steps: Vec<i64> = rows.iter().map(step).collect();
                let moved = motion::derive(&steps, &places, dt);
                let mut derived: Vec<f64> = moved.into_iter().map(|d| d.heading).collect();
                if part == FRONT {
                    derived = followed(&places, &derived, (REAR_AXLE - FRONT) * length);
                }
                for (i, row) in rows
                    .iter()
                    .enumerate()
                    .filter(|(i, _)| headings[*i].is_nan())
                {
                    self.followed[*row as usize] = derived[i];
                }
                let known =
                    |(given, derived): (f64, f64)| if given.is_nan() { derived } else { given };
                headings = headings.into_iter().zip(derived).map(known).collect();
            }
            for (row, heading) in rows.iter().zip(headings) {
                let along = Vector::new(heading.cos(), heading.sin());
                self.places[*row as usize] += along * (length * part);
            }
        }
    }

    /// Pairs with headings in radians.
    fn turns(&self, form: HeadingForm) -> Vec<Pair> {
        let radians = |written: f64| signed(form, written);
        let mut pairs = self.pairs();
        for pair in &mut pairs {
            pair.heading = (radians(pair.heading.0), radians(pair.heading.1));
        }
        pairs.retain(|pair| pair.heading.0.is_finite() && pair.heading.1.is_finite());
        pairs
    }

    /// Kinds by class or size, and sizes of those that have none.
    fn fill_sizes(&mut self) {
        let mut assumed = Vec::new();
        let has_class = self.columns.of.contains_key(&Role::Class);
        for track in 0..self.sizes.len() {
            let kind = self.kind(track);
            let size = &mut self.sizes[track];
            if size.0 <= 0.0 || size.1 <= 0.0 {
                let usual = assembly::default_size(kind);
                assumed.push(kind);
                // Some tables have lengths only.
                if size.0 <= 0.0 {
                    size.0 = usual.0;
                }
                if size.1 <= 0.0 {
                    size.1 = usual.1;
                }
            }
        }
        self.note_unknown_classes();
        if !has_class {
            self.report
                .note("no classes; taken by size, those without a size as cars");
        }
        if !assumed.is_empty() {
            self.report.note(format!(
                "tracks without a size above 0: {}; assumed by class: {}",
                assumed.len(),
                assembly::in_words(assumed)
            ));
        }
    }

    /// Names classes that say nothing of what a road user is.
    fn note_unknown_classes(&self) {
        let mut unknown: BTreeMap<&str, usize> = BTreeMap::new();
        for (track, named) in self.rows.tracks.iter().enumerate() {
            let class = named.class.as_str();
            let is_said = class.is_empty() || UNKNOWN.contains(&class.to_lowercase().as_str());
            if !is_said && self.kind(track) == ObstacleType::Unknown {
                *unknown.entry(class).or_default() += 1;
            }
        }
        let words = unknown.iter().take(MAX_CLASSES);
        let words: Vec<String> = words
            .map(|(class, count)| format!("`{}` (tracks: {count})", shown(class)))
            .collect();
        let more = match unknown.len() - words.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        if !words.is_empty() {
            self.report.at(format!("column {}", self.column(Role::Class))).note(
                Severity::Note,
                format!(
                    "classes that are not known: {}{more}; taken as unknown; known are words such as car, truck, bus, motorcycle, bicycle and pedestrian",
                    words.join(", ")
                ),
            );
        }
    }

    pub(super) fn kind(&self, track: usize) -> ObstacleType {
        let class = &self.rows.tracks[track].class;
        match self.said.kind {
            Some(kind) => kind(class),
            None if class.is_empty() => assembly::kind_by_size(self.sizes[track]),
            None => assembly::kind_by_class(class),
        }
    }
}

/// The headings of bodies whose front is at some places and moves in some directions: the rear axle, `wheelbase` metres
/// behind, rolls towards the front.
fn followed(fronts: &[Point], directions: &[f64], wheelbase: f64) -> Vec<f64> {
    let Some((front, direction)) = fronts.first().zip(directions.first()) else {
        return Vec::new();
    };
    // In a turn the front goes inwards of the heading: as much at first as over the first metres.
    let far = fronts.iter().position(|p| (p - front).norm() > wheelbase);
    let slip = far.map_or(0.0, |far| {
        let path: f64 = fronts[..=far]
            .windows(2)
            .map(|p| (p[1] - p[0]).norm())
            .sum();
        let bend = angle_between(*direction, directions[far]) / path;
        (bend * wheelbase).clamp(-0.7, 0.7).asin()
    });
    let first = direction - slip;
    let mut rear = front - Vector::new(first.cos(), first.sin()) * wheelbase;
    let each = fronts.iter().map(|front| {
        let along = front - rear;
        rear = front - along * (wheelbase / along.norm().max(f64::MIN_POSITIVE));
        along.y.atan2(along.x)
    });
    each.collect()
}
