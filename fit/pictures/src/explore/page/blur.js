// Weights between pixels, and the convolution of pictures with them.

// Widest blur, pixels on either side, and transforms that are evaluated for it at most. Light that
// is spread farther comes round within the blur, so that none is lost.
const FINE = { widest: 202, evaluations: 150000 };
const QUICK = { widest: 67, evaluations: 40000 };

// Weights of the blur for pixels of a pitch, mm, in a picture whose plane of incidence is
// horizontal: the point spread averaged over both squares. Rows and columns run from -reach to
// reach.
function weights(place, pitch, limits = FINE) {
  if (!place.returns) return { reach: 0, values: Float32Array.of(0) };
  if (place.polygons && data.lobe === null) {
    // Columns run along the plane of incidence, rows against the sagittal axis.
    const down = data.seen_in_mirror ? pitch : -pitch;
    const pixels = ({ corners, light }) => ({
      corners: corners.map(([u, v]) => [u / pitch, v / down]),
      light: light / place.light,
    });
    return depositedWeights(place.polygons.map(pixels));
  }
  // Frequencies in cycles per pixel that look alike on whole pixels, up to where the OTF ends.
  const rim = Math.min(16, Math.max(0.5, place.highest() * pitch));
  const pixels = (mm) => Math.floor(mm / pitch) + 2;
  const affordable = Math.floor(Math.sqrt(limits.evaluations / 2) / (2 * rim));
  const most = Math.max(pixels(place.core), Math.min(limits.widest, affordable));
  const size = smooth(2 * Math.min(pixels(place.reach), most) + 1, true);
  const reach = (size - 1) / 2;
  const turns = Math.ceil(rim);
  const alike = (k) => {
    const all = [];
    for (let m = -turns - 1; m <= turns; m++) {
      const f = k / size + m;
      const weight = sinc(f) ** 2;
      if (Math.abs(f) <= rim && weight > 1e-12) all.push([f / pitch, weight]);
    }
    return all;
  };
  const columns = (size + 1) / 2;
  const across = Array.from({ length: columns }, (_, k) => alike(k));
  const down = Array.from({ length: size }, (_, k) => alike(k));
  const re = Array.from({ length: columns }, () => new Float64Array(size));
  const im = Array.from({ length: columns }, () => new Float64Array(size));
  const value = [0, 0];
  for (let column = 0; column < columns; column++) {
    for (let row = 0; row < size; row++) {
      // The first column is its own mirror image.
      let [r, i] = [0, 0];
      for (const [x, byX] of across[column]) {
        for (const [y, byY] of down[row]) {
          // Columns run along the plane of incidence, rows against the sagittal axis.
          place.otf(x, data.seen_in_mirror ? y : -y, value);
          r += value[0] * byX * byY;
          i += value[1] * byX * byY;
        }
      }
      re[column][row] = r;
      im[column][row] = i;
    }
    fourier(size).inverse(re[column], im[column]);
  }
  const values = new Float32Array(size * size);
  const [lineRe, lineIm] = [new Float64Array(size), new Float64Array(size)];
  for (let row = 0; row < size; row++) {
    for (let k = 0; k < size; k++) {
      const own = k < columns ? k : size - k;
      lineRe[k] = re[own][row];
      lineIm[k] = k < columns ? im[own][row] : -im[own][row];
    }
    lineIm[0] = 0;
    fourier(size).inverse(lineRe, lineIm);
    const to = ((row + reach) % size) * size;
    for (let k = 0; k < size; k++) {
      values[to + ((k + reach) % size)] = lineRe[k] / (size * size);
    }
  }
  return { reach, values };
}

function sinc(x) {
  return x === 0 ? 1 : Math.sin(Math.PI * x) / (Math.PI * x);
}

// Convolution of pictures of one size, padded so that nothing comes round.
class Convolver {
  constructor(width, height, reach) {
    Object.assign(this, { width, height, reach });
    this.across = smooth(width + reach, false);
    this.down = smooth(height + reach, false);
    this.columns = this.across / 2 + 1;
    this.rows = [new Float64Array(this.across), new Float64Array(this.across)];
    this.column = [new Float64Array(this.down), new Float64Array(this.down)];
    const size = this.columns * this.down;
    this.work = [new Float32Array(size), new Float32Array(size)];
  }

