//! Whether a JPEG is whole. The decoder fills what is missing with grey and does not tell, so all
//! blocks of all scans are counted here before it decodes them (ITU-T T.81, annex B).
//!
//! Refused are files without the marker of the end, files whose data end before the last block or
//! lose their meaning before it, and progressive files without their last scans. A JPEG has no
//! checksum: a byte that another one replaced goes unnoticed where as many blocks follow as before.
//! Data that go on behind the last block cause a warning. Bytes behind the end of the picture are
//! no fault: cameras put previews there.

use crate::photographs::photo::entropy::{Band, Bits, Huffman, Stop, Tables};
use crate::photographs::photo::limits::MAX_PIXELS;

/// Largest number of scans that are followed. The decoder refuses more.
const MOST_SCANS: usize = 100;

/// One component of the picture: Y, Cb or Cr of most files.
struct Component {
    id: u8,
    /// Sampling factors along the columns and the rows.
    sampling: [usize; 2],
    /// Lowest bit of each coefficient that some scan held; `None` if no scan held it.
    low: [Option<u8>; 64],
    /// For progressive files: the coefficients of each block that are not 0.
    set: Vec<u64>,
}

/// The frame: the picture and its components.
struct Frame {
    progressive: bool,
    width: usize,
    height: usize,
    components: Vec<Component>,
}

/// All that is known of the file at one place in it.
#[derive(Default)]
struct State {
    frame: Option<Frame>,
    dc: [Option<Huffman>; 4],
    ac: [Option<Huffman>; 4],
    /// Number of units of blocks between two restart markers; 0 without such markers.
    restart: usize,
    /// Whole bytes that were left between the blocks and the marker behind them.
    left: usize,
    has_profile: bool,
}

/// A reason why a file is not checked, or not whole.
enum Fault {
    /// The file is of a kind that this check does not know. The decoder judges it.
    Unknown,
    /// The file is not whole, for this reason.
    Lacking(String),
}

/// The markers, by their second byte.
mod marker {
    pub(super) const SOF0: u8 = 0xc0;
    pub(super) const SOF2: u8 = 0xc2;
    pub(super) const DHT: u8 = 0xc4;
    pub(super) const RST0: u8 = 0xd0;
    pub(super) const RST7: u8 = 0xd7;
    pub(super) const EOI: u8 = 0xd9;
    pub(super) const SOS: u8 = 0xda;
    pub(super) const DRI: u8 = 0xdd;
    pub(super) const APP2: u8 = 0xe2;
}

/// A JPEG that is whole, as far as can be told.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Whole {
    /// Warning about data behind the last block.
    pub(crate) warning: Option<String>,
    /// True if the file has a part of an ICC profile.
    pub(crate) has_profile: bool,
    /// True if a pixel has four colours: CMYK, or YCCK.
    pub(crate) is_cmyk: bool,
}

/// Checks that a JPEG is whole.
///
/// # Errors
/// Returns the reason, in words, if something is missing or has no meaning.
pub(crate) fn check(bytes: &[u8]) -> Result<Whole, String> {
    let mut state = State::default();
    if let Err(Fault::Lacking(reason)) = state.walk(bytes) {
        return Err(reason);
    }
    let warning = format!(
        "{} bytes of its data lie behind the last pixels; if the picture looks damaged, copy it \
        again",
        state.left
    );
    Ok(Whole {
        warning: (state.left > 0).then_some(warning),
        has_profile: state.has_profile,
        is_cmyk: state.frame.is_some_and(|frame| frame.components.len() == 4),
    })
}

const HEADER: &str = "its headers end too early or have no meaning";

fn lacking<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Lacking(reason.into()))
}

impl State {
    /// Follows the file from its start to the end of the picture.
    fn walk(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        const NO_END: &str = "it has no end-of-image marker";
        let mut bits = Bits::new(bytes, 2);
        let mut scans = 0;
        while let Some((code, at, _)) = bits.marker() {
            if code == marker::EOI {
                return self.complete(scans);
            }
            if (marker::RST0..=marker::RST7).contains(&code) || code == 1 {
                continue;
            }
            let length = bytes
                .get(at..at + 2)
                .map(|l| usize::from(l[0]) << 8 | usize::from(l[1]));
            let Some(content) = length.and_then(|length| bytes.get(at + 2..at + length)) else {
                return lacking(NO_END);
            };
            let behind = at + 2 + content.len();
            bits = Bits::new(bytes, behind);
            match code {
                marker::SOF0..=marker::SOF2 if self.frame.is_none() => {
                    self.frame = Some(frame(code, content)?);
                }
                marker::DHT => self.tables(content)?,
                marker::APP2 => self.has_profile |= content.starts_with(b"ICC_PROFILE\0"),
                // Second frames, and frames that are lossless, hierarchical or arithmetic.
                0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcf => return Err(Fault::Unknown),
                marker::DRI => {
                    let [high, low] = *content else {
                        return Err(Fault::Unknown);
                    };
                    self.restart = usize::from(high) << 8 | usize::from(low);
                }
                marker::SOS if scans == MOST_SCANS => return Err(Fault::Unknown),
                marker::SOS => {
                    self.scan(content, &mut bits)?;
                    scans += 1;
                }
                _ => {}
            }
        }
        lacking(NO_END)
    }

