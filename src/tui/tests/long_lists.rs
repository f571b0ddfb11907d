//! Lists of thousands: frames and messages cost no more for rows that are off screen.

use std::path::Path;
use std::time::{Duration, Instant};

use super::bench::Bench;
use crate::features::scenarios::request::{Find, Found, Survey};
use crate::loaded::{Facts, Verdicts};
use crate::message::Msg;
use crate::update::update;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_workflow::find_in_pieces;

const MANY: usize = 2_000;

fn entries() -> Vec<Entry> {
    let countries = ["DEU", "USA", "ESP", "CHN"];
    let name = |i: usize| format!("f{}/{}_Town{i:04}-1_1_T-1.xml", i % 7, countries[i % 4]);
    (0..MANY)
        .map(|i| Entry::of_file(Path::new(&name(i))))
        .collect()
}

/// The least time that something takes of several tries: others use the machine too.
fn least(mut what: impl FnMut()) -> Duration {
    let tries = (0..21).map(|_| {
        let begun = Instant::now();
        what();
        begun.elapsed()
    });
    tries.min().unwrap()
}

fn facts() -> Facts {
    let read = |entry: &Entry| {
        Facts::read(
            entry,
            &EgoSelection::Beside,
            Thresholds::shipped(),
            &Verdicts::default(),
        )
    };
    read(&bundled()[0]).unwrap()
}

#[test]
fn the_first_frame_counts_thousands() {
    let mut bench = Bench::empty();
    drop(update(
        &mut bench.model,
        Msg::reply::<Find>(Found::More(entries())),
    ));
    drop(update(&mut bench.model, Msg::Drawing));
    assert!(bench.frame(200, 60).contains("scenarios 2000"));
}

#[test]
fn a_frame_costs_the_same_for_thousands_and_for_few() {
    let frames = |count: usize| {
        let mut bench = Bench::empty();
        drop(update(
            &mut bench.model,
            Msg::reply::<Find>(Found::More(entries()[..count].to_vec())),
        ));
        drop(update(&mut bench.model, Msg::Drawing));
        least(|| drop(bench.frame(200, 60)))
    };
    let (few, many) = (frames(60), frames(MANY));
    assert!(many < few * 3, "{few:?} {many:?}");
}

#[test]
fn what_arrives_is_sorted_once_a_frame() {
    let mut bench = Bench::empty();
    drop(update(
        &mut bench.model,
        Msg::reply::<Find>(Found::More(entries())),
    ));
    bench.model.list.sort_by(crate::model::Order::Obstacles);
    let facts = facts();
    let arriving = least(|| {
        for place in 0..MANY {
            drop(update(
                &mut bench.model,
                Msg::reply::<Survey>((place, Ok(facts.clone()))),
            ));
        }
    });
    let settling = least(|| {
        drop(update(
            &mut bench.model,
            Msg::reply::<Survey>((0, Ok(facts.clone()))),
        ));
        drop(update(&mut bench.model, Msg::Drawing));
    });
    // Sorting at every message would take as long as sorting two thousand times.
    assert!(arriving < settling * 60, "{arriving:?} {settling:?}");
    assert_eq!(bench.model.list.known, MANY);
}

#[test]
fn what_is_on_the_screen_is_asked_for_first_and_once() {
    let mut bench = Bench::empty();
    drop(update(
        &mut bench.model,
        Msg::reply::<Find>(Found::More(entries())),
    ));
    drop(update(&mut bench.model, Msg::Drawing));
    bench.frame(120, 40);
    bench.model.list.selected = 1_000;
    bench.frame(120, 40);
    let mut asked = update(&mut bench.model, Msg::Drawing);
    let Ok(Survey::First(places)) = asked.pop().unwrap().into_request() else {
        panic!("{asked:?}");
    };
    assert!(places.contains(&1_000) && places.len() < 60, "{places:?}");
    assert!(update(&mut bench.model, Msg::Drawing).is_empty(), "once");
    assert_eq!(bench.model.list.current(), Some(1_000));
}

#[test]
fn folders_of_thousands_come_in_pieces_and_whole() {
    let folder = tempfile::tempdir().unwrap();
    for i in 0..700 {
        let below = folder.path().join(format!("f{}", i % 3));
        std::fs::create_dir_all(&below).unwrap();
        std::fs::write(below.join(format!("s{i:03}.xml")), "<commonRoad/>").unwrap();
    }
    std::fs::write(folder.path().join("empty.xml"), "").unwrap();
    let paths = [folder.path().to_path_buf()];
    let mut pieces = Vec::new();
    let passed_over = find_in_pieces(&paths, &mut |piece| pieces.push(piece)).unwrap();
    assert_eq!(passed_over.len(), 1);
    assert!(
        pieces.len() > 2 && pieces[0].len() == 64,
        "{}",
        pieces.len()
    );
    let mut all: Vec<String> = pieces.iter().flatten().map(Entry::display).collect();
    assert_eq!(all.len(), 700);
    assert!(all.is_sorted(), "folders and files come by name");
    let found = nearmiss_formats::find(&paths).unwrap();
    all.sort();
    let whole: Vec<String> = found.entries.iter().map(Entry::display).collect();
    assert_eq!(all, whole);
    let nothing = tempfile::tempdir().unwrap();
    let error = find_in_pieces(&[nothing.path().to_path_buf()], &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("no CommonRoad scenario"));
}
