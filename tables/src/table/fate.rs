//! Fates of rays.

use crate::options::Front;

/// Fate of a ray. The names and their order are those of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(usize)]
pub enum Fate {
    /// Came back by a path whose linear map is -I, with a shift inside the histogram.
    ///
    /// In a plate the map is diag(-1, -1, 1). In bodies of glass the exit direction decides.
    Retroreflected,
    /// Left the cell after one reflection.
    LeftAfter1,
    /// Left the cell after two reflections.
    LeftAfter2,
    /// Left antiparallel by a path whose linear map is not -I.
    AntiparallelOther,
    /// Left in another direction after three reflections or more.
    Deviated,
    /// Went through a facet where total internal reflection failed.
    Transmitted,
    /// Absorbed by a facet, met one from behind, or was reflected by the front face on the way in
    /// or out.
    Absorbed,
    /// Hit nothing.
    Missed,
    /// Retroreflected, but the shift lies outside the histogram.
    OutOfRange,
    /// Was stopped after the greatest allowed number of reflections.
    BounceLimit,
    /// Had not left through the front face when it was given up. Only tables with `--front trapped`
    /// have it.
    Trapped,
}

impl Fate {
    /// All fates, in the order of the file.
    pub const ALL: [Fate; 11] = [
        Fate::Retroreflected,
        Fate::LeftAfter1,
        Fate::LeftAfter2,
        Fate::AntiparallelOther,
        Fate::Deviated,
        Fate::Transmitted,
        Fate::Absorbed,
        Fate::Missed,
        Fate::OutOfRange,
        Fate::BounceLimit,
        Fate::Trapped,
    ];

    /// Returns the fates of tables whose front face treats light in this way, in the order of the
    /// file.
    pub fn of(front: Front) -> &'static [Fate] {
        match front {
            Front::Once => &Fate::ALL[..Fate::Trapped as usize],
            Front::Trapped => &Fate::ALL,
        }
    }

    /// Returns the name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Fate::Retroreflected => "retroreflected",
            Fate::LeftAfter1 => "left_after_1",
            Fate::LeftAfter2 => "left_after_2",
            Fate::AntiparallelOther => "antiparallel_other",
            Fate::Deviated => "deviated",
            Fate::Transmitted => "transmitted",
            Fate::Absorbed => "absorbed",
            Fate::Missed => "missed",
            Fate::OutOfRange => "out_of_range",
            Fate::BounceLimit => "bounce_limit",
            Fate::Trapped => "trapped",
        }
    }
}
