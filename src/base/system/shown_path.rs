//! Paths as they are told: whole, with the home folder as `~`.

use std::path::{Path, PathBuf};

/// The whole path, with the home folder as `~`.
#[must_use]
pub fn shown_path(path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    // `./x` is whole with a dot in it.
    let whole: PathBuf = whole.components().collect();
    below_home(&whole, std::env::home_dir().as_deref())
}

fn below_home(whole: &Path, home: Option<&Path>) -> String {
    let home = home.filter(|home| home.parent().is_some());
    match home.and_then(|home| whole.strip_prefix(home).ok()) {
        Some(rest) => Path::new("~").join(rest).display().to_string(),
        None => whole.display().to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn home_is_a_tilde_and_nothing_else_is() {
        let told = |path: &str, home: &str| below_home(Path::new(path), Some(Path::new(home)));
        assert_eq!(told("/home/ada/a/b.svg", "/home/ada"), "~/a/b.svg");
        assert_eq!(told("/home/adam/b.svg", "/home/ada"), "/home/adam/b.svg");
        assert_eq!(told("/srv/b.svg", "/"), "/srv/b.svg");
        assert!(shown_path(Path::new("./b.svg")).ends_with("/b.svg"));
        assert!(!shown_path(Path::new("./b.svg")).contains("/./"));
    }
}
