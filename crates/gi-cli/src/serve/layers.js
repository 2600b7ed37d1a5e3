// The layers of the run as pictures of the viewer. A layer is downloaded when it is shown and its version has changed.

/** Layers that are shown in false colours, by the number of pixel i; what the table shows of a channel. Layers of one channel are shown
 * by that channel. */
const SCALES = {
  Variance: {
    name: "Standard error", unit: "radiance, root mean square of the channels",
    channel: Math.sqrt,
    of: (rgb, i) => Math.sqrt((value(rgb, 0, i) + value(rgb, 1, i) + value(rgb, 2, i)) / 3),
  },
};
const ONE_CHANNEL = { name: "Value", unit: "scene units", of: (rgb, i) => value(rgb, 0, i) };
const LABELS = { Variance: "Standard error", N: "Normal", Z: "Depth" };

const QUANTITIES = { picture: { name: "Picture" } };

function quantities() {
  return ["picture"];
}

/** A layer that is not downloaded yet. `latest` is the version that the run has. */
function pictureOf({ name, channels, version }) {
  return {
    label: LABELS[name] ?? name, rgb: null, version: 0,
    name, channels: channels.length, latest: version, directions: name === "N",
    scale: SCALES[name] ?? (channels.length === 1 ? ONE_CHANNEL : null),
  };
}

/** The colour scale of a layer that is no colour; stops shorten it. */
function scaleFor({ scale, rgb, end }) {
  if (!scale || !rgb) return null;
  return { name: scale.name, unit: scale.unit, map: "magma", end: end * 2 ** -view.stops, of: (i) => scale.of(rgb, i) };
}

/** The numbers of a pixel: the channels of a layer that has three, and the number that gives it a false colour. */
function numbersOf({ scale, rgb, channels }, _, i) {
  if (!rgb) return null;
  const numbers = [];
  if (channels === 3) for (let k = 0; k < 3; k++) numbers[k] = (scale?.channel ?? Number)(value(rgb, k, i));
  if (scale) numbers[3] = scale.of(rgb, i);
  return numbers;
}

function inspectedName() {
  return "False colour";
}

/** The number that 99 of 100 pixels do not exceed, from at most about 10000 of them; 1 if there is none above zero. */
function endOf(scale, rgb) {
  const numbers = [];
  for (let i = 0; i < PIXELS; i += Math.ceil(PIXELS / 10000)) {
    const v = scale.of(rgb, i);
    if (Number.isFinite(v)) numbers.push(v);
  }
  numbers.sort((a, b) => a - b);
  const end = numbers[Math.floor((numbers.length - 1) * 0.99)];
  return end > 0 ? end : 1;
}

/** Layers that are shown, or all, of which the run has a newer version. */
function outdated(all = false) {
  const shown = new Set(shownByPane().flat());
  return pictures.filter((p, index) => (all || shown.has(index)) && p.version < p.latest);
}

async function download(picture) {
  const answer = await fetch(`layers/${encodeURIComponent(picture.name)}`, { signal: AbortSignal.timeout(30000) });
  if (!answer.ok) throw new Error(`layer ${picture.name}: status ${answer.status}`);
  const bytes = new DataView(await answer.arrayBuffer());
  const bits = Uint16Array.from({ length: bytes.byteLength / 2 }, (_, i) => bytes.getUint16(2 * i, true));
  if (bits.length !== picture.channels * PIXELS) throw new Error(`layer ${picture.name}: ${bits.length} numbers`);
  picture.rgb = { bits, scale: Number(answer.headers.get("X-Scale")) };
  picture.version = Number(answer.headers.get("X-Version"));
  if (picture.scale) picture.end = endOf(picture.scale, picture.rgb);
}
