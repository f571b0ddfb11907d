//! The risk score of `risk_scores_*.csv`, 0 (collision) to 5 (negligible), and the cases of the motion behind it.

use super::{Across, Along, Relation};

/// Largest gaps below which the scores 0, 1, … are given, metres: those of the published code, not of its prompt.
const DISTANCES: [f64; 5] = [0.3, 0.8, 1.3, 3.0, 5.0];

/// The same for times, seconds; the first is excluded, the others are included.
const TIMES: [f64; 5] = [0.15, 0.65, 1.15, 3.0, 5.0];

/// The grades of one obstacle at one step, and what becomes of them. The fields are named like the published columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Risk {
    /// Weight of the longitudinal grades, 0 to 1; the lateral ones have the rest.
    pub wdominant: f64,
    /// Grade of the longitudinal gap.
    pub long_dsc: u8,
    /// Grade of the lateral gap.
    pub lat_dsc: u8,
    /// Weighted grade of the gaps.
    pub dsc: f64,
    /// Grade of the longitudinal time.
    pub long_tsc: u8,
    /// Grade of the lateral time.
    pub lat_tsc: u8,
    /// Weighted grade of the times.
    pub tsc: f64,
    /// Half the sum of both, without its fraction.
    pub risk_score: u8,
}

impl Risk {
    /// The score of a relation; the published ones are those of rounded relations.
    #[must_use]
    pub fn score(relation: &Relation) -> Self {
        let wdominant = relation.direction.longitudinal_weight();
        let weighted =
            |long: u8, lat: u8| wdominant * f64::from(long) + (1.0 - wdominant) * f64::from(lat);
        let long_dsc = of_distance(relation.adjusted_d_long);
        let lat_dsc = of_distance(relation.adjusted_d_lat);
        let long_tsc = of_time(relation.ttc_long);
        let lat_tsc = of_time(relation.ttc_lat);
        let dsc = weighted(long_dsc, lat_dsc);
        let tsc = weighted(long_tsc, lat_tsc);
        Self {
            wdominant,
            long_dsc,
            lat_dsc,
            dsc,
            long_tsc,
            lat_tsc,
            tsc,
            risk_score: f64::midpoint(dsc, tsc) as u8,
        }
    }
}

fn of_distance(gap: f64) -> u8 {
    DISTANCES.iter().filter(|d| gap.abs() >= **d).count() as u8
}

fn of_time(time: Option<f64>) -> u8 {
    let Some(time) = time else { return 5 };
    let [first, others @ ..] = TIMES;
    u8::from(time >= first) + others.iter().filter(|t| time > **t).count() as u8
}

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
    pub fn text(self) -> &'static str {
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
    pub fn text(self) -> &'static str {
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
    use super::super::{AcrossMotion, AlongMotion, Direction};
    use super::*;

    #[test]
    fn a_gap_at_a_threshold_is_above_it() {
        let grades = |values: [f64; 6]| values.map(of_distance);
        assert_eq!(
            grades([0.0, 0.3, 0.8, 1.3, 3.0, 5.0]),
            [0, 1, 2, 3, 4, 5],
            "at the thresholds"
        );
        assert_eq!(
            grades([-0.29, -0.79, -1.29, -2.99, -4.99, -500.0]),
            [0, 1, 2, 3, 4, 5],
            "below them, on the other side"
        );
    }

    #[test]
    fn a_time_at_a_threshold_is_below_it_but_for_the_first() {
        let grades = |values: [f64; 6]| values.map(|t| of_time(Some(t)));
        assert_eq!(
            grades([0.14, 0.15, 1.15, 3.0, 5.0, 5.01]),
            [0, 1, 2, 3, 4, 5]
        );
        assert_eq!(of_time(Some(0.65)), 1);
        assert_eq!(of_time(Some(0.66)), 2);
        assert_eq!(of_time(None), 5);
    }

    fn relation(d_long: f64, d_lat: f64, adjusted: [f64; 2], ttc: [Option<f64>; 2]) -> Relation {
        let direction = Direction::from_offsets(d_long, d_lat);
        Relation {
            direction,
            d_long,
            d_lat,
            adjusted_d_long: adjusted[0],
            adjusted_d_lat: adjusted[1],
            v_rel_long: 0.0,
            v_rel_lat: 0.0,
            a_rel_long: 0.0,
            a_rel_lat: 0.0,
            ttc_long: ttc[0],
            ttc_lat: ttc[1],
            motion_long: AlongMotion::classify(direction.along, 0.0),
            motion_lat: AcrossMotion::classify(direction.across, 0.0),
        }
    }

    #[test]
    fn the_weight_follows_the_direction_and_fractions_are_cut() {
        // Diagonal: (5 + 0) / 2 = 2.5 and (5 + 1) / 2 = 3, so 2.75.
        let risk = Risk::score(&relation(-12.11, 1.84, [-7.6, 0.23], [None, Some(0.18)]));
        assert_eq!((risk.wdominant, risk.dsc, risk.tsc), (0.5, 2.5, 3.0));
        assert_eq!(risk.risk_score, 2);
        let ahead = Risk::score(&relation(5.0, 0.0, [0.49, 0.0], [Some(0.5), Some(0.0)]));
        assert_eq!((ahead.wdominant, ahead.dsc, ahead.tsc), (1.0, 1.0, 1.0));
        assert_eq!(ahead.risk_score, 1);
        // The same behind is taken for a diagonal.
        let behind = Risk::score(&relation(-5.0, 0.0, [-0.49, 0.0], [Some(0.5), Some(0.0)]));
        assert_eq!((behind.wdominant, behind.dsc, behind.tsc), (0.5, 0.5, 0.5));
        assert_eq!(behind.risk_score, 0);
        let beside = Risk::score(&relation(1.0, 4.0, [0.0, 2.39], [Some(0.0), None]));
        assert_eq!((beside.wdominant, beside.dsc, beside.tsc), (0.0, 3.0, 5.0));
        assert_eq!(beside.risk_score, 4);
        let inside = Risk::score(&relation(1.0, 1.0, [0.0, 0.0], [Some(0.0), Some(0.0)]));
        assert_eq!((inside.wdominant, inside.risk_score), (0.5, 0));
    }

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