    /// Checks, at the end of the picture, that all coefficients were there.
    fn complete(&self, scans: usize) -> Result<(), Fault> {
        let Some(frame) = &self.frame else {
            return lacking(HEADER);
        };
        let mut low = frame.components.iter().flat_map(|component| component.low);
        if low.all(|bit| bit == Some(0)) {
            return Ok(());
        }
        lacking(format!(
            "it ends after scan {scans}, before all of its details"
        ))
    }

    /// Reads Huffman tables.
    fn tables(&mut self, mut content: &[u8]) -> Result<(), Fault> {
        while let Some((&[place, ref counts @ ..], rest)) = content.split_first_chunk::<17>() {
            let values: usize = counts.iter().map(|&count| usize::from(count)).sum();
            let kind = match place >> 4 {
                0 => &mut self.dc,
                1 => &mut self.ac,
                _ => return Err(Fault::Unknown),
            };
            let slot = kind
                .get_mut(usize::from(place & 15))
                .ok_or(Fault::Unknown)?;
            let values = rest.split_at_checked(values).ok_or(Fault::Unknown)?;
            *slot = Huffman::new(counts, values.0);
            content = values.1;
        }
        Ok(())
    }

    /// Follows the blocks of a scan. `content` is that of its marker, and `bits` stand behind it.
    fn scan(&mut self, content: &[u8], bits: &mut Bits) -> Result<(), Fault> {
        let frame = self.frame.as_mut().ok_or(Fault::Unknown)?;
        let (members, band) = header(content, frame)?;
        for &(index, dc, ac) in &members {
            let needs = |table: &Option<Huffman>, used: bool| !used || table.is_some();
            let (is_dc, is_ac) = (band.first == 0 && !band.refines, band.last > 0);
            // Some files leave the tables to the reader.
            if !needs(&self.dc[dc], is_dc) || !needs(&self.ac[ac], is_ac) {
                return Err(Fault::Unknown);
            }
            frame.components[index].hold(band);
        }
        let [across, down] = frame.units(&members);
        let (mut run, mut restarts) = (0, 0_u8);
        for unit in 0..across * down {
            let row = frame.row(unit / across, down);
            if self.restart > 0 && unit > 0 && unit % self.restart == 0 {
                run = 0;
                match bits.marker() {
                    Some((code, _, left)) if code == marker::RST0 + restarts % 8 => {
                        self.left += left;
                    }
                    _ => return lacking(format!("its data break off at about row {row}")),
                }
                restarts = restarts.wrapping_add(1);
            }
            let place = [unit % across, unit / across];
            for &(index, dc, ac) in &members {
                let tables = Tables {
                    dc: self.dc[dc].as_ref(),
                    ac: self.ac[ac].as_ref(),
                };
                let single = members.len() == 1;
                let read = frame.blocks((index, place, single), |set| match set {
                    None => tables.sequential(bits),
                    Some(set) => tables.progressive(bits, band, set, &mut run),
                });
                match read {
                    Ok(()) => {}
                    Err(Stop::Missing) => {
                        return lacking(format!("its data end at about row {row}"));
                    }
                    Err(Stop::Bad) => {
                        return lacking(format!(
                            "its data have no meaning from about row {row} on"
                        ));
                    }
                }
            }
        }
        self.left += bits.rest();
        Ok(())
    }
}

impl Component {
    /// Notes the coefficients that a scan holds.
    fn hold(&mut self, band: Band) {
        for low in &mut self.low[band.first as usize..=band.last as usize] {
            *low = Some(band.low);
        }
    }
}

impl Frame {
    /// Returns the largest sampling factors.
    fn largest(&self) -> [usize; 2] {
        [0, 1].map(|side| {
            let each = self.components.iter().map(|c| c.sampling[side]);
            each.max().unwrap_or(1)
        })
    }

