//! The index of a corpus: choosing and reading it, its filter terms, the coverage map, and the session.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::features::index::ReadIndex;
use crate::features::scenarios::request::Survey;
use crate::loaded::{Facts, Verdicts};
use crate::message::{Effect, Msg};
use crate::model::{JobId, JobState, Pane, Update};
use crate::session::{Session, restore};
use crate::tests::bench::Bench;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::corpus::{
    CorpusIndex, IndexOptions, IndexedWindow, Manoeuvre, RoadType, WindowEgo, for_each_window,
};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::Config;

/// The bundled scenarios, all of them read.
fn read() -> Bench {
    let mut bench = Bench::bundled();
    for (place, entry) in bundled().iter().enumerate() {
        let facts = Facts::read(
            entry,
            &EgoSelection::Beside,
            Thresholds::shipped(),
            &Verdicts::default(),
        );
        bench.send(Msg::reply::<Survey>((place, facts)));
    }
    bench
}

fn entry(name: &str) -> Entry {
    let mut all = bundled().into_iter();
    all.find(|entry| entry.name.contains(name)).unwrap()
}

fn windows_of(entry: &Entry) -> Vec<IndexedWindow> {
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap();
    let options = IndexOptions {
        length: 2.0,
        stride: 1.0,
        radius: 50.0,
        measures: Vec::new(),
    };
    let mut found = Vec::new();
    for_each_window(
        &scenario,
        ego,
        &options,
        Thresholds::shipped(),
        &mut |window| found.push(window),
    );
    found
}

/// An index of the windows of two scenarios, and of a third one that has changed since. Those of the recorded ego of the
/// first were asked about.
fn index() -> CorpusIndex {
    let mut windows = Vec::new();
    let entries = ["CutIn", "Pedestrian", "Merge"].map(entry);
    let hashes = entries
        .each_ref()
        .map(|entry| entry.read().unwrap().hash.to_string());
    for (place, entry) in entries.iter().enumerate() {
        let hash = match place {
            2 => "0123",
            _ => &hashes[place],
        };
        for window in windows_of(entry) {
            let asked = place == 0 && window.ego == WindowEgo::Recorded;
            windows.push((entry.name.as_str(), hash, window, asked));
        }
    }
    CorpusIndex::of_windows("/data/index".into(), &windows)
}

/// The index whose reading was begun last.
fn begun(bench: &Bench) -> (JobId, PathBuf) {
    let mut started = bench
        .effects
        .iter()
        .filter_map(|effect| match effect.request() {
            Some(ReadIndex { id, folder }) => Some((*id, folder.clone())),
            _ => None,
        });
    started.next_back().expect("an index is being read")
}

fn ended(bench: &mut Bench, result: Result<CorpusIndex, String>) {
    let (id, _) = begun(bench);
    let ended = Update::Ended(result.map(Arc::new));
    bench.send(Msg::reply::<ReadIndex>((id, ended)));
}

/// With that index.
fn with_index() -> Bench {
    let mut bench = read();
    bench.perform("index /data/index");
    ended(&mut bench, Ok(index()));
    bench
}

fn listed(bench: &Bench) -> Vec<&str> {
    let list = &bench.model.list;
    let rows = list.visible.iter().map(|place| &list.rows[*place]);
    rows.map(|row| row.entry.name.as_str()).collect()
}

fn filtered<'a>(bench: &'a mut Bench, filter: &str) -> Vec<&'a str> {
    bench.model.list.set_filter(filter.into());
    listed(bench)
}

#[test]
fn terms_of_an_index_say_what_to_do_until_it_is_read() {
    let mut bench = read();
    let all = bundled().len();
    let wrong = |bench: &Bench| bench.model.list.read.wrong.join(" ");
    assert_eq!(filtered(&mut bench, "manoeuvre:cut_in").len(), all);
    for words in [
        "manoeuvre:",
        ":index FOLDER",
        "--index",
        "nearmiss corpus index",
    ] {
        assert!(wrong(&bench).contains(words), "{}", wrong(&bench));
    }
    bench.perform("index /data/index");
    let (id, folder) = begun(&bench);
    assert_eq!(folder, Path::new("/data/index"));
    assert!(wrong(&bench).contains("being read"), "{}", wrong(&bench));
    bench.send(Msg::reply::<ReadIndex>((id, Update::Progress((5, 10)))));
    let job = bench.model.jobs.all.last().unwrap();
    assert_eq!((job.done, job.of), (5, 10));
    bench.press("space l c");
    assert!(bench.frame(80, 24).contains("50 %, 5 of 10 windows"));
    ended(&mut bench, Ok(index()));
    bench.press("esc");
    assert_eq!(wrong(&bench), "");
    let cut_in = entry("CutIn").name;
    assert_eq!(listed(&bench), [cut_in.as_str()]);
    assert!(matches!(
        bench.model.jobs.all.last().unwrap().state,
        JobState::Done(_)
    ));
}

