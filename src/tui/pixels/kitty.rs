//! Images at kitty: sent once, in pieces, and shown wherever cells hold its placeholders.
//!
//! <https://sw.kovidgoyal.net/kitty/graphics-protocol/>; an image whose placeholders are gone is taken away by the terminal,
//! and one that is sent with the id of another replaces it.

use std::borrow::Cow;
use std::io::Write;
use std::num::NonZeroU16;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use ratatui::buffer::{Buffer, CellDiffOption};
use ratatui::layout::Rect;
use ratatui::style::Color;

/// The character that stands for a cell of an image; the colour of the text is the image's id.
const PLACEHOLDER: char = '\u{10eeee}';
/// A cell that is one column wide, however wide its symbol looks.
pub const ONE_COLUMN: CellDiffOption = CellDiffOption::ForcedWidth(NonZeroU16::MIN);
/// Bytes of a piece: 4096 in base64.
const PIECE: usize = 4096 / 4 * 3;

/// The sequences that send an image of red, green, blue and opacity, `width` pixels wide, for so many columns and rows.
pub fn sequences(
    pixels: &[u8],
    width: u32,
    (columns, rows): (u16, u16),
    id: u32,
    compress: bool,
) -> Vec<String> {
    let height = pixels.len() / 4 / width.max(1) as usize;
    let (data, packed) = match compress.then(|| zlib(pixels)).flatten() {
        Some(data) => (Cow::Owned(data), "o=z,"),
        None => (Cow::Borrowed(pixels), ""),
    };
    let last = data.len().div_ceil(PIECE).saturating_sub(1);
    let piece = |(i, piece): (usize, &[u8])| {
        let mut sequence = String::from("\x1b_Gq=2,");
        if i == 0 {
            sequence += &format!(
                "i={id},a=T,U=1,f=32,{packed}t=d,s={width},v={height},c={columns},r={rows},"
            );
        }
        sequence += &format!("m={};", u8::from(i < last));
        STANDARD.encode_string(piece, &mut sequence);
        sequence + "\x1b\\"
    };
    data.chunks(PIECE).enumerate().map(piece).collect()
}

/// Quickly compressed: the picture waits for it.
fn zlib(pixels: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(pixels).ok()?;
    encoder.finish().ok()
}

/// Fills an area with placeholders of an image; `send` goes ahead of them.
pub fn place(buffer: &mut Buffer, area: Rect, id: u32, mut send: Option<&str>) {
    let [high, red, green, blue] = id.to_be_bytes();
    for y in 0..area.height {
        let marks = [y, 0, u16::from(high)].map(diacritic);
        let [Some(row), Some(first), Some(high)] = marks else {
            break;
        };
        for x in (0..area.width).take_while(|x| diacritic(*x).is_some()) {
            let Some(cell) = buffer.cell_mut((area.x + x, area.y + y)) else {
                continue;
            };
            let mut symbol = send.take().unwrap_or_default().to_string();
            symbol.push(PLACEHOLDER);
            // The cells to the right continue the row.
            if x == 0 {
                symbol.extend([row, first, high]);
            }
            cell.set_symbol(&symbol)
                .set_fg(Color::Rgb(red, green, blue))
                .set_diff_option(ONE_COLUMN);
        }
    }
}

/// The mark that says a row, column or byte at a placeholder.
fn diacritic(n: u16) -> Option<char> {
    let mut before = 0;
    for [first, count] in DIACRITICS.as_chunks().0 {
        let after = u32::from(n) - before;
        if after < *count {
            return char::from_u32(first + after);
        }
        before += count;
    }
    None
}

