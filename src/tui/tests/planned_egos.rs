//! Planned egos that are restored, exported and listed; and messages if nothing is planned.

use std::sync::Arc;

use super::bench::Bench;
use super::drive_fixtures::planned;
use crate::features::planner::cycle::CycleScreen;
use crate::features::planner::request::{self, Plan, SaveDrive};
use crate::features::values::ReadThresholds;
use crate::loaded::{DriveFiles, DriveKey, Opened, PlannedEgo};
use crate::message::{Effect, Msg};
use crate::model::Update;
use nearmiss_drive::planner::{Bound, Broken, Forecast};
use nearmiss_drive::simulation::{
    BeyondVehicle, Clock, ExternalReport, Outcome, PlannerError, PlannerFault,
};
use nearmiss_formats::bundled;
use nearmiss_formats::commonroad::read_solution;
use nearmiss_scene::scenario::Prediction;

/// How often planning was asked for.
fn begun(bench: &Bench) -> usize {
    let begin = |e: &&Effect| matches!(e.request(), Some(Plan { planner: 0, .. }));
    bench.effects.iter().filter(begin).count()
}

/// The last drive that was asked for ends.
fn arrive(bench: &mut Bench) {
    let last = bench
        .effects
        .iter()
        .rev()
        .find_map(|effect| match effect.request() {
            Some(Plan {
                id,
                entry,
                forecast,
                planner: 0,
                ..
            }) => Some((*id, entry.clone(), *forecast)),
            _ => None,
        });
    let (id, entry, forecast) = last.expect("planning was asked for");
    let ended = planned(&entry, forecast).map(Box::new);
    bench.send(Msg::reply::<Plan>((id, Update::Ended(ended))));
}

/// The last drive that was asked for ends as that of a process that died, with steps that no vehicle can do.
fn arrive_failed(bench: &mut Bench) {
    let last = bench
        .effects
        .iter()
        .rev()
        .find_map(|effect| match effect.request() {
            Some(Plan {
                id,
                entry,
                forecast,
                planner: 0,
                ..
            }) => Some((*id, entry.clone(), *forecast)),
            _ => None,
        });
    let (id, entry, forecast) = last.expect("planning was asked for");
    let mut opened = planned(&entry, forecast).unwrap();
    let mut of = PlannedEgo::clone(opened.planned.as_deref().unwrap());
    let broken = Broken {
        step: 3,
        bound: Bound::Slip,
        value: 0.04,
        most: 0.02,
    };
    of.beyond = Some(BeyondVehicle {
        steps: 8,
        first: broken,
        worst: broken,
    });
    of.outcome = Outcome::PlannerError(PlannerError {
        fault: PlannerFault::Died,
        step: 11,
    });
    of.process = Some(Box::new(ExternalReport {
        planner: "lab".into(),
        name: "minimal".into(),
        version: "1".into(),
        clock: Clock::default(),
        predictions: false,
        history: 0,
        fault: Some(PlannerFault::Died),
        fault_step: Some(11),
        message: None,
        stderr: Vec::new(),
        started_in: None,
        overhead_ms: Vec::new(),
        late_steps: 0,
        largest_offset: 0.0,
    }));
    opened.planned = Some(Arc::new(of));
    let ended = Ok(Box::new(opened));
    bench.send(Msg::reply::<Plan>((id, Update::Ended(ended))));
}

#[test]
fn a_planner_that_died_is_named_and_what_no_vehicle_can_do_is_shown() {
    let mut bench = Bench::bundled();
    bench.press("space e p");
    arrive_failed(&mut bench);
    let message = said(&bench);
    assert!(
        message.starts_with(
            "ego planned: lab failed: the planner ended at step 11, where the drive ends; "
        ),
        "{message}"
    );
    let scene = bench.model.scene().unwrap();
    let until = format!(
        "ego planned until {:.1} s",
        scene.time_of(scene.last_step())
    );
    for (columns, rows) in [(80, 24), (200, 60)] {
        let header = bench.frame(columns, rows);
        let header = header.lines().next().unwrap();
        assert!(header.contains(&until), "{header}");
    }
    bench.press("space e w");
    let panel = bench.frame(200, 60);
    for words in [
        "predictions not asked for",
        "vehicle    8 steps beyond the vehicle, worst: slip",
        "lab failed: the planner ended",
    ] {
        assert!(panel.contains(words), "{words}\n{panel}");
    }
    // A name that fills its column keeps its distance.
    assert!(bench.frame(80, 24).contains("predictions not asked"));
}

/// The first bundled scenario, its ego planned.
fn driven() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("space e p");
    arrive(&mut bench);
    bench
}

fn said(bench: &Bench) -> String {
    let last = bench.model.toasts.last();
    last.map_or(String::new(), |toast| toast.text.clone())
}

