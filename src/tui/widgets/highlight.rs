//! Highlighting of Markdown by syntect, in the colours of the theme.
//!
//! The syntaxes are loaded in the background after the start; until then texts are plain.

use std::str::FromStr;
use std::sync::{Arc, OnceLock};

use edtui::SyntaxHighlighter;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};
use syntect::easy::HighlightLines;
use syntect::highlighting::{
    Color as Rgba, FontStyle, ScopeSelectors, StyleModifier, Theme as Scopes, ThemeItem, ThemeSet,
    ThemeSettings,
};
use syntect::parsing::{SyntaxReference, SyntaxSet};

use crate::text::visible;
use crate::tui::theme::Theme;

static SYNTAXES: OnceLock<(Arc<SyntaxSet>, SyntaxReference)> = OnceLock::new();

/// Loads the syntaxes; takes some ten milliseconds, once.
pub fn load() {
    SYNTAXES.get_or_init(|| {
        let set = SyntaxSet::load_defaults_newlines();
        let markdown = set
            .find_syntax_by_extension("md")
            .unwrap_or_else(|| set.find_syntax_plain_text());
        let markdown = markdown.clone();
        (Arc::new(set), markdown)
    });
}

/// A text of many lines, safe to show, highlighted as Markdown once the syntaxes are loaded.
#[must_use]
pub fn markdown(text: &str, theme: &Theme) -> Text<'static> {
    let text = visible(text);
    let Some((set, syntax)) = SYNTAXES.get() else {
        return Text::styled(text.into_owned(), theme.base());
    };
    let colors = Colors::of(theme);
    let scopes = scopes(&|i| Rgba {
        r: i,
        g: 0,
        b: 0,
        a: 255,
    });
    let mut highlighter = HighlightLines::new(syntax, &scopes);
    let lines = text.lines().map(|line| {
        // The syntaxes expect lines to end.
        let ended = format!("{line}\n");
        match highlighter.highlight_line(&ended, set) {
            Ok(pieces) => Line::from_iter(pieces.into_iter().map(|(style, piece)| {
                let mut ours = Style::new().fg(colors.0[usize::from(style.foreground.r).min(6)]);
                if style.font_style.contains(FontStyle::BOLD) {
                    ours = ours.add_modifier(Modifier::BOLD);
                }
                if style.font_style.contains(FontStyle::ITALIC) {
                    ours = ours.add_modifier(Modifier::ITALIC);
                }
                Span::styled(piece.trim_end_matches('\n').to_string(), ours)
            })),
            Err(_) => Line::styled(line.to_string(), theme.base()),
        }
    });
    Text::from_iter(lines)
}

/// The editor's highlighter; only for themes of true colours, which are all that the editor takes.
#[must_use]
pub fn editor(theme: &Theme) -> Option<SyntaxHighlighter> {
    let (set, syntax) = SYNTAXES.get()?;
    let colors = Colors::of(theme);
    let mut rgb = Vec::new();
    for color in colors.0 {
        let Color::Rgb(r, g, b) = color else {
            return None;
        };
        rgb.push(Rgba { r, g, b, a: 255 });
    }
    let scopes = scopes(&|i| rgb[usize::from(i)]);
    Some(SyntaxHighlighter::with_sets(
        scopes,
        Arc::new(ThemeSet::new()),
        syntax.clone(),
        set.clone(),
    ))
}

/// The colours in use, by number.
struct Colors([Color; 7]);

impl Colors {
    fn of(theme: &Theme) -> Self {
        Self([
            theme.text,
            theme.accent,
            theme.safe,
            theme.warning,
            theme.dim,
            theme.ego,
            theme.picked,
        ])
    }
}

/// What is coloured how: scopes of the syntaxes, with numbers of [`Colors`].
fn scopes(color: &dyn Fn(u8) -> Rgba) -> Scopes {
    let rules: [(&str, u8, FontStyle); 7] = [
        ("markup.heading", 1, FontStyle::BOLD),
        ("markup.bold", 0, FontStyle::BOLD),
        ("markup.italic", 0, FontStyle::ITALIC),
        ("markup.raw, string", 2, FontStyle::empty()),
        ("constant.numeric, constant.language", 3, FontStyle::empty()),
        ("comment, punctuation.definition", 4, FontStyle::empty()),
        ("meta.mapping.key string, keyword", 5, FontStyle::empty()),
    ];
    let items = rules.iter().filter_map(|(selector, number, style)| {
        Some(ThemeItem {
            scope: ScopeSelectors::from_str(selector).ok()?,
            style: StyleModifier {
                foreground: Some(color(*number)),
                background: None,
                font_style: Some(*style),
            },
        })
    });
    Scopes {
        scopes: items.collect(),
        settings: ThemeSettings {
            foreground: Some(color(0)),
            ..ThemeSettings::default()
        },
        ..Scopes::default()
    }
}
