// Runs inside a page: uses every control as a person would, by events, and gives back what is seen.

const seen = { problems: [] };
const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
/** Once the page has drawn its pictures. */
const drawn = () => new Promise((done) => {
  const root = document.documentElement;
  if (root.dataset.drawn) done();
  else new MutationObserver(done).observe(root, { attributes: true });
});
const byId = (id) => document.getElementById(id);
const canvases = () => [...document.querySelectorAll("#panes canvas")];
const check = (name, holds, detail) => { if (!holds) seen.problems.push(`${name}: ${JSON.stringify(detail)}`); };

function pointer(canvas, type, [x, y], more = {}) {
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new PointerEvent(type, { bubbles: true, cancelable: true, pointerId: 1, button: 0, clientX: box.left + x, clientY: box.top + y, ...more }));
}
function wheel(canvas, [x, y], deltaY) {
  const box = canvas.getBoundingClientRect();
  return canvas.dispatchEvent(new WheelEvent("wheel", { bubbles: true, cancelable: true, deltaY, clientX: box.left + x, clientY: box.top + y }));
}
async function press(key, more = {}) {
  const target = more.on || document.body;
  target.dispatchEvent(new KeyboardEvent("keydown", { bubbles: true, cancelable: true, key, code: /^\d$/.test(key) ? `Digit${key}` : "", ...more }));
  await frame();
}
async function put(id, v, event = "change") {
  byId(id).value = v;
  byId(id).dispatchEvent(new Event(event, { bubbles: true }));
  await frame();
}
async function click(element) { element.click(); await frame(); }
const middle = (canvas) => [canvas.clientWidth / 2, canvas.clientHeight / 2];
/** The pixel under a point of a pane, as the page says. */
async function pixelAt(canvas, point) {
  pointer(canvas, "pointermove", point);
  await frame();
  return byId("pixel").textContent.split(", ").map(Number);
}
/** Pixels of a canvas, read from a copy: the browser would warn of reading the original. */
function pixelsOf(canvas, x, y, width) {
  const copy = new OffscreenCanvas(width, 1).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, -x, -y);
  return [...copy.getImageData(0, 0, width, 1).data];
}
/** What is drawn at a point of a pane. */
function colourAt(canvas, [x, y]) {
  const r = canvas.width / canvas.clientWidth;
  return pixelsOf(canvas, Math.floor(x * r), Math.floor(y * r), 1).slice(0, 3);
}
/** The numbers that the table shows of picture k. */
const numbers = (k) => [...document.querySelectorAll("#inspector tbody tr")[k].querySelectorAll("td")].map((c) => c.textContent);
const encode = (v) => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * Math.min(v, 1) ** (1 / 2.4) - 0.055);
/** Whether a colour is that of these numbers: they are shown with three digits. */
const isColourOf = (colour, rgb, stops = 0) => colour.every((c, k) => Math.abs(c - encode(Number(rgb[k]) * 2 ** stops)) < 2.5);
const near = (a, b, by) => a.length === b.length && a.every((v, k) => Math.abs(v - b[k]) <= by);
/** Zoom in so that pixels are large, and let the pointer rest near the middle: the frame round a pixel is not in the way. */
async function zoomIn(canvas) {
  while (scaleOf() < 30) await click(byId("zoom-in"));
  return middle(canvas);
}
const scaleOf = () => { const c = canvases()[0]; return Number(byId("zoom").textContent.replace("x", "")) * Math.min(c.clientWidth / seen.size[0], c.clientHeight / seen.size[1]); };

async function checkStart() {
  seen.state = byId("state").hidden;
  seen.pictures = [...byId("a").options].map((o) => o.text);
  seen.quantities = [...byId("quantity").options].map((o) => o.value);
  seen.size = DATA.size;
  const named = (e) => [...(e.labels || [])].some((l) => l.textContent.replace(e.textContent, "").trim())
    || e.getAttribute("aria-label") || (e.matches("button") && e.textContent.trim());
  seen.unlabelled = [...document.querySelectorAll("input, select, button")].filter((e) => !named(e)).map((e) => e.id);
  seen.overflow = document.documentElement.scrollWidth - window.innerWidth;
  seen.inspected = [];
  for (const at of [[3, 5], [17, 11]]) {
    // To the pixel by keys alone.
    const canvas = canvases()[0];
    for (let guard = 0; guard < 200; guard++) {
      const now = byId("pixel").textContent.split(", ").map(Number);
      const key = now[0] < at[0] ? "ArrowRight" : now[0] > at[0] ? "ArrowLeft" : now[1] < at[1] ? "ArrowDown" : now[1] > at[1] ? "ArrowUp" : null;
      if (!key) break;
      await press(key, { shiftKey: true, on: canvas });
    }
    seen.inspected.push({ at, shown: byId("pixel").textContent, rows: seen.pictures.map((_, k) => numbers(k)) });
  }
}

