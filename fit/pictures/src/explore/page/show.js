// What the page shows: images, curves, and sentences.

const toCode = Uint8Array.from({ length: 4097 }, (_, k) => {
  const v = k / 4096;
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
});

// Draws one or three planes of light, times an exposure and above an ambient light.
function draw(canvas, planes, width, height, exposure, ambient) {
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const pen = canvas.getContext("2d");
  const image = pen.createImageData(width, height);
  const out = new Uint32Array(image.data.buffer);
  const [red, green, blue] = planes.length === 3 ? planes : [planes[0], planes[0], planes[0]];
  const scale = 4096 * exposure;
  const base = 4096 * exposure * ambient;
  const grey = planes.length === 1;
  for (let i = 0; i < out.length; i++) {
    const r = toCode[clip(red[i] * scale + base)];
    const g = grey ? r : toCode[clip(green[i] * scale + base)];
    const b = grey ? r : toCode[clip(blue[i] * scale + base)];
    out[i] = 0xff000000 | (b << 16) | (g << 8) | r;
  }
  pen.putImageData(image, 0, 0);
}

function clip(value) {
  return value > 4096 ? 4096 : value < 0 ? 0 : value | 0;
}

// A number with three digits, as people write it.
function shown(value) {
  if (value === null || !Number.isFinite(value)) return "not known";
  const size = Math.abs(value);
  if (size >= 1e5 || (size > 0 && size < 1e-4)) return value.toExponential(2);
  return String(Number(value.toPrecision(3)));
}

// ---- Curves.

// MTF along both axes at each frequency, with the ends of its 95 % interval where `bands` asks for
// them and they are known.
function curves(settings, frequencies, bands) {
  const value = [0, 0];
  const mtf = (changed) => {
    const place = new Place({ ...settings, ...changed });
    return [0, 1].map((axis) =>
      frequencies.map((f) => {
        place.otf(axis === 0 ? f : 0, axis === 0 ? 0 : f, value);
        return Math.hypot(value[0], value[1]);
      }),
    );
  };
  const middle = mtf({});
  const slopes = ["spread", "c"].map((key) => {
    const own = settings[key];
    if (!own || !bands) return null;
    const by = 0.01 * own;
    const [less, more] = [mtf({ [key]: own - by }), mtf({ [key]: own + by })];
    return more.map((all, axis) => all.map((v, k) => (v - less[axis][k]) / (2 * by)));
  });
  return middle.map((all, axis) =>
    all.map((value, k) => {
      const [bySpread, byC] = slopes.map((slope) => slope?.[axis][k] ?? 0);
      const error = bands ? standardError(settings.incidence, [bySpread, byC, 0]) : null;
      const half = error === null ? null : 1.96 * error;
      return {
        value,
        low: half === null ? null : Math.max(0, value - half),
        high: half === null ? null : Math.min(1, value + half),
      };
    }),
  );
}

// Frequency from which on the lesser of both curves is below a level; 0 if it never is above.
function fallsTo(place, level) {
  const value = [0, 0];
  const lesser = (f) => {
    place.otf(f, 0, value);
    const along = Math.hypot(value[0], value[1]);
    place.otf(0, f, value);
    return Math.min(along, Math.hypot(value[0], value[1]));
  };
  if (!place.returns || lesser(0) < level) return 0;
  // Fine enough for the shift, and for a lobe or waves.
  const coarsest = Math.min(0.05 / Math.max(place.settings.c, 1e-9), 0.1 / place.core);
  const step = Math.min(place.highest() / 200, coarsest);
  if (!Number.isFinite(step)) return Infinity;
  for (let low = 0, f = step; f < place.highest() + step; low = f, f += step) {
    if (lesser(f) >= level) continue;
    let high = f;
    for (let k = 0; k < 24; k++) {
      const middle = 0.5 * (low + high);
      if (lesser(middle) < level) high = middle;
      else low = middle;
    }
    return low;
  }
  return place.highest();
}

const NAMES = ["tangential", "sagittal"];

