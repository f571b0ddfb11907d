//! Checks the terminal, as far as it can be detected.

use super::Finding;
use nearmiss_base::system::Terminal;

const AREA: &str = "terminal";

pub fn look(terminal: &Terminal) -> Vec<Finding> {
    let said = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let mut found = vec![
        kind(said("TERM")),
        size(terminal),
        colours(terminal, &said),
        locale(terminal, &said),
    ];
    if terminal.size.is_some() {
        found.push(background(terminal));
    }
    found.push(Finding::ok(
        AREA,
        "mouse and clipboard (OSC 52) support cannot be detected; click in the workbench, or copy something with y, to test; `mouse = false` in config.toml leaves the mouse to the terminal",
    ));
    found
}

fn kind(term: Option<String>) -> Finding {
    match term.as_deref() {
        Some("dumb") => Finding::problem(
            AREA,
            "TERM is `dumb`: the terminal cannot move its cursor",
            "the workbench cannot open; commands work",
        ),
        Some(term) => Finding::ok(AREA, format!("TERM is `{term}`")),
        None if cfg!(windows) => Finding::ok(AREA, "TERM is not set, which is usual here"),
        None => Finding::warning(
            AREA,
            "TERM is not set",
            "set it as your terminal's manual says",
        ),
    }
}

fn size(terminal: &Terminal) -> Finding {
    let (columns, rows) = terminal.least;
    match terminal.size {
        Some((c, r)) if c < columns || r < rows => Finding::problem(
            AREA,
            format!("{c} columns and {r} rows"),
            format!(
                "the workbench needs {columns} and {rows}: make the window larger or the font smaller"
            ),
        ),
        Some((c, r)) => Finding::ok(AREA, format!("{c} columns and {r} rows")),
        None => Finding::warning(
            AREA,
            "standard output is not a terminal: size and background unknown",
            "run `nearmiss doctor` in the terminal you use",
        ),
    }
}

fn colours(terminal: &Terminal, said: &dyn Fn(&str) -> Option<String>) -> Finding {
    let why = ["NO_COLOR", "COLORTERM", "TERM"]
        .iter()
        .find_map(|name| Some(format!("{name} is `{}`", said(name)?)))
        .unwrap_or_else(|| "no further hints".into());
    match terminal.colours {
        "true" => Finding::ok(AREA, format!("all colours ({why})")),
        "none" if said("NO_COLOR").is_some() => {
            Finding::ok(AREA, format!("colours disabled ({why})"))
        }
        "none" => Finding::warning(
            AREA,
            format!("no colours ({why})"),
            "everything works without colours; if the terminal has colours, set TERM accordingly",
        ),
        few => Finding::warning(
            AREA,
            format!("{few} colours ({why})"),
            "theme colours are rounded; if the terminal supports true colour, set COLORTERM=truecolor",
        ),
    }
}

fn locale(terminal: &Terminal, said: &dyn Fn(&str) -> Option<String>) -> Finding {
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"]
        .iter()
        .find_map(|name| Some(format!("{name} is `{}`", said(name)?)))
        .unwrap_or_else(|| "no locale is set".into());
    if terminal.unicode {
        Finding::ok(AREA, format!("Unicode ({locale})"))
    } else {
        Finding::warning(
            AREA,
            format!("ASCII only ({locale})"),
            "set LANG to a UTF-8 locale, or `glyphs = \"unicode\"` in config.toml if the font has Braille",
        )
    }
}

fn background(terminal: &Terminal) -> Finding {
    match terminal.dark {
        Some(true) => Finding::ok(AREA, "the background is dark"),
        Some(false) => Finding::ok(AREA, "the background is light"),
        None => Finding::warning(
            AREA,
            "unknown background, assumed dark",
            "set `theme = \"light\"` in config.toml if it is light",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::State;
    use super::*;

    fn terminal() -> Terminal {
        Terminal {
            size: Some((80, 24)),
            least: (80, 24),
            colours: "true",
            unicode: true,
            dark: Some(true),
        }
    }

    #[test]
    fn what_does_not_do_is_said() {
        let none = |_: &str| None;
        assert_eq!(size(&terminal()).state, State::Ok);
        let small = Terminal {
            size: Some((79, 24)),
            ..terminal()
        };
        assert_eq!(size(&small).state, State::Problem);
        assert_eq!(kind(Some("dumb".into())).state, State::Problem);
        let few = Terminal {
            colours: "16",
            unicode: false,
            dark: None,
            ..terminal()
        };
        assert_eq!(colours(&few, &none).state, State::Warning);
        assert_eq!(locale(&few, &none).state, State::Warning);
        assert_eq!(background(&few).state, State::Warning);
        let wished = Terminal {
            colours: "none",
            ..terminal()
        };
        let no_color = |name: &str| (name == "NO_COLOR").then(|| "1".to_string());
        assert_eq!(colours(&wished, &no_color).state, State::Ok);
    }
}
