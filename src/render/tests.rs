//! Figures of bundled scenes: geometry, formats, sizes, and that the same is always the same.
#![allow(clippy::unwrap_used)]

use std::sync::atomic::AtomicBool;

use super::*;
use nearmiss_base::geometry::Point;
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::metrics::{MEASURES, Thresholds};
use nearmiss_scene::scenario::{Scene, WindowEnd, WindowRule};

fn scene(name: &str) -> Scene {
    let entry = bundled()
        .into_iter()
        .find(|e| e.name.contains(name))
        .unwrap();
    let scenario = entry.read().unwrap();
    let ego = EgoSelection::Beside
        .resolve(&entry, &scenario)
        .unwrap()
        .unwrap();
    Scene::new(scenario, ego)
}

fn figure(scene: &Scene, look: FigureOptions) -> Figure<'_> {
    Figure::new(
        Subject::with_ego(scene),
        "test",
        look,
        Thresholds::shipped(),
    )
    .unwrap()
}

/// The points of every path in the group `name`, path by path, with its fill.
fn paths(picture: &Picture, name: &str) -> Vec<(Vec<Spot>, Option<Color>)> {
    let mut open = Vec::new();
    let mut found = Vec::new();
    for item in &picture.items {
        match item {
            Item::Begin { name, .. } => open.push(*name),
            Item::End => drop(open.pop()),
            Item::Path { path, fill, .. } if open.contains(&name) => {
                let spots = path.iter().filter_map(|s| match s {
                    Segment::Move(p) | Segment::Line(p) => Some(*p),
                    _ => None,
                });
                found.push((spots.collect(), *fill));
            }
            _ => {}
        }
    }
    found
}

#[test]
fn the_ego_has_its_real_size_and_place_on_the_page() {
    let scene = scene("RedLight");
    for (ego_up, size) in [(false, (240.0, Some(160.0))), (true, (500.0, Some(90.0)))] {
        let look = FigureOptions {
            seen: MapExtent::Ego { width: 60.0 },
            size,
            ego_up,
            ..FigureOptions::default()
        };
        let picture = figure(&scene, look).at(40);
        let (corners, _) = &paths(&picture, "ego")[0];
        let placed = scene.ego_at(40).unwrap();
        let real: Vec<Point> = placed.outlines().concat();
        assert_eq!(corners.len(), real.len());
        // 60 m from the left to the right end of the map, as wide as the page but for half of its frame's line.
        let scale = (size.0 - 0.5) / 60.0;
        for i in 0..real.len() {
            let j = (i + 1) % real.len();
            let there = (real[i] - real[j]).norm() * scale;
            let here = (corners[i].0 - corners[j].0).hypot(corners[i].1 - corners[j].1);
            assert!((there - here).abs() < 1e-6, "{there} {here}");
        }
        let middle = corners
            .iter()
            .fold((0.0, 0.0), |s, c| (s.0 + c.0 / 4.0, s.1 + c.1 / 4.0));
        assert!((middle.0 - picture.size.0 / 2.0).abs() < 1e-6, "{middle:?}");
        assert!((middle.1 - picture.size.1 / 2.0).abs() < 1e-6, "{middle:?}");
    }
}

#[test]
fn labels_lie_over_nothing_that_matters() {
    for name in ["RedLight", "CutIn", "Merge", "JamTail"] {
        let scene = scene(name);
        let look = FigureOptions {
            seen: MapExtent::Ego { width: 200.0 },
            ..FigureOptions::default()
        };
        let picture = figure(&scene, look).at(30);
        let mut open = Vec::new();
        let mut boxes: Vec<Area> = Vec::new();
        for item in &picture.items {
            match item {
                Item::Begin { name, .. } => open.push(*name),
                Item::End => drop(open.pop()),
                Item::Text(text) if open.contains(&"labels") => {
                    let width = Text::width(&text.words, text.size);
                    let (x, y) = text.at;
                    boxes.push(Area {
                        x: x - width / 2.0,
                        y: y - text.size * 0.76,
                        width,
                        height: text.size * 0.86,
                    });
                }
                _ => {}
            }
        }
        assert!(boxes.len() > 1, "{name}");
        for (i, a) in boxes.iter().enumerate() {
            assert!(
                boxes[i + 1..].iter().all(|b| !a.meets(b)),
                "{name}: {boxes:?}"
            );
        }
    }
}

#[test]
fn the_contact_is_marked_at_its_step_alone() {
    let scene = scene("RedLight");
    let figure = figure(&scene, FigureOptions::default());
    let step = figure.telling_step();
    assert!(!paths(&figure.at(step), "contact").is_empty());
    assert!(paths(&figure.at(step - 5), "contact").is_empty());
    assert_eq!(figure.obstacles(), [301]);
}

