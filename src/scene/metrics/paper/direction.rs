//! The direction of an obstacle in the published tables' terms: its centre against one length and one width.

use super::{LENGTH, WIDTH};

/// Position along the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Along {
    /// More than a length ahead.
    Front,
    /// Within a length.
    Beside,
    /// More than a length behind.
    Behind,
}

/// Position across the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Across {
    /// More than a width to the left.
    Left,
    /// Within a width.
    Aligned,
    /// More than a width to the right.
    Right,
}

/// Both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Direction {
    /// Along the ego's heading.
    pub along: Along,
    /// Across it.
    pub across: Across,
}

impl Direction {
    /// The direction of a centre, metres forward and to the left of the ego's.
    #[must_use]
    pub fn from_offsets(d_long: f64, d_lat: f64) -> Self {
        let along = if d_long > LENGTH {
            Along::Front
        } else if d_long < -LENGTH {
            Along::Behind
        } else {
            Along::Beside
        };
        let across = if d_lat > WIDTH {
            Across::Left
        } else if d_lat < -WIDTH {
            Across::Right
        } else {
            Across::Aligned
        };
        Self { along, across }
    }

    /// The published word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.along, self.across) {
            (Along::Front, Across::Aligned) => "Front",
            (Along::Front, Across::Left) => "Front-left",
            (Along::Front, Across::Right) => "Front-right",
            (Along::Behind, Across::Aligned) => "Behind",
            (Along::Behind, Across::Left) => "Rear-left",
            (Along::Behind, Across::Right) => "Rear-right",
            (Along::Beside, Across::Left) => "Left",
            (Along::Beside, Across::Right) => "Right",
            (Along::Beside, Across::Aligned) => "Collision",
        }
    }

    /// How much the longitudinal grade counts against the lateral one: all of it straight ahead, nothing
    /// beside, half everywhere else, also straight behind.
    #[must_use]
    pub fn longitudinal_weight(self) -> f64 {
        match (self.along, self.across) {
            (Along::Front, Across::Aligned) => 1.0,
            (Along::Beside, Across::Left | Across::Right) => 0.0,
            _ => 0.5,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_has_its_word_and_weight() {
        let expected = [
            (9.0, 0.0, "Front", 1.0),
            (9.0, 3.0, "Front-left", 0.5),
            (9.0, -3.0, "Front-right", 0.5),
            (-9.0, 0.0, "Behind", 0.5),
            (-9.0, 3.0, "Rear-left", 0.5),
            (-9.0, -3.0, "Rear-right", 0.5),
            (1.0, 3.0, "Left", 0.0),
            (1.0, -3.0, "Right", 0.0),
            (1.0, 1.0, "Collision", 0.5),
        ];
        for (d_long, d_lat, name, weight) in expected {
            let direction = Direction::from_offsets(d_long, d_lat);
            assert_eq!(direction.name(), name);
            assert_eq!(direction.longitudinal_weight(), weight, "{name}");
        }
    }

    #[test]
    fn exactly_a_length_or_a_width_away_is_not_outside() {
        assert_eq!(Direction::from_offsets(LENGTH, WIDTH).name(), "Collision");
        assert_eq!(Direction::from_offsets(-LENGTH, -WIDTH).name(), "Collision");
        assert_eq!(
            Direction::from_offsets(LENGTH.next_up(), WIDTH.next_up()).name(),
            "Front-left"
        );
    }
}
