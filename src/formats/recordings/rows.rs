//! Rows of a recording: the header of a table, the steps that rows lie on, and rows that say a thing twice.

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::plausibility::LATEST_STEP;

use super::Report;
use super::assembly::median;
use crate::commonroad::builder::SourceLocation;

/// A part of a step by which a time may be off it.
const OFF: f64 = 0.25;

/// So much is the rounding of written times, seconds.
const ROUNDING: f64 = 0.0101;

/// By how much a time may be off a step of this length by rounding, seconds.
fn rounding(time_step: f64) -> f64 {
    ROUNDING.min(time_step / 10.0)
}

/// Steps for each time, where some times are missing, at most.
const GAPS: f64 = 1.6;

/// No steps are shorter, seconds.
const SHORTEST: f64 = 1e-4;

/// The steps at which times lie.
pub struct Steps {
    /// The first time, seconds.
    pub start: f64,
    /// Seconds.
    pub time_step: f64,
    /// Of each time. Times that are not there are gaps.
    pub steps: Vec<i64>,
    /// Times that are farther from their step than they are rounded.
    off: usize,
    /// By how much the farthest one is, seconds.
    most: f64,
}

impl Steps {
    /// Of times in order, seconds.
    ///
    /// # Errors
    /// They are fewer than two, or do not lie on steps of the same length.
    pub fn from_times(times: &[f64]) -> Result<Self, String> {
        let [start, .., last] = times[..] else {
            let count = if times.is_empty() { "no" } else { "only one" };
            return Err(format!("{count} time step; at least 2 are needed"));
        };
        let between = times.windows(2).map(|pair| pair[1] - pair[0]);
        let between: Vec<f64> = between.collect();
        let least = between.iter().copied().fold(f64::MAX, f64::min);
        let median = median(between);
        if median < SHORTEST {
            return Err(format!("time steps of less than {} ms", SHORTEST * 1e3));
        }
        if (last - start) / median > LATEST_STEP as f64 / 2.0 {
            return Err(format!("time {last} s is implausible"));
        }
        // Where many times are missing, most can be two steps apart.
        let most = times.len() as f64 * GAPS;
        let shorter = || Self::of_length(times, least).ok();
        Self::of_length(times, median).or_else(|why| {
            let few = |found: &Self| found.steps.last().is_some_and(|last| (*last as f64) < most);
            shorter().filter(few).ok_or(why)
        })
    }

    /// Of steps that are about as long as `guess`, seconds.
    fn of_length(times: &[f64], guess: f64) -> Result<Self, String> {
        let (start, last) = match times[..] {
            [start, .., last] => (start, last),
            _ => (0.0, 0.0),
        };
        // Written times are rounded: what a step is shows the better the farther a time is from the first one. Those that
        // are off by more are no steps, and show nothing.
        let mut time_step = guess;
        for time in times {
            let count = ((time - start) / time_step).round();
            let off = (time - start - count * time_step).abs();
            if count > 0.0 && off <= rounding(time_step) {
                time_step = (time - start) / count;
            }
        }
        // Clocks count thousandths of a second, or tenths of them.
        let told = [1e3, 1e4].map(|parts| (time_step * parts).round() / parts);
        let count = (last - start) / time_step;
        let fits = |told: &f64| (told - time_step).abs() * count < rounding(time_step);
        time_step = told.into_iter().find(fits).unwrap_or(time_step);
        let mut found = Self {
            start,
            time_step,
            steps: Vec::with_capacity(times.len()),
            off: 0,
            most: 0.0,
        };
        for time in times {
            let at = (time - start) / time_step;
            let off = (at - at.round()).abs();
            let step = at.round() as i64;
            if off > OFF || found.steps.last().is_some_and(|before| *before >= step) {
                return Err(format!(
                    "time {time} s is no step: most times are {time_step} s apart, from {start} s; sample the recording at equal times"
                ));
            }
            if off * time_step > rounding(time_step) {
                found.off += 1;
                found.most = found.most.max(off * time_step);
            }
            found.steps.push(step);
        }
        Ok(found)
    }

