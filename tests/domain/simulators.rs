//! Scenarios for simulators: what is written, evaluated independently; opened again; damaged; played by esmini.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use nearmiss::formats::{Entry, Export, Exported, ExportedEgo, bundled, write_openscenario};
use nearmiss::geometry::{Point, Polyline};
use nearmiss::scenario::{Scenario, Scene};

mod made;
mod others;
mod roads;
mod round_trip;
mod storyboards;

/// The export of an entry with the ego beside it.
fn exported(entry: &Entry, road_file: &str) -> (Arc<Scene>, Exported) {
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let scene = Scene::new(scenario, ego);
    let written = write_openscenario(&Export {
        scenario: &scene.scenario,
        ego: ExportedEgo::Follows(&scene.ego),
        road_file,
        properties: &BTreeMap::new(),
        about: &[],
        varied: None,
    });
    (Arc::new(scene.clone()), written.unwrap())
}

/// An element as it stands in the text: its name and attributes; `None` for one that ends.
type Tag = (String, HashMap<String, String>);

/// The tags of a document in order, read without a parser of the program.
fn tags(text: &str) -> Vec<Tag> {
    let mut all = Vec::new();
    for piece in text.split('<').skip(1) {
        let inside = piece.split('>').next().unwrap();
        let mut parts = inside.split('"');
        let head = parts.next().unwrap().trim();
        let mut words = head.split_whitespace();
        let name = words
            .next()
            .unwrap_or_default()
            .trim_end_matches('/')
            .to_string();
        let mut key = words
            .last()
            .unwrap_or_default()
            .trim_end_matches('=')
            .to_string();
        let mut attributes = HashMap::new();
        while let Some(value) = parts.next() {
            attributes.insert(key.clone(), value.to_string());
            let next = parts.next().unwrap_or_default().trim();
            key = next.trim_end_matches('=').to_string();
        }
        all.push((name, attributes));
    }
    all
}

fn number(attributes: &HashMap<String, String>, name: &str) -> f64 {
    attributes[name].parse().unwrap()
}

/// Roads as the XML tells them: geometry (s, x, y, hdg, length, curvature), offsets and widths (s, a, b) by lane.
#[derive(Default)]
struct Told {
    length: f64,
    geometry: Vec<[f64; 6]>,
    offset: Vec<[f64; 3]>,
    widths: BTreeMap<i64, Vec<[f64; 3]>>,
    lanelets: BTreeMap<i64, i64>,
}

fn told(text: &str) -> Vec<Told> {
    let mut roads: Vec<Told> = Vec::new();
    let mut lane = 0;
    for (name, a) in tags(text) {
        if name == "road" {
            roads.push(Told {
                length: number(&a, "length"),
                ..Told::default()
            });
        }
        let Some(road) = roads.last_mut() else {
            continue;
        };
        match name.as_str() {
            "geometry" => {
                let of = ["s", "x", "y", "hdg", "length"].map(|n| number(&a, n));
                road.geometry.push([of[0], of[1], of[2], of[3], of[4], 0.0]);
            }
            "arc" => road.geometry.last_mut().unwrap()[5] = number(&a, "curvature"),
            "laneOffset" => road.offset.push(["s", "a", "b"].map(|n| number(&a, n))),
            "lane" => lane = a["id"].parse().unwrap(),
            "width" => {
                let of = ["sOffset", "a", "b"].map(|n| number(&a, n));
                road.widths.entry(lane).or_default().push(of);
            }
            "userData" if a["code"] == "commonroad_lanelet" => {
                road.lanelets.insert(lane, a["value"].parse().unwrap());
            }
            _ => {}
        }
    }
    roads
}

fn value(of: &[[f64; 3]], s: f64) -> f64 {
    let [from, a, b] = of
        .iter()
        .rev()
        .find(|c| c[0] <= s + 1e-9)
        .copied()
        .unwrap_or(of[0]);
    a + b * (s - from)
}

impl Told {
    /// A place beside the reference line, by the formulas of the standard.
    fn at(&self, s: f64, t: f64) -> Point {
        let found = self.geometry.iter().rev().find(|g| g[0] <= s + 1e-9);
        let [from, x, y, heading, _, k] = found.copied().unwrap();
        let d = s - from;
        let (px, py, h) = match k {
            0.0 => (x + d * heading.cos(), y + d * heading.sin(), heading),
            _ => {
                let end = heading + k * d;
                (
                    x + (end.sin() - heading.sin()) / k,
                    y - (end.cos() - heading.cos()) / k,
                    end,
                )
            }
        };
        Point::new(px - t * h.sin(), py + t * h.cos())
    }

