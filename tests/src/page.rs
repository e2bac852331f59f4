//! The commands that a page prints.

/// The commands of the blocks marked `sh`; a line that ends in a backslash goes on in the next one.
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
