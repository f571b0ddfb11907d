//! Which paths a source file names: `use` declarations with nested groups, and paths written out in code.
//!
//! A small reader of tokens, not of the whole language: comments and text are passed over, and so is every item
//! under `#[cfg(test)]`.

use std::path::{Path, PathBuf};

/// A path that a file names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// Line in the file, from 1.
    pub line: usize,
    /// Where it leads.
    pub target: Target,
}

/// Where a path leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// Into the crate: its folder, and segments from its root.
    Inside(Vec<String>),
    /// Elsewhere, or to a name that is in scope.
    Outside(Vec<String>),
}

/// What the checker wants to know of a file.
#[derive(Debug, Default)]
pub struct Source {
    /// Every path it names outside its tests.
    pub named: Vec<Named>,
    /// Files that are modules for tests only.
    pub test_files: Vec<PathBuf>,
    /// Macros and plain names that it uses outside its tests, with their lines: `print!`, `stdout`.
    pub words: Vec<(usize, String)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Token {
    Word(String),
    Text(String),
    Mark(char),
}

type Tokens = Vec<(usize, Token)>;

/// Reads the source text of the file at `path` (relative to `src`).
pub fn read(path: &Path, text: &str) -> Source {
    let mut source = Source::default();
    let tokens = without_tests(tokens(text), path, &mut source.test_files);
    let module = module_of(path);
    let mut walk = Walk {
        tokens: &tokens,
        at: 0,
        children: children(&tokens),
        inline: Vec::new(),
        depth: 0,
        module,
        source: &mut source,
    };
    walk.all();
    source
}

/// The folder of a file's crate and its module path: `tui/views/map.rs` is `tui::views::map`.
pub fn module_of(path: &Path) -> Vec<String> {
    let mut parts: Vec<String> = path
        .with_extension("")
        .components()
        .map(|c| c.as_os_str().to_string_lossy().into_owned())
        .collect();
    if parts
        .last()
        .is_some_and(|last| last == "mod" || last == "lib")
    {
        parts.pop();
    }
    parts
}

fn tokens(text: &str) -> Tokens {
    let chars: Vec<char> = text.chars().collect();
    let mut found = Vec::new();
    let (mut at, mut line) = (0, 1);
    let get = |i: usize| chars.get(i).copied().unwrap_or('\0');
    while at < chars.len() {
        let begin = at;
        let token = match get(at) {
            '/' if get(at + 1) == '/' => {
                while at < chars.len() && get(at) != '\n' {
                    at += 1;
                }
                None
            }
            '/' if get(at + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (get(at), get(at + 1)) {
                        ('/', '*') => (depth, at) = (depth + 1, at + 2),
                        ('*', '/') => (depth, at) = (depth - 1, at + 2),
                        _ => at += 1,
                    }
                    if depth == 0 || at >= chars.len() {
                        break;
                    }
                }
                None
            }
            '"' => {
                at += 1;
                while at < chars.len() && get(at) != '"' {
                    at += if get(at) == '\\' { 2 } else { 1 };
                }
                at += 1;
                let end = at.saturating_sub(1).min(chars.len());
                Some(Token::Text(chars[begin + 1..end].iter().collect()))
            }
            '\'' => {
                // A character, or a lifetime.
                if get(at + 1) == '\\' {
                    at += 3;
                    while at < chars.len() && get(at) != '\'' {
                        at += 1;
                    }
                    at += 1;
                } else if get(at + 2) == '\'' {
                    at += 3;
                } else {
                    at += 1;
                }
                None
            }
            c if c.is_alphabetic() || c == '_' => {
                while get(at).is_alphanumeric() || get(at) == '_' {
                    at += 1;
                }
                let word: String = chars[begin..at].iter().collect();
                let mut hashes = 0;
                while get(at + hashes) == '#' {
                    hashes += 1;
                }
                if matches!(word.as_str(), "r" | "br" | "cr") && get(at + hashes) == '"' {
                    at += hashes + 1;
                    let closes = |i: usize| {
                        get(i) == '"' && (1..=hashes).all(|offset| get(i + offset) == '#')
                    };
                    while at < chars.len() && !closes(at) {
                        at += 1;
                    }
                    at += 1 + hashes;
                    None
                } else if word == "r" && hashes == 1 {
                    at += 1;
                    None
                } else {
                    Some(Token::Word(word))
                }
            }
            c => {
                at += 1;
                (!c.is_whitespace()).then_some(Token::Mark(c))
            }
        };
        found.extend(token.map(|t| (line, t)));
        line += chars[begin..at.min(chars.len())]
            .iter()
            .filter(|c| **c == '\n')
            .count();
    }
    found
}

