//! What a row of an index says its window is of: manoeuvre, road, severity and type of obstacle.

use super::parts::{IndexError, PartRow};
use super::{Manoeuvre, RoadType};
use crate::scenario::ObstacleType;
use nearmiss_base::system::unknown;

/// What a window is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowCell {
    /// What the obstacle does.
    pub manoeuvre: Manoeuvre,
    /// The road under the ego.
    pub road: RoadType,
    /// The severity of its most severe step, 0 (contact) to 5 (none).
    pub severity: u8,
    /// The obstacle's type.
    pub actor: ObstacleType,
}

impl RowCell {
    /// Reads it from the text columns `manoeuvre`, `road` and `obstacle_type` and the integer column `severity`, which
    /// are at these places.
    ///
    /// # Errors
    /// A word or number that no index has.
    pub fn of(
        row: &PartRow<'_>,
        (manoeuvre, road, actor): (usize, usize, usize),
        severity: usize,
    ) -> Result<Self, IndexError> {
        let word = row.text(manoeuvre)?;
        let manoeuvre = Manoeuvre::ALL
            .into_iter()
            .find(|one| one.name() == word)
            .ok_or_else(|| {
                row.foreign(unknown(
                    "manoeuvre",
                    word,
                    Manoeuvre::ALL.map(Manoeuvre::name),
                ))
            })?;
        let word = row.text(road)?;
        let road = RoadType::ALL
            .into_iter()
            .find(|one| one.name() == word)
            .ok_or_else(|| row.foreign(unknown("road", word, RoadType::ALL.map(RoadType::name))))?;
        let word = row.text(actor)?;
        let actor = ObstacleType::parse(word).ok_or_else(|| {
            let known = ObstacleType::ALL.iter().map(|kind| kind.name());
            row.foreign(unknown("obstacle_type", word, known))
        })?;
        let severity = row.severity(severity)?;
        Ok(Self {
            manoeuvre,
            road,
            severity,
            actor,
        })
    }
}
