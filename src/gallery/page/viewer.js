// One sample at a time: the two views over each other, the labels over them, the probe, the surface.

const MODES = ["left", "right", "swipe", "flicker", "anaglyph", "disparity", "surface"];
const FLICKER_MS = 500;
const view = { index: -1, mode: "left", scale: 1, x: 0, y: 0, probe: null, second: false, loading: 0 };
const surface = new Surface(byId("solid"));
const flat = byId("flat");

function canvasOf(width, height, paint) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  paint(canvas.getContext("2d"), canvas);
  return canvas;
}

/** A picture with one colour's light alone, for the anaglyph. */
const tinted = (image, colour) =>
  canvasOf(image.naturalWidth, image.naturalHeight, (pen, canvas) => {
    pen.drawImage(image, 0, 0);
    pen.globalCompositeOperation = "multiply";
    pen.fillStyle = colour;
    pen.fillRect(0, 0, canvas.width, canvas.height);
  });

function painted(sample, colourOf) {
  return canvasOf(sample.columns, sample.rows, (pen) => {
    const picture = pen.createImageData(sample.columns, sample.rows);
    for (let i = 0; i < sample.columns * sample.rows; i++) picture.data.set(colourOf(i), 4 * i);
    pen.putImageData(picture, 0, 0);
  });
}

async function openSample(index) {
  const sample = samples[index], turn = ++view.loading, { left, right } = pack(index);
  const [leftImage, rightImage, known] = await Promise.all([picture(jpegUrl(left)), picture(jpegUrl(right)), labels(sample, index)]);
  // Who steps on quickly sees the last sample only.
  if (turn !== view.loading) return;
  const range = colourRange(known.disparity);
  const shade = (d) => (Number.isFinite(d) ? Math.min(255, Math.max(0, Math.round((255 * (d - range[0])) / (range[1] - range[0])))) : -1);
  const over = [[205, 0, 205, 200], [0, 0, 0, 0], [230, 159, 0, 170], [86, 180, 233, 120]];
  Object.assign(view, {
    index, sample, known, range, probe: null, full: null, tints: null, surfaceOf: -1,
    images: { left: leftImage, right: rightImage },
    colours: painted(sample, (i) => {
      const k = 3 * shade(known.disparity[i]);
      return k < 0 ? [0, 0, 0, 255] : [RAMP[k], RAMP[k + 1], RAMP[k + 2], 255];
    }),
    overlay: painted(sample, (i) => over[known.validity[i]]),
  });
  const align = byId("align");
  align.min = Math.floor(range[0]) - 2;
  align.max = Math.ceil(range[1]) + 2;
  align.value = median(known.disparity);
  byId("title").textContent = sample.id;
  byId("probe").textContent = "Move over the picture: the point in the other view is shown here.";
  byId("notice").hidden = true;
  if (!byId("viewer").open) byId("viewer").showModal();
  location.replace("#" + sample.id);
  ["left", "right"].forEach((side) => clearPatch(side));
  facts(sample);
  histogram();
  setMode(view.mode);
  fit();
  (view.mode === "surface" ? byId("solid") : flat).focus({ preventScroll: true });
}

const median = (values) => {
  const sorted = values.filter(Number.isFinite).sort();
  return sorted.length ? sorted[sorted.length >> 1] : 0;
};

/** Whole pictures from the files beside this page, once they are looked at closely. */
async function fetchFull() {
  const { sample, full } = view;
  if (full || !sample.left_path || sample.every === 1) return;
  view.full = "asked";
  try {
    const [left, right] = await Promise.all([sample.left_path, sample.right_path].map((path) => picture(encodeURI(path))));
    if (view.sample !== sample) return;
    Object.assign(view, { full: "there", tints: null, images: { left, right } });
    draw();
  } catch {
    if (view.sample !== sample) return;
    byId("notice").textContent = "The images beside this page are not there: reduced ones are shown.";
    byId("notice").hidden = false;
  }
}

