//! Errors in user files, formatted for display.

use nearmiss_scene::description::visible;

/// Mistakes that are safe to show, whatever they quote.
pub fn all_visible(mistakes: Vec<String>) -> Vec<String> {
    let shown = |mistake: String| visible(&mistake).into_owned();
    mistakes.into_iter().map(shown).collect()
}

/// The first mistake, and how many more there are.
pub fn first(mistakes: &[String]) -> String {
    match mistakes {
        [] => String::new(),
        [one] => one.clone(),
        [one, more @ ..] => format!("{one} (and {} more)", more.len()),
    }
}
