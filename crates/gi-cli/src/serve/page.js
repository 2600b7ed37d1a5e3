// The page of a run: asks about once a second how far the run is.

const POLL = 1000;
/** Time between two attempts when the run does not answer. */
const RETRY = 5000;

/** A time span in the two units that matter. */
function span(seconds) {
  const s = Math.floor(seconds), m = Math.floor(s / 60);
  if (s < 10) return `${seconds.toFixed(1)} s`;
  if (s < 60) return `${s} s`;
  return s < 3600 ? `${m} min ${s % 60} s` : `${Math.floor(m / 60)} h ${m % 60} min`;
}

/** Whole numbers in full, others in three digits. */
function numberInFull(v) {
  if (v === null) return "not finite";
  return Number.isInteger(v) && Math.abs(v) < 1e15 ? String(v) : digits(v);
}

/** What the run is doing, in words that change seldom: they are read aloud. */
function phaseOf(state) {
  return {
    reading: "Reading the scene", preparing: "Preparing", saving: "Saving",
    passes: state.picture ? "Rendering" : "Rendering. The first picture comes when a pass ends.",
    ended: `The run has ended: ${state.outcome}. This is its last picture.`,
  }[state.phase] ?? state.phase;
}

/** A step of the preparation. */
function stepOf({ name, done, total }) {
  if (!name || (!done && !total)) return name;
  return total ? `${Math.min(done, total)} of ${total} ${name}` : `${done} ${name}`;
}

/** How far the run is: names with values. What is not known is left out. */
function factsOf(state) {
  const { picture, step } = state;
  const of = state.passes ? ` of ${state.passes}` : "";
  const facts = [
    ["preparing", step && stepOf(step)],
    ["passes made", state.pass !== undefined && `${state.pass}${of}`],
    ["time limit", state.time && span(state.time)],
    ["elapsed", span(state.elapsed)],
    ["remaining", Number.isFinite(state.remaining) && span(state.remaining)],
    ["samples per second", state.samples_per_second && `${digits(state.samples_per_second / 1e6)} million`],
    ["picture after", picture && `${picture.passes} ${picture.passes === 1 ? "pass" : "passes"}`],
    ["standard error of the picture, relative to its mean", picture?.noise && digits(picture.noise)],
    ["error estimate", Number.isFinite(picture?.error) && digits(picture.error)],
  ];
  return facts.filter(([, v]) => v);
}

/** The same that matters most, in a line. */
function lineOf(facts) {
  const known = Object.fromEntries(facts);
  const line = ["preparing", "passes made", "elapsed", "remaining", "picture after"].map((name) => known[name] && `${name} ${known[name]}`);
  return line.filter(Boolean).join("; ");
}

/** Fill a table with names and values, and hide its section if there are none. */
function fillTable(id, rows) {
  const made = rows.map(([name, v]) => {
    const tr = document.createElement("tr");
    tr.innerHTML = "<th scope=\"row\"></th><td></td>";
    tr.firstChild.textContent = name;
    tr.lastChild.textContent = v;
    return tr;
  });
  $(id).replaceChildren(...made);
  $(id).closest("section").hidden = !rows.length;
}

function setText(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

/** How much of the preparation's step or of the run is done; undefined if that is unknown. */
function fractionOf({ phase, step, fraction }) {
  if (phase === "preparing" && step.total) return Math.min(step.done / step.total, 1);
  return phase === "ended" ? 1 : fraction;
}

/** Show how far the run is. */
function showState(state) {
  document.title = `${state.pass === undefined ? state.phase : `pass ${state.pass}`}: ${state.program} ${state.scene}`;
  setText("title", `${state.program} ${state.scene}`);
  setText("summary", state.size ? `${state.size[0]} x ${state.size[1]} pixels; version ${state.version}` : `version ${state.version}`);
  setText("state", phaseOf(state));
  const fraction = fractionOf(state);
  $("progress").hidden = false;
  if (fraction === undefined) $("progress").removeAttribute("value");
  else $("progress").value = fraction;
  const facts = factsOf(state);
  setText("line", lineOf(facts));
  fillTable("facts", facts);
  fillTable("numbers", (state.picture?.technique ?? []).map(([name, v]) => [name.replaceAll("_", " "), numberInFull(v)]));
}

/** Take the list of layers; the first one begins the viewer. */
function takeLayers({ size, picture }) {
  if (!picture) return;
  if (pictures.length) {
    for (const p of pictures) p.latest = picture.layers.find((layer) => layer.name === p.name)?.version ?? p.latest;
  } else {
    setSize(size);
    showViewer(picture.layers.map(pictureOf), { layout: "one", a: 0, b: Math.min(1, picture.layers.length - 1) });
  }
}

/** Download what is shown; at the end all layers, because the run answers no more. */
async function takePixels(hasEnded) {
  for (const all of hasEnded ? [false, true] : [false]) {
    for (const picture of outdated(all)) {
      await download(picture);
      draw();
    }
  }
}

let wake = () => {};
/** Wait, but not if something is to be shown that is not downloaded yet. */
function wait(time) {
  return new Promise((done) => {
    const timer = setTimeout(done, time);
    wake = () => { clearTimeout(timer); done(); };
  });
}
for (const event of ["change", "keydown"]) {
  document.addEventListener(event, () => setTimeout(() => { if (outdated().length) wake(); }));
}

/** Ask until the run has ended. */
async function watch() {
  for (let run = null; ;) {
    let state = null;
    try {
      const answer = await fetch("state.json", { signal: AbortSignal.timeout(10000) });
      if (!answer.ok) throw new Error(`status ${answer.status}`);
      state = await answer.json();
      // Another run has taken the address.
      if (run && run !== state.run) return location.reload();
      run = state.run;
      showState(state);
      takeLayers(state);
      await takePixels(state.phase === "ended");
    } catch (error) {
      if (!(error instanceof TypeError) && error.name !== "TimeoutError") console.error(error);
      if (state?.phase !== "ended") setText("state", "The run does not answer: it has ended, or cannot be reached. This is its last picture.");
    }
    if (state?.phase === "ended") return undefined;
    await wait(state ? POLL : RETRY);
  }
}

watch();
