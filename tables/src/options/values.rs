//! The values of options that have a name each.

use crate::options::word::Named;

/// How the distribution of shifts is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Method {
    /// The exact method where the cell allows it, else rays. A table names the one that it was.
    #[cfg_attr(
        feature = "cli",
        value(help = "The exact method where the cell allows it, else rays")
    )]
    Auto,
    /// Sampled rays.
    Rays,
    /// Beams: no sampling, planar facets only.
    Exact,
}

/// How the points of a stream of samples are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Sampler {
    /// Independent points.
    Random,
    /// Owen-scrambled Sobol points.
    Sobol,
}

/// What facets are backed with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Back {
    /// A mirror: reflects at every angle.
    Mirror,
    /// Nothing: reflects where reflection is total.
    Tir,
}

/// What surfaces take from the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Losses {
    /// Nothing: mirrors reflect all, the front face lets all through.
    None,
    /// What Fresnel's equations say of the front face and of each facet, for unpolarised light.
    Fresnel,
}

/// Kinds of element, by the image that they make.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Element {
    /// Sends light back: the image is where the object is
    #[default]
    Retroreflector,
    /// Lets light through, as a micro-mirror array plate: the image is the object's mirror image
    /// behind the plate
    Plate,
}

/// Whose normals facets reflect about.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum NormalsFrom {
    /// Their own: facets are planes.
    #[default]
    Facets,
    /// Those of the mesh file, interpolated between a facet's corners: facets stand for a curved
    /// face.
    File,
}

macro_rules! named {
    ($($type:ident { $($value:ident = $name:literal),* })*) => {
        $(
            impl $type {
                /// The name in options and in tables.
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
    Element { Retroreflector = "retroreflector", Plate = "plate" }
    NormalsFrom { Facets = "facets", File = "file" }
}

#[cfg(all(test, feature = "cli"))]
mod tests {
    use super::*;
    use clap::ValueEnum;

    /// The command line and the file have one name for a value.
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
        assert_eq!(values + more, 13);
    }
}
