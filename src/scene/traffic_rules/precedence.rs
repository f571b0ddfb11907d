//! Who goes first at an intersection: signs, then turning left, then right before left.

use super::Rule;
use super::junction::Turn;
use crate::scenario::{Lanelet, LaneletNetwork, SignMeaning};
use nearmiss_base::geometry::angle_between;

/// What the signs of a road that leads into an intersection say about precedence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SignRank {
    /// Stop and give way.
    Stop,
    /// Give way.
    Yield,
    /// Nothing, or that it is right before left.
    Unsigned,
    /// Right of way here, or a priority road.
    Priority,
}

impl SignRank {
    /// Of lanelets with their signs: the strictest that is said.
    pub(super) fn of<'a>(
        network: &LaneletNetwork,
        lanelets: impl IntoIterator<Item = &'a Lanelet>,
    ) -> Self {
        let mut rank = Self::Unsigned;
        let mut prior = false;
        for id in lanelets.into_iter().flat_map(|l| &l.signs) {
            let sign = network.signs.iter().find(|sign| sign.id == *id);
            for element in sign.into_iter().flat_map(|sign| &sign.elements) {
                match element.meaning() {
                    Some(SignMeaning::Words("stop")) => rank = Self::Stop,
                    Some(SignMeaning::Words("yield")) => rank = rank.min(Self::Yield),
                    Some(SignMeaning::Words("right of way" | "priority road")) => prior = true,
                    _ => {}
                }
            }
        }
        if rank == Self::Unsigned && prior {
            Self::Priority
        } else {
            rank
        }
    }

    /// The number that decides for a turn, after the table of R-IN4: the higher one goes first.
    fn number(self, turn: Turn) -> u8 {
        match self {
            Self::Stop => 1,
            Self::Yield => 2,
            Self::Unsigned => 3,
            Self::Priority if turn == Turn::Straight => 5,
            Self::Priority => 4,
        }
    }
}

/// One of two vehicles that meet: the heading with which it enters (radians), where it turns to, and its signs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Party {
    pub heading: f64,
    pub turn: Turn,
    pub rank: SignRank,
}

/// Half of the angle within which others are opposite, radians; and the least angle from which they come from a side.
const OPPOSITE: f64 = std::f64::consts::FRAC_PI_4;
const SAME: f64 = std::f64::consts::FRAC_PI_6;

/// The rule by which the first has to give way to the second; `None` where it need not. With `lights` on its own lane
/// only an oncoming vehicle comes before its left turn: the others have red.
pub(super) fn gives_way(own: &Party, other: &Party, lights: bool) -> Option<Rule> {
    let turn = angle_between(own.heading, other.heading);
    let opposite = turn.abs() > std::f64::consts::PI - OPPOSITE;
    let before_left = opposite && own.turn == Turn::Left && other.turn != Turn::Left;
    if lights {
        return before_left.then_some(Rule::LeftTurn);
    }
    let (mine, theirs) = (own.rank.number(own.turn), other.rank.number(other.turn));
    let both_prior = own.rank == SignRank::Priority && other.rank == SignRank::Priority;
    if both_prior && opposite {
        return before_left.then_some(Rule::LeftTurn);
    }
    if mine != theirs {
        return (mine < theirs).then_some(Rule::Priority);
    }
    if before_left {
        return Some(Rule::LeftTurn);
    }
    // It comes from the right: it drives to the left as seen from here.
    let from_right = turn > SAME && !opposite;
    from_right.then_some(Rule::RightBeforeLeft)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn party(heading: f64, turn: Turn, rank: SignRank) -> Party {
        Party {
            heading,
            turn,
            rank,
        }
    }

    #[test]
    fn signs_come_first_then_left_turns_then_the_right() {
        use SignRank::*;
        use Turn::*;
        let own = |turn, rank| party(FRAC_PI_2, turn, rank);
        let right = |turn, rank| party(PI, turn, rank);
        let left = |turn, rank| party(0.0, turn, rank);
        let oncoming = |turn, rank| party(-FRAC_PI_2, turn, rank);
        for (mine, other, lights, rule) in [
            (
                own(Straight, Unsigned),
                right(Straight, Unsigned),
                false,
                Some(Rule::RightBeforeLeft),
            ),
            (
                own(Straight, Unsigned),
                left(Straight, Unsigned),
                false,
                None,
            ),
            (
                own(Straight, Unsigned),
                oncoming(Left, Unsigned),
                false,
                None,
            ),
            (
                own(Left, Unsigned),
                oncoming(Straight, Unsigned),
                false,
                Some(Rule::LeftTurn),
            ),
            (own(Left, Unsigned), oncoming(Left, Unsigned), false, None),
            (
                own(Straight, Yield),
                left(Straight, Priority),
                false,
                Some(Rule::Priority),
            ),
            (
                own(Straight, Stop),
                left(Straight, Yield),
                false,
                Some(Rule::Priority),
            ),
            (own(Straight, Priority), right(Straight, Yield), false, None),
            (
                own(Left, Priority),
                oncoming(Straight, Priority),
                false,
                Some(Rule::LeftTurn),
            ),
            (
                own(Straight, Priority),
                oncoming(Left, Priority),
                false,
                None,
            ),
            (
                own(Straight, Unsigned),
                right(Straight, Unsigned),
                true,
                None,
            ),
            (
                own(Left, Unsigned),
                oncoming(Right, Unsigned),
                true,
                Some(Rule::LeftTurn),
            ),
        ] {
            assert_eq!(gives_way(&mine, &other, lights), rule, "{mine:?} {other:?}");
        }
    }
}
