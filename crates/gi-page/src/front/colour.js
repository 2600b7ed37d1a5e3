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

/** Byte that shows a component of a direction. */
function directionByte(v) {
  return Math.round(127.5 + 127.5 * Math.min(Math.max(v, -1), 1));
}

/** Colour of a number on a scale. */
function falseColour({ map, end }, v) {
  if (!Number.isFinite(v)) return BROKEN;
  const t = map === "signed" ? 0.5 + 0.5 * v / end : v / end;
  return MAPS[map][Math.round(255 * Math.min(Math.max(t, 0), 1))];
}

/** A picture, or what its scale shows of it, as colours: RGBA bytes. Stops brighten a picture. */
function colours(picture, stops) {
  const out = new ImageData(WIDTH, HEIGHT);
  const scale = scaleFor(picture);
  if (scale) paintNumbers(out.data, scale);
  else paintPicture(out.data, picture.rgb, picture.directions ? directionByte : (v) => srgb(v * 2 ** stops));
  return out;
}

function paintPicture(out, { bits, scale }, byteOf) {
  const bytes = new Uint8Array(65536);
  for (let b = 0; b < 65536; b++) bytes[b] = byteOf(HALF[b] * scale);
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

function paintNumbers(out, scale) {
  for (let i = 0; i < PIXELS; i++) {
    out.set(falseColour(scale, scale.of(i)), 4 * i);
    out[4 * i + 3] = 255;
  }
}
