// The data: planes of half floats, unpacked. A picture keeps the bits; tables turn them into numbers and colours.

const DATA = JSON.parse(document.getElementById("data").textContent);
const [WIDTH, HEIGHT] = DATA.size;
const PIXELS = WIDTH * HEIGHT;

/** The number that each of the 65536 half floats stands for. */
const HALF = new Float32Array(65536);
for (let bits = 0; bits < 65536; bits++) {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023;
  const size = exponent === 31 ? (fraction ? NaN : Infinity)
    : exponent === 0 ? fraction * 2 ** -24
    : (1 + fraction / 1024) * 2 ** (exponent - 15);
  HALF[bits] = bits >> 15 ? -size : size;
}

/** Bytes of a plane's element, which is emptied. */
async function unpack(id) {
  const element = document.getElementById(id);
  const text = atob(element.textContent);
  element.textContent = "";
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Half floats: channel by channel all upper bytes, then all lower ones. */
async function unpackHalves(packed) {
  const bytes = await unpack(packed.id);
  const count = packed.channels * PIXELS;
  const bits = new Uint16Array(count);
  for (let i = 0; i < count; i++) bits[i] = (bytes[i] << 8) | bytes[count + i];
  return { bits, scale: packed.scale };
}

/** All pictures, the reference first. */
async function unpackAll() {
  return Promise.all(DATA.pictures.map(async (p) => {
    const halves = (packed) => packed ? unpackHalves(packed) : null;
    const [rgb, bias, deviation, flip] = await Promise.all(
      [halves(p.rgb), halves(p.bias), halves(p.deviation), p.flip ? unpack(p.flip.id) : null]);
    return { label: p.label, rgb, bias, deviation, flip };
  }));
}

/** Value of channel k of pixel i. */
function value(plane, k, i) {
  return HALF[plane.bits[k * PIXELS + i]] * plane.scale;
}

// What can be shown besides the picture: for each a number a pixel, of picture p against reference r.

const RELATIVE = (d, r) => d / Math.sqrt(r * r + DATA.floor);

function rootMeanSquare(p, r, i, of) {
  let sum = 0;
  for (let k = 0; k < 3; k++) {
    const truth = value(r.rgb, k, i);
    sum += of(value(p.rgb, k, i) - truth, truth) ** 2;
  }
  return Math.sqrt(sum / 3);
}

function meanDifference(p, r, i) {
  let sum = 0;
  for (let k = 0; k < 3; k++) sum += value(p.rgb, k, i) - value(r.rgb, k, i);
  return sum / 3;
}

/** Name, unit, colour map, where its scale ends, and the number. Zero for the reference. */
const QUANTITIES = {
  picture: { name: "Picture" },
  error: { name: "Error", unit: "radiance, root mean square of channels; the mean of its square is MSE", map: "magma", of: (p, r, i) => rootMeanSquare(p, r, i, (d) => d) },
  relative: { name: "Relative error", unit: "of the reference; the mean of its square is relMSE", map: "magma", of: (p, r, i) => rootMeanSquare(p, r, i, RELATIVE) },
  signed: { name: "Signed error", unit: "radiance, mean of channels, picture minus reference", map: "signed", of: meanDifference },
  flip: { name: "FLIP", unit: "HDR, 0 to 1", map: "magma", of: (p, r, i) => p.flip ? p.flip[i] / 255 : 0 },
  bias: { name: "Bias", unit: "radiance, mean of seeds and channels minus reference", map: "signed", of: (p, r, i) => p.bias ? value(p.bias, 0, i) : 0 },
  deviation: { name: "Standard deviation", unit: "radiance, between seeds", map: "magma", of: (p, r, i) => p.deviation ? value(p.deviation, 0, i) : 0 },
};

/** Those that there is data for. */
function quantities() {
  const split = DATA.pictures.some((p) => p.bias);
  return Object.keys(QUANTITIES).filter((q) => split || !["bias", "deviation"].includes(q));
}

/** A number in three digits. */
function digits(v) {
  if (v === 0) return "0";
  if (!Number.isFinite(v)) return String(v);
  const size = Math.abs(v);
  return size >= 1e-3 && size < 1e5 ? String(Number(v.toPrecision(3))) : v.toExponential(2);
}
