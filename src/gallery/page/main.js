// Pointers, keys and buttons.

function startViewer() {
  const viewer = byId("viewer"), stage = byId("stage"), pointers = new Map();
  byId("modes").replaceChildren(...MODES.map((mode, i) => {
    const button = document.createElement("button"), key = document.createElement("kbd");
    button.dataset.mode = mode;
    key.textContent = i + 1;
    button.append(`${mode} `, key);
    button.addEventListener("click", () => setMode(mode));
    return button;
  }));
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  byId("fit").addEventListener("click", fit);
  byId("close").addEventListener("click", () => viewer.close());
  byId("help-toggle").addEventListener("click", () => (byId("help").hidden = !byId("help").hidden));
  for (const id of ["overlay", "align", "swipe"]) byId(id).addEventListener("input", draw);
  byId("rise").addEventListener("input", () => {
    surface.rise = Number(byId("rise").value);
    byId("rise-value").value = surface.rise;
    surface.draw();
  });
  viewer.addEventListener("close", () => {
    history.replaceState(null, "", location.pathname + location.search);
    cards[view.index]?.focus();
  });
  new ResizeObserver(draw).observe(stage);
  setInterval(() => {
    view.second = !view.second;
    if (viewer.open && view.mode === "flicker") draw();
  }, FLICKER_MS);

  const place = (event) => {
    const box = stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  stage.addEventListener("pointerdown", (event) => {
    const what = event.target.id === "divider" ? "divider" : "picture";
    pointers.set(event.pointerId, { at: place(event), what });
    stage.setPointerCapture(event.pointerId);
    if (what === "picture" && view.mode !== "surface") probeAt(...place(event));
  });
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (event) => pointers.delete(event.pointerId));
  stage.addEventListener("pointermove", (event) => {
    const now = place(event), held = pointers.get(event.pointerId);
    if (!held) {
      if (view.mode !== "surface" && event.pointerType === "mouse") probeAt(...now);
      return;
    }
    const [dx, dy] = [now[0] - held.at[0], now[1] - held.at[1]];
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (held.what === "divider") {
      byId("swipe").value = now[0] / stage.clientWidth;
      draw();
    } else if (other) {
      const apart = (p) => Math.hypot(p[0] - other.at[0], p[1] - other.at[1]);
      zoom(apart(now) / Math.max(1, apart(held.at)), ...other.at);
    } else if (view.mode === "surface") {
      const still = stage.clientHeight;
      event.shiftKey || event.buttons === 2 ? surface.move(dx / still, dy / still) : surface.turn((4 * dx) / still, (4 * dy) / still);
    } else {
      view.x -= dx / view.scale;
      view.y -= dy / view.scale;
      draw();
    }
    held.at = now;
  });
  stage.addEventListener("contextmenu", (event) => event.preventDefault());
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0015), ...place(event));
  }, { passive: false });

  document.addEventListener("keydown", (event) => {
    if (!viewer.open || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches("input[type=range]") && event.key.startsWith("Arrow")) return;
    const solid = view.mode === "surface", [width, height] = stageSize();
    const slide = (id, by) => {
      byId(id).value = Number(byId(id).value) + by;
      draw();
    };
    const arrows = {
      ArrowLeft: () => (solid ? surface.turn(-0.1, 0) : step(-1)), ArrowRight: () => (solid ? surface.turn(0.1, 0) : step(1)),
      ArrowUp: () => solid && surface.turn(0, -0.1), ArrowDown: () => solid && surface.turn(0, 0.1),
    };
    const keys = {
      ...arrows, n: () => step(1), p: () => step(-1), f: fit, v: () => byId("overlay").click(),
      "+": () => zoom(1.25, width / 2, height / 2), "=": () => zoom(1.25, width / 2, height / 2),
      "-": () => zoom(0.8, width / 2, height / 2),
      "[": () => slide("align", -1), "]": () => slide("align", 1), ",": () => slide("swipe", -0.02), ".": () => slide("swipe", 0.02),
      "?": () => byId("help-toggle").click(),
    };
    const action = MODES[Number(event.key) - 1] ? () => setMode(MODES[Number(event.key) - 1]) : keys[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}

startGrid();
startViewer();
const asked = samples.findIndex((s) => "#" + s.id === decodeURI(location.hash));
if (asked >= 0) openSample(asked);
