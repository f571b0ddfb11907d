//! The planner drives the ego, and what is shown of its drives.

use std::sync::Arc;
use std::time::Duration;

use crate::features::planner::cycle::CycleScreen;
use crate::features::planner::request::{Plan, SaveDrive};
use crate::features::values::ReadThresholds;
use crate::loaded::{CycleShown, DriveFiles, DriveKey, Opened, PlannedEgo};
use crate::message::{Effect, Msg};
use crate::model::{Drives, JobId, JobState, Model, OpenId, Pane, Update};
use crate::tests::bench::{Bench, coarse, planned, request};
use crate::update::Open;
use nearmiss_drive::planner::{self, Bound, Broken, Forecast};
use nearmiss_drive::simulation::{
    BeyondVehicle, Clock, ExternalReport, Outcome, PlannerError, PlannerFault, Settings,
};
use nearmiss_formats::commonroad::read_solution;
use nearmiss_formats::{Entry, bundled};
use nearmiss_scene::scenario::{EgoSource, Prediction};
use nearmiss_workflow::{MissingEgo, PlanEvent, prepare};

/// The drive that was asked for last.
fn asked(bench: &Bench) -> (JobId, Entry, Forecast) {
    let mut asks = bench
        .effects
        .iter()
        .rev()
        .filter_map(|effect| match effect.request() {
            Some(Plan {
                id,
                entry,
                forecast,
                planner: 0,
                ..
            }) => Some((*id, entry.clone(), *forecast)),
            _ => None,
        });
    asks.next().expect("planning was asked for")
}

fn begun(bench: &Bench) -> usize {
    let begin = |e: &&Effect| matches!(e.request(), Some(Plan { planner: 0, .. }));
    bench.effects.iter().filter(begin).count()
}

fn stopped(bench: &Bench) -> usize {
    let cancel = |e: &&Effect| matches!(e, Effect::Cancel(_));
    bench.effects.iter().filter(cancel).count()
}

/// What was asked for is driven to its end.
fn arrive(bench: &mut Bench) {
    let (id, entry, forecast) = asked(bench);
    let opened = planned(&entry, forecast).map(Box::new);
    bench.send(Msg::reply::<Plan>((id, Update::Progress((3, 100)))));
    bench.send(Msg::reply::<Plan>((id, Update::Ended(opened))));
}

/// A bundled scenario whose ego the planner drove.
fn driven(name: &str) -> Bench {
    let mut bench = Bench::bundled();
    bench.press("/");
    bench.type_text(name);
    bench.press("enter space e p");
    arrive(&mut bench);
    bench
}

/// Removes the recorded ego of the open scenario.
fn without_ego(bench: &mut Bench) {
    let mut opened = (**bench.model.opened.as_ref().unwrap()).clone();
    opened.scene = None;
    opened.series = None;
    opened.headline = None;
    opened.collision = None;
    opened.ranking = Vec::new();
    opened.no_ego = Some(MissingEgo::NotRecorded);
    let id = OpenId(bench.model.new_id());
    bench.model.opening = Some((id, None));
    bench.send(Msg::reply::<Open>((id, Ok(Box::new(opened)))));
}

fn is_planned(model: &Model) -> bool {
    model
        .scene()
        .is_some_and(|scene| matches!(scene.ego.source, EgoSource::Planned { .. }))
}

fn passes(bench: &mut Bench, ms: u64) {
    bench.send(Msg::Passed(Duration::from_millis(ms)));
}

