//! Which column of a table of tracks tells what, in which unit: by name, by the user's word, or by a known data set.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use nearmiss_base::system::unknown;
use strum::IntoEnumIterator;

use crate::recordings::rows;

/// What a column can tell of a track.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    strum::EnumIter,
    strum::EnumString,
    strum::IntoStaticStr,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Role {
    /// When, seconds.
    Time,
    /// What of a second is to be added to it, ns.
    Nanoseconds,
    /// Which picture of the recording, a whole number.
    Frame,
    /// The track's name.
    Id,
    /// Metres.
    X,
    /// Metres.
    Y,
    /// Degrees on WGS 84.
    Latitude,
    /// Degrees on WGS 84.
    Longitude,
    /// Radians, counterclockwise from the x-axis.
    Heading,
    /// A part of the quaternion that turns the x-axis to the heading.
    QuaternionX,
    /// The same.
    QuaternionY,
    /// The same.
    QuaternionZ,
    /// The same.
    QuaternionW,
    /// m/s.
    Speed,
    /// m/s along the x-axis.
    VelocityX,
    /// m/s along the y-axis.
    VelocityY,
    /// m/s² along the heading.
    Acceleration,
    /// Metres.
    Length,
    /// Metres.
    Width,
    /// The class of the road user.
    Class,
    /// Whether the track is the ego.
    Ego,
    /// Which of several scenarios in the file.
    Scenario,
    /// Which of several predicted trajectories of the road user.
    Mode,
    /// How likely that one is, 0 to 1.
    Probability,
}

impl Role {
    /// Its name on the command line and in messages.
    pub fn name(self) -> &'static str {
        self.into()
    }

    pub(super) fn quantity(self) -> Quantity {
        match self {
            Self::Time => Quantity::Time,
            Self::X | Self::Y | Self::Length | Self::Width => Quantity::Length,
            Self::Heading | Self::Latitude | Self::Longitude => Quantity::Angle,
            Self::Speed | Self::VelocityX | Self::VelocityY => Quantity::Speed,
            Self::Acceleration => Quantity::Acceleration,
            Self::Nanoseconds
            | Self::Frame
            | Self::QuaternionX
            | Self::QuaternionY
            | Self::QuaternionZ
            | Self::QuaternionW
            | Self::Id
            | Self::Class
            | Self::Ego
            | Self::Scenario
            | Self::Mode
            | Self::Probability => Quantity::None,
        }
    }

    /// Whether its values are texts rather than numbers.
    pub fn is_text(self) -> bool {
        matches!(
            self,
            Self::Id | Self::Class | Self::Ego | Self::Scenario | Self::Mode
        )
    }

    /// Whether it tells of what was, and not of what is expected.
    pub fn is_of_recordings(self) -> bool {
        !matches!(self, Self::Mode | Self::Probability)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    Length,
    Angle,
    Speed,
    Acceleration,
    None,
}

/// Units: how they are written, of what, and what one of them is in seconds, metres, radians, m/s or m/s².
const UNITS: [(&str, Quantity, f64); 37] = [
    ("s", Quantity::Time, 1.0),
    ("sec", Quantity::Time, 1.0),
    ("seconds", Quantity::Time, 1.0),
    ("ms", Quantity::Time, 1e-3),
    ("msec", Quantity::Time, 1e-3),
    ("milliseconds", Quantity::Time, 1e-3),
    ("us", Quantity::Time, 1e-6),
    ("usec", Quantity::Time, 1e-6),
    ("microseconds", Quantity::Time, 1e-6),
    ("ns", Quantity::Time, 1e-9),
    ("nsec", Quantity::Time, 1e-9),
    ("nanoseconds", Quantity::Time, 1e-9),
    ("m", Quantity::Length, 1.0),
    ("meter", Quantity::Length, 1.0),
    ("meters", Quantity::Length, 1.0),
    ("cm", Quantity::Length, 0.01),
    ("mm", Quantity::Length, 0.001),
    ("km", Quantity::Length, 1000.0),
    ("ft", Quantity::Length, FOOT),
    ("feet", Quantity::Length, FOOT),
    ("rad", Quantity::Angle, 1.0),
    ("radians", Quantity::Angle, 1.0),
    ("deg", Quantity::Angle, std::f64::consts::PI / 180.0),
    ("degrees", Quantity::Angle, std::f64::consts::PI / 180.0),
    ("°", Quantity::Angle, std::f64::consts::PI / 180.0),
    ("m/s", Quantity::Speed, 1.0),
    ("mps", Quantity::Speed, 1.0),
    ("ms", Quantity::Speed, 1.0),
    ("km/h", Quantity::Speed, 1.0 / 3.6),
    ("kmh", Quantity::Speed, 1.0 / 3.6),
    ("kph", Quantity::Speed, 1.0 / 3.6),
    ("mph", Quantity::Speed, 0.447_04),
    ("ft/s", Quantity::Speed, FOOT),
    ("fps", Quantity::Speed, FOOT),
    ("m/s2", Quantity::Acceleration, 1.0),
    ("mps2", Quantity::Acceleration, 1.0),
    ("ft/s2", Quantity::Acceleration, FOOT),
];

