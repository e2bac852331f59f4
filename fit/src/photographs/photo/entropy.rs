//! Entropy-coded data of a JPEG (ITU-T T.81, annexes F and G), read only as far as tells where each
//! block ends: no coefficient and no pixel is computed.

/// A reason why a block cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stop {
    /// The data end before the block does.
    Missing,
    /// The data have no meaning.
    Bad,
}

/// A Huffman table: length and value of the code at the front of any 16 bits.
pub(crate) struct Huffman(Vec<u16>);

impl Huffman {
    /// Makes a table from the counts of codes of 1 to 16 bits and their values (T.81, annex C).
    /// Returns `None` if there are too many codes.
    pub(crate) fn new(counts: &[u8; 16], values: &[u8]) -> Option<Huffman> {
        // A length of 0 stands for bits that begin no code.
        let mut codes = vec![0_u16; 1 << 16];
        let (mut start, mut values) = (0_usize, values.iter());
        for (length, &count) in (1_u16..).zip(counts) {
            let span = 1_usize << (16 - length);
            for _ in 0..count {
                let entry = length << 8 | u16::from(*values.next()?);
                codes.get_mut(start..start + span)?.fill(entry);
                start += span;
            }
        }
        Some(Huffman(codes))
    }
}

/// Bits of a scan, up to the next marker.
pub(crate) struct Bits<'a> {
    bytes: &'a [u8],
    /// Index of the next byte.
    next: usize,
    /// Bits that were read from the bytes and not used yet, the last one lowest.
    held: u64,
    /// Number of these bits.
    count: u32,
}

impl<'a> Bits<'a> {
    /// Starts at a byte of a file.
    pub(crate) fn new(bytes: &'a [u8], next: usize) -> Bits<'a> {
        Bits {
            bytes,
            next,
            held: 0,
            count: 0,
        }
    }

    /// Reads bytes until more than 48 bits are held or a marker or the end of the file is met.
    fn fill(&mut self) {
        while self.count <= 48 {
            let Some(&byte) = self.bytes.get(self.next) else {
                return;
            };
            if byte == 0xff {
                // A zero behind it says that it is no marker.
                if self.bytes.get(self.next + 1) != Some(&0) {
                    return;
                }
                self.next += 1;
            }
            self.next += 1;
            self.held = self.held << 8 | u64::from(byte);
            self.count += 8;
        }
    }

    /// Takes up to 16 bits and returns them as a number.
    fn take(&mut self, count: u32) -> Result<u32, Stop> {
        if self.count < count {
            self.fill();
        }
        self.count = self.count.checked_sub(count).ok_or(Stop::Missing)?;
        Ok((self.held >> self.count) as u32 & ((1 << count) - 1))
    }

    /// Takes a code and returns its value.
    fn symbol(&mut self, table: &Huffman) -> Result<u32, Stop> {
        if self.count < 16 {
            self.fill();
        }
        let front = if self.count >= 16 {
            self.held >> (self.count - 16)
        } else {
            // Ones behind the end, as a JPEG pads its last byte.
            let lacking = 16 - self.count;
            self.held << lacking | ((1 << lacking) - 1)
        };
        let entry = table.0[(front & 0xffff) as usize];
        let length = u32::from(entry >> 8);
        if length == 0 {
            return Err(if self.count < 16 {
                Stop::Missing
            } else {
                Stop::Bad
            });
        }
        self.count = self.count.checked_sub(length).ok_or(Stop::Missing)?;
        Ok(u32::from(entry & 0xff))
    }

    /// Returns the number of whole bytes before the next marker. The place is not changed.
    pub(crate) fn rest(&self) -> usize {
        let ahead = Bits { ..*self }.marker();
        ahead.map_or(0, |(_, _, left)| left)
    }

    /// Drops what is left before the next marker. Returns its second byte, the index behind it and
    /// the number of whole bytes that were left; `None` at the end of the file.
    pub(crate) fn marker(&mut self) -> Option<(u8, usize, usize)> {
        let mut left = (self.count / 8) as usize;
        while let Some(&byte) = self.bytes.get(self.next) {
            self.next += 1;
            if byte != 0xff {
                left += 1;
                continue;
            }
            match self.bytes.get(self.next)? {
                0 => {
                    left += 1;
                    self.next += 1;
                }
                0xff => {}
                &code => {
                    self.next += 1;
                    (self.held, self.count) = (0, 0);
                    return Some((code, self.next, left));
                }
            }
        }
        None
    }
}

/// The coefficients that a scan holds (T.81, B.2.3): the band from `first` to `last`, from bit
/// `low` upward. A scan that refines holds this bit alone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub(crate) first: u32,
    pub(crate) last: u32,
    pub(crate) low: u8,
    pub(crate) refines: bool,
}