#[test]
fn plots_shade_the_window_of_the_question_and_mark_the_contact() {
    let drawn = |name, end, step| {
        let look = FigureOptions {
            what: FigureContent::Plot,
            window: Some(WindowRule { end, history: 10 }),
            ..FigureOptions::default()
        };
        let scene = scene(name);
        let picture = figure(&scene, look).at(step);
        let window = paths(&picture, "window");
        let contact = paths(&picture, "contact");
        let across = |spots: &[Spot]| Area::around(spots).map(|a| (a.x, a.right()));
        let named = svg(&picture).contains(">contact<");
        assert_eq!(named, !contact.is_empty(), "{name}");
        let first = |all: Vec<(Vec<Spot>, _)>| all.first().and_then(|(s, _)| across(s));
        (first(window), first(contact), scene.steps())
    };
    let (moving, contact, steps) = drawn("RedLight", WindowEnd::Present, 40);
    let (last, _, _) = drawn("RedLight", WindowEnd::Recording, 40);
    let ((from, to), (end_from, end_to)) = (moving.unwrap(), last.unwrap());
    // Ten steps, nine times the way between two.
    let step = (to - from) / 9.0;
    assert!((end_to - end_from - 9.0 * step).abs() < 1e-6);
    let later = (steps.end - 1 - 40) as f64 * step;
    assert!((end_to - to - later).abs() < 1e-6, "{end_to} {to} {later}");
    // The contact at step 59, as the judge has it.
    let contact = contact.unwrap();
    assert!((contact.0 - to - 19.0 * step).abs() < 1e-6, "{contact:?}");
    assert_eq!(drawn("CutIn", WindowEnd::Present, 20).1, None);
}

#[test]
fn the_same_figure_is_the_same_bytes() {
    let scene = scene("CutIn");
    let look = || FigureOptions {
        what: FigureContent::Both,
        measures: MEASURES
            .iter()
            .filter(|m| ["ttc", "risk"].contains(&m.id))
            .collect(),
        ..FigureOptions::default()
    };
    let pictures = [figure(&scene, look()).at(20), figure(&scene, look()).at(20)];
    let texts = pictures.each_ref().map(svg);
    assert_eq!(texts[0], texts[1]);
    assert!(texts[0].contains("<metadata>") && texts[0].contains("time to collision (s)"));
    assert_eq!(
        texts[0].matches("<g ").count(),
        texts[0].matches("</g>").count()
    );
    let images = pictures.each_ref().map(|p| png(p, 100.0).unwrap());
    assert!(images[0] == images[1]);
}

#[test]
fn a_png_has_the_pixels_that_were_asked_for_and_too_many_are_refused() {
    let scene = scene("Merge");
    let look = FigureOptions {
        size: (800.0 * PIXEL, Some(500.0 * PIXEL)),
        ..FigureOptions::default()
    };
    let picture = figure(&scene, look).at(0);
    let bytes = png(&picture, 96.0).unwrap();
    let decoder = ::png::Decoder::new(std::io::Cursor::new(&bytes[..]));
    let reader = decoder.read_info().unwrap();
    let info = reader.info();
    assert_eq!((info.width, info.height), (800, 500));
    assert_eq!(info.pixel_dims.unwrap().xppu, 3780);
    assert!(info.utf8_text.iter().any(|t| t.keyword == "sha256"));
    let error = png(&picture, 2400.0 * 10.0).unwrap_err();
    assert!(error.to_string().contains("lower resolution"), "{error}");
}

#[test]
fn an_animation_has_a_frame_for_every_step_and_can_be_stopped() {
    let scene = scene("RightTurn");
    let figure = figure(&scene, FigureOptions::default());
    let stop = AtomicBool::new(false);
    let mut bytes = Vec::new();
    let count = animate(
        &mut bytes,
        12,
        0.1,
        50.0,
        |i| Ok(figure.at(i as i64)),
        &stop,
    )
    .unwrap();
    assert_eq!(count, 12);
    let mut reader = gif::Decoder::new(&bytes[..]).unwrap();
    let (mut frames, mut time) = (0, 0);
    while let Some(frame) = reader.read_next_frame().unwrap() {
        frames += 1;
        time += frame.delay;
    }
    assert_eq!((frames, time), (12, 12 * 10 + 100));
    // Steps of a hundredth of a second: viewers show no frame shorter than two.
    let mut fast = Vec::new();
    let count = animate(
        &mut fast,
        12,
        0.01,
        30.0,
        |i| Ok(figure.at(i as i64)),
        &stop,
    )
    .unwrap();
    assert_eq!(count, 6);
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
    let stopped = animate(
        Vec::new(),
        12,
        0.1,
        50.0,
        |i| Ok(figure.at(i as i64)),
        &stop,
    );
    assert!(matches!(stopped, Err(AnimationError::Stopped)));
}

#[test]
fn who_is_not_there_cannot_be_pointed_out() {
    let scene = scene("RedLight");
    let wanted = |id| FigureOptions {
        obstacles: vec![id],
        ..FigureOptions::default()
    };
    let subject = Subject::with_ego(&scene);
    let error = |look| Figure::new(subject, "test", look, Thresholds::shipped()).err();
    assert_eq!(error(wanted(-5)), Some(FigureError::NoSuchObstacle(-5)));
    let alone = Subject {
        scenario: &scene.scenario,
        scene: None,
    };
    let plot = FigureOptions {
        what: FigureContent::Plot,
        ..FigureOptions::default()
    };
    let none = Figure::new(alone, "test", plot, Thresholds::shipped()).err();
    assert_eq!(none, Some(FigureError::NoEgo));
    assert!(
        Figure::new(
            alone,
            "test",
            FigureOptions::default(),
            Thresholds::shipped()
        )
        .is_ok()
    );
}
