//! Quitting: at once, or asked again while something runs.

use super::bench::Bench;
use crate::message::Effect;

#[test]
fn q_asks_again_while_something_runs() {
    let mut bench = super::answers::asking();
    let quits = |bench: &Bench| bench.effects.iter().any(|e| matches!(e, Effect::Quit));
    bench.press("q");
    assert!(!quits(&bench));
    assert!(
        bench
            .frame(120, 40)
            .contains("1 question is running; q again")
    );
    bench.press("q");
    assert!(quits(&bench));
    let mut bench = Bench::bundled();
    bench.press("q");
    assert!(quits(&bench), "nothing runs");
}
