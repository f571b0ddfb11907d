//! Single-line text: untrusted characters made visible, long text truncated, numbers and times formatted.

use crate::widgets::unbroken;
use nearmiss_scene::description::visible;
use ratatui::buffer::Buffer;
use unicode_segmentation::UnicodeSegmentation;
use unicode_width::UnicodeWidthStr;

pub use nearmiss_study::evaluation::{duration, local_time as date, thousands};

/// `text` on one line, safe to show, cut to `width` columns with an ellipsis.
#[must_use]
pub fn fit(text: &str, width: usize) -> String {
    let text = visible(text).replace(['\n', '\t'], " ");
    if text.width() <= width {
        return text;
    }
    let mut cut = String::new();
    for grapheme in text.graphemes(true) {
        if cut.width() + grapheme.width() + 1 > width {
            break;
        }
        cut.push_str(grapheme);
    }
    if width > 0 {
        cut.push('…');
    }
    cut
}

/// The same, cut at its beginning: what tells names apart is often at their end.
#[must_use]
pub fn fit_end(text: &str, width: usize) -> String {
    let text = visible(text).replace(['\n', '\t'], " ");
    if text.width() <= width {
        return text;
    }
    let mut kept = Vec::new();
    let mut left = width.saturating_sub(1);
    for grapheme in text.graphemes(true).rev() {
        let Some(rest) = left.checked_sub(grapheme.width()) else {
            break;
        };
        left = rest;
        kept.push(grapheme);
    }
    let ellipsis = (width > 0).then_some("…");
    ellipsis.into_iter().chain(kept.into_iter().rev()).collect()
}

/// The same, cut in its middle: of names that begin alike the end tells them apart, of others the beginning.
#[must_use]
pub fn fit_middle(text: &str, width: usize) -> String {
    let end = width.saturating_sub(1) / 2;
    let text = visible(text).replace(['\n', '\t'], " ");
    if text.width() <= width {
        return text;
    }
    // What is cut at its end keeps the ellipsis.
    let end = match end {
        0 => String::new(),
        end => fit_end(&text, end + 1).split_off("…".len()),
    };
    format!("{}{end}", fit(&text, width.saturating_sub(end.width())))
}

/// `text` filled with spaces to `width` columns, cut where it is longer.
#[must_use]
pub fn pad(text: &str, width: usize) -> String {
    let mut text = fit(text, width);
    let missing = width.saturating_sub(text.width());
    text.extend(std::iter::repeat_n(' ', missing));
    text
}

/// A text in at most two lines of so many columns, and whether more of it is left; then the second is too long.
#[must_use]
pub fn two_lines(text: &str, columns: usize) -> (Vec<String>, bool) {
    let text = visible(text);
    let wrapped = unbroken::wrap(&text, columns.max(1));
    let (first, rest) = wrapped.split_at(1.min(wrapped.len()));
    let joined = [first, rest].map(|lines| lines.join(" "));
    let lines = joined.into_iter().filter(|line| !line.is_empty());
    (lines.collect(), rest.len() > 1)
}

/// Techniques as they are called where there is little room.
#[must_use]
pub fn short_techniques(techniques: &str) -> String {
    techniques.replace("cp+cot+icl", "cp…icl")
}

/// Parts with dots between them, as many as there is room for: each whole, but the first, which is cut.
#[must_use]
pub fn whole_parts<'a>(parts: impl IntoIterator<Item = &'a str>, room: usize) -> String {
    let mut line = String::new();
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        if line.is_empty() {
            line = fit(part, room);
        } else if line.width() + BETWEEN.width() + part.width() <= room {
            line.push_str(BETWEEN);
            line.push_str(part);
        } else {
            break;
        }
    }
    line
}

/// Between the parts of a line.
const BETWEEN: &str = " · ";

/// A value with its unit, if it has one.
#[must_use]
pub fn quantity(value: f64, unit: &str) -> String {
    match unit {
        "" => number(value),
        unit => format!("{} {unit}", number(value)),
    }
}

/// As many digits as tell values apart.
#[must_use]
pub fn number(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 {
        format!("{:.0}", value + 0.0)
    } else if value.abs() < 5e-3 || value.abs() >= 1e6 {
        format!("{value:.1e}")
    } else if value.abs() < 10.0 {
        format!("{value:.2}")
    } else {
        format!("{value:.1}")
    }
}

/// To a hundredth; what is too small for that and not nothing is said to be.
#[must_use]
pub fn hundredths(value: f64) -> String {
    match value.abs() {
        small if small > 0.0 && small < 0.01 => "<0.01".into(),
        // Of a negative zero the sign says nothing.
        _ => format!("{:.2}", value + 0.0),
    }
}

