//! Escape sequences in every name and text that is not ours: no view of the workbench obeys them.

use std::time::Duration;

use super::Session;
use super::support::planted::{leaks, plant};
use super::support::program::Home;

/// Keys that lead through the views, and back to the main screen.
const WAYS: [&str; 28] = [
    "?",
    " oi",
    " ov",
    ":",
    "m",
    "\x14",
    " pm",
    " ls",
    " lt",
    " ml",
    " od",
    " os",
    " op",
    " oj",
    " aa",
    " oc",
    " ob",
    "\x12",
    " avz",
    " avz",
    " avz",
    " avz",
    "e\x06",
    ":templates\r",
    " lg",
    " lg",
    "/PWN",
    " at",
];

#[test]
fn nothing_planted_reaches_the_terminal() {
    let home = Home::new();
    let folder = plant(&home);
    let (config, data) = (home.config(), home.data());
    let environment = [
        ("NEARMISS_CONFIG", config.to_str().unwrap()),
        ("NEARMISS_DATA", data.to_str().unwrap()),
    ];
    let arguments = [folder.to_str().unwrap()];
    let mut session = Session::start_with(160, 45, &environment, &arguments);
    session.see("scenarios");
    session.see("PWNED");
    let settle = |session: &mut Session| {
        for _ in 0..6 {
            session.receive(Duration::from_millis(30));
        }
    };
    settle(&mut session);
    for (columns, rows) in [(160, 45), (80, 24)] {
        session.resize(columns, rows);
        for keys in WAYS {
            session.press(keys);
            settle(&mut session);
            for _ in 0..4 {
                session.press("\x1b");
                // Esc and what follows at once would be another key.
                session.receive(Duration::from_millis(60));
            }
        }
        // The files that cannot be read.
        session.press("j");
        settle(&mut session);
        session.press(" oi");
        settle(&mut session);
        session.press("\x1b");
        settle(&mut session);
    }
    session.press("\x03");
    settle(&mut session);
    session.press("q");
    session.press("\x11");
    session.end();
    session.is_restored();
    // OSC 11 asks for the background; everything else that is looked for comes from the planted text alone.
    let raw = String::from_utf8_lossy(&session.raw).into_owned();
    let leaks = leaks(&raw);
    assert!(leaks.is_empty(), "{}", leaks.join("\n"));
    assert!(!raw.contains('\u{7}'), "a bell or the end of a title");
    assert!(
        raw.matches("PWNED").count() > 20,
        "what was planted is shown"
    );
}