    /// The border to the right of lanes 0 to `lanes`.
    fn border(&self, s: f64, lanes: i64) -> Point {
        let inner = (1..=lanes).map(|lane| value(&self.widths[&-lane], s));
        self.at(s, value(&self.offset, s) - inner.sum::<f64>())
    }
}

#[test]
fn lanes_have_the_borders_of_their_lanelets() {
    for entry in bundled() {
        let (scene, written) = exported(&entry, "x.xodr");
        let text = String::from_utf8(written.roads).unwrap();
        let network = &scene.scenario.network;
        let mut seen = 0;
        for road in told(&text) {
            for pair in road.geometry.windows(2) {
                let end = pair[0][0] + pair[0][4];
                assert!(
                    (end - pair[1][0]).abs() < 1e-6,
                    "{}: a gap in s",
                    entry.name
                );
                let away = road.at(pair[1][0] - 1e-7, 0.0) - road.at(pair[1][0], 0.0);
                assert!(away.norm() < 1e-5, "{}: a gap", entry.name);
            }
            for (lane, id) in &road.lanelets {
                seen += 1;
                let lanelet = network.lanelet(*id).unwrap();
                let sides = [(&lanelet.left, -lane - 1), (&lanelet.right, -lane)];
                for (bound, lanes) in sides {
                    let line = Polyline::new(bound.points.iter().copied()).unwrap();
                    let count = (road.length / 0.5).ceil() as i64;
                    for i in 0..=count {
                        let s = road.length * i as f64 / count as f64;
                        let off = line.project(&road.border(s, lanes)).d.abs();
                        assert!(off < 0.05, "{} lanelet {id} at {s}: {off}", entry.name);
                    }
                }
            }
        }
        assert_eq!(seen, network.lanelets.len(), "{}", entry.name);
        assert!(written.deviation < 0.05);
    }
}

#[test]
fn vertices_are_the_recorded_states() {
    let entry = &bundled()[1];
    let (scene, written) = exported(entry, "x.xodr");
    let text = String::from_utf8(written.scenario).unwrap();
    let dt = scene.scenario.dt();
    let (mut entity, mut step, mut start) = (String::new(), 0, (0.0, 0.0));
    let mut checked = 0;
    for (name, a) in tags(&text) {
        match name.as_str() {
            "Private" => entity = a["entityRef"].clone(),
            "Vertex" => step = (number(&a, "time") / dt).round() as i64,
            "ManeuverGroup" => entity = a["name"].trim_start_matches("entity ").to_string(),
            "TeleportAction" => step = i64::MIN,
            "WorldPosition" | "RelativeWorldPosition" => {
                let at = match name.as_str() {
                    "WorldPosition" => (number(&a, "x"), number(&a, "y")),
                    _ => (start.0 + number(&a, "dx"), start.1 + number(&a, "dy")),
                };
                if step == i64::MIN {
                    start = at;
                    continue;
                }
                let motion = match entity.as_str() {
                    "ego" => scene.ego.track.at(step),
                    id => scene
                        .scenario
                        .obstacle(id.parse().unwrap())
                        .unwrap()
                        .motion_at(step),
                };
                let p = motion.unwrap().pose.position;
                assert!(
                    (p - Point::new(at.0, at.1)).norm() < 1e-3,
                    "{entity} at {step}"
                );
                checked += 1;
            }
            _ => {}
        }
    }
    assert!(checked > 100, "{checked}");
}

/// Writes an export into a folder.
fn write(folder: &Path, name: &str, exported: &Exported) -> PathBuf {
    let path = folder.join(format!("{name}.xosc"));
    std::fs::write(&path, &exported.scenario).unwrap();
    std::fs::write(path.with_extension("xodr"), &exported.roads).unwrap();
    path
}

