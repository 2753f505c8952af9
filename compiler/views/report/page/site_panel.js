// One site: its depth image, error and probability over range, its factors, and the reason for its range.

import { answerAt, answerText, kindOfPlace, protectionOf } from "./answers.js";
import { drawChart, drawHorizontal, drawVertical } from "./charts.js";
import { css, lengthColours } from "./colours.js";
import { chosenRange, depthOfSite, directionAt, measuredError, numbers, predictedError, probability, textOfSite } from "./data.js";
import { button, element, limitText } from "./elements.js";
import { drawNdView } from "./nd_view.js";
import { onSelect, select, selection } from "./selection.js";

const limitColours = ["blue", "orange", "green"];

function drawSteps(page, site) {
  const go = (to) => select(Math.min(Math.max(to, 0), page.sites.count - 1));
  const number = element("input", { type: "number", min: 0, max: page.sites.count - 1, value: site });
  number.setAttribute("aria-label", "Site number");
  number.addEventListener("change", () => go(Number(number.value)));
  const stepBy = (sign, words, step) => button(sign, words, () => {
    go(site + step);
    document.querySelector(`.site-panel button[title="${words}"]`)?.focus();
  });
  return element("div", { className: "steps" }, stepBy("◀◀", "10 sites back", -10), stepBy("◀", "Previous site", -1), number,
    stepBy("▶", "Next site", 1), stepBy("▶▶", "10 sites ahead", 10),
    element("span", { textContent: `of ${page.sites.count}, run ${page.sites.run[site]}, ${page.sites.s_m[site].toFixed(1)} m from its start` }),
    element("span", { textContent: `world: ${placeText(page, site, page.origin_world_m)}; map: ${placeText(page, site, [0, 0, 0])}` }));
}

// "x 641.0, y -62.0, z 1.8 m"
function placeText(page, site, origin_m) {
  const [x, y, z] = [page.sites.x_m, page.sites.y_m, page.sites.z_m].map((of, axis) => (of[site] + origin_m[axis]).toFixed(1));
  return `x ${x}, y ${y}, z ${z} m`;
}

function rangeSpan(page) {
  const margin = page.ranges_m.length > 1 ? 0.3 * (page.ranges_m[1] - page.ranges_m[0]) : 1;
  return [page.ranges_m[0] - margin, page.ranges_m.at(-1) + margin];
}

// Limits across, the chosen ranges upright, each in its limit's colour.
function markLimits(page, site, u) {
  page.limits_m.forEach((limit_m, limit) => {
    drawHorizontal(u, 100 * limit_m, css(limitColours[limit % 3]), [5, 4]);
    drawVertical(u, page.ranges_m[chosenRange(page, site, limit)], css(limitColours[limit % 3]), limit === 0 ? [] : [2, 3]);
  });
}

function drawErrors(page, site, parent) {
  const lines = [{ label: "predicted error (cm)", colour: () => css("soft"), hasPoints: true, width: 2, dash: [6, 4],
    ys: page.ranges_m.map((_, range) => 100 * predictedError(page, site, range)) }];
  if (page.judgedOfSite[site] >= 0) {
    lines.push({ label: "measured error (cm)", colour: () => css("ink"), hasPoints: true, width: 2,
      ys: page.ranges_m.map((_, range) => 100 * measuredError(page, site, range)) });
  }
  return drawChart(parent, {
    title: "Error over range at this site", xLabel: "observation range (m)", yLabel: "localization error (cm)", height: 230,
    xs: page.ranges_m, xRange: rangeSpan(page), xTicks: page.ranges_m, lines, overlay: (u) => markLimits(page, site, u),
  });
}

function drawProbabilities(page, site, parent) {
  return drawChart(parent, {
    title: "Probability of an error within each limit at this site", xLabel: "observation range (m)", yLabel: "P(error within the limit)", height: 230, greatest: 1.02,
    xs: page.ranges_m, xRange: rangeSpan(page), xTicks: page.ranges_m,
    lines: page.limits_m.map((limit_m, limit) => ({ label: `P(error ≤ ${limitText(limit_m)})`, colour: () => css(limitColours[limit % 3]), hasPoints: true, width: 2, decimals: 3,
      ys: page.ranges_m.map((_, range) => probability(page, site, range, limit)) })),
    overlay: (u) => page.limits_m.forEach((_, limit) => {
      if (page.thresholds[limit] > 0) drawHorizontal(u, page.thresholds[limit], css(limitColours[limit % 3]), [5, 4]);
      drawVertical(u, page.ranges_m[chosenRange(page, site, limit)], css(limitColours[limit % 3]), limit === 0 ? [] : [2, 3]);
    }),
  });
}

