//! Merged lanes: every way through a lanelet, from its predecessors to its successors, as one lane.

use std::collections::HashSet;

use super::Lane;
use crate::scenario::{Lanelet, LaneletNetwork};

/// How far and how many ways are followed; networks branch without end and have cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MergeLimits {
    /// Metres of lanelets before, and metres after the lanelet, after which no more are added.
    pub reach: f64,
    /// Most lanes.
    pub lanes: usize,
}

impl Default for MergeLimits {
    /// 150 m, as the reference reader has it, and 64 lanes.
    fn default() -> Self {
        Self {
            reach: 150.0,
            lanes: 64,
        }
    }
}

/// The lanes through a lanelet.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedLanes {
    /// One a way, each with the lanelet in it.
    pub lanes: Vec<Lane>,
    /// Whether there are no more ways than the limit allows.
    pub complete: bool,
}

impl LaneletNetwork {
    /// All lanes through the lanelet `id`: a chain of predecessors, the lanelet, a chain of successors.
    ///
    /// No lanelet is twice in a lane. Nothing where there is no such lanelet or it has no length.
    #[must_use]
    pub fn merged_lanes(&self, id: i64, limits: &MergeLimits) -> Option<MergedLanes> {
        let middle = self.lanelet(id)?;
        Lane::of(middle)?;
        let (before, all_before) = self.chains(middle, |l| &l.predecessors, limits);
        let (after, all_after) = self.chains(middle, |l| &l.successors, limits);
        let mut lanes = Vec::new();
        let mut complete = all_before && all_after;
        for head in &before {
            for tail in &after {
                // What lies before may come again after in a cycle; it ends the lane.
                let seen: HashSet<i64> = head.iter().map(|l| l.id).collect();
                let tail = tail.iter().take_while(|l| !seen.contains(&l.id));
                let chain = head.iter().rev().chain([&middle]).chain(tail).copied();
                let Some(lane) = Lane::merged(chain) else {
                    continue;
                };
                if lanes.iter().any(|l: &Lane| l.lanelets == lane.lanelets) {
                    continue;
                }
                if lanes.len() == limits.lanes {
                    complete = false;
                    break;
                }
                lanes.push(lane);
            }
        }
        Some(MergedLanes { lanes, complete })
    }

    /// Chains of lanelets away from `start`, which is not in them, and whether these are all.
    fn chains<'a>(
        &'a self,
        start: &'a Lanelet,
        next: fn(&Lanelet) -> &Vec<i64>,
        limits: &MergeLimits,
    ) -> (Vec<Vec<&'a Lanelet>>, bool) {
        let (mut done, mut open) = (Vec::new(), vec![(vec![], 0.0)]);
        while let Some((chain, length)) = open.pop() {
            let end: &Lanelet = chain.last().copied().unwrap_or(start);
            let mut further: Vec<&Lanelet> = Vec::new();
            if length < limits.reach {
                for id in next(end) {
                    let fresh = self.lanelet(*id).filter(|l| {
                        l.id != start.id
                            && chain.iter().all(|c: &&Lanelet| c.id != l.id)
                            && further.iter().all(|f| f.id != l.id)
                    });
                    further.extend(fresh);
                }
            }
            if further.is_empty() {
                done.push(chain);
                if done.len() >= limits.lanes {
                    return (done, open.is_empty());
                }
                continue;
            }
            for lanelet in further.into_iter().rev() {
                let more = Lane::of(lanelet).map_or(0.0, |l| l.length());
                let longer = chain.iter().copied().chain([lanelet]).collect();
                open.push((longer, length + more));
            }
        }
        (done, true)
    }
}
