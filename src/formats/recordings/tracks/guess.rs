//! What a table does not say of its units and conventions, from how its numbers agree with each other.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nearmiss_base::geometry::{Vector, angle_between, normalize_angle};

use super::columns::FOOT;

/// Two rows of a track that follow each other.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// The place of their track.
    pub track: usize,
    /// Between them, as in the table.
    pub time: f64,
    /// As in the table.
    pub moved: Vector,
    /// At the first and the second, as in the table; NaN where there is none.
    pub heading: (f64, f64),
    /// At the second, as in the table; NaN where there is none.
    pub speed: f64,
    /// Of the body, as in the table; NaN where there is none.
    pub length: f64,
}

/// Fewer pairs tell nothing.
const FEWEST: usize = 12;

/// How whole numbers of time are to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeUnit {
    /// One is so many seconds.
    Seconds(f64),
    /// It counts pictures.
    Frames,
}

/// In which unit times are that are mostly `between` apart; `are_whole` where all are whole numbers.
pub fn time_unit(between: f64, are_whole: bool) -> TimeUnit {
    match between {
        _ if !are_whole => TimeUnit::Seconds(1.0),
        ns if ns >= 2e6 => TimeUnit::Seconds(1e-9),
        us if us >= 2e3 => TimeUnit::Seconds(1e-6),
        ms if ms >= 4.0 => TimeUnit::Seconds(1e-3),
        _ => TimeUnit::Frames,
    }
}

/// The middle one of some values; nothing of few.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|v| v.is_finite());
    (values.len() >= FEWEST).then(|| crate::recordings::assembly::median(values))
}

/// How many units of time pass a second, as speeds in m/s and moves in metres tell it.
pub fn rate(pairs: &[Pair]) -> Option<f64> {
    let each = pairs
        .iter()
        .filter(|p| p.speed.abs() > 1.0 && p.moved.norm() > 1e-3);
    let rates: Vec<f64> = each
        .map(|p| p.speed.abs() / (p.moved.norm() / p.time))
        .collect();
    let rate = median(rates)?;
    // Rates are whole numbers.
    let whole = rate.round();
    (whole >= 1.0 && (rate / whole - 1.0).abs() < 0.03).then_some(whole)
}

/// Whether sizes of vehicles are in feet: length and width, as in the table.
pub fn are_feet(sizes: &[(f64, f64)]) -> bool {
    let of = |pick: fn(&(f64, f64)) -> f64| {
        let mut all: Vec<f64> = sizes.iter().map(pick).filter(|v| *v > 0.0).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or_default()
    };
    // A car is 1.8 m or 6 ft wide and 4.5 m or 15 ft long.
    (4.5..=9.0).contains(&of(|size| size.1)) && (10.0..=40.0).contains(&of(|size| size.0))
}

/// Units of speeds: their names, and what one is in m/s.
const SPEEDS: [(&str, f64); 4] = [
    ("m/s", 1.0),
    ("km/h", 1.0 / 3.6),
    ("mph", 0.447_04),
    ("ft/s", FOOT),
];

/// Speeds fit moves that are off by a smaller part.
const FITTING: f64 = 0.1;

/// What speeds say of their unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpeedUnit {
    /// Too little moves to tell.
    Unknown,
    /// Name, and one in m/s.
    Known(&'static str, f64),
    /// In no unit do speeds fit the moves; the middle ratio of both.
    Odd(f64),
}

/// The unit of speeds; moves are in metres and times in seconds. Where lengths were `in_feet`, speeds are where they can be.
pub fn speed_unit(pairs: &[Pair], in_feet: bool) -> SpeedUnit {
    let each = pairs.iter().filter(|p| p.moved.norm() / p.time > 1.0);
    let ratios: Vec<f64> = each
        .map(|p| p.speed.abs() / (p.moved.norm() / p.time))
        .collect();
    let Some(ratio) = median(ratios) else {
        return SpeedUnit::Unknown;
    };
    let off = |(name, one): &(&'static str, f64)| {
        let off = (ratio * one - 1.0).abs();
        let is_best = in_feet && *one == FOOT && off < FITTING;
        (if is_best { 0.0 } else { off }, *name, *one)
    };
    let best = SPEEDS.iter().map(off).min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((off, name, one)) if off < FITTING => SpeedUnit::Known(name, one),
        _ => SpeedUnit::Odd(ratio),
    }
}

/// A part by which the speeds of one track may differ from those of the table.
const SAME_UNIT: f64 = 0.2;

/// The unit of a track's speeds where it is another than that of the table, of which one is `factor` m/s, and how many
/// times the motion they are.
pub fn other_speed_unit(pairs: &[Pair], factor: f64) -> Option<(&'static str, f64)> {
    match speed_unit(pairs, false) {
        SpeedUnit::Known(name, own) if (factor / own - 1.0).abs() > SAME_UNIT => {
            Some((name, factor / own))
        }
        _ => None,
    }
}

