// Functions that run inside the live page and give back what is seen. They stand in the body of a function: each call has its own.

const seen = { problems: [] };
const byId = (id) => document.getElementById(id);
const check = (name, holds, detail) => { if (!holds) seen.problems.push(`${name}: ${JSON.stringify(detail)}`); };
const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));

/** Wait until something is so. */
async function until(name, isSo) {
  for (const start = Date.now(); !isSo();) {
    if (Date.now() - start > 60000) throw new Error(`waited in vain until ${name}`);
    await new Promise((done) => setTimeout(done, 20));
  }
  await frame();
}

async function put(id, v, event = "change") {
  byId(id).value = v;
  byId(id).dispatchEvent(new Event(event, { bubbles: true }));
  await frame();
}

/** A table of names and values. */
const tableOf = (id) => Object.fromEntries([...byId(id).rows].map((row) => [row.cells[0].textContent, row.cells[1].textContent]));
const downloads = () => performance.getEntriesByType("resource").map((r) => r.name).filter((name) => name.includes("/layers/"));
const labels = () => [...byId("a").options].map((o) => o.text);
/** The number of a layer in the list. */
const layer = (name) => String(labels().findIndex((label) => label.endsWith(name)));
/** The row of the pixel table that belongs to a layer. */
const row = (name) => [...document.querySelectorAll("#inspector tbody tr")[layer(name)].querySelectorAll("td")].map((c) => c.textContent);

/** What is drawn at the pixel of the table, off its frame. */
function colour() {
  const canvas = document.querySelector("#panes canvas");
  const copy = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, -Math.floor(canvas.width / 2), -Math.floor(canvas.height / 2));
  return [...copy.getImageData(0, 0, 1, 1).data].slice(0, 3);
}
const encode = (v) => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * Math.min(v, 1) ** (1 / 2.4) - 0.055);
const isNear = (a, b) => a.every((v, k) => Math.abs(v - b[k]) < 2.5);

/** Have one pixel large in the middle of the pane. */
async function zoomIn() {
  for (let k = 0; k < 12; k++) byId("zoom-in").click();
  const [x, y] = byId("pixel").textContent.split(", ").map(Number);
  moveTo(x + 0.5, y + 0.5);
  await frame();
}

/** While the run goes on. */
async function checkRun() {
  await until("there is a picture", () => !byId("controls").hidden && downloads().length);
  Object.assign(seen, { title: byId("title").textContent, labels: labels(), numbers: Object.keys(tableOf("numbers")) });
  const named = (e) => [...(e.labels || [])].some((l) => l.textContent.replace(e.textContent, "").trim())
    || e.getAttribute("aria-label") || (e.matches("button") && e.textContent.trim());
  seen.unlabelled = [...document.querySelectorAll("input, select, button, progress")].filter((e) => !named(e)).map((e) => e.id);
  seen.overflow = document.documentElement.scrollWidth - window.innerWidth;
  check("it says what the run does", byId("state").textContent === "Rendering", byId("state").textContent);
  check("a line says how far it is", /^passes made \d+ of 100000000; elapsed [\d.]+ s; remaining .*; picture after \d+ pass/.test(byId("line").textContent), byId("line").textContent);
  const passes = () => parseInt(tableOf("facts")["passes made"]), first = passes();
  await until("passes are counted", () => passes() > first);
  const before = downloads().length;
  await until("a newer picture is downloaded", () => downloads().length > before);
  seen.downloads = downloads();
  await zoomIn();
  check("the picture has its colours", isNear(colour(), row("Picture").slice(0, 3).map((v) => encode(Number(v)))), [colour(), row("Picture")]);
  await put("exposure", "-1", "input");
  check("a stop less", isNear(colour(), row("Picture").slice(0, 3).map((v) => encode(Number(v) / 2))), [colour(), row("Picture")]);
  await put("exposure", "0", "input");
  await put("a", layer("Normal"));
  await until("the normals are downloaded", () => row("Normal")[0] !== "");
  check("normals are directions", isNear(colour(), row("Normal").slice(0, 3).map((v) => 127.5 + 127.5 * Number(v))), [colour(), row("Normal")]);
  await put("a", layer("Standard error"));
  await until("the error is downloaded", () => row("Standard error")[0] !== "");
  const errors = row("Standard error").map(Number), mean = Math.sqrt((errors[0] ** 2 + errors[1] ** 2 + errors[2] ** 2) / 3);
  check("the error of the channels makes the error of the pixel", Math.abs(errors[3] / mean - 1) < 0.02, errors);
  check("the control is named after the scale", byId("exposure-name").textContent === "Scale", "");
  document.querySelector("input[value=split]").click();
  await put("b", layer("Picture"));
  check("beside a picture it is the exposure", byId("exposure-value").textContent === "0.0 stops", byId("exposure-value").textContent);
  document.querySelector("input[value=one]").click();
  await put("a", layer("Depth"));
  await until("the depth is downloaded", () => row("Depth")[3] !== "");
  check("depth has a legend", !byId("legend").hidden && row("Depth")[0] === "", row("Depth"));
  await put("a", layer("Picture"));
  return seen;
}

/** When the run has been stopped. */
async function checkEnd() {
  await until("the page knows", () => byId("state").textContent.startsWith("The run has ended: stopped by SIGTERM"));
  await until("all layers are there", () => pictures.every((p) => p.version === p.latest));
  const rows = Object.fromEntries(["Picture", "Direct", "Albedo"].map((name) => [name, row(name)]));
  check("the picture stays", isNear(colour(), rows.Picture.slice(0, 3).map((v) => encode(Number(v)))), [colour(), rows.Picture]);
  return Object.assign(seen, { rows, facts: tableOf("facts"), at: byId("pixel").textContent.split(", ").map(Number) });
}
