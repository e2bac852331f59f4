//! Which directions of a table have a panel.

use tables::Table;

/// Largest number of panels.
const PANELS: usize = 24;

/// Largest number of panels beside each other.
const ACROSS: usize = 6;

/// Directions that are drawn.
pub(crate) struct Choice {
    /// Indices (incidence, azimuth), in the order of the panels.
    pub(crate) directions: Vec<(usize, usize)>,
    /// Number of panels beside each other.
    pub(crate) columns: usize,
    /// Says which of the directions are drawn, if they are not all.
    pub(crate) note: Option<String>,
}

impl Choice {
    /// Chooses at most 24 directions of a table, the first and the last of each axis among them.
    pub(crate) fn of(table: &Table) -> Choice {
        let (incidences, azimuths) = table.axes.shape();
        Choice::among(incidences, azimuths)
    }

    fn among(incidences: usize, azimuths: usize) -> Choice {
        let across = match incidences * azimuths > PANELS {
            true => azimuths.min(ACROSS),
            false => azimuths,
        };
        let down = incidences.min(PANELS / across.max(1)).max(1);
        let spread: Vec<usize> = evenly(azimuths, across);
        let directions: Vec<(usize, usize)> = evenly(incidences, down)
            .into_iter()
            .flat_map(|i| spread.iter().map(move |&a| (i, a)))
            .collect();
        let all = directions.len() == incidences * azimuths;
        let some = || {
            let of = |drawn: usize, all: usize, name: &str| format!("{drawn} of {all} {name}");
            let incidences = of(down, incidences, "incidences");
            let azimuths = (azimuths > 1).then(|| of(across, azimuths, "azimuths"));
            let both = azimuths.map_or(incidences.clone(), |a| format!("{incidences}, {a}"));
            format!("drawn: {both}")
        };
        Choice {
            columns: columns(directions.len(), across),
            note: (!all).then(some),
            directions,
        }
    }
}

/// Returns how many panels stand beside each other: whole groups of `together`, in rows as even as
/// can be.
fn columns(panels: usize, together: usize) -> usize {
    let together = together.clamp(1, ACROSS);
    let most = ACROSS / together * together;
    let rows = panels.div_ceil(most).max(1);
    panels.div_ceil(rows).div_ceil(together) * together
}

/// Returns `some` of the numbers below `all`, evenly spread, with the first and the last.
fn evenly(all: usize, some: usize) -> Vec<usize> {
    let last = all.saturating_sub(1);
    match some {
        0 => Vec::new(),
        1 => vec![0],
        _ => (0..some)
            .map(|k| (2 * k * last + some - 1) / (2 * (some - 1)))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_few_and_reach_both_ends() {
        // Incidences, azimuths; panels, columns.
        let cases = [
            ((1, 1), (1, 1)),
            ((10, 1), (10, 5)),
            ((19, 1), (19, 5)),
            ((90, 1), (24, 6)),
            ((10, 2), (20, 6)),
            ((2, 12), (24, 6)),
            ((10, 12), (24, 6)),
            ((5, 5), (20, 5)),
        ];
        for ((incidences, azimuths), expected) in cases {
            let choice = Choice::among(incidences, azimuths);
            let found = (choice.directions.len(), choice.columns);
            assert_eq!(found, expected, "{incidences} x {azimuths}");
            assert_eq!(choice.directions[0], (0, 0));
            let last = choice.directions[found.0 - 1];
            assert_eq!(last, (incidences - 1, azimuths - 1));
            assert!(choice.directions.windows(2).all(|pair| pair[0] < pair[1]));
            assert_eq!(choice.note.is_none(), found.0 == incidences * azimuths);
        }
        let note = Choice::among(10, 12).note;
        let expected = "drawn: 4 of 10 incidences, 6 of 12 azimuths";
        assert_eq!(note.as_deref(), Some(expected));
    }
}
