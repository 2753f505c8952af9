"""What the map of a page answers: the first screen, hovering, colours, the wheel, the download."""

import csv
import io
import re


def paint_names(browser):
    return browser.value_of('[...document.querySelector(".switches select").options].map((each) => each.textContent)')


def show_paint(browser, name):
    browser.value_of(f"""(() => {{ const choice = document.querySelector(".switches select");
        choice.value = {paint_names(browser).index(name)}; choice.dispatchEvent(new Event("change")); }})()""")


def place_of(browser, site):
    """Of a site of the map, in the window."""
    return browser.value_of(f"""(() => {{ const {{page, map}} = sightlineReport; const box = map.getContainer().getBoundingClientRect();
        const at = map.latLngToContainerPoint([page.sites.y_m[{site}], page.sites.x_m[{site}]]);
        return {{x: box.x + at.x, y: box.y + at.y}}; }})()""")


def check_phone(browser):
    """The verdict and a good part of the map are seen without scrolling; the map stays above the chosen place."""
    seen = browser.value_of("""[".overall", ".map-view"].map((name) => {
        const box = document.querySelector(name).getBoundingClientRect(); return Math.min(box.bottom, innerHeight) - Math.max(box.top, 0); })""")
    assert min(seen) > 200, seen
    browser.value_of('document.getElementById("site-title").scrollIntoView({behavior: "instant", block: "center"})')
    box = browser.value_of('(() => { const box = document.querySelector(".map-view").getBoundingClientRect(); return [box.top, box.bottom]; })()')
    assert 0 <= box[0] < 5 and 250 < box[1] < 500, box
    browser.value_of('window.scrollTo({top: 0, behavior: "instant"})')


def check_first_screen(browser):
    """The verdict, all of the route and the chosen place are seen without scrolling."""
    seen = browser.value_of("""Object.fromEntries([".overall", ".map-view", ".site-panel"].map((name) => {
        const box = document.querySelector(name).getBoundingClientRect();
        return [name, [Math.min(box.bottom, innerHeight) - Math.max(box.top, 0), box.width]]; }))""")
    for name, (height, width) in seen.items():
        assert height > 200 and width > 240, seen
    assert browser.value_of("""(() => { const {page, map} = sightlineReport; const shown = map.getBounds();
        return Array.from(page.sites.x_m).every((x_m, i) => shown.contains([page.sites.y_m[i], x_m])); })()""")


def check_sticky(browser):
    """The map stays in the window while the chosen place is scrolled."""
    browser.value_of('window.scrollTo({top: 500, behavior: "instant"})')
    box = browser.value_of('(() => { const box = document.querySelector(".map-view").getBoundingClientRect(); return [box.top, box.bottom, innerHeight]; })()')
    assert 0 <= box[0] and box[1] <= box[2], box
    browser.value_of('window.scrollTo({top: 0, behavior: "instant"})')


def check_hover(browser):
    at = place_of(browser, 60)
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", **at)
    browser.wait_for('document.querySelector(".answer-tip") !== null')
    words = browser.value_of('document.querySelector(".answer-tip").textContent')
    assert re.match(r"Site (59|60|61), ", words) and "within 10 cm: " in words and "predicted error" in words, words
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=at["x"], y=at["y"] + 60)
    browser.wait_for('document.querySelector(".answer-tip") === null')


def check_wheel(browser):
    """The wheel scrolls the page; once the map has the focus it zooms."""
    at = place_of(browser, 60)
    zoom = "sightlineReport.map.getZoom()"
    before = browser.value_of(zoom)
    browser.value_of("(() => { const {map} = sightlineReport; window.viewBefore = [map.getCenter(), map.getZoom()]; })()")
    browser.call("Input.dispatchMouseEvent", type="mouseWheel", deltaX=0, deltaY=120, **at)
    browser.wait_for("scrollY > 0")
    assert browser.value_of(zoom) == before
    browser.value_of('window.scrollTo({top: 0, behavior: "instant"})')
    browser.value_of('document.querySelector(".map-view").focus({preventScroll: true})')
    browser.call("Input.dispatchMouseEvent", type="mouseWheel", deltaX=0, deltaY=-120, **at)
    browser.wait_for(f"{zoom} > {before}")
    browser.value_of("document.activeElement.blur()")
    browser.wait_for("!sightlineReport.map._animatingZoom")
    browser.value_of("sightlineReport.map.setView(...window.viewBefore, {animate: false}) && 0")