async function checkZoomAndPan() {
  const canvas = canvases()[0];
  const point = [canvas.clientWidth * 0.315, canvas.clientHeight * 0.59]; // no border of pixels
  const before = await pixelAt(canvas, point);
  const zoom = byId("zoom").textContent;
  check("the wheel is not left to the page", !wheel(canvas, point, -300), "");
  await frame();
  check("the wheel zooms", parseFloat(byId("zoom").textContent) > parseFloat(zoom), byId("zoom").textContent);
  check("the wheel keeps what is under the pointer", near(await pixelAt(canvas, point), before, 0), before);
  const scale = scaleOf();
  pointer(canvas, "pointerdown", point);
  pointer(canvas, "pointermove", [point[0] + 3 * scale, point[1] - 2 * scale]);
  pointer(canvas, "pointerup", [point[0] + 3 * scale, point[1] - 2 * scale]);
  await frame();
  check("dragging pans", near(await pixelAt(canvas, point), [before[0] - 3, before[1] + 2], 1), [before, byId("pixel").textContent]);
  check("and the grabbed pixel follows", near(await pixelAt(canvas, [point[0] + 3 * scale, point[1] - 2 * scale]), before, 1), byId("pixel").textContent);
  await click(byId("fit"));
  check("fit", byId("zoom").textContent === "1x", byId("zoom").textContent);
  for (const [act, name] of [[() => click(byId("zoom-in")), "button +"], [() => press("+"), "key +"]]) {
    const was = parseFloat(byId("zoom").textContent);
    await act();
    check(name, parseFloat(byId("zoom").textContent) > was, was);
  }
  for (const [act, name] of [[() => click(byId("zoom-out")), "button -"], [() => press("-"), "key -"]]) {
    const was = parseFloat(byId("zoom").textContent);
    await act();
    check(name, parseFloat(byId("zoom").textContent) < was, was);
  }
  await press("+");
  const home = await pixelAt(canvas, point);
  await press("ArrowRight", { on: canvas });
  await press("ArrowDown", { on: canvas });
  const moved = await pixelAt(canvas, point);
  check("arrows pan", moved[0] > home[0] && moved[1] > home[1], [home, moved]);
  await press("ArrowRight");
  check("away from the pictures they do not", near(await pixelAt(canvas, point), moved, 0), moved);
  await press("0");
  check("key 0 fits", byId("zoom").textContent === "1x", byId("zoom").textContent);
}

async function checkSplitAndFlip() {
  const canvas = canvases()[0];
  await zoomIn(canvas);
  // Beside the pointer's pixel, on either side of the divider.
  const [left, right] = [[canvas.clientWidth * 0.2, canvas.clientHeight * 0.5], [canvas.clientWidth * 0.8, canvas.clientHeight * 0.5]];
  const shows = async (point, name) => {
    await pixelAt(canvas, point);
    const rows = seen.pictures.map((_, k) => numbers(k).slice(0, 3));
    // Off the frame's line: the middle of a pixel larger than the frame's border.
    const colour = colourAt(canvas, centre(canvas, point));
    const fits = rows.map((r, k) => isColourOf(colour, r) ? k : -1).filter((k) => k >= 0);
    return { name, colour, rows, fits };
  };
  const expect = async (name, point, k) => {
    const found = await shows(point, name);
    check(name, found.fits.includes(k), found);
  };
  await put("a", "1");
  await put("b", "2");
  await expect("the left is what is chosen", left, 1);
  await expect("the right is what is chosen", right, 2);
  await put("divider", "0.1", "input");
  await expect("the divider by its control", left, 2);
  pointer(canvas, "pointerdown", [canvas.clientWidth * 0.1 + 2, 40]);
  pointer(canvas, "pointermove", [canvas.clientWidth * 0.9, 40]);
  pointer(canvas, "pointerup", [canvas.clientWidth * 0.9, 40]);
  await frame();
  check("the divider by dragging", near([Number(byId("divider").value)], [0.9], 0.02), byId("divider").value);
  await expect("the divider by dragging", right, 1);
  await press("1");
  check("digit flips the left", byId("a").value === "0", byId("a").value);
  await expect("digit flips the left", left, 0);
  await press("3");
  await expect("and back", left, 2);
  await press("2", { shiftKey: true, key: "\"" });
  check("shift and digit flip the right", byId("b").value === "1", byId("b").value);
  await press(" ", { on: canvas });
  check("blank swaps", byId("a").value === "1" && byId("b").value === "2", [byId("a").value, byId("b").value]);
  await put("divider", "0.5", "input");
  await click(byId("fit"));
}

