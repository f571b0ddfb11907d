//! The external editor: writes a text to a file, runs the editor, and reads the file back.

use std::io::Write;
use std::path::Path;
use std::process::Command;

use nearmiss_base::system;

/// The command that the user edits texts with: `VISUAL`, else `EDITOR`; it may have arguments.
///
/// # Errors
/// Neither is set, or its quotes do not match.
pub fn command(env: impl Fn(&str) -> Option<String>) -> Result<Vec<String>, String> {
    let set = |name: &str| {
        env(name)
            .filter(|v| !v.trim().is_empty())
            .map(|v| (name.to_string(), v))
    };
    let Some((name, value)) = set("VISUAL").or_else(|| set("EDITOR")) else {
        return Err(
            "neither VISUAL nor EDITOR is set; set one to your editor, such as `vim` or `code -w`"
                .into(),
        );
    };
    match split_words(&value) {
        Some(words) if !words.is_empty() => Ok(words),
        _ => Err(format!("{name} is `{value}`: its quotes do not match")),
    }
}

/// The words of a command, which quotes hold together.
fn split_words(text: &str) -> Option<Vec<String>> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in text.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    quote.is_none().then_some(words)
}

/// Lets the user edit a text as a file of this name. The terminal must be theirs meanwhile.
///
/// # Errors
/// The editor cannot be started, says that it failed, or leaves what is no text. What was written then is kept in
/// the file that the error names.
pub fn edit(command: &[String], name: &str, text: &str) -> Result<String, String> {
    let folder = tempfile::Builder::new()
        .prefix("nearmiss-")
        .tempdir()
        .map_err(|e| format!("no folder for the text: {}", system::error_text(&e)))?;
    let path = folder.path().join(name);
    let write = std::fs::File::create_new(&path).and_then(|mut f| f.write_all(text.as_bytes()));
    write.map_err(|e| format!("{}: {}", path.display(), system::error_text(&e)))?;
    run(command, &path).map_err(|why| {
        // The user's text is not lost.
        let differs =
            system::read_file(&path, system::LARGEST).is_ok_and(|bytes| bytes != text.as_bytes());
        if differs {
            let kept = folder.keep().join(name);
            return format!("{why}; changes not applied, but kept in {}", kept.display());
        }
        format!("{why}; the template is as it was")
    })
}

/// Lets the user edit a file of theirs where it is, and gives its text. The terminal must be theirs meanwhile.
///
/// # Errors
/// The editor cannot be started, says that it failed, or leaves what is no text.
pub fn edit_file(command: &[String], path: &Path) -> Result<String, String> {
    run(command, path)
}

/// Runs the editor on a file, and reads that.
fn run(command: &[String], path: &Path) -> Result<String, String> {
    let shown = command.join(" ");
    let mut editor = Command::new(&command[0]);
    editor.args(&command[1..]).arg(path);
    let started = system::processes::with_default(|| editor.spawn());
    match started.and_then(|mut editor| editor.wait()) {
        Err(error) => Err(format!(
            "`{shown}` cannot be started: {}; set VISUAL or EDITOR to your editor",
            system::error_text(&error)
        )),
        Ok(status) if !status.success() => Err(match status.code() {
            Some(code) => format!("`{shown}` ended with status {code}"),
            None => format!("`{shown}` was ended by a signal"),
        }),
        Ok(_) => read(path).map_err(|why| format!("`{shown}` left no text: {why}")),
    }
}

fn read(path: &Path) -> Result<String, String> {
    system::read_text(path, system::LARGEST_TEXT).map_err(|error| system::error_text(&error))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn of(pairs: &[(&str, &str)]) -> Result<Vec<String>, String> {
        command(|name| {
            let found = pairs.iter().find(|(n, _)| *n == name);
            found.map(|(_, v)| (*v).to_string())
        })
    }

    #[test]
    fn the_command_and_its_arguments() {
        assert_eq!(
            of(&[("EDITOR", "vi"), ("VISUAL", "code -w")]).unwrap(),
            ["code", "-w"]
        );
        assert_eq!(of(&[("EDITOR", "vi"), ("VISUAL", " ")]).unwrap(), ["vi"]);
        assert_eq!(
            of(&[("EDITOR", "'/my apps/ed' --title \"a b\" ''")]).unwrap(),
            ["/my apps/ed", "--title", "a b", ""]
        );
        assert!(of(&[]).unwrap_err().contains("neither VISUAL nor EDITOR"));
        assert!(of(&[("EDITOR", "'vi")]).unwrap_err().contains("quotes"));
    }

    #[cfg(unix)]
    #[test]
    fn a_text_goes_out_and_comes_back_and_nothing_is_lost() {
        let sh = |script: &str| {
            let command = ["sh", "-c", script, "sh"].map(String::from);
            edit(&command, "t.md", "old")
        };
        assert_eq!(sh("cat \"$1\" > /dev/null").unwrap(), "old");
        assert_eq!(
            sh("case \"$1\" in */t.md) echo new > \"$1\";; esac").unwrap(),
            "new\n"
        );
        let error = sh("exit 3").unwrap_err();
        assert!(
            error.contains("status 3") && error.contains("as it was"),
            "{error}"
        );
        let error = sh("printf mine > \"$1\"; exit 1").unwrap_err();
        let (_, path) = error.rsplit_once(" kept in ").unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "mine");
        std::fs::remove_dir_all(Path::new(path).parent().unwrap()).unwrap();
        let error = sh("printf '\\377' > \"$1\"").unwrap_err();
        assert!(error.contains("UTF-8"), "{error}");
        let error = edit(&["no-such-editor".into()], "t.md", "old").unwrap_err();
        assert!(
            error.contains("no-such-editor` cannot be started"),
            "{error}"
        );
    }
}