// Draws both curves into an SVG as wide as its place, so that its text is as large as that of the
// page.
function plot(svg, place, mark, bands) {
  const width = Math.max(260, svg.clientWidth || 640);
  const height = 260;
  const [left, right, top, bottom] = [46, width - 14, 14, height - 44];
  const last = fallsTo(place, 0.03);
  const end = nice(Number.isFinite(last) && last > 0 ? 1.25 * last : 1);
  const frequencies = Array.from({ length: 121 }, (_, k) => (k * end) / 120);
  const x = (f) => left + ((right - left) * f) / end;
  const y = (m) => bottom - (bottom - top) * m;
  const points = (list) => list.map(([f, m]) => `${x(f).toFixed(1)},${y(m).toFixed(1)}`).join(" ");
  const parts = [];
  for (let k = 0; k <= 4; k++) {
    const level = k / 4;
    parts.push(`<line class="rule" x1="${left}" x2="${right}" y1="${y(level)}" y2="${y(level)}"/>`);
    parts.push(`<text class="y" x="${left - 8}" y="${y(level) + 4}">${level}</text>`);
    const at = level * end;
    parts.push(`<text class="x" x="${x(at)}" y="${bottom + 18}">${shown(at)}</text>`);
  }
  const middle = (left + right) / 2;
  parts.push(`<text class="x" x="${middle}" y="${height - 6}">frequency, 1/mm</text>`);
  const labels = [];
  const both = curves(place.settings, frequencies, bands);
  NAMES.forEach((name, axis) => {
    const all = both[axis];
    if (all[0].high !== null) {
      const band = frequencies
        .map((f, k) => [f, all[k].high])
        .concat(frequencies.map((f, k) => [f, all[k].low]).reverse());
      parts.push(`<polygon class="band ${name}" points="${points(band)}"/>`);
    }
    const line = frequencies.map((f, k) => [f, all[k].value]);
    parts.push(`<polyline class="curve ${name}" points="${points(line)}"/>`);
    // The upper curve has its name above it, the lower one below it.
    const at = 30;
    const above = both[axis][at].value >= both[1 - axis][at].value - 1e-9 * (axis + 1);
    labels.push([name, x(frequencies[at]), y(line[at][1]), above]);
  });
  if (mark > 0 && mark < end) {
    parts.push(`<line class="mark" x1="${x(mark)}" x2="${x(mark)}" y1="${top}" y2="${bottom}"/>`);
  }
  for (const [name, at, level, above] of labels) {
    const place = above
      ? `x="${at + 10}" y="${Math.max(top + 10, level - 10)}"`
      : `x="${at - 10}" y="${Math.min(bottom - 8, level + 22)}" text-anchor="end"`;
    parts.push(`<text class="label ${name}" ${place}>${name}</text>`);
  }
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.setAttribute("height", height);
  svg.innerHTML = parts.join("");
}

// The least of 1, 2, 4, 8 times a power of ten that is not below a number.
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 4, 8, 10].map((n) => n * power).find((n) => n >= value);
}

// ---- Sentences.

// What lies outside of the photographs at these settings.
function outside(settings) {
  const domain = data.domain;
  if (!domain) return [];
  const ranges = [
    ["distance", domain.floating_distance_mm, "mm"],
    ["incidence", domain.incidence_deg, "deg"],
    ["azimuth", data.azimuth ? domain.azimuth_deg : null, "deg"],
  ];
  return ranges
    .filter(([key, range]) => range && !holds(key, range, settings[key]))
    .map(([key, [low, high], unit]) => {
      const span = low === high ? shown(low) : `${shown(low)} to ${shown(high)}`;
      return `${key} (photographed: ${span} ${unit})`;
    });
}

function holds(key, [low, high], value) {
  const near = 1e-6 * Math.max(Math.abs(low), Math.abs(high)) + 1e-9;
  const inside = (v) => v >= low - near && v <= high + near;
  return key === "azimuth" ? sameAzimuths(value).some(inside) : inside(value);
}

// Azimuths that the symmetry of the cell makes equal, from -720 to 720 degrees.
function sameAzimuths(azimuth) {
  const { first, step, count, ends } = data.azimuth;
  if (ends === "open") return [azimuth];
  const period = step * (ends === "turn" ? count : 2 * (count - 1));
  const starts = ends === "mirrors" ? [azimuth, 2 * first - azimuth] : [azimuth];
  const all = [];
  const turns = Math.ceil(1080 / period);
  for (const start of starts) {
    for (let k = -turns; k <= turns; k++) all.push(start + k * period);
  }
  return all;
}