/// Metres.
pub const FOOT: f64 = 0.3048;

/// Whether a text is a unit of anything.
pub(super) fn is_unit(text: &str) -> bool {
    UNITS.iter().any(|(_, of, _)| unit(*of, text).is_some())
}

/// What a unit of this quantity is worth, by how it is written.
pub(super) fn unit(quantity: Quantity, written: &str) -> Option<f64> {
    let written = written.to_lowercase().replace('²', "2").replace("^2", "2");
    let found = UNITS
        .iter()
        .find(|(name, of, _)| *of == quantity && *name == written);
    found.map(|(.., factor)| *factor)
}

/// A name without a unit of the role's in brackets behind it, and what one of that unit is.
fn with_unit(role: Role, name: &str) -> Option<(&str, f64)> {
    let (base, rest) = name.rsplit_once(['[', '('])?;
    let written = rest.trim_end_matches([']', ')', ' ']).trim();
    Some((base.trim_end(), unit(role.quantity(), written)?))
}

/// What of a column is other than usual, as words in brackets say it.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, strum::EnumString, strum::IntoStaticStr, strum::EnumIter,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Convention {
    /// Of `y` and the velocity along it: it grows downwards, as in pictures.
    Down,
    /// Of `heading`: clockwise from north.
    North,
    /// Of `x`: the place is the middle of the front.
    Front,
    /// Of `x`: the place is the middle of the rear axle, 0.28 of the length behind that of the body.
    RearAxle,
    /// Of `x`: the place is the upper left corner (least x, greatest y) of a box that is not turned, as in highD.
    Corner,
}

impl Convention {
    fn role(self) -> Role {
        match self {
            Self::Down => Role::Y,
            Self::North => Role::Heading,
            Self::Front | Self::RearAxle | Self::Corner => Role::X,
        }
    }
}

/// Where a role's values stand, and in which unit they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The name of the column, or its place from 1 in a table without a header.
    pub column: String,
    /// What one of its units is in the role's; `None` where nothing says it.
    pub factor: Option<f64>,
}

/// The columns of a table and their conventions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// Each role once.
    pub of: BTreeMap<Role, Source>,
    /// What is other than usual.
    pub conventions: Vec<Convention>,
    /// Roles that no column is to have.
    pub none: Vec<Role>,
}

/// The parts of a quaternion, in the order of [`crate::recordings::assembly::yaw`].
pub const QUATERNION: [Role; 4] = [
    Role::QuaternionW,
    Role::QuaternionX,
    Role::QuaternionY,
    Role::QuaternionZ,
];

/// Instead of a column: there is none of a role.
const NONE: &str = "none";

/// Why words for columns cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ColumnsError(String);

impl FromStr for Columns {
    type Err = ColumnsError;