function setMode(mode) {
  view.mode = mode;
  for (const button of byId("modes").children) button.setAttribute("aria-pressed", button.dataset.mode === mode);
  const solid = mode === "surface", both = ["swipe", "flicker", "anaglyph", "right"].includes(mode);
  flat.hidden = solid;
  byId("solid").hidden = !solid;
  byId("align-row").hidden = !both;
  byId("swipe-row").hidden = byId("divider").hidden = mode !== "swipe";
  byId("rise-row").hidden = !solid;
  byId("probe").hidden = solid;
  byId("patches").hidden = solid || !view.probe;
  if (solid && surface.gl && view.surfaceOf !== view.index) {
    surface.load(view.sample, view.known, view.images.left);
    view.surfaceOf = view.index;
  }
  if (solid && !surface.gl) {
    byId("notice").textContent = "This browser has no WebGL2, which the surface needs.";
    byId("notice").hidden = false;
  }
  draw();
}

const stageSize = () => [byId("stage").clientWidth, byId("stage").clientHeight];

function fit() {
  const [width, height] = stageSize(), { width_px, height_px } = view.sample.camera;
  Object.assign(view, { scale: Math.min(width / width_px, height / height_px), x: width_px / 2, y: height_px / 2 });
  surface.reset();
  draw();
}

/** Place in the stage of a place in the frame, whose pixel (0, 0) reaches from 0 to 1. */
function toStage(x, y) {
  const [width, height] = stageSize();
  return [(x - view.x) * view.scale + width / 2, (y - view.y) * view.scale + height / 2];
}

function toFrame(sx, sy) {
  const [width, height] = stageSize();
  return [(sx - width / 2) / view.scale + view.x, (sy - height / 2) / view.scale + view.y];
}

const moved = () => Number(byId("align").value);