    /// Says that times are off their steps, where some are.
    pub fn report_to(&self, report: &Report) {
        if self.off > 0 {
            report.at("").warn(format!(
                "{} times are up to {:.3} s off the steps of {} s; taken as at the nearest one",
                self.off, self.most, self.time_step
            ));
        }
    }
}

/// Sorts the rows of a road user by step and keeps the first one of each. How many others there were, and how far from
/// these, is said about `name`.
pub fn once<T>(
    report: &Report,
    name: impl FnOnce() -> String,
    rows: &mut Vec<T>,
    step: impl Fn(&T) -> i64,
    place: impl Fn(&T) -> Point,
) {
    if rows.windows(2).all(|pair| step(&pair[0]) < step(&pair[1])) {
        return;
    }
    rows.sort_by_key(|row| step(row));
    let (mut twice, mut most) = (0, 0.0_f64);
    rows.dedup_by(|row, first| {
        let same = step(row) == step(first);
        if same {
            twice += 1;
            most = most.max((place(row) - place(first)).norm());
        }
        same
    });
    if twice > 0 {
        report.at(name()).warn(format!(
            "{twice} rows are at a step that has one already, up to {most:.2} m from it; the first of each step is used, are these two road users?"
        ));
    }
}

/// What may stand between two fields.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// The separator of a table that begins with `head`, and the names of its columns. The separator is the one that makes
/// most columns.
pub fn columns_of(head: &[u8]) -> (u8, Vec<String>) {
    let line = head.split(|b| *b == b'\n').next().unwrap_or_default();
    let split = |separator: u8| {
        let mut table = csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .terminator(csv::Terminator::Any(b'\n'))
            .from_reader(line);
        let record = table.byte_records().next().and_then(Result::ok);
        (separator, record.unwrap_or_default())
    };
    // Of as many the first one.
    let all = SEPARATORS.map(split).into_iter().rev();
    let (separator, fields) = all
        .max_by_key(|(_, fields)| fields.len())
        .unwrap_or_default();
    let names: Vec<String> = fields
        .iter()
        .map(|field| name(&String::from_utf8_lossy(field)))
        .collect();
    match names[..] {
        [] => (separator, vec![String::new()]),
        _ => (separator, names),
    }
}

/// The name of a column without what surrounds it.
pub fn name(field: &str) -> String {
    bare(field).to_string()
}

/// The same as a part of the field.
pub fn bare(field: &str) -> &str {
    let plain = field.trim_start_matches('\u{feff}').trim();
    plain.trim_matches('"').trim()
}

/// A number. Where fields are separated by something else, it may have a decimal comma; whether it has one comes with it.
pub fn number(text: &str, separator: u8) -> Option<(f64, bool)> {
    let text = text.trim();
    if let Ok(value) = text.parse() {
        return Some((value, false));
    }
    let has_comma = separator != b',' && text.matches(',').count() == 1 && !text.contains('.');
    let with_point = has_comma.then(|| text.replace(',', "."))?;
    Some((with_point.parse().ok()?, true))
}

