//! Formulas of the user: values, units, places of mistakes.

#![allow(clippy::unwrap_used)]

use std::f64::consts::FRAC_PI_2;

use super::super::NoValue;
use super::super::relation::tests::{motion, with};
use super::*;
use crate::metrics::Reading;
use crate::scenario::Motion;

fn own<'t>(id: &'t str, formula: &'t str) -> OwnMeasure<'t> {
    OwnMeasure {
        id,
        formula,
        name: None,
        unit: None,
        danger: Danger::Neutral,
        threshold: None,
    }
}

fn one(said: OwnMeasure<'_>) -> Result<Measure, String> {
    let mut all = OwnMeasures::new(&[said]).map_err(|mistakes| mistakes[0].words.clone())?;
    Ok(all.all.remove(0).measure())
}

fn measure_of(formula: &str) -> Measure {
    one(own("mine", formula)).unwrap_or_else(|words| panic!("{formula}: {words}"))
}

fn words(formula: &str) -> String {
    one(own("mine", formula)).expect_err(formula)
}

/// 10 m/s, and 10 m before it another of 4 m length with this speed.
fn follow(speed: f64) -> (Motion, Motion) {
    (motion(0.0, 0.0, 0.0, 10.0), motion(14.0, 0.0, 0.0, speed))
}

fn value(formula: &str, (ego, other): (Motion, Motion)) -> Reading {
    let measure = measure_of(formula);
    with(ego, other, |encounter| measure.evaluate(encounter))
}

#[track_caller]
fn gives(formula: &str, expected: f64) {
    let found = value(formula, follow(5.0)).value().unwrap();
    assert!((found - expected).abs() < 1e-6, "{formula} = {found}");
}

#[test]
fn formulas_are_worked_out_by_the_precedence_of_their_operators() {
    gives("1 + 2 * 3 ^ 2 - 4 / 2", 17.0);
    gives("-3 ^ 2", -9.0);
    gives("2 * -3", -6.0);
    gives("(1 + 2) * 3", 9.0);
    gives("10 - 4 - 3", 3.0);
    gives("1 > 2 || 2 > 1 && !(1 > 2) ? 7 : 8", 7.0);
    gives("1 > 2 ? 1 : 2 > 3 ? 2 : 3", 3.0);
    gives(
        "min(3, 1, 2) + max(4, 5) + abs(-2) + sqrt(9) + exp(0) + log(1)",
        12.0,
    );
    gives("ttc", 2.0);
    gives("distance / speed", 1.0);
    gives("ttc < 2.5 s ? 1 s : distance / speed", 1.0);
    gives("(ego.speed - obstacle.speed) ^ 2 / (2 * distance)", 1.25);
    gives("2m^2 / 1 m/s^2 * 1e0", 2.0);
    let crossing = (
        motion(-20.0, 0.0, 0.0, 10.0),
        motion(0.0, -20.0, -FRAC_PI_2, -3.0),
    );
    let angle = value("heading_difference / 1 rad", crossing)
        .value()
        .unwrap();
    assert!((angle - FRAC_PI_2).abs() < 1e-12);
    assert_eq!(value("obstacle.speed", crossing), Reading::Value(3.0));
}

#[test]
fn what_has_no_value_is_compared_with_nothing_and_is_needed_only_where_it_is_asked() {
    let apart = || follow(12.0);
    let none = Reading::None(NoValue::NoContact);
    assert_eq!(value("ttc + 1", apart()), none);
    assert_eq!(value("ttc < 2 ? 1 : 0", apart()), Reading::Value(0.0));
    assert_eq!(value("ttc >= 2 ? 1 : 0", apart()), Reading::Value(0.0));
    assert_eq!(value("!(ttc < 2) ? 1 : 0", apart()), Reading::Value(1.0));
    assert_eq!(value("ttc != 2 ? 1 : 0", apart()), Reading::Value(0.0));
    assert_eq!(value("ttc < 2 ? ttc : 9", apart()), Reading::Value(9.0));
    assert_eq!(value("distance > 0 ? ttc : 9", apart()), none);
    let endless = Reading::None(NoValue::NotFinite);
    for formula in [
        "1 / 0",
        "0 / 0",
        "sqrt(-1)",
        "log(0)",
        "exp(1e9)",
        "1 / (1 / 0)",
    ] {
        assert_eq!(value(formula, apart()), endless, "{formula}");
    }
}

#[test]
fn units_follow_from_the_operands() {
    for (formula, unit) in [
        ("ttc", "s"),
        ("distance / speed", "s"),
        ("speed ^ 2 / 2 / distance", "m/s²"),
        ("sqrt(2 * distance / drac)", "s"),
        ("ttc < 2 ? 1 : distance / speed", "s"),
        ("risk * heading_difference", ""),
        ("1 / ttc", "1/s"),
        ("exp(-ttc / 1 s)", ""),
        ("2 + 3", ""),
        ("distance ^ -2", "1/m²"),
        ("min(ttc, 10)", "s"),
    ] {
        assert_eq!(measure_of(formula).unit, unit, "{formula}");
    }
    let with_unit = |unit| {
        one(OwnMeasure {
            unit: Some(unit),
            ..own("mine", "distance / speed")
        })
    };
    assert!(with_unit("s").is_ok());
    assert!(
        with_unit("m")
            .unwrap_err()
            .starts_with("the formula gives s, not m")
    );
    assert!(with_unit("km").unwrap_err().contains("unknown unit `km`"));
    let bare = one(OwnMeasure {
        unit: Some("s"),
        ..own("mine", "1 + 1")
    });
    assert_eq!(bare.unwrap().unit, "s");
}

