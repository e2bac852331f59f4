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
    /// Absorbed by a facet, or met one from behind. In older tables, which have no
    /// [`Fate::ReflectedByFront`], also reflected by the front face on the way in or out.
    Absorbed,
    /// Hit nothing.
    Missed,
    /// Retroreflected, but the shift lies outside the histogram.
    OutOfRange,
    /// Was stopped after the greatest allowed number of reflections.
    BounceLimit,
    /// Was sent back inside by the front face (of a plate, the back face), and had not left when it
    /// was given up: at once without `--front trapped`.
    Trapped,
    /// Reflected by the front face on the way in.
    ReflectedByFront,
}

impl Fate {
    /// All fates, in the order of the file.
    pub const ALL: [Fate; 12] = [
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
        Fate::ReflectedByFront,
    ];

    /// Returns the fates of tables whose front face treats light in this way, in the order of the
    /// file.
    ///
    /// `reflects` says whether the front face reflects a part of all light: losses are counted, and
    /// the refractive index is above 1.
    pub fn of(front: Front, reflects: bool) -> &'static [Fate] {
        match front {
            _ if reflects => &Fate::ALL,
            Front::Once => &Fate::ALL[..Fate::Trapped as usize],
            Front::Trapped => &Fate::ALL[..Fate::ReflectedByFront as usize],
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
            Fate::ReflectedByFront => "reflected_by_front",
        }
    }
}
