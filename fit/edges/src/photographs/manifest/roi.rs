//! A region of interest: a rectangle of a photograph.

/// A rectangle of a photograph, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Roi {
    /// First column, from 0.
    pub x: usize,
    /// First row, from 0.
    pub y: usize,
    /// Number of columns, at least 1.
    pub width: usize,
    /// Number of rows, at least 1.
    pub height: usize,
}

impl Roi {
    /// Returns the rectangle of four numbers x, y, width and height, the last two above 0.
    pub fn of(numbers: &[usize]) -> Option<Roi> {
        match *numbers {
            [x, y, width, height] if width > 0 && height > 0 => Some(Roi {
                x,
                y,
                width,
                height,
            }),
            _ => None,
        }
    }

    /// Returns whether the whole rectangle lies in a picture of `width` x `height` pixels.
    pub fn fits(&self, width: usize, height: usize) -> bool {
        let within = |first: usize, size: usize, whole| {
            first.checked_add(size).is_some_and(|end| end <= whole)
        };
        within(self.x, self.width, width) && within(self.y, self.height, height)
    }
}

impl std::fmt::Display for Roi {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "roi = [{}, {}, {}, {}]",
            self.x, self.y, self.width, self.height
        )
    }
}
