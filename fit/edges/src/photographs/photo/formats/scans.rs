//! Whether a JPEG is whole. The decoder fills what is missing with grey and does not tell, so all
//! blocks of all scans are counted here (ITU-T T.81). No coefficient and no pixel is computed.
//!
//! Refused are files without the marker of the end, files whose data end before the last block or
//! lose their meaning before it, and progressive files without their last scans. A JPEG has no
//! checksum: a byte that another one replaced goes unnoticed where as many blocks follow as before.
//! Bytes behind the end of the picture are no fault: cameras put previews there.

use crate::photographs::photo::limits::MAX_PIXELS;

/// Largest number of scans that are followed. The decoder refuses more.
const MOST_SCANS: usize = 100;

/// What is known of a file at one place in it.
#[derive(Default)]
pub(crate) struct Scans {
    is_progressive: bool,
    /// Columns and rows of the picture.
    size: [usize; 2],
    components: Vec<Component>,
    /// Largest sampling factors of the components.
    largest: [usize; 2],
    /// Number of units across and down: a unit is all blocks that cover one place.
    units: [usize; 2],
    /// Tables of DC in places 0 to 3, and of AC in places 4 to 7: length and value of the code at
    /// the front of any 16 bits. A length of 0 stands for bits that begin no code.
    tables: [Vec<u16>; 8],
    /// Number of units of blocks between two restart markers; 0 without such markers.
    restart: usize,
    /// Whole bytes that were left between blocks and the markers behind them.
    pub(crate) left: usize,
    /// True if the file has a part of an ICC profile.
    pub(crate) has_profile: bool,
}

/// One component of the picture: Y, Cb or Cr of most files.
struct Component {
    id: u8,
    /// Sampling factors along the columns and the rows.
    sampling: [usize; 2],
    /// Lowest bit of each coefficient that some scan held.
    low: [u8; 64],
    /// The coefficients of each block that are not 0.
    set: Vec<u64>,
}

/// Reason why a file is not whole, in words; `None` if it is of a kind that is not known here, and
/// the decoder judges it.
type Lack = Option<String>;

impl Scans {
    /// Follows a JPEG from its start to the end of the picture.
    ///
    /// # Errors
    /// Returns the reason, in words, if something is missing or has no meaning.
    pub(crate) fn of(bytes: &[u8]) -> Result<Scans, String> {
        let mut scans = Scans::default();
        match scans.follow(bytes) {
            Err(Some(reason)) => Err(reason),
            Err(None) | Ok(()) => Ok(scans),
        }
    }

    fn follow(&mut self, bytes: &[u8]) -> Result<(), Lack> {
        let no_end = || Some("it has no end-of-image marker".to_owned());
        let (mut file, mut count) = (Markers { bytes, next: 2 }, 0);
        loop {
            let code = file.marker().ok_or_else(no_end)?;
            if code == 0xd9 {
                // At the end of the picture, all coefficients must have been there.
                let is_whole = count > 0 && self.components.iter().all(|it| it.low == [0; 64]);
                let lack = || Some(format!("it ends after scan {count}, before all details"));
                return is_whole.then_some(()).ok_or_else(lack);
            }
            if code == 1 || (0xd0..=0xd7).contains(&code) {
                continue;
            }
            let content = file.content().ok_or_else(no_end)?;
            match (code, content) {
                (0xc0..=0xc2, _) if self.components.is_empty() => {
                    self.frame(code, content).ok_or(None)?;
                }
                (0xc4, _) => self.huffman(content).ok_or(None)?,
                (0xda, _) if count < MOST_SCANS => {
                    self.scan(content, &mut file)?;
                    count += 1;
                }
                // Also second frames, and those that are lossless, hierarchical or arithmetic.
                (0xc0..=0xcf | 0xda, _) => return Err(None),
                (0xdd, &[high, low]) => self.restart = u16::from_be_bytes([high, low]).into(),
                (0xe2, _) => self.has_profile |= content.starts_with(b"ICC_PROFILE\0"),
                _ => {}
            }
        }
    }

    /// Reads tables from the counts of codes of 1 to 16 bits and their values (T.81, annex C).
    fn huffman(&mut self, mut content: &[u8]) -> Option<()> {
        while let Some((&[place, ref counts @ ..], rest)) = content.split_first_chunk::<17>() {
            let place = usize::from(place >> 4 << 2 | place & 15);
            let table = self.tables.get_mut(place)?;
            let (mut codes, mut values) = (Vec::with_capacity(1 << 16), rest.iter());
            for (length, &count) in (1_u16..).zip(counts) {
                for value in values.by_ref().take(count.into()) {
                    let entry = length << 8 | u16::from(*value);
                    codes.extend(std::iter::repeat_n(entry, 1 << (16 - length)));
                    (codes.len() <= 1 << 16).then_some(())?;
                }
            }
            codes.resize(1 << 16, 0);
            (*table, content) = (codes, values.as_slice());
        }
        Some(())
    }

