//! Recordings of other data sets in the workbench: their windows in the list, opened, stepped through, and their texts.

use std::fmt::Write;
use std::path::Path;

use super::bench::Bench;
use crate::features::scenarios::request::{Find, Found};
use crate::message::Msg;
use nearmiss_workflow::find;

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
    let found = find(&[folder.path().to_path_buf()]).unwrap();
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
