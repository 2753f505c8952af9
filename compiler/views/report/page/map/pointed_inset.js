// Where on the route is what one points at in a chart: a small map in the corner while the map itself is out of
// sight.

import { css } from "../colours.js";
import { element } from "../elements.js";
import { onPoint } from "../selection.js";

const side_px = 200;
const margin_px = 14;
const mostPoints = 3000;

function boxOf(sites) {
  const box = { low_x_m: Infinity, low_y_m: Infinity, high_x_m: -Infinity, high_y_m: -Infinity };
  for (let i = 0; i < sites.count; ++i) {
    box.low_x_m = Math.min(box.low_x_m, sites.x_m[i]);
    box.high_x_m = Math.max(box.high_x_m, sites.x_m[i]);
    box.low_y_m = Math.min(box.low_y_m, sites.y_m[i]);
    box.high_y_m = Math.max(box.high_y_m, sites.y_m[i]);
  }
  return box;
}

export function drawInset(page, mapView) {
  const { sites } = page;
  const box = boxOf(sites);
  const [width_m, height_m] = [box.high_x_m - box.low_x_m, box.high_y_m - box.low_y_m];
  const scale = (side_px - 2 * margin_px) / Math.max(width_m, height_m, 1);
  const height_px = Math.round(height_m * scale) + 2 * margin_px;
  const fine = Math.max(1, devicePixelRatio);
  const canvas = element("canvas", { width: side_px * fine, height: height_px * fine });
  canvas.style.width = `${side_px}px`;
  const inset = element("div", { className: "inset", hidden: true }, canvas);
  inset.setAttribute("aria-hidden", "true");
  document.body.append(inset);
  const place = (i) => [margin_px + (sites.x_m[i] - box.low_x_m) * scale, margin_px + (box.high_y_m - sites.y_m[i]) * scale];
  const step = Math.ceil(sites.count / mostPoints);
  const draw = (site) => {
    const context = canvas.getContext("2d");
    context.setTransform(fine, 0, 0, fine, 0, 0);
    context.clearRect(0, 0, side_px, height_px);
    context.strokeStyle = css("grey");
    context.lineWidth = 3;
    context.beginPath();
    for (let i = 0; i < sites.count; i += step) {
      const goesOn = i >= step && sites.run[i] === sites.run[i - step];
      context[goesOn ? "lineTo" : "moveTo"](...place(i));
    }
    context.stroke();
    context.fillStyle = css("accent");
    context.beginPath();
    context.arc(...place(site), 6, 0, 2 * Math.PI);
    context.fill();
  };
  onPoint((site) => {
    const seen = mapView.getBoundingClientRect();
    inset.hidden = site === null || (seen.bottom > 80 && seen.top < innerHeight - 80);
    if (!inset.hidden) draw(site);
  });
}
