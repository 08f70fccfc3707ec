"use strict";
// What the page holds: the samples' facts at once, their pictures and labels when they are asked for.

const byId = (id) => document.getElementById(id);
const dataset = JSON.parse(byId("dataset").textContent);
const samples = dataset.samples;

const VALIDITY = ["nothing hit", "valid", "occluded", "out of frame"];
// A disparity is held in 1/256 px above -8192 px, 22 bits; 0 is none. Two bits above it hold the validity.
const STEPS = 256, ZERO = 1 << 21, VALUE = (1 << 22) - 1;

const packed = new Map();

/** A sample's pictures and labels as they stand in the page. */
function pack(index) {
  if (!packed.has(index)) {
    packed.set(index, JSON.parse(byId("sample-" + index).textContent));
    if (packed.size > 64) packed.delete(packed.keys().next().value);
  }
  return packed.get(index);
}

const jpegUrl = (base64) => "data:image/jpeg;base64," + base64;

async function picture(url) {
  const image = new Image();
  image.src = url;
  await image.decode();
  return image;
}

/** Labels of every k-th pixel: disparity (px, NaN where nothing was hit) and validity. */
async function labels(sample, index) {
  const zipped = Uint8Array.from(atob(pack(index).labels), (c) => c.charCodeAt(0));
  const stream = new Blob([zipped]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const { columns, rows } = sample, count = columns * rows;
  const disparity = new Float32Array(count), validity = new Uint8Array(count), code = new Int32Array(count);
  for (let i = 0; i < count; i++) {
    const difference = bytes[i] | (bytes[count + i] << 8) | (bytes[2 * count + i] << 16) | (bytes[3 * count + i] << 24);
    const before = i % columns ? code[i - 1] : i ? code[i - columns] : 0;
    code[i] = before + ((difference >>> 1) ^ -(difference & 1));
    const value = code[i] & VALUE;
    disparity[i] = value ? (value - ZERO) / STEPS : NaN;
    validity[i] = code[i] >> 22;
  }
  return { disparity, validity };
}

/** The pixel of the full frame whose label stands at a place of the reduced grid. */
const fullPixel = (sample, i) => i * sample.every + (sample.every >> 1);

/** The place of the reduced grid that is nearest to a pixel of the full frame. */
function gridPlace(sample, u, v) {
  const nearest = (x, count) => Math.min(count - 1, Math.max(0, Math.round((x - (sample.every >> 1)) / sample.every)));
  return [nearest(u, sample.columns), nearest(v, sample.rows)];
}

/** World point of a left pixel, m: depth is f B / (d + doffs). */
function worldPoint(sample, u, v, disparity) {
  const c = sample.camera, depth = (c.fx_px * sample.baseline_m) / (disparity + sample.doffs_px);
  const ray = [(u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px, 1];
  return c.world_from_camera.map((row, k) => c.position_m[k] + depth * (row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2]));
}

/** The range of colours, px: half a percent of the pixels lies beyond each end. */
function colourRange(disparity) {
  const sorted = disparity.filter(Number.isFinite).sort();
  if (!sorted.length) return [0, 1];
  const low = sorted[Math.floor(sorted.length * 0.005)], high = sorted[Math.floor((sorted.length - 1) * 0.995)];
  return [low, Math.max(high, low + 0.5)];
}

/** 256 colours of even steps in lightness, from violet to yellow: a line in OKLCH (Ottosson 2020). */
const RAMP = (() => {
  const ramp = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; i++) {
    const t = i / 255, lightness = 0.24 + 0.7 * t, hue = ((300 - 200 * t) * Math.PI) / 180;
    const chroma = 0.05 + 0.3 * t * (1 - t) + 0.06 * t;
    const a = chroma * Math.cos(hue), b = chroma * Math.sin(hue);
    const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
    const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
    const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
    const linear = [
      4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
      -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
      -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
    ];
    linear.forEach((x, k) => {
      const y = Math.min(1, Math.max(0, x));
      ramp[3 * i + k] = Math.round(255 * (y <= 0.0031308 ? 12.92 * y : 1.055 * y ** (1 / 2.4) - 0.055));
    });
  }
  return ramp;
})();
