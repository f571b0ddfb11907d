//! Sessions: saved state is restored, nothing else; and the hint towards a first verdict.

use std::path::PathBuf;

use super::bench::{Bench, answer};
use super::events;
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, Msg};
use crate::model::{Grouping, Pane, Sizes};
use crate::session::Session;
use crate::session::restore::{self, KeepSession, KeepSessionLater};
use nearmiss_formats::{Entry, EntryLocation, bundled};
use nearmiss_scene::verdict::Task;

fn kept(bench: &mut Bench) -> Option<Session> {
    bench.effects.clear();
    bench.press("q");
    assert!(
        matches!(bench.effects.last(), Some(Effect::Quit)),
        "kept before the end"
    );
    let mut effects = bench.effects.drain(..);
    effects.find_map(|effect| match effect.into_request() {
        Ok(KeepSession(session)) => Some(*session),
        Err(_) => None,
    })
}

/// The same after it was written and read.
fn read(session: &Session) -> Session {
    Session::parse(&session.text().unwrap(), &session.paths).unwrap()
}

fn keeping(mut bench: Bench) -> Bench {
    bench.model.recall.on = true;
    bench
}

#[test]
fn the_workbench_comes_back_as_it_was_left() {
    let mut bench = keeping(Bench::bundled());
    bench.frame(200, 60);
    bench.press("down down right right * space a t space a c space a h n");
    bench.press("+ + h space l g");
    bench.model.config.model = Some("lab/small".into());
    bench.model.plot.measure = nearmiss_scene::metrics::measure("ttc").unwrap();
    bench.model.map.layers.signs = false;
    bench.press("ctrl-w > tab tab z");
    bench.press("right right right");
    let left = kept(&mut bench).unwrap();
    let before = &bench.model;

    let mut again = keeping(Bench::empty());
    again.model.config.model = Some("lab/small".into());
    restore::restore(&mut again.model, read(&left), false);
    again.send(Msg::reply::<Find>(Found::All(Ok(bundled().into()))));
    let after = &again.model;
    let name = |bench: &crate::model::Model| bench.opened.as_ref().unwrap().name.clone();
    assert_eq!(name(after), name(before));
    assert_ne!(name(after), bundled()[0].name);
    assert_eq!(after.clock.step(), before.clock.step());
    assert_eq!((after.task, after.frame), (before.task, before.frame));
    assert_eq!(after.techniques, before.techniques);
    assert_eq!((after.focus, after.zoomed), (before.focus, true));
    assert_eq!(after.camera, before.camera);
    assert_eq!(after.look.sizes, before.look.sizes);
    assert_ne!(after.look.sizes, Sizes::default());
    assert_eq!(after.picked, before.picked);
    assert_eq!(after.list.grouping, Grouping::Country);
    assert_eq!(after.marks.count(&after.list), 1);
    assert_eq!(
        (after.plot.measure.id, after.map.layers.signs),
        ("ttc", false)
    );
    assert_eq!(after.model, "reference/geometry");
    assert_eq!(
        kept(&mut again),
        None,
        "nothing changed, nothing is written"
    );
}

#[test]
fn what_the_configuration_says_anew_wins() {
    let mut bench = keeping(Bench::bundled());
    bench.model.model = "lab/small".into();
    let left = kept(&mut bench).unwrap();
    let restored = |configured: Option<&str>| {
        let mut again = Bench::empty();
        again.model.config.model = configured.map(Into::into);
        restore::restore(&mut again.model, read(&left), false);
        again.model.model
    };
    assert_eq!(restored(None), "lab/small");
    assert_eq!(
        restored(Some("lab/new")),
        "reference/geometry",
        "as it was made"
    );
}

#[test]
fn the_last_scenario_is_waited_for_and_another_choice_ends_that() {
    let file = |name: &str| Entry {
        place: EntryLocation::File(PathBuf::from(format!("a/{name}.xml"))),
        name: name.into(),
        group: "a".into(),
    };
    let mut bench = keeping(Bench::empty());
    bench.model.recall.here = "/here".into();
    bench.send(Msg::reply::<Find>(Found::More(vec![
        file("one"),
        file("two"),
        file("three"),
    ])));
    bench.press("down down *");
    let mut left = kept(&mut bench).unwrap();
    let opened = crate::session::SavedScenario {
        scenario: crate::session::SavedLocation::File("/here/a/three.xml".into()),
        ego: None,
        step: 3,
        picked: None,
        pinned: None,
        camera: crate::session::View {
            cell: 1.0,
            center: [0.0, 0.0],
            shift: [0.0, 0.0],
            follow: true,
            ego_up: false,
            auto: false,
        },
    };
    left.opened = Some(opened);

    let start = || {
        let mut again = keeping(Bench::empty());
        // From another folder, and so with other paths.
        again.model.recall.here = "/here/b".into();
        restore::restore(&mut again.model, read(&left), false);
        again
    };
    let file = |name: &str| Entry {
        place: EntryLocation::File(PathBuf::from(format!("../a/{name}.xml"))),
        ..file(name)
    };
    let mut again = start();
    again.send(Msg::reply::<Find>(Found::More(vec![
        file("one"),
        file("two"),
    ])));
    assert_eq!(again.model.list.opened, None, "it may still come");
    again.send(Msg::reply::<Find>(Found::More(vec![file("three")])));
    assert_eq!(again.model.list.opened, Some(2));
    assert_eq!(again.model.marks.count(&again.model.list), 1);

    let mut gone = start();
    gone.send(Msg::reply::<Find>(Found::More(vec![
        file("one"),
        file("two"),
    ])));
    gone.send(Msg::reply::<Find>(Found::Ended(Ok(Vec::new()))));
    assert_eq!(gone.model.list.opened, Some(0));

    let mut impatient = start();
    impatient.send(Msg::reply::<Find>(Found::More(vec![
        file("one"),
        file("two"),
    ])));
    impatient.press("down");
    assert_eq!(impatient.model.list.opened, Some(1));
    impatient.send(Msg::reply::<Find>(Found::More(vec![file("three")])));
    assert_eq!(impatient.model.list.opened, Some(1));
}

