//! The risk scores of a whole scene: of every obstacle at every step, exactly or by the convention of the paper.

use super::paper::{self, TooLarge};
use super::{Encounter, MEASURES, Thresholds};
use crate::scenario::Scene;

/// By which numbers and thresholds a risk score is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum RiskConvention {
    /// Real bodies, and the table of the thresholds in use; see [`super::RISK_LEVELS`].
    #[default]
    Exact,
    /// That of the tables published with "From Words to Collisions", of obstacles within 30 m; see [`paper::Risk`].
    Paper,
}

/// The score of an obstacle at a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ScoreAt {
    /// The time step.
    pub step: i64,
    /// 0 (collision) to 5 (negligible).
    pub score: u8,
    /// The obstacle.
    pub obstacle: i64,
}

impl RiskConvention {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Paper => "paper",
        }
    }

    /// The scores of a scene that are at most `most`, by step, the worst of a step first.
    ///
    /// # Errors
    /// The scene cannot be scored by the paper's convention, whose tables hold no numbers as large as its own.
    pub fn scores_up_to(
        self,
        most: u8,
        scene: &Scene,
        thresholds: &Thresholds,
    ) -> Result<Vec<ScoreAt>, TooLarge> {
        match self {
            Self::Exact => Ok(Self::exact_up_to(most, scene, thresholds)),
            Self::Paper => Ok(up_to(most, of_paper(scene)?)),
        }
    }

    /// The same by [`Self::Exact`], which scores every scene.
    #[must_use]
    pub fn exact_up_to(most: u8, scene: &Scene, thresholds: &Thresholds) -> Vec<ScoreAt> {
        up_to(most, exact(scene, thresholds))
    }
}

fn up_to(most: u8, mut found: Vec<ScoreAt>) -> Vec<ScoreAt> {
    found.retain(|one| one.score <= most);
    found.sort_unstable();
    found
}

fn exact(scene: &Scene, thresholds: &Thresholds) -> Vec<ScoreAt> {
    let Some(risk) = MEASURES.iter().find(|measure| measure.id == "risk") else {
        return Vec::new();
    };
    let everyone: Vec<_> = scene.participants().collect();
    let of_step = |step: i64| {
        let at = move |other: &_| {
            let encounter = Encounter::at(scene, other, step)?.under(thresholds);
            let score = risk.of(&encounter).value()?;
            Some(ScoreAt {
                step,
                score: score as u8,
                obstacle: other.obstacle.id,
            })
        };
        everyone.iter().filter_map(at).collect::<Vec<_>>()
    };
    scene.steps().flat_map(of_step).collect()
}

fn of_paper(scene: &Scene) -> Result<Vec<ScoreAt>, TooLarge> {
    let rows = paper::rows(scene)?;
    let near = rows.iter().filter(|row| row.distance <= paper::RADIUS);
    let score = |row: &paper::Row| ScoreAt {
        step: row.timestep,
        score: row.risk.risk_score,
        obstacle: row.obstacle,
    };
    Ok(near.map(score).collect())
}
