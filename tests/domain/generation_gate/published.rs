//! The example that the paper's authors published: an original, and the variant that a model made of it.

use std::collections::BTreeSet;

use nearmiss::formats::commonroad;
use nearmiss::generation::{Gate, Reason, Refusal};

use super::built::names;
use super::support::recorded::shared;

/// What is wrong with the variant's car: the kind, the steps, and the largest value. The first nine were worked out
/// from the file's numbers by other means; the last four take the single-track model.
const EXPECTED: [(&str, &[i64], f64); 13] = [
    ("start", &[0], 0.1646),
    ("jump", &[30], 10.7322),
    (
        "velocity of the displacement",
        &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23,
            24, 25, 27, 28, 29, 30,
        ],
        23.8841,
    ),
    (
        "heading along motion",
        &[
            0, 2, 3, 4, 5, 6, 7, 8, 9, 13, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28,
            29, 30,
        ],
        1.2054,
    ),
    (
        "said acceleration",
        &[
            1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 26, 27, 28, 29, 30,
        ],
        56.0,
    ),
    ("jerk", &[0, 1, 3, 6, 8, 19, 21, 30, 31], 629.22),
    (
        "acceleration",
        &[
            0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 30,
        ],
        60.0,
    ),
    (
        "friction circle",
        &[
            0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 30,
        ],
        72.641,
    ),
    ("yaw rate", &[30], 9.972),
    ("steering rate", &[0, 1, 4, 8, 9, 20, 30, 31], 3.2659),
    (
        "displacement",
        &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 22, 28, 29,
        ],
        2.3803,
    ),
    ("slip", &[21, 23, 24, 25, 26, 27, 30], 9.1497),
    (
        "heading",
        &[2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 30],
        0.9525,
    ),
];

#[test]
fn each_violation_of_the_published_example_is_named() {
    let Some(folder) = shared("from-words-to-collisions/Generation") else {
        return;
    };
    let read =
        |name: &str| commonroad::read_file(&folder.join(name).join(format!("{name}.xml"))).unwrap();
    let original = read("BEL_Antwerp-1_14_T-1");
    let variant = read("BEL_Antwerp-1_14_T-1n");
    // The recording is rounded to 4 digits.
    let gate = Gate::new(&original).rounded_to(5e-5);
    let compared = gate.compare(&variant, None);
    // Besides moving a car, the variant makes every urban lanelet one of an unknown type.
    let whole: Vec<_> = compared.refusals.iter().map(|r| &r.reason).collect();
    assert_eq!(whole, [&Reason::Differs("the attributes of the road")]);
    assert_eq!(compared.changed.len(), 1);
    let judged = &compared.changed[0];
    assert_eq!((judged.change.obstacle, judged.from), (30762, 0));
    let found = judged.verdict.as_ref().expect_err("refused");
    for (name, steps, worst) in EXPECTED {
        let named = found.iter().filter(|r| r.reason.name() == name);
        let named: Vec<&Refusal> = named.collect();
        let at: BTreeSet<i64> = named.iter().filter_map(|r| r.step).collect();
        assert_eq!(at, steps.iter().copied().collect(), "{name}");
        let value = named.iter().filter_map(|r| r.value).fold(0.0, f64::max);
        assert!((value - worst).abs() < 0.001, "{name}: {value}");
    }
    let expected: BTreeSet<_> = EXPECTED.iter().map(|(name, ..)| *name).collect();
    assert_eq!(names(found), expected);
    // What follows it is the recording again, and the recording keeps the limits there.
    assert!(found.iter().all(|r| r.step <= Some(31)));
}
