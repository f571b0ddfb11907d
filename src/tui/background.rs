//! Detects a dark or light terminal background: by a terminal query, else from the environment.

use std::time::Duration;

/// Asks whether the terminal is well (DSR), at the end of a question: every terminal answers that in the same way.
pub const STATUS: &str = "\x1b[5n";

/// The longest that the first frame waits for the terminal's answer.
pub const ANSWER_TIMEOUT: Duration = Duration::from_millis(70);

/// The detected background.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Background {
    /// Whether it is dark.
    pub dark: bool,
    /// Whether the terminal may still answer: what it says then are no keys.
    pub late: bool,
}

/// Queries the terminal (OSC 11) for at most [`ANSWER_TIMEOUT`]; without a reply, `COLORFGBG` decides, else it counts as
/// dark. `answers` gives what it answers to a question.
#[must_use]
pub fn ask(
    answers: impl FnOnce(&str, Duration) -> Option<String>,
    env: impl Fn(&str) -> Option<String>,
) -> Background {
    // Ended by BEL, since rxvt-unicode ends its answer like the question, and does so wrongly otherwise.
    let question = format!("\x1b]11;?\x07{STATUS}");
    let is_asked = answers_in_order(env("TERM").as_deref());
    let answers = is_asked
        .then(|| answers(&question, ANSWER_TIMEOUT))
        .flatten();
    match answers.as_deref().and_then(color) {
        Some(color) => Background {
            dark: is_dark(color),
            late: false,
        },
        None => Background {
            late: true,
            ..of_environment(env)
        },
    }
}

/// Whether a terminal can be asked: the dumb and Eterm do not answer, and screen answers questions in another order.
fn answers_in_order(term: Option<&str>) -> bool {
    let is_screen = |term: &str| term == "screen" || term.starts_with("screen.");
    term.is_some_and(|term| !["dumb", "Eterm"].contains(&term) && !is_screen(term))
}

/// The colour in an answer to OSC 11, such as `rgb:1e1e/1e1e/2e2e` or `rgba:ff/ff/ff/ff`.
fn color(answers: &str) -> Option<[u8; 3]> {
    let (_, answer) = answers.split_once("\x1b]11;rgb")?;
    let values = answer.trim_start_matches('a').strip_prefix(':')?;
    let end = values.find(['\x07', '\x1b'])?;
    let mut channels = values[..end].split('/').map(|digits| {
        let most = 16_u64.checked_pow(u32::try_from(digits.len()).ok()?)? - 1;
        let value = u64::from_str_radix(digits, 16).ok()?;
        u8::try_from(value.checked_mul(255)?.checked_div(most)?).ok()
    });
    Some([channels.next()??, channels.next()??, channels.next()??])
}

/// Whether a colour looks nearer to black than to white: its lightness in CIELAB is at most 50.
fn is_dark(rgb: [u8; 3]) -> bool {
    let linear = |value: u8| {
        let value = f64::from(value) / 255.0;
        if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    };
    let [red, green, blue] = rgb.map(linear);
    0.2126 * red + 0.7152 * green + 0.0722 * blue <= 0.1842
}

/// Detects the background from the environment, without querying the terminal.
#[must_use]
pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Background {
    Background {
        dark: parse_colorfgbg(env("COLORFGBG").as_deref()).unwrap_or(true),
        late: false,
    }
}

/// Parses `COLORFGBG`, such as `15;0` or `0;default;15`: the last number is the background's.
fn parse_colorfgbg(value: Option<&str>) -> Option<bool> {
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
    fn the_terminal_says() {
        for (answers, expected) in [
            (
                "\x1b]11;rgb:ffff/8080/0000\x1b\\\x1b[0n",
                Some([255, 128, 0]),
            ),
            ("typed\x1b]11;rgb:f/0/8\x07\x1b[0n", Some([255, 0, 136])),
            ("\x1b]11;rgba:1e/1e/2e/ff\x07\x1b[0n", Some([30, 30, 46])),
            ("\x1b]11;rgb:ffff/8080\x07\x1b[0n", None),
            ("\x1b]11;rgb:/é/\x07\x1b[0n", None),
            ("\x1b]11;rgb:ffffffffffffffff/0/0\x07\x1b[0n", None),
            ("\x1b]11;?\x07\x1b[0n", None),
            ("\x1b[0n", None),
        ] {
            assert_eq!(color(answers), expected, "{answers:?}");
        }
        let asked = ["xterm-256color", "screen-256color", "screen.xterm", "dumb"];
        let asked = asked.map(|term| answers_in_order(Some(term)));
        assert_eq!(asked, [true, true, false, false]);
        assert!(is_dark([118, 118, 118]) && !is_dark([120, 120, 120]));
    }

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
            assert_eq!(parse_colorfgbg(value), dark, "{value:?}");
        }
    }
}