    /// Returns the number of units across and down a scan of these components. A unit is a block if
    /// there is one component, else the blocks of all components that cover one place.
    fn units(&self, members: &[(usize, usize, usize)]) -> [usize; 2] {
        let largest = self.largest();
        let sides = [self.width, self.height];
        match members {
            [(index, ..)] => {
                let own = self.components[*index].sampling;
                [0, 1].map(|i| (sides[i] * own[i]).div_ceil(largest[i]).div_ceil(8))
            }
            _ => [0, 1].map(|i| sides[i].div_ceil(8 * largest[i])),
        }
    }

    /// Returns the row of the picture at which a row of units begins.
    fn row(&self, unit: usize, down: usize) -> usize {
        self.height * unit / down
    }

    /// Calls `read` for each block that a component has in one unit, with the coefficients that are
    /// not 0 in a progressive file. `single` says whether the component is alone in its scan.
    fn blocks(
        &mut self,
        (index, [x, y], single): (usize, [usize; 2], bool),
        mut read: impl FnMut(Option<&mut u64>) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let across = self.width.div_ceil(8 * self.largest()[0]);
        let component = &mut self.components[index];
        let own = component.sampling;
        let [columns, rows] = if single { [1, 1] } else { own };
        for row in 0..rows {
            for column in 0..columns {
                if !self.progressive {
                    read(None)?;
                    continue;
                }
                let place = (y * rows + row) * across * own[0] + x * columns + column;
                read(Some(component.set.get_mut(place).ok_or(Stop::Bad)?))?;
            }
        }
        Ok(())
    }
}

/// Reads the header of a frame.
fn frame(code: u8, content: &[u8]) -> Result<Frame, Fault> {
    let Some((&[depth, h1, h0, w1, w0, count], rest)) = content.split_first_chunk::<6>() else {
        return lacking(HEADER);
    };
    if depth != 8 {
        return Err(Fault::Unknown);
    }
    let width = usize::from(w1) << 8 | usize::from(w0);
    let height = usize::from(h1) << 8 | usize::from(h0);
    let mut frame = Frame {
        progressive: code == marker::SOF2,
        width,
        height,
        components: Vec::new(),
    };
    for part in rest.chunks_exact(3).take(count.into()) {
        let sampling = [part[1] >> 4, part[1] & 15].map(usize::from);
        if sampling.iter().any(|side| !(1..=4).contains(side)) {
            return lacking(HEADER);
        }
        frame.components.push(Component {
            id: part[0],
            sampling,
            low: [None; 64],
            set: Vec::new(),
        });
    }
    let pixels = width as u64 * height as u64;
    if !(1..=MAX_PIXELS).contains(&pixels) || !(1..=4).contains(&frame.components.len()) {
        return Err(Fault::Unknown);
    }
    if frame.progressive {
        let [h, v] = frame.largest();
        let units = width.div_ceil(8 * h) * height.div_ceil(8 * v);
        for component in &mut frame.components {
            component.set = vec![0; units * component.sampling.iter().product::<usize>()];
        }
    }
    Ok(frame)
}

/// Components of a scan, each with the places of its two tables, and the coefficients.
type Header = (Vec<(usize, usize, usize)>, Band);

/// Reads the header of a scan.
fn header(content: &[u8], frame: &Frame) -> Result<Header, Fault> {
    let Some((&count, rest)) = content.split_first() else {
        return lacking(HEADER);
    };
    let Some((parts, &[first, last, bits])) = rest.split_at_checked(2 * usize::from(count)) else {
        return lacking(HEADER);
    };
    let mut members = Vec::new();
    for part in parts.chunks_exact(2) {
        let index = frame.components.iter().position(|c| c.id == part[0]);
        let (dc, ac) = (usize::from(part[1] >> 4), usize::from(part[1] & 15));
        members.push((
            index
                .filter(|_| dc < 4 && ac < 4)
                .ok_or_else(|| Fault::Lacking(HEADER.into()))?,
            dc,
            ac,
        ));
    }
    let band = if frame.progressive {
        Band {
            first: first.into(),
            last: last.into(),
            low: bits & 15,
            refines: bits >> 4 > 0,
        }
    } else {
        Band {
            first: 0,
            last: 63,
            low: 0,
            refines: false,
        }
    };
    let mixed = frame.progressive && band.first == 0 && band.last > 0;
    let many = frame.progressive && band.first > 0 && members.len() != 1;
    if members.is_empty() || band.last > 63 || band.first > band.last || mixed || many {
        return lacking(HEADER);
    }
    Ok((members, band))
}
