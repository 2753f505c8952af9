#!/usr/bin/env python3
"""Opens the pages of made-up roads in a headless Chromium: 3 km on a desk, 600 m and 10 km on a phone. The map opens
with its route drawn from one end to the other, and nothing is wider than the window. Prints how large a page is
and how long it takes until its map is drawn; the times are not judged. Screenshots stay beside the pages.

usage: long_page_test.py WRITE_LONG_PAGE FOLDER
"""

import pathlib
import shutil
import subprocess
import sys
import time

from chromium import READY, TILES_DRAWN, Browser

# Metres of road, and the window.
CASES = [(3000, 1440, 900), (600, 390, 844), (10000, 390, 844)]


def drawn_span(browser):
    """What part of the route's width on the screen has pixels of the topmost layer, which is the route."""
    return browser.value_of("""(() => {
        const {page, map} = sightlineReport;
        const columns = new Set();
        const canvases = [...document.querySelectorAll(".leaflet-layer")]
            .sort((a, b) => a.style.zIndex - b.style.zIndex).at(-1)?.querySelectorAll("canvas") ?? [];
        for (const canvas of canvases) {
          const box = canvas.getBoundingClientRect();
          const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
          for (let i = 3; i < pixels.length; i += 4) {
            if (pixels[i] > 100) columns.add(Math.floor(box.x + ((i >> 2) % canvas.width) * box.width / canvas.width));
          }
        }
        const at = (site) => map.latLngToContainerPoint([page.sites.y_m[site], page.sites.x_m[site]]).x;
        const box = map.getContainer().getBoundingClientRect();
        const [left, right] = [at(0), at(page.sites.count - 1)];
        let drawn = 0;
        for (let x = Math.ceil(left); x < right; ++x) drawn += columns.has(Math.round(box.x + x));
        return {share: drawn / (right - left), fits: left >= 0 && right <= box.width};
    })()""")


def check(page, width, height):
    with Browser("chromium", width, height) as browser:
        browser.resize(width, height)
        begin = time.monotonic()
        ready_s = browser.open(page.as_uri(), READY)
        browser.wait_for(TILES_DRAWN)
        drawn_s = time.monotonic() - begin
        megabytes = page.stat().st_size / 1e6
        print(f"{page.stem} at {width} x {height}: {megabytes:.1f} MB, ready in {ready_s:.2f} s, map drawn in {drawn_s:.2f} s")
        browser.screenshot(page.parent / f"{page.stem}_first_screen.png")
        browser.value_of('document.querySelector(".map-view").scrollIntoView({behavior: "instant"})')
        browser.screenshot(page.parent / f"{page.stem}_map.png")
        route = drawn_span(browser)
        assert route["fits"] and route["share"] > 0.97, route
        assert browser.complaints == [], browser.complaints


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    subprocess.run([pathlib.Path(__file__).parents[3] / "support" / "install", "chromium"], check=True)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for metres, width, height in CASES:
        page = folder / f"road_{metres}_m.html"
        subprocess.run([program, str(metres), str(page)], check=True)
        if 'id="data"' in page.read_text():
            check(page, width, height)
        else:
            print("built without npm: the page has its still pictures alone")
    print(f"screenshots: {folder}")


main()
