//! Whole frames, and every size.

use super::bench::{Bench, answer};
use super::events;
use crate::model::Pane;

/// The first scenario at its contact, with two answers to compare.
fn compared() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("x");
    for (model, dangerous, who) in [("lab/small", false, 302), ("lab/large", true, 301)] {
        bench.model.model = model.into();
        bench.press("r");
        let (id, _) = bench.asked();
        bench.send(events::answered(
            id,
            Ok(Box::new(answer(model, dangerous, who))),
        ));
    }
    bench.model.toasts.clear();
    bench
}

#[test]
fn at_80_by_24() {
    insta::assert_snapshot!(compared().frame(80, 24));
}

#[test]
fn at_80_by_24_with_the_map() {
    let mut bench = compared();
    bench.model.focus = Pane::Map;
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn at_120_by_40() {
    insta::assert_snapshot!(compared().frame(120, 40));
}

#[test]
fn at_200_by_60() {
    insta::assert_snapshot!(compared().frame(200, 60));
}

#[test]
fn models_to_choose_from() {
    let mut bench = Bench::bundled();
    bench.press("m");
    insta::assert_snapshot!(bench.frame(100, 30));
}

#[test]
fn too_small_is_said() {
    for (columns, rows) in [(59, 24), (60, 17), (30, 8)] {
        assert!(
            compared().frame(columns, rows).contains("too small"),
            "{columns}×{rows}"
        );
    }
}

#[test]
fn no_size_is_too_much_or_too_little() {
    let mut bench = compared();
    let overlays = ["", "?", "i", "shift-v", "m", ":", "e"];
    for keys in overlays {
        bench.press(keys);
        for columns in [1, 2, 10, 59, 60, 79, 80, 109, 110, 160, 300] {
            for rows in [1, 2, 5, 17, 18, 24, 31, 32, 90] {
                bench.frame(columns, rows);
            }
        }
        bench.press("esc");
    }
    for pane in Pane::ALL {
        bench.model.focus = pane;
        bench.model.zoomed = true;
        for size in [(80, 24), (120, 40), (200, 60)] {
            bench.frame(size.0, size.1);
        }
    }
}
