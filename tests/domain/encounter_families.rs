//! Families of an encounter: the recorded one is a case of its own, cases are as they were asked for, and what is written for
//! players moves as the cases do.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss::formats::{Entry, Export, ExportedEgo, bundled, write_openscenario};
use nearmiss::metrics::Thresholds;
use nearmiss::scenario::{Motion, Scene};
use nearmiss_drive::driver::{Field, Preventability};
use nearmiss_drive::generation::{EncounterFamily, Values, Varied};
use nearmiss_scene::corpus::{Event, EventKind, events};

/// Events are looked for within so many metres.
const RADIUS: f64 = 50.0;

fn scene(name: &str) -> Scene {
    let entry = bundled().into_iter().find(|entry| entry.name == name);
    let entry: Entry = entry.unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    Scene::new(Arc::clone(&scenario), ego)
}

fn family(scene: &Scene) -> EncounterFamily<'_> {
    EncounterFamily::of(scene, Thresholds::shipped(), RADIUS, false).unwrap()
}

/// The event of an obstacle in a scene.
fn event(scene: &Scene, obstacle: i64, kind: EventKind) -> Option<Event> {
    let mut all = events(scene, RADIUS).into_iter();
    all.rfind(|event| event.obstacle == obstacle && event.manoeuvre == kind)
}

/// The families that can be varied in these ways, with the event of obstacle 301 that leads to the encounter.
const FAMILIES: [(&str, Option<EventKind>, &[Varied]); 3] = [
    ("ZAM_CutIn-1_1_T-1", Some(EventKind::CutIn), &Varied::ALL),
    (
        "ZAM_HardBraking-1_1_T-1",
        Some(EventKind::Braking),
        &[Varied::Gap, Varied::Closing, Varied::Start],
    ),
    ("ZAM_RedLight-1_1_T-1", None, &[Varied::Start]),
];
const OBSTACLE: i64 = 301;

/// Shares of how far values are from the recorded one.
const SHARES: [f64; 6] = [-1.0, -0.5, -0.3, 0.3, 0.5, 1.0];

/// The recorded values with another one.
fn with(family: &EncounterFamily<'_>, varied: Varied, share: f64) -> Values {
    let mut values = family.recorded();
    values[varied as usize] += share
        * match varied {
            Varied::Gap => 5.0,
            Varied::Closing => 3.0,
            Varied::LateralSpeed => 0.7 * values[varied as usize],
            Varied::Start => 1.0,
        };
    values
}

#[test]
fn the_recorded_encounter_is_a_case() {
    for (name, kind, can) in FAMILIES {
        let scene = scene(name);
        let family = family(&scene).with_starts(&SHARES);
        let own = scene.scenario.obstacle(OBSTACLE).unwrap();
        let recorded: Vec<(i64, Motion)> = own.track().iter().map(|(s, m)| (s, *m)).collect();
        let moved = family.motion(&family.recorded());
        assert_eq!(moved.len(), recorded.len());
        for ((step, before), (same, after)) in recorded.iter().zip(&moved) {
            assert_eq!(step, same);
            let off = before.differences(after).map(|(_, off)| off.abs());
            assert!(off.iter().all(|off| *off < 1e-9), "{name} {step} {off:?}");
        }
        for varied in Varied::ALL {
            assert_eq!(family.base(varied).is_ok(), can.contains(&varied), "{name}");
        }
        if let Some(kind) = kind {
            let event = event(&scene, OBSTACLE, kind).unwrap();
            let measured = [event.gap, event.closing].map(Option::unwrap);
            assert_eq!(family.recorded()[..2], measured);
        }
        let judged = family.judge(&family.recorded()).unwrap();
        let field = Field::around(&scene, OBSTACLE, judged.step).unwrap();
        let before = Preventability::of(&field);
        let words = |found: &Preventability| -> Vec<&str> {
            found
                .verdicts
                .iter()
                .map(|v| v.result.outcome().name())
                .collect()
        };
        assert_eq!(words(&judged), words(&before));
    }
}