#[test]
fn a_key_lets_the_planner_drive_and_another_goes_back() {
    let mut bench = Bench::bundled();
    let before = bench.model.scene().unwrap().ego.to_string();
    bench.press("space e p");
    let (id, _, forecast) = asked(&bench);
    assert_eq!(forecast, Forecast::Lane);
    bench.send(Msg::reply::<Plan>((id, Update::Progress((7, 100)))));
    assert!(bench.frame(120, 40).contains("planning 7/100"));
    assert!(
        !is_planned(&bench.model),
        "the recorded one stays until then"
    );
    arrive(&mut bench);
    assert!(is_planned(&bench.model));
    let planned = bench.model.planned().unwrap();
    let recorded = planned.recorded.as_ref().unwrap();
    assert_eq!(recorded.ego.to_string(), before);
    assert_eq!(planned.cycles[0].step, bench.model.clock.range().0);
    let frame = bench.frame(200, 60);
    assert!(frame.contains("ego planned, "), "{frame}");
    assert!(frame.contains("goes back to the recorded ego"), "{frame}");
    let job = bench.model.jobs.all.last().unwrap();
    assert_eq!(job.state, JobState::Done(planned.outcome.to_string()));
    bench.press("space e r");
    assert_eq!(bench.model.scene().unwrap().ego.to_string(), before);
    assert!(bench.model.planned().is_none());
    assert!(!bench.frame(200, 60).contains("ego planned"));
}

#[test]
fn what_is_under_way_can_be_stopped_and_ends_when_something_else_opens() {
    let mut bench = Bench::bundled();
    bench.press("space e p space e p");
    assert_eq!((begun(&bench), stopped(&bench)), (1, 1));
    assert!(bench.model.driver.under_way.is_none());
    bench.press("space e p space o j x esc");
    assert_eq!((begun(&bench), stopped(&bench)), (2, 2));
    assert!(matches!(
        bench.model.jobs.all.last().unwrap().state,
        JobState::Cancelled(_)
    ));
    bench.press("space e p down");
    assert_eq!((begun(&bench), stopped(&bench)), (3, 3));
    // What still arrives of it is dropped.
    let name = bench.model.opened.as_ref().unwrap().name.clone();
    arrive(&mut bench);
    assert_eq!(bench.model.opened.as_ref().unwrap().name, name);
    assert!(!is_planned(&bench.model));
}

#[test]
fn another_forecast_drives_anew_and_the_same_one_does_not() {
    let mut bench = driven("cutin");
    bench.press("space e p");
    assert_eq!(begun(&bench), 1, "it would be the same drive");
    bench.press("space e f");
    assert_eq!(asked(&bench).2, Forecast::ConstantVelocity);
    arrive(&mut bench);
    let planned = bench.model.planned().unwrap();
    assert_eq!(planned.forecast, Forecast::ConstantVelocity);
    assert!(
        planned.recorded.is_some(),
        "the recorded ego, not the planned one before"
    );
}

#[test]
fn a_scenario_without_an_ego_gets_one_when_it_stays_open() {
    let mut bench = Bench::bundled();
    passes(&mut bench, 900);
    assert_eq!(begun(&bench), 0, "it has an ego");
    without_ego(&mut bench);
    assert!(bench.model.moves(), "time has to pass");
    passes(&mut bench, 300);
    bench.press("down");
    passes(&mut bench, 900);
    assert_eq!(begun(&bench), 0, "it was left before");
    bench.press("up");
    without_ego(&mut bench);
    passes(&mut bench, 400);
    passes(&mut bench, 400);
    assert_eq!(begun(&bench), 1);
    assert!(bench.frame(200, 60).contains("the ego is being planned"));
    arrive(&mut bench);
    assert!(is_planned(&bench.model));
    let said = &bench.model.toasts.last().unwrap().text;
    assert!(said.starts_with("ego planned: "), "{said}");
    passes(&mut bench, 900);
    assert_eq!(begun(&bench), 1);
}

#[test]
fn who_does_not_want_a_planned_ego_gets_none_and_a_failure_is_told_once() {
    let mut bench = Bench::bundled();
    without_ego(&mut bench);
    passes(&mut bench, 700);
    bench.press("space e p");
    passes(&mut bench, 900);
    passes(&mut bench, 900);
    assert_eq!((begun(&bench), stopped(&bench)), (1, 1));
    bench.press("space e p");
    let (id, ..) = asked(&bench);
    let why = "no way leads from the start to the goal";
    bench.send(Msg::reply::<Plan>((id, Update::Ended(Err(why.into())))));
    passes(&mut bench, 900);
    assert_eq!(begun(&bench), 2);
    assert!(bench.model.toasts.iter().any(|t| t.text.contains(why)));
    assert!(bench.model.scene().is_none());
    // What cannot be read is not made up for.
    let mut opened = (**bench.model.opened.as_ref().unwrap()).clone();
    opened.no_ego = Some(MissingEgo::Unusable(
        "ego.csv: line 1 has no column `timestep`".into(),
    ));
    bench.model.driver.declined = None;
    bench.model.opened = Some(Box::new(opened));
    passes(&mut bench, 900);
    passes(&mut bench, 900);
    assert_eq!(begun(&bench), 2);
}

