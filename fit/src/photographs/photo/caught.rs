//! The border of the decoders: a panic of theirs is an error of the file.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// True while this thread is within a decoder.
    static IS_DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Calls a decoder. A panic prints nothing and ends here.
///
/// # Errors
/// Returns the message of a panic.
pub(crate) fn caught<T>(decoder: impl FnOnce() -> T) -> Result<T, String> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let print = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_DECODING.get() {
                print(panic);
            }
        }));
    });
    let before = IS_DECODING.replace(true);
    // What the decoder held is lost with it.
    let result = catch_unwind(AssertUnwindSafe(decoder));
    IS_DECODING.set(before);
    result.map_err(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or(panic.downcast_ref::<String>().map(String::as_str));
        format!("its decoder failed: {}", text.unwrap_or("no reason given"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A panic ends at the border with its message, also one in a decoder within another and in
    /// threads of rayon. What comes after it is whole.
    #[test]
    fn a_panic_ends_at_the_border() {
        use rayon::prelude::*;
        let words = ["one", "two"];
        let at = std::hint::black_box(words.len());
        let panics: [Result<&str, String>; 3] = [
            caught(|| words[at]),
            caught(|| caught(|| words[at]).unwrap_or("inner")),
            caught(|| {
                (0..9)
                    .into_par_iter()
                    .map(|i| words[i])
                    .max()
                    .unwrap_or("none")
            }),
        ];
        let told = |result: &Result<&str, String>| match result {
            Ok(word) => (*word).to_owned(),
            Err(text) => text.chars().take(40).collect(),
        };
        let told = panics.each_ref().map(told);
        assert_eq!(told[0], "its decoder failed: index out of bounds:");
        assert_eq!(told[1], "inner");
        assert!(told[2].starts_with("its decoder failed"), "{}", told[2]);
        assert_eq!(caught(|| words[1]), Ok("two"));
        assert!(!IS_DECODING.get());
    }
}