    /// Reads the header of the frame.
    fn frame(&mut self, code: u8, content: &[u8]) -> Option<()> {
        let (&[depth, h1, h0, w1, w0, count], parts) = content.split_first_chunk::<6>()?;
        self.is_progressive = code == 0xc2;
        self.size = [[w1, w0], [h1, h0]].map(|side| u16::from_be_bytes(side).into());
        let pixels = self.size[0] as u64 * self.size[1] as u64;
        let factors = |part: &[u8]| [part[1] >> 4, part[1] & 15].map(usize::from);
        let parts = || parts.chunks_exact(3).take(count.into());
        let are_odd = parts()
            .flat_map(factors)
            .any(|side| !(1..=4).contains(&side));
        if depth != 8 || !(1..=MAX_PIXELS).contains(&pixels) || count > 4 || are_odd {
            return None;
        }
        self.largest = [0, 1].map(|side| parts().map(|it| factors(it)[side]).max().unwrap_or(1));
        self.units = [0, 1].map(|side| self.size[side].div_ceil(8 * self.largest[side]));
        for part in parts() {
            let [wide, tall] = factors(part);
            self.components.push(Component {
                id: part[0],
                sampling: [wide, tall],
                low: [u8::MAX; 64],
                set: vec![0; self.units[0] * wide * self.units[1] * tall],
            });
        }
        Some(())
    }

    /// Follows the blocks of a scan. `content` is that of its marker, and `file` stands behind it.
    fn scan(&mut self, content: &[u8], file: &mut Markers) -> Result<(), Lack> {
        let (&count, rest) = content.split_first().ok_or(None)?;
        let Some((parts, &[first, last, low])) = rest.split_at_checked(2 * usize::from(count))
        else {
            return Err(None);
        };
        let is_single = count == 1;
        let (band, low, refines) = match self.is_progressive {
            true => ([first.into(), last.into()], low & 15, low >> 4 > 0),
            false => ([0, 63], 0, false),
        };
        if band[1] > 63 || band[0] > band[1] || band[0] > 0 && !is_single {
            return Err(None);
        }
        // Components, each with the places of its two tables.
        let mut members: Vec<(usize, usize, usize)> = Vec::new();
        for part in parts.chunks_exact(2) {
            let index = self.components.iter().position(|it| it.id == part[0]);
            let (dc, ac) = ((part[1] >> 4 & 3).into(), (4 + (part[1] & 3)).into());
            members.push((index.ok_or(None)?, dc, ac));
            // Some files leave the tables to the reader.
            let lacks_dc = band[0] == 0 && !refines && self.tables[dc].is_empty();
            if lacks_dc || band[1] > 0 && self.tables[ac].is_empty() {
                return Err(None);
            }
        }
        // One component alone has no blocks that only fill a unit.
        let own = self.components[members.first().ok_or(None)?.0].sampling;
        let single = |side: usize| (self.size[side] * own[side]).div_ceil(8 * self.largest[side]);
        let [across, down] = if is_single {
            [0, 1].map(single)
        } else {
            self.units
        };
        let (mut run, mut restarts, mut bits) = (0, 0, file.data());
        for unit in 0..across * down {
            let (x, y) = (unit % across, unit / across);
            let row = self.size[1] * y / down;
            let lack = || Some(format!("its data end or lose their meaning near row {row}"));
            if self.restart > 0 && unit > 0 && unit % self.restart == 0 {
                self.left += bits.left() / 8;
                let marker = file.marker().filter(|code| *code == 0xd0 + restarts);
                restarts = (marker.ok_or_else(lack)? + 1) % 8;
                (run, bits) = (0, file.data());
            }
            for &(index, dc, ac) in &members {
                let component = &mut self.components[index];
                let [wide, tall] = component.sampling;
                let [columns, rows] = if is_single { [1, 1] } else { [wide, tall] };
                let stride = self.units[0] * wide;
                for k in 0..columns * rows {
                    let place = (y * rows + k / columns) * stride + x * columns + k % columns;
                    let set = component.set.get_mut(place).ok_or_else(lack)?;
                    let tables = [&self.tables[dc][..], &self.tables[ac]];
                    let followed = bits.block(band, refines, tables, set, &mut run);
                    followed.ok_or_else(lack)?;
                }
            }
        }
        self.left += bits.left() / 8;
        for (index, ..) in members {
            self.components[index].low[band[0]..=band[1]].fill(low);
        }
        Ok(())
    }
}