function draw() {
  if (view.index < 0) return;
  if (view.mode === "surface") return surface.draw();
  const { sample, images, mode } = view, [width, height] = stageSize(), ratio = devicePixelRatio;
  [flat.width, flat.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const pen = flat.getContext("2d");
  pen.scale(ratio, ratio);
  pen.imageSmoothingEnabled = view.scale * ratio < 2 && sample.every > 1 ? true : view.scale * ratio < 1.5;
  if (view.scale * ratio * sample.every > 1.5) fetchFull();
  const put = (image, shift) => {
    // The last column of a reduced picture may stand for fewer pixels than the others.
    const whole = view.full === "there" && image.width > sample.columns;
    const [w, h] = whole ? [image.width, image.height] : [sample.columns * sample.every, sample.rows * sample.every];
    const [x, y] = toStage(shift, 0);
    pen.drawImage(image, x, y, w * view.scale, h * view.scale);
  };
  const shift = moved();
  byId("align-value").value = `${shift.toFixed(2)} px`;
  const [left, right] = [() => put(images.left, 0), () => put(images.right, shift)];
  if (mode === "left") left();
  if (mode === "right" || (mode === "flicker" && view.second)) right();
  if (mode === "flicker" && !view.second) left();
  if (mode === "disparity") put(view.colours, 0);
  if (mode === "swipe") {
    left();
    const at = Number(byId("swipe").value) * width;
    byId("divider").style.left = `${at}px`;
    pen.save();
    pen.beginPath();
    pen.rect(at, 0, width - at, height);
    pen.clip();
    pen.clearRect(0, 0, width, height);
    right();
    pen.restore();
  }
  if (mode === "anaglyph") {
    view.tints ??= [tinted(images.left, "#f00"), tinted(images.right, "#0ff")];
    put(view.tints[0], 0);
    pen.globalCompositeOperation = "lighter";
    put(view.tints[1], shift);
    pen.globalCompositeOperation = "source-over";
  }
  if (byId("overlay").checked && mode !== "right") {
    pen.imageSmoothingEnabled = false;
    put(view.overlay, 0);
  }
  if (mode === "disparity") scaleBar(pen, width, height);
  if (view.probe) mark(pen);
}

/** The colours of disparity, px. */
function scaleBar(pen, width, height) {
  const [low, high] = view.range, long = Math.min(260, width - 40), x = 20, y = height - 34;
  pen.fillStyle = "#000b";
  pen.fillRect(x - 10, y - 8, long + 20, 40);
  for (let i = 0; i < long; i++) {
    const k = 3 * Math.floor((255 * i) / (long - 1));
    pen.fillStyle = `rgb(${RAMP[k]},${RAMP[k + 1]},${RAMP[k + 2]})`;
    pen.fillRect(x + i, y, 1.5, 10);
  }
  pen.fillStyle = "#fff";
  pen.font = "12px system-ui, sans-serif";
  [[low, "left"], [(low + high) / 2, "center"], [high, "right"]].forEach(([value, side], i) => {
    pen.textAlign = side;
    pen.fillText(`${value.toFixed(1)}${i === 2 ? " px" : ""}`, x + (long * i) / 2, y + 25);
  });
}

/** The probe's crosses: green where it is, yellow where the other view has it. */
function mark(pen) {
  const { u, v, right } = view.probe, both = ["swipe", "flicker", "anaglyph"].includes(view.mode);
  const cross = (x, y, colour) => {
    const [sx, sy] = toStage(x + 0.5, y + 0.5);
    for (const [line, style] of [[3, "#000"], [1.2, colour]]) {
      pen.lineWidth = line;
      pen.strokeStyle = style;
      pen.beginPath();
      pen.moveTo(sx - 11, sy);
      pen.lineTo(sx + 11, sy);
      pen.moveTo(sx, sy - 11);
      pen.lineTo(sx, sy + 11);
      pen.stroke();
    }
  };
  if (view.mode !== "right") cross(u, v, "#4dff6a");
  if (right !== null && (both || view.mode === "right")) cross(right + moved(), v, "#ffe14d");
}

function probeAt(sx, sy) {
  const { sample, known } = view;
  let [x, y] = toFrame(sx, sy);
  if (view.mode === "right") {
    x = leftOf(x - moved() - 0.5, y - 0.5) + 0.5;
  }
  const { width_px, height_px } = sample.camera;
  if (!(x >= 0 && y >= 0 && x < width_px && y < height_px)) return;
  const [column, row] = gridPlace(sample, x - 0.5, y - 0.5), i = row * sample.columns + column;
  const [u, v] = [fullPixel(sample, column), fullPixel(sample, row)], disparity = known.disparity[i];
  const seen = VALIDITY[known.validity[i]];
  const right = Number.isFinite(disparity) ? u - disparity : null;
  view.probe = { u, v, right };
  let text = `left (${u}, ${v}): ${seen}`;
  if (right !== null) {
    const [wx, wy, wz] = worldPoint(sample, u, v, disparity);
    text = `left (${u}, ${v})\ndisparity ${disparity.toFixed(2)} px, ${seen}\nright (${right.toFixed(2)}, ${v})\n` +
      `world (${wx.toFixed(1)}, ${wy.toFixed(1)}) m, height ${wz.toFixed(2)} m`;
  }
  byId("probe").textContent = text;
  byId("probe").style.whiteSpace = "pre-line";
  byId("patches").hidden = false;
  patch("left", u, v);
  right === null ? clearPatch("right") : patch("right", right, v);
  draw();
}

/** The left column whose match stands at a column of the right view: the nearest of its row. */
function leftOf(u, v) {
  const { sample, known } = view, row = gridPlace(sample, 0, v)[1];
  let best = NaN, least = sample.every;
  for (let column = 0; column < sample.columns; column++) {
    const i = row * sample.columns + column;
    const away = Math.abs(fullPixel(sample, column) - known.disparity[i] - u);
    if (known.validity[i] === 1 && away < least) [best, least] = [fullPixel(sample, column), away];
  }
  return best;
}

function clearPatch(side) {
  const canvas = byId("patch-" + side);
  canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
}

/** What lies around a place of a view, eleven times enlarged at least. */
function patch(side, u, v) {
  const canvas = byId("patch-" + side), pen = canvas.getContext("2d"), { sample } = view, image = view.images[side];
  const k = view.full === "there" ? 1 : sample.every, reach = Math.max(16, 8 * k), side_px = canvas.width;
  pen.imageSmoothingEnabled = false;
  pen.fillStyle = "#0b0d10";
  pen.fillRect(0, 0, side_px, side_px);
  const enlarge = side_px / (2 * reach);
  pen.drawImage(image, (reach - u - 0.5) * enlarge, (reach - v - 0.5) * enlarge, image.width * k * enlarge, image.height * k * enlarge);
  pen.strokeStyle = side === "left" ? "#4dff6a" : "#ffe14d";
  pen.beginPath();
  const c = side_px / 2;
  for (const [dx, dy] of [[1, 0], [0, 1], [-1, 0], [0, -1]]) {
    pen.moveTo(c + 5 * dx, c + 5 * dy);
    pen.lineTo(c + 16 * dx, c + 16 * dy);
  }
  pen.stroke();
}

const plain = (value) =>
  typeof value === "number" && !Number.isInteger(value) ? String(Number(value.toFixed(4))) : typeof value === "object" ? JSON.stringify(value) : value;

function facts(sample) {
  const scene = dataset.scenes[sample.id.split("/")[0]];
  const rows = [
    ["region", `${sample.region}/${sample.variant}`], ["seed", sample.scene_seed], ["split", sample.split],
    ["baseline", `${sample.baseline_m.toFixed(3)} m`], ["azimuth", `${sample.azimuth_deg.toFixed(2)}°`],
    ["convergence", `${sample.convergence_deg.toFixed(2)}°`],
    ["valid", percent(sample.valid_fraction)], ["occluded", percent(sample.occluded_fraction)],
    ["out of frame", percent(sample.out_of_frame_fraction)],
    ["disparity", `${sample.disparity_min_px?.toFixed(2)} to ${sample.disparity_max_px?.toFixed(2)} px`],
    ["frame", `${sample.camera.width_px} × ${sample.camera.height_px} px, ${sample.gsd_m} m`],
    ["altitude", `${sample.altitude_m} m`], ["doffs", `${sample.doffs_px.toFixed(3)} px`],
    ["shown here", sample.every === 1 ? "every pixel" : `labels of every ${sample.every}th pixel and row`],
    ...Object.entries(scene ?? {}).map(([name, value]) => [name, plain(value)]),
  ];
  byId("facts").replaceChildren(...rows.map(([name, value]) => {
    const row = document.createElement("tr"), head = document.createElement("th"), cell = document.createElement("td");
    head.textContent = name;
    cell.textContent = value;
    row.append(head, cell);
    return row;
  }));
}

/** Counts of disparity by validity, over the range of the colours. */
function histogram() {
  const canvas = byId("histogram"), pen = canvas.getContext("2d"), { known, range } = view, bins = 80;
  const counts = [1, 2, 3].map(() => new Float64Array(bins));
  known.disparity.forEach((d, i) => {
    const bin = Math.floor(((d - range[0]) / (range[1] - range[0])) * bins);
    if (known.validity[i] && bin >= 0 && bin < bins) counts[known.validity[i] - 1][bin]++;
  });
  const style = getComputedStyle(document.documentElement), { width, height } = canvas, base = height - 34;
  const most = Math.max(1, ...counts[0].map((_, b) => counts[0][b] + counts[1][b] + counts[2][b]));
  pen.clearRect(0, 0, width, height);
  for (let b = 0; b < bins; b++) {
    let top = base;
    ["--valid", "--occluded", "--outside"].forEach((name, k) => {
      const tall = (counts[k][b] / most) * (base - 4);
      pen.fillStyle = style.getPropertyValue(name);
      pen.fillRect((b * width) / bins, top - tall, width / bins - 1, tall);
      top -= tall;
    });
  }
  for (let x = 0; x < width; x++) {
    const k = 3 * Math.floor((255 * x) / (width - 1));
    pen.fillStyle = `rgb(${RAMP[k]},${RAMP[k + 1]},${RAMP[k + 2]})`;
    pen.fillRect(x, base + 2, 1, 6);
  }
  pen.fillStyle = style.getPropertyValue("--ink");
  pen.font = "22px system-ui, sans-serif";
  [[range[0], "left", 0], [(range[0] + range[1]) / 2, "center", width / 2], [range[1], "right", width]].forEach(([value, side, x]) => {
    pen.textAlign = side;
    pen.fillText(`${value.toFixed(1)} px`, x, height - 3);
  });
}

function step(by) {
  const at = shown.indexOf(view.index);
  const next = shown[(Math.max(at, 0) + by + shown.length) % shown.length];
  if (next !== undefined) openSample(next);
}

function zoom(factor, sx, sy) {
  if (view.mode === "surface") return surface.zoom(1 / factor);
  const before = toFrame(sx, sy);
  view.scale = Math.min(40, Math.max(0.05, view.scale * factor));
  const after = toFrame(sx, sy);
  view.x += before[0] - after[0];
  view.y += before[1] - after[1];
  draw();
}
