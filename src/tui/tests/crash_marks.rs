//! A scenario that ended the program is not opened again until the user asks for it.

use std::path::Path;

use super::bench::Bench;
use super::editing::with;
use crate::features::scenarios::request::{Find, Found};
use crate::message::Msg;
use crate::session::SavedLocation;
use nearmiss_base::system::activity::{self, Subject};
use nearmiss_formats::{bundled, find};
use nearmiss_settings::Keys;

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
    activity::keep_marks(&marks).unwrap();

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
    assert!(!activity::is_held(&draft) && editing.model.prompt.error.is_none());

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
    assert!(!activity::is_held(&second));
    activity::close_marks();
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
    let doing = activity::trying("opening", subject.clone());
    doing.settle();
    drop(doing);
    assert!(!activity::is_held(&subject));
}