// A line where the vehicle looks ahead.
function markAhead(page, site, canvas) {
  const turn = ((Math.PI - page.sites.heading_rad[site]) / (2 * Math.PI)) * canvas.width;
  const column = ((Math.floor(turn) % canvas.width) + canvas.width) % canvas.width;
  const context = canvas.getContext("2d");
  context.fillStyle = css("orange");
  context.fillRect(column, 0, 1, canvas.height);
}

// In the colours that the route has where a range is as long.
function paintDepth(page, image, canvas) {
  const colourAt = lengthColours(page.ranges_m);
  const colours = Array.from({ length: 255 }, (_, grey) => colourAt((grey / 254) * page.depth.longest_m));
  const nothing = css("line");
  canvas.width = image.width;
  canvas.height = image.height;
  const context = canvas.getContext("2d");
  for (let row = 0; row < image.height; ++row) {
    for (let column = 0; column < image.width; ++column) {
      const grey = image.grey[row * image.width + column];
      context.fillStyle = grey === 255 ? nothing : colours[grey];
      context.fillRect(column, row, 1, 1);
    }
  }
}

async function drawDepth(page, site, parent) {
  const image = await depthOfSite(page, site);
  if (selection.site !== site) return;
  const canvas = element("canvas", { className: "depth" });
  canvas.style.aspectRatio = `${image.width} / ${2 * image.height}`;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `Depth image of site ${image.site}`);
  const reading = element("div", { className: "reading", textContent: "Point at the image to read a distance." });
  paintDepth(page, image, canvas);
  markAhead(page, site, canvas);
  canvas.addEventListener("mousemove", (event) => {
    const box = canvas.getBoundingClientRect();
    const column = Math.min(Math.floor(((event.clientX - box.left) / box.width) * image.width), image.width - 1);
    const row = Math.min(Math.floor(((event.clientY - box.top) / box.height) * image.height), image.height - 1);
    const grey = image.grey[row * image.width + column];
    const { azimuth_deg, elevation_deg } = directionAt(page.depth, column, row);
    reading.textContent = `${azimuth_deg.toFixed(0)}° from +x, ${elevation_deg.toFixed(0)}° above the horizon: ${grey === 255 ? `no surface within ${page.depth.longest_m} m` : `${((grey / 254) * page.depth.longest_m).toFixed(1)} m`}`;
  });
  const colourAt = lengthColours(page.ranges_m);
  const bar = element("span", { className: "ramp" });
  bar.style.background = `linear-gradient(to right, ${Array.from({ length: 9 }, (_, i) => colourAt((i / 8) * page.depth.longest_m)).join(",")})`;
  parent.append(element("h3", { textContent: image.site === site ? "Depth image of this site" : `Depth image of site ${image.site}, the nearest that has one` }), canvas,
    element("div", { className: "depth-words" }, ...["−x", "+y", "+x", "−y", "−x"].map((words) => element("span", { textContent: words }))),
    element("div", { className: "reading" }, "0 m", bar, `${page.depth.longest_m} m; grey: no surface within range; orange line: direction of travel; colours as those of the ranges on the map`), reading);
}

