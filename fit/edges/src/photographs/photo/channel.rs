//! Choice of the plane of a photograph, and of the meaning of its stored values.

use crate::photographs::photo::Transfer;

/// Rec. 709 weights of linear red, green and blue in luminance (ITU-R BT.709-6, item 3.2).
pub(crate) const REC709: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// The plane of a colour photograph that is used.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub enum Channel {
    /// Rec. 709 luminance of R, G, B, or the only plane of a monochrome file.
    #[default]
    Luminance,
    /// Linear red.
    Red,
    /// Linear green.
    Green,
    /// Linear blue.
    Blue,
    /// A channel of an EXR by its full name, such as `diffuse.R` or `L`.
    Named(String),
}

impl Channel {
    /// The primaries: red, green, blue.
    pub const PRIMARIES: [Channel; 3] = [Channel::Red, Channel::Green, Channel::Blue];

    /// Returns the channel that has this name in a manifest: `luminance`, `red`, `green`, `blue`
    /// (or `r`, `g`, `b`). Any other name is that of an EXR channel.
    pub fn from_name(name: &str) -> Channel {
        match name {
            "luminance" => Channel::Luminance,
            "r" | "red" => Channel::Red,
            "g" | "green" => Channel::Green,
            "b" | "blue" => Channel::Blue,
            other => Channel::Named(other.to_owned()),
        }
    }
}

impl std::fmt::Display for Channel {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Channel::Luminance => "luminance",
            Channel::Red => "red",
            Channel::Green => "green",
            Channel::Blue => "blue",
            Channel::Named(name) => name,
        })
    }
}

/// Options for the decoding of a photograph.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Decode {
    /// Relation of stored values to light. With `None` the file decides, and if it says nothing,
    /// its format: linear for EXR, floats and 16-bit integers, and sRGB for 8-bit integers.
    pub transfer: Option<Transfer>,
    /// The plane that is used.
    pub channel: Channel,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for name in ["luminance", "red", "green", "blue", "diffuse.R"] {
            assert_eq!(Channel::from_name(name).to_string(), name);
        }
    }
}