#[test]
fn mistakes_have_their_place_and_say_what_to_do() {
    for (formula, said) in [
        (
            "ttc + distance",
            "column 1, `[ttc + distance]`: a sum needs one unit, but `ttc` has s and `distance` m;",
        ),
        (
            "1 + (ttc < distance ? 1 : 2)",
            "column 6, `1 + ([ttc < distance] ? 1 : 2)`: a comparison needs",
        ),
        (
            "min(ttc, risk)",
            "min needs one unit, but `ttc` has s and `risk` no unit",
        ),
        (
            "distanse * 2",
            "column 1, `[distanse] * 2`: unknown name `distanse`; did you mean `distance`",
        ),
        (
            "ttc < 2",
            "`[ttc < 2]`: this holds or not and is no number; make one of it by",
        ),
        ("1 < ttc < 2", "`[1 < ttc] < 2`: this holds or not"),
        (
            "ttc ? 1 : 2",
            "`[ttc] ? 1 : 2`: this is a number; compare it, such as `ttc > 0`",
        ),
        ("ttc +", "column 6, `ttc +[]`: expected a number, a measure"),
        (
            "ttc distance",
            "`ttc [distance]`: expected an operator such as + or <, or the end, not `distance`",
        ),
        ("(ttc", "expected `)`"),
        ("ttc = 2", "`ttc [=] 2`: `=` is not known; `==` compares"),
        (
            "ttc ^ 0.5",
            "a power must be a whole number up to 9, not `0.5`; sqrt()",
        ),
        ("sqrt(ttc)", "s has no square root"),
        (
            "exp(ttc)",
            "exp takes a number without unit, not one in s; divide by a reference, such as 1 s",
        ),
        ("min(ttc)", "min takes two numbers or more"),
        ("mine + 1", "`mine` is part of itself"),
        ("1.2.3", "column 4"),
        ("", "column 1, `[]`: expected a number"),
        ("ttc · 2", "`·` is not known; a formula has"),
    ] {
        let found = words(formula);
        assert!(found.contains(said), "{formula}: {found}");
    }
    assert!(words(&"-".repeat(501)).contains("more than 500 bytes"));
    assert!(words(&"(".repeat(20)).contains("expected a number"));
    assert!(words(&"(".repeat(500)).contains("deep"));
}

#[test]
fn ids_are_plain_and_free_and_thresholds_need_a_danger() {
    for id in [
        "ttc",
        "speed",
        "min",
        "s",
        "obstacles",
        "risk_reason",
        "dce",
    ] {
        let taken = one(own(id, "1"));
        assert!(taken.unwrap_err().contains("taken"), "{id}");
    }
    for id in ["", "My", "2nd", "a-b", "é", "_a"] {
        assert!(one(own(id, "1")).unwrap_err().contains("a to z"), "{id}");
    }
    let threshold = OwnMeasure {
        threshold: Some(1.0),
        ..own("mine", "ttc")
    };
    assert!(one(threshold).unwrap_err().contains("danger"));
}

#[test]
fn measures_use_each_other_but_not_themselves_and_stay_small() {
    let all = [own("b", "a * 2"), own("a", "ttc")];
    let found = OwnMeasures::new(&all).unwrap();
    assert_eq!(
        found
            .all
            .iter()
            .map(|one| one.unit.to_string())
            .collect::<Vec<_>>(),
        ["s", "s"]
    );
    let circle = OwnMeasures::new(&[own("a", "b"), own("b", "c"), own("c", "a")]).unwrap_err();
    assert!(
        circle
            .iter()
            .any(|mistake| mistake.words.contains("part of itself")),
        "{circle:?}"
    );
    // Each is twice the one before.
    let ids: Vec<String> = (0..20).map(|n| format!("x{n}")).collect();
    let formulas: Vec<String> = std::iter::once("ttc".into())
        .chain(ids.iter().map(|id| format!("{id} + {id}")))
        .collect();
    let grown: Vec<_> = ids
        .iter()
        .zip(&formulas)
        .map(|(id, formula)| own(id, formula))
        .collect();
    let words = &OwnMeasures::new(&grown).unwrap_err()[0].words;
    assert!(words.contains("more than 1000 parts"), "{words}");
}

#[test]
fn the_deepest_formulas_that_use_each_other_fit_the_stack() {
    let ids: Vec<String> = (0..32).map(|n| format!("deep{n}")).collect();
    let (open, close) = ("(".repeat(20), ")".repeat(20));
    let formulas: Vec<String> = (1..32)
        .map(|n| format!("{open}deep{n}{close}"))
        .chain(["ttc".into()])
        .collect();
    let all: Vec<_> = { ids.iter().zip(&formulas) }
        .map(|(id, formula)| own(id, formula))
        .collect();
    assert!(OwnMeasures::new(&all).is_ok());
}

#[test]
fn what_they_are_follows_from_their_operands() {
    let is = |formula: &str| {
        let measure = measure_of(formula);
        (
            measure.reads_ahead,
            measure.is_of_places(),
            measure.mirrored,
        )
    };
    assert_eq!(is("distance / speed"), (false, true, Mirrored::Kept));
    assert_eq!(
        is("distance + pet * obstacle.speed"),
        (true, false, Mirrored::Kept)
    );
    assert_eq!(is("gap_lat"), (false, true, Mirrored::Negated));
    assert_eq!(is("abs(gap_lat)").2, Mirrored::Kept);
}
