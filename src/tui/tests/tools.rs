//! Tools for models, switched in the workbench: what is asked, shown, counted and remembered.

use super::bench::{Bench, answer};
use super::events;
use crate::features::answers::Ask;
use crate::features::batch::request::EstimateBatch;
use crate::model::{Prices, RequestTokens};
use crate::session::{Session, restore};
use nearmiss_ask::llm::{Environment, Registry, ToolLimits};
use nearmiss_study::evaluation::Answer;

/// A workbench that asks a model with a price.
fn asking() -> Bench {
    let mut bench = Bench::bundled();
    let lab = "[lab]\nbase_url = \"http://lab.example\"\n[[lab.prices]]\nmodel = \"small\"\ninput = 1.0\noutput = 2.0\n";
    let registry = Registry::new(&toml::from_str(lab).unwrap()).unwrap();
    let free = registry.free(&Environment::from_lookup(|_| None));
    bench.model.prompt.prices = Prices::new(registry, free, jiff::civil::date(2026, 1, 1));
    bench.model.config.max_tokens = Some(200);
    bench.model.model = "lab/small".into();
    bench
}

fn last_tools(bench: &Bench) -> Option<ToolLimits> {
    let mut all = bench.effects.iter().rev();
    let found = all.find_map(|effect| {
        let asked = effect.request().map(|ask: &Ask| ask.tools);
        let estimated = effect.request();
        asked.or_else(|| estimated.map(|of: &EstimateBatch| of.batch.experiment.parameters().tools))
    });
    found.expect("something was asked")
}

#[test]
fn the_key_switches_what_is_asked_with_and_what_the_header_says() {
    let mut bench = asking();
    bench.press("r");
    assert_eq!(last_tools(&bench), None);
    assert!(!bench.frame(200, 60).contains("+tools"));
    bench.press("space a");
    assert!(bench.frame(200, 60).contains("tools for models on/off"));
    bench.press("u");
    let frame = bench.frame(200, 60);
    assert!(frame.contains("ego · cp+cot+icl+tools"), "{frame}");
    assert!(frame.contains("lab/small may call tools: at most $"));
    assert!(bench.frame(80, 24).contains("all+tools"));
    bench.press("r");
    assert_eq!(last_tools(&bench), Some(ToolLimits::default()));
    let column = bench.model.answers.column().unwrap();
    assert_eq!(column.how, "ego · cp+cot+icl+tools");
    bench.press("space a a");
    assert_eq!(last_tools(&bench), Some(ToolLimits::default()));
    let card = bench.frame(120, 40);
    for words in ["cp+cot+icl+tools", "each with up to 8 rounds of tools"] {
        assert!(card.contains(words), "{card}");
    }
    bench.press("esc space a u space a a");
    assert_eq!(last_tools(&bench), None);
}

#[test]
fn what_calls_no_tools_is_asked_without() {
    let mut bench = asking();
    for model in ["reference/geometry", "recorded/gpt-4o"] {
        bench.model.model = model.into();
        bench.model.tools = false;
        bench.press("space a u");
        let frame = bench.frame(200, 60);
        let words = format!("tools on, but not for {model}; m chooses a model");
        assert!(frame.contains(&words), "{frame}");
        bench.press("r");
        assert_eq!(last_tools(&bench), None, "{model}");
    }
}

#[test]
fn the_price_is_that_of_all_rounds() {
    let mut bench = asking();
    let alone = bench.model.price();
    let tokens = bench.model.prompt.tokens;
    bench.press("space a u");
    let with_tools = bench.model.price();
    let usd = |words: &str| words.strip_prefix("at most $").unwrap().parse::<f64>();
    let (alone, with_tools) = (usd(&alone).unwrap(), usd(&with_tools).unwrap());
    // Nine requests, each with the question and the tools.
    assert!(with_tools > 9.0 * alone, "{with_tools} {alone}");
    let nine = [RequestTokens {
        question: tokens,
        answer: Some(200),
    }; 9];
    let bare = bench.model.prompt.prices.of_requests("lab/small", &nine);
    assert!(with_tools > usd(&bare).unwrap());
    let narrow = bench.frame(80, 24);
    assert!(
        narrow.contains("collision+tools · lab/small · ≤$"),
        "{narrow}"
    );
    bench.press("m");
    let words = format!("at most ${with_tools:.4}");
    assert!(bench.frame(120, 40).contains(&words), "as in the list");
}

#[test]
fn the_answer_of_the_way_that_is_switched_to_is_shown() {
    let mut bench = asking();
    for (keys, how) in [
        ("r", "ego · cp+cot+icl"),
        ("space a u r", "ego · cp+cot+icl+tools"),
    ] {
        bench.press(keys);
        let (id, model) = bench.asked();
        let said = Answer {
            how: how.into(),
            ..answer(&model, true, 301)
        };
        bench.send(events::answered(id, Ok(Box::new(said))));
    }
    let shown = |bench: &Bench| bench.model.answers.column().unwrap().how.clone();
    assert_eq!(shown(&bench), "ego · cp+cot+icl+tools");
    let frame = bench.frame(200, 60);
    assert!(frame.contains("all+tools"), "they differ: {frame}");
    assert!(bench.frame(80, 24).contains("all+t "), "in less room");
    bench.press("space a u");
    assert_eq!(shown(&bench), "ego · cp+cot+icl");
    bench.press("space a u");
    assert_eq!(shown(&bench), "ego · cp+cot+icl+tools");
}

#[test]
fn the_switch_comes_back_unless_the_configuration_says_anew() {
    let left = |configured: bool| {
        let mut bench = asking();
        bench.model.config.tools = configured;
        bench.model.tools = configured;
        bench.press("space a u");
        restore::capture(&bench.model)
    };
    let restored = |session: &Session, configured: bool| {
        let read = Session::parse(&session.text().unwrap(), &session.paths).unwrap();
        let mut again = Bench::empty();
        again.model.config.tools = configured;
        again.model.tools = configured;
        restore::restore(&mut again.model, read, false);
        again.model.tools
    };
    let (on, off) = (left(false), left(true));
    assert!(restored(&on, false), "switched on");
    assert!(!restored(&off, true), "switched off");
    assert!(restored(&on, true) && !restored(&off, false));
    // Sessions of older versions do not say, and older versions read those without a choice.
    let mut bench = asking();
    let old = restore::capture(&bench.model);
    assert!(!old.text().unwrap().contains("tools"));
    assert!(restored(&old, true) && !restored(&old, false));
    bench.press("space a u space a u");
    assert_eq!(restore::capture(&bench.model).tools, None);
}