/// A file from one of its bytes on.
struct Markers<'a> {
    bytes: &'a [u8],
    next: usize,
}

impl<'a> Markers<'a> {
    /// Goes behind the next marker, and returns its second byte; `None` at the end of the file.
    fn marker(&mut self) -> Option<u8> {
        loop {
            let pair = self.bytes.get(self.next..self.next + 2)?;
            self.next += 1;
            if pair[0] == 0xff && !matches!(pair[1], 0 | 0xff) {
                self.next += 1;
                return Some(pair[1]);
            }
        }
    }

    /// Takes the content of a marker.
    fn content(&mut self) -> Option<&'a [u8]> {
        let (&length, rest) = self.bytes.get(self.next..)?.split_first_chunk::<2>()?;
        let length = usize::from(u16::from_be_bytes(length));
        self.next += length;
        rest.get(..length.checked_sub(2)?)
    }

    /// Takes the data before the next marker. A zero behind 0xff says that it is none.
    fn data(&mut self) -> Bits {
        let mut bytes = Vec::new();
        while let Some(&byte) = self.bytes.get(self.next) {
            let is_marked = byte == 0xff;
            if is_marked && self.bytes.get(self.next + 1) != Some(&0) {
                break;
            }
            bytes.push(byte);
            self.next += 1 + usize::from(is_marked);
        }
        Bits { bytes, next: 0 }
    }
}

/// Bits of a scan, up to a marker.
struct Bits {
    bytes: Vec<u8>,
    /// Index of the next bit.
    next: usize,
}

impl Bits {
    /// Returns the number of bits that were not taken.
    fn left(&self) -> usize {
        8 * self.bytes.len() - self.next
    }

    /// Returns 16 bits ahead. Behind the end are ones, as a JPEG pads its last byte.
    fn ahead(&self) -> usize {
        let byte = |i| usize::from(*self.bytes.get(self.next / 8 + i).unwrap_or(&0xff));
        (byte(0) << 16 | byte(1) << 8 | byte(2)) >> (8 - self.next % 8) & 0xffff
    }

    /// Takes up to 16 bits and returns them as a number.
    fn take(&mut self, count: usize) -> Option<usize> {
        let taken = self.ahead() >> (16 - count);
        self.next += (count <= self.left()).then_some(count)?;
        Some(taken)
    }

    /// Takes a code and returns its value.
    fn symbol(&mut self, table: &[u16]) -> Option<usize> {
        let entry = table.get(self.ahead()).filter(|entry| **entry > 0)?;
        self.take(usize::from(entry >> 8))?;
        Some(usize::from(entry & 0xff))
    }

    /// Follows one block of a scan with a band of coefficients. `set` has a bit for each one that is
    /// not 0, and `run` counts the blocks that follow without new ones (T.81, G.1.2). Returns `None`
    /// if the data end or have no meaning.
    fn block(
        &mut self,
        [mut at, last]: [usize; 2],
        refines: bool,
        [dc, ac]: [&[u16]; 2],
        set: &mut u64,
        run: &mut usize,
    ) -> Option<()> {
        let is_first = at == 0;
        if is_first {
            let size = if refines { 1 } else { self.symbol(dc)? };
            self.take(size.min(16))?;
            at = 1;
        }
        while *run == 0 && at <= last {
            let symbol = self.symbol(ac)?;
            let (mut zeros, size) = (symbol >> 4, symbol & 15);
            if size == 0 && zeros < 15 {
                // Runs of blocks are those of progressive files.
                *run = if is_first {
                    1
                } else {
                    (1 << zeros) + self.take(zeros)?
                };
                break;
            }
            self.take(size)?;
            // Each coefficient that is not 0 yet counts as one of the zeros; when bits are refined,
            // each other one has a bit of its own.
            while at <= last {
                if refines && *set >> at & 1 == 1 {
                    self.take(1)?;
                } else if zeros == 0 {
                    break;
                } else {
                    zeros -= 1;
                }
                at += 1;
            }
            if at > last && (size > 0 || !refines) || refines && size > 1 {
                return None;
            }
            *set |= if size > 0 { 1 << at } else { 0 };
            at += 1;
        }
        if *run > 0 {
            for _ in (at..=last).filter(|k| refines && *set >> k & 1 == 1) {
                self.take(1)?;
            }
            *run -= 1;
        }
        Some(())
    }
}
