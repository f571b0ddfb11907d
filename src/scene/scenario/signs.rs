//! What lights show at a step, where they and stop lines are, and what signs mean.

use super::{Lanelet, LaneletNetwork, Sign, SignElement, SignalColor, TrafficLight};
use nearmiss_base::geometry::Point;

impl TrafficLight {
    /// The colour that it shows at a time step: its phases one after the other, for ever, before the offset too.
    #[must_use]
    pub fn color_at(&self, step: i64) -> SignalColor {
        let lasts = |duration: i64| i128::from(duration.max(0));
        let whole: i128 = self.cycle.iter().map(|p| lasts(p.duration)).sum();
        if !self.active || whole == 0 {
            return SignalColor::Inactive;
        }
        let mut left = (i128::from(step) - i128::from(self.offset)).rem_euclid(whole);
        for phase in &self.cycle {
            left -= lasts(phase.duration);
            if left < 0 {
                return phase.color;
            }
        }
        SignalColor::Inactive
    }
}

impl Lanelet {
    /// The ends of its stop line; one without points lies across the end of the lanelet.
    #[must_use]
    pub fn stop_line_ends(&self) -> Option<(Point, Point)> {
        let line = self.stop_line.as_ref()?;
        line.points
            .or_else(|| Some((*self.left.points.last()?, *self.right.points.last()?)))
    }
}

impl LaneletNetwork {
    /// Where a light stands; one without a position stands at the end of the first lanelet that it holds on.
    #[must_use]
    pub fn position_of(&self, light: &TrafficLight) -> Option<Point> {
        light.position.or_else(|| {
            let refers = |l: &&Lanelet| l.lights.contains(&light.id);
            let lanelet = self.lanelets.iter().find(refers)?;
            lanelet.right.points.last().copied()
        })
    }
}

/// What a sign tells a driver, as far as a map can show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SignMeaning {
    /// No faster than this, m/s.
    SpeedLimit(f64),
    /// At least this fast, m/s.
    LeastSpeed(f64),
    /// Anything else, in a few words.
    Words(&'static str),
}

/// Words for the signs of Germany (by number) and of some others that files hold.
const WORDS: &[(&str, &str)] = &[
    ("101", "danger"),
    ("102", "right before left"),
    ("131", "lights ahead"),
    ("138", "cyclists"),
    ("201", "railway crossing"),
    ("205", "yield"),
    ("206", "stop"),
    ("208", "yield to oncoming"),
    ("209", "mandatory direction"),
    ("211", "turn here"),
    ("215", "roundabout"),
    ("220", "one way"),
    ("222", "pass here"),
    ("224", "bus stop"),
    ("237", "bicycles"),
    ("239", "pedestrians"),
    ("240", "foot and bicycle path"),
    ("242.1", "pedestrian zone"),
    ("244.1", "bicycle street"),
    ("245", "bus lane"),
    ("250", "no vehicles"),
    ("251", "no cars"),
    ("253", "no trucks"),
    ("254", "no bicycles"),
    ("259", "no pedestrians"),
    ("260", "no motor vehicles"),
    ("267", "no entry"),
    ("276", "no overtaking"),
    ("277", "no overtaking by trucks"),
    ("278", "end of limit"),
    ("280", "end of no overtaking"),
    ("282", "end of all limits"),
    ("283", "no stopping"),
    ("286", "no parking"),
    ("301", "right of way"),
    ("306", "priority road"),
    ("308", "priority over oncoming"),
    ("310", "town"),
    ("311", "end of town"),
    ("314", "parking"),
    ("325.1", "living street"),
    ("325.2", "end of living street"),
    ("330.1", "motorway"),
    ("330.2", "end of motorway"),
    ("331.1", "motor road"),
    ("331.2", "end of motor road"),
    ("350", "crossing"),
    ("357", "dead end"),
    ("R1-1", "stop"),
    ("R1-2", "yield"),
    ("R5-1", "no entry"),
    ("R6-1L", "one way"),
    ("R6-1R", "one way"),
    ("r1", "yield"),
    ("r2", "stop"),
];

/// Signs whose value is the highest speed, of any country.
const LIMITS: &[&str] = &["274", "274.1", "R2-1", "r301", "C43", "B14", "3.24"];

