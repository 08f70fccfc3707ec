"""Opens a dataset's gallery in headless Chromium, from file://, and holds what it shows against the label files.

    python tests/python/gallery.py DATASET [SCREENSHOTS]

Needs playwright and a Chromium of the system. Exits with 0 and says so where there is no Chromium.
"""

import io
import json
import pathlib
import re
import shutil
import sys

import numpy as np
import tifffile
from PIL import Image
from playwright.sync_api import sync_playwright

VALIDITY = ["nothing hit", "valid", "occluded", "out of frame"]


def labels(root, sample):
    folder = root / sample
    return tifffile.imread(folder / "disparity_left.tif"), np.asarray(Image.open(folder / "validity_left.png"))


def check_probe(page, root, sample, points, rng):
    """What the probe says at random places of the stage is what the label files say."""
    disparity, validity = labels(root, sample)
    stage = page.locator("#stage").bounding_box()
    seen = 0
    for _ in range(40 * points):
        if seen == points:
            break
        page.mouse.move(stage["x"] + rng.uniform(0, stage["width"]), stage["y"] + rng.uniform(0, stage["height"]))
        told = page.inner_text("#probe")
        place = re.match(r"left \((\d+), (\d+)\)", told)
        if not place:
            continue
        u, v = map(int, place.groups())
        number = re.search(r"disparity (-?[\d.]+) px, ([a-z ]+)\nright \((-?[\d.]+), (\d+)\)", told)
        assert number, told
        assert abs(float(number[1]) - disparity[v, u]) <= 0.0071, (sample, u, v, told, disparity[v, u])
        assert number[2] == VALIDITY[validity[v, u]], (sample, u, v, told, validity[v, u])
        assert abs(float(number[3]) - (u - disparity[v, u])) <= 0.0071 and int(number[4]) == v, told
        seen += 1
    assert seen == points, f"only {seen} places of {sample} could be probed"


def pixels(page, canvas):
    """How many colours a canvas shows."""
    png = page.locator(canvas).screenshot()
    return len(np.unique(np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).reshape(-1, 3), axis=0))


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    shots = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not chromium:
        print("gallery: left out, since there is no Chromium on this system")
        return
    records = [json.loads(line) for line in (root / "manifest.jsonl").read_text().splitlines()]
    rng = np.random.default_rng(5)
    with sync_playwright() as playwright:
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=chromium, args=flags)
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        problems, requests = [], []
        page.on("console", lambda m: problems.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda e: problems.append(str(e)))
        page.on("request", lambda r: requests.append(r.url))

        def shot(name):
            if shots:
                shots.mkdir(parents=True, exist_ok=True)
                page.screenshot(path=shots / f"{name}.png")

        # Loading waits for a browser that shares two cores with the tests: how long is not what is held against it.
        page.set_default_navigation_timeout(180_000)
        page.goto((root / "gallery.html").as_uri())
        cards = page.locator(".card")
        assert cards.count() == len(records), (cards.count(), len(records))
        page.locator(".card img[src]").first.wait_for()
        page.wait_for_timeout(300)
        shot("overview-light")

        # Filters and order.
        page.fill("#find", records[-1]["id"][:6])
        expected = [r["id"] for r in records if records[-1]["id"][:6] in r["id"]]
        assert page.locator(".card span:nth-of-type(1)").all_text_contents() == expected
        page.fill("#find", "no such sample")
        assert cards.count() == 0 and page.is_visible("#empty")
        page.fill("#find", "")
        page.select_option("#region", records[-1]["region"])
        assert cards.count() == sum(r["region"] == records[-1]["region"] for r in records)
        page.select_option("#region", "all")
        page.select_option("#sort", "most occluded")
        shown = page.locator(".card span:nth-of-type(1)").all_text_contents()
        assert shown == [r["id"] for r in sorted(records, key=lambda r: -r["occluded_fraction"])]
        page.select_option("#sort", "plan order")

        # Every mode draws, by its key, and the probe tells what the files say.
        page.locator(".card").first.click()
        page.wait_for_selector("#viewer[open]")
        page.locator("#title", has_text=records[0]["id"]).wait_for()
        for key, mode in enumerate(["left", "right", "swipe", "flicker", "anaglyph", "disparity", "surface"], 1):
            page.keyboard.press(str(key))
            pressed = page.locator("#modes button[aria-pressed=true]")
            assert pressed.count() == 1 and pressed.get_attribute("data-mode") == mode
            page.wait_for_timeout(150)
            colours = pixels(page, "#solid" if mode == "surface" else "#flat")
            assert colours > 100, f"{mode} shows {colours} colours"
            shot(f"mode-{mode}")
        before = page.locator("#solid").screenshot()
        page.keyboard.press("ArrowLeft")
        page.wait_for_timeout(100)
        assert page.locator("#solid").screenshot() != before, "the arrow does not turn the surface"
        page.keyboard.press("1")
        check_probe(page, root, records[0]["id"], 20, rng)
        for _ in range(6):
            page.keyboard.press("+")
        page.wait_for_timeout(300)
        check_probe(page, root, records[0]["id"], 20, rng)
        shot("close")
        page.keyboard.press("f")

        # The divider of swipe moves, validity lies over the picture, the next sample comes.
        page.keyboard.press("3")
        at = page.locator("#divider").bounding_box()["x"]
        page.keyboard.press(".")
        assert page.locator("#divider").bounding_box()["x"] > at
        page.keyboard.press("1")
        page.mouse.move(2, 2)
        before = page.locator("#flat").screenshot()
        page.keyboard.press("v")
        assert page.locator("#flat").screenshot() != before, "validity changes nothing"
        page.keyboard.press("v")
        page.keyboard.press("n")
        page.locator("#title", has_text=records[1]["id"]).wait_for()
        check_probe(page, root, records[1]["id"], 20, rng)
        page.keyboard.press("Escape")
        assert not page.is_visible("#viewer")

        # Dark, and as wide as a phone: nothing sticks out.
        page.emulate_media(color_scheme="dark")
        shot("overview-dark")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(21, 24, 28)"
        page.click("#theme")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        page.click("#theme")
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        shot("phone-overview")
        page.locator(".card").first.click()
        page.wait_for_selector("#viewer[open]")
        page.keyboard.press("6")
        page.wait_for_timeout(200)
        assert page.evaluate("document.getElementById('viewer').scrollWidth <= innerWidth")
        shot("phone-viewer")

        assert not problems, problems
        away = [url for url in requests if not url.startswith(("file:", "data:"))]
        assert not away, away
        browser.close()
    print(f"gallery: {len(records)} samples, 60 probed places, 7 modes, 2 themes, phone: as the files say")


if __name__ == "__main__":
    main()
