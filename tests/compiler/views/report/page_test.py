#!/usr/bin/env python3
"""Opens the report of a small town in a headless Chromium, from disk and without a network: every figure is
drawn, nothing is complained of or fetched, a click and the keyboard show a site, and the page's numbers are
those of `sightline dump`. Screenshots stay beside the page.

usage: page_test.py SIGHTLINE TOWN FOLDER
"""

import base64
import csv
import io
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import zlib

from chromium import Browser

CONFIG = """
annotation: {ranges_m: [10, 20, 30, 40]}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
evaluation: {scans: drive_2/scans, poses: drive_2/poses.tum}
measure-error: {offset_count: 3, reference: known}
train-model: {trees: 20}
"""
READY = 'document.documentElement?.dataset.ready === "yes"'


def run(*command):
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout


def make_page(sightline, town, folder):
    """The page of the town, and that of its map against one with another promise."""
    run(town, "--seed", "3", "--length-m", "150", "--output", str(folder))
    config = folder / "town.yaml"
    config.write_text(CONFIG)
    new, old = folder / "town.slmap", folder / "old.slmap"
    run(sightline, "compile", str(config), "-q", "-o", str(new))
    run(sightline, "compile", str(config), "-q", "-o", str(old), "--set", "choose-ranges.alpha=0.4")
    page = folder / "report.html"
    run(sightline, "report", str(config), "-q", "--map", str(new), "--against", str(old), "-o", str(page))
    return new, page


def numbers(packed):
    """An array of the page (compiler/views/report/page/page_data.h)."""
    kind = {"u8": "B", "u16": "H", "u32": "I", "f32": "f", "f64": "d"}[packed["type"]]
    planes = zlib.decompress(base64.b64decode(packed["data"]))
    count, size = packed["count"], struct.calcsize(kind)
    assert len(planes) == count * size
    return struct.unpack(f"<{count}{kind}", bytes(planes[plane * count + i] for i in range(count) for plane in range(size)))


def dumped(sightline, map_file, what):
    rows = run(sightline, "dump", str(map_file), "--what", what, "--format", "csv").splitlines()
    return list(csv.DictReader(io.StringIO("\n".join(row for row in rows if not row.startswith("#")))))


def of_ranges(rows):
    """Without the looks that take a sample."""
    return [row for row in rows if "returns" not in row["look"]]


def check_numbers(sightline, map_file, page):
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(), re.S)[1])
    sites = dumped(sightline, map_file, "sites")
    assert data["sites"]["count"] == len(sites) > 100
    for axis in "xyz":
        assert list(numbers(data["sites"][f"{axis}_m"])) == [float(site[f"p_{axis}_m"]) for site in sites]
    ranges_m = data["ranges_m"]
    chosen = numbers(data["choice"]["range_index"])
    rows = of_ranges(dumped(sightline, map_file, "ranges"))
    assert [ranges_m[index] for index in chosen] == [float(row["range_m"]) for row in rows]
    predicted = numbers(data["predicted"]["mean_m"])
    rows = of_ranges(dumped(sightline, map_file, "predicted"))
    by_pair = {(int(row["site"]), float(row["range_m"])): float(row["mean_error_m"]) for row in rows}
    for (site, range_m), mean_m in by_pair.items():
        found_m = predicted[site * len(ranges_m) + ranges_m.index(range_m)]
        assert abs(found_m - mean_m) <= 1e-6 * abs(mean_m), (site, range_m)
    assert sum(tile["count"] for tile in data["nds"]["tiles"]) == len(dumped(sightline, map_file, "nds"))


def check_stills(browser):
    """Every still picture has something in it, whether it is shown or not."""
    empty = browser.value_of("""[...document.querySelectorAll("svg.chart")]
        .filter((svg) => svg.querySelectorAll("path[d], rect, circle").length < 5).map((svg) => svg.querySelector("title").textContent)""")
    assert empty == [], empty
    # A route with one range everywhere is a single path, of many points.
    drawn = browser.value_of("""[...document.querySelectorAll("svg.still-map")]
        .map((svg) => [...svg.querySelectorAll("path[d]")].map((path) => path.getAttribute("d")).join("").length)""")
    assert len(drawn) >= 2 and min(drawn) > 500, drawn
    assert browser.value_of('document.querySelectorAll("svg.chart").length') >= 10
    bad = browser.value_of('[...document.querySelectorAll("svg")].filter((svg) => /NaN|inf/.test(svg.outerHTML)).length')
    assert bad == 0


def check_drawn(browser):
    """The map and what is shown of a site have more than paper on their canvases."""
    browser.value_of('document.querySelector(".is-live").scrollIntoView({behavior: "instant"})')
    browser.wait_for('document.querySelector(".is-live > .live canvas") !== null')
    browser.wait_for('!document.querySelector(".leaflet-tile:not(.leaflet-tile-loaded)")')
    colours = browser.value_of("""[...document.querySelectorAll(".chart-live canvas, canvas.depth")].map((canvas) => {
        const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        return new Set(pixels).size; })""")
    assert len(colours) >= 3 and min(colours) > 10, colours
    layers = browser.value_of("""[...document.querySelectorAll(".leaflet-layer")].map((layer) =>
        [...layer.querySelectorAll("canvas")].reduce((sum, canvas) => sum + new Uint32Array(canvas.getContext("2d")
            .getImageData(0, 0, canvas.width, canvas.height).data.buffer).filter((pixel) => pixel !== 0).length, 0))""")
    assert len(layers) == 3 and min(layers) > 1000, layers
    browser.value_of("window.scrollTo({top: 0, behavior: 'instant'})")