/// The tables of one component.
pub(crate) struct Tables<'a> {
    pub(crate) dc: Option<&'a Huffman>,
    pub(crate) ac: Option<&'a Huffman>,
}

impl Tables<'_> {
    /// Reads one block of a sequential JPEG.
    pub(crate) fn sequential(&self, bits: &mut Bits) -> Result<(), Stop> {
        self.first_dc(bits)?;
        self.coefficients(bits, [1, 63], |_| {}).map(drop)
    }

    /// Reads coefficients from `first` to `last` that were 0 before, and passes the number of each
    /// that is not 0 to `take`. Returns the upper half of the code that ends the block early.
    fn coefficients(
        &self,
        bits: &mut Bits,
        [first, last]: [u32; 2],
        mut take: impl FnMut(u32),
    ) -> Result<Option<u32>, Stop> {
        let table = self.ac.ok_or(Stop::Bad)?;
        let mut at = first;
        while at <= last {
            let symbol = bits.symbol(table)?;
            let (zeros, size) = (symbol >> 4, symbol & 15);
            if size == 0 && zeros < 15 {
                return Ok(Some(zeros));
            }
            at += zeros;
            if at > last {
                return Err(Stop::Bad);
            }
            bits.take(size)?;
            if size > 0 {
                take(at);
            }
            at += 1;
        }
        Ok(None)
    }

    fn first_dc(&self, bits: &mut Bits) -> Result<(), Stop> {
        let size = bits.symbol(self.dc.ok_or(Stop::Bad)?)?;
        if size > 15 {
            return Err(Stop::Bad);
        }
        bits.take(size).map(drop)
    }

    /// Reads one block of a progressive scan. `set` has a bit for each coefficient that is not 0,
    /// and `run` counts the blocks that follow without new ones (T.81, G.1.2).
    pub(crate) fn progressive(
        &self,
        bits: &mut Bits,
        band: Band,
        set: &mut u64,
        run: &mut u32,
    ) -> Result<(), Stop> {
        match (band.first, band.refines) {
            (0, false) => self.first_dc(bits),
            (0, true) => bits.take(1).map(drop),
            (_, false) => self.first_ac(bits, band, set, run),
            (_, true) => self.refined_ac(bits, band, set, run),
        }
    }

    fn first_ac(
        &self,
        bits: &mut Bits,
        band: Band,
        set: &mut u64,
        run: &mut u32,
    ) -> Result<(), Stop> {
        if *run > 0 {
            *run -= 1;
            return Ok(());
        }
        let ended = self.coefficients(bits, [band.first, band.last], |at| *set |= 1 << at)?;
        if let Some(zeros) = ended {
            *run = (1 << zeros) - 1 + bits.take(zeros)?;
        }
        Ok(())
    }

    fn refined_ac(
        &self,
        bits: &mut Bits,
        band: Band,
        set: &mut u64,
        run: &mut u32,
    ) -> Result<(), Stop> {
        let table = self.ac.ok_or(Stop::Bad)?;
        let mut at = band.first;
        while *run == 0 && at <= band.last {
            let symbol = bits.symbol(table)?;
            let (mut zeros, size) = (symbol >> 4, symbol & 15);
            if size == 0 && zeros < 15 {
                *run = (1 << zeros) + bits.take(zeros)?;
                break;
            }
            if size > 1 {
                return Err(Stop::Bad);
            }
            bits.take(size)?;
            // Each coefficient that is not 0 yet counts as one of the zeros; each other one has a
            // bit of its own.
            while at <= band.last {
                if *set >> at & 1 == 1 {
                    bits.take(1)?;
                } else if zeros == 0 {
                    break;
                } else {
                    zeros -= 1;
                }
                at += 1;
            }
            if size > 0 {
                if at > band.last {
                    return Err(Stop::Bad);
                }
                *set |= 1 << at;
            }
            at += 1;
        }
        if *run > 0 {
            let rest = (at..=band.last).filter(|k| *set >> k & 1 == 1).count();
            for _ in 0..rest {
                bits.take(1)?;
            }
            *run -= 1;
        }
        Ok(())
    }
}
