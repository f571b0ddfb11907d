//! `--wish`: what attacks are wished to be, in words.

use crate::{Failure, output};
use nearmiss_drive::generation::Wish;
use nearmiss_workflow::{ReadWish, read_wish};

/// Reads the words of a wish, and says what of them is understood.
pub fn read(words: &str) -> Result<Wish, Failure> {
    let ReadWish {
        wish,
        not_understood,
    } = read_wish(words);
    let unknown: Vec<_> = not_understood
        .iter()
        .map(|word| format!("`{}`", output::visible(word)))
        .collect();
    // What is left out would widen the search, or turn it round.
    if !unknown.is_empty() {
        return Err(Failure::input(format!(
            "--wish: {} not understood: use other words or leave them out, see `nearmiss help wishes`; --attacker names an obstacle by its id, --attackers how many attack together",
            unknown.join(", ")
        )));
    }
    if wish.is_empty() {
        return Err(Failure::input(format!(
            "--wish: none of the words in `{}` says who attacks, how, or from where; try \"a car cuts in from the left lane\", and see `nearmiss help wishes`",
            output::visible(words)
        )));
    }
    output::say(&format!("nearmiss: wish: {wish}"));
    Ok(wish)
}
