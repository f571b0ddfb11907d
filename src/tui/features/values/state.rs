//! All measures of the picked obstacle and of the scene, computed while they are displayed.

use crate::loaded::Measured;
use crate::model::MeasureId;

/// The last request and its result.
#[derive(Debug, Default)]
pub struct Values {
    /// The last request, and about whom; `None` before the first one for a scene.
    pub asked: Option<(MeasureId, Option<i64>)>,
    /// The last result; it may be about the obstacle that was picked before.
    pub found: Option<Box<Measured>>,
}

impl Values {
    /// The values of this obstacle, if they are known.
    #[must_use]
    pub fn for_obstacle(&self, obstacle: Option<i64>) -> Option<&Measured> {
        self.found
            .as_deref()
            .filter(|found| found.obstacle == obstacle)
    }
}
