//! Detects a dark or light terminal background: by a terminal query, else from the environment.

use std::time::Duration;

use terminal_colorsaurus::{QueryOptions, background_color};

/// The longest that the first frame waits for the terminal's answer.
pub const PATIENCE: Duration = Duration::from_millis(70);

/// The detected background.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Background {
    /// Whether it is dark.
    pub dark: bool,
    /// Whether the terminal may still answer: what it says then are no keys.
    pub late: bool,
}

/// Queries the terminal (OSC 11) for at most [`PATIENCE`]; without a reply, `COLORFGBG` decides, else it counts as
/// dark. Nothing else may read the terminal meanwhile.
#[must_use]
pub fn ask(env: impl Fn(&str) -> Option<String>) -> Background {
    let mut options = QueryOptions::default();
    options.timeout = PATIENCE;
    match background_color(options) {
        Ok(color) => Background {
            dark: color.perceived_lightness() <= 0.5,
            late: false,
        },
        Err(_) => Background {
            late: true,
            ..of_environment(env)
        },
    }
}

/// Detects the background from the environment, without querying the terminal.
#[must_use]
pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Background {
    Background {
        dark: said(env("COLORFGBG").as_deref()).unwrap_or(true),
        late: false,
    }
}

/// Parses `COLORFGBG`, such as `15;0` or `0;default;15`: the last number is the background's.
fn said(value: Option<&str>) -> Option<bool> {
    let background = value?.rsplit(';').next()?;
    match background.trim().parse::<u8>().ok()? {
        // As Vim and rxvt have it: white and the bright colours but dark gray are light.
        7 | 9..=15 => Some(false),
        0..=6 | 8 => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_says() {
        for (value, dark) in [
            (None, None),
            (Some(""), None),
            (Some("15;0"), Some(true)),
            (Some("0;15"), Some(false)),
            (Some("0;default;7"), Some(false)),
            (Some("12;8"), Some(true)),
            (Some("0;default"), None),
            (Some("0;99"), None),
        ] {
            assert_eq!(said(value), dark, "{value:?}");
        }
    }
}
