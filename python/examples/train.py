#!/usr/bin/env python3
"""Trains a small stereo net on a stream alone, and holds it against OpenCV's semi-global matcher on pairs it never saw.

    pip install ./python torch opencv-python-headless matplotlib
    python python/examples/train.py --minutes 75 --out trained

Nothing is read from disk: every training pair is made by `satseed.torch.StereoStream` in a worker, while the net trains
on what came so far. Held-out pairs come from other seeds: pivots of the training regions, and regions that the net never
sees. After each evaluation OUT/curve.json and OUT/curve.png are written anew; OUT/net.pt at the end. docs/training.md
tells what came out.
"""

import argparse
import copy
import json
import math
import os
import pathlib
import random
import sys
import threading
import time

import cv2
import numpy as np
import torch
import torch.nn.functional as F
from torch import nn
from torch.utils.data import DataLoader

import satseed
from satseed.torch import StereoStream

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples"))
import sgbm  # noqa: E402

# The datum is the pivot's height: what lies there has disparity 0, higher things have more, lower things less. Pivots lie
# on low ground, so that with baselines of 50 to 100 m nearly all of the regions lies within LOW to HIGH; `range` in the
# curve file tells how much does not.
LOW, HIGH = -16, 72
TRAINED, HELD_OUT = ("toronto", "canyon", "field"), ("desert", "forest")
TRAIN_SEED, HELD_OUT_SEED = 1, 900_001
# Rows and columns of what a step sees of a pair.
PATCH = (224, 288)


# ---- The net ---------------------------------------------------------------------------------------------------------


def conv(dim, inward, outward, stride=1, dilation=1):
    layers = {2: (nn.Conv2d, nn.BatchNorm2d), 3: (nn.Conv3d, nn.BatchNorm3d)}[dim]
    return nn.Sequential(
        layers[0](inward, outward, 3, stride, padding=dilation, dilation=dilation, bias=False), layers[1](outward), nn.ReLU(inplace=True)
    )