impl SignElement {
    /// What it means; `None` if its number is not known here.
    #[must_use]
    pub fn meaning(&self) -> Option<SignMeaning> {
        let speed = || self.values.iter().find_map(|v| v.trim().parse().ok());
        let speed = || speed().filter(|v: &f64| v.is_finite() && *v >= 0.0);
        if LIMITS.contains(&self.id.as_str()) {
            return Some(match speed() {
                Some(limit) => SignMeaning::SpeedLimit(limit),
                None => SignMeaning::Words("speed limit"),
            });
        }
        if self.id == "275" {
            return Some(match speed() {
                Some(least) => SignMeaning::LeastSpeed(least),
                None => SignMeaning::Words("minimum speed"),
            });
        }
        let words = |id: &str| WORDS.iter().find(|(known, _)| *known == id);
        // `283-10` is a variant of 283.
        let variant = self.id.split('-').next().unwrap_or_default();
        let found = words(&self.id).or_else(|| words(variant))?;
        Some(SignMeaning::Words(found.1))
    }
}

impl Sign {
    /// Whether its speeds are told in miles an hour where it stands.
    fn in_miles(&self) -> bool {
        let american = |e: &SignElement| e.id.starts_with('R') && e.id.contains('-');
        self.elements.iter().any(american)
    }

    /// A speed (m/s) as the sign tells it, with its unit.
    #[must_use]
    pub fn speed_shown(&self, speed: f64) -> (f64, &'static str) {
        if self.in_miles() {
            (speed * 2.236_936, "mph")
        } else {
            (speed * 3.6, "km/h")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::LightPhase;
    use super::*;

    fn light(offset: i64, phases: &[(i64, SignalColor)]) -> TrafficLight {
        TrafficLight {
            id: 1,
            cycle: phases
                .iter()
                .map(|&(duration, color)| LightPhase { duration, color })
                .collect(),
            offset,
            position: None,
            direction: None,
            active: true,
        }
    }

    #[test]
    fn phases_follow_each_other_for_ever_and_began_before_the_offset() {
        use SignalColor::*;
        // 10 red and yellow, 150 green, 30 yellow, 170 red: 360 steps, and the first phase begins at step 320.
        let phases = [(10, RedYellow), (150, Green), (30, Yellow), (170, Red)];
        let light = light(320, &phases);
        // Step 0 is 40 steps into the cycle before.
        let expected = [
            (-40, RedYellow),
            (-31, RedYellow),
            (-30, Green),
            (0, Green),
            (119, Green),
            (120, Yellow),
            (149, Yellow),
            (150, Red),
            (319, Red),
            (320, RedYellow),
            (330, Green),
            (680, RedYellow),
        ];
        for (step, color) in expected {
            assert_eq!(light.color_at(step), color, "step {step}");
        }
    }

    #[test]
    fn what_is_off_or_has_no_phases_shows_nothing() {
        let mut off = light(0, &[(5, SignalColor::Red)]);
        assert_eq!(off.color_at(3), SignalColor::Red);
        off.active = false;
        assert_eq!(off.color_at(3), SignalColor::Inactive);
        assert_eq!(light(0, &[]).color_at(3), SignalColor::Inactive);
        let odd = [(0, SignalColor::Red), (-4, SignalColor::Yellow)];
        assert_eq!(light(0, &odd).color_at(3), SignalColor::Inactive);
        let long = [(i64::MAX, SignalColor::Red), (i64::MAX, SignalColor::Green)];
        // 2⁶⁴ − 1 steps into a cycle of 2⁶⁴ − 2.
        let late = light(i64::MIN, &long).color_at(i64::MAX);
        assert_eq!(late, SignalColor::Red);
    }

    #[test]
    fn signs_are_read_by_their_numbers() {
        let element = |id: &str, value: &str| SignElement {
            id: id.into(),
            values: vec![value.into()],
        };
        assert_eq!(
            element("274", " 13.888888").meaning(),
            Some(SignMeaning::SpeedLimit(13.888_888))
        );
        assert_eq!(
            element("274", "NaN").meaning(),
            Some(SignMeaning::Words("speed limit"))
        );
        assert_eq!(
            element("283-10", "").meaning(),
            Some(SignMeaning::Words("no stopping"))
        );
        assert_eq!(element("no such", "").meaning(), None);
    }
}
