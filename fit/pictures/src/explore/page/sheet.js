// The sheet: parameters, and the OTF at any place, mixed from the nodes of the grid.
const data = JSON.parse(document.getElementById("data").textContent);
// Whether the blur has shifts or waves: then a lattice has more than the frequency 0.
const shifts = data.lattices[0].points > 0;
const grid = {
  parts: data.real ? 1 : 2,
  lattices: [],
  numbers: 0,
  values: new Int16Array(0),
};
for (const { end, points } of data.lattices) {
  const margin = shifts ? data.margin : 0;
  const columns = 2 * (points + margin) + 1;
  const rows = shifts ? points + 2 * margin + 1 : 1;
  grid.lattices.push({ end, points, margin, columns, rows, start: grid.numbers });
  grid.numbers += columns * rows * grid.parts;
}
const { tail: TAIL, cut: CUT, faint: FAINT } = data;

// Unpacks the transforms: all lower bytes, then all upper bytes, in zlib's format. They are
// differences (see `packed` in grid.rs), with the sign in the lowest bit.
async function unpack() {
  const packed = Uint8Array.from(atob(data.values), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = bytes.length / 2;
  grid.values = new Int16Array(count);
  for (let k = 0; k < count; k++) {
    const coded = bytes[k] | (bytes[count + k] << 8);
    grid.values[k] = (coded >> 1) ^ -(coded & 1);
  }
  for (let start = 0; start < count; start += grid.numbers) {
    for (const lattice of grid.lattices) addUp(start + lattice.start, lattice);
  }
}

// Adds the differences of a lattice up, twice along its rows and once along its columns. The array
// takes all sums modulo 2^16.
function addUp(first, { columns, rows }) {
  const { parts, values } = grid;
  const width = columns * parts;
  for (let row = first; row < first + rows * width; row += width) {
    for (let twice = 0; twice < 2; twice++) {
      for (let k = row + parts; k < row + width; k++) values[k] += values[k - parts];
    }
    if (row > first) for (let k = row; k < row + width; k++) values[k] += values[k - width];
  }
}

// ---- Parameters.

// The numbers of a parameter whose weighted mean is its value at an incidence.
function parts(all, incidence) {
  if (all.length === 0) return [];
  if (all[0].incidence_deg === null) return [{ ...all[0], weight: 1 }];
  const next = all.findIndex((one) => one.incidence_deg >= incidence);
  if (next === 0) return [{ ...all[0], weight: 1 }];
  if (next < 0) return [{ ...all[all.length - 1], weight: 1 }];
  const [a, b] = [all[next - 1], all[next]];
  const share = (incidence - a.incidence_deg) / (b.incidence_deg - a.incidence_deg);
  return [{ ...a, weight: 1 - share }, { ...b, weight: share }];
}

function fitted(all, incidence) {
  const own = parts(all, incidence);
  return own.length ? own.reduce((sum, part) => sum + part.weight * part.value, 0) : null;
}

// Standard error of a number with derivatives by spread, c and mu; null if it is not known.
function standardError(incidence, by) {
  const kinds = [data.parameters.spread, data.parameters.c, data.parameters.mu];
  const rows = kinds.flatMap((all, kind) =>
    by[kind] === 0 ? [] : parts(all, incidence).map((p) => [p.row, by[kind] * p.weight]),
  );
  let variance = 0;
  for (const [i, a] of rows) {
    for (const [j, b] of rows) {
      const entry = i === null || j === null ? null : data.covariance[i]?.[j];
      if (entry === null || entry === undefined) return null;
      variance += a * b * entry;
    }
  }
  return variance >= 0 ? Math.sqrt(variance) : null;
}

// ---- The grid.

// Nodes and weights by which a place along an axis is mixed.
function mixture(axis, place) {
  const { first, step, count, ends, points: most } = axis;
  const points = ends === "open" ? Math.min(most, count) : most;
  const x = (place - first) / step;
  let start = Math.floor(x) - Math.floor((points - 1) / 2);
  if (ends === "open") start = Math.max(0, Math.min(count - points, start));
  const t = x - start;
  return Array.from({ length: points }, (_, own) => {
    let weight = 1;
    for (let k = 0; k < points; k++) if (k !== own) weight *= (t - k) / (own - k);
    return { ...folded(axis, start + own), weight };
  });
}

function folded({ count, ends }, number) {
  if (ends === "turn") return { node: ((number % count) + count) % count, mirrored: false };
  if (ends === "open") return { node: number, mirrored: false };
  const period = 2 * Math.max(1, count - 1);
  const within = ((number % period) + period) % period;
  return within < count
    ? { node: within, mirrored: false }
    : { node: period - within, mirrored: true };
}

const ALL = [{ node: 0, mirrored: false, weight: 1 }];

// Transforms of the shift at one direction and scaling, mixed from the nodes around it.
class Mixture {
  constructor(incidence, azimuth, scaling) {
    const along = mixture(data.incidence, incidence);
    const around = data.azimuth ? mixture(data.azimuth, azimuth) : ALL;
    const fixed = data.scaling === "fixed";
    const states = fixed ? ALL : mixture(data.state, Math.log(scaling / (scaling + data.bend)));
    this.states = states.map((state) => {
      const lattice = grid.lattices[state.node];
      const size = lattice.columns * lattice.rows;
      return { lattice, re: new Float64Array(size), im: new Float64Array(size) };
    });
    this.light = 0;
    this.reach = 0;
    const directions = data.azimuth ? data.azimuth.count : 1;
    const nodes = along.flatMap((a) => around.map((b) => [a, b]));
    for (const [a, b] of nodes) {
      this.light += a.weight * b.weight * data.energy[a.node * directions + b.node];
    }
    const scale = 1 / (data.unit * Math.max(this.light, FAINT));
    for (const [a, b] of nodes) {
      const direction = a.node * directions + b.node;
      const share = a.weight * b.weight * data.energy[direction] * scale;
      if (share === 0) continue;
      states.forEach((s, k) => {
        this.reach = Math.max(this.reach, data.reach[direction * data.state.count + s.node]);
        add(this.states[k], direction, share * s.weight, b.mirrored);
      });
    }
  }
}

// Mixtures are kept: curves and their intervals ask for the same ones.
const mixtures = new Map();
function mixtureAt(incidence, azimuth, scaling) {
  const key = `${incidence} ${azimuth} ${scaling}`;
  if (!mixtures.has(key)) {
    if (mixtures.size > 8) mixtures.delete(mixtures.keys().next().value);
    mixtures.set(key, new Mixture(incidence, azimuth, scaling));
  }
  return mixtures.get(key);
}

// The blur of the sheet at some settings: distance (mm), incidence and azimuth (degrees), spread,
// c (mm) and mu. The waves of a colour are `stretch` times as long as those of the luminance.
class Place {
  constructor(settings, stretch = 1) {
    this.settings = settings;
    const { distance, incidence, azimuth, c } = settings;
    this.polygons = data.gaps ? polygonsOf(settings) : null;
    if (this.polygons) {
      this.shaped();
      return;
    }
    const waves = (stretch * distance) / (c * c);
    const scaling = { fixed: 1, deviating: distance / c, waves }[data.scaling];
    const { light, reach, states } = mixtureAt(incidence, azimuth, scaling);
    this.states = states;
    this.light = light;
    this.returns = light > FAINT;
    const { highest, angle } = data.ends;
    const end = (highest ** -4 + (scaling / angle) ** 4) ** -0.25;
    this.end = shifts ? end / c : Infinity;
    // Tangential frequencies of shifts are those along the sheet.
    this.tilt = data.scaling === "waves" ? 1 : Math.cos((incidence * Math.PI) / 180);
    this.kink = data.kink * scaling * c;
    this.lobe = lobe(settings);
    // What holds nearly all light, and what holds all but 0.2 % of it along an axis: the tails of
    // waves and of the separable lobe are long.
    this.core = reach * c + this.lobe.core + 3 * this.kink;
    this.reach = reach * c + this.lobe.reach + this.kink / (Math.PI ** 2 * TAIL);
  }

  // Takes light and reach from the polygons, in mm.
  shaped() {
    const all = this.polygons.flatMap((polygon) => polygon.corners);
    this.light = this.polygons.reduce((sum, polygon) => sum + polygon.light, 0);
    this.returns = this.light > FAINT;
    this.lobe = lobe(this.settings);
    const shift = all.reduce((most, corner) => Math.max(most, Math.hypot(...corner)), 0);
    this.core = shift + this.lobe.core;
    this.reach = shift + this.lobe.reach;
    // The transform of a polygon falls by the square of the frequency.
    this.end = 16 / this.settings.c;
    this.tilt = 1;
  }

  // Luminance of the mid-air image divided by that of the source; null without mu.
  energy() {
    if (!this.returns) return 0;
    return this.settings.mu === null ? null : this.settings.mu * this.light * data.half_mirror;
  }

  // OTF at a frequency (tangential, sagittal), 1/mm, written to `out`.
  otf(x, y, out) {
    if (!this.returns) {
      out[0] = out[1] = 0;
      return;
    }
    if (this.polygons) {
      out[0] = out[1] = 0;
      const factor = this.lobe.at(x, y);
      if (factor === 0) return;
      for (const { corners, light } of this.polygons) {
        addTransform(corners, (factor * light) / this.light, x, y, out);
      }
      return;
    }
    const factor = this.lobe.at(x, y);
    if (!shifts || factor === 0) {
      out[0] = factor;
      out[1] = 0;
      return;
    }
    const sign = y < 0 ? -1 : 1;
    // States are mixed at the same share of their ends.
    const across = (sign * x * this.tilt) / this.end;
    const down = (sign * y) / this.end;
    out[0] = out[1] = 0;
    if (Math.abs(across) > 1 || down > 1) return;
    for (const state of this.states) interpolate(state, across, down, out);
    const smooth = this.kink > 0 ? factor * Math.exp(-this.kink * Math.hypot(x, y)) : factor;
    out[0] *= smooth;
    out[1] *= sign * smooth;
  }

  // Highest frequency at which anything is left, 1/mm.
  highest() {
    return Math.min(this.end / this.tilt, this.lobe.end);
  }
}

// Polygons of the light, (tangential, sagittal) in mm.
function polygonsOf({ distance, incidence, azimuth, c }) {
  const edge = [c * Math.cos((incidence * Math.PI) / 180), c];
  const found = polygonsAt(incidence, azimuth, [distance / edge[0], distance / edge[1]]);
  const scaled = ([u, v]) => [u * edge[0], v * edge[1]];
  return found.map(({ corners, light }) => ({ corners: corners.map(scaled), light }));
}

// Adds the transforms of a direction, times a share, to a state.
function add({ lattice, re, im }, direction, share, mirrored) {
  const { columns, rows, start } = lattice;
  const { parts, values, numbers } = grid;
  // In a mirror the sagittal frequency changes its sign: the transform at (x, -y) is the conjugate
  // of that at (-x, y). So rows are read backwards.
  const step = mirrored ? -parts : parts;
  const sign = mirrored ? -share : share;
  for (let row = 0; row < rows; row++) {
    const own = row * columns;
    const first = direction * numbers + start + own * parts;
    let from = mirrored ? first + (columns - 1) * parts : first;
    for (let column = 0; column < columns; column++, from += step) {
      re[own + column] += share * values[from];
      if (parts === 2) im[own + column] += sign * values[from + 1];
    }
  }
}

// Adds the transform of a state at a frequency, given as a share of its end, to `out`.
function interpolate({ lattice, re, im }, across, down, out) {
  const { points, margin, columns } = lattice;
  const x = across * points;
  const y = down * points;
  const left = Math.floor(x);
  const top = Math.floor(y);
  six(x - left, SIX_X);
  six(y - top, SIX_Y);
  for (let i = 0; i < 6; i++) {
    const at = (top + margin - 2 + i) * columns + left + points + margin - 2;
    let r = 0;
    let s = 0;
    for (let j = 0; j < 6; j++) {
      r += re[at + j] * SIX_X[j];
      s += im[at + j] * SIX_X[j];
    }
    out[0] += r * SIX_Y[i];
    out[1] += s * SIX_Y[i];
  }
}

const SIX_X = new Float64Array(6);
const SIX_Y = new Float64Array(6);

// Weights of the points -2 to 3 of a polynomial through six points, at t in [0, 1].
function six(t, out) {
  const [a, b, c, d, e, f] = [t + 2, t + 1, t, t - 1, t - 2, t - 3];
  out[0] = (b * c * d * e * f) / -120;
  out[1] = (a * c * d * e * f) / 24;
  out[2] = (a * b * d * e * f) / -12;
  out[3] = (a * b * c * e * f) / 12;
  out[4] = (a * b * c * d * f) / -24;
  out[5] = (a * b * c * d * e) / 120;
}

// ---- The lobe: its transfer at a frequency, its reach, and where the transfer ends.

function lobe({ distance, incidence, spread, c }) {
  if (data.gains.length) return facets(distance, incidence, spread, c);
  if (data.lobe === null) return { at: () => 1, core: 0, reach: 0, end: Infinity };
  const a = data.kernel === "angular" ? spread / distance : spread;
  if (data.lobe === "separable") {
    const slope = Math.PI / a;
    const at = (x, y) =>
      Math.max(0, 1 - slope * Math.abs(x)) * Math.max(0, 1 - slope * Math.abs(y));
    return { at, core: CUT / a, reach: 1 / (Math.PI * a * TAIL), end: a / Math.PI };
  }
  const at = (x, y) => tabulated(Math.hypot(x, y) / a);
  const reach = data.table.reach / a;
  return { at, core: reach, reach, end: tableEnd() * a };
}

function tableEnd() {
  return (data.table.values.length - 2) * data.table.step;
}

// Transfer of a lobe with a = 1/mm at f, 1/mm: a cubic through four points of its table.
function tabulated(f) {
  const { step, values } = data.table;
  const x = f / step;
  const k = Math.floor(x);
  if (k + 2 >= values.length) return 0;
  const t = x - k;
  // The transfer is even in the frequency.
  const before = k === 0 ? values[1] : values[k - 1];
  return (
    (before * t * (t - 1) * (t - 2)) / -6 +
    (values[k] * (t + 1) * (t - 1) * (t - 2)) / 2 +
    (values[k + 1] * (t + 1) * t * (t - 2)) / -2 +
    (values[k + 2] * (t + 1) * t * (t - 1)) / 6
  );
}

// Rough facets: their gains along both axes add as squares.
function facets(distance, incidence, spread, front) {
  const shares = mixture(data.incidence, incidence);
  const gain = (axis, kind) =>
    shares.reduce((sum, s) => sum + s.weight * data.gains[s.node][axis][kind][0], 0);
  const kinds = [
    [spread * distance, 0],
    [front * distance, 1],
  ].map(([scale, kind]) => ({
    x: scale * gain(0, kind),
    y: scale * gain(1, kind),
    count: data.gains[0][0][kind][1],
  }));
  const at = (x, y) =>
    kinds.reduce((product, { x: gx, y: gy, count }) => {
      const width = Math.hypot(gx * x, gy * y);
      return count === 0 || width === 0 ? product : product * tabulated(width) ** count;
    }, 1);
  const squares = (axis) => kinds.reduce((sum, k) => sum + k.count * k[axis] ** 2, 0);
  const widest = Math.max(squares("x"), squares("y"));
  const reach =
    data.lobe === "ggx" ? Math.sqrt((0.5 * widest) / TAIL) : Math.sqrt(-widest * Math.log(TAIL));
  const narrowest = Math.sqrt(Math.min(squares("x"), squares("y")));
  const core = Math.min(reach, 4 * Math.sqrt(widest));
  return { at, core, reach, end: narrowest > 0 ? tableEnd() / narrowest : Infinity };
}