/// Moments are steps, and a body that is in the lane a step earlier or later is nearer or farther by what closes in one.
#[test]
fn cases_have_the_parameters_that_they_are_asked_for() {
    let mut measured = 0;
    for (name, kind, can) in FAMILIES {
        let scene = scene(name);
        let family = family(&scene).with_starts(&SHARES);
        let Some(kind) = kind else { continue };
        let first = event(&scene, OBSTACLE, kind).unwrap().first_step;
        for (varied, share) in can.iter().flat_map(|one| SHARES.map(|share| (*one, share))) {
            let values = with(&family, varied, share);
            let found = event(&family.changed(&values), OBSTACLE, kind).unwrap();
            let [gap, closing, lateral, start] = values;
            let step = closing.abs() * family.dt();
            let off = [
                (found.gap.unwrap() - gap).abs() - step,
                (found.closing.unwrap() - closing).abs(),
                (found.lateral_speed.unwrap_or_default() - lateral).abs(),
                ((found.first_step - first) as f64 - start / family.dt()).abs(),
            ];
            let most = [0.1, 0.4, 0.1 * lateral + 1e-9, 1.01];
            let is_met = off.iter().zip(most).all(|(off, most)| *off <= most);
            assert!(is_met, "{name} {} {share}: {off:?}", varied.name());
            measured += 1;
        }
    }
    assert_eq!(measured, (4 + 3) * SHARES.len());
}

#[test]
fn players_get_the_motion_of_the_case_whose_values_are_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    for (name, _, can) in FAMILIES {
        let scene = scene(name);
        let family = family(&scene).with_starts(&SHARES);
        let ranges: Vec<_> = can.iter().map(|one| (*one, [-10.0, 40.0])).collect();
        let varied = family.varied(&ranges);
        let written = write_openscenario(&Export {
            scenario: &scene.scenario,
            ego: ExportedEgo::Follows(&scene.ego),
            road_file: "roads.xodr",
            properties: &BTreeMap::new(),
            about: &[],
            varied: Some(&varied),
        })
        .unwrap();
        std::fs::write(folder.path().join("roads.xodr"), &written.roads).unwrap();
        let text = String::from_utf8(written.scenario).unwrap();
        let path = folder.path().join("case.xosc");
        let cases = can
            .iter()
            .flat_map(|one| [0.0, -0.5, 1.0].map(|share| (*one, share)));
        for (one, share) in cases {
            let values = with(&family, one, share);
            let named = format!(r#"name="{}" parameterType="double" value=""#, one.name());
            let (before, after) = text.split_once(&named).unwrap();
            let (_, after) = after.split_once('"').unwrap();
            let value = values[one as usize];
            std::fs::write(&path, format!("{before}{named}{value}\"{after}")).unwrap();
            let read = Entry::of_file(&path).read().unwrap();
            let track = read.obstacle(OBSTACLE).unwrap().track();
            let case = family.motion(&values);
            let mut compared = 0;
            for (step, motion) in &case {
                // Players stop where the ego's recording ends in contact.
                let Some(there) = track.at(*step) else {
                    continue;
                };
                let off = (there.pose.position - motion.pose.position).norm();
                assert!(
                    off < 1e-3,
                    "{name} {} {value} step {step}: {off} m",
                    one.name()
                );
                let turned = (there.pose.heading - motion.pose.heading).sin();
                assert!(
                    turned.abs() < 1e-6,
                    "{name} {} {value}: {turned}",
                    one.name()
                );
                compared += 1;
            }
            assert!(compared > 50, "{name}: {compared} of {}", case.len());
            if share != 0.0 {
                let recorded = scene.scenario.obstacle(OBSTACLE).unwrap().track();
                let moved = case.iter().filter_map(|(step, motion)| {
                    let before = recorded.at(*step)?.pose.position;
                    Some((before - motion.pose.position).norm())
                });
                assert!(moved.fold(0.0, f64::max) > 0.5, "{name} {}", one.name());
            }
        }
    }
}

#[test]
fn what_could_not_be_is_no_case() {
    let refused = |name: &str, varied: Varied, value: f64| {
        let scene = scene(name);
        let family = family(&scene);
        let mut values = family.recorded();
        values[varied as usize] = value;
        family.judge(&values).map(|_| ()).unwrap_err()
    };
    // To the side within a tenth of a second; faster backwards than the ego forwards; into the car in front.
    let steering = refused("ZAM_CutIn-1_1_T-1", Varied::LateralSpeed, 40.0);
    assert!(steering.contains("at most"), "{steering}");
    let backwards = refused("ZAM_CutIn-1_1_T-1", Varied::Closing, 40.0);
    assert_eq!(backwards, "it drives backwards");
    let touching = refused("ZAM_HardBraking-1_1_T-1", Varied::Gap, 40.0);
    assert_eq!(touching, "it touches 302");
}
