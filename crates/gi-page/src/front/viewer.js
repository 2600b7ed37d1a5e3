// What is seen: panes that show one region of the picture, each its own pictures.

const $ = (id) => document.getElementById(id);

/** All that the controls change. `zoom` is relative to the whole picture in a pane; `x`, `y` is what stands in its middle. */
const view = {
  layout: "split", quantity: "picture", a: 1, b: 0, divider: 0.5, stops: 0,
  zoom: 1, x: 0, y: 0, pixel: [0, 0],
};
const MAX_ZOOM = 256;
let pictures = [];
let panes = [];
let painted = new Map();

/** A picture in colours, painted when it is first seen. */
function paint(index) {
  const key = `${index} ${pictures[index].version ?? 0} ${view.quantity} ${view.stops}`;
  if (!painted.has(key)) {
    // Other exposures are not kept: there are too many.
    if (painted.size > 2 * pictures.length) painted.clear();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [WIDTH, HEIGHT];
    canvas.getContext("2d").putImageData(colours(pictures[index], view.stops), 0, 0);
    painted.set(key, canvas);
  }
  return painted.get(key);
}

/** Which pictures the panes show: one pane of one or two pictures, or one for each. */
function shownByPane() {
  return view.layout === "all" ? pictures.map((_, i) => [i]) : [view.layout === "one" ? [view.a] : [view.a, view.b]];
}

/** The scale of the first picture that is shown in false colours. */
function shownScale() {
  return shownByPane().flat().map((k) => scaleFor(pictures[k])).find((scale) => scale);
}

/** Panes for the layout. */
function arrange() {
  const shown = shownByPane();
  $("panes").className = view.layout;
  if (panes.length !== shown.length) {
    panes = shown.map(() => {
      const figure = document.createElement("figure");
      figure.innerHTML = "<figcaption><span></span><span></span></figcaption><canvas tabindex=\"0\" role=\"img\"></canvas>";
      const pane = { canvas: figure.querySelector("canvas"), captions: figure.querySelectorAll("span"), figure };
      watchPointer(pane);
      return pane;
    });
    $("panes").replaceChildren(...panes.map((p) => p.figure));
  }
  panes.forEach((pane, i) => {
    pane.shows = shown[i];
    pane.captions.forEach((c, k) => { c.textContent = k in shown[i] ? pictures[shown[i][k]].label : ""; });
    pane.canvas.setAttribute("aria-label", `${shown[i].map((k) => pictures[k].label).join(" and ")}; arrow keys pan`);
    pane.canvas.style.aspectRatio = view.layout === "all" ? `${WIDTH} / ${HEIGHT}` : "";
  });
  draw();
}

/** Screen pixels a picture pixel, in a pane of this size. */
function scaleIn(width, height) {
  return view.zoom * Math.min(width / WIDTH, height / HEIGHT);
}

/** Where a point of a pane lies in the picture. */
function toPicture(pane, [px, py]) {
  const { clientWidth: w, clientHeight: h } = pane.canvas;
  const s = scaleIn(w, h);
  return [view.x + (px - w / 2) / s, view.y + (py - h / 2) / s];
}

function drawPane(pane) {
  const { canvas } = pane;
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [canvas.clientWidth, canvas.clientHeight].map((n) => Math.max(1, Math.round(n * ratio)));
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, w, h);
  const s = scaleIn(w, h);
  context.imageSmoothingEnabled = s < 1;
  const place = [w / 2 - view.x * s, h / 2 - view.y * s, WIDTH * s, HEIGHT * s];
  const edge = pane.shows.length > 1 ? Math.round(view.divider * w) : w;
  const part = (index, from, to) => {
    if (!pictures[index].rgb) return;
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, h);
    context.clip();
    context.drawImage(paint(index), ...place);
    context.restore();
  };
  part(pane.shows[0], 0, edge);
  if (pane.shows.length > 1) {
    part(pane.shows[1], edge, w);
    context.fillStyle = "#000";
    context.fillRect(edge - 1.5 * ratio, 0, 3 * ratio, h);
    context.fillStyle = "#fff";
    context.fillRect(edge - 0.5 * ratio, 0, ratio, h);
  }
  drawPixel(context, place, s, ratio);
}

