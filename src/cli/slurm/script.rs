//! The text of the scripts.

use super::command::{PART, PartCommand};

/// What Slurm is asked for.
pub struct Resources<'a> {
    pub partition: Option<&'a str>,
    pub account: Option<&'a str>,
    pub time: Option<&'a str>,
    pub memory: Option<&'a str>,
    pub cpus: Option<u32>,
}

/// What the scripts say; paths are absolute and have no control characters.
pub struct Scripts<'a> {
    pub command: &'a PartCommand,
    pub parts: u32,
    /// Parts that run at the same time.
    pub at_once: Option<u32>,
    /// The shared folder.
    pub folder: &'a str,
    pub program: &'a str,
    /// Where relative paths of the command begin.
    pub here: &'a str,
    pub env_file: Option<&'a str>,
    pub resources: Resources<'a>,
}

impl Scripts<'_> {
    /// The job array.
    pub fn array(&self) -> String {
        let parts = self.parts;
        let name = self.command.words.first().map_or("", String::as_str);
        let at_once = self.at_once.map_or_else(String::new, |n| format!("%{n}"));
        let more = format!("#SBATCH --array=1-{parts}{at_once}\n#SBATCH --requeue\n");
        let head = self.head(name, "part-%a", &more);
        let words: Vec<String> = self.command.words.iter().map(|word| part(word)).collect();
        let (words, resume) = (words.join(" "), self.command.more());
        let preamble = self.preamble();
        format!(
            "{head}\n{preamble}\
             \npart=${{SLURM_ARRAY_TASK_ID:?submit this script with sbatch}}\n\
             # Each part has a store of its own: one SQLite file is not written by several machines.\n\
             export NEARMISS_DATA=\"$folder/parts/$part-of-{parts}\"\n\
             mkdir -p \"$NEARMISS_DATA\" || exit\n\n\
             # Started again, a part continues. Status 137: killed, for instance because memory ran out.\n\
             for _ in 1 2 3; do\n    \
                 \"$nearmiss\" {words} --shard \"$part/{parts}\"{resume}\n    \
                 status=$?\n    \
                 [ \"$status\" -eq 137 ] || break\n\
             done\n\
             exit \"$status\"\n"
        )
    }

    /// The script that joins the parts; `None` where they need no joining.
    pub fn join(&self) -> Option<String> {
        if !self.command.is_joined() {
            return None;
        }
        let parts = self.parts;
        let head = self.head("join", "join", "");
        let preamble = self.preamble();
        Some(format!(
            "{head}\n{preamble}\
             \n# The stores of all parts become one; again, only what is new is added.\n\
             export NEARMISS_DATA=\"$folder/joined\"\n\
             mkdir -p \"$NEARMISS_DATA\" || exit\n\
             \"$nearmiss\" import \"$folder\"/parts/{{1..{parts}}}-of-{parts}/runs.sqlite || exit\n\
             \"$nearmiss\" report --batch last -o \"$folder/report.html\" --overwrite || exit\n\
             \"$nearmiss\" report --batch last\n"
        ))
    }

    /// The first lines, up to what Slurm reads.
    fn head(&self, name: &str, log: &str, more: &str) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let log = format!("{}/logs/", self.folder.replace('%', "%%")) + log + ".log";
        let mut head = format!(
            "#!/bin/bash\n# Written by `nearmiss slurm`, version {version}.\n\
             #SBATCH --job-name=nearmiss-{name}\n{more}#SBATCH --output={}\n#SBATCH --open-mode=append\n",
            in_directive(&log)
        );
        let resources = &self.resources;
        let cpus = resources.cpus.map(|n| n.to_string());
        for (option, value) in [
            ("partition", resources.partition),
            ("account", resources.account),
            ("time", resources.time),
            ("mem", resources.memory),
            ("cpus-per-task", cpus.as_deref()),
        ] {
            if let Some(value) = value {
                head.push_str(&format!("#SBATCH --{option}={value}\n"));
            }
        }
        head
    }

    /// Program, folder and environment.
    fn preamble(&self) -> String {
        let mut text = String::new();
        let mut words = self.command.words.iter().map(String::as_str);
        let paths = [self.program, self.folder, self.here];
        let is_literal = |word: &str| word.contains(['$', '`']);
        if paths.into_iter().chain(self.env_file).any(is_literal) || words.any(is_literal) {
            text += "# Dollar signs in names are meant as they are.\n# shellcheck disable=SC2016\n";
        }
        text += &format!(
            "nearmiss={}\nfolder={}\n\n# Relative paths begin here.\ncd {} || exit\n",
            quoted(self.program),
            quoted(self.folder),
            quoted(self.here)
        );
        if let Some(file) = self.env_file {
            text += &format!(
                "# Keys and other settings.\nset -a\n# shellcheck source=/dev/null\n. {} || exit\nset +a\n",
                quoted(file)
            );
        }
        text
    }
}

/// A word as a shell reads it back.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,+@%".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// A word of the command, with the number of the part in it.
fn part(word: &str) -> String {
    let mut text = String::new();
    for (place, piece) in word.split(PART).enumerate() {
        if place > 0 {
            text.push_str("\"$part\"");
        }
        if !piece.is_empty() || word.is_empty() {
            text.push_str(&quoted(piece));
        }
    }
    text
}

/// A value without backslashes in a line of `#SBATCH`, as Slurm reads it back.
fn in_directive(value: &str) -> String {
    format!("\"{}\"", value.replace('"', r#"\""#))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_as_shells_read_them() {
        for (word, wanted) in [
            ("--lead=0.5,1", "--lead=0.5,1"),
            ("", "''"),
            ("my study.toml", "'my study.toml'"),
            ("Ada's $(x) \"y\"", r#"'Ada'\''s $(x) "y"'"#),
            ("~/x", "'~/x'"),
        ] {
            assert_eq!(quoted(word), wanted);
            assert_eq!(part(word), wanted);
        }
        assert_eq!(part("a {part} b.json"), "'a '\"$part\"' b.json'");
        assert_eq!(part("{part}"), "\"$part\"");
    }
}