/// Signs and what stands for them.
const LIKE: &[(&str, char)] = &[
    ("─╌┄┈╴╶‐‑–—‒▔", '-'),
    ("━═", '='),
    ("│╎┆┊╵╷▏▕", '|'),
    ("┃║▌▐", '#'),
    ("┌┐└┘├┤┬┴┼╭╮╯╰╱╲╳┝┥┠┨┯┷┰┸", '+'),
    ("┏┓┗┛┣┫┳┻╋╔╗╚╝", '#'),
    ("▸▶►→❯›⟩»⇒", '>'),
    ("◂◀◄←‹⟨«⇐", '<'),
    ("▴▲↑△⇑", '^'),
    ("▾▼↓▽⇓", 'v'),
    ("↗↘↙↖", '*'),
    ("●◉⬤◆♦■", 'o'),
    ("○◯◇□▭▯", 'o'),
    ("▬", '='),
    ("·•∙", '.'),
    ("…", '~'),
    ("×✕✗✘", 'x'),
    ("✓✔", 'v'),
    ("≠", '#'),
    ("≈", '~'),
    ("≤", '<'),
    ("≥", '>'),
    ("±", '+'),
    ("−", '-'),
    ("°", 'o'),
    ("′‘’", '\''),
    ("″“”„", '"'),
    ("␛", '^'),
    ("▁", '_'),
    ("▂", '.'),
    ("▃", ':'),
    ("▄", '-'),
    ("▅", '='),
    ("▆", '+'),
    ("▇", '*'),
    ("█▓", '#'),
    ("▒", '%'),
    ("░", ':'),
    ("▀", '"'),
    ("äàáâãå", 'a'),
    ("öòóôõ", 'o'),
    ("üùúû", 'u'),
    ("éèêë", 'e'),
    ("ÄÀÁÂÃÅ", 'A'),
    ("ÖÒÓÔÕ", 'O'),
    ("ÜÙÚÛ", 'U'),
    ("ß", 's'),
    ("Δ", 'D'),
    ("µμ", 'u'),
];

/// Turns what was drawn into ASCII.
pub fn only(buffer: &mut Buffer) {
    for cell in &mut buffer.content {
        if cell.symbol().is_ascii() {
            continue;
        }
        let like = like(cell.symbol());
        // The second column of a wide symbol is a separate cell, left out when a wide one is drawn.
        match cell.symbol().width() {
            0 | 1 => {
                cell.set_char(like);
            }
            _ => {
                cell.set_symbol(&format!("{like}{like}"));
            }
        }
    }
}

fn like(symbol: &str) -> char {
    let Some(sign) = symbol.chars().next() else {
        return ' ';
    };
    if let Ok(dots @ 0..=0xff) = u32::from(sign).checked_sub(0x2800).ok_or(()) {
        return of_dots(dots);
    }
    let found = LIKE.iter().find(|(signs, _)| signs.contains(sign));
    found.map_or('?', |(_, like)| *like)
}

/// What stands for the dots of a Braille pattern: by how many there are, and whether above or below.
fn of_dots(dots: u32) -> char {
    const UPPER: u32 = 0b0001_1011;
    match (dots.count_ones(), dots & UPPER, dots & !UPPER) {
        (0, ..) => ' ',
        (6.., ..) => '#',
        (4..=5, ..) => '%',
        (_, _, 0) => '\'',
        (_, 0, _) => '.',
        _ => ':',
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;

    #[test]
    fn cuts_between_characters() {
        assert_eq!(fit("abcdef", 4), "abc…");
        assert_eq!(fit("日本語", 4), "日…");
        assert_eq!(fit("a\u{1b}[m\nb", 9), "a␛[m b");
        assert_eq!(pad("ab", 4), "ab  ");
        assert_eq!(fit("abc", 0), "");
        assert_eq!(fit_end("lab/small", 9), "lab/small");
        assert_eq!(fit_end("lab/small", 6), "…small");
        assert_eq!(fit_end("日本語", 4), "…語");
        assert_eq!(fit_end("abc", 0), "");
        assert_eq!(fit_middle("sage-70b", 8), "sage-70b");
        assert_eq!(fit_middle("sage-70b", 7), "sag…70b");
        assert_eq!(fit_middle("日本語日本", 6), "日…本");
        assert_eq!(fit_middle("abc", 1), "…");
        assert_eq!(fit_middle("abc", 0), "");
        let parts = ["a name", "", "12 steps", "s"];
        assert_eq!(whole_parts(parts, 40), "a name · 12 steps · s");
        assert_eq!(whole_parts(parts, 20), "a name · 12 steps");
        assert_eq!(whole_parts(parts, 16), "a name");
        assert_eq!(whole_parts(parts, 4), "a n…");
    }

    #[test]
    fn numbers() {
        assert_eq!(thousands(1_834_002), "1,834,002");
        assert_eq!(thousands(12), "12");
        let values = [0.0, -0.0, 3.0, 0.004, -1.254, 12.34, 4e9, -250.0];
        let shown = ["0", "0", "3", "4.0e-3", "-1.25", "12.3", "4.0e9", "-250"];
        assert_eq!(values.map(number), shown);
        assert_eq!(quantity(1.5, "s"), "1.50 s");
        let values = [0.0, 0.005, 0.009_9, 0.01, 1.234];
        let shown = ["0.00", "<0.01", "<0.01", "0.01", "1.23"];
        assert_eq!(values.map(hundredths), shown);
        assert_eq!(duration(6_120), "6.1 s");
    }

    #[test]
    fn every_sign_has_one_like_it() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 20, 1));
        buffer.set_string(0, 0, "┏━ ▸⣿⠉⣀⠒ ≠ é…日x", ratatui::style::Style::new());
        only(&mut buffer);
        let text: String = buffer.content.iter().map(|cell| cell.symbol()).collect();
        assert!(text.is_ascii());
        assert!(text.starts_with("#= >#'.' # e~??"), "{text}");
    }
}
