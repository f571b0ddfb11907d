//! Syntax highlighting by syntect in the theme's colours: Markdown, JSON, XML and templates.
//!
//! Syntaxes load in the background after the start; until then text is plain.

use std::borrow::Cow;
use std::str::FromStr;
use std::sync::OnceLock;

use nearmiss_scene::description::visible;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};
use syntect::highlighting::{
    Color as Rgba, FontStyle, HighlightIterator, HighlightState, Highlighter, ScopeSelectors,
    StyleModifier, Theme as Scopes, ThemeItem, ThemeSettings,
};
use syntect::parsing::{ParseState, ScopeStack, SyntaxReference, SyntaxSet};

use crate::theme::Theme;

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
        if line.len() > MAX_HIGHLIGHTED_BYTES {
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
        let colors = Colors::new(theme);
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
const MAX_HIGHLIGHTED_BYTES: usize = 20_000;

/// The colours in use, by number.
struct Colors([Color; 7]);

impl Colors {
    fn new(theme: &Theme) -> Self {
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

/// Highlights an answer line by line: what is JSON in it as that, the rest as Markdown.
#[derive(Debug, Clone)]
pub struct AnswerPainter {
    parts: JsonParts,
    painter: Painter,
}

impl AnswerPainter {
    /// For a text that begins.
    #[must_use]
    pub fn new() -> Self {
        Self {
            parts: JsonParts::default(),
            painter: Painter::new(Language::Markdown),
        }
    }

    /// The next line, safe to show.
    pub fn line(&mut self, line: &str, theme: &Theme) -> Line<'static> {
        if let Some(language) = self.parts.begun_by(line) {
            self.painter = Painter::new(language);
        }
        self.painter.line(line, theme)
    }
}

/// The parts of an answer in their order. JSON begins with a brace or bracket that a line begins with, and ends
/// with the line in which they close; in fences or not. One that does not close yet is JSON to the end.
#[derive(Debug, Clone, Default)]
pub struct JsonParts {
    open: Option<BracketDepth>,
    /// Whether the line before closed a part.
    closed: bool,
    /// Whether the line before began one.
    began: bool,
}

impl JsonParts {
    /// Whether the next line is JSON.
    pub fn is_json(&mut self, line: &str) -> bool {
        let open = self.open.is_some();
        self.begun_by(line);
        open || self.began
    }

    /// Whether the last line began a part of JSON.
    #[must_use]
    pub fn begins(&self) -> bool {
        self.began
    }

    /// Whether no JSON is open.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open.is_none()
    }

    /// The language of the part that begins with the next line, if one does.
    fn begun_by(&mut self, line: &str) -> Option<Language> {
        let closed = std::mem::take(&mut self.closed);
        let begins =
            self.open.is_none() && line.trim_start().starts_with(['{', '[']) && !is_link(line);
        self.began = begins;
        if begins {
            self.open = Some(BracketDepth::default());
        }
        if let Some(depth) = &mut self.open
            && depth.closes(line)
        {
            self.open = None;
            self.closed = true;
        }
        match (begins, closed) {
            (true, _) => Some(Language::Json),
            (false, true) => Some(Language::Markdown),
            (false, false) => None,
        }
    }
}

/// Whether a line that begins with a bracket is a link or a box to tick of Markdown.
fn is_link(line: &str) -> bool {
    let line = line.trim();
    line.contains("](") || line.starts_with("[ ]") || line.starts_with("[x]")
}

/// How many braces and brackets are open.
#[derive(Debug, Clone, Default)]
struct BracketDepth {
    open: usize,
    string: bool,
}

impl BracketDepth {
    fn closes(&mut self, line: &str) -> bool {
        let mut escaped = false;
        for c in line.chars() {
            match c {
                _ if escaped => escaped = false,
                '\\' if self.string => escaped = true,
                '"' => self.string = !self.string,
                '{' | '[' if !self.string => self.open += 1,
                '}' | ']' if !self.string => self.open = self.open.saturating_sub(1),
                _ => {}
            }
        }
        // No string of JSON goes over a line.
        self.string = false;
        self.open == 0
    }
}

/// A style for every character of the lines, of which the first is number `from` of the file, from 0. Front matter
/// is seen only from the beginning on.
#[must_use]
pub fn template(text: &[&str], from: usize, theme: &Theme) -> Vec<Vec<Style>> {
    let mut fences = text
        .iter()
        .enumerate()
        .filter(|(_, l)| l.trim_end() == "+++")
        .map(|(at, _)| at);
    let front = match (from, fences.next(), fences.next()) {
        (0, Some(0), Some(end)) => end + 1,
        _ => 0,
    };
    let mut styles: Vec<Vec<Style>> = text[..front].iter().map(|l| toml(l, theme)).collect();
    let body = text[front..].iter().copied();
    for (line, source) in lines(Language::Markdown, body.clone(), theme)
        .into_iter()
        .zip(body)
    {
        let of_span = |span: &ratatui::text::Span<'_>| {
            let style = span.style;
            span.content.chars().map(|_| style).collect::<Vec<_>>()
        };
        let mut line: Vec<Style> = line.spans.iter().flat_map(of_span).collect();
        line.resize(source.chars().count(), theme.base());
        styles.push(line);
    }
    tags(&text[front..], &mut styles[front..], theme);
    styles
}

