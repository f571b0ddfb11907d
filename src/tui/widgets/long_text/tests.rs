//! Long texts: grown as if read at once, and every part where it is in the whole.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Text;
use ratatui::widgets::Widget;

use crate::widgets::highlight::load;
use crate::widgets::long_text::*;

const TEXT: &str = "# Why\n\nObstacle **7** is in front of the ego, which is *slower* than it is, ü and all.\n\
    ```json\n{\n \"a\": \"}\",\n \"b\": [1, 2]\n}\n```\n| a | b |\n|--|-:|\n| **long** | 3 |\n\n- one\n- two `raw`\n\n{\"open\": [\n 1,";

fn all(reading: &mut Reading, theme: &Theme) -> Vec<Line<'static>> {
    let rows = reading.rows();
    reading.seen(0, rows, &MarkedClaims::default(), theme).0
}

#[test]
fn what_grows_is_as_if_it_were_read_at_once() {
    load();
    let theme = Theme::default_theme();
    let none = MarkedClaims::default();
    for (raw, unfold) in [(false, false), (false, true), (true, false)] {
        let mode = ReadingMode {
            raw,
            unfold,
            ..ReadingMode::default()
        };
        let mut growing = Reading::answer();
        growing.show_as(mode.clone());
        for end in (0..=TEXT.len()).filter(|&end| TEXT.is_char_boundary(end)) {
            let text = &TEXT[..end];
            growing.follow(text, &none, 20, &theme);
            let mut fresh = Reading::answer();
            fresh.show_as(mode.clone());
            fresh.follow(text, &none, 20, &theme);
            assert_eq!(growing.rows(), fresh.rows(), "{text}");
            assert_eq!(all(&mut growing, &theme), all(&mut fresh, &theme), "{text}");
        }
        let lines = all(&mut growing, &theme);
        let text: Vec<String> = lines.iter().map(ToString::to_string).collect();
        let text = text.join("\n");
        let folded = text.contains("▸ JSON, 4 lines\n");
        assert_eq!(folded, !raw && !unfold, "{text}");
        assert_eq!(text.contains("\"a\": \"}\""), !folded, "{text}");
        assert_eq!(text.contains("**7**"), raw, "{text}");
        assert_eq!(text.contains("• one"), !raw, "{text}");
        let colors = lines.into_iter().flat_map(|l| l.spans);
        let colors: std::collections::HashSet<_> = colors.map(|s| s.style.fg).collect();
        assert!(colors.len() > 2, "{colors:?}");
        // Another text, another width.
        growing.follow("short", &none, 5, &theme);
        assert_eq!((growing.rows(), all(&mut growing, &theme).len()), (1, 1));
    }
}

#[test]
fn every_part_of_it_is_where_it_is_in_the_whole() {
    let theme = Theme::default_theme();
    let none = MarkedClaims::default();
    let mut reading = Reading::answer();
    reading.follow(TEXT, &none, 17, &theme);
    assert!(reading.rows() > 9, "some lines are broken");
    let area = Rect::new(0, 0, 17, 4);
    let show = |lines: Vec<Line<'static>>, above: usize| {
        let mut buffer = Buffer::empty(area);
        let words = Paragraph::new(Text::from(lines)).wrap(Wrap { trim: false });
        let above = u16::try_from(above).unwrap_or(u16::MAX);
        words.scroll((above, 0)).render(area, &mut buffer);
        buffer
    };
    let whole = all(&mut reading, &theme);
    for top in 0..reading.rows() {
        let (lines, above) = reading.seen(top, 4, &none, &theme);
        assert!(lines.len() <= 4, "{top}");
        assert_eq!(show(lines, above), show(whole.clone(), top), "{top}");
    }
}
