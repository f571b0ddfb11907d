//! Highlighting by syntect, in the colours of the theme: Markdown, JSON, XML, and templates.
//!
//! The syntaxes are loaded in the background after the start; until then texts are plain.

mod answer;
mod template;

use std::str::FromStr;
use std::sync::OnceLock;

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};
use syntect::easy::HighlightLines;
use syntect::highlighting::{
    Color as Rgba, FontStyle, ScopeSelectors, StyleModifier, Theme as Scopes, ThemeItem,
    ThemeSettings,
};
use syntect::parsing::{SyntaxReference, SyntaxSet};

use crate::text::visible;
use crate::tui::theme::Theme;

pub use answer::answer;
pub use template::template;

static SYNTAXES: OnceLock<SyntaxSet> = OnceLock::new();

/// What a text is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// Markdown.
    Markdown,
    /// JSON.
    Json,
    /// XML.
    Xml,
}

impl Language {
    fn syntax(self, set: &SyntaxSet) -> &SyntaxReference {
        let ending = match self {
            Self::Markdown => "md",
            Self::Json => "json",
            Self::Xml => "xml",
        };
        set.find_syntax_by_extension(ending)
            .unwrap_or_else(|| set.find_syntax_plain_text())
    }
}

/// Loads the syntaxes; takes some ten milliseconds, once.
pub fn load() {
    SYNTAXES.get_or_init(SyntaxSet::load_defaults_newlines);
}

/// Whether the syntaxes are there.
#[must_use]
pub fn is_loaded() -> bool {
    SYNTAXES.get().is_some()
}

/// A text of many lines, safe to show, highlighted as Markdown once the syntaxes are loaded.
#[must_use]
pub fn markdown(text: &str, theme: &Theme) -> Text<'static> {
    Text::from(lines(Language::Markdown, text.lines(), theme))
}

/// Lines that follow each other, safe to show, highlighted once the syntaxes are loaded. Longer ones are plain: to
/// highlight them would take too long.
#[must_use]
pub fn lines<'t>(
    language: Language,
    lines: impl Iterator<Item = &'t str>,
    theme: &Theme,
) -> Vec<Line<'static>> {
    let lines = lines.map(visible);
    let Some(set) = SYNTAXES.get() else {
        return lines
            .map(|l| Line::styled(l.into_owned(), theme.base()))
            .collect();
    };
    let colors = Colors::of(theme);
    let scopes = scopes(&|i| Rgba {
        r: i,
        g: 0,
        b: 0,
        a: 255,
    });
    let mut highlighter = HighlightLines::new(language.syntax(set), &scopes);
    let line = |line: std::borrow::Cow<'_, str>| {
        if line.len() > LONGEST {
            return Line::styled(line.into_owned(), theme.base());
        }
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
            Err(_) => Line::styled(line.into_owned(), theme.base()),
        }
    };
    lines.map(line).collect()
}

/// Lines are highlighted up to here, bytes.
const LONGEST: usize = 20_000;

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
    let rules: [(&str, u8, FontStyle); 8] = [
        ("markup.heading", 1, FontStyle::BOLD),
        ("markup.bold", 0, FontStyle::BOLD),
        ("markup.italic", 0, FontStyle::ITALIC),
        ("markup.raw, string", 2, FontStyle::empty()),
        ("constant.numeric, constant.language", 3, FontStyle::empty()),
        ("comment, punctuation.definition", 4, FontStyle::empty()),
        ("meta.mapping.key string, keyword", 5, FontStyle::empty()),
        ("entity.name.tag", 1, FontStyle::empty()),
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