/// By how much the headings of a track are off its motion, radians, where they fit it in the other unit.
pub fn other_angle_unit(pairs: &[Pair], form: HeadingForm) -> Option<f64> {
    let other = HeadingForm {
        degrees: !form.degrees,
        ..form
    };
    let off = heading_off(pairs, form).filter(|off| *off > ODD_HEADING)?;
    (heading_off(pairs, other)? < ODD_HEADING).then_some(off)
}

/// Headings farther off the motion on average are told, radians.
pub const ODD_HEADING: f64 = 0.35;

/// How headings are written.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HeadingForm {
    /// Degrees rather than radians.
    pub degrees: bool,
    /// Clockwise from north rather than counterclockwise from the x-axis.
    pub from_north: bool,
    /// They turn the other way than the places: y grows downwards.
    pub mirrored: bool,
}

impl HeadingForm {
    /// A heading, radians counterclockwise from the x-axis; that of a mirrored one is for a y that grows upwards.
    pub fn radians(self, written: f64) -> f64 {
        let radians = if self.degrees {
            written.to_radians()
        } else {
            written
        };
        normalize_angle(if self.from_north {
            FRAC_PI_2 - radians
        } else {
            radians
        })
    }
}

/// By how much headings that are written so are off the moves on average, radians; nothing where too little moves.
pub fn heading_off(pairs: &[Pair], form: HeadingForm) -> Option<f64> {
    let moving = pairs
        .iter()
        .filter(|p| p.moved.norm() / p.time > 1.0 && p.heading.1.is_finite());
    let off = moving.map(|p| {
        let y = if form.mirrored { -p.moved.y } else { p.moved.y };
        angle_between(form.radians(p.heading.1), y.atan2(p.moved.x)).abs()
    });
    let (sum, count) = off.fold((0.0, 0), |(sum, count), off| (sum + off, count + 1));
    (count >= FEWEST).then(|| sum / count as f64)
}

/// Whether headings are so large that they may be degrees; few are mistakes.
fn are_large(pairs: &[Pair]) -> bool {
    let all = pairs.iter().map(|p| p.heading.1).filter(|h| h.is_finite());
    let (count, large) = all.fold((0, 0), |(count, large), heading| {
        (count + 1, large + usize::from(heading.abs() > TAU + 0.1))
    });
    large > 0 && large * FEW >= count
}

/// One of so many is few.
const FEW: usize = 10;

/// How headings are written: as they agree best with the moves, and by how much they do, radians. What is known already
/// is kept. Where too little moves, degrees are told by their size.
pub fn heading_form(
    pairs: &[Pair],
    degrees: Option<bool>,
    from_north: Option<bool>,
) -> (HeadingForm, Option<f64>) {
    let usual = HeadingForm {
        degrees: degrees.unwrap_or_else(|| are_large(pairs)),
        from_north: from_north.unwrap_or(false),
        mirrored: false,
    };
    if heading_off(pairs, usual).is_none() {
        return (usual, None);
    }
    let choices = |known: Option<bool>, usual: bool| match known {
        Some(known) => vec![known],
        None => vec![usual, !usual],
    };
    let mut best = (usual, f64::MAX);
    for mirrored in [false, true] {
        // Radians may be large, too: of a road user that turned and turned.
        for degrees in choices(degrees, usual.degrees) {
            for from_north in choices(from_north, false) {
                let form = HeadingForm {
                    degrees,
                    from_north,
                    mirrored,
                };
                let off = heading_off(pairs, form).unwrap_or(f64::MAX);
                // The more usual one where both fit: all drive along the x-axis, say.
                if off < best.1 - 0.02 {
                    best = (form, off);
                }
            }
        }
    }
    (best.0, Some(best.1))
}

