// Sliders, pictures, and the loop that draws.

const $ = (id) => document.getElementById(id);

// A slider: its range, whether it is a logarithm, its unit, and what it stands for.
function sliders() {
  const { span, incidence, azimuth, parameters, domain } = data;
  const last = (axis) => axis.first + axis.step * (axis.count - (axis.ends === "turn" ? 0 : 1));
  const middle = (range, low, high) =>
    range ? Math.max(low, Math.min(high, 0.5 * (range[0] + range[1]))) : 0.5 * (low + high);
  const [near, far] = span.distance_mm;
  const at = domain ? domain.floating_distance_mm[0] : Math.sqrt(near * far);
  const all = [
    ["distance", "Floating distance", "mm", near, far, at, true, domain?.floating_distance_mm],
    [
      "incidence",
      "Incidence",
      "deg",
      incidence.first,
      last(incidence),
      middle(domain?.incidence_deg, incidence.first, last(incidence)),
      false,
      domain?.incidence_deg,
    ],
  ];
  if (azimuth && azimuth.count > 1) {
    const range = domain?.azimuth_deg;
    const turn = azimuth.ends === "open" ? [azimuth.first, last(azimuth)] : [0, 360];
    const start = Math.max(turn[0], Math.min(turn[1], range ? range[0] : azimuth.first));
    all.push(["azimuth", "Azimuth", "deg", ...turn, start, false, range]);
  }
  all.push(["width", "Width of the picture", "mm", ...span.width_mm, 100, true, null]);
  const factor = [...span.factor, 1, true, null];
  if (parameters.c.length) all.push(["c", NAMES_OF[data.size_name], "x fit", ...factor]);
  if (parameters.spread.length) {
    all.push(["spread", NAMES_OF[data.spread_name], "x fit", ...factor]);
  }
  if (parameters.mu.length) all.push(["mu", "Reflectance mu", "x fit", ...factor]);
  return all.map(([key, label, unit, low, high, usual, log, range]) => {
    const value = Math.max(low, Math.min(high, data.start[key] ?? usual));
    return { key, label, unit, low, high, value, log, range };
  });
}

const NAMES_OF = {
  c_mm: "Corner size c",
  surface_roughness: "Roughness of the front",
  a_per_mm: "Diffraction spread a",
  a_times_r: "Diffraction spread a R",
  roughness: "Roughness",
};
const UNITS_OF = { c_mm: " mm", a_per_mm: " 1/mm" };

const SLIDERS = sliders();
const state = Object.fromEntries(SLIDERS.map(({ key, value }) => [key, value]));
const STEPS = 1000;
// Boxes of numbers that no slider has.
const BOXES = ["luminance", "ambient", "threshold", "viewer"];

function position({ low, high, log }, value) {
  const share = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * share);
}

function valueAt({ low, high, log }, at) {
  const share = at / STEPS;
  return log ? low * (high / low) ** share : low + share * (high - low);
}

// Settings of the model: parameters are factors on the fitted values at the incidence.
function settings(from = state) {
  const { spread, c, mu } = data.parameters;
  const at = (all, factor, none) => {
    const own = fitted(all, from.incidence);
    return own === null ? none : own * (factor ?? 1);
  };
  return {
    distance: from.distance,
    incidence: from.incidence,
    azimuth: data.azimuth?.count > 1 ? from.azimuth : (data.azimuth?.first ?? null),
    spread: at(spread, from.spread, 1),
    c: at(c, from.c, 1),
    mu: at(mu, from.mu, null),
  };
}

// ---- Rendering.

let picture = null;
let convolver = null;
let spectra = null;

function use(next) {
  picture = next;
  convolver = null;
  draw($("source"), picture.planes, picture.width, picture.height, 1, 0);
  refresh(true);
}

// Planes of the mid-air image, before exposure. `colour` is false while a slider moves.
function render(place, pitch, colour) {
  const planes = colour ? picture.planes : [picture.luminance];
  const each = colour && data.colours
    ? data.colours.map((stretch) => new Place(place.settings, stretch))
    : [place];
  const blurs = each.map((own) => weights(own, pitch, colour ? FINE : QUICK));
  const reach = Math.max(...blurs.map((blur) => blur.reach));
  if (!convolver || convolver.reach < reach || convolver.reach > 2 * reach + 32) {
    convolver = new Convolver(picture.width, picture.height, reach);
    spectra = new Map();
  }
  const own = planes.map((plane) => {
    if (!spectra.has(plane)) spectra.set(plane, convolver.spectrum(plane));
    return spectra.get(plane);
  });
  const energy = place.energy() ?? 1;
  if (blurs.length === 1) return convolver.blur(own, blurs[0], energy);
  return own.flatMap((plane, k) => convolver.blur([plane], blurs[k], energy));
}