#[test]
fn an_export_opened_again_is_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    for entry in bundled() {
        let (scene, written) = exported(&entry, &format!("{}.xodr", entry.name));
        let path = write(folder.path(), &entry.name, &written);
        let again = Entry::of_file(&path);
        let scenario: Arc<Scenario> = again.read().unwrap();
        let ego = again.recorded_ego(&scenario).unwrap().unwrap();
        let back = Scene::new(scenario, ego);
        assert_eq!(back.scenario.dt(), scene.scenario.dt());
        let (read, kept) = (&back.scenario.network, &scene.scenario.network);
        assert_eq!(read.signs, kept.signs, "{}", entry.name);
        assert_eq!(read.lights, kept.lights, "{}", entry.name);
        for (a, b) in read.lanelets.iter().zip(&kept.lanelets) {
            assert_eq!((a.id, &a.signs, &a.lights), (b.id, &b.signs, &b.lights));
            assert_eq!(a.stop_line, b.stop_line);
        }
        for step in scene.steps() {
            let (a, b) = (scene.ego_at(step).unwrap(), back.ego_at(step).unwrap());
            assert!((a.pose.position - b.pose.position).norm() < 1e-3);
            let motions = (
                scene.ego.track.at(step).unwrap(),
                back.ego.track.at(step).unwrap(),
            );
            assert!((motions.0.velocity - motions.1.velocity).abs() < 1e-9);
            for other in scene.participants() {
                let id = other.obstacle.id;
                let same = back.participants().find(|p| p.obstacle.id == id).unwrap();
                let (Some(x), y) = (other.placed_at(step), same.placed_at(step)) else {
                    assert!(
                        same.placed_at(step).is_none(),
                        "{} {id} at {step}",
                        entry.name
                    );
                    continue;
                };
                let away = (a.distance(&x) - b.distance(&y.unwrap())).abs();
                // Where only the heading changes, places are 0.1 mm apart.
                assert!(away < 1e-3, "{} {id} at {step}: {away}", entry.name);
            }
        }
    }
}

#[test]
fn damaged_files_are_refused_or_opened_and_never_end_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let (_, written) = exported(&bundled()[1], "damaged.xodr");
    let path = write(folder.path(), "damaged", &written);
    let mut random = fastrand::Rng::with_seed(5);
    for case in 0..500 {
        let mut files = written.clone();
        let bytes = match case % 2 {
            0 => &mut files.scenario,
            _ => &mut files.roads,
        };
        match case % 4 {
            0 | 1 => bytes.truncate(random.usize(..bytes.len())),
            _ => {
                for _ in 0..random.usize(1..4) {
                    let at = random.usize(..bytes.len());
                    bytes[at] = random.u8(32..127);
                }
            }
        }
        std::fs::write(&path, &files.scenario).unwrap();
        std::fs::write(path.with_extension("xodr"), &files.roads).unwrap();
        let scenario = Entry::of_file(&path).read();
        if let Err(error) = scenario {
            assert!(!error.message.is_empty());
        }
    }
}

#[test]
fn errors_name_element_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let (_, written) = exported(&bundled()[1], "wrong.xodr");
    let path = write(folder.path(), "wrong", &written);
    let text = String::from_utf8(written.roads).unwrap();
    let line = text.lines().position(|l| l.contains("<geometry")).unwrap() + 1;
    let wrong = text.replacen("hdg=\"", "hdg=\"north ", 1);
    std::fs::write(path.with_extension("xodr"), wrong).unwrap();
    let error = Entry::of_file(&path).read().unwrap_err();
    assert_eq!(error.line, line);
    assert!(error.element.ends_with("geometry"), "{error}");
    assert!(error.message.contains("is not a number"), "{error}");
}

/// Runs `tests/support/simulator.py` on exports of bundled and published scenarios.
#[test]
fn esmini_plays_exports_as_they_were_recorded() {
    let Some(esmini) = std::env::var_os("NEARMISS_ESMINI") else {
        crate::support::program::skipped(
            "NEARMISS_ESMINI is not set; it names a folder with esmini and odrplot",
        );
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/simulator.py");
    for entry in bundled() {
        let (scene, written) = exported(&entry, &format!("{}.xodr", entry.name));
        let path = write(folder.path(), &entry.name, &written);
        let beside = |ending: &str| {
            let file = format!("scenarios/{}{ending}", entry.name);
            Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
        };
        let ended = Command::new("python3")
            .arg(&script)
            .arg(&esmini)
            .args([beside(".xml"), beside(".ego_trajectory.csv"), path])
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&ended.stdout).into_owned();
        let found: serde_json::Value = serde_json::from_str(&text)
            .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&ended.stderr)));
        println!("{}: {found}", entry.name);
        assert!(found["position"].as_f64().unwrap() < 0.01);
        assert!(found["heading"].as_f64().unwrap() < 0.01);
        assert!(found["border"].as_f64().unwrap() < 0.05);
        assert_eq!(found["contact"][0], found["contact"][1]);
        assert_eq!(found["log"], serde_json::json!([]));
        assert_eq!(found["missing"], serde_json::json!([]));
        drop(scene);
    }
}
