//! The list of jumps: places that were left, to go back to and forward again.

use super::OpenId;

/// A place: a scenario, a step and the picked obstacle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The scenario, by its place in the list.
    pub scenario: usize,
    /// The obstacle that was taken as the ego.
    pub taken: Option<i64>,
    /// The time step.
    pub step: i64,
    /// The picked obstacle.
    pub picked: Option<i64>,
}

/// Places to go back to and forward to, the next one last.
#[derive(Debug, Clone, Default)]
pub struct JumpList {
    back: Vec<Place>,
    forward: Vec<Place>,
    /// The place to go to when its scenario has been opened.
    pub arriving: Option<(OpenId, Place)>,
}

/// Places that are kept.
const KEPT: usize = 100;

impl JumpList {
    /// A jump leaves this place: what lay ahead is forgotten.
    pub fn leave(&mut self, place: Place) {
        self.forward.clear();
        if self.back.last() != Some(&place) {
            self.back.push(place);
        }
        let over = self.back.len().saturating_sub(KEPT);
        self.back.drain(..over);
    }

    /// The place before the last jump, or after it, in exchange for the present one.
    pub fn turn(&mut self, back: bool, now: Option<Place>) -> Option<Place> {
        let (from, to) = if back {
            (&mut self.back, &mut self.forward)
        } else {
            (&mut self.forward, &mut self.back)
        };
        // A jump that led nowhere is none.
        while from.last().is_some_and(|place| Some(place) == now.as_ref()) {
            from.pop();
        }
        let place = from.pop()?;
        to.extend(now);
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: i64) -> Place {
        Place {
            scenario: 0,
            taken: None,
            step,
            picked: None,
        }
    }

    #[test]
    fn back_and_forward_and_a_jump_forgets_what_lay_ahead() {
        let mut jumps = JumpList::default();
        jumps.leave(at(1));
        jumps.leave(at(2));
        assert_eq!(jumps.turn(true, Some(at(3))), Some(at(2)));
        assert_eq!(jumps.turn(true, Some(at(2))), Some(at(1)));
        assert_eq!(jumps.turn(true, Some(at(1))), None);
        assert_eq!(jumps.turn(false, Some(at(1))), Some(at(2)));
        assert_eq!(jumps.turn(false, Some(at(2))), Some(at(3)));
        assert_eq!(jumps.turn(true, Some(at(3))), Some(at(2)));
        jumps.leave(at(2));
        assert_eq!(jumps.turn(false, Some(at(9))), None);
        for step in 0..500 {
            jumps.leave(at(step));
        }
        assert_eq!(jumps.back.len(), KEPT);
    }
}
