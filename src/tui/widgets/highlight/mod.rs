//! Syntax highlighting by syntect in the theme's colours: Markdown, JSON, XML and templates.
//!
//! Syntaxes load in the background after the start; until then text is plain.

mod answer;
mod template;

use std::borrow::Cow;
use std::str::FromStr;
use std::sync::OnceLock;

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};
use syntect::highlighting::{
    Color as Rgba, FontStyle, HighlightIterator, HighlightState, Highlighter, ScopeSelectors,
    StyleModifier, Theme as Scopes, ThemeItem, ThemeSettings,
};
use syntect::parsing::{ParseState, ScopeStack, SyntaxReference, SyntaxSet};

use crate::theme::Theme;
use nearmiss_scene::description::visible;

pub use answer::{AnswerPainter, JsonParts};
pub use template::template;

static SYNTAXES: OnceLock<SyntaxSet> = OnceLock::new();

/// Language of a text.
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
    let mut painter = Painter::new(language);
    lines.map(|line| painter.line(line, theme)).collect()
}

/// Highlights one line after the other, each as those before it make it.
#[derive(Debug, Clone)]
pub struct Painter {
    language: Language,
    /// `None` before the first line.
    state: Option<(ParseState, HighlightState)>,
}

impl Painter {
    /// For a text that begins.
    #[must_use]
    pub fn new(language: Language) -> Self {
        Self {
            language,
            state: None,
        }
    }

    /// The next line, safe to show, highlighted once the syntaxes are loaded.
    pub fn line(&mut self, line: &str, theme: &Theme) -> Line<'static> {
        let line = visible(line);
        let plain = |line: Cow<'_, str>| Line::styled(line.into_owned(), theme.base());
        let Some(set) = SYNTAXES.get() else {
            return plain(line);
        };
        if line.len() > LONGEST {
            return plain(line);
        }
        let highlighter = highlighter();
        let (parse, style) = self.state.get_or_insert_with(|| {
            let parse = ParseState::new(self.language.syntax(set));
            (parse, HighlightState::new(highlighter, ScopeStack::new()))
        });
        // The syntaxes expect lines to end.
        let ended = format!("{line}\n");
        let Ok(ops) = parse.parse_line(&ended, set) else {
            return plain(line);
        };
        let colors = Colors::of(theme);
        let pieces = HighlightIterator::new(style, &ops, &ended, highlighter);
        Line::from_iter(pieces.map(|(style, piece)| {
            let mut ours = Style::new().fg(colors.0[usize::from(style.foreground.r).min(6)]);
            if style.font_style.contains(FontStyle::BOLD) {
                ours = ours.add_modifier(Modifier::BOLD);
            }
            if style.font_style.contains(FontStyle::ITALIC) {
                ours = ours.add_modifier(Modifier::ITALIC);
            }
            Span::styled(piece.trim_end_matches('\n').to_string(), ours)
        }))
    }
}

/// The rules of [`scopes`], made once.
fn highlighter() -> &'static Highlighter<'static> {
    static SCOPES: OnceLock<Scopes> = OnceLock::new();
    static HIGHLIGHTER: OnceLock<Highlighter<'static>> = OnceLock::new();
    HIGHLIGHTER.get_or_init(|| Highlighter::new(SCOPES.get_or_init(scopes)))
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
fn scopes() -> Scopes {
    let color = |number| Rgba {
        r: number,
        g: 0,
        b: 0,
        a: 255,
    };
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