fn outcome_and_ego(bench: &Bench) -> Option<String> {
    let scene = bench.model.scene()?;
    bench.model.planned().map(|_| scene.ego.to_string())
}

#[test]
fn a_planned_ego_is_there_again_when_its_scenario_is() {
    let mut bench = driven();
    let ego = outcome_and_ego(&bench).unwrap();
    bench.press("down");
    assert_eq!(outcome_and_ego(&bench), None);
    bench.press("up");
    assert_eq!(outcome_and_ego(&bench), Some(ego.clone()));
    assert!(said(&bench).starts_with("the planned ego again: "));
    assert_eq!(begun(&bench), 1, "nothing is planned anew");
    // Who took it off finds the recorded one, and gets the drive back without planning.
    bench.press("space e r down up");
    assert_eq!(outcome_and_ego(&bench), None);
    bench.press("space e p");
    assert_eq!(outcome_and_ego(&bench), Some(ego));
    assert_eq!(begun(&bench), 1);
    // An obstacle that is taken as the ego is the ego.
    bench.press("n space e t");
    assert!(bench.model.taken.is_some() && bench.model.planned().is_none());
    bench.press("down up");
    assert_eq!(outcome_and_ego(&bench), None);
}

#[test]
fn every_forecast_has_a_drive_of_its_own() {
    let mut bench = driven();
    bench.press("space e f");
    arrive(&mut bench);
    assert_eq!(begun(&bench), 2);
    bench.press("down up");
    let forecast = bench.model.planned().unwrap().forecast;
    assert_eq!(
        forecast,
        Forecast::ConstantVelocity,
        "the one that was shown"
    );
    bench.press("space e f");
    arrive(&mut bench);
    bench.press("space e f");
    assert_eq!(begun(&bench), 3, "along the lanes was driven before");
    assert_eq!(bench.model.planned().unwrap().forecast, Forecast::Lane);
}

#[test]
fn other_thresholds_measure_it_anew() {
    let mut bench = driven();
    bench.press("down");
    let thresholds = bench.model.thresholds.clone();
    bench.send(Msg::reply::<ReadThresholds>(Ok(thresholds)));
    bench.press("up");
    assert_eq!(outcome_and_ego(&bench), None, "its measures hold no longer");
}

#[test]
fn the_list_shows_the_values_of_the_ego_that_is_shown() {
    let mut bench = driven();
    let headline = bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .headline
        .clone()
        .unwrap();
    let row = |bench: &Bench| {
        let frame = bench.frame(80, 24);
        let row = frame.lines().find(|line| line.contains('▸')).unwrap();
        row.to_string()
    };
    bench.model.zoomed = true;
    let shown = row(&bench);
    assert!(shown.contains(" planned "), "{shown}");
    let distance = format!("{:.2}", headline.distance.unwrap().value);
    assert!(shown.contains(&distance), "{distance}: {shown}");
    bench.press("space e r");
    let recorded = row(&bench);
    assert!(!recorded.contains(" planned "), "{recorded}");
    assert_ne!(shown.replace(" planned", "        "), recorded);
}

#[test]
fn messages_stand_beside_the_panel() {
    let mut bench = Bench::bundled();
    bench.send(Msg::Resize(80, 24));
    bench.press("space e p");
    arrive(&mut bench);
    bench.model.toasts.clear();
    bench.press("space e w");
    let clear = bench.frame(80, 24);
    bench
        .model
        .complain("words about something else ".repeat(12));
    let covered = bench.frame(80, 24);
    assert!(covered.contains("┌ error "), "{covered}");
    let panel = |frame: &str| -> Vec<String> {
        let rows = frame.lines().skip(1).take(22);
        rows.map(|row| row.chars().skip(42).collect()).collect()
    };
    assert_eq!(panel(&clear), panel(&covered), "{covered}");
}

#[test]
fn where_nothing_can_be_planned_every_key_says_why_and_what_to_do() {
    let mut bench = Bench::bundled();
    let mut opened = (**bench.model.opened.as_ref().unwrap()).clone();
    let mut scenario = (*opened.scenario).clone();
    scenario.planning_problems.clear();
    opened.scenario = scenario.into();
    bench.model.opened = Some(Box::new(opened));
    let forecast = bench.model.driver.forecast;
    for key in ["space e p", "space e f", "space e w", "space p d"] {
        bench.model.toasts.clear();
        bench.press(key);
        let words = said(&bench);
        assert!(words.contains("no planning problem"), "{key}: {words}");
        assert!(words.contains("open another scenario"), "{key}: {words}");
        assert!(bench.model.screens.is_empty());
    }
    bench.perform("save-drive");
    assert!(said(&bench).starts_with("nothing to write: no planning problem"));
    assert_eq!(bench.model.driver.forecast, forecast);
    assert_eq!(begun(&bench), 0);
}