/// The marks of kitty's `rowcolumn-diacritics.txt`: the first one of each run, and how many follow each other.
const DIACRITICS: [u32; 172] = [
    0x305, 1, 0x30d, 2, 0x310, 1, 0x312, 1, 0x33d, 3, 0x346, 1, 0x34a, 3, 0x350, 3, 0x357, 1,
    0x35b, 1, 0x363, 13, 0x483, 5, 0x592, 4, 0x597, 3, 0x59c, 6, 0x5a8, 2, 0x5ab, 2, 0x5af, 1,
    0x5c4, 1, 0x610, 8, 0x657, 5, 0x65d, 2, 0x6d6, 7, 0x6df, 4, 0x6e4, 1, 0x6e7, 2, 0x6eb, 2,
    0x730, 1, 0x732, 2, 0x735, 2, 0x73a, 1, 0x73d, 1, 0x73f, 3, 0x743, 1, 0x745, 1, 0x747, 1,
    0x749, 2, 0x7eb, 7, 0x7f3, 1, 0x816, 4, 0x81b, 9, 0x825, 3, 0x829, 5, 0x951, 1, 0x953, 2,
    0xf82, 2, 0xf86, 2, 0x135d, 3, 0x17dd, 1, 0x193a, 1, 0x1a17, 1, 0x1a75, 8, 0x1b6b, 1, 0x1b6d,
    7, 0x1cd0, 3, 0x1cda, 2, 0x1ce0, 1, 0x1dc0, 2, 0x1dc3, 7, 0x1dcb, 2, 0x1dd1, 22, 0x1dfe, 1,
    0x20d0, 2, 0x20d4, 4, 0x20db, 2, 0x20e1, 1, 0x20e7, 1, 0x20e9, 1, 0x20f0, 1, 0x2cef, 3, 0x2de0,
    32, 0xa66f, 1, 0xa67c, 2, 0xa6f0, 2, 0xa8e0, 18, 0xaab0, 1, 0xaab2, 2, 0xaab7, 2, 0xaabe, 2,
    0xaac1, 1, 0xfe20, 7, 0x10a0f, 1, 0x10a38, 1, 0x1d185, 5, 0x1d1aa, 4, 0x1d242, 3,
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::Read;

    use super::*;

    /// What the terminal makes of the sequences: the keys of the first, and the data.
    fn received(sequences: &[String]) -> (String, Vec<u8>) {
        let mut data = String::new();
        let mut first = None;
        for (i, sequence) in sequences.iter().enumerate() {
            let body = sequence.strip_prefix("\x1b_G").unwrap();
            let (keys, piece) = body
                .strip_suffix("\x1b\\")
                .unwrap()
                .split_once(';')
                .unwrap();
            let more = i + 1 < sequences.len();
            assert!(keys.ends_with(if more { "m=1" } else { "m=0" }), "{keys}");
            assert!(piece.len() <= 4096);
            first.get_or_insert(keys.to_string());
            data += piece;
        }
        (first.unwrap(), STANDARD.decode(data).unwrap())
    }

    #[test]
    fn an_image_arrives_as_it_was_sent() {
        let pixels: Vec<u8> = (0..60 * 40 * 4_u32).map(|i| (i * 7 % 251) as u8).collect();
        let sent = sequences(&pixels, 60, (6, 2), 9, false);
        assert!(sent.len() > 1);
        let (keys, data) = received(&sent);
        assert_eq!(keys, "q=2,i=9,a=T,U=1,f=32,t=d,s=60,v=40,c=6,r=2,m=1");
        assert_eq!(data, pixels);
        let (keys, data) = received(&sequences(&pixels, 60, (6, 2), 9, true));
        assert!(keys.contains("f=32,o=z,t=d,s=60,v=40"), "{keys}");
        let mut unpacked = Vec::new();
        flate2::read::ZlibDecoder::new(&data[..])
            .read_to_end(&mut unpacked)
            .unwrap();
        assert_eq!(unpacked, pixels);
    }

    #[test]
    fn placeholders_name_image_row_and_column() {
        let area = Rect::new(1, 1, 3, 2);
        let mut buffer = Buffer::empty(Rect::new(0, 0, 5, 4));
        place(&mut buffer, area, 0x01_0a_0b_0c, Some("send"));
        let symbol = |x, y| buffer[(x, y)].symbol().to_string();
        assert_eq!(symbol(1, 1), "send\u{10eeee}\u{305}\u{305}\u{30d}");
        assert_eq!(symbol(2, 1), "\u{10eeee}");
        assert_eq!(symbol(1, 2), "\u{10eeee}\u{30d}\u{305}\u{30d}");
        assert_eq!((symbol(0, 1), symbol(4, 1)), (" ".into(), " ".into()));
        assert_eq!(buffer[(3, 2)].fg, Color::Rgb(0x0a, 0x0b, 0x0c));
    }

    #[test]
    fn as_many_rows_as_there_are_marks() {
        let marks = [0, 1, 2, 3, 4, 5, 296].map(diacritic);
        let kitty = [
            '\u{305}',
            '\u{30d}',
            '\u{30e}',
            '\u{310}',
            '\u{312}',
            '\u{33d}',
            '\u{1d244}',
        ];
        assert_eq!(marks, kitty.map(Some));
        assert_eq!(diacritic(297), None);
        let mut buffer = Buffer::empty(Rect::new(0, 0, 2, 300));
        let area = buffer.area;
        place(&mut buffer, area, 1, None);
        assert!(buffer[(0, 296)].symbol().starts_with(PLACEHOLDER));
        assert_eq!(buffer[(0, 297)].symbol(), " ");
    }
}