#[test]
fn scenarios_are_known_by_their_contents_and_changed_ones_are_said() {
    let mut bench = with_index();
    let all = bundled().len();
    assert_eq!(filtered(&mut bench, "has:index").len(), 2);
    assert_eq!(filtered(&mut bench, "no:index").len(), all - 2);
    let words = bench.model.list.index_share().summary();
    assert_eq!(
        words,
        format!("1 changed since, {} not in the index", all - 3)
    );
    // Under another name it is the same scenario.
    let place = bench
        .model
        .list
        .rows
        .iter()
        .map(|row| row.entry.name.clone())
        .into_iter()
        .position(|name| name.contains("CutIn"));
    bench.model.list.rows[place.unwrap()].entry.name = "renamed".into();
    assert_eq!(filtered(&mut bench, "manoeuvre:cut_in"), ["renamed"]);
    // A scenario that is read later is looked up, too.
    let facts = bench.model.list.rows[0].facts.take().unwrap();
    bench.send(Msg::reply::<Survey>((0, facts)));
    assert_eq!(filtered(&mut bench, "has:index").len(), 2);
}

#[test]
fn an_index_that_cannot_be_read_is_told_and_its_terms_stay_errors() {
    let mut bench = read();
    bench.perform("index /data/other");
    ended(&mut bench, Err("/data/other: no index here".into()));
    let told = &bench.model.toasts.last().unwrap().text;
    assert!(told.contains("no index here"), "{told}");
    filtered(&mut bench, "road:urban");
    let wrong = bench.model.list.read.wrong.join(" ");
    assert!(wrong.contains("cannot be read"), "{wrong}");
    bench.press("space l c");
    assert!(bench.frame(80, 24).contains("no index here"));
    // From the screen, another one is chosen.
    bench.press("i");
    bench.type_text("/data/index");
    bench.press("enter");
    assert_eq!(begun(&bench).1, Path::new("/data/index"));
    ended(&mut bench, Ok(index()));
    assert!(bench.frame(80, 24).contains("cut_in"));
}

#[test]
fn reading_is_cancelled_in_the_list_of_tasks_and_late_news_is_dropped() {
    let mut bench = read();
    bench.perform("index /data/index");
    let (id, _) = begun(&bench);
    let job = bench.model.jobs.all.last().unwrap();
    assert!(job.is_running());
    bench.press("space o j shift-x");
    let cancelled = |effect: &Effect| matches!(effect, Effect::Cancel(job) if *job == id);
    assert!(bench.effects.iter().any(cancelled), "{:?}", bench.effects);
    ended(&mut bench, Ok(index()));
    assert!(bench.model.list.index().ready().is_none());
}

#[test]
fn the_map_counts_windows_and_enter_filters_the_list_to_a_cell() {
    let mut bench = with_index();
    let index = index();
    bench.press("space l c");
    bench.send(Msg::Resize(80, 24));
    let counts = index.counts(Some(Manoeuvre::CutIn), None);
    assert!(counts.windows.iter().sum::<u64>() > 0);
    let frame = bench.frame(80, 24);
    insta::assert_snapshot!("coverage_80x24", frame);
    insta::assert_snapshot!("coverage_60x18", bench.frame(60, 18));
    assert!(bench.frame(200, 60).contains("by severity"));
    // The first cell with windows is selected: the cut-in.
    bench.press("enter");
    assert_eq!(bench.model.focus, Pane::Scenarios);
    assert!(bench.model.screens.is_empty());
    let filter = bench.model.list.filter.clone();
    assert!(filter.starts_with("manoeuvre:cut_in road:"), "{filter}");
    assert_eq!(listed(&bench), [entry("CutIn").name.as_str()]);
    // All of everything, of one severity.
    bench.press("space l c shift-g s");
    for _ in RoadType::ALL {
        bench.press("right");
    }
    bench.press("enter");
    assert_eq!(bench.model.list.filter, "severity=0");
}

#[test]
fn empty_cells_are_seen_and_have_no_windows() {
    let mut bench = with_index();
    bench.press("space l c g g");
    bench.press("left left left left left left left");
    let counts = index().counts(Some(Manoeuvre::CutIn), Some(RoadType::Intersection));
    assert_eq!(counts.windows, [0; 6], "the test needs an empty cell");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("cut_in, intersection: 0 windows"), "{frame}");
    let row = frame
        .lines()
        .find(|line| line.contains("▸ cut_in"))
        .unwrap();
    assert!(row.contains('·') && row.contains('*'), "{row}");
    bench.press("tab");
    let said = &bench.model.toasts.last().unwrap().text;
    assert!(said.contains("no window"), "{said}");
}

