//! How an obstacle moves against the ego, along and across its heading: the cases of the published descriptions, in
//! words of our own.

use super::{Across, Along};

/// The relative motion along the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AlongMotion {
    /// It overlaps the ego along this axis; its motion is not looked at.
    Beside,
    /// From ahead, it comes closer.
    ClosingAhead,
    /// From behind, it comes closer.
    ClosingBehind,
    /// It falls back or drives off.
    Receding,
    /// The distance stays exactly the same.
    Steady,
}

/// The relative motion across the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AcrossMotion {
    /// It overlaps the ego across its heading; its motion is not looked at.
    Aligned,
    /// It comes closer from the left.
    ClosingLeft,
    /// It comes closer from the right.
    ClosingRight,
    /// It moves off to the left.
    RecedingLeft,
    /// It moves off to the right.
    RecedingRight,
    /// The distance stays exactly the same.
    Steady,
}

impl AlongMotion {
    pub(super) fn classify(along: Along, v_rel: f64) -> Self {
        let closing = match along {
            Along::Beside => return Self::Beside,
            Along::Front => (v_rel < 0.0).then_some(Self::ClosingAhead),
            Along::Behind => (v_rel > 0.0).then_some(Self::ClosingBehind),
        };
        let otherwise = if v_rel == 0.0 {
            Self::Steady
        } else {
            Self::Receding
        };
        closing.unwrap_or(otherwise)
    }

    /// In a few words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Beside => "alongside",
            Self::ClosingAhead => "closing in ahead",
            Self::ClosingBehind => "closing in behind",
            Self::Receding => "getting farther",
            Self::Steady => "steady",
        }
    }
}

impl AcrossMotion {
    pub(super) fn classify(across: Across, v_rel: f64) -> Self {
        let steady = v_rel == 0.0;
        match (across, v_rel < 0.0) {
            (Across::Aligned, _) => Self::Aligned,
            _ if steady => Self::Steady,
            (Across::Left, true) => Self::ClosingLeft,
            (Across::Left, false) => Self::RecedingLeft,
            (Across::Right, true) => Self::RecedingRight,
            (Across::Right, false) => Self::ClosingRight,
        }
    }

    /// In a few words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Aligned => "in line",
            Self::ClosingLeft => "closing in from the left",
            Self::ClosingRight => "closing in from the right",
            Self::RecedingLeft => "getting farther left",
            Self::RecedingRight => "getting farther right",
            Self::Steady => "steady",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_depends_on_the_side() {
        let along = |side, v| AlongMotion::classify(side, v);
        assert_eq!(along(Along::Front, -1.0), AlongMotion::ClosingAhead);
        assert_eq!(along(Along::Front, 1.0), AlongMotion::Receding);
        assert_eq!(along(Along::Behind, 1.0), AlongMotion::ClosingBehind);
        assert_eq!(along(Along::Behind, -1.0), AlongMotion::Receding);
        let across = |side, v| AcrossMotion::classify(side, v);
        assert_eq!(across(Across::Left, -1.0), AcrossMotion::ClosingLeft);
        assert_eq!(across(Across::Left, 1.0), AcrossMotion::RecedingLeft);
        assert_eq!(across(Across::Right, 1.0), AcrossMotion::ClosingRight);
        assert_eq!(across(Across::Right, -1.0), AcrossMotion::RecedingRight);
    }

    #[test]
    fn no_motion_is_steady_and_overlap_hides_it() {
        for zero in [0.0, -0.0] {
            assert_eq!(
                AlongMotion::classify(Along::Front, zero),
                AlongMotion::Steady
            );
            assert_eq!(
                AlongMotion::classify(Along::Behind, zero),
                AlongMotion::Steady
            );
            assert_eq!(
                AcrossMotion::classify(Across::Left, zero),
                AcrossMotion::Steady
            );
            assert_eq!(
                AcrossMotion::classify(Across::Right, zero),
                AcrossMotion::Steady
            );
        }
        for v in [-1.0, 0.0, 1.0] {
            assert_eq!(AlongMotion::classify(Along::Beside, v), AlongMotion::Beside);
            assert_eq!(
                AcrossMotion::classify(Across::Aligned, v),
                AcrossMotion::Aligned
            );
        }
    }
}
