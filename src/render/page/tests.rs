//! What a page holds: the numbers of the scene, and nothing that a browser would load or run.
#![allow(clippy::unwrap_used)]

use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::metrics::{MEASURES, Thresholds};
use nearmiss_scene::scenario::Scene;
use serde_json::Value;

use super::*;
use crate::{FigureContent, FigureOptions, Subject};

fn scenes() -> impl Iterator<Item = (String, Scene)> {
    bundled().into_iter().map(|entry| {
        let scenario = entry.read().unwrap();
        let ego = EgoSelection::Beside.resolve(&entry, &scenario);
        (entry.name, Scene::new(scenario, ego.unwrap().unwrap()))
    })
}

fn look() -> FigureOptions {
    let ids = ["ttc", "distance", "risk"];
    FigureOptions {
        what: FigureContent::Both,
        measures: MEASURES.iter().filter(|m| ids.contains(&m.id)).collect(),
        ..FigureOptions::default()
    }
}

fn figure<'a>(scene: &'a Scene, name: &'a str) -> Figure<'a> {
    let subject = Subject::with_ego(scene);
    Figure::new(subject, name, look(), Thresholds::shipped()).unwrap()
}

fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data-scene\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

fn summed(list: &Value) -> Vec<f64> {
    let numbers = list.as_array().unwrap().iter();
    numbers
        .scan(0.0, |sum, n| {
            *sum += n.as_f64().unwrap();
            Some(*sum)
        })
        .collect()
}

#[test]
fn poses_and_measures_are_those_of_the_scene() {
    for (name, scene) in scenes() {
        let figure = figure(&scene, &name);
        let page = figure.page(figure.telling_step(), &Palette::paper(), &[]);
        assert!(page.len() < 1_000_000, "{name}: {} bytes", page.len());
        let data = data(&page);
        assert_eq!(data["view"]["step"], figure.telling_step());
        let bodies = data["bodies"].as_array().unwrap();
        let ego = bodies.iter().find(|body| body["id"].is_null()).unwrap();
        let (x, y) = (summed(&ego["x"]), summed(&ego["y"]));
        let motions: Vec<_> = scene.ego.track.iter().collect();
        assert_eq!(x.len(), motions.len());
        let place = |i: usize| motions[i].1.pose.position;
        // From the first place on, to a centimetre.
        for i in 0..x.len() {
            let (dx, dy) = ((x[i] - x[0]) / 100.0, (y[i] - y[0]) / 100.0);
            let moved = place(i) - place(0);
            assert!((moved.x - dx).abs() < 0.011 && (moved.y - dy).abs() < 0.011);
        }
        let series = figure.series().unwrap();
        for row in data["readings"].as_array().unwrap() {
            let id = row[0].as_str().unwrap().parse().unwrap();
            for (measure, written) in series.measures().iter().zip(row[1].as_array().unwrap()) {
                let mut values = Vec::new();
                for part in written.as_array().unwrap() {
                    match part.as_str() {
                        Some(none) => {
                            let count = none[1..].parse().unwrap();
                            values.extend(std::iter::repeat_n(None, count));
                        }
                        None => values.push(part.as_f64()),
                    }
                }
                let known: Vec<_> = series
                    .row(measure.id, id)
                    .iter()
                    .map(|r| r.value())
                    .collect();
                assert_eq!(values.len(), known.len());
                for (written, known) in values.iter().zip(known) {
                    let off = written.zip(known).map(|(a, b)| (a - b).abs());
                    assert!(off.is_none_or(|off| off <= 0.0051), "{name} {id}");
                    assert_eq!(written.is_some(), known.is_some());
                }
            }
        }
        let worst = &data["moments"][0];
        assert_eq!(worst["step"], figure.telling_step());
        assert_eq!(data["view"]["picked"], worst["obstacle"]);
    }
}

#[test]
fn ids_that_a_browser_would_round_stay_apart() {
    let (name, scene) = scenes().next().unwrap();
    let mut scenario = (*scene.scenario).clone();
    // As numbers of a browser both are 2^53.
    let large = [9_007_199_254_740_992, 9_007_199_254_740_993];
    for (obstacle, id) in scenario.obstacles.iter_mut().zip(large) {
        obstacle.id = id;
    }
    let scene = Scene::new(scenario.into(), scene.ego);
    let figure = figure(&scene, &name);
    let data = data(&figure.page(figure.telling_step(), &Palette::paper(), &[]));
    for id in large.map(|id| id.to_string()) {
        let is_in = |list: &str, key: &str| {
            let mut all = data[list].as_array().unwrap().iter();
            all.any(|one| one[key] == id.as_str() || one[0] == id.as_str())
        };
        assert!(is_in("bodies", "id") && is_in("readings", ""), "{id}");
    }
}

#[test]
fn texts_of_files_are_texts_and_nothing_is_loaded() {
    let evil = "</title></script><img src=x onerror=alert(1)>\u{202e}";
    let (_, scene) = scenes().next().unwrap();
    let mut scenario = (*scene.scenario).clone();
    let attributes = &mut scenario.header.attributes;
    attributes.insert("author".into(), evil.into());
    let scene = Scene::new(scenario.into(), scene.ego);
    let figure = figure(&scene, evil);
    let page = figure.page(figure.telling_step(), &Palette::paper(), &[evil.into()]);
    for bad in ["<img", "\u{202e}", "http:", "https:", "url(", "@import"] {
        // A name space is no address.
        let page = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!page.contains(bad), "{bad}");
    }
    assert_eq!(page.matches("<script>").count(), 1);
    assert_eq!(
        page.matches("<script").count(),
        page.matches("</script>").count()
    );
    assert!(page.contains("default-src 'none'") && page.contains("script-src 'sha256-"));
    // Name, story and author, beside the title.
    assert_eq!(
        page.matches("&lt;img src=x onerror=alert(1)&gt;").count(),
        4
    );
}

#[test]
fn without_an_ego_the_map_is_played() {
    let (name, scene) = scenes().next().unwrap();
    let subject = Subject {
        scenario: &scene.scenario,
        scene: None,
    };
    let look = FigureOptions::default();
    let figure = Figure::new(subject, &name, look, Thresholds::shipped()).unwrap();
    let data = data(&figure.page(0, &Palette::paper(), &[]));
    assert_eq!(data["measures"].as_array().unwrap().len(), 0);
    assert_eq!(data["view"]["follows"], false);
    assert!(!data["bodies"].as_array().unwrap().is_empty());
}
