//! Directions, sentences, who is told of, and the worst values of a window, by the numbers beside them.

use std::collections::HashMap;

use nearmiss::description::{Form, Frame, STANDS_FAR, VELOCITY_TOLERANCE};
use nearmiss::metrics::{Context, Encounter};
use nearmiss::scenario::Participant;

use super::{Told, is, value};
use crate::words::parsed::Row;

impl Told<'_> {
    /// Direction and sentence follow from the numbers as they are written.
    pub(super) fn words(&self, row: &Row) {
        let number = |title| row.number(title).unwrap();
        let sign = |value: f64| {
            if value == 0.0 {
                0
            } else {
                value.signum() as i8
            }
        };
        let (long, lat) = (sign(number("gap long [m]")), sign(number("gap lat [m]")));
        let (v_long, v_lat) = (
            sign(number("v rel long [m/s]")),
            sign(number("v rel lat [m/s]")),
        );
        let touches = number("distance [m]") == 0.0;
        assert!(!touches || (long, lat) == (0, 0), "{row:?}");
        let side = match (long, lat) {
            (1, 0) => "Front",
            (-1, 0) => "Behind",
            (0, 1) => "Left",
            (0, -1) => "Right",
            (1, 1) => "Front-left",
            (1, -1) => "Front-right",
            (-1, 1) => "Rear-left",
            (-1, -1) => "Rear-right",
            _ if touches && self.options.contact => "Contact",
            _ => row.text("direction").unwrap(),
        };
        assert_eq!(row.text("direction"), Some(side), "{row:?}");
        let Some(sentence) = &row.sentence else {
            return assert_eq!(self.options.form, Form::Compact);
        };
        let said = |words: &str| sentence.contains(words);
        for (words, holds) in [
            ("Ahead of the ego", long > 0),
            ("Behind the ego", long < 0),
            ("level with the ego", long == 0 && lat != 0),
            ("in line with the ego", lat == 0 && long != 0),
            ("on the left it", lat > 0),
            ("on the right it", lat < 0),
            ("gap is closing", long * v_long < 0),
            ("gap is opening", long * v_long > 0),
            ("gap stays", long != 0 && v_long == 0),
            ("comes nearer sideways", lat * v_lat < 0),
            ("moves away sideways", lat * v_lat > 0),
            ("keeps its sideways", lat != 0 && v_lat == 0),
            (
                "overlaps the ego's extent in both",
                (long, lat) == (0, 0) && !touches,
            ),
            ("touches the ego.", touches && self.options.contact),
        ] {
            if said(words) != holds {
                self.fail(row, words);
            }
        }
        for (words, way) in [("forward", 1), ("backward", -1)] {
            assert!(
                long != 0 || said("neither") || !said(words) || v_long == way,
                "{row:?}"
            );
        }
        for (words, way) in [("to the left", 1), ("to the right", -1)] {
            assert!(lat != 0 || !said(words) || v_lat == way, "{row:?}");
        }
    }

    /// How near the discs around ego and participant come within the reach, metres; looked at every hundredth of a second.
    fn least_gap(&self, other: &Participant<'_>, step: i64) -> f64 {
        let encounter = Encounter::at(self.scene, other, step).unwrap();
        let bodies = encounter.ego_body.reach() + encounter.other_body.reach();
        let between = encounter.other.pose.position - encounter.ego.pose.position;
        let velocity = encounter.other.velocity_vector() - encounter.ego.velocity_vector();
        let seconds = self.options.reach.unwrap();
        let gap = |t: f64| (between + velocity * t).norm() - bodies - 2.0 * VELOCITY_TOLERANCE * t;
        let times = (0..)
            .map(|k| 0.01 * f64::from(k))
            .take_while(|t| *t <= seconds);
        times.map(gap).fold(f64::INFINITY, f64::min)
    }

    /// Everyone near or able to reach the ego is told of, at every described step or, what stands far away, at its last;
    /// and the others are counted.
    pub(super) fn who_is_told(&self) {
        let rows = self.parsed.rows.iter();
        let mut told: Vec<(i64, i64)> = rows
            .filter_map(|row| Some((self.step(row.t), row.id?)))
            .collect();
        told.sort_unstable();
        let mut near: HashMap<i64, Vec<(i64, bool)>> = HashMap::new();
        let mut empty = Vec::new();
        for step in self.options.steps(&self.window) {
            let ego = self.scene.ego.track.at(step).unwrap().pose.position;
            let before = near.values().map(Vec::len).sum::<usize>();
            let everyone = self.scene.participants();
            let everyone: Vec<_> = everyone.filter(|p| p.at(step).is_some()).collect();
            let ttc = |p: &Participant<'_>| value("ttc", &Encounter::at(self.scene, p, step)?);
            let times = everyone
                .iter()
                .filter_map(|p| Some((ttc(p)?, p.obstacle.id)));
            let first = times.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id);
            for participant in everyone {
                let (id, motion) = (participant.obstacle.id, participant.at(step).unwrap());
                let apart = (motion.pose.position - ego).norm();
                let far = apart > STANDS_FAR && is("0.00", motion.velocity);
                let gap = self.least_gap(&participant, step);
                // As near to the bound as the steps of time are long, either is right.
                let reaches = gap < 0.0 || gap < 0.35 && told.contains(&(step, id));
                if apart <= self.options.radius || reaches || first == Some(id) {
                    near.entry(id).or_default().push((step, far));
                }
            }
            if near.values().map(Vec::len).sum::<usize>() == before {
                empty.push(step);
            }
        }
        self.others(&near);
        let mut expected: Vec<(i64, i64)> = Vec::new();
        for (id, steps) in near {
            let once = steps.iter().all(|(_, far)| *far);
            let skipped = if once { steps.len() - 1 } else { 0 };
            expected.extend(steps[skipped..].iter().map(|(step, _)| (*step, id)));
        }
        expected.sort_unstable();
        assert_eq!(told, expected, "{}", self.text);
        let nobody: Vec<i64> = self.parsed.nobody.iter().map(|t| self.step(*t)).collect();
        if self.options.form == Form::Prose && self.frame != Frame::Cartesian {
            assert_eq!(nobody, empty, "{}", self.text);
        }
    }

    /// Who is not told of is counted, with the smallest distance of their centres.
    fn others(&self, told: &HashMap<i64, Vec<(i64, bool)>>) {
        let ego = &self.scene.ego.track;
        let mut nearest: Vec<f64> = Vec::new();
        for other in self.scene.participants() {
            let both = |step| ego.at(step).zip(other.at(step));
            let both = self.window.steps().filter_map(both);
            let distances = both.map(|(a, b)| (a.pose.position - b.pose.position).norm());
            let least = distances.min_by(f64::total_cmp);
            nearest.extend(least.filter(|_| !told.contains_key(&other.obstacle.id)));
        }
        nearest.sort_by(f64::total_cmp);
        let said = self
            .text
            .lines()
            .find_map(|l| l.strip_prefix("Not described: "));
        let expected = nearest.first().map(|least| {
            let come = match nearest.len() {
                1 => "1 other, which comes".to_string(),
                n => format!("{n} others, which come"),
            };
            format!("{come} no nearer than {least:.2} m, centre to centre.")
        });
        assert_eq!(said, expected.as_deref(), "{}", self.text);
    }

    pub(super) fn worst(
        &self,
        id: i64,
        values: &[(String, Option<(String, f64)>)],
        context: &Context<'_>,
    ) {
        let is_it = |p: &Participant<'_>| p.obstacle.id == id;
        let place = context.participants().iter().position(is_it).unwrap();
        for (title, told) in values {
            let (id, most) = match title.as_str() {
                "min distance [m]" => ("distance", 1.0),
                "min ttc [s]" => ("ttc", 1.0),
                "max drac [m/s²]" => ("drac", -1.0),
                _ => ("risk", 1.0),
            };
            let all = self.window.steps().filter_map(|step| {
                let truth = value(id, &context.encounter(place, step)?)?;
                Some((if id == "risk" { truth.max(1.0) } else { truth }, step))
            });
            let worst = all.min_by(|a, b| (most * a.0).total_cmp(&(most * b.0)));
            match (told, worst) {
                (Some((text, t)), Some((truth, step))) => {
                    assert!(is(text, truth), "{title} {text} {truth}\n{}", self.text);
                    assert_eq!(self.step(*t), step, "{title}\n{}", self.text);
                }
                // A time from a speed that is written as 0 is not told.
                (None, Some(_)) if id == "ttc" => {}
                (None, None) => {}
                other => panic!("{title}: {other:?}\n{}", self.text),
            }
        }
    }
}
