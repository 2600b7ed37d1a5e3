// Pictures as numbers. A picture keeps the bits of half floats; a table turns them into numbers.

const DATA = JSON.parse(document.getElementById("data").textContent);

/** The size of all pictures. */
let WIDTH = 0, HEIGHT = 0, PIXELS = 0;

function setSize([width, height]) {
  [WIDTH, HEIGHT, PIXELS] = [width, height, width * height];
}

/** The number that each of the 65536 half floats stands for. */
const HALF = new Float32Array(65536);
for (let bits = 0; bits < 65536; bits++) {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023;
  const size = exponent === 31 ? (fraction ? NaN : Infinity)
    : exponent === 0 ? fraction * 2 ** -24
    : (1 + fraction / 1024) * 2 ** (exponent - 15);
  HALF[bits] = bits >> 15 ? -size : size;
}

/** Value of channel k of pixel i. */
function value(plane, k, i) {
  return HALF[plane.bits[k * PIXELS + i]] * plane.scale;
}

/** A number in three digits. */
function digits(v) {
  if (v === 0) return "0";
  if (!Number.isFinite(v)) return String(v);
  const size = Math.abs(v);
  return size >= 1e-3 && size < 1e5 ? String(Number(v.toPrecision(3))) : v.toExponential(2);
}