/// Whether places are those of the front rather than of the middle. In a turn the place moves at an angle to the heading
/// that grows with its distance from the rear axle: `tan β = d·ω/v`. Headings are radians, times seconds, moves metres.
pub fn is_front(pairs: &[Pair]) -> bool {
    let each = pairs.iter().filter_map(|p| {
        let turn = angle_between(p.heading.0, p.heading.1);
        let (speed, rate) = (p.moved.norm() / p.time, turn / p.time);
        let middle = p.heading.0 + turn / 2.0;
        let slip = angle_between(middle, p.moved.y.atan2(p.moved.x));
        let turns = rate.abs() > 0.1 && speed > 2.0 && slip.abs() < PI / 4.0 && p.length > 1.0;
        turns.then(|| slip.tan() * speed / rate / p.length)
    });
    // Of a car the middle is 0.3 of its length before the rear axle, the front 0.8.
    median(each.collect()).is_some_and(|part| (0.62..1.1).contains(&part))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive around a circle of radius 20 m at 10 m/s whose heading is written by `write`; the place is `ahead` metres
    /// before the rear axle.
    fn circle(write: impl Fn(f64) -> f64, ahead: f64) -> Vec<Pair> {
        let at = |i: i32| {
            let angle = f64::from(i) * 0.05;
            let axle = Vector::new(20.0 * angle.sin(), -20.0 * angle.cos());
            (axle + Vector::new(angle.cos(), angle.sin()) * ahead, angle)
        };
        let pairs = (0..120).map(|i| {
            let ((a, before), (b, after)) = (at(i), at(i + 1));
            Pair {
                track: 0,
                time: 0.1,
                moved: b - a,
                heading: (write(before), write(after)),
                speed: 10.0,
                length: 4.6,
            }
        });
        pairs.collect()
    }

    #[test]
    fn times_are_told_by_how_far_they_are_apart() {
        for (between, unit) in [
            (1e8, TimeUnit::Seconds(1e-9)),
            (4e4, TimeUnit::Seconds(1e-6)),
            (100.0, TimeUnit::Seconds(1e-3)),
            (1.0, TimeUnit::Frames),
        ] {
            assert_eq!(time_unit(between, true), unit);
        }
        assert_eq!(time_unit(0.04, false), TimeUnit::Seconds(1.0));
    }

    #[test]
    fn headings_are_read_as_they_agree_with_the_moves() {
        let form = |pairs: &[Pair]| heading_form(pairs, None, None);
        let said = |degrees, from_north, mirrored| HeadingForm {
            degrees,
            from_north,
            mirrored,
        };
        assert_eq!(form(&circle(|h| h, 1.3)).0, said(false, false, false));
        assert_eq!(
            form(&circle(f64::to_degrees, 1.3)).0,
            said(true, false, false)
        );
        let compass = circle(|h| (90.0 - h.to_degrees()).rem_euclid(360.0), 1.3);
        let (found, off) = form(&compass);
        assert_eq!(found, said(true, true, false));
        assert!(off.is_some_and(|off| off < 0.1));
        // Headings that turn against the places: y grows downwards.
        let down = circle(|h| -h, 1.3);
        assert_eq!(form(&down).0, said(false, false, true));
        assert!((compass[7].heading.1.to_radians() - (FRAC_PI_2 - 0.4)).abs() < 1e-9);
        assert!((found.radians(compass[7].heading.1) - 0.4).abs() < 1e-9);
        assert_eq!(form(&compass[..3]).1, None);
        // Radians that go on beyond a turn.
        assert_eq!(
            form(&circle(|h| h + 2.0 * TAU, 1.3)).0,
            said(false, false, false)
        );
        let stands = |heading: f64| Pair {
            moved: Vector::new(0.0, 0.0),
            heading: (heading, heading),
            ..compass[0]
        };
        let mut one: Vec<Pair> = (0..40).map(|_| stands(1.6)).collect();
        one.push(stands(31.4));
        assert_eq!(form(&one), (HeadingForm::default(), None));
        assert!(form(&[stands(90.0)]).0.degrees);
    }

    #[test]
    fn speeds_sizes_and_rates_have_units() {
        let with = |speed: f64, time: f64| -> Vec<Pair> {
            let of = |p: Pair| Pair { speed, time, ..p };
            circle(|h| h, 0.0).into_iter().map(of).collect()
        };
        assert_eq!(
            speed_unit(&with(10.0, 0.1), false),
            SpeedUnit::Known("m/s", 1.0)
        );
        assert_eq!(
            speed_unit(&with(36.0, 0.1), false),
            SpeedUnit::Known("km/h", 1.0 / 3.6)
        );
        assert!(matches!(
            speed_unit(&with(5.0, 0.1), false),
            SpeedUnit::Odd(_)
        ));
        assert_eq!(speed_unit(&[], false), SpeedUnit::Unknown);
        assert_eq!(rate(&with(10.0, 1.0)), Some(10.0));
        assert_eq!(rate(&with(25.0, 1.0)), Some(25.0));
        assert!(are_feet(&[(14.5, 6.0), (40.0, 8.0), (15.0, 6.1)]));
        assert!(!are_feet(&[(4.5, 1.8), (12.0, 2.5)]) && !are_feet(&[]));
    }

    #[test]
    fn the_front_is_told_by_how_it_moves_in_a_turn() {
        assert!(is_front(&circle(|h| h, 3.7)));
        assert!(!is_front(&circle(|h| h, 1.3)));
        assert!(!is_front(&circle(|h| h, 0.0)));
    }
}
