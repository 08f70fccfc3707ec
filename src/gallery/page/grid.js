// The overview: filters, order and cards. A card's picture is decoded when it comes near the screen.

const percent = (share) => (share * 100).toFixed(share < 0.0995 ? 1 : 0) + " %";
const cards = samples.map(card);
/** Indices of the samples that pass the filters, in the order shown. */
let shown = [];

const near = new IntersectionObserver((entries) => {
  for (const entry of entries.filter((e) => e.isIntersecting)) {
    near.unobserve(entry.target);
    entry.target.querySelector("img").src = jpegUrl(pack(Number(entry.target.dataset.index)).left);
  }
}, { rootMargin: "600px" });

function card(sample, index) {
  const button = document.createElement("button");
  button.className = "card";
  button.dataset.index = index;
  const image = document.createElement("img");
  image.alt = "";
  const name = document.createElement("span");
  name.textContent = sample.id;
  const facts = document.createElement("span");
  facts.className = "soft";
  facts.textContent = `B ${sample.baseline_m.toFixed(0)} m, occluded ${percent(sample.occluded_fraction)}`;
  button.append(image, name, facts);
  button.addEventListener("click", () => openSample(index));
  return button;
}

const ORDERS = {
  "plan order": () => 0,
  "baseline, short first": (a, b) => a.baseline_m - b.baseline_m,
  "baseline, long first": (a, b) => b.baseline_m - a.baseline_m,
  "most occluded": (a, b) => b.occluded_fraction - a.occluded_fraction,
  "least occluded": (a, b) => a.occluded_fraction - b.occluded_fraction,
  "most out of frame": (a, b) => b.out_of_frame_fraction - a.out_of_frame_fraction,
  "widest disparity": (a, b) => spread(b) - spread(a),
};
const spread = (sample) => (sample.disparity_max_px ?? 0) - (sample.disparity_min_px ?? 0);

const OCCLUDED = { any: [0, 2], "under 1 %": [0, 0.01], "1 to 5 %": [0.01, 0.05], "5 to 15 %": [0.05, 0.15], "over 15 %": [0.15, 2] };

function options(id, names) {
  byId(id).replaceChildren(...names.map((name) => new Option(name)));
}

function arrange() {
  const text = byId("find").value.trim().toLowerCase();
  const [region, split, baseline] = ["region", "split", "baseline"].map((id) => byId(id).value);
  const [low, high] = OCCLUDED[byId("occluded").value];
  const order = ORDERS[byId("sort").value];
  const passes = (s) =>
    s.id.includes(text) &&
    (region === "all" || region === s.region || region === `${s.region}/${s.variant}`) &&
    (split === "all" || split === s.split) &&
    (baseline === "all" || baseline === `${s.baseline_m.toFixed(1)} m`) &&
    s.occluded_fraction >= low && s.occluded_fraction < high;
  shown = samples.map((_, i) => i).filter((i) => passes(samples[i])).sort((a, b) => order(samples[a], samples[b]) || a - b);
  byId("grid").replaceChildren(...shown.map((i) => cards[i]));
  byId("empty").hidden = shown.length > 0;
  const all = dataset.in_dataset === samples.length ? `${samples.length}` : `${samples.length} of ${dataset.in_dataset}`;
  byId("counts").textContent = shown.length === samples.length ? `${all} samples` : `${shown.length} of ${all} samples`;
}

function startGrid() {
  const sorted = (values) => [...new Set(values)].sort((a, b) => String(a).localeCompare(b, "en", { numeric: true }));
  const variants = sorted(samples.flatMap((s) => [s.region, `${s.region}/${s.variant}`]));
  options("region", ["all", ...variants]);
  options("split", ["all", ...sorted(samples.map((s) => s.split))]);
  options("baseline", ["all", ...sorted(samples.map((s) => `${s.baseline_m.toFixed(1)} m`))]);
  options("occluded", Object.keys(OCCLUDED));
  options("sort", Object.keys(ORDERS));
  byId("origin").textContent = `Dataset ${dataset.root_hash}`;
  byId("recipe-text").textContent = dataset.recipe;
  byId("filters").addEventListener("input", arrange);
  byId("filters").addEventListener("submit", (event) => event.preventDefault());
  byId("theme").addEventListener("click", () => {
    const root = document.documentElement, dark = getComputedStyle(root).colorScheme === "dark";
    root.dataset.theme = dark ? "light" : "dark";
  });
  cards.forEach((c) => near.observe(c));
  arrange();
}
