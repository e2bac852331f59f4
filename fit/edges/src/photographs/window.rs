//! The part of a photograph in which an edge is searched: linear light, in pixel units, with the
//! origin at its centre.

use crate::photographs::photo::plane::Photo;

/// A rectangle of linear pixel values. Positions are relative to the centre of the rectangle, in
/// pixels, x to the right and y down.
#[derive(Debug, Clone)]
pub struct Window {
    width: usize,
    height: usize,
    values: Vec<f32>,
    /// Factor of [`Window::excess`].
    excess: f64,
    /// Level of [`Window::ceiling`].
    ceiling: Option<f64>,
}

/// One pixel: its position (pixels, from the window's centre) and its value.
#[derive(Debug, Clone, Copy)]
pub struct Pixel {
    /// Distance to the right of the window's centre, pixels.
    pub x: f64,
    /// Distance below the window's centre, pixels.
    pub y: f64,
    /// Linear light.
    pub value: f64,
}

/// The positions of a window's pixels without their values. Excluded pixels are not among them.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    /// Indices of the excluded pixels, row by row, ascending.
    taken_out: Vec<usize>,
}

impl Raster {
    /// Returns the positions of the pixels (x to the right, y down, pixels from the window's
    /// centre), in the order of [`Window::pixels`].
    pub fn positions(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let (cx, cy) = centre(self.width, self.height);
        let mut taken_out = self.taken_out.iter().peekable();
        (0..self.width * self.height)
            .filter(move |index| taken_out.next_if_eq(&index).is_none())
            .map(move |index| {
                let (x, y) = (index % self.width, index / self.width);
                [x as f64 - cx, y as f64 - cy]
            })
    }
}

fn centre(width: usize, height: usize) -> (f64, f64) {
    (0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0))
}

impl Window {
    /// Cuts the rectangle `[x, y, width, height]` out of a photograph, or takes all of it. Returns
    /// `None` if the rectangle is empty or does not fit.
    pub fn of(photo: &Photo, roi: Option<[usize; 4]>) -> Option<Window> {
        let [x, y, width, height] = roi.unwrap_or([0, 0, photo.width, photo.height]);
        let fits = |at: usize, size: usize, all: usize| {
            size > 0 && at.checked_add(size).is_some_and(|end| end <= all)
        };
        if !fits(x, width, photo.width) || !fits(y, height, photo.height) {
            return None;
        }
        let values = (y..y + height)
            .flat_map(|row| &photo.luminance[row * photo.width + x..][..width])
            .copied()
            .collect();
        Some(Window {
            width,
            height,
            values,
            excess: 1.0,
            ceiling: None,
        })
    }

    /// Returns the value at which the camera cut its noise off, if bright pixels reach it. It is
    /// `None` unless `Window::set_ceiling` has set it.
    pub fn ceiling(&self) -> Option<f64> {
        self.ceiling
    }

    /// Sets the level of [`Window::ceiling`].
    pub(crate) fn set_ceiling(&mut self, level: f64) {
        self.ceiling = Some(level);
    }

    /// Returns the factor by which means over many pixels scatter more, as a variance, than those
    /// of independent pixels. It is 1 unless `Window::set_excess` has set another one.
    pub fn excess(&self) -> f64 {
        self.excess
    }

    /// Sets the factor of [`Window::excess`].
    pub(crate) fn set_excess(&mut self, excess: f64) {
        self.excess = excess;
    }

