//! Arguments that may be named in several ways, and what is said of those that are none of them.

use std::path::PathBuf;

use nearmiss_workflow::span::At;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::{Problem, of_keyword};

/// Takes the first form that fits; `expected` says all of them.
macro_rules! forms {
    ($name:ident, $expected:literal, $($form:ident),+) => {
        impl<'py> FromPyObject<'_, 'py> for $name {
            type Error = PyErr;

            fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
                $(if let Ok(taken) = given.extract() {
                    return Ok(Self::$form(taken));
                })+
                let kind = given.get_type();
                Err(PyTypeError::new_err(format!(
                    concat!("expected ", $expected, ", not {}"),
                    kind.name()?
                )))
            }
        }
    };
}

/// A moment of a recording.
pub enum Moment {
    /// A time step.
    Step(i64),
    /// Seconds since step 0.
    Seconds(f64),
    /// The same as a `datetime.timedelta`.
    Time(Timedelta),
    /// `worst`, `worst:ttc`, or `3.2s`.
    Named(String),
}

forms!(
    Moment,
    "a time step (int), seconds (float), a timedelta or \"worst\"",
    Step,
    Seconds,
    Time,
    Named
);

impl Moment {
    /// The same as commands name it.
    ///
    /// # Errors
    /// The word is no moment.
    pub fn at(self) -> Result<At, Problem> {
        Ok(match self {
            Self::Step(step) => At::Step(step),
            Self::Seconds(seconds) | Self::Time(Timedelta(seconds)) if seconds.is_finite() => {
                At::Seconds(seconds)
            }
            Self::Seconds(seconds) | Self::Time(Timedelta(seconds)) => {
                return Err(Problem::new(format!("at: {seconds} is no time")));
            }
            Self::Named(word) => of_keyword("at", word.parse())?,
        })
    }
}

/// A duration, seconds; one of pandas, too, and one that is negative.
pub struct Timedelta(f64);

impl<'py> FromPyObject<'_, 'py> for Timedelta {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        given.call_method0("total_seconds")?.extract().map(Self)
    }
}

/// A keyword that has to be a positive number where it is said.
///
/// # Errors
/// It is none.
pub fn positive(keyword: &str, value: Option<f64>) -> Result<(), Problem> {
    match value {
        Some(value) if !(value.is_finite() && value > 0.0) => Err(Problem::new(format!(
            "{keyword}: expected a positive number"
        ))),
        _ => Ok(()),
    }
}

/// One path or many.
pub enum Paths {
    /// A file or folder.
    One(PathBuf),
    /// Several.
    Many(Vec<PathBuf>),
}

forms!(Paths, "a path or a list of paths", One, Many);

impl Paths {
    /// All of them.
    pub fn all(self) -> Vec<PathBuf> {
        match self {
            Self::One(path) => vec![path],
            Self::Many(paths) => paths,
        }
    }
}

/// One name or many.
pub enum Names {
    /// A name.
    One(String),
    /// Several.
    Many(Vec<String>),
}

forms!(Names, "a name or a list of names", One, Many);

impl Names {
    /// All of them.
    pub fn all(self) -> Vec<String> {
        match self {
            Self::One(name) => vec![name],
            Self::Many(names) => names,
        }
    }
}

/// An ego.
#[derive(Clone)]
pub enum Ego {
    /// Id of an obstacle.
    Id(i64),
    /// A file with its trajectory, `FILE#ID`, the name of a track, or `planner`.
    Named(PathBuf),
}

forms!(
    Ego,
    "the id of an obstacle, a path, the name of a track or \"planner\"",
    Id,
    Named
);

/// Obstacles.
pub enum Obstacles {
    /// One.
    One(i64),
    /// Several.
    Many(Vec<i64>),
}

forms!(
    Obstacles,
    "the id of an obstacle or a list of ids",
    One,
    Many
);