    /// Reads `time=t[ms],id=track,x=px[ft],y=py[down],heading=none`.
    fn from_str(words: &str) -> Result<Self, ColumnsError> {
        let fail = |message: String| Err(ColumnsError(message));
        let mut columns = Self::default();
        for word in words.split(',').map(str::trim).filter(|w| !w.is_empty()) {
            let Some((role, column)) = word.split_once('=') else {
                return fail(format!(
                    "`{word}` is no column; write ROLE=COLUMN, such as time=t"
                ));
            };
            let Ok(role) = Role::from_str(role.trim()) else {
                return fail(unknown("role", role.trim(), Role::iter().map(Role::name)));
            };
            if column.trim() == NONE {
                columns.none.push(role);
                continue;
            }
            let (name, brackets) = bracketed(role, column.trim());
            let mut factor = None;
            for said in brackets.split(' ').filter(|said| !said.is_empty()) {
                match (unit(role.quantity(), said), Convention::from_str(said)) {
                    (Some(unit), _) => factor = Some(unit),
                    (None, Ok(convention)) if convention.role() == role => {
                        columns.conventions.push(convention);
                    }
                    _ => return fail(wrong_unit(role, said, column.trim())),
                }
            }
            let source = Source {
                column: name.to_string(),
                factor,
            };
            if columns.of.insert(role, source).is_some() {
                return fail(format!("`{}` is there twice", role.name()));
            }
        }
        if columns.of.is_empty() && columns.none.is_empty() {
            return fail("no column is named; write ROLE=COLUMN, such as time=t,id=track".into());
        }
        Ok(columns)
    }
}

/// The name of a column and what the last brackets behind it say. Brackets without a letter, such as `[0]`, are part of the
/// name, unless they are a unit.
fn bracketed(role: Role, column: &str) -> (&str, &str) {
    let split = column
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once('['));
    let Some((name, said)) = split else {
        return (column, "");
    };
    let is_name = !said.is_empty()
        && !said.contains(char::is_alphabetic)
        && unit(role.quantity(), said).is_none();
    if is_name {
        (column, "")
    } else {
        (name.trim(), said)
    }
}

fn wrong_unit(role: Role, said: &str, column: &str) -> String {
    let instead = format!("; for a column of that name: {}={column}[]", role.name());
    let units = UNITS.iter().filter(|(_, of, _)| *of == role.quantity());
    let units = units.map(|(name, ..)| *name);
    let conventions = Convention::iter().filter(|c| c.role() == role);
    let known: Vec<&str> = units.chain(conventions.map(<&str>::from)).collect();
    match known[..] {
        [] => format!("`{}` has no unit; remove [{said}]{instead}", role.name()),
        _ => format!(
            "[{said}] is no unit of `{}`; known are {}{instead}",
            role.name(),
            known.join(", ")
        ),
    }
}

impl fmt::Display for Columns {
    /// As `time = column t, id = column track`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (role, source)) in self.of.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{} = {}", role.name(), source.column)?;
        }
        Ok(())
    }
}

impl Columns {
    /// In words with the units and conventions that they say, for hashes.
    pub(super) fn how(&self) -> String {
        let units = self.of.iter().filter_map(|(role, source)| {
            let factor = source.factor?;
            Some(format!(" {}[{factor}]", role.name()))
        });
        let conventions = self.conventions.iter().map(|said| format!(" {said:?}"));
        let said: String = units.chain(conventions).collect();
        format!("{self}{said}")
    }

    /// These, and for roles that they do not name those of `others`.
    pub fn or(mut self, others: Self) -> Self {
        let used: Vec<String> = self.of.values().map(|s| s.column.clone()).collect();
        for (role, source) in others.of {
            if !used.contains(&source.column) && !self.none.contains(&role) {
                self.of.entry(role).or_insert(source);
            }
        }
        self.settled()
    }

    /// Without parts of a time or a heading that are not whole or not needed.
    pub(super) fn settled(mut self) -> Self {
        if !self.of.contains_key(&Role::Time) {
            self.of.remove(&Role::Nanoseconds);
        }
        let is_whole = QUATERNION.iter().all(|role| self.of.contains_key(role));
        if !is_whole || self.of.contains_key(&Role::Heading) || self.none.contains(&Role::Heading) {
            self.of.retain(|role, _| !QUATERNION.contains(role));
        }
        // These are of one unit only.
        let is_split = self.of.contains_key(&Role::Nanoseconds);
        for (role, source) in &mut self.of {
            if QUATERNION.contains(role) || is_split && *role == Role::Time {
                source.factor.get_or_insert(1.0);
            }
        }
        self
    }

    /// Where a role's values stand; those of headings may be quaternions.
    pub fn source(&self, role: Role) -> Option<&Source> {
        let instead = (role == Role::Heading).then_some(Role::QuaternionZ);
        let own = self.of.get(&role);
        own.or_else(|| self.of.get(&instead?))
    }