#[test]
fn without_a_planning_problem_it_says_so() {
    let entry = bundled().remove(0);
    let mut bench = Bench::bundled();
    let mut opened = (**bench.model.opened.as_ref().unwrap()).clone();
    let mut scenario = (*opened.scenario).clone();
    scenario.planning_problems.clear();
    opened.scenario = scenario.into();
    bench.model.opened = Some(Box::new(opened));
    bench.press("space e p");
    assert_eq!(begun(&bench), 0, "{}", entry.name);
    let said = &bench.model.toasts.last().unwrap().text;
    assert!(said.contains("no planning problem"), "{said}");
}

#[test]
fn stepping_goes_through_the_cycles() {
    let mut bench = driven("cutin");
    bench.model.toasts.clear();
    let first = bench.model.clock.range().0;
    let planned = bench.model.planned().unwrap();
    assert!(planned.cycle_at(first - 1).is_none());
    assert_eq!(planned.cycle_at(first + 5).unwrap().step, first + 5);
    assert_eq!(
        planned.cycle_at(i64::MAX).unwrap(),
        planned.cycles.last().unwrap()
    );
    let begins = |step: i64| planned.cycle_at(step).unwrap().chosen[0];
    let drives = |step: i64| {
        bench
            .model
            .scene()
            .unwrap()
            .ego
            .track
            .at(step)
            .unwrap()
            .pose
            .position
    };
    for step in [first, first + 5, first + 11] {
        let off = (begins(step) - drives(step)).norm();
        assert!(off < 1e-6, "the choice begins where the ego is: {off}");
    }
    bench.model.clock.go(first + 5);
    bench.press("space e w");
    assert!(bench.model.screens.is_top::<CycleScreen>());
    let panel = bench.frame(200, 60);
    assert!(panel.contains(&format!("step {}", first + 5)), "{panel}");
    let cycle = bench.model.cycle().unwrap();
    assert!(panel.contains(&format!("{} candidates", cycle.candidates)));
    let out: usize = cycle.rejected.iter().map(|(_, n)| n).sum();
    assert_eq!(cycle.feasible + out, cycle.candidates);
    bench.press("right");
    assert!(
        bench
            .frame(200, 60)
            .contains(&format!("step {}", first + 6))
    );
    bench.press("space e w");
    assert!(bench.model.screens.is_empty());
}

#[test]
fn the_layer_can_be_switched_off() {
    let mut bench = driven("cutin");
    bench.model.toasts.clear();
    (bench.model.zoomed, bench.model.focus) = (true, Pane::Map);
    let with = bench.frame(120, 40);
    assert!(
        with.contains("recorded") && with.contains("chosen"),
        "{with}"
    );
    bench.model.map.layers.planner = false;
    let without = bench.frame(120, 40);
    assert!(!without.contains("chosen"), "{without}");
    assert!(
        without.contains("ego planned"),
        "who drives is said in any case"
    );
}

#[test]
fn the_plot_compares_both_egos() {
    let mut bench = driven("cutin");
    bench.press("space p d");
    assert_eq!(bench.model.plot.drives, Some(Drives::Speed));
    let frame = bench.frame(200, 60);
    assert!(
        frame.contains("⠒⠒planned ") && frame.contains("⠂⠀⠂recorded "),
        "{frame}"
    );
    bench.press("space p d");
    let frame = bench.frame(200, 60);
    assert!(frame.contains("from planned to recorded ego"), "{frame}");
    bench.press("space p d");
    assert_eq!(bench.model.plot.drives, None);
    bench.press("space e r space p d");
    assert_eq!(bench.model.plot.drives, None, "nothing was planned");
}