// The narrowest picture whose blur the page can render, mm.
function narrowest(place) {
  return ((place.core / (FINE.widest - 2)) * Math.max(picture.width, picture.height)) * 1.001;
}

let resting = 0;
let asked = false;

// Draws at the next frame; in colour when the sliders rest.
function refresh(colour) {
  clearTimeout(resting);
  if (colour) remember();
  if (!colour) resting = setTimeout(() => refresh(true), 150);
  if (asked && !colour) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    paint(colour);
  });
}

function paint(colour) {
  if (!picture) return;
  const own = settings();
  const place = new Place(own);
  const width = Math.max(state.width, narrowest(place));
  const pitch = width / Math.max(picture.width, picture.height);
  const planes = render(place, pitch, colour);
  const light = Number($("luminance").value) || 0;
  const ambient = light > 0 ? (Number($("ambient").value) || 0) / light : 0;
  const brightest = planes.length === 3 ? brightestOf(planes) : peak(planes[0]);
  const auto = $("auto").checked && brightest + ambient > 0;
  // Blur mixes colours: a colour may then be brighter than any of the source, and be clipped.
  const alike = picture.white / (brightest + ambient);
  if (colour) {
    const unclipped = picture.most / (Math.max(...planes.map(peak)) + ambient);
    picture.darker = alike > 0 ? Math.min(1, unclipped / alike) : 1;
  }
  // While a slider moves there is no colour to look at: the last one counts.
  const exposure = auto ? alike * (picture.darker ?? 1) : 1;
  draw($("aerial"), planes, picture.width, picture.height, exposure, ambient);
  say(own, place, { width, pitch, exposure, light, ambient, colour });
}

function brightestOf([r, g, b]) {
  let most = 0;
  for (let i = 0; i < r.length; i++) {
    const own = 0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i];
    if (own > most) most = own;
  }
  return most;
}

// ---- Numbers and sentences.

function say(own, place, { width, pitch, exposure, light, ambient, colour }) {
  const height = pitch * picture.height;
  const energy = place.energy();
  const threshold = Math.min(1, Math.max(0.001, Number($("threshold").value) || data.letter.contrast));
  // The contrast (Lmax - Lmin) / (Lmax + Lmin) of a wide pattern, whose dark is the ambient light.
  const contrast = energy === null ? 1 : energy > 0 ? energy / (energy + 2 * ambient) : 0;
  const finest = contrast > threshold ? fallsTo(place, threshold / contrast) : 0;
  const half = fallsTo(place, 0.5);
  // The smallest letters that normal sight reads.
  const viewer = Math.max(0, Number($("viewer").value) || 0);
  const eye = 1000 * viewer * Math.tan((data.letter.arcminutes / 60) * (Math.PI / 180));
  const letter = Math.max(data.letter.periods / finest, eye);
  // Bands by c need more mixtures where the blur depends on the scaling: they wait for a rest.
  plot($("curves"), place, finest, colour || data.scaling === "fixed");
  const facts = {
    "fact-size": `${shown(pitch * picture.width)} x ${shown(height)} mm`,
    "fact-luminance":
      energy === null
        ? `not known: ${data.by_hand ? "mu was not given" : "the result has no mu"}`
        : `${shown(energy * light)}${interval(own, place, light)} cd/m\u00b2, ` +
          `${shown(100 * energy)} % of the source`,
    "fact-mtf50": half > 0 ? `${shown(half)} 1/mm` : "no contrast",
    "fact-letter":
      finest > 0
        ? letterText(letter, eye, viewer, height)
        : "none: no contrast above the threshold",
    "fact-exposure": `x ${shown(exposure)}`,
  };
  for (const [id, text] of Object.entries(facts)) $(id).textContent = text;
  const remarks = note ? [note] : [];
  if (!place.returns) remarks.push("Nothing returns in this direction: the image is black.");
  if (width > state.width * 1.0001) {
    remarks.push(`The picture is shown ${shown(width)} mm wide: at ${shown(state.width)} mm its ` +
      "blur would be wider than this page can compute.");
  }
  const left = outside(own);
  if (left.length) {
    remarks.push(`Outside of the photographs of the fit: ${left.join(", ")}. Nothing was ` +
      "measured there.");
  }
  if (data.kernel === "eq1" && left.some((text) => text.startsWith("distance"))) {
    const [near, far] = data.domain.floating_distance_mm;
    remarks.push("The kernel eq1 takes the blur as the same at every distance. The kernels " +
      "angular and wave let it grow. " + (near === far
        ? "Photographs at two distances tell which of them holds."
        : `Photographs from ${shown(near)} to ${shown(far)} mm chose eq1; beyond them nothing ` +
          "was measured."));
  }
  if (data.misfit[0] > data.goal) {
    const share = shown(100 * data.misfit[0]);
    remarks.push(`A pixel of this page can err by ${share} % of the brightest.`);
  }
  if (data.by_hand) {
    remarks.push("This sheet was not photographed. Real sheets are dimmer and less sharp than " +
      "ideal ones.");
  }
  list($("remarks"), remarks);
  $("aerial").setAttribute("aria-label", `Mid-air image, ${facts["fact-size"]}, ` +
    `${shown(own.distance)} mm from the sheet, incidence ${shown(own.incidence)} degrees`);
}

