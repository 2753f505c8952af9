#!/usr/bin/env python3
"""Opens the report of a small town in a headless Chromium, from disk and without a network: every figure is
drawn, nothing is complained of or fetched, hovering, a click and the keyboard show a site, and the page's numbers are
those of `sightline dump`. AXE (axe.min.js, which npm installs with the page's libraries) finds nothing. Screenshots
stay beside the pages.

usage: page_test.py SIGHTLINE TOWN FOLDER AXE
With SIGHTLINE_LONG in the environment each page is judged in full by AXE in light and dark, in a wide and a narrow window,
and there is a screenshot of each section.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from chromium import READY, TILES_DRAWN, Browser
from page_answers import check_map, check_phone
from page_numbers import check_numbers
from page_scene import check_no_scene, check_scene

IS_LONG = "SIGHTLINE_LONG" in os.environ

CONFIG = """
annotation: {ranges_m: [10, 20, 30, 40], looks: "100 m, 650 returns, 40 points by normals; 100 m, 1944 returns, 80 points"}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
evaluation: {scans: drive_2/scans, poses: drive_2/poses.tum}
measure-error: {offset_count: 2, reference: known}
train-model: {trees: 20}
build-surface: {cell_m: 1.0}
cast-rays: {azimuth_count: 180}
remove-moving: {carve_range_m: 30}
"""


def run(*command):
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout


def make_pages(sightline, town, folder):
    """A map, its page with all that its drives tell, and the page of the map alone; both against a map with another
    promise."""
    run(town, "--seed", "3", "--length-m", "150", "--spacing-m", "2", "--output", str(folder))
    config = folder / "town.yaml"
    config.write_text(CONFIG)
    new, old = folder / "town.slmap", folder / "old.slmap"
    run(sightline, "compile", str(config), "-q", "-o", str(new))
    run(sightline, "compile", str(config), "-q", "-o", str(old), "--set", "choose-ranges.alpha=0.4")
    page = folder / "report.html"
    gate = folder / "gate.json"
    run(sightline, "gate", str(new), "--json", str(gate))
    run(sightline, "report", str(config), "-q", "--map", str(new), "--against", str(old), "--gate", str(gate), "-o", str(page))
    alone = folder / "alone.html"
    run(sightline, "report", str(new), "--against", str(old), "-o", str(alone))
    return new, page, alone


def check_stills(browser, least_charts):
    """Every still picture has something in it, whether it is shown or not."""
    empty = browser.value_of("""[...document.querySelectorAll("svg.chart")]
        .filter((svg) => svg.querySelectorAll("path[d], rect, circle").length < 5).map((svg) => svg.querySelector("title").textContent)""")
    assert empty == [], empty
    # A route with one range everywhere is a single path, of many points.
    drawn = browser.value_of("""[...document.querySelectorAll("svg.still-map")]
        .map((svg) => [...svg.querySelectorAll("path[d]")].map((path) => path.getAttribute("d")).join("").length)""")
    assert len(drawn) >= 2 and min(drawn) > 500, drawn
    assert browser.value_of('document.querySelectorAll("svg.chart").length') >= least_charts
    bad = browser.value_of("""[...document.querySelectorAll("svg")].map((svg) => svg.outerHTML.replace(/data:[^"')]*/g, "").match(/.{0,80}(NaN|inf).{0,40}/))
        .filter((found) => found !== null).map((found) => found[0])""")
    assert bad == [], bad


def check_drawn(browser, has_surface):
    """The map and what is shown of a site have more than paper on their canvases."""
    browser.value_of('document.querySelector(".is-live").scrollIntoView({behavior: "instant"})')
    browser.wait_for('document.querySelector(".is-live > .live canvas") !== null')
    show_nds = """[...document.querySelectorAll(".more-switches input[type=checkbox]")].find((each) => each.parentElement.textContent.trim() === "NDs").click()"""
    browser.value_of(show_nds)
    browser.wait_for(TILES_DRAWN)
    colours = browser.value_of("""[...document.querySelectorAll(".chart-live canvas, canvas.depth")].map((canvas) => {
        const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        return new Set(pixels).size; })""")
    assert len(colours) >= (3 if has_surface else 2) and min(colours) > 10, colours
    layers = browser.value_of("""[...document.querySelectorAll(".leaflet-layer")].map((layer) =>
        [...layer.querySelectorAll("canvas")].reduce((sum, canvas) => sum + new Uint32Array(canvas.getContext("2d")
            .getImageData(0, 0, canvas.width, canvas.height).data.buffer).filter((pixel) => pixel !== 0).length, 0))""")
    # Surface and route; NDs where they are wanted. Of those that differ there are none here.
    assert len([count for count in layers if count > 1000]) >= (3 if has_surface else 2), layers
    browser.value_of(show_nds)
    browser.value_of("window.scrollTo({top: 0, behavior: 'instant'})")


def check_answers(browser):
    """A click on the map and the keyboard show a site."""
    browser.value_of('document.querySelector(".map-view").scrollIntoView({behavior: "instant"})')
    for site in (40, 90):
        place = browser.value_of(f"""(() => {{ const {{page, map}} = sightlineReport; const box = map.getContainer().getBoundingClientRect();
            const at = map.latLngToContainerPoint([page.sites.y_m[{site}], page.sites.x_m[{site}]]);
            return {{x: box.x + at.x, y: box.y + at.y}}; }})()""")
        browser.click(place["x"], place["y"])
        browser.wait_for(f"""(() => {{ const {{page}} = sightlineReport; const shown = Number(document.getElementById("site-title").textContent.slice(5));
            return Math.abs(shown - {site}) <= 1 && document.querySelector(".site-panel pre")?.textContent.startsWith("site " + shown + ",") &&
                (!page.depth || document.querySelector(".site-panel canvas.depth") !== null); }})()""")
    shown = browser.value_of('Number(document.getElementById("site-title").textContent.slice(5))')
    browser.value_of('document.querySelector(\'.site-panel button[title="Next site"]\').focus()')
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
        browser.value_of(f'{figure}.querySelector(\'button[title="Zoom in"]\').click()')
        assert browser.value_of(width) > 1.5 * narrow
        browser.value_of(f'{figure}.querySelector(\'button[title="Zoom out"]\').click()')
        assert abs(browser.value_of(width) - narrow) < 1


def check_first_screen(browser, words):
    """What the map promises, what came of it and what the gate says stand where the page opens."""
    text = browser.value_of("""[...document.querySelectorAll(".status")]
        .filter((each) => each.getBoundingClientRect().bottom <= innerHeight).map((each) => each.textContent).join("\\n")""")
    for word in words:
        assert re.search(word, text), (word, text)


def check_change(browser):
    """The page of a change opens on it: names of both maps, differences, and the route coloured by them."""
    assert "town.slmap against old.slmap" in browser.value_of('document.querySelector(".kind").textContent')
    text = browser.value_of('document.getElementById("diff").textContent')
    assert "old.slmap: map" in text and "town.slmap: map" in text and "difference" in text
    assert re.search(r"mean range \(m\)20.040.0\+20.0", text), text
    assert "change" in browser.value_of('document.querySelector(".switches select").selectedOptions[0].textContent')


ALL_SEEN = """(() => {{ const box = document.querySelector("{}").getBoundingClientRect();
        return box.height > 0 && box.top >= 0 && box.bottom <= innerHeight; }})()"""


def is_all_seen(browser, selector):
    return browser.value_of(ALL_SEEN.format(selector))


def check_links(browser):
    """A link to a site shows the site and scrolls to the map, from within the page and in its address."""
    browser.value_of("window.scrollTo({top: 0, behavior: 'instant'})")
    browser.value_of("location.hash = '#site=7'")
    browser.wait_for('document.getElementById("site-title").textContent === "Site 7"')
    assert is_all_seen(browser, ".map-view")
    browser.value_of('document.querySelector(\'#stretches a[href="#site=0"]\').click()')
    browser.wait_for('document.getElementById("site-title").textContent === "Site 0"')
    browser.wait_for(ALL_SEEN.format(".map-view"))


def check_search_and_filter(browser):
    def find(text, frame="world"):
        browser.value_of(f"""(() => {{ const form = document.querySelector("form.search"); form.querySelector("input").value = "{text}";
            const frame = form.querySelector("select"); frame.value = "{frame}"; frame.dispatchEvent(new Event("change"));
            form.requestSubmit(); }})()""")
        return browser.value_of('document.querySelector("form.search output").textContent')

    sites = "sightlineReport.page.sites"
    at = browser.value_of(f"[{sites}.x_m[33], {sites}.y_m[33]]")
    origin = browser.value_of("sightlineReport.page.origin_world_m")
    for text, frame in (("33", "map"), (f"{at[0] + 0.1}, {at[1] + 0.1}", "map"), (f"{at[0] + origin[0]} {at[1] + origin[1]} 2", "world")):
        assert find(text, frame).startswith("site 33"), text
        browser.wait_for('document.getElementById("site-title").textContent === "Site 33"')
        find("0")
    panel = browser.value_of('document.querySelector(".steps").textContent')
    place = [browser.value_of(f"{sites}.{axis}_m[0]") for axis in "xyz"]
    for name, shift in (("world", origin), ("map", [0, 0, 0])):
        x, y, z = (p + o for p, o in zip(place, shift))
        assert f"{name}: x {x:.1f}, y {y:.1f}, z {z:.1f} m" in panel, panel
    assert find("nowhere").startswith("enter a site number") and find("4711").startswith("site numbers are 0 to")
    count = browser.value_of('document.querySelector(".filter select").length')
    assert count >= 4, count
    for choice in (1, count - 1, 0):
        browser.value_of(f"""(() => {{ const choice = document.querySelector(".filter select"); choice.value = {choice};
            choice.dispatchEvent(new Event("change")); }})()""")
        words = browser.value_of('document.querySelector(".filter output").textContent')
        assert re.match(r"\d+ of 151 sites", words) if choice else words == "", words


def check_pointing(browser):
    """What a chart is pointed at shows on the map, and in a small one where the map is out of sight."""
    browser.value_of('document.querySelector("#figure-5").scrollIntoView({behavior: "instant", block: "center"})')
    place = browser.value_of("""(() => { const box = document.querySelector("#figure-5 svg").getBoundingClientRect();
        return {x: box.x + 0.6 * box.width, y: box.y + 0.5 * box.height}; })()""")
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", **place)
    browser.wait_for('document.querySelector(".pointed-mark") !== null && !document.querySelector(".inset").hidden')
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=2, y=2)
    browser.wait_for('document.querySelector(".pointed-mark") === null && document.querySelector(".inset").hidden')


def check_axe(browser, axe, rules=None):
    """axe-core finds nothing, with all that can be opened open; judged by these rules, or by all."""
    options = {"resultTypes": ["violations"]} | ({"runOnly": rules} if rules else {})
    browser.value_of('document.querySelectorAll("details").forEach((each) => { each.open = true; })')
    browser.value_of(axe.read_text() + ";0")
    found = browser.value_of(f"axe.run(document, {json.dumps(options)})" + """.then(({violations}) =>
        violations.map((each) => `${each.id}: ${each.nodes.slice(0, 3).map((node) => node.html).join(" ")}`))""")
    assert found == [], found


def check_narrow(browser, page, is_dark, axe):
    """On a phone nothing is wider than the window."""
    browser.new_window(390, 844, is_dark)
    browser.resize(390, 844)
    browser.call("Page.setBypassCSP", enabled=True)
    browser.open(page.as_uri(), READY)
    browser.wait_for(TILES_DRAWN)
    assert browser.value_of("document.documentElement.scrollWidth") == 390
    check_phone(browser)
    browser.screenshot(page.parent / f"phone_{page.stem}_{'dark' if is_dark else 'light'}.png")
    # Of the map alone nothing stands there that is not in the other page.
    if axe.exists() and (IS_LONG or (page.stem == "report" and not is_dark)):
        check_axe(browser, axe)


def check_page(browser, page, is_dark, axe, sightline, map_file):
    browser.new_window(1280, 900, is_dark)
    browser.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=-1, uploadThroughput=-1)
    browser.call("Page.setBypassCSP", enabled=True)  # for axe
    has_scripts = 'id="data"' in page.read_text()
    has_surface = '"relief"' in page.read_text()
    seconds = browser.open(page.as_uri(), READY if has_scripts else 'document.readyState === "complete"')
    print(f"opened in {seconds:.2f} s, {page.stat().st_size / 1e6:.1f} MB")
    check_stills(browser, 10 if has_surface else 0)
    browser.screenshot(page.parent / f"{page.stem}_first_screen_{'dark' if is_dark else 'light'}.png")
    check_change(browser) if has_scripts else None
    check_first_screen(browser, ["No promise", r"target: 95.0\s%"] + (
        [r"Tracks lost: \d+; best fixed choice: \d+", "of 76 scans", "(Passed|Failed): "] if has_surface else []))
    if has_scripts:
        check_map(browser, has_surface)
        check_drawn(browser, has_surface)
        check_answers(browser)
        check_links(browser)
        check_search_and_filter(browser)
        check_scene(browser, sightline, map_file)
    if has_scripts and has_surface:
        check_figures(browser)
        check_pointing(browser)
    if has_scripts and axe.exists():
        check_axe(browser, axe, ["color-contrast"] if is_dark and not IS_LONG else None)
    if not has_scripts:
        print("built without npm: the page has its still pictures alone")
    else:
        browser.wait_for(TILES_DRAWN)
    browser.value_of("window.scrollTo({top: 0, behavior: 'instant'})")
    tone = "dark" if is_dark else "light"
    sections = browser.value_of('[...document.querySelectorAll("section")].map((section) => section.id)')
    for section in sections if IS_LONG else []:
        browser.screenshot(page.parent / f"{page.stem}_{tone}_{section}.png", f"#{section}")
    assert browser.complaints == [], browser.complaints
    fetched = [address for address in browser.requests if not address.startswith(("file:///", "data:", "blob:", "about:"))]
    assert fetched == [], fetched
    return has_scripts


def main():
    sightline, town, folder, axe = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]).resolve(), pathlib.Path(sys.argv[4])
    subprocess.run([pathlib.Path(__file__).parents[3] / "support" / "install", "chromium"], check=True)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    map_file, *pages = make_pages(sightline, town, folder)
    if not axe.exists():
        print(f"not judged by axe: there is no {axe}")
    with Browser("chromium", 1280, 900) as browser:
        for page in pages:
            if check_page(browser, page, False, axe, sightline, map_file):
                check_numbers(sightline, map_file, page)
                check_page(browser, page, True, axe, sightline, map_file)
                check_no_scene(browser, page)
                check_narrow(browser, page, False, axe)
                check_narrow(browser, page, True, axe)
    for drive in ("mapping", "drive_1", "drive_2", ".sightline-cache"):
        shutil.rmtree(folder / drive)
    print(f"screenshots: {folder}")


main()