#[test]
fn a_cycle_is_small() {
    let entry = bundled().remove(0);
    let settings = Settings {
        planner: planner::Settings::default(),
        ..coarse(Forecast::Lane)
    };
    // A few cycles of a whole fan.
    let prepared = prepare(&request(&entry, &settings)).unwrap();
    let limits = planner::Limits::for_vehicle(settings.planner.vehicle);
    let (dt, cancel) = (prepared.scenario.dt(), planner::Cancel::default());
    let mut kept = Vec::new();
    let stopped = prepared.run(&cancel, &mut |event| {
        let PlanEvent::Cycle {
            planner,
            cycle,
            traffic,
            ..
        } = event;
        kept.push(CycleShown::new(planner, &limits, cycle, &traffic(), dt));
        if kept.len() == 2 {
            cancel.ask();
        }
    });
    assert!(stopped.unwrap().is_none());
    assert_eq!(kept.len(), 2);
    for cycle in &kept {
        assert!(cycle.fan.count() <= 200 && cycle.fan.count() > 20);
        assert!(cycle.bytes() < 60_000, "{} bytes", cycle.bytes());
    }
}

#[test]
fn a_cycle_at_both_sizes() {
    for (columns, rows) in [(80, 24), (200, 60)] {
        let mut bench = Bench::bundled();
        bench.send(Msg::Resize(columns, rows));
        bench.frame(columns, rows);
        bench.press("/");
        bench.type_text("cutin");
        bench.press("enter space e p");
        arrive(&mut bench);
        bench.model.toasts.clear();
        bench.model.clock.go(12);
        bench.press("space p d");
        bench.model.toasts.clear();
        bench.press("space e w");
        insta::assert_snapshot!(
            format!("the_planner_at_{columns}_by_{rows}"),
            bench.frame(columns, rows)
        );
    }
}

#[test]
fn how_it_ended_is_said_in_short() {
    let bench = driven("cutin");
    let outcome = bench.model.planned().unwrap().outcome;
    let words = match outcome {
        Outcome::Goal(_) => "ego planned, goal reached".to_string(),
        Outcome::Collision(c) => format!("ego planned, collision with {}", c.with),
        Outcome::Timeout => "ego planned, goal not reached".to_string(),
        Outcome::OffRoad => "ego planned, off the road".to_string(),
        Outcome::Infeasible => "ego planned, cannot be driven".to_string(),
        Outcome::PlannerError(error) => format!("ego planned, {error}"),
    };
    assert!(bench.frame(120, 40).contains(&words), "{words}");
    let narrow = bench.frame(80, 24);
    assert!(narrow.contains("ego planned · ZAM_CutIn"), "{narrow}");
}

#[test]
fn the_workbench_drives_as_the_command_line_does() {
    let settings = coarse(Forecast::ConstantVelocity);
    let entry = bundled().remove(0);
    let prepared = prepare(&request(&entry, &settings)).unwrap();
    let outcome = prepared.run(&planner::Cancel::default(), &mut |_| {});
    let drive = outcome.unwrap().unwrap().drive;
    let opened = planned(&entry, settings.forecast).unwrap();
    assert_eq!(opened.planned.as_ref().unwrap().outcome, drive.outcome);
    let track = &opened.scene.as_ref().unwrap().ego.track;
    let limits = planner::Limits::for_vehicle(settings.planner.vehicle);
    for (step, state) in &drive.states {
        let place = track.at(*step).unwrap().pose.position;
        assert_eq!(place, state.centre(&limits).pose.position);
    }
}

/// The last drive that was asked for ends.
fn arrive_planned(bench: &mut Bench) {
    let (id, entry, forecast) = asked(bench);
    let ended = planned(&entry, forecast).map(Box::new);
    bench.send(Msg::reply::<Plan>((id, Update::Ended(ended))));
}