// What limits the smallest letter: the blur, the eye, or the picture itself.
function letterText(letter, eye, viewer, height) {
  if (letter > height) return `none: it would be ${shown(letter)} mm high`;
  const least = `${shown(letter)} mm high`;
  if (letter === eye) return `${least}, limited by the eye at ${shown(viewer)} m`;
  return `${least}, limited by the blur (by the eye at ${shown(viewer)} m: ${shown(eye)} mm)`;
}

// Fills a list with sentences.
function list(element, sentences) {
  element.replaceChildren(
    ...sentences.map((text) => {
      const item = document.createElement("li");
      item.textContent = text;
      return item;
    }),
  );
}

// The 95 % interval of the luminance, as text; empty where it is not known.
function interval(own, place, light) {
  const byMu = place.light * data.half_mirror * light;
  const error = standardError(own.incidence, [0, 0, byMu]);
  if (error === null) return "";
  const value = own.mu * byMu;
  return ` (${shown(Math.max(0, value - 1.96 * error))} to ${shown(value + 1.96 * error)})`;
}

// ---- Controls.

// The value of a slider as a person reads and types it, and what stands behind it.
function valueOf(slider) {
  return slider.unit === "x fit" ? settings()[slider.key] : state[slider.key];
}

function unitOf(slider) {
  if (slider.unit !== "x fit") return slider.unit;
  const name = slider.key === "c" ? data.size_name : slider.key === "mu" ? "mu" : data.spread_name;
  const of = data.by_hand ? "given" : "fit";
  return `${UNITS_OF[name] ?? ""} (${shown(state[slider.key])} x ${of})`.trim();
}

// Sentence about the last typed value; empty if it was taken as it was.
let note = "";

// Takes a typed value, as far as the range of its slider goes.
function type(slider, text) {
  const value = Number(text);
  note = "";
  if (text.trim() !== "" && Number.isFinite(value)) {
    const one = slider.unit === "x fit" ? valueOf(slider) / state[slider.key] : 1;
    state[slider.key] = Math.max(slider.low, Math.min(slider.high, value / one));
    if (state[slider.key] !== value / one) {
      const [low, high] = [slider.low, slider.high].map((end) => shown(end * one));
      note = `${slider.label}: ${text} is outside of ${low} to ${high}, and is shown as ` +
        `${shown(valueOf(slider))}.`;
    }
  }
  sync();
  refresh(true);
}

// Hatches the track of a slider where no photograph was taken, and marks the fitted value with its
// 95 % interval.
function track(slider) {
  const percent = (value) => {
    const at = (100 * position(slider, value)) / STEPS;
    return Math.max(0, Math.min(100, at)).toFixed(1);
  };
  if (slider.range) {
    const turned = (v) => (slider.key === "azimuth" ? ((v % 360) + 360) % 360 : v);
    const [low, high] = slider.range.map((v) => Number(percent(turned(v))));
    // A range that was photographed at one value is still a mark that can be seen.
    return { low: Math.max(0, low - 0.7), high: Math.min(100, high + 0.7) };
  }
  if (slider.unit !== "x fit") return null;
  const all = data.parameters[slider.key];
  const own = parts(all, state.incidence)[0];
  const half = own.standard_error ? (1.96 * own.standard_error) / own.value : 0;
  const [low, high] = [Math.max(slider.low, 1 - half), Math.min(slider.high, 1 + half)]
    .map(percent)
    .map(Number);
  return { low: Math.max(0, low - 0.7), high: Math.min(100, high + 0.7) };
}

