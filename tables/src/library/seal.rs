//! Seal: a SHA-256 of the whole file behind its end, which is wrong if any bit of the file has
//! changed.
//!
//! HDF5 readers stop at the end that the superblock states and never see the seal. A program that
//! opens the file for writing cuts it off. Then only the content hash vouches for the file.
//!
//! On disk, behind the HDF5 part, stand `AIRRSEAL` (8 bytes) and the 32 bytes of SHA-256 of
//! everything before the seal.

use sha2::{Digest, Sha256};

use crate::file::content::hex;

/// First bytes of a seal.
const MARK: &[u8; 8] = b"AIRRSEAL";
/// Length of a seal, bytes.
const LENGTH: usize = MARK.len() + 32;

/// Greatest number of wrong bits, of 64, with which a mark is still recognised.
const MOST_WRONG: u32 = 8;

/// Verdict of a seal on a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Seal {
    /// Seal of unchanged bytes.
    Intact,
    /// No seal: another program changed the file, or it never had one.
    Absent,
    /// Seal of other bytes: the file is damaged.
    Broken {
        /// SHA-256 in the seal, lower-case hex.
        stored: String,
        /// SHA-256 of the bytes before the seal, lower-case hex.
        computed: String,
    },
}

/// Adds the seal.
pub(crate) fn append(bytes: &mut Vec<u8>) {
    let hash = Sha256::digest(&*bytes);
    bytes.extend_from_slice(MARK);
    bytes.extend_from_slice(hash.as_ref());
}

/// Compares the seal at the end of a file with the bytes before it.
pub(crate) fn check(bytes: &[u8]) -> Seal {
    let Some((before, seal)) = bytes.split_last_chunk::<LENGTH>() else {
        return Seal::Absent;
    };
    // A mark with a few wrong bits counts as a damaged one. By chance, 8 bytes are this similar in
    // one file of 2^30.
    let wrong: u32 = seal
        .iter()
        .zip(MARK)
        .map(|(a, b)| (a ^ b).count_ones())
        .sum();
    if wrong > MOST_WRONG {
        return Seal::Absent;
    }
    let (stored, computed) = (
        hex(&seal[MARK.len()..]),
        hex(Sha256::digest(before).as_ref()),
    );
    if stored == computed && wrong == 0 {
        Seal::Intact
    } else {
        Seal::Broken { stored, computed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_breaks_the_seal() {
        let mut sealed: Vec<u8> = (0..100).collect();
        append(&mut sealed);
        assert_eq!(check(&sealed), Seal::Intact);
        assert_eq!(check(&sealed[..30]), Seal::Absent);
        let mut tried = 0;
        for bit in 0..8 * sealed.len() {
            let mut flipped = sealed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let seal = check(&flipped);
            assert!(matches!(seal, Seal::Broken { .. }), "bit {bit}");
            tried += 1;
        }
        assert_eq!(tried, 8 * 140);
    }
}
