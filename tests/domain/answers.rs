//! Answers of any kind: nothing panics, nothing takes long, and the slips of models change no meaning.
#![allow(clippy::unwrap_used)]

use nearmiss::verdict::{
    CollisionAnswer, CriticalObstacle, ObstacleRisk, ParseQuality, RecordingAnswer, SafetyAnswer,
    Task, Verdict, parse, read,
};
use proptest::prelude::*;

fn verdicts() -> impl Strategy<Value = Verdict> {
    let words = "[ -~äß“”\n\t]{0,60}";
    let obstacle =
        (1..100_000_i64, 0..=5_u8, words).prop_map(|(id, risk_score, reason)| ObstacleRisk {
            id,
            risk_score,
            reason,
            written_score: None,
        });
    let obstacles = proptest::collection::vec(obstacle, 0..5).prop_map(|mut list| {
        let mut seen = std::collections::HashSet::new();
        list.retain(|o| seen.insert(o.id));
        list
    });
    let task = proptest::sample::select(Task::VERDICTS.to_vec());
    let critical = (1..100_000_i64, 0.0..=1.0_f64).prop_map(|(id, probability)| CriticalObstacle {
        id,
        probability: Some(probability),
    });
    let critical = proptest::collection::vec(critical, 0..3).prop_map(|mut list| {
        let mut seen = std::collections::HashSet::new();
        list.retain(|o| seen.insert(o.id));
        list
    });
    // Older answers say neither.
    let stated = proptest::option::of((critical, 0.0..=1.0_f64));
    (task, any::<bool>(), obstacles, words, stated).prop_map(
        |(task, dangerous, obstacles, justification, stated)| {
            let (critical, probability) = stated.unzip();
            Verdict {
                task,
                dangerous,
                obstacles,
                justification,
                critical,
                probability,
                token_probability: None,
                unknown: Vec::new(),
            }
        },
    )
}

/// The answer that was asked for.
fn written(verdict: &Verdict) -> String {
    let Verdict {
        task,
        dangerous,
        obstacles,
        justification,
        critical: critical_obstacles,
        probability,
        token_probability: _,
        unknown: _,
    } = verdict.clone();
    let written = match task {
        Task::Collision => serde_json::to_string_pretty(&CollisionAnswer {
            justification,
            obstacles,
            critical_obstacles,
            probability,
            collision: dangerous,
        }),
        Task::Recording => serde_json::to_string_pretty(&RecordingAnswer {
            justification,
            obstacles,
            critical_obstacles,
            probability,
            high_risk: dangerous,
        }),
        _ => serde_json::to_string_pretty(&SafetyAnswer {
            justification,
            obstacles,
            critical_obstacles,
            probability,
            safety_critical: dangerous,
        }),
    };
    written.unwrap()
}

/// The same verdict with texts that hold nothing a slip could be mistaken for.
fn with_plain_words(mut verdict: Verdict) -> Verdict {
    let plain = |text: &str| {
        text.chars()
            .filter(|c| c.is_ascii_alphabetic() || *c == ' ')
            .collect::<String>()
    };
    verdict.justification = plain(&verdict.justification);
    for o in &mut verdict.obstacles {
        o.reason = plain(&o.reason);
    }
    verdict
}

