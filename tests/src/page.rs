//! Commands that a page of the manual shows.

/// Returns the commands of all blocks marked `sh`, each as a list of words.
///
/// A line that ends in a backslash continues on the next line.
pub fn commands(page: &str) -> Vec<Vec<String>> {
    let (mut commands, mut inside, mut line) = (Vec::new(), false, String::new());
    for text in page.lines().map(str::trim) {
        if text.starts_with("```") {
            inside = text == "```sh";
        } else if inside {
            line.push_str(text.trim_end_matches('\\'));
            line.push(' ');
            if !text.ends_with('\\') {
                commands.push(line.split_whitespace().map(str::to_owned).collect());
                line.clear();
            }
        }
    }
    commands
}
