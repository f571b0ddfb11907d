//! The tables of nuScenes, each an array of rows in JSON, read row by row: of millions of rows only what is needed stays.

use std::fmt;
use std::io::BufReader;
use std::marker::PhantomData;
use std::path::Path;

use serde::de::{DeserializeOwned, Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, de};

use nearmiss_base::system;

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;

/// A token: 32 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Token(u128);

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl<'de> Deserialize<'de> for Token {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct OfText;
        impl de::Visitor<'_> for OfText {
            type Value = Token;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a token of 32 hexadecimal digits")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Token, E> {
                let number = u128::from_str_radix(text, 16).ok();
                let whole = number.filter(|_| text.len() == 32);
                whole.map(Token).ok_or_else(|| {
                    let shown: String = text.chars().take(40).collect();
                    E::custom(format!("`{shown}` is no token"))
                })
            }
        }
        from.deserialize_str(OfText)
    }
}

/// A row of `scene.json`.
#[derive(Deserialize)]
pub struct Scene {
    pub token: Token,
    pub name: String,
}

/// A row of `sample.json`: a key frame.
#[derive(Deserialize)]
pub struct Sample {
    pub token: Token,
    /// Microseconds.
    pub timestamp: i64,
    pub scene_token: Token,
}

/// A row of `category.json`.
#[derive(Deserialize)]
pub struct Category {
    pub token: Token,
    pub name: String,
}

/// A row of `instance.json`: an object of a scene.
#[derive(Deserialize)]
pub struct Instance {
    pub token: Token,
    pub category_token: Token,
}

/// A row of `sample_annotation.json`: an object's box in a key frame.
#[derive(Deserialize)]
pub struct Annotation {
    pub sample_token: Token,
    pub instance_token: Token,
    /// The middle of the box, metres.
    pub translation: [f64; 3],
    /// Width, length and height, metres.
    pub size: [f64; 3],
    /// A quaternion: w, x, y, z.
    pub rotation: [f64; 4],
}

/// A row of `sample_data.json`: what a sensor saw.
#[derive(Deserialize)]
pub struct SampleData {
    pub sample_token: Token,
    pub ego_pose_token: Token,
    /// Microseconds.
    pub timestamp: i64,
    pub is_key_frame: bool,
}

/// A row of `ego_pose.json`: where the rear axle of the vehicle is that records.
#[derive(Deserialize)]
pub struct EgoPose {
    pub token: Token,
    pub translation: [f64; 3],
    pub rotation: [f64; 4],
}

/// Gives every row of a table to `take`.
///
/// # Errors
/// The file is not there or damaged: with the line.
pub fn each<R: DeserializeOwned>(
    scenes: &Path,
    name: &str,
    mut take: impl FnMut(R),
) -> Result<(), ReadError> {
    let path = scenes.with_file_name(name);
    let report = Report::about(path.display().to_string());
    let file = system::open_file(&path).map_err(|error| {
        if error.kind() == std::io::ErrorKind::NotFound {
            let message = format!(
                "not there; a scene of nuScenes needs {}",
                super::FILES.join(", ")
            );
            return report.fail(message);
        }
        ReadError::io(report.file(), &error)
    })?;
    let from = BufReader::with_capacity(1 << 18, file);
    let mut json = serde_json::Deserializer::from_reader(from);
    let rows = Rows {
        take: &mut take,
        row: PhantomData,
    };
    let read = json.deserialize_seq(rows).and_then(|()| json.end());
    read.map_err(|error| {
        // The place is told by its line.
        let said = error.to_string();
        let words = said.split(" at line ").next().unwrap_or_default();
        report.row(error.line(), "").fail(words.to_string())
    })
}

/// The rows of an array, one after the other.
struct Rows<'t, R, F: FnMut(R)> {
    take: &'t mut F,
    row: PhantomData<R>,
}

impl<'de, R: Deserialize<'de>, F: FnMut(R)> Visitor<'de> for Rows<'_, R, F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<(), A::Error> {
        let mut count: usize = 0;
        while let Some(row) = rows.next_element::<R>()? {
            count += 1;
            if count > MOST_ROWS {
                return Err(A::Error::custom(format!("more than {MOST_ROWS} rows")));
            }
            (self.take)(row);
        }
        Ok(())
    }
}

/// No table has more rows.
const MOST_ROWS: usize = 50_000_000;
