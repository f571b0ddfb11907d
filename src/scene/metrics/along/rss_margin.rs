//! Joint margin of responsibility-sensitive safety: how much more room there is than both safe distances ask for.
//!
//! The larger of the longitudinal and the lateral margin. RSS calls a situation dangerous only while both distances
//! are shorter than the safe ones, so this is negative then and only then. Source: Shalev-Shwartz, Shammah and
//! Shashua, On a Formal Model of Safe and Scalable Self-driving Cars, 2017.

use super::super::{Danger, Measure, Mirrored};
use super::{rss_lateral, rss_longitudinal};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "rss_margin",
    name: "RSS margin",
    unit: "m",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "larger of the two margins; dangerous below 0 (Shalev-Shwartz et al. 2017)",
    compute: |e| {
        e.ask(|c, other, i| {
            let (ego, other, rss) = (c.ego_along(i)?, c.along(other, i)?, &c.limits().rss);
            let along = rss_longitudinal::margin(&ego, &other, rss);
            Ok(along.max(rss_lateral::margin(&ego, &other, rss)))
        })
        .into()
    },
};
