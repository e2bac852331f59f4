//! What is wrong with the texts of a picture: the test of every figure.

use crate::text::{HEAD, SMALL, TITLE, width};

/// Part of a text's size that its letters reach above and below the line on which they stand: in
/// DejaVu Sans 0.76 without accents, and 0.24.
const ABOVE: f64 = 0.8;
const BELOW: f64 = 0.24;

/// Text with the box that it covers at most: left, top, right, bottom.
type Boxed<'a> = (&'a str, [f64; 4]);

/// Returns what is wrong in the pictures of some markup: texts that leave their picture or cover
/// each other, numbers that are none, and pictures without any text.
///
/// # Panics
/// Panics if the markup was not written by this crate.
pub fn faults(markup: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let mut count = 0;
    for picture in markup.split("<svg").skip(1) {
        let picture = picture.split("</svg>").next().unwrap_or(picture);
        let Some(size) = attribute(picture, "viewBox") else {
            continue;
        };
        let size: Vec<f64> = size
            .split(' ')
            .map(|v| v.parse().expect("a number"))
            .collect();
        let texts: Vec<Boxed> = picture.split("<text ").skip(1).map(boxed).collect();
        count += texts.len();
        for (k, (name, own)) in texts.iter().enumerate() {
            let [left, top, right, bottom] = *own;
            if left < 0.0 || top < 0.0 || right > size[2] || bottom > size[3] {
                faults.push(format!(
                    "\"{name}\" leaves the picture: {own:.1?} in {size:?}"
                ));
            }
            for (other, its) in &texts[..k] {
                let apart =
                    own[0] >= its[2] || its[0] >= own[2] || own[1] >= its[3] || its[1] >= own[3];
                if !apart {
                    faults.push(format!(
                        "\"{name}\" covers \"{other}\": {own:.1?} and {its:.1?}"
                    ));
                }
            }
        }
        for word in ["NaN", "inf "] {
            let drawn = picture
                .split("<path")
                .skip(1)
                .filter_map(|path| attribute(path, "d"));
            if drawn.into_iter().any(|d| d.contains(word)) {
                faults.push(format!("a path holds {word}"));
            }
        }
    }
    if count == 0 {
        faults.push("there is no text".into());
    }
    faults
}

/// Returns the value of an attribute of the first element.
fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let element = element.split('>').next()?;
    let value = element.split(&format!("{name}=\"")).nth(1)?;
    value.split('"').next()
}

/// Returns a text and the box that it covers at most.
fn boxed(element: &str) -> Boxed<'_> {
    let content = element.split('>').nth(1).expect("the end of a tag");
    let content = content.split('<').next().unwrap_or(content);
    let class = attribute(element, "class").expect("a class");
    let has = |name: &str| class.split(' ').any(|word| word == name);
    let size = if has("title") {
        TITLE
    } else if has("head") {
        HEAD
    } else {
        SMALL
    };
    let plain = content.replace("&#39;", "'").replace("&quot;", "\"");
    let plain = plain
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&");
    let wide = width(&plain, size);
    let (up, down) = (ABOVE * size, BELOW * size);
    let number = |text: &str| -> f64 { text.parse().expect("a number") };
    if let Some(moved) = attribute(element, "transform") {
        let place = moved.split(['(', ')']).nth(1).expect("a place");
        let (x, y) = place.split_once(' ').expect("two numbers");
        let (x, y) = (number(x), number(y));
        return (content, [x - up, y - 0.5 * wide, x + down, y + 0.5 * wide]);
    }
    let place = |name: &str| number(attribute(element, &format!(" {name}")).expect("a place"));
    let (x, y) = (place("x"), place("y"));
    let left = match () {
        () if has("x") => x - 0.5 * wide,
        () if has("y") => x - wide,
        () => x,
    };
    (content, [left, y - up, left + wide, y + down])
}
