//! Whoever can reach the ego soon is described, however far away; whoever is not described is counted.

use std::sync::Arc;

use nearmiss::description::{Form, Frame, Options, describe};
use nearmiss::evaluation::{AttackTerms, Case, prepare};
use nearmiss::formats::{bundled, find};
use nearmiss::metrics::{Encounter, Thresholds, measure};
use nearmiss::prompts::{Library, Pack, Techniques};
use nearmiss::scenario::{Participant, Scene, Window};
use nearmiss::verdict::Task;

use crate::support::recorded::folder;
use crate::words::{check_spans, scene};

/// At step 48 the ego, at 29.5 m/s, and this car drive at each other: 53.6 m, 1.04 s.
const OVERTAKING: &str = "ZAM_Overtaking-1_1_T-1";
const ONCOMING: &str = "car 305";

/// The frames that describe everyone.
const FRAMES: [Frame; 5] = [
    Frame::Ego,
    Frame::Cartesian,
    Frame::Metrics,
    Frame::Picture,
    Frame::CartesianPicture,
];

/// The obstacle of the lowest time to collision at a step.
fn first(scene: &Scene, step: i64) -> Option<Participant<'_>> {
    let ttc = measure("ttc").unwrap();
    let times = scene.participants().filter_map(|other| {
        let time = ttc.compute(&Encounter::at(scene, &other, step)?).value()?;
        Some((time, other))
    });
    let first = times.min_by(|a, b| a.0.total_cmp(&b.0));
    first.map(|(_, other)| other)
}

fn text(scene: &Scene, frame: Frame, last: i64, options: &Options) -> String {
    let window = Window::ending_at(scene, last, 10);
    let described = describe(scene, frame, &window, options).unwrap();
    // How to read a picture is told with numbers that are always the same.
    if !frame.has_picture() {
        check_spans(&described);
    }
    described.text
}

/// How many windows had one of the lowest time to collision, and in how many of them it is beyond the radius.
fn check(scene: &Scene, every: usize) -> (usize, usize) {
    let (mut all, mut far) = (0, 0);
    for last in scene.steps().rev().step_by(every) {
        let Some(other) = first(scene, last) else {
            continue;
        };
        all += 1;
        let apart = scene
            .ego
            .track
            .at(last)
            .zip(other.at(last))
            .map(|(a, b)| (a.pose.position - b.pose.position).norm());
        far += usize::from(apart.is_some_and(|apart| apart > 30.0));
        let name = format!("{} {}", other.obstacle.kind.name(), other.obstacle.id);
        for frame in FRAMES {
            let text = text(scene, frame, last, &Options::default());
            let names = text.match_indices(&name);
            let mut ends = names.map(|(at, _)| text[at + name.len()..].chars().next());
            assert!(
                ends.any(|next| !next.is_some_and(|c| c.is_ascii_digit())),
                "{} {frame:?} {last}: no {name}:\n{text}",
                scene.scenario.header.benchmark_id
            );
        }
    }
    (all, far)
}

#[test]
fn the_first_to_collide_is_described_in_every_window_of_the_bundled_scenarios() {
    let mut found = (0, 0);
    for entry in bundled() {
        let (all, far) = check(&scene(&entry.name), 5);
        found = (found.0 + all, found.1 + far);
    }
    assert!(found.0 > 50 && found.1 > 10, "{found:?}");
}

#[test]
fn the_first_to_collide_is_described_in_every_window_of_the_published_scenarios() {
    let Some(folder) = folder() else { return };
    let mut found = (0, 0);
    for entry in find(&[folder]).unwrap().entries {
        let Ok(scenario) = entry.read() else { continue };
        let Ok(Some(ego)) = entry.recorded_ego(&scenario) else {
            continue;
        };
        let (all, far) = check(&Scene::new(scenario, ego), 25);
        found = (found.0 + all, found.1 + far);
    }
    assert!(found.0 > 50 && found.1 > 5, "{found:?}");
}

#[test]
fn a_small_radius_hides_nobody_who_can_reach_the_ego() {
    let scene = scene(OVERTAKING);
    for form in Form::ALL {
        for frame in FRAMES {
            let options = Options {
                form,
                radius: 1.0,
                ..Options::default()
            };
            let told = text(&scene, frame, 48, &options);
            assert!(told.contains(ONCOMING), "{frame:?}: {told}");
            // Those who are not told of are counted.
            assert_eq!(told.matches("Not described: ").count(), 1, "{frame:?}");
            let by_radius = Options {
                reach: None,
                ..options
            };
            let told = text(&scene, frame, 48, &by_radius);
            assert!(!told.contains(ONCOMING), "{frame:?}: {told}");
            assert!(told.contains("Not described: 8 others, which come no nearer than "));
        }
    }
}

#[test]
fn one_that_is_not_described_is_singular_and_nobody_is_no_line() {
    let scene = scene(OVERTAKING);
    let obstacles = scene.participants().count();
    let of_one = Options {
        obstacle: scene.participants().next().map(|p| p.obstacle.id),
        ..Options::default()
    };
    let told = text(&scene, Frame::Trajectory, 48, &of_one);
    let others = format!("Not described: {} others, which come no", obstacles - 1);
    assert!(told.contains(&others), "{told}");
    let everywhere = Options {
        radius: f64::MAX,
        ..Options::default()
    };
    let told = text(&scene, Frame::Ego, 48, &everywhere);
    assert!(!told.contains("Not described"), "{told}");
    let mut two = (*scene.scenario).clone();
    two.obstacles.truncate(2);
    let two = Scene::new(Arc::new(two), scene.ego.clone());
    let told = text(&two, Frame::Trajectory, 48, &of_one);
    assert!(told.contains("Not described: 1 other, which comes no nearer"));
}

#[test]
fn questions_have_who_can_reach_within_their_horizon_and_the_papers_the_radius() {
    let scene = Arc::new(scene(OVERTAKING));
    let asked = |pack: Pack, horizon: f64| {
        let library = Library::load(None).with_pack(pack);
        let case = Case {
            name: OVERTAKING.into(),
            scene: scene.clone(),
            task: Task::Safety,
            frame: Frame::Ego,
            techniques: Techniques::ALL,
            window: Window::ending_at(&scene, 48, 10),
            options: Options::default(),
            thresholds: Arc::new(Thresholds::shipped().clone()),
            horizon,
            attack: AttackTerms::default(),
        };
        prepare(case, &library, None).unwrap().prompt
    };
    let usual = asked(Pack::Standard, 2.0);
    assert!(usual.user.contains(ONCOMING));
    assert!(usual.system.contains("could touch it within 2.0 s"));
    // More can come in four seconds than in two.
    let named = |text: &str| {
        text.lines()
            .filter(|line| line.starts_with("0.00,"))
            .count()
    };
    assert!(named(&asked(Pack::Standard, 4.0).user) > named(&usual.user));
    let paper = asked(Pack::Paper, 2.0);
    let told = format!("{}\n{}", paper.system, paper.user);
    assert!(!told.contains(ONCOMING), "{told}");
    assert!(
        told.contains("within 30.0 m of the ego's are listed, nearest first; farther ones are not")
    );
    assert!(told.contains("Not described: 7 others"), "{told}");
}
