// Charts that answer to mouse and keyboard, in the place of the still pictures.

import uPlot from "uplot";
import { css, onTheme } from "./colours.js";

const charts = new Set();
const routeSync = uPlot.sync("route");

function axis(label, size) {
  return {
    label, size, stroke: css("soft"), font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
    grid: { stroke: css("line"), width: 1 }, ticks: { stroke: css("line"), width: 1 },
  };
}

function drawBands(u, bands, colour) {
  u.ctx.save();
  u.ctx.fillStyle = colour;
  for (const [from, to] of bands) {
    const left = u.valToPos(Math.max(from, u.scales.x.min), "x", true);
    const right = u.valToPos(Math.min(to, u.scales.x.max), "x", true);
    if (right > left || (from < u.scales.x.max && to > u.scales.x.min)) {
      u.ctx.fillRect(left, u.bbox.top, Math.max(right - left, 1.5), u.bbox.height);
    }
  }
  u.ctx.restore();
}

function drawLine(u, from, to, colour, dash) {
  u.ctx.save();
  u.ctx.beginPath();
  u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
  u.ctx.clip();
  u.ctx.strokeStyle = colour;
  u.ctx.setLineDash(dash);
  u.ctx.lineWidth = 1.5 * devicePixelRatio;
  u.ctx.beginPath();
  u.ctx.moveTo(...from);
  u.ctx.lineTo(...to);
  u.ctx.stroke();
  u.ctx.restore();
}

export function drawVertical(u, x, colour, dash = []) {
  const left = u.valToPos(x, "x", true);
  drawLine(u, [left, u.bbox.top], [left, u.bbox.top + u.bbox.height], colour, dash);
}

export function drawHorizontal(u, y, colour, dash = []) {
  const top = u.valToPos(y, "y", true);
  drawLine(u, [u.bbox.left, top], [u.bbox.left + u.bbox.width, top], colour, dash);
}

function seriesOf(line) {
  const step = line.isStepped ? { paths: uPlot.paths.stepped({ align: 1 }) } : {};
  return {
    label: line.label, stroke: line.colour(), width: line.width ?? 1.5, dash: line.dash, spanGaps: false,
    points: { show: line.hasPoints ?? false, size: 7, fill: line.colour() },
    value: (u, value) => (value == null ? "–" : value.toFixed(line.decimals ?? 1)), ...step,
  };
}

// Left and right move the cursor, Enter picks what it is at.
function listenToKeys(frame, u, pick) {
  frame.tabIndex = 0;
  frame.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const last = u.data[0].length - 1;
    if (step !== undefined) {
      const index = Math.min(Math.max((u.cursor.idx ?? 0) + step * (event.shiftKey ? 20 : 1), 0), last);
      u.setCursor({ left: u.valToPos(u.data[0][index], "x"), top: u.over.clientHeight / 2 });
      event.preventDefault();
    } else if (event.key === "Enter" && u.cursor.idx != null && pick) {
      pick(u.cursor.idx);
    }
  });
}

function optionsOf(spec, width) {
  return {
    width, height: spec.height ?? 300,
    scales: { x: { time: false, range: spec.xRange }, y: { range: (u, least, greatest) => [spec.least ?? 0, spec.greatest ?? (greatest > 0 ? greatest * 1.05 : 1)] } },
    axes: [{ ...axis(spec.xLabel, 46), splits: spec.xTicks && (() => spec.xTicks) }, axis(spec.yLabel, 58)],
    cursor: {
      drag: { x: spec.isRoute ?? false, y: false },
      sync: spec.isRoute ? { key: routeSync.key, scales: ["x", null] } : undefined,
    },
    series: [{ label: spec.xLabel, value: (u, value) => (value == null ? "–" : String(+value.toFixed(1))) }, ...spec.lines.map(seriesOf)],
    legend: { markers: { width: 0, fill: (u, i) => (i > 0 ? spec.lines[i - 1].colour() : "transparent") } },
    hooks: {
      drawClear: [(u) => drawBands(u, spec.bands ?? [], css("pink"))],
      draw: [(u) => spec.overlay?.(u)],
    },
  };
}

// A chart in `parent`: spec {title, xs, lines: [{label, ys, colour(), ...}], xLabel, yLabel, bands, overlay(u),
// pick(index)}. Returns an object with redraw() and remove().
export function drawChart(parent, spec) {
  const frame = document.createElement("div");
  frame.className = "chart-live";
  frame.setAttribute("role", "img");
  frame.setAttribute("aria-label", spec.title);
  parent.append(frame);
  let u = null;
  let isRemoved = false;
  const make = () => {
    if (isRemoved) return;
    u?.destroy();
    const width = Math.max(frame.clientWidth, 240);
    u = new uPlot(optionsOf(spec, width), [spec.xs, ...spec.lines.map((line) => line.ys)], frame);
    let pressed = 0;
    u.over.addEventListener("mousedown", (event) => { pressed = event.clientX; });
    u.over.addEventListener("click", (event) => {
      if (spec.pick && Math.abs(event.clientX - pressed) < 4 && u.cursor.idx != null) spec.pick(u.cursor.idx);
    });
  };
  onTheme(make);
  listenToKeys(frame, { get data() { return u.data; }, get cursor() { return u.cursor; }, get over() { return u.over; },
    valToPos: (...place) => u.valToPos(...place), setCursor: (place) => u.setCursor(place) }, spec.pick);
  const observer = new ResizeObserver(() => {
    if (frame.clientWidth > 0 && u.width !== frame.clientWidth) u.setSize({ width: frame.clientWidth, height: spec.height ?? 300 });
  });
  observer.observe(frame);
  const chart = {
    redraw: () => u.redraw(false, false),
    remove: () => { isRemoved = true; observer.disconnect(); charts.delete(chart); u.destroy(); frame.remove(); },
  };
  charts.add(chart);
  return chart;
}

// After another site was picked: its mark moves in every chart.
export function redrawCharts() {
  for (const chart of charts) chart.redraw();
}