#[test]
fn a_window_opens_with_its_ego_and_obstacle_at_its_worst_step() {
    let mut bench = with_index();
    bench.press("space l c");
    let cut_in = entry("CutIn");
    let mut worst = windows_of(&cut_in);
    worst.retain(|window| window.manoeuvre == Manoeuvre::CutIn);
    worst.sort_by_key(|window| window.severity);
    let (first, taken) = match worst[0].ego {
        WindowEgo::Recorded => (&worst[0], None),
        WindowEgo::Obstacle(id) => (&worst[0], Some(id)),
    };
    bench.press("tab enter");
    assert!(bench.model.screens.is_empty());
    let model = &bench.model;
    assert_eq!(model.opened.as_ref().unwrap().name, cut_in.name);
    assert_eq!(model.taken, taken);
    assert_eq!(model.picked, Some(first.obstacle));
    assert_eq!(model.clock.step(), first.worst_step);
    // A window of a scenario that has changed stays closed, and why is said.
    let mut bench = with_index();
    let merge = entry("Merge").name;
    bench.press("space l c");
    let frame = |bench: &Bench| bench.frame(120, 40);
    for _ in 0..11 {
        bench.press("down");
        bench.press("shift-g");
    }
    bench.press("tab");
    for _ in 0..100 {
        bench.press("down");
        let drawn = frame(&bench);
        let selected = drawn.lines().filter(|line| line.contains("▸ "));
        if selected.into_iter().any(|line| line.contains(&merge)) {
            bench.press("enter");
            let said = &bench.model.toasts.last().unwrap().text;
            assert!(said.contains("other contents"), "{said}");
            return;
        }
    }
    panic!("no window of {merge}: {}", frame(&bench));
}

#[test]
fn the_session_remembers_the_index_and_older_sessions_load() {
    let bench = with_index();
    let session = restore::capture(&bench.model);
    let text = session.text().unwrap();
    let again = Session::parse(&text, &session.paths).unwrap();
    assert_eq!(again, session);
    let mut after = Bench::empty();
    restore::restore(&mut after.model, again.clone(), false);
    assert_eq!(
        after.model.index.folder.as_deref(),
        Some(Path::new("/data/index"))
    );
    // What is configured meanwhile comes first.
    let mut configured = Bench::empty();
    configured.model.index.folder = Some("/lab".into());
    configured.model.index.configured = Some("/lab".into());
    restore::restore(&mut configured.model, again, false);
    assert_eq!(
        configured.model.index.folder.as_deref(),
        Some(Path::new("/lab"))
    );
    let mut old: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(old.as_object_mut().unwrap().remove("index").is_some());
    let old = Session::parse(&old.to_string(), &session.paths).unwrap();
    assert_eq!(old.index, None);
    let mut after = Bench::empty();
    restore::restore(&mut after.model, old, false);
    assert_eq!(after.model.index.folder, None);
}

#[test]
fn no_index_is_a_choice_that_stays_even_over_the_configuration() {
    let mut bench = read();
    bench.model.config = Config {
        index: Some("/lab".into()),
        ..Config::default()
    };
    bench.model.index.configured = Some("/lab".into());
    bench.perform("index /lab");
    ended(&mut bench, Ok(index()));
    assert_eq!(restore::capture(&bench.model).index, None);
    bench.press("space l i down enter");
    assert!(bench.model.list.index().ready().is_none());
    let session = restore::capture(&bench.model);
    assert_eq!(session.index.as_ref().unwrap().chosen, "");
    let mut after = Bench::empty();
    after.model.index.folder = Some("/lab".into());
    after.model.index.configured = Some("/lab".into());
    restore::restore(&mut after.model, session, false);
    assert_eq!(after.model.index.folder, None);
}

#[test]
fn terms_are_edited_and_kept_while_windows_are_filtered() {
    let mut bench = with_index();
    bench.press("/");
    bench.type_text("manoeuvre:cut_in");
    // A match opens.
    bench.send(Msg::Passed(std::time::Duration::from_secs(1)));
    assert!(bench.model.list.filtering.is_some(), "it can be edited");
    assert_eq!(listed(&bench), [entry("CutIn").name.as_str()]);
    bench.type_text(",crossing");
    assert!(listed(&bench).len() > 1);
    bench.press("enter");
    assert!(bench.model.list.filtering.is_none());
    assert_eq!(bench.model.list.filter, "manoeuvre:cut_in,crossing");
}