  // Transforms the rows of real lines, two at once. `line(y, out)` writes line y and says whether
  // it has one. Columns are contiguous in `to`.
  transformRows(lines, line, [toRe, toIm]) {
    const [re, im] = this.rows;
    const { across, columns, down } = this;
    const plan = fourier(across);
    for (let k = 0; k < lines.length; k += 2) {
      re.fill(0);
      im.fill(0);
      line(lines[k], re);
      if (k + 1 < lines.length) line(lines[k + 1], im);
      plan.transform(re, im);
      for (let x = 0; x < columns; x++) {
        const mirror = x === 0 ? 0 : across - x;
        const [a, b, c, d] = [re[x], im[x], re[mirror], im[mirror]];
        const at = x * down;
        toRe[at + lines[k]] = 0.5 * (a + c);
        toIm[at + lines[k]] = 0.5 * (b - d);
        if (k + 1 < lines.length) {
          toRe[at + lines[k + 1]] = 0.5 * (b + d);
          toIm[at + lines[k + 1]] = 0.5 * (c - a);
        }
      }
    }
  }

  transformColumn([re, im], column, out) {
    const { down } = this;
    out[0].set(re.subarray(column * down, (column + 1) * down));
    out[1].set(im.subarray(column * down, (column + 1) * down));
    fourier(down).transform(out[0], out[1]);
  }

  // Spectrum of a plane; it serves for every blur.
  spectrum(plane) {
    const { width, height, columns, down } = this;
    const size = columns * down;
    const to = [new Float32Array(size), new Float32Array(size)];
    const lines = Array.from({ length: height }, (_, y) => y);
    const row = (y, out) => out.set(plane.subarray(y * width, (y + 1) * width));
    this.transformRows(lines, row, to);
    for (let column = 0; column < columns; column++) {
      this.transformColumn(to, column, this.column);
      to[0].set(this.column[0], column * down);
      to[1].set(this.column[1], column * down);
    }
    return to;
  }

  // Convolves planes, given by their spectra, with weights times a factor.
  blur(spectra, { reach, values }, factor) {
    const { across, down, columns, width, height } = this;
    const size = 2 * reach + 1;
    const scale = factor / (across * down);
    const kernel = this.work;
    kernel[0].fill(0);
    kernel[1].fill(0);
    const lines = Array.from({ length: size }, (_, k) => (k - reach + down) % down);
    const line = (y, out) => {
      const row = (y > reach ? y - down : y) + reach;
      for (let k = -reach; k <= reach; k++) {
        out[(k + across) % across] = values[row * size + k + reach] * scale;
      }
    };
    this.transformRows(lines, line, kernel);
    const images = spectra.map(() => [new Float32Array(kernel[0].length), null]);
    for (const image of images) image[1] = new Float32Array(kernel[0].length);
    const [re, im] = this.column;
    const product = [new Float64Array(down), new Float64Array(down)];
    for (let column = 0; column < columns; column++) {
      this.transformColumn(kernel, column, this.column);
      const at = column * down;
      spectra.forEach(([ownRe, ownIm], k) => {
        for (let y = 0; y < down; y++) {
          const [a, b] = [ownRe[at + y], ownIm[at + y]];
          product[0][y] = a * re[y] - b * im[y];
          product[1][y] = a * im[y] + b * re[y];
        }
        fourier(down).inverse(product[0], product[1]);
        images[k][0].set(product[0], at);
        images[k][1].set(product[1], at);
      });
    }
    return images.map((image) => this.rowsBack(image, width, height));
  }

  // Transforms rows back, two real ones at once.
  rowsBack([fromRe, fromIm], width, height) {
    const { across, down, columns } = this;
    const [re, im] = this.rows;
    const plane = new Float32Array(width * height);
    for (let y = 0; y < height; y += 2) {
      const next = y + 1 < height ? 1 : 0;
      for (let x = 0; x < columns; x++) {
        const at = x * down + y;
        const [a, b] = [fromRe[at], fromIm[at]];
        const [c, d] = next ? [fromRe[at + 1], fromIm[at + 1]] : [0, 0];
        re[x] = a - d;
        im[x] = b + c;
        if (x > 0 && x < across - x) {
          re[across - x] = a + d;
          im[across - x] = c - b;
        }
      }
      fourier(across).inverse(re, im);
      for (let x = 0; x < width; x++) {
        plane[y * width + x] = re[x];
        if (next) plane[(y + 1) * width + x] = im[x];
      }
    }
    return plane;
  }
}