def colour_at(browser, site):
    """Of the route, as it is drawn over the surface's layer."""
    return browser.value_of(f"""(() => {{ const {{page, map}} = sightlineReport;
        const at = map.latLngToContainerPoint([page.sites.y_m[{site}], page.sites.x_m[{site}]]);
        const box = map.getContainer().getBoundingClientRect();
        for (const canvas of [...document.querySelectorAll(".map-view canvas")].reverse()) {{
          const tile = canvas.getBoundingClientRect();
          const [x, y] = [box.x + at.x - tile.x, box.y + at.y - tile.y].map((each) => Math.floor(each * canvas.width / tile.width));
          if (x < 0 || y < 0 || x >= canvas.width || y >= canvas.height) continue;
          const copy = new OffscreenCanvas(1, 1).getContext("2d", {{willReadFrequently: true}});
          copy.drawImage(canvas, x, y, 1, 1, 0, 0, 1, 1);
          const pixel = [...copy.getImageData(0, 0, 1, 1).data];
          if (pixel[3] === 255) return pixel.slice(0, 3);
        }}
        return null; }})()""")


def check_error_colours(browser):
    """Blue up to the limit, orange to red above it."""
    show_paint(browser, "predicted error (cm)")
    browser.wait_for('!document.querySelector(".leaflet-tile:not(.leaflet-tile-loaded)")')
    errors_m, limit_m = browser.value_of("""(() => { const {page} = sightlineReport; const ranges = page.ranges_m.length;
        return [Array.from({length: page.sites.count}, (_, site) =>
            page.predicted.mean_m[site * ranges + page.choice.range_index[site * page.limits_m.length]]), page.limits_m[0]]; })()""")
    order = sorted(range(2, len(errors_m) - 2), key=lambda site: errors_m[site])
    for site in (order[0], order[-1]):
        if any((errors_m[near] > limit_m) != (errors_m[site] > limit_m) for near in (site - 1, site + 1)):
            continue  # beside another hue
        red, _, blue = colour_at(browser, site)
        assert (red > blue) == (errors_m[site] > limit_m), (site, errors_m[site], red, blue)


def check_layers(browser, has_surface):
    names = paint_names(browser)
    assert names[0] == "answer" and {"kind of place", "protection level, forward (m)"} <= set(names), names
    on = browser.value_of('[...document.querySelectorAll(".more-switches input[type=checkbox]")].map((each) => [each.parentElement.textContent.trim(), each.checked])')
    assert ["NDs", False] in on and ["route", True] in on and (not has_surface or ["surface", True] in on), on


def check_download(browser, count):
    text = browser.value_of("""(async () => { let saved; const make = URL.createObjectURL; const click = HTMLAnchorElement.prototype.click;
        URL.createObjectURL = (blob) => { saved = blob; return make(blob); };
        HTMLAnchorElement.prototype.click = function () {};
        document.querySelector("button.download").click();
        [URL.createObjectURL, HTMLAnchorElement.prototype.click] = [make, click];
        return saved.text(); })()""")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == count and [int(row["site"]) for row in rows] == list(range(count))
    assert all(row["answer_10cm"] and float(row["predicted_error_m_10cm"]) > 0 and row["place_kind"] for row in rows), rows[0]


def check_typical(browser):
    """The place that is shown first has a predicted error of the middle of all places."""
    shown, errors_m = browser.value_of("""(() => { const {page} = sightlineReport; const limits = page.limits_m.length;
        return [Number(document.getElementById("site-title").textContent.slice(5)),
            Array.from({length: page.sites.count}, (_, site) => page.answers.mean_m[site * limits])]; })()""")
    rank = sorted(errors_m).index(errors_m[shown]) / len(errors_m)
    assert 0.25 < rank < 0.75, (shown, rank)


def check_map(browser, has_surface):
    """All of it, on a page whose map lies within its window and whose first place was not changed."""
    check_typical(browser)
    check_first_screen(browser)
    check_sticky(browser)
    check_layers(browser, has_surface)
    check_hover(browser)
    check_wheel(browser)
    check_error_colours(browser)
    check_download(browser, browser.value_of("sightlineReport.page.sites.count"))
