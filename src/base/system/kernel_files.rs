//! Folders whose files the kernel makes up while they are read: nothing was saved there, and links lead everywhere.

use std::path::Path;

/// Whether a folder is one of them, such as `/proc` and what is in it.
#[cfg(target_os = "linux")]
#[must_use]
pub fn is_of_kernel(folder: &Path) -> bool {
    // statfs(2): procfs, sysfs, both kinds of cgroups, debugfs and tracefs.
    const MAGIC: [u64; 6] = [
        0x9fa0,
        0x6265_6572,
        0x27_e0eb,
        0x6367_7270,
        0x6462_6720,
        0x7472_6163,
    ];
    let kind = rustix::fs::statfs(folder).map(|found| found.f_type);
    kind.is_ok_and(|kind| u64::try_from(kind).is_ok_and(|kind| MAGIC.contains(&kind)))
}

/// Elsewhere there is none.
#[cfg(not(target_os = "linux"))]
#[must_use]
pub fn is_of_kernel(_: &Path) -> bool {
    false
}