async function drawFactors(page, site, parent) {
  const [values, median, deviation] = await Promise.all([page.factors.values, page.factors.median, page.factors.deviation].map(numbers));
  if (selection.site !== site) return;
  const count = page.factors.names.length;
  const body = element("tbody", {});
  const fill = (range) => {
    body.replaceChildren(...page.factors.names.map((name, factor) => {
      const value = values[(site * page.ranges_m.length + range) * count + factor];
      const [middle, spread] = [median[range * count + factor], deviation[range * count + factor]];
      const z = spread > 0 ? (0.6745 * (value - middle)) / spread : 0;
      const isDirection = name.endsWith("_heading");
      const bar = element("span", { className: "bar" });
      bar.style.width = `${Math.min(Math.abs(z), 6) * 0.6}rem`;
      bar.style.background = css(z < 0 ? "blue" : "orange");
      const cell = element("td", { className: "zcell" });
      if (!isDirection) cell.append(bar, ` ${z >= 0 ? "+" : "−"}${Math.abs(z).toFixed(1)}`);
      return element("tr", {}, element("th", { scope: "row", title: name, textContent: page.factors.words[factor] }), element("td", { textContent: Number(value.toPrecision(4)) }),
        element("td", { textContent: isDirection ? "" : Number(middle.toPrecision(4)) }), cell);
    }));
  };
  const choice = element("select", {}, ...page.ranges_m.map((range_m, range) => element("option", { value: range, textContent: `${range_m} m` })));
  choice.value = chosenRange(page, site, 0);
  choice.addEventListener("change", () => fill(Number(choice.value)));
  fill(Number(choice.value));
  parent.append(element("label", { textContent: "at a range of " }, choice),
    element("div", { className: "scroll", tabIndex: 0 }, element("table", {}, element("thead", {}, element("tr", {}, ...["factor", "this site", "median", "deviation (robust z)"].map((words) => element("th", { scope: "col", textContent: words })))), body)));
}

// "forward 0.43, left 0.03, up 0.08 m"
const protectionText = ([forward_m, left_m, up_m]) => `forward ${forward_m.toFixed(2)}, left ${left_m.toFixed(2)}, up ${up_m.toFixed(2)} m`;

// What the map answers here, and the figures behind it.
function drawAnswers(page, site) {
  const facts = element("dl", { className: "facts" });
  const add = (name, value) => facts.append(element("dt", { textContent: name }), element("dd", { textContent: value }));
  page.limits_m.forEach((limit_m, limit) => {
    const answer = answerAt(page, site, limit);
    add(`within ${limitText(limit_m)}`, `${answerText(answer)}; predicted error ${(100 * answer.mean_m).toFixed(1)} cm, P(error within the limit) ${(100 * answer.probability).toFixed(0)} %`);
  });
  if (page.judgedOfSite[site] >= 0) {
    add("measured error", page.limits_m.map((limit_m, limit) => `${(100 * measuredError(page, site, chosenRange(page, site, limit))).toFixed(1)} cm at the range for ${limitText(limit_m)}`).join("; "));
  }
  const kind = kindOfPlace(page, site);
  if (kind) add("kind of place", kind);
  const levels_m = protectionOf(page, site);
  if (levels_m) add("protection level", `${protectionText(levels_m)}; exceeded by a tracking vehicle in at most ${100 * page.places.risk} % of stretches of 60 m`);
  if (page.sites.unconstrained?.[site] > 0) add("poses", "not constrained by the scans");
  return facts;
}

const folded = (title, ...content) => element("details", {}, element("summary", { textContent: title }), ...content);

export function drawSitePanel(page, place) {
  const panel = element("div", { className: "site-panel" });
  panel.setAttribute("aria-live", "polite");
  place.append(panel);
  const ndView = drawNdView(page);
  let charts = [];
  onSelect(async (site) => {
    charts.forEach((chart) => chart.remove());
    const isOpen = [...panel.querySelectorAll("details")].map((each) => each.open);
    const errors = element("div", {}, element("h3", { textContent: "Error over range" }),
      element("div", { className: "reading", textContent: "Dashed: the limits. Vertical lines: the chosen range for each limit." }));
    const probabilities = element("div", {}, element("h3", { textContent: "Probability over range" }),
      element("div", { className: "reading", textContent: "Dashed: the required probability. Vertical lines: the chosen range for each limit." }));
    const depth = element("div", {});
    const factors = element("div", {});
    const words = element("div", {});
    panel.replaceChildren(element("h3", { id: "site-title", textContent: `Site ${site}` }), drawSteps(page, site), drawAnswers(page, site),
      ...(ndView ? [ndView] : []), folded("Reason for this answer", words), errors, probabilities, ...(page.depth ? [depth] : []), ...(page.factors ? [folded("Factors", factors)] : []));
    panel.querySelectorAll("details").forEach((each, i) => { each.open = isOpen[i] ?? false; });
    charts = [drawErrors(page, site, errors), drawProbabilities(page, site, probabilities)];
    if (page.depth) drawDepth(page, site, depth);
    if (page.factors) drawFactors(page, site, factors);
    const text = await textOfSite(page, site);
    if (selection.site === site) words.append(element("pre", { textContent: text, tabIndex: 0 }));
  });
}
