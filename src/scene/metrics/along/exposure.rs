//! Sums over the rest of the recording that several measures share, from the last step to the first. Steps of contact are
//! not in them: there is no gap left to close.

use super::{crash_potential, drac, lane_ttc};
use crate::metrics::Context;

/// The quantity summed from a step to the end of the recording.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::metrics) struct Exposure {
    /// Seconds with a time to collision below the threshold.
    pub exposed: f64,
    /// The deficit to the threshold, integrated over time, s².
    pub integrated: f64,
    /// Probabilities that the needed deceleration is not available, added up.
    pub crash: f64,
    /// Steps at which both are there.
    pub steps: u32,
}

impl Exposure {
    /// The sums from every step of the ego on.
    pub fn rows(context: &Context<'_>, participant: usize) -> Vec<Self> {
        let mut rows = vec![Self::default(); context.length()];
        let mut sum = Self::default();
        let limits = context.limits();
        for index in (0..context.length()).rev() {
            let both = context.ego[index].is_some() && context.other(participant, index).is_some();
            sum.steps += u32::from(both);
            if both && let Ok(following) = context.following(participant, index) {
                if let Ok(time) = lane_ttc::time(&following)
                    && time < limits.tau
                {
                    sum.exposed += context.dt();
                    sum.integrated += (limits.tau - time) * context.dt();
                }
                if let Ok(rate) = drac::rate(&following) {
                    sum.crash += crash_potential::probability(rate, &limits.madr);
                }
            }
            rows[index] = sum;
        }
        rows
    }
}
