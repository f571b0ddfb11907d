//! Requirements as JUnit XML, which CI servers show as tests.

use crate::output::visible;
use nearmiss_study::evaluation::Check;

/// A test case for each requirement and way.
pub fn xml(checks: &[Check]) -> String {
    let failures = checks.iter().filter(|check| !check.is_met).count();
    let (tests, mut text) = (
        checks.len(),
        String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"),
    );
    text += &format!(
        "<testsuites tests=\"{tests}\" failures=\"{failures}\">\n  <testsuite name=\"nearmiss\" tests=\"{tests}\" \
         failures=\"{failures}\" errors=\"0\" skipped=\"0\">\n"
    );
    for check in checks {
        let (class, name) = (escaped(&check.configuration), escaped(&check.requirement));
        let found = escaped(&check.found);
        text += &if check.is_met {
            format!("    <testcase classname=\"{class}\" name=\"{name}\"/>\n")
        } else {
            format!(
                "    <testcase classname=\"{class}\" name=\"{name}\">\n      <failure message=\"{found}\"/>\n    \
                 </testcase>\n"
            )
        };
    }
    text + "  </testsuite>\n</testsuites>\n"
}

fn escaped(text: &str) -> String {
    let text = visible(text);
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_for_each_check_and_nothing_is_obeyed() {
        let check = |is_met| Check {
            requirement: "f1 >= 0.8".into(),
            configuration: "lab/<a>\"&\u{1b}".into(),
            found: "f1 is 0.7".into(),
            is_met,
        };
        let text = xml(&[check(true), check(false)]);
        assert!(text.contains("tests=\"2\" failures=\"1\""), "{text}");
        assert!(
            text.contains("classname=\"lab/&lt;a&gt;&quot;&amp;␛\""),
            "{text}"
        );
        assert!(text.contains("<failure message=\"f1 is 0.7\"/>"), "{text}");
    }
}
