// The page's data: pictures in packed planes, and what can be shown of them.

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

/** The colour scale of what is shown; stops shorten it. */
function scaleFor(picture) {
  if (view.quantity === "picture") return null;
  const { of, ...scale } = QUANTITIES[view.quantity];
  return { ...scale, end: DATA.ranges[view.quantity] * 2 ** -view.stops, of: (i) => of(picture, pictures[0], i) };
}

/** What the fourth number of a pixel is. */
function inspected() {
  return QUANTITIES[view.quantity === "picture" ? "error" : view.quantity];
}

function inspectedName() {
  return inspected().name;
}

/** The numbers of a pixel: radiance, and what is inspected; the reference has none of it. */
function numbersOf(picture, index, i) {
  const rgb = [0, 1, 2].map((k) => value(picture.rgb, k, i));
  return index ? [...rgb, inspected().of(picture, pictures[0], i)] : rgb;
}

async function start() {
  setSize(DATA.size);
  const all = await unpackAll();
  $("state").hidden = true;
  showViewer(all, {});
}

start().catch((error) => {
  $("state").textContent = `The pictures cannot be shown: ${error.message}`;
  console.error(error);
});
