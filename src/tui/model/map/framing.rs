//! What a map shows until the user zooms: the ego, and who matters most beside it.

use super::{Moment, On};
use crate::model::{Camera, Model};
use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::metrics::Headline;

/// Cells are at least so wide, metres, where the map chooses.
const NEAREST: f64 = 0.6;
/// And at most, where that shows both the ego and the other: beyond, bodies are single arrows.
const FARTHEST: f64 = 4.0;
/// Between two widths of cells: so the map does not zoom at every step.
const STEP: f64 = 1.25;
/// Around the middle of a body, metres, for the body and a part of its name.
const AROUND: f64 = 5.0;

impl Model {
    /// The camera of a map of so many columns and rows at a moment. Until the user zooms, it shows the ego, and the
    /// picked obstacle or else the most dangerous one, as near as possible.
    #[must_use]
    pub fn camera_of(&self, size: (u16, u16), moment: &Moment<'_>) -> Camera {
        let mut camera = self.camera.clone();
        let (true, true, Some(ego)) = (camera.auto, camera.follow, moment.ego()) else {
            return camera;
        };
        let (columns, rows) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
        camera.shift = Vector::zeros();
        camera.cell = NEAREST.max(camera.least / columns);
        let frame = camera.frame(Some(ego));
        for place in self.places_of_others(moment) {
            let to = frame.to_local(&place);
            let needs = ((to.y.abs() + 2.0 * AROUND) / columns)
                .max((to.x.abs() + 2.0 * AROUND) / (rows * camera.aspect));
            let steps = (needs / camera.cell).log(STEP).ceil().max(0.0);
            let cell = camera.cell * STEP.powf(steps);
            if !cell.is_finite() || cell > FARTHEST.max(camera.cell) {
                continue;
            }
            camera.cell = cell;
            // As little off the middle as shows both.
            let aside = |to: f64, length: f64| {
                let by = (to.abs() + AROUND - length / 2.0).max(0.0);
                by.copysign(to)
            };
            camera.shift = Vector::new(
                aside(to.x, rows * camera.row()),
                aside(to.y, columns * camera.cell),
            );
            break;
        }
        camera
    }

    /// Where the picked obstacle is, and the most dangerous one.
    fn places_of_others(&self, moment: &Moment<'_>) -> impl Iterator<Item = Point> {
        let headline = moment.opened.headline.as_ref();
        let worst = headline.and_then(Headline::worst);
        let all = self.picked.into_iter().chain(worst.map(|w| w.obstacle));
        let motions = all.filter_map(|id| {
            let motion = moment.opened.motion_of(On::Obstacle(id), moment.step)?;
            Some(motion.pose.position)
        });
        motions.collect::<Vec<_>>().into_iter()
    }

    /// Takes over what the map showed last, so that keys and the mouse start from there.
    pub fn settle_camera(&mut self) {
        if let Some(now) = self.moment() {
            let camera = self.camera_of(self.drawn.map_size(), &now);
            self.camera = camera;
        }
    }
}