/** A frame round the pixel whose numbers are shown. */
function drawPixel(context, [x0, y0], s, ratio) {
  const size = Math.max(s, 6 * ratio);
  const [x, y] = [x0 + (view.pixel[0] + 0.5) * s - size / 2, y0 + (view.pixel[1] + 0.5) * s - size / 2];
  for (const [colour, width] of [["#000", 3], ["#fff", 1]]) {
    context.strokeStyle = colour;
    context.lineWidth = width * ratio;
    context.strokeRect(x, y, size, size);
  }
}

let drawing = 0;
/** Draw at the next frame, however often it is asked for. */
function draw() {
  drawing ||= requestAnimationFrame(() => {
    drawing = 0;
    panes.forEach(drawPane);
    legend();
    inspect();
    $("zoom").textContent = `${digits(view.zoom)}x`;
    nameExposure();
    document.documentElement.dataset.drawn = String(Number(document.documentElement.dataset.drawn || 0) + 1);
  });
}

/** What the exposure's control changes: where the scale ends if there are only false colours, else the brightness. */
function nameExposure() {
  const sign = view.stops > 0 ? "+" : "";
  const isScale = shownByPane().flat().every((k) => scaleFor(pictures[k]));
  $("exposure-name").textContent = isScale ? "Scale" : "Exposure";
  $("exposure-value").textContent = isScale ? `to ${digits(shownScale().end)}` : `${sign}${view.stops.toFixed(1)} stops`;
}

/** The colour scale with its ends, in its unit. */
function legend() {
  const scale = shownScale();
  $("legend").hidden = !scale;
  if (!scale) return;
  const { name, unit, map, end } = scale;
  $("legend-name").textContent = `${name} (${unit})`;
  const bar = new ImageData(256, 1);
  MAPS[map].forEach((c, i) => bar.data.set([...c, 255], 4 * i));
  $("legend-bar").getContext("2d").putImageData(bar, 0, 0);
  const ends = map === "signed" ? [-end, 0, end] : [0, end / 2, end];
  [...$("legend-ticks").children].forEach((tick, k) => { tick.textContent = digits(ends[k]); });
}

/** The numbers of all pictures at the pixel. */
function inspect() {
  const [x, y] = view.pixel;
  const i = y * WIDTH + x;
  $("pixel").textContent = `${x}, ${y}`;
  $("inspected").textContent = inspectedName();
  const rows = document.querySelectorAll("#inspector tbody tr");
  pictures.forEach((p, index) => {
    const numbers = numbersOf(p, index, i);
    rows[index].hidden = !numbers;
    [...rows[index].querySelectorAll("td")].forEach((cell, k) => { cell.textContent = numbers && k in numbers ? digits(numbers[k]) : ""; });
  });
}

function clamp(v, low, high) {
  return Math.min(Math.max(v, low), high);
}

/** Zoom by a factor; `at` of a pane stays where it is. */
function zoomBy(factor, pane = panes[0], at = [pane.canvas.clientWidth / 2, pane.canvas.clientHeight / 2]) {
  const [x, y] = toPicture(pane, at);
  const zoom = clamp(view.zoom * factor, 0.25, MAX_ZOOM);
  const kept = view.zoom / zoom;
  view.zoom = zoom;
  moveTo(x + (view.x - x) * kept, y + (view.y - y) * kept);
}

/** Have a point of the picture in the middle. */
function moveTo(x, y) {
  [view.x, view.y] = [clamp(x, 0, WIDTH), clamp(y, 0, HEIGHT)];
  draw();
}

function fit() {
  view.zoom = 1;
  moveTo(WIDTH / 2, HEIGHT / 2);
}

function choosePixel(x, y) {
  view.pixel = [clamp(Math.floor(x), 0, WIDTH - 1), clamp(Math.floor(y), 0, HEIGHT - 1)];
  draw();
}
