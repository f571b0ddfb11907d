//! Tests of what command line and workbench both rely on.

use std::path::Path;

use super::*;
use nearmiss_drive::planner::{Cancel, Forecast};
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::{EgoSelection, Entry, bundled};

fn settings() -> Settings {
    let mut settings = nearmiss_study::evaluation::default_planning();
    settings.forecast = Forecast::ConstantVelocity;
    settings.planner.horizon = 2.0;
    settings
}

fn request<'a>(entry: &'a Entry, settings: &'a Settings) -> PlanRequest<'a> {
    PlanRequest {
        open: OpenRequest {
            entry,
            ego: &EgoSelection::Beside,
            transform: None,
            strict: false,
            stand_in: StandIn::None,
        },
        problem: None,
        settings,
    }
}

/// A bundled scenario with its ego, as a file of its own.
pub fn copied(folder: &Path, name: &str) -> Entry {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../scenarios")
        .join(name);
    for ending in ["xml", "ego_trajectory.csv"] {
        let to = folder.join("v").with_extension(ending);
        std::fs::copy(shipped.with_extension(ending), to).unwrap();
    }
    Entry::of_file(&folder.join("v.xml"))
}

/// A bundled scenario that has another planning problem before its own; its recorded ego lies beside it or not.
fn with_two_problems(folder: &Path, ego: bool) -> Entry {
    let entry = bundled().remove(0);
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../scenarios")
        .join(&entry.name);
    let xml = std::fs::read_to_string(shipped.with_extension("xml")).unwrap();
    let start = xml.find("<planningProblem").unwrap();
    let end = xml.find("</planningProblem>").unwrap() + "</planningProblem>".len();
    let id = entry.read().unwrap().planning_problems[0].id;
    let problem = &xml[start..end];
    let other = problem.replacen(&format!("id=\"{id}\""), "id=\"98765\"", 1);
    let path = folder.join("two.xml");
    std::fs::write(
        &path,
        xml.replacen(problem, &format!("{other}{problem}"), 1),
    )
    .unwrap();
    if ego {
        let csv = shipped.with_extension("ego_trajectory.csv");
        std::fs::copy(csv, folder.join("two.ego_trajectory.csv")).unwrap();
    }
    Entry::of_argument(&path)
}

#[test]
fn the_recorded_egos_problem_is_planned_wherever_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let settings = settings();
    let entry = with_two_problems(folder.path(), true);
    let own = prepare(&request(&entry, &settings)).unwrap();
    assert_ne!(own.problem().id, 98765);
    assert_eq!(own.problem().id, own.recorded.as_ref().unwrap().ego.id);
    let other = PlanRequest {
        problem: Some(98765),
        ..request(&entry, &settings)
    };
    assert_eq!(prepare(&other).unwrap().problem().id, 98765);

    let bare = tempfile::tempdir().unwrap();
    let entry = with_two_problems(bare.path(), false);
    let first = prepare(&request(&entry, &settings)).unwrap();
    assert_eq!(first.problem().id, 98765);
}

#[test]
fn what_is_cancelled_has_no_outcome_and_says_nothing_more() {
    let settings = settings();
    let entry = bundled().remove(0);
    let prepared = prepare(&request(&entry, &settings)).unwrap();
    let cancel = Cancel::default();
    let mut cycles = 0;
    let outcome = prepared.run(&cancel, &mut |PlanEvent::Cycle { done, .. }| {
        cycles += 1;
        assert_eq!(done, cycles);
        if cycles == 3 {
            cancel.ask();
        }
    });
    assert!(outcome.unwrap().is_none());
    assert_eq!(cycles, 3);
}

#[test]
fn errors_name_the_scenario_and_what_is_there() {
    let settings = settings();
    let entry = bundled().remove(0);
    let wrong = PlanRequest {
        problem: Some(-4),
        ..request(&entry, &settings)
    };
    let error = prepare(&wrong).unwrap_err();
    assert!(matches!(error, PlanError::Mismatch(_)));
    let words = error.to_string();
    assert!(words.starts_with(&entry.display()) && words.contains("the only one is"));
    let prepared = prepare(&request(&entry, &settings)).unwrap();
    let absent = GenerateRequest {
        prepared: &prepared,
        attackers: &[-4],
        wish: None,
        delay: 0.5,
        style: nearmiss_drive::generation::AttackStyle::Human,
        source: AttackSource::Search(&nearmiss_drive::generation::Effort::default()),
    };
    let error = generate(&absent, &Cancel::default(), &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("no obstacle -4"));
}

/// A bundled scenario without the ego that lies beside it, and without its planning problems unless they are kept.
fn without_ego(folder: &Path, keeps_problem: bool) -> Entry {
    let xml = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/ZAM_CutIn-1_1_T-1.xml");
    let mut text = std::fs::read_to_string(xml).unwrap();
    if !keeps_problem {
        let (from, to) = ("<planningProblem", "</planningProblem>");
        let (start, end) = (text.find(from).unwrap(), text.rfind(to).unwrap());
        text.replace_range(start..end + to.len(), "");
    }
    let path = folder.join("alone.xml");
    std::fs::write(&path, text).unwrap();
    Entry::of_argument(&path)
}

#[test]
fn without_a_recorded_ego_the_planner_drives_or_the_most_dangerous_pair_chooses() {
    let settings = settings();
    let opened = |keeps_problem, ego: &EgoSelection, stand_in| {
        let folder = tempfile::tempdir().unwrap();
        let entry = &without_ego(folder.path(), keeps_problem);
        open(&OpenRequest {
            entry,
            ego,
            transform: None,
            strict: true,
            stand_in,
        })
        .unwrap()
    };
    let beside = &EgoSelection::Beside;
    let driven = opened(true, beside, StandIn::Planner(&settings));
    let ego = &driven.scene.as_ref().unwrap().ego;
    assert!(driven.stands_in && ego.source.to_string().starts_with("planned by nearmiss"));
    let note = &ego.diagnostics[0].message;
    assert!(
        note.contains("the built-in planner drives planning problem"),
        "{note}"
    );
    // What takes time is left to the caller, which shows that it is under way.
    let later = opened(true, beside, StandIn::Follower);
    assert_eq!(later.scene.unwrap_err(), MissingEgo::NotRecorded);
    for stand_in in [StandIn::Follower, StandIn::Planner(&settings)] {
        let chosen = opened(false, beside, stand_in);
        let ego = &chosen.scene.as_ref().unwrap().ego;
        let note = &ego.diagnostics[0].message;
        assert!(
            note.contains(&format!("the ego is {}, the follower", ego.id)),
            "{note}"
        );
        let id = ego.id;
        let other = opened(false, &EgoSelection::Obstacle(id), stand_in);
        assert!(!other.stands_in && other.scene.unwrap().ego.diagnostics.is_empty());
    }
    let nobody = opened(false, beside, StandIn::None);
    assert_eq!(nobody.scene.unwrap_err(), MissingEgo::NotRecorded);
}
