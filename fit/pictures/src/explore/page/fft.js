// Fourier transforms of any length, after Stockham: each stage writes in order, so that nothing is
// sorted.
class Fourier {
  constructor(length) {
    this.length = length;
    this.stages = [];
    let rest = length;
    let stride = 1;
    while (rest > 1) {
      const radix = [4, 2, 3, 5].find((p) => rest % p === 0) ?? smallestFactor(rest);
      const count = rest / radix;
      // Twiddles of each group: exp(-2 pi i p k / rest).
      const cosines = new Float64Array(count * radix);
      const sines = new Float64Array(count * radix);
      for (let p = 0; p < count; p++) {
        for (let k = 0; k < radix; k++) {
          const angle = (-2 * Math.PI * p * k) / rest;
          cosines[p * radix + k] = Math.cos(angle);
          sines[p * radix + k] = Math.sin(angle);
        }
      }
      const root = (k) => (2 * Math.PI * k) / radix;
      const cos = Float64Array.from({ length: radix }, (_, k) => Math.cos(root(k)));
      const sin = Float64Array.from({ length: radix }, (_, k) => -Math.sin(root(k)));
      this.stages.push({ radix, count, stride, cosines, sines, cos, sin });
      rest = count;
      stride *= radix;
    }
    this.spare = [new Float64Array(length), new Float64Array(length)];
  }

  // Transforms in place; with the parts exchanged it is the inverse, without the factor 1/length.
  transform(re, im) {
    let [ar, ai] = [re, im];
    let [br, bi] = this.spare;
    for (const stage of this.stages) {
      const run = { 2: two, 3: three, 4: four }[stage.radix] ?? any;
      run(stage, ar, ai, br, bi);
      [ar, ai, br, bi] = [br, bi, ar, ai];
    }
    if (ar !== re) {
      re.set(ar);
      im.set(ai);
    }
  }

  inverse(re, im) {
    this.transform(im, re);
  }
}

function smallestFactor(n) {
  let p = 7;
  while (n % p !== 0) p += 2;
  return p;
}

function two({ count, stride, cosines, sines }, ar, ai, br, bi) {
  for (let p = 0; p < count; p++) {
    const c = cosines[2 * p + 1];
    const s = sines[2 * p + 1];
    let x = stride * p;
    let y = stride * 2 * p;
    const half = stride * count;
    for (let q = 0; q < stride; q++, x++, y++) {
      const dr = ar[x] - ar[x + half];
      const di = ai[x] - ai[x + half];
      br[y] = ar[x] + ar[x + half];
      bi[y] = ai[x] + ai[x + half];
      br[y + stride] = dr * c - di * s;
      bi[y + stride] = dr * s + di * c;
    }
  }
}

function three({ count, stride, cosines, sines }, ar, ai, br, bi) {
  const root = -Math.sqrt(0.75);
  const step = stride * count;
  for (let p = 0; p < count; p++) {
    const [c1, s1] = [cosines[3 * p + 1], sines[3 * p + 1]];
    const [c2, s2] = [cosines[3 * p + 2], sines[3 * p + 2]];
    let x = stride * p;
    let y = stride * 3 * p;
    for (let q = 0; q < stride; q++, x++, y++) {
      const sr = ar[x + step] + ar[x + 2 * step];
      const si = ai[x + step] + ai[x + 2 * step];
      const dr = root * (ar[x + step] - ar[x + 2 * step]);
      const di = root * (ai[x + step] - ai[x + 2 * step]);
      const mr = ar[x] - 0.5 * sr;
      const mi = ai[x] - 0.5 * si;
      br[y] = ar[x] + sr;
      bi[y] = ai[x] + si;
      const [r1, i1, r2, i2] = [mr - di, mi + dr, mr + di, mi - dr];
      br[y + stride] = r1 * c1 - i1 * s1;
      bi[y + stride] = r1 * s1 + i1 * c1;
      br[y + 2 * stride] = r2 * c2 - i2 * s2;
      bi[y + 2 * stride] = r2 * s2 + i2 * c2;
    }
  }
}

function four({ count, stride, cosines, sines }, ar, ai, br, bi) {
  const step = stride * count;
  for (let p = 0; p < count; p++) {
    const c1 = cosines[4 * p + 1];
    const s1 = sines[4 * p + 1];
    const c2 = cosines[4 * p + 2];
    const s2 = sines[4 * p + 2];
    const c3 = cosines[4 * p + 3];
    const s3 = sines[4 * p + 3];
    let x = stride * p;
    let y = stride * 4 * p;
    for (let q = 0; q < stride; q++, x++, y++) {
      const r02 = ar[x] + ar[x + 2 * step];
      const i02 = ai[x] + ai[x + 2 * step];
      const d02 = ar[x] - ar[x + 2 * step];
      const e02 = ai[x] - ai[x + 2 * step];
      const r13 = ar[x + step] + ar[x + 3 * step];
      const i13 = ai[x + step] + ai[x + 3 * step];
      // -i times the difference of the odd ones.
      const d13 = ai[x + step] - ai[x + 3 * step];
      const e13 = ar[x + 3 * step] - ar[x + step];
      br[y] = r02 + r13;
      bi[y] = i02 + i13;
      const r1 = d02 + d13;
      const i1 = e02 + e13;
      const r2 = r02 - r13;
      const i2 = i02 - i13;
      const r3 = d02 - d13;
      const i3 = e02 - e13;
      br[y + stride] = r1 * c1 - i1 * s1;
      bi[y + stride] = r1 * s1 + i1 * c1;
      br[y + 2 * stride] = r2 * c2 - i2 * s2;
      bi[y + 2 * stride] = r2 * s2 + i2 * c2;
      br[y + 3 * stride] = r3 * c3 - i3 * s3;
      bi[y + 3 * stride] = r3 * s3 + i3 * c3;
    }
  }
}

// A transform of a stage by its definition.
function any({ radix, count, stride, cosines, sines, cos, sin }, ar, ai, br, bi) {
  const step = stride * count;
  for (let p = 0; p < count; p++) {
    for (let k = 0; k < radix; k++) {
      const c = cosines[radix * p + k];
      const s = sines[radix * p + k];
      for (let q = 0; q < stride; q++) {
        const x = stride * p + q;
        let r = 0;
        let i = 0;
        for (let j = 0, turn = 0; j < radix; j++) {
          const at = x + j * step;
          r += ar[at] * cos[turn] - ai[at] * sin[turn];
          i += ar[at] * sin[turn] + ai[at] * cos[turn];
          turn += k;
          if (turn >= radix) turn -= radix;
        }
        const y = stride * (radix * p + k) + q;
        br[y] = r * c - i * s;
        bi[y] = r * s + i * c;
      }
    }
  }
}

// Transforms are kept: a slider asks for the same few lengths again and again.
const fouriers = new Map();
function fourier(length) {
  if (!fouriers.has(length)) fouriers.set(length, new Fourier(length));
  return fouriers.get(length);
}

// The least number from `least` on that has no prime factor above 5, of the given parity.
function smooth(least, odd) {
  for (let n = least; ; n++) {
    if ((n % 2 === 1) !== odd) continue;
    let rest = n;
    for (const p of [2, 3, 5]) while (rest % p === 0) rest /= p;
    if (rest === 1) return n;
  }
}