#[test]
fn occupancy_sets_are_told() {
    let mut bench = driven();
    bench.model.toasts.clear();
    bench.press("space e w");
    assert!(!bench.frame(200, 60).contains("is given as"));
    let opened = bench.model.opened.as_mut().unwrap();
    let mut scenario = (*opened.scenario).clone();
    let first = scenario.obstacles[0].clone();
    let region = first.footprint.as_ref().unwrap().shape().clone();
    let time = nearmiss_scene::scenario::Steps { from: 1, to: 9 };
    let parts = nearmiss_scene::scenario::ObstacleParts {
        id: first.id,
        role: nearmiss_scene::scenario::ObstacleRole::Dynamic,
        kind: first.kind,
        footprint: first.footprint.clone(),
        initial: first.initial.clone(),
        prediction: Prediction::Occupancies(vec![nearmiss_scene::scenario::Occupancy {
            time,
            region,
        }]),
        signals: Vec::new(),
    };
    scenario.obstacles[0] = nearmiss_scene::scenario::Obstacle::new(parts, scenario.dt());
    opened.scenario = scenario.into();
    let panel = bench.frame(200, 60);
    assert!(
        panel.contains(&format!("obstacle {} is given as", first.id)),
        "{panel}"
    );
}

/// What is written of a drive, into a folder.
fn files(opened: &Opened, folder: &std::path::Path) -> DriveFiles {
    let planned = opened.planned.as_ref().unwrap();
    DriveFiles {
        key: opened.drive_key().unwrap(),
        name: opened.name.clone(),
        scene: opened.scene.clone().unwrap(),
        vehicle: planned.vehicle,
        problem: planned.problem,
        folder: Some(folder.to_path_buf()),
    }
}

#[test]
fn both_files_hold_the_drive_and_nothing_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let entry = bundled().remove(0);
    let opened = planned(&entry, Forecast::Lane).unwrap();
    let job = files(&opened, folder.path());
    request::write(&job).unwrap();
    let name = |end: &str| folder.path().join(format!("{}{end}", entry.name));
    let csv = std::fs::read(name("_planned_lane.csv")).unwrap();
    let track = &job.scene.ego.track;
    let lines = String::from_utf8(csv.clone()).unwrap().lines().count();
    assert_eq!(lines, track.iter().count() + 1);
    let file = format!("solution_KS2_SM1_{}_2020a_lane.xml", entry.name);
    let bytes = std::fs::read(folder.path().join(&file)).unwrap();
    let solution = read_solution(&bytes, &file).unwrap();
    let solved = solution.problem(job.problem).unwrap();
    assert_eq!(solved.vehicle, job.vehicle);
    assert_eq!(solved.trajectory.states().len(), track.iter().count());
    request::write(&job).unwrap();
    assert!(name("_planned_lane_2.csv").is_file());
    assert_eq!(std::fs::read(name("_planned_lane.csv")).unwrap(), csv);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    let nowhere = files(&opened, &folder.path().join("nowhere"));
    let error = request::write(&nowhere).unwrap_err();
    assert!(
        error.contains("nowhere") && error.contains("`pictures`"),
        "{error}"
    );
}

#[test]
fn the_panel_says_where_the_drive_is() {
    let mut bench = driven();
    bench.model.toasts.clear();
    bench.press("space e w");
    assert!(bench.frame(200, 60).contains("until you quit; Space e s"));
    bench.perform("save-drive");
    assert!(bench.model.screens.is_top::<CycleScreen>());
    let asked = bench
        .effects
        .iter()
        .rev()
        .find_map(|effect| match effect.request() {
            Some(SaveDrive(files)) => Some(files.key),
            _ => None,
        });
    let key: DriveKey = asked.expect("writing was asked for");
    bench.send(Msg::reply::<SaveDrive>((key, Ok("a.csv and b.xml".into()))));
    assert_eq!(said(&bench), "saved as a.csv and b.xml");
    assert!(bench.frame(200, 60).contains("in a.csv and b.xml"));
    bench.send(Msg::reply::<SaveDrive>((
        key,
        Err("the disk is full".into()),
    )));
    assert!(said(&bench).contains("not written: the disk is full"));
}

#[test]
fn another_planner_is_chosen_from_the_configuration() {
    let mut bench = Bench::bundled();
    bench.press("space e n");
    assert!(said(&bench).starts_with("only the built-in planner"));
    bench.model.driver.planners = vec!["lab".into()];
    bench.press("space e n");
    assert_eq!(bench.model.driver.planner_name(), "lab");
    bench.press("space e p");
    let by = |effect: &Effect| matches!(effect.request(), Some(Plan { planner: 1, .. }));
    assert!(bench.effects.iter().any(by));
    // On its way, the next one drives instead.
    bench.press("space e n");
    assert_eq!(bench.model.driver.planner_name(), "nearmiss");
    assert_eq!(begun(&bench), 1);
}
