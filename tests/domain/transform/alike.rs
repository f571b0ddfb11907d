//! Whether two scenes are the same but for rounding, and whether the road under a point is.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nearmiss::scenario::{Obstacle, Scene, Transform};

/// The transform that undoes another; there is none for new numbers.
fn inverse(transform: &Transform) -> Option<Transform> {
    match *transform {
        Transform::Rotate(angle) => Some(Transform::Rotate(-angle)),
        Transform::Mirror => Some(Transform::Mirror),
        Transform::Move(x, y) => Some(Transform::Move(-x, -y)),
        Transform::Renumber(_) => None,
    }
}

/// What differs after a change and its undoing.
pub fn on_the_way_back(scene: &Scene, change: &Transform) -> Vec<String> {
    let changed = change.apply(scene);
    assert_ne!(changed.scene.scenario.hash, scene.scenario.hash);
    if let Some(inverse) = inverse(change) {
        return differences(scene, &inverse.apply(&changed.scene).scene);
    }
    // Of new numbers the map is the way back.
    let mut found = Vec::new();
    let pairs = scene
        .scenario
        .obstacles
        .iter()
        .zip(&changed.scene.scenario.obstacles);
    for (old, new) in pairs {
        if changed.original(new.id) != old.id || new.id == old.id {
            found.push(format!("{} became {}", old.id, new.id));
        }
        if old.track() != new.track() || old.footprint != new.footprint {
            found.push(format!("{} is another", old.id));
        }
    }
    found.extend(compared("ego", &scene.ego.track, &changed.scene.ego.track));
    found
}

fn differences(a: &Scene, b: &Scene) -> Vec<String> {
    let mut found = Vec::new();
    let (x, y) = (&a.scenario.network, &b.scenario.network);
    found.extend(compared("lanelets", &x.lanelets, &y.lanelets));
    found.extend(compared("signs", &x.signs, &y.signs));
    found.extend(compared("lights", &x.lights, &y.lights));
    let (mut before, mut after) = (x.intersections.clone(), y.intersections.clone());
    for (old, new) in before.iter_mut().zip(&mut after) {
        // Who has two others on the same side can say so of one of them only.
        let lefts: Vec<_> = old.incomings.iter().filter_map(|i| i.is_left_of).collect();
        let once = |id: &i64| lefts.iter().filter(|other| *other == id).count() == 1;
        let there = |id: &i64| old.incomings.iter().any(|i| i.id == *id);
        if !lefts.iter().all(|id| once(id) && there(id)) {
            let all = old.incomings.iter_mut().chain(&mut new.incomings);
            all.for_each(|incoming| incoming.is_left_of = None);
        }
    }
    found.extend(compared("crossings", &before, &after));
    let by_id = |scene: &Scene| -> BTreeMap<i64, Obstacle> {
        scene
            .scenario
            .obstacles
            .iter()
            .map(|o| (o.id, o.clone()))
            .collect()
    };
    found.extend(compared("obstacles", &by_id(a), &by_id(b)));
    let (p, q) = (&a.scenario.planning_problems, &b.scenario.planning_problems);
    found.extend(compared("plans", p, q));
    found.extend(compared("ego", &a.ego, &b.ego));
    found
}

/// Compares what two things say of themselves, numbers but for rounding and whole turns.
fn compared<T: std::fmt::Debug>(what: &str, a: &T, b: &T) -> Option<String> {
    let (a, b) = (format!("{a:?}"), format!("{b:?}"));
    let (x, y) = (words(&a), words(&b));
    let wrong = x.iter().zip(&y).position(|(a, b)| !alike(a, b));
    let place = wrong.or((x.len() != y.len()).then_some(x.len().min(y.len())))?;
    let near = |words: &[&str]| {
        words[place.saturating_sub(12)..]
            .iter()
            .take(16)
            .copied()
            .collect::<String>()
    };
    Some(format!("{what}: {} | {}", near(&x), near(&y)))
}

/// Numbers and what is between them.
fn words(text: &str) -> Vec<&str> {
    let of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-');
    let mut words = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let number = of_number(first);
        let mut end = rest.find(|c| of_number(c) != number).unwrap_or(rest.len());
        let exponent = rest[end..]
            .strip_prefix('e')
            .filter(|after| number && after.starts_with(of_number));
        if let Some(after) = exponent {
            end += 1 + after.find(|c| !of_number(c)).unwrap_or(after.len());
        }
        words.push(&rest[..end]);
        rest = &rest[end..];
    }
    words
}

fn alike(a: &str, b: &str) -> bool {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => {
            let off = (a - b).abs();
            let turns = (off / TAU).round() * TAU;
            off <= 1e-6 || (a.abs() <= TAU && (off - turns).abs() <= 1e-6)
        }
        _ => a == b,
    }
}

/// Where the centres of obstacles and ego are on other lanelets than before.
pub fn lanelets(scene: &Scene, change: &Transform) -> Vec<String> {
    let changed = change.apply(scene);
    let mut found = Vec::new();
    for step in scene.steps().step_by(5) {
        let before = scene.ego.track.at(step).map(|m| m.pose.position);
        let after = changed.scene.ego.track.at(step).map(|m| m.pose.position);
        let on = |scene: &Scene, p: Option<nearmiss::geometry::Point>| {
            let mut ids = p.map_or(Vec::new(), |p| scene.scenario.network.lanelets_at(&p));
            ids.sort_unstable();
            ids
        };
        let (a, b) = (on(scene, before), on(&changed.scene, after));
        if a != b {
            found.push(format!("lanelets of the ego at {step}: {a:?} became {b:?}"));
        }
    }
    found
}
