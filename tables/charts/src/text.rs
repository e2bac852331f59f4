//! Text of charts: how wide it is, where it is wrapped, and what it must not hold.

/// Escapes text for any place of a picture or page, attributes too.
///
/// Characters that no XML may hold become the replacement character.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(character),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// Replaces the hyphen of a number by the typographic minus.
pub fn minus(number: String) -> String {
    number.replace('-', "\u{2212}")
}

/// Size of the numbers and names of a chart, of the heads of panels, and of titles, pixels, as in
/// the style sheet.
pub(crate) const SMALL: f64 = 11.0;
pub(crate) const HEAD: f64 = 12.0;
pub(crate) const TITLE: f64 = 14.0;

/// Height of a line of text, pixels.
pub(crate) const LINE: f64 = 15.0;

/// Returns a width that a text does not exceed, pixels.
///
/// The widest font that the style sheet names is DejaVu Sans. Its advances in parts of the size
/// are: digits 0.636, small letters at most 0.635 but for m (0.974) and w (0.818), capitals at most
/// 0.787 but for M (0.863) and W (0.989), signs of sums 0.838. A letter of another script is
/// taken for a square. Titles are bold, at most 1.18 times as wide.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let advance = |letter: char| match letter {
        'i' | 'j' | 'l' | ' ' | '.' | ',' | ':' | ';' | '|' | '\'' | '(' | ')' | '[' | ']'
        | '/' | '-' | 'f' | 't' | 'r' | 'I' | '!' => 0.42,
        '°' | '"' | '*' => 0.51,
        '+' | '<' | '=' | '>' | '~' | '#' | '\u{2212}' | '\u{d7}' | 'w' => 0.84,
        '0'..='9' | 'a'..='l' | 'n'..='z' | '$' | '?' | '_' | '\u{3c3}' => 0.64,
        'm' | 'M' | 'W' | '%' | '@' | '&' => 1.0,
        ' '..='~' => 0.79,
        _ => 1.0,
    };
    let weight = if size == TITLE { 1.18 } else { 1.0 };
    size * weight * text.chars().map(advance).sum::<f64>()
}

/// Breaks a text into lines of at most `most` pixels, at spaces where there are some.
pub(crate) fn wrap(text: &str, size: f64, most: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is a first line");
        let longer = format!("{line} {word}");
        if line.is_empty() {
            *line = word.into();
        } else if width(&longer, size) <= most {
            *line = longer;
        } else {
            lines.push(word.into());
        }
        // A word such as a path may be longer than a line.
        while let Some(line) = lines.pop_if(|line| width(line, size) > most) {
            let fits = |&(end, _): &(usize, char)| width(&line[..end], size) <= most;
            // Every line holds one letter at least.
            let mut ends = line.char_indices().skip(1);
            let Some(first) = ends.next() else {
                lines.push(line);
                break;
            };
            let (end, _) = ends.take_while(fits).last().unwrap_or(first);
            lines.extend([line[..end].to_owned(), line[end..].to_owned()]);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_name_becomes_markup() {
        assert_eq!(
            escape("<script>'\"&\u{1}\u{ffff}é</script>"),
            "&lt;script&gt;&#39;&quot;&amp;\u{fffd}\u{fffd}é&lt;/script&gt;"
        );
    }

    /// Checks that nothing is lost, and that lines fit, except where one letter is too wide.
    #[test]
    fn lines_fit_and_hold_every_letter() {
        let long = "MTF of a/very/long/path/to/a_sheet_with_a_name.h5: 0° und 日本語";
        let mut cases = 0;
        for most in [1.0, 20.0, 60.0, 200.0, 2_000.0] {
            let lines = wrap(long, HEAD, most);
            let bare = |text: &str| text.replace(' ', "");
            assert_eq!(bare(&lines.concat()), bare(long));
            for line in &lines {
                assert!(
                    width(line, HEAD) <= most || line.chars().count() == 1,
                    "{line}"
                );
                cases += 1;
            }
        }
        assert!(cases > 60, "{cases}");
        assert_eq!(wrap(long, HEAD, 2_000.0), [long]);
    }
}