    /// Returns the width, pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the height, pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns all pixels that are not excluded, row by row. By `for_each` they come twice as fast as
    /// by `for`.
    pub fn pixels(&self) -> impl Iterator<Item = Pixel> + '_ {
        let (cx, cy) = self.centre();
        self.values
            .chunks_exact(self.width)
            .enumerate()
            .flat_map(move |(j, row)| {
                let held = row.iter().enumerate().filter(|(_, value)| !value.is_nan());
                held.map(move |(i, &value)| Pixel {
                    x: i as f64 - cx,
                    y: j as f64 - cy,
                    value: f64::from(value),
                })
            })
    }

    /// Replaces the value of every pixel by the result of `value`.
    pub fn change(&mut self, value: impl Fn(&Pixel) -> f64) {
        let (cx, cy) = self.centre();
        for (j, row) in self.values.chunks_exact_mut(self.width).enumerate() {
            for (i, held) in row.iter_mut().enumerate().filter(|(_, v)| !v.is_nan()) {
                *held = value(&Pixel {
                    x: i as f64 - cx,
                    y: j as f64 - cy,
                    value: f64::from(*held),
                }) as f32;
            }
        }
    }

    /// Excludes the pixels for which `good` is false, and returns their number.
    pub fn keep(&mut self, good: impl Fn(&Pixel) -> bool) -> usize {
        let out = std::cell::Cell::new(0);
        self.change(|pixel| {
            if good(pixel) {
                return pixel.value;
            }
            out.set(out.get() + 1);
            f64::NAN
        });
        out.get()
    }

    /// Excludes the pixels that `other`, a window of the same size, excludes.
    pub fn without_those_of(mut self, other: &Window) -> Window {
        for (value, other) in self.values.iter_mut().zip(&other.values) {
            if other.is_nan() {
                *value = f32::NAN;
            }
        }
        self
    }

    /// Returns positions along the border, in steps of an eighth of a side. The values of these
    /// pixels are 0.
    pub fn outline(&self) -> impl Iterator<Item = Pixel> {
        let (cx, cy) = self.centre();
        (0..=8).flat_map(move |k| {
            let part = f64::from(k) / 4.0 - 1.0;
            [(part, -1.0), (part, 1.0), (-1.0, part), (1.0, part)].map(|(x, y)| Pixel {
                x: x * cx,
                y: y * cy,
                value: 0.0,
            })
        })
    }

    /// Returns approximately `most` of the values, or fewer, evenly spaced.
    pub fn sample(&self, most: usize) -> Vec<f32> {
        // An odd step meets all columns of a picture whose width is a power of 2.
        let step = (self.values.len() / most) | 1;
        let held = self.values.iter().step_by(step).filter(|v| !v.is_nan());
        held.copied().collect()
    }

    /// Returns the values that 1 in 100 pixels lie below, and 1 in 100 above.
    pub fn bulk(&self) -> (f64, f64) {
        let mut sample = self.sample(65_536);
        if sample.is_empty() {
            return (0.0, 0.0);
        }
        let last = sample.len() - 1;
        let mut at = |index: usize| {
            let (_, &mut value, _) = sample.select_nth_unstable_by(index, f32::total_cmp);
            f64::from(value)
        };
        (at(last / 100), at(last - last / 100))
    }

    /// Returns the window averaged over blocks of `side` x `side` pixels. Pixels at the right and
    /// lower border that do not fill a block are left out. Excluded pixels do not count; a block
    /// without other pixels is excluded.
    pub fn reduced(&self, side: usize) -> Window {
        let (width, height) = (self.width / side, self.height / side);
        let mut sums = vec![(0.0_f32, 0.0_f32); width * height];
        let rows = self.values.chunks_exact(self.width);
        for (y, row) in rows.take(height * side).enumerate() {
            let sums = &mut sums[y / side * width..][..width];
            for ((sum, count), part) in sums.iter_mut().zip(row.chunks_exact(side)) {
                let whole = part.iter().sum::<f32>();
                if whole.is_nan() {
                    let held = part.iter().filter(|value| !value.is_nan());
                    *count += held.clone().count() as f32;
                    *sum += held.sum::<f32>();
                } else {
                    *count += side as f32;
                    *sum += whole;
                }
            }
        }
        Window {
            width,
            height,
            values: sums.into_iter().map(|(sum, count)| sum / count).collect(),
            excess: self.excess,
            ceiling: None,
        }
    }

    /// Returns the value at column `x`, row `y` of the window; NaN if the pixel is excluded.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.width + x]
    }

    /// Returns the positions of the window's pixels.
    pub fn raster(&self) -> Raster {
        let out = |(index, value): (usize, &f32)| value.is_nan().then_some(index);
        Raster {
            width: self.width,
            height: self.height,
            taken_out: self.values.iter().enumerate().filter_map(out).collect(),
        }
    }

    fn centre(&self) -> (f64, f64) {
        centre(self.width, self.height)
    }

    /// Returns the smallest and the largest value.
    pub fn extremes(&self) -> (f64, f64) {
        let (low, high) = self
            .values
            .iter()
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &v| {
                (l.min(v), h.max(v))
            });
        (f64::from(low), f64::from(high))
    }

    /// Returns the number of pixels that are exactly 0, and their share of the dark ones.
    fn zeros(&self) -> (usize, f64) {
        let dark = 0.05 * self.extremes().1 as f32;
        let count =
            |holds: fn(f32, f32) -> bool| self.values.iter().filter(|&&v| holds(v, dark)).count();
        let (zero, dark) = (count(|v, _| v == 0.0), count(|v, dark| v < dark));
        (zero, zero as f64 / dark.max(1) as f64)
    }

    /// Returns whether the noise is cut off at 0. This means that some pixels are exactly 0, none
    /// is below, and the dark side is not 0 everywhere (as in a picture without noise).
    pub fn cuts_off_at_zero(&self) -> bool {
        let (zero, share) = self.zeros();
        zero > 0 && share < 0.95 && self.extremes().0 == 0.0
    }

    /// Returns a warning about dark pixels that are exactly 0 because a sensor's noise was cut off.
    /// Returns `None` if fewer than 1 in 100 are 0, or if nearly all are (a picture without noise).
    pub fn floor_warning(&self) -> Option<String> {
        let (zero, share) = self.zeros();
        (0.01..0.95).contains(&share).then(|| {
            format!(
                "{zero} pixels ({:.1} % of the dark ones) are exactly 0: the noise is cut off, \
                which the loss edge takes into account; for other losses and `fit mtf` it raises \
                the dark plateau and lowers mu; keep the camera's black offset, or expose more",
                100.0 * share
            )
        })
    }

    /// Returns a warning about pixels at or above the level where the format saturates, or `None`
    /// if there are none.
    pub fn clipping_warning(&self, level: f32) -> Option<String> {
        let clipped = self.values.iter().filter(|&&v| v >= level).count();
        (clipped > 0).then(|| {
            let share = 100.0 * clipped as f64 / self.values.len() as f64;
            format!(
                "{clipped} pixels ({share:.2} %) are clipped, which lowers the bright plateau (the \
                loss edge takes it into account in a photograph of one channel); expose less"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the outline of a window of 9 x 17 pixels: on each side nine positions, one every
    /// eighth of the side, from corner to corner. All are exact in binary.
    #[test]
    fn the_outline_goes_along_all_sides_from_corner_to_corner() {
        let window = Window {
            width: 9,
            height: 17,
            values: vec![0.5; 9 * 17],
            excess: 1.0,
            ceiling: None,
        };
        let along = |held: fn(&Pixel) -> bool, place: fn(&Pixel) -> f64| {
            let mut places: Vec<f64> = window.outline().filter(held).map(|p| place(&p)).collect();
            places.sort_by(f64::total_cmp);
            places.dedup();
            places
        };
        let expected = |step: f64| -> Vec<f64> { (-4..=4).map(|k| step * f64::from(k)).collect() };
        let sides = [
            (along(|p| p.y == -8.0, |p| p.x), 1.0),
            (along(|p| p.y == 8.0, |p| p.x), 1.0),
            (along(|p| p.x == -4.0, |p| p.y), 2.0),
            (along(|p| p.x == 4.0, |p| p.y), 2.0),
        ];
        for (found, step) in &sides {
            assert_eq!(*found, expected(*step));
        }
        assert_eq!(window.outline().count(), 36);
    }
}
