//! Generation by a model: who may attack, and what came to nothing.

use super::events;
use super::written::{asked, count, open, said, unwritten};
use crate::features::generation::panel::VariantScreen;

#[test]
fn the_picked_obstacle_attacks_and_the_judge_writes_nothing() {
    let mut bench = open();
    bench.model.picked = Some(305);
    bench.perform("generate-with-model-by");
    bench.press("enter");
    assert_eq!(asked(&bench).1.only, Some(305));
    bench.press("esc esc");
    bench.model.model = nearmiss_scene::judge::MODEL.into();
    bench.press("space g m");
    assert_eq!(count(&bench), 1);
    let words = said(&bench.model);
    assert!(
        words.contains("m chooses a model, Space g g searches without one"),
        "{words}"
    );
}

#[test]
fn what_came_to_nothing_can_be_read() {
    let mut bench = open();
    bench.press("space g v");
    assert!(bench.model.screens.is_empty());
    bench.press("space g m enter");
    let (id, _) = asked(&bench);
    let nothing = unwritten("lab/\u{1b}[31msmall");
    bench.send(events::generated(id, Ok(nothing)));
    assert!(said(&bench.model).ends_with("Space g v details"));
    bench.press("space g v");
    assert!(bench.model.screens.is_top::<VariantScreen>());
    let panel = bench.frame(200, 60);
    for words in [
        "what the model wrote",
        "1 answer, 0 passed the gate",
        "x rejected: lab/␛[31msmall",
        "305, by the model",
    ] {
        assert!(panel.contains(words), "{words}\n{panel}");
    }
    assert!(!panel.contains('\u{1b}'));
}
