//! Rows, marks and texts of a page, and that nothing in its data becomes markup.

use super::AnswerPage;
use crate::evaluation::tests_scored::answer;
use crate::evaluation::{AnswerCase, AnswerStatus, Label, Lead, Scored};

fn told(scenario: &str, model: &str, dangerous: bool, truth: Option<Label>) -> Scored {
    Scored {
        truth,
        ..answer(scenario, model, dangerous, &[(3, 0)])
    }
}

#[test]
fn questions_are_rows_and_answers_are_marked() {
    let hit = Some(Label::Collision(None));
    let mut all = vec![
        told("A", "lab/x", true, hit),
        told("A", "lab/y", false, hit),
        told("B", "lab/x", true, None),
        told("A", "lab/x", true, hit),
    ];
    for one in &mut all[..2] {
        one.window = Some((3, 12));
    }
    all[3].sample = 1;
    // Not asked, so its window is not known: it is about the same question.
    all[3].status = AnswerStatus::Unasked("not asked yet".into());
    let page = AnswerPage::new(&AnswerCase::all(&all));
    assert_eq!((page.rows.len(), page.configurations.len()), (2, 2));
    let letters: String = page.marks.iter().map(|mark| mark.letter).collect();
    assert_eq!(letters, "RW?N");
    assert_eq!(page.marks[3].row, page.marks[0].row);
    let lead = |seconds| Some(Lead::Seconds(seconds));
    let cases = [(0, lead(1.0)), (1, lead(2.0))].map(|(place, lead)| AnswerCase {
        scored: &all[place],
        lead,
    });
    assert_eq!(
        AnswerPage::new(&cases).rows.len(),
        2,
        "each lead is a question"
    );
}

#[test]
fn texts_are_kept_once_and_nothing_becomes_markup() {
    let evil = "</script><img src=x onerror=alert(1)> <!-- <script> & \u{202e}\u{1b}[2J";
    let mut one = told(evil, evil, true, Some(Label::Safe));
    if let AnswerStatus::Verdict(verdict) = &mut one.status {
        verdict.justification = evil.into();
        verdict.obstacles[0].reason = evil.into();
    }
    let all = [one.clone(), one];
    let mut page = AnswerPage::new(&AnswerCase::all(&all));
    for place in 0..2 {
        page.add_message(place, "user", evil);
        page.set_text(place, "another text");
        if let Some(detail) = page.detail_mut(place) {
            detail.model_returned = Some(evil.into());
        }
    }
    page.set_picture(0, "<svg></svg>");
    page.set_picture(0, "<svg>another</svg>");
    let html = page.html();
    for bad in ["<img", "<!--", "<svg", "\u{1b}", "\u{202e}"] {
        assert!(!html.contains(bad), "{bad}");
    }
    assert_eq!(
        html.matches("</script>").count(),
        html.matches("<script").count()
    );
    assert_eq!(html.matches("another text").count(), 1);
    assert_eq!(html.matches("id=\"data-picture-").count(), 1);
}
