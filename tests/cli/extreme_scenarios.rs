//! Every command on scenarios in which something is not there at all, or out of all proportion.

use std::time::{Duration, Instant};

use super::support::program::Home;
use super::{CUT_IN, bundled_xml};

fn without(xml: &str, names: &[&str]) -> String {
    let mut xml = xml.to_owned();
    for name in names {
        let (open, close) = (format!("<{name} id="), format!("</{name}>"));
        while let Some(from) = xml.find(&open) {
            let to = xml[from..].find(&close).unwrap() + from + close.len();
            xml.replace_range(from..to, "");
        }
    }
    xml
}

const OBSTACLES: [&str; 2] = ["dynamicObstacle", "staticObstacle"];

/// Names and texts; each with an id that can be the ego, where there is one.
fn files() -> Vec<(&'static str, String)> {
    let xml = bundled_xml(CUT_IN);
    let close = "</dynamicObstacle>";
    let end = xml.find(close).unwrap() + close.len();
    let alone = xml[..end].to_owned() + &without(&xml[end..], &OBSTACLES);
    let steps = |dt: &str| xml.replace("timeStepSize=\"0.1\"", &format!("timeStepSize=\"{dt}\""));
    vec![
        ("nobody.xml", without(&xml, &OBSTACLES)),
        ("one.xml", alone),
        ("noroad.xml", without(&xml, &["lanelet"])),
        ("noproblem.xml", without(&xml, &["planningProblem"])),
        ("long.xml", steps("10")),
        ("short.xml", steps("0.001")),
        ("tiny.xml", steps("0.000001")),
        ("huge.xml", steps("1000000000")),
        (
            "late.xml",
            xml.replace("<intervalEnd>90<", "<intervalEnd>1000000000<"),
        ),
    ]
}

#[test]
fn every_command_ends_with_a_sentence_whatever_is_missing() {
    let home = Home::new();
    for (name, xml) in files() {
        let id = xml
            .split("<dynamicObstacle id=\"")
            .nth(1)
            .and_then(|rest| rest.split('"').next())
            .unwrap_or("1");
        let ego = ["--ego", id];
        home.write(name, &xml);
        let commands: [&[&str]; 12] = [
            &["inspect", name],
            &["metrics", name],
            &["prompt", "describe", name],
            &["prompt", "describe", name, "--frame", "metrics"],
            &["prompt", "show", name],
            &["ask", name],
            &["ask", name, "--task", "safety"],
            &["render", name],
            &[
                "render",
                name,
                "--what",
                "both",
                "--format",
                "png",
                "-o",
                "both.png",
                "--overwrite",
            ],
            &["render", name, "--what", "screen"],
            &["plan", name, "--set=horizon=0.5", "--set=replan=5"],
            &["convert", name, "-o", "again.xml", "--overwrite"],
        ];
        for command in commands {
            let takes_ego = !["inspect", "plan", "convert"].contains(&command[0]);
            let with_ego = takes_ego.then(|| [command, &ego].concat());
            for arguments in std::iter::once(command.to_vec()).chain(with_ego) {
                let begun = Instant::now();
                // A panic fails in there.
                let ended = home.run(&arguments);
                let took = begun.elapsed();
                assert!(
                    matches!(ended.status, Some(0..=2)),
                    "{arguments:?}: {ended:?}"
                );
                assert!(
                    ended.status == Some(0) || !ended.stderr.is_empty(),
                    "{arguments:?} says nothing"
                );
                assert!(took < Duration::from_secs(60), "{arguments:?}: {took:?}");
            }
        }
    }
}
