// From numbers to colours.

/** Shown where a number is not finite: no map and hardly a picture holds it. */
const BROKEN = [255, 0, 255];

const MAPS = Object.fromEntries(Object.entries(DATA.maps).map(([name, hex]) =>
  [name, Array.from({ length: 256 }, (_, i) => [0, 2, 4].map((k) => parseInt(hex.substr(6 * i + k, 2), 16)))]));

/** sRGB of linear v, a byte [IEC 61966-2-1]. */
function srgb(v) {
  const c = Math.min(Math.max(v, 0), 1);
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
}

/** Where a colour scale ends: stops shorten it as they brighten a picture. */
function scaleEnd(quantity, stops) {
  return DATA.ranges[quantity] * 2 ** -stops;
}

/** Colour of a number, on a scale that ends at `end`. */
function falseColour(quantity, v, end) {
  if (!Number.isFinite(v)) return BROKEN;
  const signed = QUANTITIES[quantity].map === "signed";
  const t = signed ? 0.5 + 0.5 * v / end : v / end;
  return MAPS[QUANTITIES[quantity].map][Math.round(255 * Math.min(Math.max(t, 0), 1))];
}

/** A picture, or its errors, as colours: RGBA bytes. */
function colours(picture, reference, quantity, stops) {
  const out = new ImageData(WIDTH, HEIGHT);
  if (quantity === "picture") paintPicture(out.data, picture.rgb, stops);
  else paintNumbers(out.data, picture, reference, quantity, scaleEnd(quantity, stops));
  return out;
}

function paintPicture(out, { bits, scale }, stops) {
  const factor = scale * 2 ** stops;
  const bytes = new Uint8Array(65536);
  for (let b = 0; b < 65536; b++) bytes[b] = srgb(HALF[b] * factor);
  for (let i = 0; i < PIXELS; i++) {
    let broken = false;
    for (let k = 0; k < 3; k++) {
      const b = bits[k * PIXELS + i];
      broken ||= (b & 0x7c00) === 0x7c00;
      out[4 * i + k] = bytes[b];
    }
    if (broken) out.set(BROKEN, 4 * i);
    out[4 * i + 3] = 255;
  }
}

function paintNumbers(out, picture, reference, quantity, end) {
  const { of } = QUANTITIES[quantity];
  for (let i = 0; i < PIXELS; i++) {
    out.set(falseColour(quantity, of(picture, reference, i), end), 4 * i);
    out[4 * i + 3] = 255;
  }
}
