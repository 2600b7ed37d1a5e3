// What the user does: pointer, wheel, keys, and the controls above the picture.

/** Pan by dragging, or move the divider where it is grabbed; zoom by the wheel; the pixel follows the pointer. */
function watchPointer(pane) {
  const { canvas } = pane;
  let dragged = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const byDivider = ([x]) => pane.shows.length > 1 && Math.abs(x - view.divider * canvas.clientWidth) < 8;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    dragged = { from: at(event), divider: byDivider(at(event)) };
    // A finger does not hover.
    if (!dragged.divider) choosePixel(...toPicture(pane, dragged.from));
    try { canvas.setPointerCapture(event.pointerId); } catch { /* the pointer is gone already */ }
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = at(event);
    canvas.style.cursor = dragged?.divider || byDivider(here) ? "col-resize" : "";
    if (dragged?.divider) {
      set({ divider: clamp(here[0] / canvas.clientWidth, 0, 1) });
    } else if (dragged) {
      const s = scaleIn(canvas.clientWidth, canvas.clientHeight);
      moveTo(view.x - (here[0] - dragged.from[0]) / s, view.y - (here[1] - dragged.from[1]) / s);
      dragged.from = here;
    } else {
      choosePixel(...toPicture(pane, here));
    }
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { dragged = null; });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    // A line is about 16 pixels, a page about 400.
    const pixels = event.deltaY * [1, 16, 400][event.deltaMode];
    zoomBy(2 ** (-pixels / 200), pane, at(event));
  }, { passive: false });
}

/** Change what is seen, and the controls with it. */
function set(change) {
  Object.assign(view, change);
  const values = { quantity: view.quantity, a: view.a, b: view.b, divider: view.divider, exposure: view.stops };
  for (const [id, v] of Object.entries(values)) $(id).value = String(v);
  $("controls").elements.layout.value = view.layout;
  for (const label of document.querySelectorAll("#controls .a")) label.hidden = view.layout === "all";
  for (const label of document.querySelectorAll("#controls .b")) label.hidden = view.layout !== "split";
  document.querySelector("#controls .a").firstChild.textContent = view.layout === "one" ? "Picture " : "Left ";
  arrange();
}

const LAYOUTS = ["one", "split", "all"];

/** A key without modifiers but Shift; returns whether it meant something. */
function key(event) {
  const digit = /^Digit([1-9])$/.exec(event.code)?.[1] - 1;
  const step = 0.1 / view.zoom;
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  const keys = {
    " ": () => set({ a: view.b, b: view.a }),
    l: () => set({ layout: LAYOUTS[(LAYOUTS.indexOf(view.layout) + 1) % 3] }),
    e: () => set({ stops: clamp(view.stops + 0.5, -10, 10) }),
    E: () => set({ stops: clamp(view.stops - 0.5, -10, 10) }),
    "+": () => zoomBy(Math.SQRT2),
    "=": () => zoomBy(Math.SQRT2),
    "-": () => zoomBy(Math.SQRT1_2),
    0: fit,
  };
  if (digit < pictures.length) set(event.shiftKey ? { b: digit } : { a: digit });
  else if (arrow && event.shiftKey) choosePixel(view.pixel[0] + arrow[0], view.pixel[1] + arrow[1]);
  else if (arrow) moveTo(view.x + arrow[0] * step * WIDTH, view.y + arrow[1] * step * HEIGHT);
  else if (keys[event.key]) keys[event.key]();
  else return false;
  return true;
}

function watchKeys() {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const on = event.target;
    // Controls keep the keys that they have a use for themselves.
    const theirs = /^(Arrow|Home|End|Page| $|Enter)/.test(event.key);
    if (on.matches?.("select") || (theirs && on.matches?.("input, button, summary"))) return;
    // Away from the pictures arrows and blank scroll the page.
    if (theirs && !on.matches?.("canvas")) return;
    if (key(event)) event.preventDefault();
  });
}

function watchControls() {
  const on = (id, event, act) => $(id).addEventListener(event, act);
  on("layouts", "change", (e) => set({ layout: e.target.value }));
  on("quantity", "change", (e) => set({ quantity: e.target.value, stops: 0 }));
  on("a", "change", (e) => set({ a: Number(e.target.value) }));
  on("b", "change", (e) => set({ b: Number(e.target.value) }));
  on("divider", "input", (e) => set({ divider: Number(e.target.value) }));
  on("exposure", "input", (e) => set({ stops: Number(e.target.value) }));
  on("zoom-in", "click", () => zoomBy(Math.SQRT2));
  on("zoom-out", "click", () => zoomBy(Math.SQRT1_2));
  on("fit", "click", fit);
  on("controls", "submit", (e) => e.preventDefault());
  new ResizeObserver(draw).observe($("panes"));
}

function fillControls() {
  const options = (id, entries) => $(id).replaceChildren(...entries.map(([v, text]) => new Option(text, v)));
  const named = pictures.map((p, i) => [i, `${i + 1}  ${p.label}`]);
  options("quantity", quantities().map((q) => [q, QUANTITIES[q].name]));
  $("quantity").parentElement.hidden = quantities().length < 2;
  options("a", named);
  options("b", named);
  const row = (p, i) => {
    const tr = document.createElement("tr");
    tr.innerHTML = "<th scope=\"row\"></th><td></td><td></td><td></td><td></td>";
    tr.firstChild.textContent = `${i + 1}  ${p.label}`;
    return tr;
  };
  document.querySelector("#inspector tbody").replaceChildren(...pictures.map(row));
}

/** Show pictures in the viewer, beginning with a part of the view. */
function showViewer(all, change) {
  pictures = all;
  fillControls();
  watchControls();
  watchKeys();
  for (const id of ["controls", "inspector"]) $(id).hidden = false;
  view.pixel = [WIDTH >> 1, HEIGHT >> 1];
  set(change);
  fit();
}
