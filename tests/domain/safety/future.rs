//! The judge of safety sees nothing after the window: whatever happens there, it says the same.

use nearmiss::geometry::Pose;
use nearmiss::scenario::Window;
use nearmiss::scenario::prediction::ObservedHistory;

use crate::safety::scenes::{NOW, all, safety};
use crate::safety::stage::HERE;

#[test]
fn another_future_changes_nothing() {
    for (name, stage, _) in all() {
        let as_recorded = safety(&stage.at(HERE));
        // All in one place: looking ahead would show a collision.
        let together = stage.changed_after(HERE, NOW, |_, _| Some(Pose::new(5.0, 5.0, 1.0)));
        // All far apart: looking ahead would show none.
        let apart = stage.changed_after(HERE, NOW, |id, _| {
            Some(Pose::new(1e4, 1e4 * (1.0 + id as f64), -2.0))
        });
        // No future at all.
        let none = stage.changed_after(HERE, NOW, |_, _| None);
        for other in [together, apart, none] {
            assert_eq!(as_recorded, safety(&other), "{name}");
        }
    }
}

#[test]
fn what_is_before_the_window_changes_nothing_either_way_it_ends() {
    for (_, stage, _) in all() {
        let scene = stage.at(HERE);
        let past = ObservedHistory::from_window(&scene, &Window::ending_at(&scene, NOW, 4));
        assert_eq!(past.now(), NOW);
        let seen = past.ego().into_iter().chain(past.others());
        for one in seen.filter(|one| !one.who.parked) {
            let steps: Vec<i64> = one.motions.iter().map(|(step, _)| *step).collect();
            assert_eq!(steps, [6, 7, 8, 9]);
        }
    }
}
