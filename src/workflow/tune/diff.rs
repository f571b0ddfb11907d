//! The difference of two templates, as editors and `patch` read it.

use std::time::Duration;

use similar::TextDiff;

/// A unified diff of a template file; blank where both are the same.
#[must_use]
pub fn template_diff(file: &str, before: &str, after: &str) -> String {
    // Of texts that have little in common a coarser difference will do.
    let difference = TextDiff::configure()
        .timeout(Duration::from_millis(300))
        .diff_lines(before, after);
    let mut unified = difference.unified_diff();
    unified.header(file, file).to_string()
}

#[cfg(test)]
mod tests {
    use super::template_diff;

    #[test]
    fn a_changed_line_is_shown_with_its_file() {
        let diff = template_diff("t.md", "a\nb\nc\n", "a\nx\nc\n");
        assert_eq!(
            diff,
            "--- t.md\n+++ t.md\n@@ -1,3 +1,3 @@\n a\n-b\n+x\n c\n"
        );
        assert_eq!(template_diff("t.md", "a\n", "a\n"), "");
    }
}
