//! That bodies touch is said only where that is wanted; the distance tells it in any case, the risk score never.

use nearmiss::description::{Form, Frame, Options, describe};
use nearmiss::prompts::Library;
use nearmiss::scenario::Window;

use crate::words::scene;
use crate::words::templates::with_contact;

/// The end of a recording in which obstacle 301 touches the ego.
fn described(frame: Frame, form: Form, contact: bool) -> String {
    let scene = scene("ZAM_RedLight-1_1_T-1");
    let options = Options {
        form,
        contact,
        obstacle: Some(301),
        ..Options::default()
    };
    let window = Window::ending_at(&scene, i64::MAX, 10);
    describe(&scene, frame, &window, &options).unwrap().text
}

#[test]
fn contact_is_said_only_where_it_is_wanted() {
    for form in Form::ALL {
        for frame in Frame::ALL {
            let without = described(frame, form, false);
            for word in ["Contact", "contact", "touch"] {
                assert!(!without.contains(word), "{word}:\n{without}");
            }
            let with = described(frame, form, true);
            let in_words = frame.words().is_some_and(|words| words != Frame::Cartesian);
            assert_eq!(with.contains("Contact"), in_words, "{with}");
            assert_eq!(with.contains("A red ring"), frame.has_picture(), "{with}");
        }
    }
    assert!(described(Frame::Ego, Form::Prose, true).contains("It touches the ego."));
}

#[test]
fn what_was_measured_still_tells_it() {
    let ego = described(Frame::Ego, Form::Prose, false);
    assert!(
        ego.contains("distance 0.00 m; gap longitudinal 0.00 m, lateral 0.00 m"),
        "{ego}"
    );
    let metrics = described(Frame::Metrics, Form::Prose, false);
    for part in [
        "; distance 0.00 m",
        "risk score 1",
        "time to collision 0.00 s",
    ] {
        assert!(metrics.contains(part), "{part}:\n{metrics}");
    }
    assert!(!metrics.contains("risk score 0"), "{metrics}");
}

#[test]
fn templates_explain_contact_only_where_it_is_said() {
    let library = Library::load(None);
    for (file, template, _) in library.templates() {
        let text = |contact| {
            let prompt = with_contact(file, 7, Form::Prose, contact);
            format!("{}\n{}", prompt.system, prompt.user)
        };
        let without = text(false);
        let named = |text: &str| text.contains("Contact") || text.contains("is contact");
        assert!(!named(&without), "{file}:\n{without}");
        let speaks = ["ego", "metrics"].contains(&template.front.frame.as_str());
        assert_eq!(text(true).contains("Contact"), speaks, "{file}");
    }
}
