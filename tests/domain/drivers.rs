//! Drivers: the models of UN Regulation 157 against a program of others, and all of them on recordings.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use nearmiss::formats::find;
use nearmiss::geometry::Pose;
use nearmiss::metrics::{Context, Grade, critical_moments};
use nearmiss::scenario::{Motion, Scenario, Scene};
use nearmiss_drive::driver::family::{Case, Family};
use nearmiss_drive::driver::{DRIVERS, DriverResult, Field, Preventability, driver};

use crate::support::program::skipped;
use crate::support::recorded::shared;

/// Every n-th case of the grids is run.
fn every() -> usize {
    let asked = std::env::var("NEARMISS_JRC_EVERY").ok();
    asked.map_or(29, |n| n.parse().expect("a number of cases"))
}

fn line(id: &str, case: &Case) -> String {
    match *case {
        Case::CutIn {
            speed,
            other,
            gap,
            lateral,
        } => format!("{id},cut_in,{speed:?},{other:?},{gap:?},{lateral:?}"),
        Case::CutOut {
            speed,
            front,
            lateral,
        } => format!("{id},cut_out,{speed:?},{front:?},{lateral:?},"),
        Case::Braking {
            speed,
            deceleration,
        } => format!("{id},braking,{speed:?},{deceleration:?},,"),
    }
}

