// Light of a sheet as polygons, where the page has the paths of the table (see gaps.rs): at a
// direction, the lines of each path leave a convex polygon, and a map turns it into shifts.

// Area below which a polygon is nothing but rounding, square edge lengths.
const NO_AREA = 1e-12;

const CORNERS = [
  [0, 0],
  [0, 1],
  [1, 0],
  [1, 1],
];

function tauOf(incidence, azimuth) {
  const sine = Math.sin((incidence * Math.PI) / 180) / data.gaps.index;
  const tangent = sine / Math.sqrt(1 - sine * sine);
  const angle = (azimuth * Math.PI) / 180;
  return [tangent * Math.cos(angle), tangent * Math.sin(angle)];
}

// The gap of an axis that holds an angle, the ends of the gap, and the place between them.
function gapOf(axis, angle) {
  const gaps = Math.max(1, axis.length - 1);
  let gap = 0;
  while (gap + 1 < gaps && axis[gap + 1] <= angle) gap++;
  const [low, high] = [axis[gap], axis[Math.min(gap + 1, axis.length - 1)]];
  const place = high > low ? (angle - low) / (high - low) : 0;
  return { gap, gaps, ends: [low, high], place: Math.max(0, Math.min(1, place)) };
}

// Azimuth of the sector that stands for any azimuth, and whether it is mirrored.
function foldedAzimuth({ first, step, count, ends }, azimuth) {
  if (ends === "open") return [azimuth, false];
  const width = step * (ends === "turn" ? count : count - 1);
  const period = ends === "turn" ? width : 2 * width;
  const within = (((azimuth - first) % period) + period) % period;
  return within <= width ? [first + within, false] : [first + period - within, true];
}

// Shares of the values at 0, 1/2 and 1 in the parabola through them.
function parabola(t) {
  return [(1 - 2 * t) * (1 - t), 4 * t * (1 - t), t * (2 * t - 1)];
}

// Polygons of the light at a direction: corners (u, v) in edge lengths, and the share of the light
// that is launched. Light that is astray by a tangent is shifted by `perTangent` times it.
function polygonsAt(incidence, azimuth, perTangent) {
  const { gaps } = data;
  const [own, mirrored] = data.azimuth
    ? foldedAzimuth(data.azimuth, azimuth)
    : [gaps.azimuth[0], false];
  const along = gapOf(gaps.incidence, incidence);
  const around = gapOf(gaps.azimuth, own);
  const tau = tauOf(incidence, own);
  const corners = CORNERS.map(([a, b]) => tauOf(along.ends[a], around.ends[b]));
  const middle = [0, 1].map((k) => corners.reduce((sum, corner) => sum + corner[k] / 4, 0));
  const beyond = [tau[0] - middle[0], tau[1] - middle[1]];
  const share = ([a, b]) =>
    (a ? along.place : 1 - along.place) * (b ? around.place : 1 - around.place);
  const angle = (own * Math.PI) / 180;
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const turned = (x, y) => [cos * x + sin * y, cos * y - sin * x];
  // A number is constant, affine in tau, or known at nine places.
  const [byIncidence, byAzimuth] = [parabola(along.place), parabola(around.place)];
  const value = (parts) => {
    if (parts.length === 1) return parts[0];
    if (parts.length === 3) return parts[0] + parts[1] * beyond[0] + parts[2] * beyond[1];
    return parts.reduce(
      (sum, part, k) => sum + part * byIncidence[Math.floor(k / 3)] * byAzimuth[k % 3],
      0,
    );
  };
  const found = [];
  for (const path of gaps.paths[along.gap * around.gaps + around.gap]) {
    const present = path.jumps.reduce((left, corner) => left - share(corner), 1);
    // Lines that hardly turn from each other can meet far away, after the path has ended.
    const moved = path.there.map(([a, b]) => {
      const corner = corners[2 * a + b];
      return gaps.fastest * Math.hypot(corner[0] - tau[0], corner[1] - tau[1]);
    });
    const margin = Math.min(...moved) + 1e-6;
    const [[left, low], [right, high]] = path.bounds;
    let polygon = [
      [left - margin, low - margin],
      [right + margin, low - margin],
      [right + margin, high + margin],
      [left - margin, high + margin],
    ];
    for (const line of path.lines) {
      const [x, y, offset] = line.map(value);
      polygon = cut(polygon, (p) => x * p[0] + y * p[1] - offset);
    }
    const [uu, uv, vu, vv, x, y, weight] = path.map.map(value);
    const area = areaOf(polygon);
    const light = (Math.max(0, Math.min(1, weight)) * Math.max(0, present) * area) / gaps.entrance;
    if (area <= NO_AREA || light <= 0) continue;
    const astray = deviation(turned(x, y), tau, gaps.index);
    const shift = ([px, py]) => {
      const [u, v] = turned(uu * px + uv * py, vu * px + vv * py);
      const across = v + perTangent[1] * astray[1];
      return [u + perTangent[0] * astray[0], mirrored ? -across : across];
    };
    found.push({ corners: polygon.map(shift), light });
  }
  return found;
}

