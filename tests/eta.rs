// Known shares eta that ideal cells retroreflect, from the table beside this file. The tests of
// several crates include it.

/// Returns incidence and azimuth, degrees (NaN for the mean over all azimuths), and eta of a cell.
#[allow(dead_code, reason = "a crate reads the cells that it tests")]
fn known_eta(cell: &str) -> Vec<(f64, f64, f64)> {
    let rows = include_str!("eta.csv").lines();
    let rows = rows.filter_map(|row| row.strip_prefix(cell)?.strip_prefix(','));
    rows.map(|row| {
        let mut numbers = row.split(',').map(|word| word.parse().unwrap_or(f64::NAN));
        let mut next = || numbers.next().expect("three columns");
        (next(), next(), next())
    })
    .collect()
}
