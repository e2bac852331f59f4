//! Values of options, each with a name.

use crate::options::word::Named;

/// Method that finds the distribution of shifts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Method {
    /// Exact method if the cell allows it, otherwise rays; a table names the method that was used.
    #[cfg_attr(
        feature = "cli",
        value(help = "The exact method if the cell allows it, otherwise rays")
    )]
    Auto,
    /// Sampled rays.
    Rays,
    /// Beams: no sampling, planar facets only.
    Exact,
}

/// Sampler: the way in which the points of a stream of samples are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Sampler {
    /// Independent points.
    Random,
    /// Owen-scrambled Sobol points.
    Sobol,
}

/// Material behind the facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Back {
    /// Mirror, which reflects at every angle.
    Mirror,
    /// Nothing: facets reflect only where reflection is total.
    Tir,
}

/// Losses of light at surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Losses {
    /// No losses: mirrors reflect all light, the front face lets all light through.
    None,
    /// Losses by Fresnel's equations at the front face and at each facet, for unpolarised light.
    Fresnel,
}

/// Treatment of light that meets the front face from inside.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Front {
    /// Light leaves or ends there: it is followed once through the front face
    #[default]
    Once,
    /// Light that the front face reflects goes on to the neighbouring cubes: all of it beyond the
    /// critical angle, and with --losses fresnel Fresnel's share below
    Trapped,
}

/// Optical elements, by the image that they make.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Element {
    /// Sheet that sends light back: the image is where the object is
    #[default]
    Retroreflector,
    /// Micro-mirror array plate that lets light through: the image is the object's mirror image
    /// behind the plate
    Plate,
}

/// Source of the normals about which facets reflect.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum NormalsFrom {
    /// Normals of the facets themselves: facets are planes.
    #[default]
    Facets,
    /// Normals of the mesh file, interpolated between a facet's corners: facets stand for a curved
    /// face.
    File,
}

macro_rules! named {
    ($($type:ident { $($value:ident = $name:literal),* })*) => {
        $(
            impl $type {
                /// Returns the name in options and in tables.
                pub const fn name(self) -> &'static str {
                    match self {
                        $($type::$value => $name,)*
                    }
                }
            }

            impl Named for $type {
                const ALL: &'static [$type] = &[$($type::$value),*];

                fn name(self) -> &'static str {
                    $type::name(self)
                }
            }
        )*
    };
}

named! {
    Method { Auto = "auto", Rays = "rays", Exact = "exact" }
    Sampler { Random = "random", Sobol = "sobol" }
    Back { Mirror = "mirror", Tir = "tir" }
    Losses { None = "none", Fresnel = "fresnel" }
    Front { Once = "once", Trapped = "trapped" }
    Element { Retroreflector = "retroreflector", Plate = "plate" }
    NormalsFrom { Facets = "facets", File = "file" }
}

#[cfg(all(test, feature = "cli"))]
mod tests {
    use super::*;
    use clap::ValueEnum;

    /// Checks that a value has one name on the command line and in the file.
    #[test]
    fn names_are_those_of_the_command_line() {
        fn same<T: Named + ValueEnum>() -> usize {
            let ours = T::ALL.iter().map(|value| value.name().to_owned());
            let values = T::value_variants().iter();
            let theirs =
                values.map(|value| value.to_possible_value().unwrap().get_name().to_owned());
            let (ours, theirs) = (Vec::from_iter(ours), Vec::from_iter(theirs));
            assert_eq!(ours, theirs);
            ours.len()
        }
        let values = same::<Method>() + same::<Sampler>() + same::<Back>();
        let more = same::<Losses>() + same::<Element>() + same::<NormalsFrom>();
        assert_eq!(values + more + same::<Front>(), 15);
    }
}
