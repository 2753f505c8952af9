"""The 3D view of a page: what it draws is what `sightline dump` contains, and it says so where nothing can be drawn."""

import csv
import itertools
import math
import re
import subprocess

from chromium import READY

REACH_M = 40
SCENE = "sightlineReport.scene"


def nds_of(sightline, map_file):
    text = subprocess.run([sightline, "dump", str(map_file), "--what", "nds", "--format", "csv"], check=True, text=True,
                          stdout=subprocess.PIPE).stdout
    rows = csv.DictReader(row for row in text.splitlines() if not row.startswith("#"))
    return [{name: float(value) for name, value in row.items()} for row in rows]


def open_scene(browser, site):
    browser.value_of(f"sightlineReport.select({site})")
    browser.value_of('(() => { const view = document.querySelector(".nd-view"); if (!view.open) view.querySelector("summary").click(); })()')
    browser.wait_for(f'document.querySelector(".nd-view").dataset.site === "{site}"')


def check_perpendicular(axes_m):
    for a, b in itertools.combinations(axes_m, 2):
        lengths_m2 = math.hypot(*a) * math.hypot(*b)
        assert abs(sum(x * y for x, y in zip(a, b))) < 1e-3 * lengths_m2, axes_m


def ellipsoids(browser):
    """Of each instance its place from the site and the covariance that its half axes stand for."""
    matrices = browser.value_of(f"[...{SCENE}.shown.nds.instanceMatrix.array]")
    found = []
    for begin in range(0, len(matrices), 16):
        columns = [matrices[begin + 4 * column: begin + 4 * column + 3] for column in range(4)]
        check_perpendicular(columns[:3])
        found.append((columns[3], {a + b: sum(column["xyz".index(a)] * column["xyz".index(b)] for column in columns[:3]) / 4
                                   for a, b in ("xx", "xy", "xz", "yy", "yz", "zz")}))
    return found


def check_shapes(browser, nds, site):
    """Every ND near the site is drawn; one in five is compared: where it is, and its covariance."""
    here_m = [browser.value_of(f"sightlineReport.page.sites.{axis}_m[{site}]") for axis in "xyz"]
    off_m = [[nd[f"mean_{axis}_m"] - here_m[i] for i, axis in enumerate("xyz")] for nd in nds]
    near = [i for i, place_m in enumerate(off_m) if math.hypot(*place_m[:2]) < REACH_M + 0.01]
    drawn = ellipsoids(browser)
    surely = sum(math.hypot(*off_m[i][:2]) < REACH_M - 0.01 for i in near)
    assert 100 < surely <= len(drawn) <= len(near), (surely, len(drawn), len(near))
    words = browser.value_of('document.querySelector(".nd-view").textContent')
    assert f"{len(drawn)} NDs within {REACH_M} m" in words, words
    assert sum(map(int, re.findall(r"(?:planes|lines|volumes): (\d+)", words))) == len(drawn), words
    for place_m, covariance_m2 in drawn[::5]:
        nearest = min(near, key=lambda i: math.dist(off_m[i], place_m))
        nd = nds[nearest]
        assert math.dist(off_m[nearest], place_m) < 0.02, (nd, place_m)
        # Correlations are in steps of 1/127 and turns of pi/256; axes below 1 cm are drawn with 1 cm.
        spread_m2 = nd["cov_xx_m2"] + nd["cov_yy_m2"] + nd["cov_zz_m2"]
        for name, value_m2 in covariance_m2.items():
            assert abs(value_m2 - nd[f"cov_{name}_m2"]) < 0.015 * spread_m2 + 1e-4, (name, value_m2, nd)


def picture(browser):
    """Colours of the view's pixels, and how many are not its background."""
    return browser.value_of(f"""(() => {{ const canvas = document.querySelector(".nd-region canvas"); {SCENE}.drawNow();
        const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", {{willReadFrequently: true}});
        copy.drawImage(canvas, 0, 0);
        const pixels = new Uint32Array(copy.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        let sum = 0; pixels.forEach((pixel, i) => {{ sum = (sum + (i % 9973) * (pixel % 9973)) % 1e9; }});
        return {{colours: new Set(pixels).size, share: pixels.filter((pixel) => pixel !== 0).length / pixels.length, sum}}; }})()""")


def check_keys(browser):
    """Arrows, plus and minus move the camera, from the keyboard alone."""
    browser.value_of('document.querySelector(".nd-region").focus()')
    seen = [picture(browser)["sum"]]
    for key, code in (("ArrowLeft", 37), ("ArrowUp", 38), ("+", 187)):
        browser.press(key, code)
        seen.append(picture(browser)["sum"])
    assert len(set(seen)) == len(seen), seen
    browser.value_of("document.activeElement.blur()")


def check_scene(browser, sightline, map_file):
    assert browser.value_of(f"!document.querySelector('.nd-view').open && {SCENE} === undefined && window.sightlineScene === undefined")
    nds = nds_of(sightline, map_file)
    for site in (30, 110):
        open_scene(browser, site)
        check_shapes(browser, nds, site)
    seen = picture(browser)
    assert seen["colours"] > 100 and 0.2 < seen["share"] < 1, seen
    check_keys(browser)
    shown_m = browser.value_of(f"Math.hypot(...{SCENE}.shown.ring.geometry.attributes.position.array.slice(0, 2))")
    assert f"Ring: {shown_m:.0f} m" in browser.value_of('document.querySelector(".nd-view").textContent'), shown_m
    has_depth = browser.value_of("Boolean(sightlineReport.page.depth)")
    assert (browser.value_of(f"{SCENE}.shown.returns.geometry.attributes.position.count") > 100) == has_depth


def check_no_scene(browser, page):
    """Without NDs there is no view; without WebGL there is a sentence."""
    bare = page.with_name(f"{page.stem}_without_nds.html")
    text = re.sub(r'"tiles":\[\{[^\]]*?"place_m".*?\}\]', '"tiles":[]', page.read_text(), count=1)
    assert text != page.read_text()
    bare.write_text(text)
    browser.new_window(1280, 900)
    browser.open(bare.as_uri(), READY)
    assert browser.value_of('document.querySelector(".nd-view") === null && document.getElementById("site-title") !== null')
    bare.unlink()
    browser.new_window(1280, 900)
    browser.call("Page.addScriptToEvaluateOnNewDocument", source="""(() => { const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind.startsWith("webgl") ? null : get.call(this, kind, ...more); }; })()""")
    browser.open(page.as_uri(), READY)
    browser.value_of('document.querySelector(".nd-view > summary").click()')
    browser.wait_for('document.querySelector(".nd-view").textContent.includes("This browser has no WebGL")')
    assert browser.complaints == [], browser.complaints
