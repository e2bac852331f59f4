//! Rules that a table can break, each with the place.

/// Rule that a table breaks. Directions are (index along incidence, index along azimuth).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Invalid {
    /// An axis without values.
    #[error("{axis} is empty")]
    EmptyAxis {
        /// Name of the axis.
        axis: &'static str,
    },
    /// More of something than any table holds.
    #[error("{what} are {found}, above the limit of {most}")]
    Many {
        /// What there are too many of, with its place, in words.
        what: String,
        /// Number of them.
        found: usize,
        /// Greatest number that is read.
        most: usize,
    },
    /// A value of an axis out of its range.
    #[error("{axis} is {value:?} at index {index}, outside of {allowed}")]
    AxisValue {
        /// Name of the axis.
        axis: &'static str,
        /// Index of the value.
        index: usize,
        /// The value.
        value: f64,
        /// The range in words.
        allowed: &'static str,
    },
    /// An axis that does not ascend.
    #[error("{axis} does not ascend at index {index}")]
    AxisOrder {
        /// Name of the axis.
        axis: &'static str,
        /// Index of the first value that is not above the one before it.
        index: usize,
    },
    /// Arrays of different shapes.
    #[error("{array} has shape {found:?}, the axes ask for {expected:?}")]
    Shape {
        /// Name of the array.
        array: &'static str,
        /// Shape that follows from the axes.
        expected: Vec<usize>,
        /// Shape that the array has.
        found: Vec<usize>,
    },
    /// A value that is NaN, infinite or outside of its range.
    #[error("{array} is {value:?} at flat index {index}, outside of {allowed}")]
    Value {
        /// Name of the array.
        array: &'static str,
        /// Index in row-major order.
        index: usize,
        /// The value.
        value: f64,
        /// The range in words.
        allowed: &'static str,
    },
    /// A histogram that neither sums to 1 nor is empty.
    #[error(
        "histogram sums to {sum} at direction {direction:?}, expected 1, or 0 where nothing returns"
    )]
    HistogramSum {
        /// The direction.
        direction: (usize, usize),
        /// The sum.
        sum: f64,
    },
    /// A histogram with entries where nothing is retroreflected.
    #[error("histogram is not empty at direction {direction:?} where retroreflected is 0")]
    HistogramOfNothing {
        /// The direction.
        direction: (usize, usize),
    },
    /// Fates that do not sum to 1.
    #[error("fate sums to {sum} at direction {direction:?}, expected 1")]
    FateSum {
        /// The direction.
        direction: (usize, usize),
        /// The sum.
        sum: f64,
    },
    /// Value of eta that differs from the fates.
    #[error(
        "retroreflected is {eta} at direction {direction:?}, fate retroreflected + out_of_range \
        is {fates}"
    )]
    EtaOfFates {
        /// The direction.
        direction: (usize, usize),
        /// eta.
        eta: f64,
        /// Sum of the fates retroreflected and out_of_range.
        fates: f64,
    },
    /// Histogram and fate that count different rays.
    #[error(
        "counts sum to {counts} at direction {direction:?}, randomisation {randomisation}, \
         fate_counts says {fates} retroreflected"
    )]
    CountSum {
        /// The direction.
        direction: (usize, usize),
        /// The randomisation.
        randomisation: usize,
        /// Sum over bins.
        counts: u128,
        /// Rays of fate retroreflected.
        fates: u64,
    },
    /// Launched rays that the fates do not account for.
    #[error("rays is {rays} at direction {direction:?}, fate_counts sums to {fates}")]
    RaySum {
        /// The direction.
        direction: (usize, usize),
        /// Rays launched.
        rays: u64,
        /// Sum over fates and randomisations.
        fates: u128,
    },
    /// More rays than f64 counts exactly.
    #[error("fate_counts sums to {rays} at direction {direction:?}, above 2^53")]
    TooManyRays {
        /// The direction.
        direction: (usize, usize),
        /// Sum over fates and randomisations.
        rays: u128,
    },
    /// Rays by deviation that are more or fewer than those of the histogram.
    #[error(
        "the deviations of direction {direction} have {deviations} rays in the cell (v, u) = \
        {cell:?}, counts has {counts}"
    )]
    DeviationSum {
        /// Index of the direction, incidence * azimuths + azimuth.
        direction: usize,
        /// The cell of shifts.
        cell: (usize, usize),
        /// Rays of all its deviations.
        deviations: u128,
        /// Rays of its bins.
        counts: u128,
    },
    /// An entry out of place, or without rays.
    #[error(
        "entry {entry} of the deviations of direction {direction} has the place {place} and \
        {rays} rays; places ascend below {places}, and rays are at least 1"
    )]
    DeviationEntry {
        /// Index of the direction, incidence * azimuths + azimuth.
        direction: usize,
        /// Index of the entry within the direction.
        entry: usize,
        /// Place of the entry.
        place: u64,
        /// Rays of the entry.
        rays: u64,
        /// Number of places.
        places: u64,
    },
    /// One of two arrays of which a table has both or none.
    #[error("{present} is there without {missing}")]
    HalfCounts {
        /// Name of the array that is there.
        present: &'static str,
        /// Name of the array that is not there.
        missing: &'static str,
    },
    /// A method or a sampler that contradicts what the table holds.
    #[error(
        "method is \"{method}\" and sampler is \"{sampler}\", but the table {counts} counts and \
        {polygons} polygons"
    )]
    Method {
        /// Word of the method.
        method: String,
        /// Word of the sampler.
        sampler: String,
        /// Word for counts that are there or not: has or lacks.
        counts: &'static str,
        /// Word for polygons that are there or not: has or lacks.
        polygons: &'static str,
    },
    /// A polygon of fewer than three corners or of negative area.
    #[error(
        "path {path} of direction {direction} has a polygon of {corners} corners and area {area}"
    )]
    Polygon {
        /// Index of the direction, incidence * azimuths + azimuth.
        direction: usize,
        /// Index of the path within the direction.
        path: usize,
        /// Number of corners.
        corners: usize,
        /// Signed area, square edge lengths.
        area: f64,
    },
    /// Polygons whose areas do not sum to eta.
    #[error(
        "polygons of direction {direction:?} return {polygons} of the power, retroreflected says \
        {eta}"
    )]
    PolygonSum {
        /// The direction.
        direction: (usize, usize),
        /// Sum of weight x area / entrance area.
        polygons: f64,
        /// eta.
        eta: f64,
    },
}
