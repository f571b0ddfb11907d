//! Every statement of the descriptions recomputed from the scene: numbers within rounding, words true by the numbers.
//!
//! `NEARMISS_ALL_WINDOWS=1` takes every window of the bundled scenarios, and more of the published ones.

use nearmiss::description::{Form, Frame, Options, describe};
use nearmiss::formats::{bundled, find};
use nearmiss::metrics::{Context, Encounter, measure};
use nearmiss::scenario::{Scene, Window};

use crate::support::recorded::folder;
use crate::words::parsed::{self, Parsed, Row};
use crate::words::scene;

#[path = "said.rs"]
mod said;

const FIRST: &str =
    "Times are relative to the end of the described window: t = 0.00 s is now.\nSizes: ";

/// A description and what it is held against.
struct Told<'s> {
    scene: &'s Scene,
    window: Window,
    options: Options,
    frame: Frame,
    text: String,
    parsed: Parsed,
}

/// Whether a number is written as this, rounded.
fn is(text: &str, truth: f64) -> bool {
    assert!(
        !text.starts_with('-') || text.parse::<f64>().unwrap() < 0.0,
        "negative zero: {text}"
    );
    let decimals = text.split_once('.').map_or(0, |(_, d)| d.len());
    let off = (text.parse::<f64>().unwrap() - truth).abs();
    off <= 0.5 * 10_f64.powi(-(decimals as i32)) + 1e-9 * truth.abs().max(1.0)
}

/// As [`is`], and 0 is written for 0 alone.
fn is_exactly_zero_or(text: &str, truth: f64) -> bool {
    is(text, truth) && (text.parse() == Ok(0.0)) == (truth == 0.0)
}

fn value(id: &str, encounter: &Encounter<'_>) -> Option<f64> {
    measure(id).unwrap().compute(encounter).value()
}

impl Told<'_> {
    fn fail(&self, row: &Row, why: &str) -> ! {
        panic!(
            "{} {:?} {:?}: {why}: {row:?}\n{}",
            self.scene.scenario.header.benchmark_id, self.frame, self.options, self.text
        )
    }

    fn step(&self, t: f64) -> i64 {
        self.window.last() + (t / self.scene.scenario.dt()).round() as i64
    }

    fn check(&self) -> usize {
        assert!(self.text.starts_with(FIRST), "{}", self.text);
        assert!(!self.text.contains("tep "), "no steps: {}", self.text);
        let context = Context::new(self.scene).during(&self.window);
        for row in &self.parsed.rows {
            match row.id {
                None => self.ego(row),
                Some(id) => self.obstacle(row, id, &context),
            }
        }
        self.who_is_told();
        for (id, values) in &self.parsed.worst {
            self.worst(*id, values, &context);
        }
        self.parsed.rows.len()
    }

    fn ego(&self, row: &Row) {
        let Some(motion) = self.scene.ego.track.at(self.step(row.t)) else {
            return assert!(row.values.is_empty());
        };
        let network = &self.scene.scenario.network;
        let off = network.lanelets_at(&motion.pose.position).is_empty();
        assert_eq!(row.text("lane"), off.then_some("off the road"));
        for (title, truth) in [
            ("v [m/s]", motion.velocity),
            ("a [m/s²]", motion.acceleration),
        ] {
            if !is(row.text(title).unwrap(), truth) {
                self.fail(row, title);
            }
        }
    }

    fn obstacle(&self, row: &Row, id: i64, context: &Context<'_>) {
        let step = self.step(row.t);
        let all = context.participants();
        let place = all.iter().position(|p| p.obstacle.id == id).unwrap();
        let encounter = context.encounter(place, step).unwrap();
        self.lane(row, &encounter);
        if self.frame == Frame::Cartesian {
            let there = encounter.other;
            for (title, truth) in [
                ("x [m]", there.pose.position.x),
                ("y [m]", there.pose.position.y),
                ("v [m/s]", there.velocity),
                ("a [m/s²]", there.acceleration),
            ] {
                if !is(row.text(title).unwrap(), truth) {
                    self.fail(row, title);
                }
            }
            let turned = row.number("heading [rad]").unwrap() - there.pose.heading;
            return assert!(turned.sin().abs() < 6e-4 && turned.cos() > 0.0, "{row:?}");
        }
        let relation = encounter.relation();
        for (title, truth) in [
            ("distance [m]", encounter.distance()),
            ("gap long [m]", relation.gap_long),
            ("gap lat [m]", relation.gap_lat),
        ] {
            if !is_exactly_zero_or(row.text(title).unwrap(), truth) {
                self.fail(row, title);
            }
        }
        for (title, truth) in [
            ("v rel long [m/s]", relation.velocity.x),
            ("v rel lat [m/s]", relation.velocity.y),
            ("a rel long [m/s²]", relation.acceleration.x),
            ("a rel lat [m/s²]", relation.acceleration.y),
        ] {
            let told = row.text(title);
            if told.is_none() && self.frame == Frame::Metrics {
                continue;
            }
            if !is(told.unwrap(), truth) {
                self.fail(row, title);
            }
        }
        if self.frame == Frame::Ego {
            let degrees = row.number("heading [°]").unwrap();
            let headings = (encounter.ego.pose.heading, encounter.other.pose.heading);
            let off = (headings.0 + degrees.to_radians() - headings.1).sin();
            assert!(
                off.abs() < 1e-3 && degrees > -180.0 && degrees <= 180.0,
                "{row:?}"
            );
        } else {
            self.measures(row, &encounter);
        }
        self.words(row);
    }

    fn lane(&self, row: &Row, encounter: &Encounter<'_>) {
        let network = &self.scene.scenario.network;
        let [ours, theirs] = [encounter.ego, encounter.other]
            .map(|motion| network.lanelets_at(&motion.pose.position));
        let told = row.text("lane").unwrap();
        assert_eq!(told == "off the road", theirs.is_empty(), "{row:?}");
        let shared = ours.iter().any(|id| theirs.contains(id));
        assert!(told != "same lane" || shared, "{row:?}");
        let beside = |left: bool| {
            ours.iter().filter_map(|id| network.lanelet(*id)).any(|l| {
                let next = if left {
                    l.adjacent_left
                } else {
                    l.adjacent_right
                };
                next.is_some_and(|a| a.same_direction && theirs.contains(&a.id))
            })
        };
        if ours.len() == 1 && theirs.len() == 1 && !shared && (beside(true) || beside(false)) {
            let expected = if beside(true) { "left" } else { "right" };
            assert_eq!(told, format!("{expected} neighbour lane"), "{row:?}");
        }
    }

    fn measures(&self, row: &Row, encounter: &Encounter<'_>) {
        for (title, id) in [
            ("ttc [s]", "ttc"),
            ("time gap [s]", "time_gap"),
            ("drac [m/s²]", "drac"),
        ] {
            match (row.text(title), value(id, encounter)) {
                (Some(told), Some(truth)) if is(told, truth) => {}
                (None, None) => {}
                // A time from a speed that is written as 0 is not told.
                (None, Some(_)) if id == "ttc" => {
                    assert_eq!(row.number("v rel long [m/s]"), Some(0.0), "{row:?}");
                    assert_eq!(row.number("v rel lat [m/s]"), Some(0.0), "{row:?}");
                }
                (None, Some(_)) if id == "time_gap" => {
                    assert!(is("0.00", encounter.ego.velocity), "{row:?}");
                }
                _ => self.fail(row, title),
            }
        }
        for (title, gap, speed, id) in [
            (
                "ttc long [s]",
                "gap long [m]",
                "v rel long [m/s]",
                "ttc_long",
            ),
            ("ttc lat [s]", "gap lat [m]", "v rel lat [m/s]", "ttc_lat"),
        ] {
            let closing = row.number(gap).unwrap() * row.number(speed).unwrap() < 0.0;
            match row.text(title) {
                Some(told) if closing && is(told, value(id, encounter).unwrap()) => {}
                None if !closing => {}
                _ => self.fail(row, title),
            }
        }
        let risk = value("risk", encounter).unwrap().max(1.0);
        assert_eq!(row.number("risk"), Some(risk), "{row:?}");
    }
}