#[test]
fn four_drivers_do_what_the_joint_research_centre_s_program_says() {
    let Some(folder) = std::env::var_os("NEARMISS_JRC_FSM") else {
        skipped("NEARMISS_JRC_FSM names no checkout of JRC-FSM");
        return;
    };
    let grid: Vec<Case> = Family::ALL.into_iter().flat_map(Case::grid).collect();
    let mut asked = String::new();
    let mut expected = Vec::new();
    for (id, case) in ["cc", "r157", "rss", "fsm"]
        .iter()
        .flat_map(|id| grid.iter().map(move |case| (id, case)))
    {
        let model = driver(id).expect("a driver");
        if let Some(result) = case.with(model) {
            expected.push((line(id, case), result));
        }
    }
    let expected: Vec<_> = expected.into_iter().step_by(every()).collect();
    for (line, _) in &expected {
        writeln!(asked, "{line}").expect("written");
    }
    let python = std::env::var("NEARMISS_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/jrc_fsm.py");
    let mut child = Command::new(python)
        .arg(script)
        .env("JRC_FSM", folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python starts");
    let mut input = child.stdin.take().expect("piped");
    let writer = std::thread::spawn(move || input.write_all(asked.as_bytes()));
    let output = child.wait_with_output().expect("python ends");
    writer.join().expect("no panic").expect("written");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let (mut differ, mut contacts, mut worst) = (Vec::new(), 0, 0.0_f64);
    for ((line, ours), answer) in expected.iter().zip(text.lines()) {
        let theirs = answer
            .strip_prefix(line.as_str())
            .expect("the same case")
            .trim_start_matches(',');
        let (closing, gap) = theirs.split_once(',').unwrap_or(("", theirs));
        let gap: f64 = gap.parse().expect("a gap");
        assert!((gap - ours.gap).abs() < 1e-9, "{answer}: {ours:?}");
        match (closing.parse::<f64>().ok(), ours.closing_speed) {
            (Some(theirs), Some(ours)) => {
                contacts += 1;
                worst = worst.max((theirs - ours).abs());
                if (theirs - ours).abs() > 1e-6 {
                    differ.push(format!("{answer} / {ours}"));
                }
            }
            (None, None) => {}
            (_, ours) => differ.push(format!("{answer} / {ours:?}")),
        }
    }
    let all = expected.len();
    println!(
        "{all} cases, {contacts} contacts, {} differ, largest difference {worst:e} m/s",
        differ.len()
    );
    for one in differ.iter().take(50) {
        println!("{one}");
    }
    assert_eq!(text.lines().count(), all);
    assert!(
        differ.len() * 1000 <= all,
        "{} of {all} differ",
        differ.len()
    );
}

#[test]
fn every_driver_says_what_it_is() {
    for driver in DRIVERS {
        for text in [
            driver.id,
            driver.name,
            driver.formula,
            driver.source,
            driver.limits,
        ] {
            assert!(
                !text.is_empty() && !text.contains("  "),
                "{}: {text}",
                driver.id
            );
        }
        for parameter in driver.parameters {
            let said = driver.formula.contains(parameter.symbol);
            assert!(
                said,
                "{}: {} is not in the formula",
                driver.id, parameter.symbol
            );
        }
    }
}

/// A recorded encounter that is a contact, a conflict or a near miss.
struct Encounter {
    name: String,
    scene: Scene,
    obstacle: i64,
    step: i64,
    grade: Grade,
}

/// The worst encounters of every n-th recording: with the recorded ego, or with the first obstacles in its place.
fn encounters() -> Option<Vec<Encounter>> {
    let folders: Vec<PathBuf> = [
        "from-words-to-collisions",
        "waymo-motion",
        "argoverse2",
        "commonroad-io",
    ]
    .iter()
    .filter_map(|part| shared(part))
    .collect();
    if folders.is_empty() {
        return None;
    }
    let found = find(&folders).expect("folders");
    let mut all = Vec::new();
    for entry in found.entries {
        let Ok(scenario) = entry.read() else { continue };
        let mut scenes = Vec::new();
        match entry.recorded_ego(&scenario) {
            Ok(Some(ego)) => scenes.push(Scene::new(Arc::clone(&scenario), ego)),
            _ => scenes.extend(
                { scenario.obstacles.iter().take(20) }
                    .filter_map(|o| Scene::with_obstacle_as_ego(Arc::clone(&scenario), o.id).ok()),
            ),
        }
        for scene in scenes {
            let context = Context::new(&scene);
            let worst = critical_moments(&context).into_iter().take(2);
            let worst: Vec<_> = worst.filter(|moment| moment.grade.number() <= 2).collect();
            drop(context);
            all.extend(worst.into_iter().map(|moment| Encounter {
                name: format!("{} ego {}", entry.name, scene.ego.id),
                scene: scene.clone(),
                obstacle: moment.obstacle,
                step: moment.step,
                grade: moment.grade,
            }));
        }
    }
    Some(all)
}

#[test]
fn recorded_encounters_and_the_ideal_driver_s_bound() {
    let Some(all) = encounters() else { return };
    let mut table: BTreeMap<(String, &str, &str), usize> = BTreeMap::new();
    let (mut beaten, mut whole, mut slowest) = (0, Duration::ZERO, Duration::ZERO);
    let (mut prepared, mut lasts) = (Duration::ZERO, Duration::ZERO);
    let (mut events, mut steered) = (0, 0);
    let mut times = Vec::new();
    for one in &all {
        let began = Instant::now();
        let Some(field) = Field::around(&one.scene, one.obstacle, one.step) else {
            continue;
        };
        prepared += began.elapsed();
        let found = Preventability::of(&field);
        let took = began.elapsed();
        whole += took;
        times.push(took);
        slowest = slowest.max(took);
        events += 1;
        let began = Instant::now();
        let found = found.with_last_moments(&field);
        lasts += began.elapsed();
        let kind = if found.contact.is_some() {
            "contact"
        } else {
            "no contact"
        };
        for verdict in &found.verdicts {
            *table
                .entry((
                    format!("{kind} {:?}", one.grade),
                    verdict.driver.id,
                    verdict.result.outcome().name(),
                ))
                .or_default() += 1;
        }
        let alone = field.ideal_ride(found.from);
        if let Some(ride) = &alone {
            steered += usize::from(ride.states.iter().any(|s| s.spot.aside != 0.0));
            let drive = Scene {
                scenario: Arc::clone(&one.scene.scenario),
                ego: field.ego_of(ride),
            };
            // Its motion as a scene touches what the ride says.
            let context = Context::new(&drive);
            let is_on_way = |step: i64| {
                let state = ride.states.iter().find(|state| state.step == step);
                state.is_some_and(|state| field.is_on_way(&state.spot))
            };
            let mut others = context.participants().iter().enumerate();
            let touches = others.any(|(place, other)| {
                let is_in_it = other.obstacle.id == one.obstacle;
                let mut contacts = context.contacts(place).iter();
                contacts.any(|c| {
                    c.step > found.from && !c.is_possible && (is_in_it || is_on_way(c.step))
                })
            });
            let (said, step) = (ride.touch.is_some(), one.step);
            assert_eq!(touches, said, "{} {} at {step}", one.name, one.obstacle);
        }
        let ideal = found.by("ideal").expect("a driver").result;
        let others = found
            .verdicts
            .iter()
            .any(|v| v.driver.id != "ideal" && v.result == DriverResult::Avoided);
        assert!(!others || ideal == DriverResult::Avoided, "{}", one.name);
        let speed = |result: &DriverResult| result.contact().map_or(0.0, |c| c.closing_speed);
        for other in found.verdicts.iter().filter(|v| v.result.decides()) {
            let (bound, own) = (speed(&ideal), speed(&other.result));
            assert!(
                bound <= own,
                "{} {}: {bound} > {own}",
                one.name,
                other.driver.id
            );
        }
        if others && alone.is_none_or(|ride| ride.touch.is_some()) {
            beaten += 1;
            println!(
                "the search alone finds less: {} {} at {}",
                one.name, one.obstacle, one.step
            );
        }
        if found.contact.is_none() {
            for verdict in found
                .verdicts
                .iter()
                .filter(|v| matches!(v.result, DriverResult::NotAvoided(_)))
            {
                println!(
                    "{} crashes where none was: {} {} at {} {:?}",
                    verdict.driver.id,
                    one.name,
                    one.obstacle,
                    one.step,
                    verdict
                        .result
                        .contact()
                        .map(|t| (t.obstacle, t.closing_speed))
                );
            }
        }
    }
    for ((kind, driver, word), count) in &table {
        println!("{kind:25} {driver:6} {word:16} {count}");
    }
    times.sort();
    let median = times.get(times.len() / 2).copied().unwrap_or_default();
    println!(
        "{events} events: {:?} each ({median:?} median, {slowest:?} slowest), of this the field {:?}; last moments {:?} each; the search alone was beaten {beaten} times",
        whole / events.max(1),
        prepared / events.max(1),
        lasts / events.max(1)
    );
    // The bound holds by construction; the search must find nearly all of it by itself.
    assert!(beaten * 10 <= events, "{beaten} of {events}");
    // Some are avoided by steering alone.
    assert!(
        events > 40 && steered > 4,
        "{events} events, {steered} steered"
    );
}

#[test]
fn another_future_changes_nothing_that_was_done_before() {
    let Some(all) = encounters() else { return };
    let mut compared = 0;
    for one in all.iter().step_by(2) {
        let scene = &one.scene;
        let dt = scene.scenario.dt();
        let Some(field) = Field::around(scene, one.obstacle, one.step) else {
            continue;
        };
        for now in [one.step - 20, one.step - 10, one.step - 4] {
            if !field.steps().contains(&now) {
                continue;
            }
            let mut changed = Scenario::clone(&scene.scenario);
            for obstacle in &mut changed.obstacles {
                let later = obstacle.track().steps().end;
                let elsewhere = |step: i64| {
                    let motion = obstacle.track().at(step)?;
                    let away = nearmiss::geometry::Vector::new(3.0, 1.0) * (step - now) as f64;
                    let pose = Pose {
                        position: motion.pose.position + away,
                        ..motion.pose
                    };
                    Some((
                        step,
                        Motion {
                            pose,
                            velocity: motion.velocity + 3.0,
                            acceleration: 5.0,
                        },
                    ))
                };
                let motions: Vec<_> = (now + 1..later).filter_map(elsewhere).collect();
                if let Some(other) = obstacle.departing(&motions, dt) {
                    *obstacle = other;
                }
            }
            let other = Scene {
                scenario: Arc::new(changed),
                ego: scene.ego.clone(),
            };
            let Some(with_other) = Field::around(&other, one.obstacle, one.step) else {
                continue;
            };
            for driver in DRIVERS.iter().filter(|driver| driver.id != "ideal") {
                let until = |field: &Field<'_>| {
                    let ride = field.ride_of(driver, field.steps().start).expect("a ride");
                    let done: Vec<_> = { ride.states.into_iter() }
                        .take_while(|state| state.step <= now + 1)
                        .collect();
                    let reacts = ride.reacts.filter(|step| *step <= now);
                    (done, reacts)
                };
                let (before, after) = (until(&field), until(&with_other));
                // A contact on the way to the next step is the world's, not the driver's.
                let both = before.0.len().min(after.0.len());
                assert_eq!(
                    before.0[..both],
                    after.0[..both],
                    "{} {}",
                    one.name,
                    driver.id
                );
                assert_eq!(before.1, after.1, "{} {}", one.name, driver.id);
                compared += 1;
            }
        }
    }
    assert!(compared > 100, "{compared} rides");
}
