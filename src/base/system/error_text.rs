//! What the operating system says, in plain words.

use std::io::{Error, ErrorKind};

/// Why the system refused something, for people: without error numbers, and without paths that the program made up
/// (those of temporary files). The caller names the path that is meant.
#[must_use]
pub fn error_text(error: &Error) -> String {
    let said = match error.kind() {
        ErrorKind::NotFound => "no such file or folder",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::IsADirectory => "is a folder, not a file",
        ErrorKind::NotADirectory => "part of this path is a file, not a folder",
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only",
        ErrorKind::StorageFull => "no space left on the device",
        _ => return without_number(&error.to_string()),
    };
    said.to_string()
}

/// The standard library writes `Words (os error 5)`, and `tempfile` the path of its file behind that.
fn without_number(text: &str) -> String {
    let Some((said, _)) = text.split_once(" (os error ") else {
        return text.to_string();
    };
    let mut rest = said.chars();
    let first = rest.next().map(|c| c.to_lowercase().to_string());
    first.unwrap_or_default() + rest.as_str()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_numbers_and_no_paths_of_its_own() {
        for kind in [ErrorKind::PermissionDenied, ErrorKind::Interrupted] {
            let wrapped = Error::new(kind, "Said so (os error 13) at path \"/a/.b.part\"");
            let said = error_text(&wrapped);
            assert!(
                !said.contains("os error") && !said.contains(".part"),
                "{said}"
            );
        }
        let permission = Error::new(
            ErrorKind::PermissionDenied,
            "Permission denied (os error 13)",
        );
        assert_eq!(error_text(&permission), "permission denied");
        assert_eq!(
            error_text(&Error::other("Too Many (os error 40)")),
            "too Many"
        );
        assert_eq!(
            error_text(&Error::other("The words as they are")),
            "The words as they are"
        );
    }

    #[cfg(unix)]
    #[test]
    fn no_error_of_the_system_shows_its_number() {
        for number in 1..=133 {
            let said = error_text(&Error::from_raw_os_error(number));
            assert!(
                !said.is_empty() && !said.contains("os error"),
                "{number}: {said}"
            );
        }
    }
}
