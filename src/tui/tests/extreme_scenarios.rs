//! Every view with scenarios that lack parts or have extreme dimensions.

use super::bench::Bench;
use super::drive_fixtures::{coarse, request};
use super::everywhere::VIEWS;
use crate::features::planner::request::Plan;
use crate::features::scenarios::request::{Find, Found};
use crate::loaded::Opened;
use crate::message::Msg;
use crate::model::Update;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, Entry, bundled};

/// The text of a bundled scenario without the elements of these names.
fn without(xml: &str, names: &[&str]) -> String {
    let mut xml = xml.to_owned();
    for name in names {
        let (open, close) = (format!("<{name} id="), format!("</{name}>"));
        while let Some(from) = xml.find(&open) {
            let to = xml[from..].find(&close).unwrap() + from + close.len();
            xml.replace_range(from..to, "");
        }
    }
    xml
}

/// The same with only the first of the elements of a name.
fn first_alone(xml: &str, name: &str) -> String {
    let close = format!("</{name}>");
    let end = xml.find(&close).unwrap() + close.len();
    xml[..end].to_owned() + &without(&xml[end..], &[name])
}

/// Coordinates and lengths that are `by` times as large.
fn grown(xml: &str, by: f64) -> String {
    let mut out = String::new();
    for (i, part) in xml.split("<x>").enumerate() {
        match (i, part.split_once('<')) {
            (1.., Some((x, rest))) => {
                let x: f64 = x.trim().parse().unwrap();
                out.push_str(&format!("<x>{}<{rest}", x * by));
            }
            _ => out.push_str(part),
        }
    }
    out
}

/// Names and texts.
fn bare() -> Vec<(&'static str, String)> {
    let entries = bundled();
    let mut entries = entries.iter();
    let entry = entries.find(|e| e.name == "ZAM_RightTurn-1_1_T-1").unwrap();
    let xml = entry.source().unwrap();
    let obstacles = ["dynamicObstacle", "staticObstacle"];
    let roads = ["lanelet", "trafficSign", "trafficLight", "intersection"];
    let empty = without(&xml, &obstacles);
    let rest = [&obstacles[..], &roads, &["planningProblem"]].concat();
    vec![
        ("no obstacles", empty.clone()),
        ("one", first_alone(&xml, "dynamicObstacle")),
        ("no road", without(&xml, &roads)),
        ("no problem", without(&xml, &["planningProblem"])),
        (
            "no obstacles and no problem",
            without(&empty, &["planningProblem"]),
        ),
        ("nothing", without(&xml, &rest)),
        (
            "long steps",
            xml.replace("timeStepSize=\"0.1\"", "timeStepSize=\"10\""),
        ),
        (
            "short steps",
            xml.replace("timeStepSize=\"0.1\"", "timeStepSize=\"0.001\""),
        ),
        // The farthest that are read.
        ("far", grown(&xml, 1e3)),
        ("farther", grown(&xml, 5e4)),
    ]
}

/// What the workbench asked the planner for is done at once.
fn planned(bench: &mut Bench) {
    let mut asks = bench
        .effects
        .iter()
        .rev()
        .filter_map(|effect| match effect.request() {
            Some(Plan {
                id,
                entry,
                change,
                forecast,
                planner: 0,
            }) => Some((*id, entry.clone(), *change, *forecast)),
            _ => None,
        });
    let Some((id, entry, change, forecast)) = asks.next() else {
        return;
    };
    let settings = coarse(forecast);
    let thresholds = bench.model.thresholds.clone();
    // A few cycles will do.
    let cancel = Cancel::default();
    let mut cycles = 0;
    let mut on_step = |_, _| {
        cycles += 1;
        if cycles == 400 {
            cancel.ask();
        }
    };
    let mut request = request(&entry, &settings);
    request.open.transform = change;
    let opened = Opened::planned(&request, &thresholds, &cancel, &mut on_step);
    if let Some(opened) = opened.transpose() {
        bench.send(Msg::reply::<Plan>((
            id,
            Update::Ended(opened.map(Box::new)),
        )));
    }
}

#[test]
fn every_view_of_bare_scenarios_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    for (place, (what, xml)) in bare().into_iter().enumerate() {
        let path = folder.path().join(format!("ZAM_Bare-{place}_1_T-1.xml"));
        std::fs::write(&path, xml).unwrap();
        let entry = Entry::of_argument(&path);
        let id = nearmiss_formats::commonroad::read_file(&path)
            .unwrap_or_else(|error| panic!("{what}: {error}"))
            .obstacles
            .first()
            .map(|obstacle| obstacle.id);
        for ego in [EgoSelection::Beside]
            .into_iter()
            .chain(id.map(EgoSelection::Obstacle))
        {
            let mut bench = Bench::empty();
            bench.ego = ego.clone();
            bench.send(Msg::reply::<Find>(Found::All(Ok(
                vec![entry.clone()].into()
            ))));
            // Where nothing is the ego, the workbench plans by itself.
            for plans in [false, true] {
                bench.frame(120, 40);
                if plans {
                    planned(&mut bench);
                }
                for (view, keys, _) in VIEWS.iter().filter(|view| view.0 != "editor") {
                    bench.press(keys);
                    for step in [i64::MIN, 20, i64::MAX] {
                        bench.model.clock.go(step);
                        let lines = bench.frame(160, 45).lines().count();
                        assert_eq!(lines, 45, "{what}: {view}");
                    }
                    bench.press("esc esc esc");
                }
            }
        }
    }
}
