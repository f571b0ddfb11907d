//! Lanes by number: which lane of a route a lanelet belongs to, counted from the one where it starts.

use std::collections::{HashMap, VecDeque};

use super::{DirectedLanelet, LaneGraph, Route, Side};

/// Neighbours farther away than this are not counted, lanes.
const WIDEST: i32 = 16;

impl LaneGraph<'_> {
    /// The number of the lane of every lanelet along `route` and beside it: 0 for the lane where the route
    /// starts, one more for each lane to the left, one less for each to the right, whichever way they are driven.
    ///
    /// A lane keeps its number along the route, and a lane change does not move the count. Lanelets that lead
    /// elsewhere have none. What the path follows before and after the route is counted too.
    #[must_use]
    pub fn lane_numbers(&self, route: &Route) -> HashMap<i64, i32> {
        let mut numbers: HashMap<i64, i32> = HashMap::new();
        let mut here = 0;
        let before = route.before.iter().map(|d| (*d, None));
        let legs = route.legs.iter().map(|leg| (leg.driven, leg.change));
        let after = route.after.iter().map(|d| (*d, None));
        let mut seeds: VecDeque<(DirectedLanelet, i32)> = VecDeque::new();
        for (driven, change) in before.chain(legs).chain(after) {
            here += match change {
                Some(Side::Left) => 1,
                Some(Side::Right) => -1,
                None => 0,
            };
            // The lanes of the route come first: neighbours never take their numbers.
            if let std::collections::hash_map::Entry::Vacant(free) = numbers.entry(driven.lanelet) {
                free.insert(here);
                seeds.push_back((driven, here));
            }
        }
        while let Some((driven, number)) = seeds.pop_front() {
            for (side, step) in [(Side::Left, 1), (Side::Right, -1)] {
                let next = number + step;
                let Some(beside) = self.beside(driven, side) else {
                    continue;
                };
                if next.abs() <= WIDEST && !numbers.contains_key(&beside.lanelet) {
                    numbers.insert(beside.lanelet, next);
                    seeds.push_back((beside, next));
                }
            }
        }
        numbers
    }

    /// The lanelet on a side of a lane, seen the way that the lane is driven, whatever users it allows.
    fn beside(&self, driven: DirectedLanelet, side: Side) -> Option<DirectedLanelet> {
        let place = self.network.place(driven.lanelet)?;
        let lanelet = &self.network.lanelets[place];
        let along = driven.direction == super::Direction::Along;
        let adjacent = if (side == Side::Left) == along {
            lanelet.adjacent_left
        } else {
            lanelet.adjacent_right
        }?;
        self.network.place(adjacent.id)?;
        Some(DirectedLanelet {
            lanelet: adjacent.id,
            direction: if adjacent.same_direction {
                driven.direction
            } else {
                driven.direction.other()
            },
        })
    }
}
