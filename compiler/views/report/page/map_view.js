// The map from above: surface, NDs, what was removed, and the route coloured by a number that a switch
// chooses. Map metres are Leaflet's units: latitude is y, longitude is x.

import L from "leaflet";
import { onTheme } from "./colours.js";
import { downloadButton } from "./download.js";
import { checkOf, element, limitText, switchOf } from "./elements.js";
import { layersOf } from "./map_layers.js";
import { showAnswers } from "./map/answer_tip.js";
import { drawInset } from "./map/pointed_inset.js";
import { firstPaint, paintsOf } from "./route_paint.js";
import { onPoint, onSelect, select } from "./selection.js";
import { siteFilter } from "./map/site_filter.js";
import { siteFinder } from "./map/site_finder.js";
import { siteSearch } from "./map/site_search.js";

const farthestZoom = -11;  // 2 km a pixel: any route fits on a phone
const foundZoom = 2;       // 4 pixels a metre, of a site that was searched for

function boundsOf(sites) {
  const bounds = L.latLngBounds([]);
  for (let i = 0; i < sites.count; ++i) bounds.extend([sites.y_m[i], sites.x_m[i]]);
  return bounds.pad(0.05);
}

// The switches over the map. show(paint, limit) draws the route anew.
function drawSwitches(page, filter, show) {
  const paints = paintsOf(page);
  const state = { paint: firstPaint(page, paints), limit: 0 };
  const redraw = () => show(paints[state.paint], state.limit);
  const paint = switchOf("Route coloured by", paints.map((each, i) => [i, each.name]), (value) => { state.paint = Number(value); redraw(); });
  paint.querySelector("select").value = state.paint;
  const limit = switchOf("for a limit of", page.limits_m.map((limit_m, i) => [i, limitText(limit_m)]),
    (value) => { state.limit = Number(value); filter.limit(state.limit); redraw(); });
  redraw();
  return { bar: element("div", { className: "switches" }, paint, limit), limit: () => state.limit };
}

function layerSwitches(map, layers) {
  const bar = element("div", { className: "switches" });
  for (const { label, layer, isOn } of layers) {
    if (isOn) layer.addTo(map);
    bar.append(checkOf(label, isOn, (isWanted) => (isWanted ? layer.addTo(map) : layer.remove())));
  }
  return bar;
}

// The wheel scrolls the page until the map has the focus.
function zoomWhileFocused(map) {
  const view = map.getContainer();
  view.addEventListener("focusin", () => map.scrollWheelZoom.enable());
  view.addEventListener("focusout", () => map.scrollWheelZoom.disable());
}

const markOf = (name, size) => L.marker([0, 0],
  { icon: L.divIcon({ className: name, iconSize: [size, size] }), interactive: false, keyboard: false });

// One mark for the site that is shown, one for the site that a chart is pointed at.
function drawMarks(page, map) {
  const at = (site) => L.latLng(page.sites.y_m[site], page.sites.x_m[site]);
  const shown = markOf("site-mark", 18);
  onSelect((site) => {
    shown.setLatLng(at(site)).addTo(map);
    // The ends of a route that fills the map lie inside this: the page opens with all of it.
    if (!map.getBounds().pad(-0.03).contains(at(site))) map.panTo(at(site));
  });
  const pointed = markOf("pointed-mark", 14);
  onPoint((site) => {
    if (site === null) pointed.remove();
    else pointed.setLatLng(at(site)).addTo(map);
  });
  return (site) => map.setView(at(site), Math.max(map.getZoom(), foundZoom), { animate: false });
}

function ndKeys() {
  const kinds = [["blue", "vertical planes"], ["grey", "horizontal planes"], ["orange", "lines"], ["green", "volumes"]];
  return element("div", { className: "legend" }, "NDs (normal distributions of points):", ...kinds.map(([name, words]) => {
    const key = element("i", {});
    key.style.background = `var(--${name})`;
    return element("span", {}, key, words);
  }));
}

export function drawMap(page, place) {
  const view = element("div", { className: "map-view" });
  view.setAttribute("role", "region");
  view.setAttribute("aria-label", "The map from above. Arrow keys move it, plus and minus zoom.");
  const legend = element("div", { className: "legend map-legend" });
  place.append(view, legend);
  const map = L.map(view, {
    crs: L.CRS.Simple, minZoom: farthestZoom, maxZoom: 6, zoomSnap: 0.25, zoomDelta: 1, attributionControl: false,
    preferCanvas: false, fadeAnimation: false, scrollWheelZoom: false,
  });
  L.control.scale({ imperial: false }).addTo(map);
  map.fitBounds(boundsOf(page.sites));
  const finder = siteFinder(page.sites);
  const { layers, route } = layersOf(page, finder);
  const filter = siteFilter(page, () => route.redraw());
  route.filter = filter;
  let drawLegend = () => {};
  const { bar, limit } = drawSwitches(page, filter, (paint, limit) => {
    route.paint = () => paint.colours(limit);
    route.redraw();
    drawLegend = () => legend.replaceChildren(paint.legend(limit));
    drawLegend();
  });
  const goTo = drawMarks(page, map);
  place.prepend(bar, element("details", { className: "more-switches" }, element("summary", { textContent: "Layers, filter, search, download" }),
    layerSwitches(map, layers), element("div", { className: "switches" }, filter.bar, siteSearch(page, finder, goTo)),
    element("div", { className: "switches" }, downloadButton(page)), ndKeys()));
  onTheme(() => {
    for (const { layer } of layers) layer.redraw();
    drawLegend();
  });
  map.on("click", (event) => select(finder.nearest(event.latlng.lng, event.latlng.lat).site));
  showAnswers(page, map, finder, limit);
  zoomWhileFocused(map);
  new ResizeObserver(() => map.invalidateSize()).observe(view);
  drawInset(page, view);
  return map;
}