const CFG_TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];

fn is(token: Option<&(usize, Token)>, text: &str) -> bool {
    match token {
        Some((_, Token::Word(word))) => word == text,
        Some((_, Token::Mark(mark))) => text.chars().eq([*mark]),
        _ => false,
    }
}

/// Leaves out every item under `#[cfg(test)]`.
fn without_tests(tokens: Tokens, path: &Path, test_files: &mut Vec<PathBuf>) -> Tokens {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let begins = |parts: &[&str], at: usize| {
            parts
                .iter()
                .enumerate()
                .all(|(i, part)| is(tokens.get(at + i), part))
        };
        if begins(&["#", "!", "[", "cfg", "(", "test", ")"], at) {
            return kept;
        }
        if !begins(&CFG_TEST, at) {
            kept.push(tokens[at].clone());
            at += 1;
            continue;
        }
        at += CFG_TEST.len();
        let mut named_file = None;
        while is(tokens.get(at), "#") {
            if begins(&["#", "[", "path", "="], at)
                && let Some((_, Token::Text(file))) = tokens.get(at + 4)
            {
                named_file = Some(file.clone());
            }
            at = closing(&tokens, at + 1);
        }
        let declaration = begins(&["use"], at) || begins(&["pub", "use"], at);
        if begins(&["mod"], at)
            && is(tokens.get(at + 2), ";")
            && let Some((_, Token::Word(name))) = tokens.get(at + 1)
        {
            let folder = path.parent().unwrap_or(Path::new(""));
            let own = match path.file_stem().and_then(|s| s.to_str()) {
                Some("mod" | "lib" | "main") | None => folder.to_path_buf(),
                Some(stem) => folder.join(stem),
            };
            match named_file {
                Some(file) => test_files.push(folder.join(file)),
                None => {
                    test_files.push(own.join(format!("{name}.rs")));
                    test_files.push(own.join(name).join("mod.rs"));
                }
            }
        }
        while at < tokens.len() {
            if is(tokens.get(at), ";") {
                at += 1;
                break;
            }
            let block = is(tokens.get(at), "{");
            if block || is(tokens.get(at), "(") || is(tokens.get(at), "[") {
                at = closing(&tokens, at);
                if block && !declaration {
                    break;
                }
            } else {
                at += 1;
            }
        }
    }
    kept
}