#[test]
fn changes_are_kept_after_a_while_and_only_once() {
    let asked = |bench: &Bench| {
        let later = |e: &&Effect| matches!(e.request(), Some(KeepSessionLater));
        bench.effects.iter().filter(later).count()
    };
    let written = |bench: &Bench| {
        let kept = |e: &&Effect| matches!(e.request(), Some(KeepSession(_)));
        bench.effects.iter().filter(kept).count()
    };
    let mut off = Bench::bundled();
    off.press("right");
    off.send(Msg::reply::<KeepSessionLater>(()));
    assert_eq!(
        (asked(&off), written(&off)),
        (0, 0),
        "not where it is switched off"
    );

    let mut bench = keeping(Bench::bundled());
    bench.press("right right right");
    assert_eq!(asked(&bench), 1, "not for every key");
    bench.send(Msg::reply::<KeepSessionLater>(()));
    assert_eq!((asked(&bench), written(&bench)), (1, 1));
    bench.press("right");
    bench.send(Msg::reply::<KeepSessionLater>(()));
    assert_eq!((asked(&bench), written(&bench)), (2, 2));
    bench.press("left right");
    bench.send(Msg::reply::<KeepSessionLater>(()));
    assert_eq!(written(&bench), 2, "the same as before");
}

#[test]
fn an_ego_of_the_command_line_wins() {
    let mut bench = keeping(Bench::bundled());
    bench.press("n space e t");
    let taken = bench.model.taken;
    assert!(taken.is_some());
    let left = kept(&mut bench).unwrap();
    for (chosen, ego) in [(false, taken), (true, None)] {
        let mut again = keeping(Bench::empty());
        restore::restore(&mut again.model, read(&left), chosen);
        again.send(Msg::reply::<Find>(Found::All(Ok(bundled().into()))));
        assert_eq!(again.model.taken, ego);
    }
    let mut stale = read(&left);
    stale.opened.as_mut().unwrap().ego = Some(-77);
    let mut again = keeping(Bench::empty());
    restore::restore(&mut again.model, stale, false);
    again.send(Msg::reply::<Find>(Found::All(Ok(bundled().into()))));
    assert!(again.model.opened.is_some() && again.model.taken.is_none());
    assert_eq!(again.model.open_error, None);
}

#[test]
fn nonsense_in_a_session_changes_nothing() {
    let mut bench = keeping(Bench::bundled());
    let mut odd = kept(&mut bench).unwrap();
    odd.task = "dance".into();
    odd.frame = "fish".into();
    odd.plot = "nothing".into();
    odd.sort = ("colour".into(), true);
    odd.focus = "timeline".into();
    let opened = odd.opened.as_mut().unwrap();
    opened.step = i64::MAX;
    opened.camera.cell = -3.0;
    opened.camera.center = [1e300, 0.0];
    let mut again = keeping(Bench::empty());
    restore::restore(&mut again.model, odd, false);
    again.send(Msg::reply::<Find>(Found::All(Ok(bundled().into()))));
    assert_eq!(again.model.task, Task::Collision);
    assert_eq!(again.model.focus, Pane::Scenarios);
    assert_eq!(again.model.clock.step(), again.model.clock.range().1);
    assert!(again.model.camera.cell > 0.0);
    again.frame(80, 24);
}

#[test]
fn three_keys_lead_to_a_first_verdict() {
    for (columns, rows) in [(80, 24), (200, 60)] {
        let mut bench = Bench::bundled();
        bench.model.recall.hint = true;
        let frame = bench.frame(columns, rows);
        // Where the pane is low, they stand in its border and hide no text.
        let title = match rows {
            24 => "↓ next  x worst moment  m model",
            _ => "three keys to a first verdict",
        };
        assert!(frame.contains(title), "{frame}");
        let shown = ["↓", "x", "m"];
        let words = [
            "open the next scenario",
            "go to its worst moment",
            "choose a model, r asks it",
        ];
        for (key, words) in shown.iter().zip(words).filter(|_| rows > 24) {
            assert!(frame.contains(&format!("{key}  {words}")), "{frame}");
        }
        bench.press("down x r");
        let (id, model) = bench.asked();
        assert_eq!(model, "reference/geometry");
        assert!(bench.frame(columns, rows).contains(title));
        let said = answer(&model, true, 301);
        bench.send(events::answered(id, Ok(Box::new(said))));
        let frame = bench.frame(columns, rows);
        assert!(!frame.contains(title), "{frame}");
    }
}
