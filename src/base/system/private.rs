//! Files and folders that only the user may read: what was asked and answered is private.

use std::io::{ErrorKind, Result};
use std::path::Path;

/// Makes a folder and those above it, for the user alone. One that is there already stays as it is.
///
/// # Errors
/// What the system says.
pub fn make_folder(path: &Path) -> Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Makes an empty file for the user alone, where there is none.
///
/// # Errors
/// What the system says.
pub fn make_file(path: &Path) -> Result<()> {
    let mut options = std::fs::File::options();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    match options.open(path) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(error),
        _ => Ok(()),
    }
}

/// What other users can do with a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OthersMay {
    /// Read it.
    pub read: bool,
    /// Change it, or put another one in its place.
    pub write: bool,
}

/// What other users can do with a file, by its permissions and those of the folders that it lies in.
#[cfg(unix)]
#[must_use]
pub fn others_may(file: &Path) -> OthersMay {
    let none = OthersMay::default();
    let (Some(bits), Ok(real)) = (mode(file), file.canonicalize()) else {
        return none;
    };
    let folders: Option<Vec<u32>> = real.ancestors().skip(1).map(mode).collect();
    let Some((folder, above)) = folders.as_deref().and_then(|all| all.split_first()) else {
        return none;
    };
    // The group, then all other users.
    [3, 0].into_iter().fold(none, |may, shift| {
        let allows = |mode: &u32, what: u32| mode >> shift & what == what;
        let replaced = allows(folder, 3) && folder & STICKY == 0;
        let reached = allows(folder, 1) && above.iter().all(|folder| allows(folder, 1));
        OthersMay {
            read: may.read || reached && allows(&bits, 4),
            write: may.write || reached && (allows(&bits, 2) || replaced),
        }
    })
}

/// Elsewhere the user's folders are closed by the system.
#[cfg(not(unix))]
#[must_use]
pub fn others_may(_: &Path) -> OthersMay {
    OthersMay::default()
}

/// Takes a file that an older program made, from all other users.
///
/// A folder with the set-group-ID bit was made for a group to share; its files stay as they are. So does what belongs
/// to another user.
#[cfg(unix)]
pub fn close_file(path: &Path) {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    if mode(folder.unwrap_or(Path::new("."))).is_none_or(|mode| mode & SET_GROUP_ID != 0) {
        return;
    }
    if path.metadata().is_ok_and(|found| found.is_file()) {
        close(path);
    }
}

/// Takes a folder that an older program made, from all other users, if nothing lies in it but what `ours` knows:
/// a folder that is used for other things as well is not the program's to close.
#[cfg(unix)]
pub fn close_folder(path: &Path, ours: impl Fn(&str) -> bool) {
    let shared = SET_GROUP_ID | STICKY;
    if mode(path).is_none_or(|mode| mode & shared != 0) {
        return;
    }
    let Ok(mut entries) = std::fs::read_dir(path) else {
        return;
    };
    let all_ours = entries.all(|entry| {
        let name = entry.map(|entry| entry.file_name());
        name.is_ok_and(|name| name.to_str().is_some_and(&ours))
    });
    if all_ours {
        close(path);
    }
}

#[cfg(unix)]
const SET_GROUP_ID: u32 = 0o2000;

#[cfg(unix)]
const STICKY: u32 = 0o1000;

#[cfg(unix)]
fn mode(path: &Path) -> Option<u32> {
    use std::os::unix::fs::PermissionsExt;
    Some(path.metadata().ok()?.permissions().mode())
}

/// What belongs to another user, or lies on a disk that cannot be written, stays open.
#[cfg(unix)]
fn close(path: &Path) {
    use std::os::unix::fs::PermissionsExt;
    if let Some(mode) = mode(path).filter(|mode| mode & 0o077 != 0) {
        let closed = std::fs::Permissions::from_mode(mode & 0o700);
        let _ = std::fs::set_permissions(path, closed);
    }
}

/// Elsewhere the user's folders are closed by the system.
#[cfg(not(unix))]
pub fn close_file(_: &Path) {}

/// Elsewhere the user's folders are closed by the system.
#[cfg(not(unix))]
pub fn close_folder(_: &Path, _: impl Fn(&str) -> bool) {}

#[cfg(test)]
#[cfg(unix)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn bits(path: &Path) -> u32 {
        mode(path).unwrap() & 0o7777
    }

    #[test]
    fn what_is_made_is_for_the_user_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (inner, file) = (folder.path().join("a/b"), folder.path().join("a/b/c"));
        make_folder(&inner).unwrap();
        make_file(&file).unwrap();
        assert_eq!((bits(&inner), bits(&file)), (0o700, 0o600));
        assert_eq!(bits(&folder.path().join("a")), 0o700);
        std::fs::write(&file, "x").unwrap();
        make_folder(&inner).unwrap();
        make_file(&file).unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"x");
    }

    #[test]
    fn what_others_may_depends_on_all_folders() {
        let home = tempfile::tempdir().unwrap();
        let (folder, file) = (
            home.path().join("config"),
            home.path().join("config/a.toml"),
        );
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(&file, "x").unwrap();
        let may = |modes: [u32; 3]| {
            for (path, mode) in [home.path(), &folder, &file].into_iter().zip(modes) {
                set_permissions(path, Permissions::from_mode(mode)).unwrap();
            }
            let OthersMay { read, write } = others_may(&file);
            (read, write)
        };
        assert_eq!(may([0o755, 0o755, 0o644]), (true, false));
        assert_eq!(may([0o755, 0o755, 0o666]), (true, true));
        assert_eq!(may([0o755, 0o755, 0o660]), (true, true), "the group");
        assert_eq!(
            may([0o755, 0o777, 0o600]),
            (false, true),
            "it can be replaced"
        );
        assert_eq!(may([0o755, 0o1777, 0o600]), (false, false));
        assert_eq!(may([0o755, 0o700, 0o666]), (false, false));
        assert_eq!(may([0o700, 0o777, 0o666]), (false, false));
        assert_eq!(others_may(&folder.join("gone")), OthersMay::default());
        may([0o700, 0o700, 0o600]);
    }

    #[test]
    fn what_is_there_is_closed_unless_it_is_shared_or_not_ours() {
        let folder = tempfile::tempdir().unwrap();
        let (inner, file) = (folder.path().join("data"), folder.path().join("data/runs"));
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(&file, "x").unwrap();
        let open = |inner_mode: u32| {
            set_permissions(&inner, Permissions::from_mode(inner_mode)).unwrap();
            set_permissions(&file, Permissions::from_mode(0o664)).unwrap();
        };
        let close = |ours: &str| {
            close_file(&file);
            close_folder(&inner, |name| name == ours);
            (bits(&inner), bits(&file))
        };
        open(0o755);
        assert_eq!(close("runs"), (0o700, 0o600));
        open(0o755);
        assert_eq!(
            close("walks"),
            (0o755, 0o600),
            "something else is in its place"
        );
        open(0o2775);
        assert_eq!(close("runs"), (0o2775, 0o664), "shared by a group");
        open(0o1777);
        assert_eq!(close("runs"), (0o1777, 0o600), "writable by all users");
        close_file(&folder.path().join("nowhere"));
        close_folder(&folder.path().join("nowhere"), |_| true);
    }
}
