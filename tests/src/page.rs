//! Commands that a page of the manual shows, and what it says that they print.

/// A block of commands, marked `sh`, and the block marked `text` right after it.
#[derive(Debug, Default)]
pub struct Block {
    /// Each command as a list of words.
    pub commands: Vec<Vec<String>>,
    /// Lines that the commands print, in their order; none if the page shows none.
    pub printed: Vec<String>,
}

/// Returns all blocks of commands of a page.
///
/// A line that ends in a backslash continues on the next line.
pub fn blocks(page: &str) -> Vec<Block> {
    let (mut blocks, mut line) = (Vec::<Block>::new(), String::new());
    // The kind of the block that is open, and whether nothing stood since the last commands.
    let (mut kind, mut is_next) = (None, false);
    for text in page.lines() {
        match (kind, text.trim().strip_prefix("```")) {
            (None, Some("sh")) => {
                blocks.push(Block::default());
                kind = Some("sh");
            }
            (None, Some("text")) if is_next => kind = Some("text"),
            (None, Some(_)) => kind = Some("other"),
            (None, None) => is_next &= text.trim().is_empty(),
            (Some(_), Some(_)) => {
                is_next = kind == Some("sh");
                kind = None;
            }
            (Some("sh"), None) => {
                line.push_str(text.trim().trim_end_matches('\\'));
                line.push(' ');
                if !text.ends_with('\\') {
                    let words = line.split_whitespace().map(str::to_owned).collect();
                    blocks.last_mut().expect("it is open").commands.push(words);
                    line.clear();
                }
            }
            (Some("text"), None) => {
                let block = blocks.last_mut().expect("text follows commands");
                block.printed.push(text.to_owned());
            }
            (Some(_), None) => {}
        }
    }
    blocks
}

/// Returns the commands of all blocks marked `sh`, each as a list of words.
pub fn commands(page: &str) -> Vec<Vec<String>> {
    let blocks = blocks(page).into_iter();
    blocks.flat_map(|block| block.commands).collect()
}

/// Returns the first line of a page that is not in what its commands printed, in this order.
///
/// Lines agree if their words are the same and their numbers are, rounded to the digits that the
/// page shows. `...` stands for any lines, and at the end of a line for its rest. Durations and
/// rates (numbers of s and of rays/s) differ from run to run and are not compared.
pub fn missing<'a>(shown: &'a [String], printed: &str) -> Option<&'a str> {
    let mut lines = printed.lines();
    let wanted = shown.iter().filter(|line| line.trim() != "...");
    let mut wanted = wanted.map(String::as_str);
    wanted.find(|wanted| !lines.any(|line| agree(wanted, line)))
}

fn agree(shown: &str, printed: &str) -> bool {
    let (shown, is_cut) = match shown.trim_end().strip_suffix("...") {
        Some(start) => (start, true),
        None => (shown, false),
    };
    let words = |line: &str| -> Vec<String> {
        let bare = |word: &str| word.trim_matches(['(', ')', ',', ';', ':']).to_owned();
        line.split_whitespace().map(bare).collect()
    };
    let (shown, printed) = (words(shown), words(printed));
    let pairs = || shown.iter().zip(&printed).enumerate();
    (printed.len() == shown.len() || is_cut && printed.len() > shown.len())
        && pairs().all(|(k, (shown_word, word))| {
            let unit = shown.get(k + 1).map_or("", String::as_str);
            let of_time = ["s", "rays/s", "million"].contains(&unit);
            match (decimals(shown_word), decimals(word)) {
                (Some(_), Some(_)) if of_time => true,
                (Some(digits), Some(all)) => {
                    let [number, exact] = [shown_word, word].map(|w| w.parse::<f64>().unwrap());
                    all >= digits && format!("{exact:.digits$}").parse() == Ok(number)
                }
                _ => shown_word == word,
            }
        })
}

/// Returns how many decimals a number has; none for a word, and for a number with an exponent.
fn decimals(word: &str) -> Option<usize> {
    let is_plain = word.parse::<f64>().is_ok() && !word.contains(['e', 'E', 'n', 'N']);
    is_plain.then(|| word.split_once('.').map_or(0, |(_, behind)| behind.len()))
}