def check_answers(browser):
    """A click on the map and the keyboard show a site."""
    browser.value_of('document.querySelector(".map-view").scrollIntoView({behavior: "instant"})')
    for site in (40, 90):
        place = browser.value_of(f"""(() => {{ const {{page, map}} = sightlineReport; const box = map.getContainer().getBoundingClientRect();
            const at = map.latLngToContainerPoint([page.sites.y_m[{site}], page.sites.x_m[{site}]]);
            return {{x: box.x + at.x, y: box.y + at.y}}; }})()""")
        browser.click(place["x"], place["y"])
        browser.wait_for(f"""(() => {{ const shown = Number(document.getElementById("site-title").textContent.slice(5));
            return Math.abs(shown - {site}) <= 1 && document.querySelector(".site-panel pre")?.textContent.startsWith("site " + shown + ",") &&
                document.querySelector(".site-panel canvas.depth") !== null; }})()""")
    shown = browser.value_of('Number(document.getElementById("site-title").textContent.slice(5))')
    browser.value_of('document.querySelector(\'.site-panel button[title="One site on"]\').focus()')
    browser.press(" ", 32)
    browser.wait_for(f'document.getElementById("site-title").textContent === "Site {shown + 1}"')
    for paint in range(browser.value_of('document.querySelector(".switches select").length')):
        browser.value_of(f"""(() => {{ const choice = document.querySelector(".switches select"); choice.value = {paint};
            choice.dispatchEvent(new Event("change")); }})()""")
        assert browser.value_of('document.querySelector(".map-legend").textContent.length') > 5
    browser.value_of("""(() => { const choice = document.querySelector(".switches select"); choice.value = 0;
        choice.dispatchEvent(new Event("change")); })()""")


def check_figures(browser):
    """Every figure along the route says what is pointed at, shows a site on a click, and can be widened."""
    count = browser.value_of('document.querySelectorAll(".is-answering").length')
    assert count >= 5, count
    for i in range(count):
        figure = f'document.querySelectorAll(".is-answering")[{i}]'
        browser.value_of(f'{figure}.scrollIntoView({{behavior: "instant", block: "center"}})')
        place = browser.value_of(f"""(() => {{ const box = {figure}.querySelector("svg").getBoundingClientRect();
            return {{x: box.x + 0.6 * box.width, y: box.y + 0.5 * box.height}}; }})()""")
        browser.click(place["x"], place["y"])
        reading = browser.value_of(f'{figure}.querySelector(".reading").textContent')
        assert re.match(r"site \d+, [\d.]+ m: ", reading), reading
        site = re.match(r"site (\d+),", reading)[1]
        browser.wait_for(f'document.getElementById("site-title").textContent === "Site {site}"')
        at = browser.value_of(f"""(() => {{ const line = {figure}.querySelector("svg path.shown").getBoundingClientRect();
            return line.x; }})()""")
        assert abs(at - place["x"]) < 8, (at, place)
        width = f'{figure}.querySelector("svg").getBoundingClientRect().width'
        narrow = browser.value_of(width)
        browser.value_of(f'{figure}.querySelector(\'button[title="Look closer"]\').click()')
        assert browser.value_of(width) > 1.5 * narrow
        browser.value_of(f'{figure}.querySelector(\'button[title="Show more of the route"]\').click()')
        assert abs(browser.value_of(width) - narrow) < 1


def check_page(page, is_dark):
    with Browser("chromium", 1280, 900, is_dark) as browser:
        browser.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=-1, uploadThroughput=-1)
        has_scripts = 'id="data"' in page.read_text()
        seconds = browser.open(page.as_uri(), READY if has_scripts else 'document.readyState === "complete"')
        print(f"opened in {seconds:.2f} s, {page.stat().st_size / 1e6:.1f} MB")
        check_stills(browser)
        if has_scripts:
            check_drawn(browser)
            check_answers(browser)
            check_figures(browser)
        else:
            print("built without npm: the page has its still pictures alone")
        browser.wait_for('!document.querySelector(".leaflet-tile:not(.leaflet-tile-loaded)")')
        browser.value_of("window.scrollTo({top: 0, behavior: 'instant'})")
        tone = "dark" if is_dark else "light"
        for section in browser.value_of('[...document.querySelectorAll("section")].map((section) => section.id)'):
            browser.screenshot(page.parent / f"{tone}_{section}.png", f"#{section}")
        assert browser.complaints == [], browser.complaints
        fetched = [address for address in browser.requests if not address.startswith(("file:///", "data:", "blob:", "about:"))]
        assert fetched == [], fetched
        return has_scripts


def main():
    sightline, town, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]).resolve()
    subprocess.run([pathlib.Path(__file__).parents[3] / "support" / "install", "chromium"], check=True)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    map_file, page = make_page(sightline, town, folder)
    if check_page(page, is_dark=False):
        check_numbers(sightline, map_file, page)
        check_page(page, is_dark=True)
    for drive in ("mapping", "drive_1", "drive_2", ".sightline-cache"):
        shutil.rmtree(folder / drive)
    print(f"screenshots: {folder}")


main()