/// What is wrong with a row that has fields beyond the columns; nothing where these are empty.
pub fn too_long<'f>(fields: impl Iterator<Item = &'f [u8]>, columns: usize) -> Option<String> {
    let beyond = fields.skip(columns);
    let count = beyond
        .filter(|field| !field.trim_ascii().is_empty())
        .count();
    (count > 0).then(|| {
        format!(
            "{} fields for {columns} columns; a list of numbers or a number with a decimal comma has to be in quotes",
            columns + count
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    fn steps(times: &[f64]) -> Result<(f64, Vec<i64>, usize), String> {
        Steps::from_times(times).map(|found| (found.time_step, found.steps, found.off))
    }

    #[test]
    fn steps_are_found_in_rounded_times_and_gaps_stay() {
        assert_eq!(steps(&[5.0, 5.5, 7.0]).unwrap().1, [0, 1, 4]);
        let gaps = steps(&[0.0, 2.0, 3.0, 5.0, 6.0, 8.0]).unwrap();
        assert_eq!((gaps.0, gaps.1), (1.0, vec![0, 2, 3, 5, 6, 8]));
        // 0.125 s, written in hundredths.
        let rounded: Vec<f64> = (0..80)
            .map(|i| (f64::from(i) * 12.5).round() / 100.0)
            .collect();
        let (time_step, found, off) = steps(&rounded).unwrap();
        assert_eq!((time_step, off), (0.125, 0));
        assert!(found.iter().copied().eq(0..80));
        // Thirty times a second.
        let thirtieths: Vec<f64> = (0..9000)
            .map(|i| (f64::from(i) * 1e3 / 30.0).round() / 1e3)
            .collect();
        let (time_step, found, off) = steps(&thirtieths).unwrap();
        assert!(
            (time_step - 1.0 / 30.0).abs() < 1e-6 && off == 0,
            "{time_step}"
        );
        assert!(found.iter().copied().eq(0..9000));
    }

    #[test]
    fn times_that_are_no_steps_are_told() {
        let error = steps(&[0.0, 0.1, 0.2, 0.35, 0.4, 0.5]).unwrap_err();
        assert!(
            error.contains("time 0.35 s is no step") && error.contains("0.1 s apart"),
            "{error}"
        );
        assert!(steps(&[0.0, 1.0, 2.0, 2.1, 3.0]).is_err());
        assert_eq!(steps(&[0.0, 1.0, 2.15, 3.0]).unwrap().2, 1);
        assert!(steps(&[0.0]).unwrap_err().contains("at least 2"));
        assert!(steps(&[0.0, 1e-6]).unwrap_err().contains("less than"));
        assert!(
            steps(&[0.0, 0.1, 0.2, 1e8])
                .unwrap_err()
                .contains("implausible")
        );
    }

    #[test]
    fn rows_of_the_same_step_are_told_with_their_distance() {
        let point = |x| Point::new(x, 0.0);
        let mut rows = vec![(2, point(2.0)), (1, point(1.0)), (1, point(1001.0))];
        let report = Report::about("x");
        once(&report, || "track 7".into(), &mut rows, |r| r.0, |r| r.1);
        assert_eq!(rows, [(1, point(1.0)), (2, point(2.0))]);
        let said = report.into_diagnostics();
        assert_eq!((said.len(), &*said[0].element), (1, "track 7"));
        assert!(
            said[0]
                .message
                .starts_with("1 rows are at a step that has one already, up to 1000.00 m")
        );
    }

    #[test]
    fn the_separator_is_the_one_that_makes_most_columns() {
        let header = |text: &str| {
            let (separator, names) = columns_of(text.as_bytes());
            (char::from(separator), names.join("|"))
        };
        assert_eq!(header("a,b\n1;2;3"), (',', "a|b".into()));
        assert_eq!(
            header("\u{feff}a; \"b, c\" ;d\r\n"),
            (';', "a|b, c|d".into())
        );
        assert_eq!(
            header("\u{feff}\"t\",\"x,m\",\"y;z\"\r\n"),
            (',', "t|x,m|y;z".into())
        );
        assert_eq!(header("a\tb"), ('\t', "a|b".into()));
        assert_eq!(header("words"), (',', "words".into()));
        assert_eq!(header(""), (',', String::new()));
    }

    #[test]
    fn commas_are_decimal_where_they_separate_nothing() {
        assert_eq!(number(" 1.5", b','), Some((1.5, false)));
        assert_eq!(number("1,5", b';'), Some((1.5, true)));
        assert_eq!(number("1,5", b','), None);
        for odd in ["1.000,5", "1,2,3", "a,b", ""] {
            assert_eq!(number(odd, b';'), None, "{odd}");
        }
        let fields = |text: &'static str| text.split(';').map(str::as_bytes);
        assert_eq!(too_long(fields("1;2;"), 2), None);
        assert!(
            too_long(fields("1;2;3"), 2).is_some_and(|said| said.starts_with("3 fields for 2"))
        );
    }
}
