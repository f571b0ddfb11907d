//! Where bodies have been as lines, where they will be as dots.

use super::canvas::Canvas;
use super::lines::stroke;
use super::{Appearance, CellView};
use crate::scene::{MapScene, Owner};

/// Lines behind them, thick for the ego and those pointed out; ahead, as far as it is recorded, a dot for every other
/// step.
pub fn draw(canvas: &mut Canvas<'_>, look: &Appearance<'_>, scene: &MapScene<'_>, view: &CellView) {
    let theme = look.theme;
    for trail in &scene.trails {
        let (past, future) = match (trail.owner, trail.highlighted) {
            (Owner::Ego, _) => (theme.ego_trail, theme.ego_trail),
            (_, Some(_)) => (theme.trail, theme.picked),
            (_, None) => (theme.trail, theme.trail),
        };
        let thick = trail.owner == Owner::Ego || trail.highlighted.is_some();
        for pair in trail.past.windows(2) {
            let ends = [pair[0].1.pose.position, pair[1].1.pose.position];
            if thick {
                canvas.thick(view.at(&ends[0]), view.at(&ends[1]), past)
            } else {
                stroke(canvas, view, &ends, past)
            }
        }
        for (_, motion) in trail.future.iter().step_by(2) {
            canvas.point(view.at(&motion.pose.position), future);
        }
    }
}