function addSlider(slider) {
  const row = document.createElement("div");
  row.className = "slider";
  row.innerHTML = `<label for="s-${slider.key}"></label><span class="exact">` +
    `<input type="number" id="n-${slider.key}" step="any"> <output id="o-${slider.key}"></output>` +
    `</span>` +
    `<span class="track" aria-hidden="true"><i></i></span>` +
    `<input type="range" id="s-${slider.key}" min="0" max="${STEPS}" step="1">`;
  row.querySelector("label").textContent = slider.label;
  $("sliders").append(row);
  const exact = row.querySelector(".exact input");
  exact.setAttribute("aria-label", `${slider.label}, as a number`);
  exact.addEventListener("change", () => type(slider, exact.value));
  const input = row.querySelector("[type=range]");
  input.addEventListener("input", () => {
    note = "";
    state[slider.key] = valueAt(slider, Number(input.value));
    sync(false);
    refresh(false);
  });
  input.addEventListener("change", () => refresh(true));
}

// Saves both pictures with a caption, as they are shown, as a PNG.
function save() {
  const [source, aerial] = [$("source"), $("aerial")];
  const [gap, line] = [16, 22];
  const lines = [
    `Source${" ".repeat(4)}${$("fact-size").textContent}`,
    `${$("aerial").getAttribute("aria-label")}, exposure ${$("fact-exposure").textContent}`,
    `${$("design").textContent}: white ${$("fact-luminance").textContent}`,
  ];
  const width = source.width + gap + aerial.width;
  const height = aerial.height + gap + line * lines.length;
  const sheet = document.createElement("canvas");
  Object.assign(sheet, { width, height });
  const pen = sheet.getContext("2d");
  pen.fillStyle = "#fff";
  pen.fillRect(0, 0, width, height);
  pen.drawImage(source, 0, 0);
  pen.drawImage(aerial, source.width + gap, 0);
  pen.fillStyle = "#1d2226";
  pen.font = "15px system-ui, sans-serif";
  lines.forEach((text, k) => pen.fillText(text, 4, aerial.height + line * (k + 1), width - 8));
  const link = document.createElement("a");
  link.download = "mid-air.png";
  link.href = sheet.toDataURL("image/png");
  link.click();
  return sheet;
}

// Brings sliders and texts to the state.
function sync(move = true) {
  for (const slider of SLIDERS) {
    const input = $(`s-${slider.key}`);
    if (move) input.value = position(slider, state[slider.key]);
    const [value, unit] = [shown(valueOf(slider)), unitOf(slider)];
    $(`n-${slider.key}`).value = value;
    $(`o-${slider.key}`).textContent = unit;
    input.setAttribute("aria-valuetext", `${value} ${unit}`);
    const found = track(slider);
    const row = input.parentElement;
    row.classList.toggle("hatched", Boolean(slider.range));
    const mark = row.querySelector("i");
    mark.hidden = !found;
    if (found) {
      mark.style.left = `${found.low}%`;
      mark.style.width = `${found.high - found.low}%`;
    }
  }
}

// Writes the settings into the part of the address behind #, so that a link leads back to them.
function remember() {
  const parts = SLIDERS.map(({ key }) => `${key}=${Number(state[key].toPrecision(6))}`);
  parts.push(...BOXES.map((id) => `${id}=${Number($(id).value) || 0}`));
  const fragment = parts.join("&");
  try {
    history.replaceState(null, "", `#${fragment}`);
  } catch {
    // A page in a frame of another origin may not change its address; it works without.
  }
}

// Takes settings from the part of the address behind #.
function fromAddressBar() {
  for (const [key, text] of new URLSearchParams(location.hash.slice(1))) {
    const slider = SLIDERS.find((one) => one.key === key);
    const value = Number(text);
    if (BOXES.includes(key) && Number.isFinite(value)) $(key).value = value;
    if (slider && Number.isFinite(value)) {
      state[key] = Math.max(slider.low, Math.min(slider.high, value));
    }
  }
}