/// The last drive that was asked for ends as that of a process that died, with steps that no vehicle can do.
fn arrive_failed(bench: &mut Bench) {
    let (id, entry, forecast) = asked(bench);
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
fn driven_open() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("space e p");
    arrive_planned(&mut bench);
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
    let mut bench = driven_open();
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
    let mut bench = driven_open();
    bench.press("space e f");
    arrive_planned(&mut bench);
    assert_eq!(begun(&bench), 2);
    bench.press("down up");
    let forecast = bench.model.planned().unwrap().forecast;
    assert_eq!(
        forecast,
        Forecast::ConstantVelocity,
        "the one that was shown"
    );
    bench.press("space e f");
    arrive_planned(&mut bench);
    bench.press("space e f");
    assert_eq!(begun(&bench), 3, "along the lanes was driven before");
    assert_eq!(bench.model.planned().unwrap().forecast, Forecast::Lane);
}

#[test]
fn other_thresholds_measure_it_anew() {
    let mut bench = driven_open();
    bench.press("down");
    let thresholds = bench.model.thresholds.clone();
    bench.send(Msg::reply::<ReadThresholds>(Ok(thresholds)));
    bench.press("up");
    assert_eq!(outcome_and_ego(&bench), None, "its measures hold no longer");
}

#[test]
fn the_list_shows_the_values_of_the_ego_that_is_shown() {
    let mut bench = driven_open();
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
    arrive_planned(&mut bench);
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
    let mut bench = driven_open();
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
    crate::features::planner::request::write(&job).unwrap();
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
    crate::features::planner::request::write(&job).unwrap();
    assert!(name("_planned_lane_2.csv").is_file());
    assert_eq!(std::fs::read(name("_planned_lane.csv")).unwrap(), csv);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    let nowhere = files(&opened, &folder.path().join("nowhere"));
    let error = crate::features::planner::request::write(&nowhere).unwrap_err();
    assert!(
        error.contains("nowhere") && error.contains("`pictures`"),
        "{error}"
    );
}

#[test]
fn the_panel_says_where_the_drive_is() {
    let mut bench = driven_open();
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

#[test]
fn the_list_keeps_what_was_computed_where_no_ego_is_recorded() {
    let mut bench = crate::tests::listing::surveyed();
    for row in &mut bench.model.list.rows {
        if let Some(Ok(facts)) = &mut row.facts {
            facts.headline = None;
        }
    }
    let count = bench.model.list.rows.len();
    let frame = bench.frame(200, 60);
    let words = format!("no ego in {count} ");
    assert!(frame.contains(&words), "one is open with an ego: {frame}");
    without_ego(&mut bench);
    let frame = bench.frame(200, 60);
    let words = format!("no ego in {count}: Space e p plans one");
    assert!(frame.contains(&words), "{frame}");
    // Sorting says what comes of them.
    bench.press("space l s");
    bench.type_text("severity");
    bench.press("enter");
    let words = "once the planner has tried to drive them";
    assert!(said(&bench).contains(words), "{}", said(&bench));
    bench.press("down");
    let place = bench.model.list.opened.unwrap();
    without_ego(&mut bench);
    bench.press("space e p");
    let (id, entry, forecast) = asked(&bench);
    let mut opened = planned(&entry, forecast).map(Box::new).unwrap();
    let mut drive = PlannedEgo::clone(opened.planned.as_deref().unwrap());
    drive.recorded = None;
    opened.planned = Some(Arc::new(drive));
    bench.send(Msg::reply::<Plan>((id, Update::Ended(Ok(opened)))));
    bench.frame(200, 60);
    let list = &bench.model.list;
    assert_eq!(list.lines.len(), count);
    assert!(
        matches!(list.lines[0], crate::model::Line::Scenario(first, _) if first == place),
        "it is sorted by what is known"
    );
    bench.press("down");
    assert_ne!(bench.model.list.opened, Some(place));
    bench.model.zoomed = true;
    let frame = bench.frame(200, 60);
    let row = frame
        .lines()
        .find(|line| line.contains(&entry.name))
        .unwrap();
    assert!(row.contains(" planned "), "{row}");
    let left = format!("no ego in {}", count - 1);
    assert!(frame.contains(&left), "{frame}");
}
