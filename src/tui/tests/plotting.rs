//! Measures over time, and the list in their order.

use super::bench::Bench;
use crate::tui::message::{Effect, Msg};

#[test]
fn any_measure_is_plotted_for_chosen_obstacles() {
    let mut bench = Bench::bundled();
    bench.press("p");
    bench.type_text("ttc");
    bench.press("enter");
    assert_eq!(bench.model.plot.measure.id, "ttc");
    let picked = bench.model.picked.unwrap();
    bench.press("b o b o");
    assert_eq!(bench.model.plot.marked.len(), 2);
    assert_eq!(bench.model.plot.marked[0], picked);
    let frame = bench.frame(200, 60);
    for words in ["ttc · picked", "critical 1.50 s", &format!("━{picked}")] {
        assert!(frame.contains(words), "{words}: {frame}");
    }
    bench.press("shift-o b");
    assert_eq!(bench.model.plot.marked.len(), 1);
    bench.press("down");
    assert!(bench.model.plot.marked.is_empty(), "of another scenario");
    assert!(bench.model.plot.series.is_some());
}

#[test]
fn the_list_is_sorted_by_a_measure() {
    let mut bench = Bench::bundled();
    let selected = bench.model.list.current();
    bench.press("s");
    bench.type_text("distance");
    bench.press("enter");
    let asked = bench.effects.iter().find_map(|e| match e {
        Effect::Rank(measure, entries) => Some((*measure, entries.len())),
        _ => None,
    });
    assert_eq!(asked, Some(("distance", 8)));
    assert!(bench.frame(200, 60).contains("by distance, m"));
    for (place, value) in [(0, Some(3.0)), (5, Some(0.25)), (2, None)] {
        bench.send(Msg::Ranked("distance", place, value));
    }
    bench.send(Msg::Ranked("ttc", 1, Some(0.0)));
    assert_eq!(
        bench.model.list.visible[..2],
        [5, 0],
        "what is not known comes last"
    );
    assert_eq!(bench.model.list.current(), selected);
    assert!(bench.frame(200, 60).contains("0.25 "));
    bench.press("s enter");
    assert_eq!(bench.model.list.visible[..3], [0, 1, 2]);
}
