//! Reasons why a direction cannot be looked up.

/// Reason why a direction cannot be looked up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoDirection {
    /// Direction outside of the angles of the table.
    #[error(
        "the table does not cover incidence {incidence_deg} deg, azimuth {azimuth_deg} deg; the \
        nearest direction in it is incidence {nearest_incidence_deg} deg, azimuth \
        {nearest_azimuth_deg} deg; correct the angle, or bake the direction"
    )]
    Outside {
        /// Incidence asked for, degrees.
        incidence_deg: f64,
        /// Azimuth asked for, degrees; NaN if the table is a mean over azimuths.
        azimuth_deg: f64,
        /// Incidence of the nearest direction, degrees.
        nearest_incidence_deg: f64,
        /// Azimuth of the nearest direction, degrees.
        nearest_azimuth_deg: f64,
    },
    /// Missing azimuth, where the table is not a mean over azimuths.
    #[error(
        "the table holds single azimuths ({first_deg} to {last_deg} deg); give azimuth_deg, or \
        bake with --azimuth mean"
    )]
    AzimuthNeeded {
        /// First azimuth of the table, degrees.
        first_deg: f64,
        /// Last azimuth of the table, degrees.
        last_deg: f64,
    },
    /// Angle that is NaN or infinite.
    #[error(
        "incidence {incidence_deg} deg, azimuth {azimuth_deg} deg is no direction; give finite \
        angles"
    )]
    NotFinite {
        /// Incidence asked for, degrees.
        incidence_deg: f64,
        /// Azimuth asked for, degrees.
        azimuth_deg: f64,
    },
}