/// The place behind the bracket that closes the one at `open`.
fn closing(tokens: &Tokens, open: usize) -> usize {
    let mut depth = 0;
    for (at, (_, token)) in tokens.iter().enumerate().skip(open) {
        match token {
            Token::Mark('(' | '[' | '{') => depth += 1,
            Token::Mark(')' | ']' | '}') => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    tokens.len()
}

/// The modules a file declares: paths may begin with their names.
fn children(tokens: &Tokens) -> Vec<String> {
    let pairs = tokens
        .windows(3)
        .filter_map(|w| match (&w[0].1, &w[1].1, &w[2].1) {
            (Token::Word(word), Token::Word(name), Token::Mark(';' | '{')) if word == "mod" => {
                Some(name.clone())
            }
            _ => None,
        });
    pairs.collect()
}

struct Walk<'a> {
    tokens: &'a Tokens,
    at: usize,
    children: Vec<String>,
    /// Modules written inside the file, with the depth of braces they began at.
    inline: Vec<(usize, String)>,
    depth: usize,
    module: Vec<String>,
    source: &'a mut Source,
}

impl Walk<'_> {
    fn all(&mut self) {
        while let Some((line, token)) = self.tokens.get(self.at) {
            let line = *line;
            match token {
                Token::Mark('{') => self.depth += 1,
                Token::Mark('}') => {
                    self.depth = self.depth.saturating_sub(1);
                    if self
                        .inline
                        .last()
                        .is_some_and(|(depth, _)| *depth == self.depth)
                    {
                        self.inline.pop();
                    }
                }
                Token::Word(word) if word == "mod" => {
                    if let Some((_, Token::Word(name))) = self.tokens.get(self.at + 1)
                        && is(self.tokens.get(self.at + 2), "{")
                    {
                        self.inline.push((self.depth, name.clone()));
                    }
                }
                Token::Word(word) if word == "use" => {
                    self.at += 1;
                    let mut paths = Vec::new();
                    self.tree(&mut Vec::new(), &mut paths);
                    for path in paths {
                        self.name(line, path);
                    }
                    continue;
                }
                Token::Word(word) => {
                    let method = self.at > 0 && is(self.tokens.get(self.at - 1), ".");
                    if is(self.tokens.get(self.at + 1), "!") {
                        self.source.words.push((line, format!("{word}!")));
                    } else if !method {
                        self.source.words.push((line, word.clone()));
                    }
                    if !method && self.colons(self.at + 1) {
                        let path = self.written_out();
                        self.name(line, path);
                        continue;
                    }
                }
                _ => {}
            }
            self.at += 1;
        }
    }

    fn colons(&self, at: usize) -> bool {
        is(self.tokens.get(at), ":") && is(self.tokens.get(at + 1), ":")
    }

    /// `a::b::c` in code; stops before `::<` and at the end.
    fn written_out(&mut self) -> Vec<String> {
        let mut path = Vec::new();
        while let Some((line, Token::Word(word))) = self.tokens.get(self.at) {
            path.push(word.clone());
            self.at += 1;
            if path.len() > 1 {
                let mark = if is(self.tokens.get(self.at), "!") {
                    "!"
                } else {
                    ""
                };
                self.source.words.push((*line, format!("{word}{mark}")));
            }
            let more = matches!(self.tokens.get(self.at + 2), Some((_, Token::Word(_))));
            if !(self.colons(self.at) && more) {
                break;
            }
            self.at += 2;
        }
        path
    }

    /// One branch of a `use` declaration, behind `prefix`.
    fn tree(&mut self, prefix: &mut Vec<String>, paths: &mut Vec<Vec<String>>) {
        let before = prefix.len();
        loop {
            match self.tokens.get(self.at).map(|(_, token)| token) {
                Some(Token::Word(word)) if word == "as" => self.at += 2,
                Some(Token::Word(word)) => {
                    prefix.push(word.clone());
                    self.at += 1;
                }
                Some(Token::Mark(':')) => self.at += 1,
                Some(Token::Mark('*')) => {
                    prefix.push("*".into());
                    self.at += 1;
                }
                Some(Token::Mark('{')) => {
                    self.at += 1;
                    while !is(self.tokens.get(self.at), "}") && self.at < self.tokens.len() {
                        self.tree(prefix, paths);
                        if is(self.tokens.get(self.at), ",") {
                            self.at += 1;
                        }
                    }
                    self.at += 1;
                    break;
                }
                _ => {
                    if prefix.len() > before {
                        paths.push(prefix.clone());
                    }
                    break;
                }
            }
        }
        prefix.truncate(before);
    }

    fn name(&mut self, line: usize, path: Vec<String>) {
        let mut here = self.module.clone();
        here.extend(self.inline.iter().map(|(_, name)| name.clone()));
        let target = resolve(&here, &self.children, path);
        self.source.named.push(Named { line, target });
    }
}

/// What a path means in the module `here`.
fn resolve(here: &[String], children: &[String], path: Vec<String>) -> Target {
    let mut base = here.to_vec();
    let mut rest = path.as_slice();
    match rest.first().map(String::as_str) {
        // The folder of a crate comes first.
        Some("crate") => {
            base.truncate(1);
            rest = &rest[1..];
        }
        // The program sees the library from outside.
        Some("nearmiss") if here == ["main"] => {
            base.clear();
            rest = &rest[1..];
        }
        Some("self" | "super") => {
            while let Some(step) = rest.first().filter(|s| *s == "self" || *s == "super") {
                if step == "super" {
                    base.pop();
                }
                rest = &rest[1..];
            }
        }
        Some(first) if children.iter().any(|child| child == first) => {}
        _ => return Target::Outside(path),
    }
    // `use a::{self}` names `a`.
    base.extend(rest.iter().filter(|s| *s != "self").cloned());
    Target::Inside(base)
}