class Residual(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.body = nn.Sequential(conv(2, channels, channels), nn.Conv2d(channels, channels, 3, padding=1, bias=False), nn.BatchNorm2d(channels))

    def forward(self, x):
        return F.relu(x + self.body(x), inplace=True)


class Tower(nn.Module):
    """Features of an image at a quarter of its resolution, with context from an eighth."""

    def __init__(self, channels=48):
        super().__init__()
        self.quarter = nn.Sequential(conv(2, 3, 24, stride=2), conv(2, 24, 24), conv(2, 24, channels, stride=2), Residual(channels))
        self.eighth = nn.Sequential(conv(2, channels, 64, stride=2), Residual(64), Residual(64))
        self.merged = nn.Sequential(conv(2, channels + 64, channels), nn.Conv2d(channels, channels, 3, padding=1, bias=False))

    def forward(self, image):
        quarter = self.quarter(image)
        context = F.interpolate(self.eighth(quarter), size=quarter.shape[-2:], mode="bilinear", align_corners=False)
        return self.merged(torch.cat([quarter, context], 1))


class SmallStereo(nn.Module):
    """Shared features, group-wise correlation over a signed range, light 3-D aggregation, soft-argmin, one refinement."""

    GROUPS = 8

    def __init__(self, low=LOW, high=HIGH):
        super().__init__()
        self.levels = range(low // 4, high // 4 + 1)
        self.tower = Tower()
        self.narrow = nn.Sequential(conv(3, self.GROUPS, 16), conv(3, 16, 16))
        self.wide = nn.Sequential(conv(3, 16, 48, stride=2), conv(3, 48, 48))
        self.back = conv(3, 48, 16)
        self.cost = nn.Parameter(torch.randn(16) / 4)
        self.fine = nn.Sequential(
            conv(2, 32, 32), conv(2, 32, 32, dilation=2), conv(2, 32, 32, dilation=4), conv(2, 32, 32), nn.Conv2d(32, 4, 3, padding=1)
        )

    def volume(self, left, right):
        """Likeness of left features at u to right ones at u - d, per group, for every level d; signed, so both ways."""
        n, c, h, w = left.shape
        grouped = lambda f: F.normalize(f.view(n, self.GROUPS, c // self.GROUPS, h, w), dim=2)
        left, right = grouped(left), grouped(right)
        planes = []
        for d in self.levels:
            shifted = torch.zeros_like(right)
            if d >= 0:
                shifted[..., d:] = right[..., : w - d]
            else:
                shifted[..., :d] = right[..., -d:]
            planes.append((left * shifted).sum(2))
        return torch.stack(planes, 2)

    def forward(self, left, right):
        """Disparity of the left image, px: coarse (upsampled) and refined, (n, rows, columns)."""
        size = left.shape[-2:]
        features = self.tower(torch.cat([left, right]))
        n = left.shape[0]
        x = self.narrow(self.volume(features[:n], features[n:]))
        inner = F.interpolate(self.back(self.wide(x)), size=x.shape[-3:], mode="trilinear", align_corners=False)
        cost = torch.einsum("ncdhw,c->ndhw", F.relu(x + inner), self.cost)
        values = torch.arange(self.levels.start, self.levels.stop, dtype=cost.dtype).view(1, -1, 1, 1) * 4.0
        coarse = (F.softmax(cost, 1) * values).sum(1, keepdim=True)
        coarse = F.interpolate(coarse, size=size, mode="bilinear", align_corners=False)
        # What the right image shows there, and how far that is from the left one: four pixels at a time.
        near = coarse.detach()
        wrong = left - warp(right, near)
        seen = torch.cat([left, wrong, near / 32, wrong.abs().mean(1, keepdim=True)], 1)
        fine = near + F.pixel_shuffle(self.fine(F.pixel_unshuffle(seen, 2)), 2)
        return coarse[:, 0], fine[:, 0]


def warp(right, disparity):
    """The right image where a disparity says that it shows the left one."""
    n, _, h, w = right.shape
    v, u = torch.meshgrid(torch.arange(h, dtype=right.dtype), torch.arange(w, dtype=right.dtype), indexing="ij")
    across = (u - disparity[:, 0]) / (w - 1) * 2 - 1
    down = (v / (h - 1) * 2 - 1).expand(n, h, w)
    return F.grid_sample(right, torch.stack([across, down], -1), padding_mode="border", align_corners=True)


# ---- What it is fed --------------------------------------------------------------------------------------------------


def images(batch):
    """uint8 to about -1 to 1, each pair by its own mean and spread."""
    both = torch.stack([batch["left"], batch["right"]], 1).float()
    mean = both.mean((1, 3, 4), keepdim=True)
    spread = both.std((1, 3, 4), keepdim=True) + 1e-3
    both = (both - mean) / spread / 2
    return both[:, 0], both[:, 1]


class Fresh:
    """The latest pairs of a stream, filled by a thread of its own: the net never waits for the stream once it runs."""

    def __init__(self, stream, most, start):
        self.most, self.held, self.came, self.lock, self.enough = most, [], 0, threading.Lock(), threading.Event()
        self.start = start
        # Where cores are few, the net comes first.
        self.loader = iter(DataLoader(stream, batch_size=None, num_workers=1, worker_init_fn=lambda _: os.nice(5)))
        threading.Thread(target=self.fill, daemon=True).start()

    def fill(self):
        for pair in self.loader:
            with self.lock:
                if len(self.held) < self.most:
                    self.held.append(pair)
                else:
                    self.held[self.came % self.most] = pair
                self.came += 1
            if self.came >= self.start:
                self.enough.set()

    def batch(self, rng, count, size):
        h, w = size
        with self.lock:
            chosen = [rng.choice(self.held) for _ in range(count)]
        cut = []
        for pair in chosen:
            rows, columns = pair["disparity"].shape
            v, u = rng.randrange(rows - h + 1), rng.randrange(columns - w + 1)
            part = {k: pair[k][..., v : v + h, u : u + w] for k in ("left", "right", "disparity", "valid")}
            if rng.random() < 0.5:  # Upside down is a stereo pair as well.
                part = {k: t.flip(-2) for k, t in part.items()}
            cut.append(part)
        return {k: torch.stack([c[k] for c in cut]) for k in cut[0]}


# ---- How it is judged ------------------------------------------------------------------------------------------------


def fill(disparity):
    """Holes take the lower of the nearest values to the left and to the right: what is hidden lies behind."""
    rows, columns = disparity.shape
    at = np.where(np.isnan(disparity), 0, np.arange(columns)[None])
    before = np.maximum.accumulate(at, axis=1)
    at = np.where(np.isnan(disparity), columns - 1, np.arange(columns)[None])
    after = np.minimum.accumulate(at[:, ::-1], axis=1)[:, ::-1]
    line = np.arange(rows)[:, None]
    filled = np.fmin(disparity[line, before], disparity[line, after])
    return np.where(np.isnan(filled), 0.0, filled).astype(np.float32)


def score(predictions, pairs):
    """Mean error and shares of wrong pixels: where both cameras see the point, and where the right one does not."""
    sums = {"valid": np.zeros(5), "occluded": np.zeros(5)}
    for predicted, pair in zip(predictions, pairs):
        truth = pair["disparity"].numpy()
        known = np.isfinite(truth)
        for name, where in (("valid", pair["valid"].numpy() & known), ("occluded", ~pair["valid"].numpy() & known)):
            error = np.abs(predicted[where] - truth[where])
            sums[name] += [error.size, error.sum(), (error > 1).sum(), (error > 2).sum(), (error > 3).sum()]
    share = lambda s: {"pixels": int(s[0]), **dict(zip(("epe_px", "over_1", "over_2", "over_3"), (round(x / max(s[0], 1), 5) for x in s[1:])))}
    return {name: share(s) for name, s in sums.items()}


def judge(net, sets):
    net.eval()
    found = {}
    with torch.no_grad():
        for name, pairs in sets.items():
            predicted = []
            for pair in pairs:
                left, right = images({k: pair[k][None] for k in ("left", "right")})
                predicted.append(fill(net(left, right)[1][0].numpy()))
            found[name] = score(predicted, pairs)
    return found


def judge_sgbm(sets):
    """The same range, the same filling."""
    bgr = lambda image: np.ascontiguousarray(image.permute(1, 2, 0).numpy()[..., ::-1])
    match = lambda p: fill(sgbm.match(bgr(p["left"]), bgr(p["right"]), LOW, HIGH))
    return {name: score([match(p) for p in pairs], pairs) for name, pairs in sets.items()}


def held_out(pivots, pairs_per_pivot):
    """Pairs of pivots that the training stream never has, and of regions that it never has; begun now, taken later."""
    begun = {}
    for name, regions, scenes in [("held-out pivots", TRAINED, pivots), *((r, (r,), max(pivots // 3, 1)) for r in HELD_OUT)]:
        samples = scenes * pairs_per_pivot
        stream = StereoStream(satseed.crops(*regions), seed=HELD_OUT_SEED, samples=samples, pairs_per_scene=pairs_per_pivot)
        begun[name] = iter(DataLoader(stream, batch_size=None, num_workers=1, prefetch_factor=samples))
    return begun


def spread(pairs):
    """What disparities pairs have, and what share of their valid pixels lies outside of the net's range."""
    d = np.concatenate([p["disparity"][p["valid"]].numpy() for p in pairs])
    low, middle, high = (float(x) for x in np.percentile(d, [0.1, 50, 99.9]))
    outside = float(((d < LOW) | (d > HIGH)).mean())
    return {"pairs": len(pairs), "p0.1_px": low, "median_px": middle, "p99.9_px": high, "outside": outside}


class Mean:
    """The net with the mean of its latest weights, which is better than any of them before the rate has fallen."""

    def __init__(self, net):
        self.net, self.steps = copy.deepcopy(net), 0

    def add(self, net):
        self.steps += 1
        keep = min(0.995, self.steps / (self.steps + 10))
        with torch.no_grad():
            for mean, own in zip(self.net.parameters(), net.parameters()):
                mean.lerp_(own, 1 - keep)
            for mean, own in zip(self.net.buffers(), net.buffers()):
                mean.copy_(own)


# ---- The run ---------------------------------------------------------------------------------------------------------


def picture(curve, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    sets = list(curve["sgbm"])
    figure, axes = plt.subplots(2, len(sets), figsize=(10, 6), squeeze=False)
    for column, name in enumerate(sets):
        steps = [e["step"] for e in curve["evaluations"]]
        for row, (keys, unit) in enumerate(((("epe_px",), "EPE, px"), (("over_1", "over_3"), "share of pixels"))):
            for key, colour in zip(keys, ("C0", "C1")):
                label = {"epe_px": "EPE", "over_1": "> 1 px", "over_3": "> 3 px"}[key]
                axes[row][column].plot(steps, [e[name]["valid"][key] for e in curve["evaluations"]], colour, marker=".", label=f"net, {label}")
                axes[row][column].axhline(curve["sgbm"][name]["valid"][key], color=colour, linestyle="--", label=f"SGBM, {label}")
            axes[row][column].set(xlabel="step", ylabel=unit, title=name, ylim=(0, None))
            axes[row][column].legend()
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("trained"))
    parser.add_argument("--minutes", type=float, default=75.0, help="CPU time of the training process, evaluations included")
    parser.add_argument("--threads", type=int, default=1, help="threads of torch; the stream's worker takes one more")
    parser.add_argument("--evaluate-every", type=float, default=8.0, metavar="MINUTES")
    parser.add_argument("--batch", type=int, default=2)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--held", type=int, default=600, help="pairs that training draws from: the latest of the stream")
    parser.add_argument("--start-with", type=int, default=32, help="pairs that must have come before training begins")
    parser.add_argument("--pairs-per-scene", type=int, default=16)
    parser.add_argument("--pivots", type=int, default=6, help="held-out pivots of the training regions; a third of it for each other region")
    parser.add_argument("--pairs-per-pivot", type=int, default=2)
    a = parser.parse_args()
    a.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(a.threads)
    torch.manual_seed(0)
    rng = random.Random(0)
    say = lambda text: print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)

    stream = StereoStream(satseed.crops(*TRAINED), seed=TRAIN_SEED, pairs_per_scene=a.pairs_per_scene)
    fresh = Fresh(stream, a.held, a.start_with)
    waiting, sets = held_out(a.pivots, a.pairs_per_pivot), {}
    say("the stream runs, and held-out pairs are made beside it")
    net = SmallStereo()
    mean = Mean(net)
    curve = {
        "satseed": satseed.__version__, "torch": torch.__version__, "parameters": sum(p.numel() for p in net.parameters()),
        "range_px": [LOW, HIGH], "batch": a.batch, "patch": PATCH, "threads": a.threads, "trained_on": TRAINED, "evaluations": [],
    }
    optimiser = torch.optim.AdamW(net.parameters(), lr=a.rate, weight_decay=1e-4)
    fresh.enough.wait()
    # A busy machine must not shorten the training: CPU time counts, which is wall time where nothing else runs.
    begun, used = time.time(), time.process_time
    first = evaluated = used()
    step, lost, budget_s = 0, [], a.minutes * 60
    say(f"{curve['parameters']} parameters; training begins with {fresh.came} pairs")

    def evaluate():
        if not sets:
            sets.update({name: list(pairs) for name, pairs in waiting.items()})
            curve["range"] = {name: spread(pairs) for name, pairs in sets.items()}
            curve["sgbm"] = judge_sgbm(sets)
            say(f"held-out pairs: {curve['range']}; SGBM: {curve['sgbm']}")
        found = judge(mean.net, sets)
        minutes = {"cpu_minutes": round((used() - first) / 60, 2), "wall_minutes": round((time.time() - begun) / 60, 2)}
        loss = float(np.mean(lost[-200:])) if lost else None
        curve["evaluations"].append({"step": step, **minutes, "pairs_made": fresh.came, "loss": loss, **found})
        (a.out / "curve.json").write_text(json.dumps(curve, indent=1))
        picture(curve, a.out / "curve.png")
        told = ", ".join(f"{n}: EPE {f['valid']['epe_px']:.3f} px, > 1 {f['valid']['over_1']:.3f}, > 3 {f['valid']['over_3']:.3f}" for n, f in found.items())
        say(f"step {step}, {minutes}, {fresh.came} pairs made, loss {loss}: {told}")

    while (spent := used() - first) < budget_s:
        # Warm up, then along a cosine down to nothing at the end of the time.
        rate = a.rate * min(1.0, (step + 1) / 100) * (0.5 + 0.5 * math.cos(math.pi * spent / budget_s))
        for group in optimiser.param_groups:
            group["lr"] = max(rate, 1e-6)
        batch = fresh.batch(rng, a.batch, PATCH)
        left, right = images(batch)
        coarse, fine = net(left, right)
        truth = batch["disparity"]
        known = torch.isfinite(truth) & (truth >= LOW) & (truth <= HIGH)
        # What the right camera does not see is taught too, at less weight: its labels are as exact.
        weight = known * (0.25 + 0.75 * batch["valid"])
        truth = torch.where(known, truth, torch.zeros_like(truth))
        each = lambda d: (F.smooth_l1_loss(d, truth, reduction="none", beta=1.0) * weight).sum() / weight.sum().clamp(min=1)
        loss = 0.5 * each(coarse) + each(fine)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimiser.step()
        mean.add(net)
        step += 1
        lost.append(float(loss.detach()))
        if step in (1, 10, 50) or step % 200 == 0:
            say(f"step {step}: loss {np.mean(lost[-100:]):.3f}, {step / (used() - first):.2f} steps a CPU second")
        if used() - evaluated > a.evaluate_every * 60:
            evaluate()
            evaluated = used()
    evaluate()
    torch.save(mean.net.state_dict(), a.out / "net.pt")
    say("done")


if __name__ == "__main__":
    main()
