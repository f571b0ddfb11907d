//! Theme previews for `nearmiss config themes`.

use std::path::Path;

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use super::{ColorDepth, Named, ROLES, Theme, ansi, color};
use crate::user_file::first;
use nearmiss_base::system::pad_end;
use nearmiss_scene::description::visible;
use nearmiss_settings::ThemeFile;

/// A list of all themes, or everything about the one called `name`, in the colours of the terminal.
///
/// Without a terminal to show it, `depth` is nothing and the text is plain.
///
/// # Errors
/// The theme does not exist, or its file is invalid: with file, line and key.
pub fn preview(
    name: Option<&str>,
    folder: &Path,
    depth: Option<ColorDepth>,
) -> Result<String, String> {
    let styled = depth.is_some();
    let shown = |line: &Line<'_>| {
        if styled {
            ansi::line(line)
        } else {
            line.to_string()
        }
    };
    let depth = depth.unwrap_or(ColorDepth::None);
    let lines = match name {
        None => list(folder, depth),
        Some(name) => {
            let theme = Theme::load(name, folder, true)?;
            whole(&theme, depth)
        }
    };
    let lines = lines
        .iter()
        .map(|line| shown(line).trim_end().to_string() + "\n");
    Ok(lines.collect())
}

fn list(folder: &Path, depth: ColorDepth) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for Named { name, file, theme } in Theme::all(folder) {
        let from = file.map_or("shipped".into(), |file| visible(&file).into_owned());
        match theme {
            Ok(theme) => {
                let ground = if theme.dark { "dark" } else { "light" };
                let about = format!("  for {ground} backgrounds, {from}");
                let theme = Theme(theme).at_depth(depth);
                let bold = theme.base().add_modifier(Modifier::BOLD);
                lines.push(Line::from(vec![
                    Span::styled(visible(&name).into_owned(), bold),
                    Span::styled(about, Style::new().fg(theme.dim)),
                ]));
                lines.extend(sample(&theme));
            }
            Err(mistakes) => {
                lines.push(Line::from(format!("{}  cannot be used", visible(&name))));
                lines.push(Line::from(format!("  {}", first(&mistakes))));
            }
        }
        lines.push(Line::default());
    }
    let pairs: Vec<&str> = ThemeFile::pairs().collect();
    lines.push(Line::from(format!(
        "Set one in config.toml: `theme = \"NAME\"`. {} follow the terminal's background.",
        pairs.join(", ")
    )));
    lines
}

/// A few words and signs as they stand in the workbench.
fn sample(theme: &Theme) -> Vec<Line<'static>> {
    let span = |text: &'static str, color: Color| Span::styled(text, Style::new().fg(color));
    let selected = Line::from(vec![Span::styled(" ▸ selected line 0X ", theme.selected())]);
    let mut upper = vec![
        Span::raw("  "),
        span("text ", theme.text),
        span("dim ", theme.dim),
    ];
    upper.extend([span("title ", theme.title), span("key ", theme.accent)]);
    upper.extend(selected.spans);
    let lower = vec![
        Span::raw("  "),
        span("collision ", theme.danger),
        span("near miss ", theme.danger_medium),
        span("= agrees ", theme.agree),
        span("≠ differs ", theme.disagree),
        span("▶ ego ", theme.ego),
        span("▭ 302 ", theme.obstacle),
        span("▬ parked ", theme.static_obstacle),
        span("▭ 301 picked ", theme.picked),
    ];
    let lanes = vec![
        Span::raw("  "),
        span("──── ", theme.lane),
        span("- - - ", theme.lane_dashed),
        span("··· ", theme.trail),
        span("··· ", theme.ego_trail),
        span("╌╌ ", theme.predicted),
        span("▒▒ ", theme.occupancy),
        span("├─┤ ", theme.tape),
        span("━━ ", theme.attacker),
        span("△ ", theme.sign),
        span("● ", theme.light_red),
        span("● ", theme.light_amber),
        span("● ", theme.light_green),
    ];
    vec![Line::from(upper), Line::from(lower), Line::from(lanes)]
}

/// Every role of a theme: its name in its colour, the colour of the file and the one that the terminal shows.
fn whole(theme: &Theme, depth: ColorDepth) -> Vec<Line<'static>> {
    let shown = theme.clone().at_depth(depth);
    let ground = if theme.dark { "dark" } else { "light" };
    let mut lines = vec![
        Line::from(format!(
            "{}, for {ground} backgrounds",
            visible(&theme.name)
        )),
        Line::default(),
    ];
    lines.extend(sample(&shown));
    lines.push(Line::default());
    let widest = ROLES.iter().map(|role| role.width()).max().unwrap_or(0);
    for role in ROLES {
        let (Some(said), Some(color)) = (theme.role(role), shown.role(role)) else {
            continue;
        };
        let style = Style::new().fg(color);
        let reversed = style.add_modifier(Modifier::REVERSED);
        let value = match (color == said, said) {
            (true, Color::Reset) => here(said),
            (true, _) => said.to_string(),
            (false, _) => format!("{said}, shown as {}", here(color)),
        };
        lines.push(Line::from(vec![
            Span::styled("    ", reversed),
            Span::styled(format!(" {}  ", pad_end(role, widest)), style),
            Span::raw(value),
        ]));
    }
    lines
}

/// A colour as this terminal has it.
fn here(color: Color) -> String {
    match (color, color::components(color)) {
        (Color::Reset, _) => "the terminal's own".into(),
        (Color::Indexed(index), Some([r, g, b])) => format!("{index} (#{r:02X}{g:02X}{b:02X})"),
        (color, _) => color.to_string(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn previews_have_the_colours_of_the_terminal_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("odd\u{1b}[2J.toml");
        std::fs::write(broken, "dark = 3\n").unwrap();
        for (depth, sign, others) in [
            (ColorDepth::True, "\x1b[38;2;", vec!["\x1b[38;5"]),
            (ColorDepth::Indexed, "\x1b[38;5;", vec!["\x1b[38;2"]),
            (
                ColorDepth::Sixteen,
                "\x1b[91m",
                vec!["\x1b[38;2", "\x1b[38;5"],
            ),
            (
                ColorDepth::None,
                "selected line",
                vec!["\x1b[38;2", "\x1b[38;5", "\x1b[9", "\x1b[3"],
            ),
        ] {
            let all = preview(None, folder.path(), Some(depth)).unwrap();
            let one = preview(Some("colorblind"), folder.path(), Some(depth)).unwrap();
            for text in [&all, &one] {
                assert!(text.contains(sign), "{depth:?}: {text:?}");
                assert!(
                    others.iter().all(|o| !text.contains(o)),
                    "{depth:?}: {text:?}"
                );
                assert!(!text.contains("\x1b[2J"), "{text:?}");
            }
            for name in ThemeFile::shipped().chain(ThemeFile::pairs()) {
                assert!(all.contains(name));
            }
            assert!(all.contains("dark must be true or false"), "{all}");
            assert!(ROLES.iter().all(|role| one.contains(role)));
        }
        let plain = preview(None, folder.path(), None).unwrap();
        assert!(plain.contains("selected line") && !plain.contains('\x1b'));
        assert!(preview(Some("none"), folder.path(), Some(ColorDepth::True)).is_err());
    }
}
