//! Parts of the samples of a bake.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Most shards of a bake.
pub const MOST_SHARDS: u32 = 65_536;

/// Some shards of a bake: equal shares of the samples of every randomisation.
///
/// A whole bake has no such record. Its text has the numbers held, from 1, the number of shards,
/// and the rays of the whole bake: `1-3,7/8 of 4194304 rays`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shards {
    /// Number of shards of the bake, 2 to [`MOST_SHARDS`].
    pub of: u32,
    /// Rays per direction of the whole bake.
    pub rays: u64,
    /// Numbers of the shards that are held, from 1; neither none nor all.
    pub held: BTreeSet<u32>,
}

impl Shards {
    /// Returns the samples of shard `number` of `of`, out of `samples` in all.
    ///
    /// The shards cover all samples without overlap.
    pub fn samples(number: u32, of: u32, samples: u64) -> Range<u64> {
        let end = |k: u32| (u128::from(samples) * u128::from(k) / u128::from(of)) as u64;
        end(number - 1)..end(number)
    }

    /// Returns the numbers of the shards that are not held.
    pub fn missing(&self) -> BTreeSet<u32> {
        (1..=self.of).filter(|k| !self.held.contains(k)).collect()
    }

    /// Returns the numbers of the shards that are not held as text: `1-3,7`.
    pub fn missing_text(&self) -> String {
        ranges(&self.missing())
    }

    /// Returns whether a bake or a merge can make this record.
    pub fn is_valid(&self) -> bool {
        (2..=MOST_SHARDS).contains(&self.of)
            && (1..self.of as usize).contains(&self.held.len())
            && self.held.iter().all(|k| (1..=self.of).contains(k))
    }
}

/// Writes numbers as `1-3,7`.
fn ranges(numbers: &BTreeSet<u32>) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for &k in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == k => *last = k,
            _ => runs.push((k, k)),
        }
    }
    let run = |&(first, last): &(u32, u32)| {
        if first == last {
            first.to_string()
        } else {
            format!("{first}-{last}")
        }
    };
    runs.iter().map(run).collect::<Vec<_>>().join(",")
}

impl fmt::Display for Shards {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}/{} of {} rays",
            ranges(&self.held),
            self.of,
            self.rays
        )
    }
}

impl FromStr for Shards {
    type Err = ();

    fn from_str(text: &str) -> Result<Shards, ()> {
        let (held, rest) = text.split_once('/').ok_or(())?;
        let (of, rest) = rest.split_once(" of ").ok_or(())?;
        let rays = rest.strip_suffix(" rays").ok_or(())?;
        let number = |text: &str| {
            text.parse::<u32>()
                .ok()
                .filter(|k| (1..=MOST_SHARDS).contains(k))
        };
        let mut numbers = BTreeSet::new();
        for run in held.split(',') {
            let (first, last) = run.split_once('-').unwrap_or((run, run));
            numbers.extend(number(first).ok_or(())?..=number(last).ok_or(())?);
        }
        let shards = Shards {
            of: number(of).ok_or(())?,
            rays: rays.parse().map_err(|_| ())?,
            held: numbers,
        };
        // Each record has only one text, because the content hash covers the text.
        (shards.is_valid() && shards.to_string() == text)
            .then_some(shards)
            .ok_or(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_samples_once() {
        let mut cases = 0;
        for samples in [0, 1, 7, 262_144, (1 << 48) - 1, u64::MAX] {
            for of in [1, 2, 3, 17, MOST_SHARDS] {
                let mut next = 0;
                for k in 1..=of {
                    let share = Shards::samples(k, of, samples);
                    assert_eq!(share.start, next);
                    next = share.end;
                }
                assert_eq!(next, samples);
                cases += 1;
            }
        }
        assert_eq!(cases, 30);
    }

    #[test]
    fn a_record_is_one_text() {
        let record = |text: &str| text.parse::<Shards>();
        for text in [
            "1/2 of 10 rays",
            "1-3,7/8 of 4194304 rays",
            "2,4-5/65536 of 0 rays",
        ] {
            assert_eq!(
                record(text).map(|shards| shards.to_string()),
                Ok(text.into())
            );
        }
        assert_eq!(
            ranges(&record("1-3,7/8 of 1 rays").unwrap().missing()),
            "4-6,8"
        );
        let bad = [
            "",
            "1/2",
            "1/1 of 9 rays",
            "1-2/2 of 9 rays",
            "3/2 of 9 rays",
            "0/2 of 9 rays",
            "1,2/4 of 9 rays",
            "2-1/4 of 9 rays",
            "1/2 of x rays",
            "1/99999 of 9 rays",
            "1-4000000000/4 of 9 rays",
        ];
        for text in bad {
            assert_eq!(record(text), Err(()), "{text}");
        }
    }
}
