//! A variant on a small screen: the most important parts are visible.

use super::bench::Bench;
use super::making::{arrive, made, open};
use nearmiss_drive::generation::Consequence;

/// A variant at its worst step, on a screen of that size.
fn shown(name: &str, columns: u16, rows: u16) -> Bench {
    let mut bench = open(name);
    bench.send(crate::message::Msg::Resize(columns, rows));
    bench.frame(columns, rows);
    bench.press("space g g");
    arrive(&mut bench);
    bench.model.toasts.clear();
    bench
}

#[test]
fn the_header_says_what_the_variant_leads_to_before_how_would_be_asked() {
    let mut bench = shown("rightturn", 80, 24);
    let Consequence::Collision(with) = made(&bench).effect.consequence else {
        panic!("{:?}", made(&bench).effect.consequence);
    };
    let name = bench.model.opened.as_ref().unwrap().name.clone();
    let header = |bench: &mut Bench, columns| {
        let frame = bench.frame(columns, 24);
        frame.lines().next().unwrap().to_string()
    };
    let words = format!("variant · collision with {} · {name}", with.with);
    let narrow = header(&mut bench, 80);
    assert!(narrow.contains(&words), "{narrow}");
    assert!(header(&mut bench, 200).contains("cp+cot+icl"));
    bench.press("space g o");
    let original = header(&mut bench, 80);
    assert!(
        original.contains("original · goal reached · "),
        "{original}"
    );
}

#[test]
fn the_attacker_is_named_however_little_room_there_is() {
    let mut bench = shown("rightturn", 80, 24);
    let attacker = made(&bench).effect.main().obstacle;
    // The list in front leaves few rows to the map; farther away all bodies share a few cells.
    for focus in ["", "tab"] {
        bench.press(focus);
        for _ in 0..6 {
            let frame = bench.frame(80, 24);
            let map: Vec<&str> = frame.lines().skip(1).collect();
            let label = format!("X {attacker}");
            let named = |line: &&str| line.contains(&label);
            assert!(map.iter().any(named), "{frame}");
            bench.perform("zoom-out");
        }
    }
}

#[test]
fn the_plot_says_both_scores() {
    let bench = shown("rightturn", 80, 24);
    let scores = "⠒⠒after 0 · ⠂⠀⠂before ";
    let frame = bench.frame(80, 24);
    assert!(frame.contains(&format!(" risk · {scores}")), "{frame}");
    let wide = bench.frame(200, 60);
    let title = format!("attacker's risk now, 0 = collision · {scores}");
    assert!(wide.contains(&title), "{wide}");
}

#[test]
fn who_has_a_variant_needs_no_way_to_a_first_verdict() {
    let mut bench = open("rightturn");
    bench.model.recall.hint = true;
    assert!(bench.frame(80, 24).contains("worst moment"));
    bench.press("space g g");
    arrive(&mut bench);
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        assert!(
            !frame.contains("three keys") && !frame.contains("x worst moment"),
            "{frame}"
        );
    }
}
