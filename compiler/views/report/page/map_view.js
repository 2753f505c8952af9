// The map from above: surface, NDs, what was removed, and the route coloured by a number that a switch
// chooses. Map metres are Leaflet's units: latitude is y, longitude is x.

import L from "leaflet";
import { css, onTheme } from "./colours.js";
import { layersOf } from "./map_layers.js";
import { paintsOf } from "./route_paint.js";
import { onSelect, select } from "./selection.js";

function element(kind, members, ...children) {
  const made = Object.assign(document.createElement(kind), members);
  made.append(...children);
  return made;
}

// Sites by coarse cell, so that the nearest is found without asking all.
function siteFinder(sites) {
  const cell_m = 16;
  const cells = new Map();
  const key = (column, row) => `${column},${row}`;
  for (let i = 0; i < sites.count; ++i) {
    const at = key(Math.floor(sites.x_m[i] / cell_m), Math.floor(sites.y_m[i] / cell_m));
    if (!cells.has(at)) cells.set(at, []);
    cells.get(at).push(i);
  }
  const within = (x_m, y_m, reach) => {
    const found = [];
    const [column, row] = [Math.floor(x_m / cell_m), Math.floor(y_m / cell_m)];
    for (let i = column - reach; i <= column + reach; ++i) {
      for (let j = row - reach; j <= row + reach; ++j) found.push(...(cells.get(key(i, j)) ?? []));
    }
    return found;
  };
  return {
    inBox: (low_x_m, low_y_m, high_x_m, high_y_m) => {
      const found = [];
      if (((high_x_m - low_x_m) * (high_y_m - low_y_m)) / cell_m ** 2 > sites.count) {
        for (let i = 0; i < sites.count; ++i) {
          if (sites.x_m[i] >= low_x_m && sites.x_m[i] <= high_x_m && sites.y_m[i] >= low_y_m && sites.y_m[i] <= high_y_m) found.push(i);
        }
        return found;
      }
      for (let i = Math.floor(low_x_m / cell_m); i <= Math.floor(high_x_m / cell_m); ++i) {
        for (let j = Math.floor(low_y_m / cell_m); j <= Math.floor(high_y_m / cell_m); ++j) found.push(...(cells.get(key(i, j)) ?? []));
      }
      return found.sort((a, b) => a - b);
    },
    nearest: (x_m, y_m) => {
      let candidates = [];
      for (let reach = 1; candidates.length === 0 && reach < 64; reach *= 2) candidates = within(x_m, y_m, reach);
      let best = null;
      let bestApart = Infinity;
      for (const i of candidates) {
        const apart = Math.hypot(sites.x_m[i] - x_m, sites.y_m[i] - y_m);
        if (apart < bestApart) [best, bestApart] = [i, apart];
      }
      return best;
    },
  };
}

function switchOf(label, choices, onChange) {
  const select = element("select", {}, ...choices.map(([value, words]) => element("option", { value, textContent: words })));
  select.addEventListener("change", () => onChange(select.value));
  return element("label", { textContent: `${label} ` }, select);
}

function checkOf(label, isOn, onChange) {
  const box = element("input", { type: "checkbox", checked: isOn });
  box.addEventListener("change", () => onChange(box.checked));
  return element("label", {}, box, ` ${label}`);
}

function boundsOf(sites) {
  const bounds = L.latLngBounds([]);
  for (let i = 0; i < sites.count; ++i) bounds.extend([sites.y_m[i], sites.x_m[i]]);
  return bounds.pad(0.08);
}

function drawSwitches(page, parent, map, layers, show) {
  const state = { paint: 0, limit: 0 };
  const paints = paintsOf(page);
  const redraw = () => show(paints[state.paint], state.limit);
  const bar = element("div", { className: "switches" },
    switchOf("Route coloured by", paints.map((paint, i) => [i, paint.name]), (value) => { state.paint = Number(value); redraw(); }),
    switchOf("for a limit of", page.limits_m.map((limit_m, i) => [i, `${+(100 * limit_m).toPrecision(6)} cm`]),
      (value) => { state.limit = Number(value); redraw(); }));
  for (const { label, layer, isOn } of layers) {
    if (isOn) layer.addTo(map);
    bar.append(checkOf(label, isOn, (isWanted) => (isWanted ? layer.addTo(map) : layer.remove())));
  }
  parent.prepend(bar);
  redraw();
}

export function drawMap(page, place) {
  const view = element("div", { className: "map-view" });
  view.setAttribute("aria-label", "The map from above. Arrow keys move it, plus and minus zoom.");
  const legend = element("div", { className: "legend map-legend" });
  place.append(view, legend);
  const map = L.map(view, {
    crs: L.CRS.Simple, minZoom: -6, maxZoom: 6, zoomSnap: 0.5, zoomDelta: 1, attributionControl: false, preferCanvas: false,
    fadeAnimation: false,
  });
  L.control.scale({ imperial: false }).addTo(map);
  const finder = siteFinder(page.sites);
  const bounds = boundsOf(page.sites);
  map.fitBounds(bounds);
  const ndKeys = element("div", { className: "legend" }, "NDs:", ...[["blue", "standing planes"], ["grey", "lying planes"], ["orange", "lines"], ["green", "volumes"]].map(
    ([name, words]) => { const key = element("i", {}); key.style.background = `var(--${name})`; return element("span", {}, key, words); }));
  place.append(ndKeys);
  const { layers, route } = layersOf(page, finder);
  drawSwitches(page, place, map, layers, (paint, limit) => {
    route.paint = () => paint.colours(limit);
    route.redraw();
    legend.replaceChildren(paint.legend(limit));
  });
  onTheme(() => { for (const { layer } of layers) layer.redraw(); });
  const mark = L.marker([0, 0], { icon: L.divIcon({ className: "site-mark", iconSize: [18, 18] }), interactive: false, keyboard: false });
  onSelect((site) => {
    const at = L.latLng(page.sites.y_m[site], page.sites.x_m[site]);
    mark.setLatLng(at).addTo(map);
    if (!map.getBounds().contains(at)) map.panTo(at);
  });
  map.on("click", (event) => {
    const site = finder.nearest(event.latlng.lng, event.latlng.lat);
    if (site !== null) select(site);
  });
  new ResizeObserver(() => map.invalidateSize()).observe(view);
  return map;
}
