// The figures along the route, of the sites that a drive judged.

import { drawChart, drawVertical } from "./charts.js";
import { css } from "./colours.js";
import { chosenByRule, rangeCount } from "./data.js";
import { selection, select } from "./selection.js";

const limitText = (limit_m) => `${+(100 * limit_m).toPrecision(6)} cm`;
const limitColours = ["blue", "orange", "green"];

// Indices of judged sites with null where the drive has a gap.
function routeOrder(page) {
  const order = [];
  page.judged.site.forEach((site, i) => {
    const before = page.judged.site[i - 1];
    if (i > 0 && (before + 1 !== site || page.sites.run[before] !== page.sites.run[site])) order.push(null);
    order.push(i);
  });
  return order;
}

function alongRoute(page) {
  const order = routeOrder(page);
  const xs = order.map((i, at) => page.sites.route_m[page.judged.site[i ?? order[at + 1]]] - (i === null ? 0.01 : 0));
  const values = (valueOf) => order.map((i) => (i === null ? null : valueOf(i)));
  return { order, xs, values };
}

function routeChart(page, parent, along, spec) {
  drawChart(parent, {
    xLabel: "way along the route (m)", isRoute: true, xs: along.xs,
    overlay: (u) => { if (selection.site !== null) drawVertical(u, page.sites.route_m[selection.site], css("ink"), [4, 4]); },
    pick: (index) => { const i = along.order[index]; if (i !== null) select(page.judged.site[i]); },
    ...spec,
  });
}

function help(parent) {
  const words = document.createElement("p");
  words.className = "chart-help";
  words.textContent = "Drag to look closer, double-click to see all, click to show the site; with the keyboard: left, right, Enter.";
  parent.append(words);
}

const timeOf = (page, i, range) => page.judged.time_ms[i * rangeCount(page) + range];
const errorOf = (page, i, range) => page.judged.error_m[i * rangeCount(page) + range];

function errorAlong(page, parent) {
  const along = alongRoute(page);
  routeChart(page, parent, along, {
    title: "Localization error along the route for every range", yLabel: "localization error (cm)", height: 340,
    lines: page.ranges_m.map((range_m, range) => ({
      label: `${range_m} m`, colour: () => css(`range-${range}`), width: 1.2,
      ys: along.values((i) => 100 * errorOf(page, i, range)),
    })),
  });
  help(parent);
}

function idealRange(page, parent) {
  const along = alongRoute(page);
  routeChart(page, parent, along, {
    title: "Shortest range that meets each limit", yLabel: "observation range (m)", height: 260,
    lines: page.limits_m.map((limit_m, limit) => ({
      label: limitText(limit_m), colour: () => css(limitColours[limit % 3]), isStepped: true, decimals: 0,
      dash: limit === 1 ? [6, 4] : undefined,
      ys: along.values((i) => page.ranges_m[chosenByRule(page, "oracle", limit, i)]),
    })),
  });
}

function timeLine(page, along, rule, limit, label, colour) {
  return { label, colour: () => css(colour), decimals: 2,
    ys: along.values((i) => timeOf(page, i, chosenByRule(page, rule, limit, i))) };
}

const longestText = (page) => `static ${page.ranges_m.at(-1)} m`;

function idealTime(page, parent) {
  const along = alongRoute(page);
  routeChart(page, parent, along, {
    title: "Matching time, static and ideal", yLabel: "matching time (ms)", height: 300,
    lines: [timeLine(page, along, "static-longest", 0, longestText(page), "grey"),
      ...page.limits_m.map((limit_m, limit) =>
        timeLine(page, along, "oracle", limit, `dynamic, ${limitText(limit_m)}`, limitColours[limit % 3]))],
  });
}

// Stretches of the route where the map's range missed the limit.
function misses(page, limit) {
  const half = page.site_spacing_m / 2;
  const bands = [];
  page.judged.site.forEach((site, i) => {
    if (errorOf(page, i, chosenByRule(page, "map", limit, i)) <= page.limits_m[limit]) return;
    const from = page.sites.route_m[site] - half;
    if (bands.length > 0 && from - bands.at(-1)[1] < half / 2) bands.at(-1)[1] = from + 2 * half;
    else bands.push([from, from + 2 * half]);
  });
  return bands;
}

function choice(page, parent, limit) {
  const along = alongRoute(page);
  const limitWords = limitText(page.limits_m[limit]);
  routeChart(page, parent, along, {
    title: "Matching time, static and with this map", yLabel: "matching time (ms)", height: 240,
    lines: [timeLine(page, along, "static-longest", 0, longestText(page), "grey"),
      timeLine(page, along, "map", limit, `this map, ${limitWords}`, "blue")],
  });
  routeChart(page, parent, along, {
    title: "Selected ranges", yLabel: "selected range (m)", height: 240, bands: misses(page, limit),
    lines: [{ label: `selected range (bars: error above ${limitWords})`, colour: () => css("blue"), isStepped: true, decimals: 0,
      ys: along.values((i) => page.ranges_m[chosenByRule(page, "map", limit, i)]) }],
  });
  help(parent);
}

const drawings = {
  "error-along": errorAlong, "ideal-range": idealRange, "ideal-time": idealTime,
};

// Draws a figure when it comes near the window.
function drawWhenNear(figure, draw) {
  const place = figure.querySelector(".live");
  const observer = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    figure.classList.add("is-live");
    draw(place);
  }, { rootMargin: "600px" });
  observer.observe(figure);
}

export function drawFigures(page) {
  if (!page.judged) return;
  for (const place of document.querySelectorAll(".live[data-drawing]")) {
    const name = place.dataset.drawing;
    const figure = place.closest("figure");
    if (drawings[name]) drawWhenNear(figure, (parent) => drawings[name](page, parent));
    const limit = /^choice-(\d+)$/.exec(name);
    if (limit) drawWhenNear(figure, (parent) => choice(page, parent, Number(limit[1])));
  }
}
