//! Sessions, marks of crashes, and recordings.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, Msg};
use crate::model::{Grouping, Pane, Sizes};
use crate::session::restore::{self, KeepSession, KeepSessionLater};
use crate::session::{SavedLocation, Session};
use crate::tests::bench::{self, Bench, answer};
use crate::tests::editing::with;
use nearmiss_base::system::crash::{self, Subject};
use nearmiss_formats::{Entry, EntryLocation, bundled, find};
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Keys;

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
    // Which side of its pane is longer is known once the map is drawn.
    let wide = before.camera.wide;
    assert_eq!(
        crate::model::Camera {
            wide,
            ..after.camera.clone()
        },
        before.camera
    );
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
        step: Some(3),
        picked: None,
        pinned: None,
        camera: crate::session::View {
            cell: 1.0,
            center: [0.0, 0.0],
            shift: [0.0, 0.0],
            follow: true,
            up: None,
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
    bench.press("home right right right");
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
    opened.step = Some(i64::MAX);
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
            24 => "↓ next  p play  m model",
            _ => "three keys; more: nearmiss --tour",
        };
        assert!(frame.contains(title), "{frame}");
        let shown = ["↓", "p", "m"];
        let words = [
            "open the next scenario",
            "play from 3 s before this moment",
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
        bench.send(bench::answered(id, Ok(Box::new(said))));
        let frame = bench.frame(columns, rows);
        assert!(!frame.contains(title), "{frame}");
    }
}

// One test, as marks are kept in one place for the whole program.
#[test]
fn a_draft_and_a_scenario_that_ended_the_program_wait_for_the_user() {
    let folder = tempfile::tempdir().unwrap();
    let scenarios = folder.path().join("scenarios");
    std::fs::create_dir(&scenarios).unwrap();
    let all = bundled();
    for (entry, name) in all.iter().zip(["a.xml", "b.xml"]) {
        std::fs::write(scenarios.join(name), entry.source().unwrap()).unwrap();
    }
    let found = find(&[scenarios]).unwrap();
    let second = SavedLocation::from_entry(&found.entries[1], Path::new("")).subject();

    let mut editing = with(Keys::Plain);
    editing.press("ctrl-g 1 0 enter");
    editing.type_text("This one ends the program. ");
    let text = editing.model.prompt.text();
    let draft = Subject::template("collision-ego.md", &text);

    let marks = folder.path().join("marks");
    std::fs::create_dir(&marks).unwrap();
    let left = format!("{}\n{}\n", draft.name(), second.name());
    std::fs::write(marks.join("running-1"), left).unwrap();
    crash::keep_marks(&marks).unwrap();

    // The draft is text, with a sentence and a key, until that is pressed.
    editing.press("esc");
    editing.model.refresh();
    assert!(editing.model.prompt.question.is_none());
    let frame = editing.frame(160, 60);
    assert!(
        frame.contains("crashed while rendering this template"),
        "{frame}"
    );
    assert!(editing.model.prompt.text().contains("This one ends"));
    editing.press("r");
    let question = editing.model.prompt.question.as_ref().unwrap();
    let prompt = format!("{}{}", question.prompt.system, question.prompt.user);
    assert!(prompt.contains("This one ends the program."));
    assert!(!crash::is_held(&draft) && editing.model.prompt.error.is_none());

    // The scenario is passed over by the arrow keys, and opened by Enter.
    let mut bench = Bench::empty();
    bench.send(Msg::reply::<Find>(Found::All(Ok(found))));
    let opened = |bench: &Bench| bench.model.opened.as_ref().unwrap().name.clone();
    let first = opened(&bench);
    bench.press("down");
    assert_eq!(opened(&bench), first);
    let said = bench.frame(160, 60);
    assert!(said.contains("crashed while opening or showing"), "{said}");
    bench.press("enter");
    assert_ne!(opened(&bench), first);
    assert!(!crash::is_held(&second));
    crash::close_marks();
}

#[test]
fn what_fails_in_a_panic_is_held_and_nothing_else() {
    // In a process of its own this is tested with the program itself; here is what may be asked at any time.
    let subject = Subject::scenario("/a\nb.xml");
    assert_eq!(subject.name().lines().count(), 1);
    assert_ne!(
        Subject::template("a.md", "x"),
        Subject::template("a.md", "y")
    );
    let doing = crash::trying("opening", subject.clone());
    doing.settle();
    drop(doing);
    assert!(!crash::is_held(&subject));
}

/// Floating car data of 40 s: `late` comes up behind `8`, which stands, and stops short of it; `9` drives far from both.
fn written(folder: &Path) {
    let mut xml = String::from("<fcd-export>\n");
    for step in 0..=400 {
        let t = f64::from(step) * 0.1;
        let (x, speed) = if t < 20.0 {
            (10.0 * t, 10.0)
        } else {
            (200.0, 0.0)
        };
        let rows = [
            ("late", x, 0.0, speed),
            ("8", 206.0, 0.0, 0.0),
            ("9", 5.0 * t, 400.0, 5.0),
        ];
        let _ = write!(xml, "<timestep time='{t:.1}'>");
        for (id, x, y, speed) in rows {
            let _ = write!(
                xml,
                "<vehicle id='{id}' x='{x:.2}' y='{y}' angle='90' type='DEFAULT_VEHTYPE' speed='{speed}'/>"
            );
        }
        xml.push_str("</timestep>\n");
    }
    std::fs::write(folder.join("fcd.xml"), xml + "</fcd-export>\n").unwrap();
}

#[test]
fn windows_of_a_recording_are_listed_opened_and_stepped_through() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let mut bench = Bench::empty();
    let found = nearmiss_workflow::find(&[folder.path().to_path_buf()]).unwrap();
    bench.send(Msg::reply::<Find>(Found::All(Ok(found))));
    let frame = bench.frame(200, 60);
    assert!(frame.contains("scenarios 1 "), "{frame}");
    assert!(frame.contains("fcd-track-late-12.8s"), "{frame}");
    // The window is open, with its track as the ego, at the moment for which it is listed.
    let scene = bench.model.scene().unwrap();
    assert_eq!(scene.scenario.dt(), 0.1);
    assert_eq!(scene.steps(), 0..101);
    assert!(frame.contains("ego recorded"), "{frame}");
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        assert!(
            frame
                .lines()
                .all(|line| line.chars().count() <= columns.into())
        );
    }
    let before = bench.model.clock.step();
    bench.press("right right");
    assert_ne!(bench.model.clock.step(), before);
    // Another ego, what was assumed, and why there is no text.
    bench.press("n space e t");
    assert_ne!(
        bench.model.scene().unwrap().ego.id,
        scene_id(&bench, "late")
    );
    bench.press("space o i");
    let told = bench.frame(120, 60);
    assert!(told.contains("no net"), "{told}");
}

/// The id of the vehicle, which the diagnostics tell.
fn scene_id(bench: &Bench, name: &str) -> i64 {
    let scenario = &bench.model.scene().unwrap().scenario;
    let said = scenario.diagnostics.iter().map(ToString::to_string);
    let told = said
        .filter(|line| line.contains("are numbered"))
        .collect::<String>();
    let rest = told.split(&format!("`{name}` ")).nth(1).unwrap();
    let digits = rest.split(|c: char| !c.is_ascii_digit()).next().unwrap();
    digits.parse().unwrap()
}
