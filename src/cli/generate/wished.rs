//! `--wish`: what attacks are wished to be, in words.

use crate::cli::{Failure, output};
use crate::generation::Wish;
use crate::workflow::{ReadWish, read_wish};

/// Reads the words of a wish, and says what of them is understood.
pub fn read(words: &str) -> Result<Wish, Failure> {
    let ReadWish {
        wish,
        not_understood,
    } = read_wish(words);
    let left_out: Vec<_> = not_understood
        .iter()
        .map(|word| output::visible(word))
        .collect();
    if wish.is_empty() {
        return Err(Failure::input(format!(
            "--wish: none of the words in `{}` says who attacks, how, or from where; try \"a car cuts in from the left lane\", and see `nearmiss help generating`",
            output::visible(words)
        )));
    }
    output::say(&format!("nearmiss: wish: {wish}"));
    if !left_out.is_empty() {
        output::say(&format!(
            "nearmiss: wish: not understood, left out: {}",
            left_out.join(", ")
        ));
    }
    Ok(wish)
}
