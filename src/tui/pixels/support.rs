//! What a terminal says about images: which it shows, and how large its cells are.

use crate::background::STATUS;
use crate::pixels::{Encoder, Protocol};

/// Asks for kitty's images.
const KITTY: &str = "\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\";
/// The same pixel, compressed.
const COMPRESSED: &str = "\x1b_Gi=32,s=1,v=1,a=q,t=d,f=24,o=z;eJxjYGAAAAADAAE=\x1b\\";
/// Asks what the terminal can do (DA1); 4 is sixel.
const ATTRIBUTES: &str = "\x1b[c";
/// Asks for the pixels of a cell (XTWINOPS).
const CELL: &str = "\x1b[16t";

/// Values of `TERM_PROGRAM` of terminals that show iTerm2's images and do not say so.
const AS_ITERM: [&str; 9] = [
    "iTerm",
    "WezTerm",
    "mintty",
    "vscode",
    "Tabby",
    "Hyper",
    "rio",
    "Bobcat",
    "WarpTerminal",
];

/// A terminal before it is asked: what its environment tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Environment {
    /// Whether tmux stands between, so that everything has to be passed through.
    pub in_tmux: bool,
    /// Whether what it says about kitty's images and sixels is not to be relied on: WezTerm and Konsole place the
    /// former wrongly, and Konsole's sixels are faulty.
    as_iterm_only: bool,
    /// Whether it is known to show iTerm2's images.
    as_iterm: bool,
}

impl Environment {
    /// Reads the environment's variables.
    pub fn read(env: impl Fn(&str) -> Option<String>) -> Self {
        let value = |name| env(name).unwrap_or_default();
        let is_set = |name| !value(name).is_empty();
        let program = value("TERM_PROGRAM");
        let in_tmux = value("TERM").starts_with("tmux") || program == "tmux";
        let outer = in_tmux && (is_set("ITERM_SESSION_ID") || is_set("WEZTERM_EXECUTABLE"));
        let named = AS_ITERM.iter().any(|known| program.contains(known));
        Self {
            in_tmux,
            as_iterm_only: is_set("WEZTERM_EXECUTABLE") || is_set("KONSOLE_VERSION"),
            as_iterm: outer || named || value("LC_TERMINAL").contains("iTerm"),
        }
    }

    /// What to send to the terminal.
    pub fn question(self) -> String {
        let asked = if self.as_iterm_only {
            [CELL, STATUS].concat()
        } else {
            [KITTY, COMPRESSED, ATTRIBUTES, CELL, STATUS].concat()
        };
        super::passed(&asked, self.in_tmux)
    }

    /// What the answers mean; `None` where the terminal shows no images.
    pub fn encoder(self, answers: &str) -> Option<Encoder> {
        let (mut kitty, mut compress, mut sixel, mut cell) = (false, false, false, None);
        for answer in answers.split('\x1b') {
            kitty |= answer == "_Gi=31;OK";
            compress |= answer == "_Gi=32;OK";
            if let Some((attributes, _)) = answer.strip_prefix("[?").and_then(|a| a.split_once('c'))
            {
                sixel |= attributes.split(';').any(|attribute| attribute == "4");
            }
            if let Some((size, _)) = answer.strip_prefix("[6;").and_then(|a| a.split_once('t')) {
                let size = size.split_once(';');
                let size = size.and_then(|(h, w)| Some((w.parse().ok()?, h.parse().ok()?)));
                cell = size.filter(|(width, height)| *width > 0 && *height > 0);
            }
        }
        let protocol = if kitty {
            Protocol::Kitty { compress }
        } else if sixel {
            Protocol::Sixel
        } else if self.as_iterm {
            Protocol::Iterm
        } else {
            return None;
        };
        Some(Encoder {
            protocol,
            cell: cell?,
            in_tmux: self.in_tmux,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(pairs: &[(&str, &str)]) -> Environment {
        Environment::read(|name| {
            let pair = pairs.iter().find(|(n, _)| *n == name);
            pair.map(|(_, value)| (*value).to_string())
        })
    }

    #[test]
    fn the_best_of_what_a_terminal_says_is_used() {
        let plain = environment(&[("TERM", "xterm-256color")]);
        let said = |answers: &str| plain.encoder(answers).map(|e| (e.protocol, e.cell));
        let all = "\x1b_Gi=31;OK\x1b\\\x1b_Gi=32;OK\x1b\\\x1b[?64;4c\x1b[6;14;7t\x1b[0n";
        let kitty = Protocol::Kitty { compress: true };
        assert_eq!(said(all), Some((kitty, (7, 14))));
        let refused = all.replace("32;OK", "32;EINVAL:bad");
        let kitty = Protocol::Kitty { compress: false };
        assert_eq!(said(&refused), Some((kitty, (7, 14))));
        let sixel = "typed\x1b[?62;4;22cmore\x1b[6;20;10t\x1b[0n";
        assert_eq!(said(sixel), Some((Protocol::Sixel, (10, 20))));
        assert_eq!(said("\x1b[?64;14c\x1b[6;20;10t\x1b[0n"), None);
        assert_eq!(said("\x1b[?62;4c\x1b[0n"), None, "of what size?");
        assert_eq!(said("\x1b[?62;4c\x1b[6;0;0t\x1b[0n"), None);
        assert_eq!(said("\x1bhonkey\x1btonkey\x1b[42\x1b\\"), None);
    }

    #[test]
    fn some_terminals_are_known_by_their_names() {
        let cell = "\x1b[6;20;10t\x1b[0n";
        let protocol =
            |pairs: &[(&str, &str)]| environment(pairs).encoder(cell).map(|e| e.protocol);
        assert_eq!(
            protocol(&[("TERM_PROGRAM", "vscode")]),
            Some(Protocol::Iterm)
        );
        assert_eq!(
            protocol(&[("LC_TERMINAL", "iTerm2")]),
            Some(Protocol::Iterm)
        );
        assert_eq!(protocol(&[("TERM", "xterm-kitty")]), None, "kitty answers");
        let tmux = [("TERM", "tmux-256color"), ("ITERM_SESSION_ID", "1")];
        assert_eq!(protocol(&tmux), Some(Protocol::Iterm));
        assert_eq!(protocol(&tmux[1..]), None);
    }

    #[test]
    fn only_what_can_be_relied_on_is_asked() {
        let plain = environment(&[]).question();
        assert!(plain.starts_with(KITTY) && plain.ends_with(STATUS));
        let wezterm = [("WEZTERM_EXECUTABLE", "w"), ("TERM_PROGRAM", "WezTerm")];
        assert_eq!(environment(&wezterm).question(), "\x1b[16t\x1b[5n");
        let tmux = [("TERM_PROGRAM", "tmux"), ("KONSOLE_VERSION", "1")];
        let passed = "\x1bPtmux;\x1b\x1b[16t\x1b\x1b[5n\x1b\\";
        assert_eq!(environment(&tmux).question(), passed);
    }
}