type Slip = (&'static str, fn(&str) -> String);

const SLIPS: [Slip; 15] = [
    ("fence", |t| format!("Here:\n```json\n{t}\n```\nDone.")),
    ("prose with braces", |t| {
        format!("With \\frac{{1}}{{2}} and {{x | x > 0}}:\n{t}")
    }),
    ("a draft", |t| {
        format!(
            "{}\nNo, rather:\n{t}",
            t.replace("true", "maybe").replace("false", "true")
        )
    }),
    ("one line", |t| t.replace('\n', " ")),
    ("single quotes", |t| t.replace('"', "'")),
    ("typographic quotes", |t| {
        let mut open = false;
        let quote = |c| match c {
            '"' => {
                open = !open;
                if open { '“' } else { '”' }
            }
            other => other,
        };
        t.chars().map(quote).collect()
    }),
    ("bare keys", |t| {
        [
            "collision",
            "safety_critical",
            "high_risk",
            "obstacles",
            "id",
            "risk_score",
            "reason",
            "justification",
            "critical_obstacles",
            "probability",
        ]
        .iter()
        .fold(t.to_string(), |t, key| {
            t.replace(&format!("\"{key}\":"), &format!("{key}:"))
        })
    }),
    ("trailing commas", |t| {
        t.replace("\n}", ",\n}")
            .replace("\n    }", ",\n    }")
            .replace("\n  ]", ",\n  ]")
    }),
    ("no commas", |t| t.replace(",\n", "\n")),
    ("comments", |t| {
        t.replace(",\n", ", // so\n")
            .replace("{\n", "{ /* this */ \n# that\n")
    }),
    ("Python", |t| {
        t.replace(": true", ": True").replace(": false", ": False")
    }),
    ("doubled braces", |t| {
        t.replace('{', "{{").replace('}', "}}")
    }),
    ("ids as text", |t| {
        let lines = t.lines().map(|line| match line.split_once("\"id\": ") {
            Some((before, id)) => format!(
                "{before}\"id\": \"Obstacle {}.0\",",
                id.trim_end_matches(',')
            ),
            None => line.to_string(),
        });
        lines.collect::<Vec<_>>().join("\n")
    }),
    ("other keys", |t| {
        t.replace("\"id\"", "\"ObstacleID\"")
            .replace("\"risk_score\"", "\"OverallRiskScore\"")
    }),
    ("nested", |t| format!("{{\"answer\": {t}}}")),
];

proptest! {
    #[test]
    fn a_verdict_as_asked_for_is_read_strictly(verdict in verdicts()) {
        for text in [written(&verdict), serde_json::to_string(&verdict).unwrap()] {
            let parsed = parse(verdict.task, &text).unwrap();
            prop_assert_eq!(&parsed.verdict, &verdict);
            prop_assert_eq!(parsed.how, ParseQuality::Strict);
        }
    }

    #[test]
    fn slips_change_no_meaning(verdict in verdicts(), first in 0..SLIPS.len(), second in 0..SLIPS.len()) {
        let verdict = with_plain_words(verdict);
        let (one, slip) = SLIPS[first];
        let mut text = slip(&written(&verdict));
        let mut names = one.to_string();
        // Two slips at once, where the second does not undo what the first one means.
        if first != second && !["a draft", "one line", "comments"].contains(&one) && SLIPS[second].0 != "single quotes" {
            text = (SLIPS[second].1)(&text);
            names = format!("{one}, {}", SLIPS[second].0);
        }
        let commented_out = names.contains("one line") && names.contains("comments");
        prop_assume!(!commented_out);
        let parsed = parse(verdict.task, &text);
        let parsed = parsed.map_err(|why| TestCaseError::fail(format!("{names}: {why}\n{text}")))?;
        prop_assert_eq!(parsed.verdict.dangerous, verdict.dangerous, "{}\n{}", names, text);
        let ids = |v: &Verdict| v.obstacles.iter().map(|o| (o.id, o.risk_score)).collect::<Vec<_>>();
        prop_assert_eq!(ids(&parsed.verdict), ids(&verdict), "{}\n{}", names, text);
        let stated = |v: &Verdict| {
            let critical = v.critical.as_ref().map(|all| all.iter().map(|c| (c.id, c.probability)).collect::<Vec<_>>());
            (critical, v.probability)
        };
        prop_assert_eq!(stated(&parsed.verdict), stated(&verdict), "{}\n{}", names, text);
    }

    #[test]
    fn any_text_gives_an_answer_or_a_reason(text in "[{}\\[\\]()\"':,a-c0-9\\\\/*#`“”é\n -]{0,300}|\\PC{0,200}") {
        for task in Task::ALL {
            let _ = read(task, &text);
        }
    }

    #[test]
    fn a_cut_answer_never_says_the_opposite(verdict in verdicts(), share in 0.0..1.0_f64) {
        let text = written(&verdict);
        let mut end = (text.len() as f64 * share) as usize;
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        match parse(verdict.task, &text[..end]) {
            Ok(parsed) => {
                prop_assert_eq!(parsed.verdict.dangerous, verdict.dangerous);
                prop_assert!(matches!(parsed.how, ParseQuality::Repaired(notes) if notes.iter().any(|n| n.contains("breaks off"))));
                for o in &parsed.verdict.obstacles {
                    let whole = verdict.obstacles.iter().find(|v| v.id == o.id).map(|v| v.risk_score);
                    prop_assert_eq!(whole, Some(o.risk_score));
                }
            }
            Err(why) => prop_assert!(end == 0 || why.to_string().contains("breaks off"), "{}", why),
        }
    }
}