    /// Those of some roles.
    pub fn only(mut self, is_wanted: fn(Role) -> bool) -> Self {
        self.of.retain(|role, _| is_wanted(*role));
        self
    }

    /// The role of the column that says when a row is, where there are `rate` frames a second.
    pub fn clock(&self, rate: Option<f64>) -> Role {
        let has = |role| self.of.contains_key(&role);
        if has(Role::Time) && !(rate.is_some() && has(Role::Frame)) {
            Role::Time
        } else {
            Role::Frame
        }
    }

    /// Whether these are places of columns and a row, the first of a table, is none of names: a number stands where x is.
    pub fn are_places(&self, row: &[String]) -> bool {
        let place = |source: &Source| -> Option<usize> {
            let from_1: usize = source.column.parse().ok()?;
            (1..=row.len()).contains(&from_1).then_some(from_1 - 1)
        };
        let mut x = [Role::X, Role::Longitude]
            .into_iter()
            .filter_map(|role| place(self.of.get(&role)?));
        x.next()
            .is_some_and(|x| rows::number(&row[x], b';').is_some())
            && self.of.values().all(|source| place(source).is_some())
    }

    /// Whether these make tracks.
    pub fn is_enough(&self) -> bool {
        self.missing().is_empty()
    }

    /// What is missing for tracks, in words.
    pub fn missing(&self) -> Vec<&'static str> {
        let has = |role| self.of.contains_key(&role);
        // Degrees are both, or metres are.
        let degrees = has(Role::Longitude) && has(Role::Latitude);
        let needed = [
            (has(Role::Time) || has(Role::Frame), "time or frame"),
            (has(Role::Id), "id"),
            (has(Role::X) || degrees, "x"),
            (has(Role::Y) || degrees, "y"),
        ];
        let missing = needed.into_iter().filter(|(there, _)| !there);
        missing.map(|(_, what)| what).collect()
    }

    /// What is found and missing for tracks, and what to do; nothing where all is there.
    pub fn lacking(&self) -> Option<String> {
        let missing = self.missing();
        if missing.is_empty() {
            return None;
        }
        let found = if self.of.is_empty() {
            String::new()
        } else {
            format!("found: {self}; ")
        };
        let one = if missing.len() == 1 && !self.of.contains_key(&Role::Id) {
            "; if each road user has a file of its own in a folder: --columns id=file"
        } else {
            ""
        };
        Some(format!(
            "{found}missing: {}; if it has tracks, say which column is what: --columns time=COLUMN,id=COLUMN,x=COLUMN,y=COLUMN{one}",
            missing.join(", ")
        ))
    }

    /// Whether a convention is said.
    pub fn has(&self, convention: Convention) -> bool {
        self.conventions.contains(&convention)
    }

    /// The same with the columns as a table writes them, in any case, and those that it does not have; with `units` also one
    /// whose name is that and its unit, if it is the only one.
    pub fn in_table(mut self, names: &[String], units: bool) -> (Self, Vec<String>) {
        let mut missing = Vec::new();
        self.of.retain(|role, source| {
            let is_base = |name: &&String| {
                with_unit(*role, name).is_some_and(|(base, factor)| {
                    let is_said = source
                        .factor
                        .is_none_or(|said| (said - factor).abs() < 1e-12);
                    units && is_said && base.eq_ignore_ascii_case(&source.column)
                })
            };
            let mut based = names.iter().filter(is_base);
            let only = based.next().filter(|_| based.next().is_none());
            let written = names
                .iter()
                .find(|name| **name == source.column)
                .or_else(|| {
                    names
                        .iter()
                        .find(|n| n.eq_ignore_ascii_case(&source.column))
                })
                .or(only);
            let Some(name) = written else {
                missing.push(source.column.clone());
                return false;
            };
            let written = with_unit(*role, name).map(|(_, factor)| factor);
            source.factor = source.factor.or(written);
            source.column.clone_from(name);
            true
        });
        (self, missing)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn names(all: &str) -> Columns {
        let names: Vec<String> = all.split('|').map(str::to_string).collect();
        Columns::by_name(&names)
    }

    #[test]
    fn columns_are_known_by_usual_names_with_their_units() {
        let found =
            names("Timestamp_ms|Track ID|pos.x [m]|Pos.Y (ft)|yaw_deg|speed_kmh|object_type|other");
        let factor = |role| found.of[&role].factor;
        assert_eq!(found.of[&Role::Id].column, "Track ID");
        assert_eq!(factor(Role::Time), Some(1e-3));
        assert_eq!((factor(Role::X), factor(Role::Y)), (Some(1.0), Some(FOOT)));
        assert!((factor(Role::Heading).unwrap() - 1f64.to_radians()).abs() < 1e-15);
        assert!((factor(Role::Speed).unwrap() - 1.0 / 3.6).abs() < 1e-15);
        // Of several with the name, and of one with another unit, none is meant.
        let missing = |said: &str, table: &[&str], units| {
            let table: Vec<String> = table.iter().map(ToString::to_string).collect();
            let columns: Columns = said.parse().unwrap();
            columns.in_table(&table, units).1
        };
        assert_eq!(missing("x=px", &["px [ft]", "px [m]"], true), ["px"]);
        assert_eq!(missing("x=px[m]", &["px [ft]"], true), ["px"]);
        assert_eq!(missing("x=px[m]", &["px [ft]", "px [m]"], true), [""; 0]);
        assert_eq!(missing("x=pos[0]", &["pos[0] [ft]"], true), [""; 0]);
        assert_eq!(missing("x=px", &["px [m]"], false), ["px"]);
        assert_eq!(found.of[&Role::Class].column, "object_type");
        assert!(found.is_enough());
        // The more usual name is meant.
        assert_eq!(names("id|track_id|x|y|t").of[&Role::Id].column, "track_id");
        assert_eq!(names("x|y|t").missing(), ["id"]);
        assert_eq!(names("lat|lon|frame|id").missing(), [""; 0]);
        let others = names("t|track_uid|x|y|dim_x|dimensions.y|cls");
        let known = [Role::Id, Role::Length, Role::Width, Role::Class];
        assert!(others.is_enough() && known.iter().all(|role| others.of.contains_key(role)));
    }

    #[test]
    fn the_user_names_columns_units_and_conventions() {
        let columns: Columns =
            "time=t[ms], id=who,x=px[ft front],y=py[down],heading=dir[deg north]"
                .parse()
                .unwrap();
        assert_eq!(columns.of[&Role::Time].factor, Some(1e-3));
        assert_eq!(columns.of[&Role::X].factor, Some(FOOT));
        assert_eq!(
            columns.conventions,
            [Convention::Front, Convention::Down, Convention::North]
        );
        let error = |words: &str| words.parse::<Columns>().unwrap_err().to_string();
        assert!(error("tiem=t").contains("unknown role") && error("tiem=t").contains("`time`"));
        assert!(error("t").contains("ROLE=COLUMN"));
        assert!(
            error("x=px[s]").contains("known are m,"),
            "{}",
            error("x=px[s]")
        );
        assert!(error("id=a[m]").contains("has no unit"));
        assert!(error("x=a,x=b").contains("twice"));
        assert!(error("").contains("no column"));
        assert!(error("x=pos[x]").contains("for a column of that name: x=pos[x][]"));
        // Brackets may be part of the name, or say the unit in the table, too.
        let brackets: Columns = "time=t,id=a[x][],x=pos[0],y=pos[1][ft],speed=v"
            .parse()
            .unwrap();
        let table = ["t [ms]", "a[x]", "pos[0]", "pos[1]", "v (km/h)"].map(String::from);
        let (found, missing) = brackets.in_table(&table, true);
        assert_eq!(missing, [""; 0]);
        let named: Vec<&str> = found.of.values().map(|s| s.column.as_str()).collect();
        assert_eq!(named, table);
        let factor = |role| found.of[&role].factor;
        assert_eq!(
            (factor(Role::Time), factor(Role::Y)),
            (Some(1e-3), Some(FOOT))
        );
        assert!((factor(Role::Speed).unwrap() - 1.0 / 3.6).abs() < 1e-15);
        // What is not named comes from the names; a column has one role.
        let rest = names("px|py|who|t|speed|dir|frame");
        let all = columns.or(rest);
        assert_eq!(all.of[&Role::Speed].column, "speed");
        assert!(all.is_enough());
    }
}