// Picture of the user that was dropped or chosen last.
let dropped = null;

async function choose(name) {
  try {
    if (name === "dropped") use(dropped);
    else use(name === "own" ? await fromAddress(data.source[1]) : builtIn(name));
  } catch {
    list($("remarks"), ["The picture could not be shown."]);
  }
}

async function take(file) {
  if (!file) return;
  try {
    dropped = await fromFile(file);
    const name = [...$("choice").options].find((one) => one.value === "dropped") ??
      $("choice").appendChild(new Option("", "dropped"));
    name.textContent = file.name;
    name.selected = true;
    use(dropped);
  } catch {
    const what = `${file.name} could not be read as a picture; take a PNG, a JPEG or a WebP.`;
    list($("remarks"), [what]);
  }
}

async function begin() {
  await unpack();
  $("threshold").value = data.letter.contrast;
  const { luminance, ambient } = data.start;
  if (luminance) $("luminance").value = luminance;
  if (ambient) $("ambient").value = Number((ambient * $("luminance").value).toPrecision(6));
  fromAddressBar();
  SLIDERS.forEach(addSlider);
  const option = (value, text) => $("choice").append(new Option(text, value));
  if (data.source) option("own", data.source[0]);
  option("sign", "Sign");
  option("card", "Test card");
  option("edge", "Edge");
  $("choice").addEventListener("change", () => choose($("choice").value));
  $("file").addEventListener("change", () => take($("file").files[0]));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    take(event.dataTransfer.files[0]);
  });
  for (const id of BOXES) {
    $(id).addEventListener("input", () => refresh(true));
  }
  $("auto").addEventListener("change", () => refresh(true));
  $("reset").addEventListener("click", () => {
    note = "";
    for (const { key, value } of SLIDERS) state[key] = value;
    sync();
    refresh(true);
  });
  $("save").addEventListener("click", save);
  $("larger").addEventListener("click", () => {
    const large = document.querySelector("main").classList.toggle("large");
    $("larger").setAttribute("aria-pressed", large);
    refresh(true);
  });
  addEventListener("resize", () => refresh(true));
  const [name, about] = data.by_hand ? [data.title, data.design] : [data.design, data.title];
  $("design").textContent = name;
  document.title = `${name}: mid-air image`;
  for (const part of document.querySelectorAll(".fitted")) part.hidden = data.by_hand;
  const model = `kernel ${data.kernel}${data.lobe ? `, lobe ${data.lobe}` : ""}`;
  const verdict = data.verdict ? `The fit is ${data.verdict}. ` : "";
  const warned = data.warnings.length;
  $("about").textContent = `${about}: ${model}. ${verdict}${warned ? `Read the ${warned} ` +
    `warning${warned > 1 ? "s" : ""} below.` : ""}`;
  list($("warnings"), data.warnings);
  $("warned").hidden = data.warnings.length === 0;
  const percent = (share) => `${shown(100 * share)} %`;
  $("error").textContent = `Against fit render, a pixel errs by at most ` +
    `${percent(data.misfit[0])} of the brightest, and a weight of the blur by at most ` +
    `${percent(data.misfit[1])} of the largest. This was measured at ${data.places} places ` +
    `between the directions that the page holds.`;
  sync();
  await choose(data.source ? "own" : "sign");
}

// For scripts, and for the console of the browser: settings in mm and degrees, c, spread and mu as
// factors on the fit. `render` returns the planes of light of the mid-air image, source white = 1.
window.airr = {
  state,
  save,
  settings,
  picture: () => picture,
  use: (name) => use(builtIn(name)),
  render: (changed = {}, colour = true) => {
    const from = { ...state, ...changed };
    const place = new Place(settings(from));
    const pitch = from.width / Math.max(picture.width, picture.height);
    return { planes: render(place, pitch, colour), pitch, energy: place.energy() };
  },
  otf: (x, y, changed = {}) => {
    const value = [0, 0];
    new Place(settings({ ...state, ...changed })).otf(x, y, value);
    return value;
  },
  seconds: (frames, key = "incidence") => {
    const slider = SLIDERS.find((one) => one.key === key);
    const began = performance.now();
    for (let k = 0; k < frames; k++) {
      state[key] = valueAt(slider, (STEPS * (k + 0.5)) / frames);
      sync();
      paint(false);
    }
    return (performance.now() - began) / 1000 / frames;
  },
};

window.airr.ready = begin();