/** The middle of the pixel under a point: nothing but its colour is drawn there. */
function centre(canvas, [x, y]) {
  const s = scaleOf(), at = byId("pixel").textContent.split(", ").map(Number);
  const [px, py] = [view.x + (x - canvas.clientWidth / 2) / s, view.y + (y - canvas.clientHeight / 2) / s];
  return [x + (at[0] + 0.5 - px) * s, y + (at[1] + 0.5 - py) * s];
}

async function checkLayouts() {
  const radio = (v) => document.querySelector(`input[name=layout][value=${v}]`);
  await click(radio("one"));
  check("one pane", canvases().length === 1 && byId("b").closest("label").hidden, canvases().length);
  await press("l");
  check("key l goes on to split", radio("split").checked, "");
  await press("l");
  check("and to all", radio("all").checked && canvases().length === seen.pictures.length, canvases().length);
  const [first, second, third] = canvases();
  const point = [second.clientWidth * 0.4, second.clientHeight * 0.3];
  wheel(second, point, -900);
  await frame();
  const at = await pixelAt(second, point);
  for (const pane of [first, third]) check("panes are linked", near(await pixelAt(pane, point), at, 0), byId("pixel").textContent);
  await zoomIn(first);
  for (const [k, pane] of canvases().entries()) {
    await pixelAt(pane, middle(pane));
    const colour = colourAt(pane, centre(pane, middle(pane)));
    check(`pane ${k} shows its picture`, isColourOf(colour, numbers(k)), [colour, numbers(k)]);
  }
  await click(byId("fit"));
  await click(radio("split"));
}

async function checkExposure() {
  const canvas = canvases()[0];
  await press("1");
  await zoomIn(canvas);
  const point = [canvas.clientWidth * 0.2, canvas.clientHeight * 0.5];
  await pixelAt(canvas, point);
  const at = (stops) => isColourOf(colourAt(canvas, centre(canvas, point)), numbers(0), stops);
  for (const stops of [1.5, -2]) {
    await put("exposure", String(stops), "input");
    check(`${stops} stops`, at(stops), [colourAt(canvas, centre(canvas, point)), numbers(0)]);
  }
  await press("e");
  check("key e", Number(byId("exposure").value) === -1.5 && at(-1.5), byId("exposure").value);
  await press("E", { shiftKey: true });
  check("key E", Number(byId("exposure").value) === -2, byId("exposure").value);
  await put("exposure", "0", "input");
  await click(byId("fit"));
}

async function checkFalseColour() {
  const canvas = canvases()[0];
  seen.maps = {};
  await press("2");
  await zoomIn(canvas);
  const point = [canvas.clientWidth * 0.2, canvas.clientHeight * 0.5];
  for (const q of seen.quantities.filter((v) => v !== "picture")) {
    await put("quantity", q);
    await pixelAt(canvas, point);
    const ticks = [...byId("legend-ticks").children].map((t) => Number(t.textContent));
    const bar = pixelsOf(byId("legend-bar"), 0, 0, 256);
    const v = Number(numbers(1)[3]);
    const i = Math.round(255 * Math.min(Math.max((v - ticks[0]) / (ticks[2] - ticks[0]), 0), 1));
    const colour = colourAt(canvas, centre(canvas, point));
    // Three digits may fall on a neighbouring step of the scale.
    const fits = [-2, -1, 0, 1, 2].some((d) => near(colour, [...bar.slice(4 * (i + d), 4 * (i + d) + 3)], 1));
    check(`${q}: the colour is the legend's at the number shown`, fits, [colour, v, ticks]);
    check(`${q}: the legend is shown and named`, !byId("legend").hidden && byId("legend-name").textContent.length > 5, "");
    seen.maps[q] = { ticks, rows: seen.pictures.map((_, k) => numbers(k)), at: byId("pixel").textContent };
    await put("exposure", "1", "input");
    check(`${q}: a stop halves the scale`, Math.abs(Number(byId("legend-ticks").children[2].textContent) / ticks[2] - 0.5) < 0.01, ticks);
  }
  await put("quantity", "picture");
  check("the picture has no legend", byId("legend").hidden && byId("exposure").value === "0", "");
  await click(byId("fit"));
}

(async () => {
  try {
    await drawn();
    for (const part of [checkStart, checkZoomAndPan, checkSplitAndFlip, checkLayouts, checkExposure, checkFalseColour]) await part();
    for (const details of document.querySelectorAll("details")) { details.querySelector("summary").click(); check("details open", details.open, ""); }
    seen.finished = true;
  } catch (error) {
    seen.problems.push(String(error.stack));
  }
  seen.resources = performance.getEntriesByType("resource").map((r) => r.name);
  return seen;
})();
