// Pictures: those of the page itself, and a picture of the user. Values are linear light.
const SIDE = 512;

const toLinear = Float32Array.from({ length: 256 }, (_, code) => {
  const v = code / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
});

const BUILT_IN = { sign: drawSign, card: drawCard, edge: drawEdge };

// A picture from a canvas.
function pictureOf(canvas) {
  const { width, height } = canvas;
  const codes = canvas.getContext("2d").getImageData(0, 0, width, height).data;
  const planes = [0, 1, 2].map((k) => {
    const plane = new Float32Array(width * height);
    for (let i = 0; i < plane.length; i++) plane[i] = toLinear[codes[4 * i + k]];
    return plane;
  });
  const [r, g, b] = planes;
  const luminance = r.map((v, i) => 0.2126 * v + 0.7152 * g[i] + 0.0722 * b[i]);
  const [white, most] = [peak(luminance), Math.max(...planes.map(peak))];
  return { width, height, canvas, planes, luminance, codes, white, most };
}

function peak(plane) {
  let most = 0;
  for (const value of plane) if (value > most) most = value;
  return most;
}

function canvasOf(width, height, draw) {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width, height });
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, width, height);
  draw(pen);
  return canvas;
}

function builtIn(name) {
  const height = name === "sign" ? 304 : SIDE;
  return pictureOf(canvasOf(SIDE, height, BUILT_IN[name]));
}

// An image of the user, at most SIDE pixels wide and high.
function fromImage(image) {
  const [width, height] = [image.naturalWidth ?? image.width, image.naturalHeight ?? image.height];
  const scale = Math.min(1, SIDE / Math.max(width, height));
  const size = [width, height].map((n) => Math.max(2, Math.round(n * scale)));
  return pictureOf(canvasOf(...size, (pen) => pen.drawImage(image, 0, 0, ...size)));
}

async function fromFile(file) {
  const image = await createImageBitmap(file);
  return fromImage(image);
}

async function fromAddress(address) {
  const image = new Image();
  image.src = address;
  await image.decode();
  return fromImage(image);
}

// A sign as it hangs above a door: a running figure, an arrow, a frame.
function drawSign(pen) {
  pen.translate(0, -104);
  pen.fillStyle = "#0a8f4a";
  pen.fillRect(16, 120, 480, 272);
  pen.fillStyle = "#fff";
  pen.strokeStyle = "#fff";
  pen.lineCap = "round";
  pen.lineJoin = "round";
  pen.lineWidth = 6;
  pen.strokeRect(28, 132, 456, 248);
  pen.beginPath();
  pen.arc(214, 178, 20, 0, 2 * Math.PI);
  pen.fill();
  const line = (width, ...points) => {
    pen.lineWidth = width;
    pen.beginPath();
    points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.stroke();
  };
  line(30, [196, 216], [172, 276]);
  line(18, [196, 216], [154, 226], [132, 262]);
  line(18, [198, 216], [232, 250], [262, 240]);
  line(20, [172, 276], [216, 304], [206, 356]);
  line(20, [172, 276], [150, 318], [104, 330]);
  line(16, [310, 256], [440, 256]);
  line(16, [392, 206], [444, 256], [392, 306]);
}

// Letters E of known sizes, lines, a star and colours.
function drawCard(pen) {
  pen.fillStyle = "#fff";
  let x = 16;
  for (const unit of [14, 10, 7, 5, 4, 3, 2, 1]) {
    for (const [row, turned] of [
      [0, false],
      [1, true],
    ]) {
      const y = 16 + row * 86;
      for (let k = 0; k < 3; k++) {
        const bar = turned ? [2 * k * unit, 0, unit, 5 * unit] : [0, 2 * k * unit, 5 * unit, unit];
        pen.fillRect(x + bar[0], y + bar[1], bar[2], bar[3]);
      }
      if (turned) pen.fillRect(x, y + 4 * unit, 5 * unit, unit);
      else pen.fillRect(x, y, unit, 5 * unit);
    }
    x += 5 * unit + 24;
  }
  let at = 16;
  for (const pitch of [16, 12, 8, 6, 4, 3, 2, 1]) {
    for (let k = 0; k < 4; k++) pen.fillRect(at + 2 * k * pitch, 196, pitch, 48);
    for (let k = 0; k < 4; k++) pen.fillRect(at, 256 + 2 * k * pitch, 48, pitch);
    at += Math.max(8 * pitch, 48) + 8;
  }
  const spokes = 36;
  for (let k = 0; k < spokes; k++) {
    pen.beginPath();
    pen.moveTo(384, 400 + 0);
    pen.arc(384, 400, 100, (2 * k * Math.PI) / spokes, ((2 * k + 1) * Math.PI) / spokes);
    pen.fill();
  }
  const colours = ["#ff0000", "#00ff00", "#0000ff", "#00ffff", "#ff00ff", "#ffff00"];
  colours.forEach((colour, k) => {
    pen.fillStyle = colour;
    pen.fillRect(16 + (k % 3) * 80, 400 + Math.floor(k / 3) * 48, 72, 40);
  });
}

// An edge as it is photographed: 5 degrees from upright.
function drawEdge(pen) {
  const slope = Math.tan((5 * Math.PI) / 180);
  pen.fillStyle = "#fff";
  pen.beginPath();
  pen.moveTo(256 + 256 * slope, 0);
  pen.lineTo(512, 0);
  pen.lineTo(512, 512);
  pen.lineTo(256 - 256 * slope, 512);
  pen.fill();
}
