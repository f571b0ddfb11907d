//! Converts a frame to ASCII: every symbol becomes a similar one of the same width.

use ratatui::buffer::Buffer;
use unicode_width::UnicodeWidthStr;

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
    fn every_sign_has_one_like_it() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 20, 1));
        buffer.set_string(0, 0, "┏━ ▸⣿⠉⣀⠒ ≠ é…日x", ratatui::style::Style::new());
        only(&mut buffer);
        let text: String = buffer.content.iter().map(|cell| cell.symbol()).collect();
        assert!(text.is_ascii());
        assert!(text.starts_with("#= >#'.' # e~??"), "{text}");
    }
}
