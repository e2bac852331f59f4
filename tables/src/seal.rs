//! The seal: a SHA-256 of the whole file behind its end, found wrong when any bit of it has changed.
//!
//! HDF5 readers stop at the end that the superblock states and never see the seal. A program that opens the file for
//! writing cuts it off; such a file is read on the strength of its content hash alone.
//!
//! On disk, behind the HDF5 part: `AIRRSEAL` (8 bytes), then the 32 bytes of SHA-256 of everything before the seal.

use std::io::{self, Read, Seek, SeekFrom};

use sha2::{Digest, Sha256};

use crate::content::hex;

const MARK: &[u8; 8] = b"AIRRSEAL";
const LENGTH: usize = MARK.len() + 32;

/// What a seal says about a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Seal {
    /// The bytes are those that were written.
    Intact,
    /// There is no seal: the file was changed by another program, or never had one.
    Absent,
    /// The bytes are not those that were written.
    Broken {
        /// SHA-256 in the seal, lower-case hex.
        stored: String,
        /// SHA-256 of the bytes before it, lower-case hex.
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
pub(crate) fn check(file: &mut (impl Read + Seek)) -> io::Result<Seal> {
    let length = file.seek(SeekFrom::End(0))?;
    let Some(end) = length.checked_sub(LENGTH as u64) else {
        return Ok(Seal::Absent);
    };
    let mut seal = [0; LENGTH];
    file.seek(SeekFrom::Start(end))?;
    file.read_exact(&mut seal)?;
    if !seal.starts_with(MARK) {
        return Ok(Seal::Absent);
    }
    file.seek(SeekFrom::Start(0))?;
    let mut hash = Sha256::new();
    let mut before = file.take(end);
    let mut block = vec![0; 1 << 20];
    loop {
        match before.read(&mut block)? {
            0 => break,
            read => hash.update(&block[..read]),
        }
    }
    let (stored, computed) = (hex(&seal[MARK.len()..]), hex(hash.finalize().as_ref()));
    Ok(if stored == computed {
        Seal::Intact
    } else {
        Seal::Broken { stored, computed }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn every_flipped_bit_breaks_the_seal() {
        let mut sealed: Vec<u8> = (0..100).collect();
        append(&mut sealed);
        assert_eq!(check(&mut Cursor::new(&sealed)).unwrap(), Seal::Intact);
        assert_eq!(
            check(&mut Cursor::new(&sealed[..30])).unwrap(),
            Seal::Absent
        );
        let mut tried = 0;
        for bit in 0..8 * sealed.len() {
            let mut flipped = sealed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let seal = check(&mut Cursor::new(&flipped)).unwrap();
            let in_mark = (100..108).contains(&(bit / 8));
            assert_eq!(seal == Seal::Absent, in_mark, "bit {bit}");
            assert_ne!(seal, Seal::Intact, "bit {bit}");
            tried += 1;
        }
        assert_eq!(tried, 8 * 140);
    }
}
