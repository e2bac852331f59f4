//! A region of a photograph.

/// A rectangle of a photograph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Roi {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
}

impl Roi {
    /// Whether all of it lies in a picture of `width` x `height` pixels.
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
