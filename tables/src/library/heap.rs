//! Guard before the HDF5 library: the structure of its global heaps.
//!
//! Texts of variable length live in global heaps, the only structure of a version 1 table that has
//! no checksum of its own. The library walks a heap with a wrong object size without end. So every
//! heap is walked here first.
//!
//! On disk a heap is `GCOL`, version 1, three zero bytes and the length of the heap as u64. Then
//! come objects: u16 index, u16 references, four reserved bytes, u64 size. If the index is above 0,
//! the data follow, padded to 8 bytes. Index 0 is the free rest of the heap, whose size includes
//! its head.

/// First bytes of a heap.
const START: &[u8; 8] = b"GCOL\x01\0\0\0";
/// Length of the head of a heap, and of an object, bytes.
const HEAD: usize = 16;

/// Returns the offset of the first heap that cannot be walked to its end, bytes.
pub(crate) fn first_broken(bytes: &[u8]) -> Option<usize> {
    let mut from = 0;
    while let Some(offset) = bytes[from..]
        .windows(START.len())
        .position(|window| window == START)
    {
        let offset = from + offset;
        if walk(&bytes[offset..]).is_none() {
            return Some(offset);
        }
        from = offset + START.len();
    }
    None
}

/// Walks a heap; returns `Some` if its objects fill it.
fn walk(heap: &[u8]) -> Option<()> {
    let length = word(heap, START.len())?;
    let mut rest = heap.get(HEAD..length)?;
    // If no free object fits, less than a head is left over.
    while rest.len() >= HEAD {
        let index = u16::from_le_bytes([rest[0], rest[1]]);
        let size = word(rest, 8)?;
        if index == 0 {
            return (size == rest.len()).then_some(());
        }
        let padded = size.checked_next_multiple_of(8)?.checked_add(HEAD)?;
        rest = rest.get(padded..)?;
    }
    Some(())
}

/// Reads a little-endian u64.
fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let word = bytes.get(at..at + 8)?.try_into().ok()?;
    usize::try_from(u64::from_le_bytes(word)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a heap of one object of 5 bytes, then free space: 16 + (16 + 8) + 24.
    fn heap() -> Vec<u8> {
        let mut bytes = START.to_vec();
        bytes.extend(64_u64.to_le_bytes());
        bytes.extend([1, 0, 1, 0, 0, 0, 0, 0]);
        bytes.extend(5_u64.to_le_bytes());
        bytes.extend(*b"hello\0\0\0");
        bytes.extend([0; 8]);
        bytes.extend(24_u64.to_le_bytes());
        bytes.extend([0; 8]);
        bytes
    }

    #[test]
    fn a_heap_with_a_wrong_size_is_found() {
        let mut file = vec![7; 100];
        file.extend(heap());
        assert_eq!(file.len(), 164);
        assert_eq!(first_broken(&file), None);
        assert_eq!(first_broken(&file[..163]), Some(100), "cut short");
        let mut tried = 0;
        // Wrong values of the length of the heap, of the size of the object (beyond its padding)
        // and of the size of the free space.
        for (at, wrong) in [
            (108, 0),
            (108, 65),
            (108, u64::MAX),
            (124, 41),
            (124, u64::MAX),
            (148, 0),
            (148, 1),
            (148, 25),
        ] {
            let mut broken = file.clone();
            broken[at..at + 8].copy_from_slice(&u64::to_le_bytes(wrong));
            assert_eq!(first_broken(&broken), Some(100), "{wrong} at {at}");
            tried += 1;
        }
        assert_eq!(tried, 8);
    }
}
