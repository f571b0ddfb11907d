//! What is odd about the tracks of a table: rows said twice, gaps, jumps, names that change bodies.

use nearmiss_base::geometry::Point;

use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;

/// A row of a track.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Its step.
    pub step: i64,
    /// Its line in the file.
    pub line: u32,
    /// Where it is, metres.
    pub place: Point,
}

/// No road user is faster, m/s.
const FASTEST: f64 = 100.0;

/// Places may be off by this much, metres.
const NOISE: f64 = 1.0;

/// Names have changed bodies where each is as near to where the other would be, metres.
const NEAR: f64 = 3.0;

/// So many of a kind are told each.
const MAX_LISTED: usize = 5;

/// Says what is odd; `tracks` are names and rows in order of steps, `dt` seconds apart.
pub fn check(report: &Report, tracks: &[(String, Vec<Seen>)], dt: f64) {
    jumps(report, tracks, dt);
    let mut gaps = Told::new(report, "gaps");
    let mut alone = Told::new(report, "tracks of one row");
    for (name, rows) in tracks {
        if let [only] = rows[..] {
            alone.tell(only.line, name, || {
                "one row only; taken as standing there for that step".into()
            });
        }
        let each = rows
            .windows(2)
            .filter(|pair| pair[1].step - pair[0].step > 1);
        let longest = each.clone().max_by_key(|pair| pair[1].step - pair[0].step);
        if let Some(pair) = longest {
            let seconds = (pair[1].step - pair[0].step) as f64 * dt;
            gaps.tell(pair[1].line, name, || {
                let gaps = match each.count() {
                    1 => "a gap".to_string(),
                    count => format!("{count} gaps, the longest"),
                };
                format!("{gaps} of {seconds:.2} s before this line; it is not there meanwhile")
            });
        }
    }
    gaps.finish();
    alone.finish();
}

/// A place at which a track is too far from where it was.
struct Jump<'t> {
    name: &'t str,
    after: Seen,
    /// Where it would be.
    expected: Point,
    metres: f64,
}

fn jumps(report: &Report, tracks: &[(String, Vec<Seen>)], dt: f64) {
    let mut found: Vec<Jump<'_>> = Vec::new();
    for (name, rows) in tracks {
        let mut before: Option<(Seen, Seen)> = None;
        for pair in rows.windows(2) {
            let steps = (pair[1].step - pair[0].step) as f64;
            let moved = pair[1].place - pair[0].place;
            // What it would do at the speed that it had.
            let drift = before.map_or_else(Default::default, |(a, b)| {
                (b.place - a.place) / (b.step - a.step) as f64 * steps
            });
            let metres = moved.norm();
            if metres > FASTEST * steps * dt + NOISE
                || before.is_some() && (moved - drift).norm() > limit(steps * dt)
            {
                found.push(Jump {
                    name,
                    after: pair[1],
                    expected: pair[0].place + drift,
                    metres: (moved - drift).norm(),
                });
                before = None;
            } else {
                before = Some((pair[0], pair[1]));
            }
        }
    }
    let mut crossed = Told::new(report, "names that change bodies");
    let mut alone = Told::new(report, "jumps");
    found.sort_by_key(|jump| jump.after.step);
    let mut done = vec![false; found.len()];
    for (i, jump) in found.iter().enumerate() {
        if done[i] {
            continue;
        }
        let same = |other: &Jump<'_>| {
            other.after.step == jump.after.step
                && (other.after.place - jump.expected).norm() < NEAR
                && (jump.after.place - other.expected).norm() < NEAR
        };
        let later = (i + 1..found.len()).take_while(|j| found[*j].after.step == jump.after.step);
        match later.into_iter().find(|j| !done[*j] && same(&found[*j])) {
            Some(j) => {
                done[j] = true;
                let (other, line) = (found[j].name, found[j].after.line);
                crossed.tell(jump.after.line, jump.name, || {
                    format!("from here on it is where `{other}` would be, and that (line {line}) where this one would be: were their ids swapped?")
                });
            }
            None => alone.tell(jump.after.line, jump.name, || {
                format!(
                    "jumps by {:.1} m; is it another road user from here on?",
                    jump.metres
                )
            }),
        }
    }
    crossed.finish();
    alone.finish();
}

/// By how much a body can be off where its speed would bring it: twice what the hardest braking does, and noise.
fn limit(seconds: f64) -> f64 {
    12.0 * seconds * seconds + 2.0 * NOISE
}

/// Tells the first findings of a kind, and how many there are more.
pub(super) struct Told<'r> {
    report: &'r Report,
    what: &'static str,
    count: usize,
}

impl<'r> Told<'r> {
    pub(super) fn new(report: &'r Report, what: &'static str) -> Self {
        Self {
            report,
            what,
            count: 0,
        }
    }

    pub(super) fn tell(&mut self, line: u32, track: &str, message: impl FnOnce() -> String) {
        self.count += 1;
        if self.count <= MAX_LISTED {
            let at = self.report.row(line as usize, format!("track `{track}`"));
            at.warn(message());
        }
    }

    pub(super) fn finish(self) {
        if self.count > MAX_LISTED {
            let more = self.count - MAX_LISTED;
            self.report
                .at("")
                .warn(format!("{}: {more} more like these", self.what));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(name: &str, first_line: u32, places: &[(i64, f64, f64)]) -> (String, Vec<Seen>) {
        let rows = places.iter().zip(first_line..);
        let seen = rows.map(|((step, x, y), line)| Seen {
            step: *step,
            line,
            place: Point::new(*x, *y),
        });
        (name.to_string(), seen.collect())
    }

    fn said(tracks: &[(String, Vec<Seen>)]) -> Vec<String> {
        let report = Report::about("x.csv");
        check(&report, tracks, 0.1);
        let all = report.into_diagnostics().into_iter();
        all.map(|d| format!("{} {} {}", d.line, d.element, d.message))
            .collect()
    }

    #[test]
    fn gaps_jumps_and_lone_rows_have_their_lines() {
        let all = said(&[
            track("a", 2, &[(0, 0.0, 0.0), (1, 1.0, 0.0), (5, 5.0, 0.0)]),
            track(
                "b",
                10,
                &[(0, 0.0, 5.0), (1, 1.0, 5.0), (2, 60.0, 5.0), (3, 61.0, 5.0)],
            ),
            track("c", 20, &[(0, 0.0, 9.0)]),
        ]);
        assert_eq!(all.len(), 3, "{all:?}");
        assert!(
            all[0].starts_with("12 track `b` jumps by 58.0 m"),
            "{all:?}"
        );
        assert!(all[1].starts_with("4 track `a` a gap of 0.40 s before"));
        assert!(all[2].starts_with("20 track `c` one row only"));
    }

    #[test]
    fn names_that_swap_bodies_are_told_together() {
        let all = said(&[
            track(
                "a",
                2,
                &[(0, 0.0, 0.0), (1, 1.0, 0.0), (2, 2.0, 20.0), (3, 3.0, 20.0)],
            ),
            track(
                "b",
                6,
                &[(0, 0.0, 20.0), (1, 1.0, 20.0), (2, 2.0, 0.0), (3, 3.0, 0.0)],
            ),
        ]);
        assert_eq!(all.len(), 1, "{all:?}");
        assert!(
            all[0].starts_with("4 track `a` from here on it is where `b` would be"),
            "{all:?}"
        );
    }
}