/// A line of front matter: keys, and what they are set to.
fn toml(line: &str, theme: &Theme) -> Vec<Style> {
    let dim = Style::new().fg(theme.dim);
    let all = line.chars().count();
    let trimmed = line.trim_start();
    if trimmed.starts_with(['#', '[', '+']) {
        return vec![dim; all];
    }
    let key = line.find('=').map_or(0, |at| line[..at].chars().count());
    let key_style = Style::new().fg(theme.ego);
    let value = Style::new().fg(theme.safe);
    (0..all)
        .map(|at| if at < key { key_style } else { value })
        .collect()
}

/// Marks of the template language: where they begin, where they end, and whether they are comments.
const TAGS: [(&str, &str, bool); 3] =
    [("{%", "%}", false), ("{{", "}}", false), ("{#", "#}", true)];

/// Colours tags and comments, which may go over lines.
fn tags(text: &[&str], styles: &mut [Vec<Style>], theme: &Theme) {
    let tag = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let comment = Style::new().fg(theme.dim).add_modifier(Modifier::ITALIC);
    let mut open: Option<(&str, bool)> = None;
    for (line, styles) in text.iter().zip(styles) {
        let chars: Vec<char> = line.chars().collect();
        let is = |at: usize, mark: &str| mark.chars().eq(chars.iter().skip(at).take(2).copied());
        let mut at = 0;
        while at < chars.len() {
            let mut taken = 1;
            // One that begins in another shows that the other was not closed.
            if !matches!(open, Some((_, true)))
                && let Some((_, end, comment)) = TAGS.iter().find(|(begin, ..)| is(at, begin))
            {
                open = Some((end, *comment));
                taken = 2;
            }
            if let Some((end, is_comment)) = open {
                if taken == 1 && is(at, end) {
                    taken = 2;
                    open = None;
                }
                let style = if is_comment { comment } else { tag };
                let last = (at + taken).min(styles.len());
                styles[at.min(last)..last].fill(style);
            }
            at += taken;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_found_in_fences_and_outside() {
        use Language::{Json, Markdown};
        let text = "# Why\n[a](b) is near\n```json\n{\n \"a\": \"}\",\n \"b\": [1]\n}\n```\nso\n{\"c\": 2}\n{\"d\":\n";
        let mut parts = JsonParts::default();
        let mut found: Vec<(Language, String)> = Vec::new();
        for line in text.split_inclusive('\n') {
            match (parts.begun_by(line), found.last_mut()) {
                (None, Some((_, part))) => part.push_str(line),
                (begun, _) => found.push((begun.unwrap_or(Markdown), line.into())),
            }
        }
        let found: Vec<(Language, &str)> = found.iter().map(|(l, p)| (*l, p.as_str())).collect();
        assert_eq!(
            found,
            [
                (Markdown, "# Why\n[a](b) is near\n```json\n"),
                (Json, "{\n \"a\": \"}\",\n \"b\": [1]\n}\n"),
                (Markdown, "```\nso\n"),
                (Json, "{\"c\": 2}\n"),
                (Json, "{\"d\":\n"),
            ]
        );
    }

    #[test]
    fn every_character_has_a_style_and_tags_stand_out() {
        let theme = Theme::default_theme();
        super::load();
        let text = "+++\nname = \"ä\"\n+++\n# Title {{ x }} b\n{# a\nb #} `c`\u{1b}";
        let lines: Vec<&str> = text.lines().collect();
        let styles = template(&lines, 0, &theme);
        for (line, styles) in lines.iter().zip(&styles) {
            assert_eq!(line.chars().count(), styles.len(), "{line}");
        }
        let color = |line: usize, at: usize| styles[line][at].fg;
        assert_eq!(color(1, 0), Some(theme.ego));
        assert_eq!(color(1, 8), Some(theme.safe));
        assert_eq!(color(3, 8), Some(theme.picked));
        assert_eq!(color(3, 14), Some(theme.picked));
        assert_eq!(color(3, 16), Some(theme.accent));
        assert_eq!(
            (color(4, 3), color(5, 0)),
            (Some(theme.dim), Some(theme.dim))
        );
        assert_ne!(color(5, 6), Some(theme.dim));
    }
}