/// The numbers and words of every description of a window; how many rows were checked.
pub fn check(scene: &Scene, last: i64) -> usize {
    let mut rows = 0;
    for frame in [Frame::Ego, Frame::Metrics, Frame::Cartesian] {
        for (form, contact) in [
            (Form::Prose, false),
            (Form::Prose, true),
            (Form::Compact, false),
            (Form::Compact, true),
        ] {
            let window = Window::ending_at(scene, last, 10);
            let options = Options {
                form,
                contact,
                stride: 3,
                ..Options::default()
            };
            let text = describe(scene, frame, &window, &options).unwrap().text;
            let parsed = match form {
                Form::Prose => parsed::prose(&text),
                Form::Compact => parsed::compact(&text),
            };
            let told = Told {
                scene,
                window,
                options,
                frame,
                text,
                parsed,
            };
            rows += told.check();
        }
    }
    rows
}

fn all_windows() -> bool {
    std::env::var_os("NEARMISS_ALL_WINDOWS").is_some()
}

#[test]
fn statements_about_the_bundled_scenarios_are_true() {
    let every = if all_windows() { 1 } else { 7 };
    let mut rows = 0;
    for entry in bundled() {
        let scene = scene(&entry.name);
        for last in scene.steps().rev().step_by(every) {
            rows += check(&scene, last);
        }
    }
    assert!(rows > 10_000, "{rows}");
}

#[test]
fn statements_about_the_published_scenarios_are_true() {
    let Some(folder) = folder() else { return };
    let found = find(&[folder]).unwrap();
    let (every, of) = if all_windows() { (7, 1) } else { (200, 8) };
    for entry in found.entries.iter().step_by(of) {
        let Ok(scenario) = entry.read() else { continue };
        let Ok(Some(ego)) = entry.recorded_ego(&scenario) else {
            continue;
        };
        let scene = Scene::new(scenario, ego);
        for last in scene.steps().rev().step_by(every) {
            check(&scene, last);
        }
    }
}
