//! A search that runs, waits or is cancelled; and variants that were saved.

use super::bench::Bench;
use super::events;
use super::making::{arrive, asked, dangerous, open, said, shown, stopped};
use crate::features::generation::request::write;
use crate::loaded::{GenerationStage, Opened};
use crate::message::Msg;
use crate::model::JobState;
use crate::model::OpenId;
use crate::update::Open;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::metrics::Thresholds;

#[test]
fn a_search_can_be_cancelled_and_ends_when_something_else_opens() {
    let mut bench = open("rightturn");
    bench.press("space g g esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (1, 0));
    assert!(
        said(&bench).contains("Esc again cancels"),
        "{}",
        said(&bench)
    );
    bench.press("esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (1, 1));
    assert!(bench.model.maker.under_way.is_none());
    let state = |bench: &Bench| bench.model.jobs.all.last().unwrap().state.clone();
    assert_eq!(state(&bench), JobState::Stopping);
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        assert!(
            frame.lines().next().unwrap().contains("cancelling…"),
            "{frame}"
        );
    }
    // What still arrives of it is dropped.
    let (id, _) = asked(&bench).pop().unwrap();
    bench.send(events::generating(id, GenerationStage::Proving));
    assert_eq!(state(&bench), JobState::Stopping);
    arrive(&mut bench);
    assert!(bench.model.variant().is_none());
    assert!(matches!(state(&bench), JobState::Cancelled(_)));
    assert!(!bench.frame(200, 60).contains("cancelling…"));
    bench.press("space g g space g g");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (2, 1));
    assert!(said(&bench).contains("Esc Esc cancels"), "{}", said(&bench));
    // Another key between the two, or a long wait, takes the first one back.
    bench.press("esc x esc");
    bench.send(Msg::Passed(std::time::Duration::from_secs(5)));
    bench.press("esc");
    assert_eq!(stopped(&bench), 1);
    bench.press("esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (2, 2));
    bench.press("space g g space o j x esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (3, 3));
    bench.press("/");
    for _ in 0..9 {
        bench.press("space e r");
    }
    bench.press("enter space g g down");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (4, 4));
}

#[test]
fn a_search_asked_for_while_the_scenario_is_read_begins_when_it_is_open() {
    let mut bench = open("rightturn");
    let place = bench.model.list.opened.unwrap();
    bench.model.opening = Some((OpenId(1_000_000), None));
    bench.press("space g g");
    assert!(asked(&bench).is_empty());
    assert!(
        said(&bench).contains("still being read"),
        "{}",
        said(&bench)
    );
    let opened = bench.model.opened.clone().unwrap();
    bench.send(Msg::reply::<Open>((OpenId(1_000_000), Ok(opened))));
    assert_eq!(asked(&bench).len(), 1);
    assert_eq!(bench.model.list.opened, Some(place));
}

#[test]
fn a_saved_variant_has_its_original_beside_it_and_opens_it() {
    let made = shown(&dangerous()).made.clone();
    let folder = tempfile::tempdir().unwrap();
    write(&made, Some(folder.path())).unwrap();
    let files = std::fs::read_dir(folder.path()).unwrap();
    let file = files
        .map(|file| file.unwrap().path())
        .find(|path| {
            let name = path.to_string_lossy().into_owned();
            name.ends_with(".xml") && !name.ends_with(".solution.xml")
        })
        .unwrap();
    let read = || {
        let thresholds = Thresholds::shipped();
        let entry = Entry::of_file(&file);
        Box::new(Opened::read(&entry, &EgoSelection::Beside, thresholds).unwrap())
    };
    let mut bench = Bench::bundled();
    bench.model.opened = Some(read());
    bench.press("space g v");
    let words = bench.frame(100, 60);
    for part in [
        "avoidable by a good driver",
        "a saved variant: ",
        "Space g o",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let driver = &made.good_driver.as_ref().unwrap();
    let used = format!("up to {:.1} m/s²", driver.acceleration);
    assert!(words.contains(&used), "{used}: {words}");
    bench.press("space g v");
    bench.press("space m s");
    let second = bench.model.second_moment().unwrap().words();
    assert!(second.starts_with("original"), "{second}");
    bench.press("space g o");
    let original = bundled()
        .into_iter()
        .find(|entry| made.file.starts_with(&entry.name))
        .unwrap();
    let opened = bench.model.opened.as_ref().unwrap();
    assert_eq!(
        (&opened.name, opened.scenario.hash),
        (&original.name, made.original())
    );
    assert!(said(&bench).contains("goes back to the variant"));

    // Another file under the original's name is not the original.
    let certificate = file.with_extension("json");
    let text = std::fs::read_to_string(&certificate).unwrap();
    let hash = made.original().to_string();
    std::fs::write(&certificate, text.replace(&hash, "0123")).unwrap();
    let mut bench = Bench::bundled();
    bench.model.opened = Some(read());
    bench.press("space g o");
    let words = said(&bench);
    assert!(
        words.contains(&format!("the original {}", original.name)),
        "{words}"
    );
    assert!(words.contains("nor among the bundled scenarios"), "{words}");
}
