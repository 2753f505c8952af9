// The charts of one site, which no still picture shows: they answer to mouse and keyboard.

import uPlot from "uplot";
import { css, onTheme } from "./colours.js";


function axis(label, size) {
  return {
    label, size, stroke: css("soft"), font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
    grid: { stroke: css("line"), width: 1 }, ticks: { stroke: css("line"), width: 1 },
  };
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
  return {
    label: line.label, stroke: line.colour(), width: line.width ?? 1.5, dash: line.dash, spanGaps: false,
    points: { show: line.hasPoints ?? false, size: 7, fill: line.colour() },
    value: (u, value) => (value == null ? "–" : value.toFixed(line.decimals ?? 1)),
  };
}

// Left and right move the cursor.
function listenToKeys(frame, chart) {
  frame.tabIndex = 0;
  frame.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step === undefined) return;
    const u = chart();
    const index = Math.min(Math.max((u.cursor.idx ?? 0) + step, 0), u.data[0].length - 1);
    u.setCursor({ left: u.valToPos(u.data[0][index], "x"), top: u.over.clientHeight / 2 });
    event.preventDefault();
  });
}

function optionsOf(spec, width) {
  return {
    width, height: spec.height ?? 300,
    scales: { x: { time: false, range: spec.xRange }, y: { range: (u, least, greatest) => [spec.least ?? 0, spec.greatest ?? (greatest > 0 ? greatest * 1.05 : 1)] } },
    axes: [{ ...axis(spec.xLabel, 46), splits: spec.xTicks && (() => spec.xTicks) }, axis(spec.yLabel, 58)],
    cursor: { drag: { x: false, y: false } },
    series: [{ label: spec.xLabel, value: (u, value) => (value == null ? "–" : String(+value.toFixed(1))) }, ...spec.lines.map(seriesOf)],
    legend: { markers: { width: 0, fill: (u, i) => (i > 0 ? spec.lines[i - 1].colour() : "transparent") } },
    hooks: { draw: [(u) => spec.overlay?.(u)] },
  };
}

// A chart in `parent`: spec {title, xs, lines: [{label, ys, colour(), ...}], xLabel, yLabel, overlay(u)}. Returns an
// object with remove().
export function drawChart(parent, spec) {
  const frame = document.createElement("div");
  frame.className = "chart-live";
  frame.setAttribute("role", "img");
  frame.setAttribute("aria-label", spec.title);
  parent.append(frame);
  let u = null;
  let isRemoved = false;
  onTheme(() => {
    if (isRemoved) return;
    u?.destroy();
    u = new uPlot(optionsOf(spec, Math.max(frame.clientWidth, 240)), [spec.xs, ...spec.lines.map((line) => line.ys)], frame);
  });
  listenToKeys(frame, () => u);
  const observer = new ResizeObserver(() => {
    if (frame.clientWidth > 0 && u.width !== frame.clientWidth) u.setSize({ width: frame.clientWidth, height: spec.height ?? 300 });
  });
  observer.observe(frame);
  return { remove: () => { isRemoved = true; observer.disconnect(); u.destroy(); frame.remove(); } };
}
