// The NDs around the chosen place in 3D, closed at first: the script that draws them (scene/) is unpacked when it is opened.

import { answerAt } from "./answers.js";
import { css, onTheme } from "./colours.js";
import { depthOfSite, directionAt, inflate, numbers } from "./data.js";
import { element, limitText } from "./elements.js";
import { legendOf } from "./legends.js";
import { kindColours, tileFinder } from "./map_layers.js";
import { onSelect, selection } from "./selection.js";

const reach_m = 40;  // of the NDs from the site, from above
const kindWords = [[4, "ground and other horizontal planes"], [2, "walls and other vertical planes"], [1, "lines"], [3, "volumes"]];
const keyTurn_rad = Math.PI / 24;
const keyMoves = {
  ArrowLeft: (scene) => scene.turn(-keyTurn_rad, 0), ArrowRight: (scene) => scene.turn(keyTurn_rad, 0),
  ArrowUp: (scene) => scene.turn(0, -keyTurn_rad), ArrowDown: (scene) => scene.turn(0, keyTurn_rad),
  "+": (scene) => scene.zoom(0.8), "-": (scene) => scene.zoom(1.25),
};

const placeOf = ({ sites }, site) => [sites.x_m[site], sites.y_m[site], sites.z_m[site]];

// p_m of each from the site.
async function ndsOfTile(nds, tile, [x_m, y_m, z_m]) {
  const names = ["place_m", "height", "radius", "turn", "rise", "tilt", "kind"];
  const [place, height, radius, turn, rise, tilt, kind] = await Promise.all(names.map((name) => numbers(tile[name])));
  const found = [];
  for (let i = 0; i < tile.count; ++i) {
    const p_m = [(tile.x + place[2 * i] / 65535) * nds.tile_m - x_m, (tile.y + place[2 * i + 1] / 65535) * nds.tile_m - y_m,
      nds.lowest_z_m + height[i] / 100 - z_m];
    if (Math.hypot(p_m[0], p_m[1]) > reach_m) continue;
    found.push({ p_m, radius_m: [radius[2 * i] / 1000, radius[2 * i + 1] / 1000], turn_rad: (turn[i] * Math.PI) / 256,
      rise_m: rise[i] / 1000, tilt: [tilt[2 * i] / 127 - 1, tilt[2 * i + 1] / 127 - 1], kind: kind[i] });
  }
  return found;
}

async function ndsNear({ nds }, [x_m, y_m, z_m]) {
  const box = { low_x_m: x_m, high_x_m: x_m, low_y_m: y_m, high_y_m: y_m };
  const tiles = tileFinder(nds.tiles, nds.tile_m)(box, reach_m);
  return (await Promise.all(tiles.map((tile) => ndsOfTile(nds, tile, [x_m, y_m, z_m])))).flat();
}

// What the depth image contains within a range, [x, y, z, x, ...] from the site; empty where the page has no depth images.
async function returnsNear(page, site, range_m) {
  if (!page.depth) return [];
  const image = await depthOfSite(page, site);
  const [here_m, there_m] = [placeOf(page, site), placeOf(page, image.site)];
  const returns_m = [];
  image.grey.forEach((grey, i) => {
    const distance_m = (grey / 254) * page.depth.longest_m;
    if (grey === 255 || distance_m > range_m) return;
    const { azimuth_deg, elevation_deg } = directionAt(page.depth, i % image.width, Math.floor(i / image.width));
    const [azimuth, elevation] = [azimuth_deg, elevation_deg].map((angle) => (angle * Math.PI) / 180);
    const ray = [Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)];
    ray.forEach((part, axis) => returns_m.push(there_m[axis] - here_m[axis] + distance_m * part));
  });
  return returns_m;
}

// Of the answer for the first limit.
function rangeOfAnswer(page, site) {
  const { choice, isRange } = answerAt(page, site, 0);
  return isRange ? page.ranges_m[choice] : page.answers.looks_range_m[choice];
}

async function contentOf(page, site) {
  const range_m = rangeOfAnswer(page, site);
  const [nds, returns_m] = await Promise.all([ndsNear(page, placeOf(page, site)), returnsNear(page, site, range_m)]);
  return { nds, returns_m, range_m, heading_rad: page.sites.heading_rad[site] };
}

const rowOfKinds = () => Object.fromEntries(Object.entries(kindColours).map(([kind, name]) => [kind, css(name)]));

function captionOf(page, { nds, returns_m, range_m }) {
  const counts = kindWords.map(([kind, words]) => [kind, words, nds.filter((nd) => nd.kind === kind).length]);
  const lines = [`Ring: ${range_m} m, the range of the answer for ${limitText(page.limits_m[0])}. Cone: the vehicle.`];
  if (returns_m.length > 0) {
    lines.push(`Points: ${returns_m.length / 3} returns of the depth image within that range. The page does not contain which returns the answer keeps.`);
  }
  return [legendOf(`${nds.length} NDs within ${reach_m} m, at two standard deviations:`,
    ...counts.filter(([, , count]) => count > 0).map(([kind, words, count]) => [css(kindColours[kind]), `${words}: ${count}`])),
    ...lines.map((line) => element("p", { className: "reading", textContent: line }))];
}

// The functions of scene/scene.js.
async function unpackedScene() {
  const source = new TextDecoder().decode(await inflate(document.getElementById("scene").textContent));
  document.head.append(element("script", { textContent: `${source};window.sightlineScene = sightlineScene;` }));
  return window.sightlineScene;
}

function answerInput(region, scene) {
  region.addEventListener("keydown", (event) => {
    if (!keyMoves[event.key]) return;
    event.preventDefault();
    keyMoves[event.key](scene);
  });
  // As over the map the wheel scrolls the page until the view has the focus.
  region.addEventListener("pointerdown", () => region.focus({ preventScroll: true }));
  region.addEventListener("focusin", () => scene.letWheelZoom(true));
  region.addEventListener("focusout", () => scene.letWheelZoom(false));
}

async function openView(page, view, region, caption) {
  const canvas = element("canvas", {});
  const scene = (await unpackedScene()).createScene(canvas);
  if (!scene) {
    region.remove();
    caption.textContent = "This browser has no WebGL, which the 3D view needs.";
    return;
  }
  region.append(canvas);
  let content = null;
  const paint = () => {
    if (!content) return;
    scene.paint(rowOfKinds(), { ring: css("ink"), vehicle: css("accent"), returns: css("purple") });
    caption.replaceChildren(...captionOf(page, content));
  };
  const show = async () => {
    const { site } = selection;
    const found = await contentOf(page, site);
    if (selection.site !== site) return;
    content = found;
    scene.show(content);
    paint();
    view.dataset.site = site;
  };
  answerInput(region, scene);
  onSelect(() => view.open && show());
  view.addEventListener("toggle", () => view.open && show());
  await show();
  new ResizeObserver(() => region.clientWidth > 0 && scene.resize(region.clientWidth, region.clientHeight)).observe(region);
  onTheme(paint);
  window.sightlineReport.scene = scene;
}

// Null where the map has no NDs.
export function drawNdView(page) {
  if (page.nds.tiles.length === 0) return null;
  const region = element("div", { className: "nd-region", tabIndex: 0 });
  region.setAttribute("role", "region");
  region.setAttribute("aria-label", "NDs around this site in 3D. Arrow keys turn the view, plus and minus zoom.");
  const caption = element("div", {});
  const view = element("details", { className: "nd-view" }, element("summary", { textContent: "3D view" }), region, caption);
  view.addEventListener("toggle", () => openView(page, view, region, caption), { once: true });
  return view;
}