// Tangents of the angle between returned light and straight back. Snell's law keeps the part of the
// light along the sheet, times the index.
function deviation([x, y], tau, index) {
  if (x === 0 && y === 0) return [0, 0];
  const square = tau[0] ** 2 + tau[1] ** 2;
  const steep = Math.sqrt(1 + square);
  const along = (-index * Math.sqrt(square)) / steep;
  const up = Math.sqrt(Math.max(0, 1 - along * along));
  const left = [along + (index * x) / steep, (index * y) / steep];
  const z = Math.sqrt(Math.max(0, 1 - left[0] ** 2 - left[1] ** 2));
  const straight = left[0] * along + z * up;
  return [(left[0] * up - z * along) / straight, left[1] / straight];
}

// The part of a convex polygon where `beyond` is not positive.
function cut(polygon, beyond) {
  const kept = [];
  let before = polygon[polygon.length - 1];
  let past = before && beyond(before);
  for (const corner of polygon) {
    const here = beyond(corner);
    if (here * past < 0) {
      const part = past / (past - here);
      kept.push([
        before[0] + part * (corner[0] - before[0]),
        before[1] + part * (corner[1] - before[1]),
      ]);
    }
    if (here <= 0) kept.push(corner);
    [before, past] = [corner, here];
  }
  return kept;
}

// Area of a polygon, positive if its corners run counter-clockwise.
function areaOf(polygon) {
  let twice = 0;
  for (let k = 2; k < polygon.length; k++) {
    const [o, a, b] = [polygon[0], polygon[k - 1], polygon[k]];
    twice += (a[0] - o[0]) * (b[1] - o[1]) - (b[0] - o[0]) * (a[1] - o[1]);
  }
  return 0.5 * twice;
}

// Adds the transform of light that is spread evenly over a polygon, times `light`, to `out`: a sum
// over its edges.
function addTransform(polygon, light, x, y, out) {
  const squared = x * x + y * y;
  const size = Math.max(...polygon.map((corner) => Math.hypot(...corner)));
  const count = polygon.length;
  if (Math.sqrt(squared) * size < 1e-4) {
    const phase = polygon.reduce((sum, [u, v]) => sum + (x * u + y * v) / count, 0);
    out[0] += light * Math.cos(2 * Math.PI * phase);
    out[1] -= light * Math.sin(2 * Math.PI * phase);
    return;
  }
  const scale = light / (2 * Math.PI * squared * areaOf(polygon));
  for (let k = 0; k < count; k++) {
    const [a, b] = [polygon[k], polygon[(k + 1) % count]];
    const [u, v] = [b[0] - a[0], b[1] - a[1]];
    const phase = Math.PI * (x * (a[0] + b[0]) + y * (a[1] + b[1]));
    const part = scale * (x * v - y * u) * sinc(x * u + y * v);
    out[0] += part * Math.sin(phase);
    out[1] += part * Math.cos(phase);
  }
}

// Weights between square pixels of light that is spread over polygons in pixels, (column, row). A
// weight is the mean of the light over both pixels: that of a tent, which is bilinear between whole
// numbers. So each piece of a polygon between them is told by four moments.
function depositedWeights(polygons) {
  let widest = 0;
  for (const { corners } of polygons) {
    for (const corner of corners) {
      widest = Math.max(widest, Math.abs(corner[0]), Math.abs(corner[1]));
    }
  }
  const reach = Math.floor(widest) + 2;
  const size = 2 * reach + 1;
  const sums = new Float64Array(size * size);
  for (const { corners, light } of polygons) {
    const per = light / areaOf(corners);
    const rows = corners.map((corner) => corner[1]);
    for (let y = Math.floor(Math.min(...rows)); y < Math.max(...rows); y++) {
      const above = cut(corners, (p) => y - p[1]);
      const strip = cut(above, (p) => p[1] - y - 1);
      if (strip.length < 3) continue;
      const columns = strip.map((corner) => corner[0]);
      const end = Math.max(...columns);
      for (let x = Math.floor(Math.min(...columns)); x < end; x++) {
        const beside = cut(strip, (p) => x - p[0]);
        const [one, u, v, uv] = moments(cut(beside, (p) => p[0] - x - 1), x, y);
        const at = (y + reach) * size + x + reach;
        sums[at] += per * (one - u - v + uv);
        sums[at + 1] += per * (u - uv);
        sums[at + size] += per * (v - uv);
        sums[at + size + 1] += per * uv;
      }
    }
  }
  return { reach, values: Float32Array.from(sums) };
}

// Integrals of 1, u, v and u v over a polygon, where (u, v) is the place beyond (x, y).
function moments(polygon, x, y) {
  const all = [0, 0, 0, 0];
  for (let k = 2; k < polygon.length; k++) {
    const [a, b, c] = [polygon[0], polygon[k - 1], polygon[k]].map((p) => [p[0] - x, p[1] - y]);
    const area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]));
    const [u, v] = [a[0] + b[0] + c[0], a[1] + b[1] + c[1]];
    all[0] += area;
    all[1] += (area * u) / 3;
    all[2] += (area * v) / 3;
    all[3] += (area * (u * v + a[0] * a[1] + b[0] * b[1] + c[0] * c[1])) / 12;
  }
  return all;
}
