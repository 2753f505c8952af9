// The answer of the place that the mouse points at, beside it.

import L from "leaflet";
import { answerAt, answerText, kindOfPlace, protectionOf } from "../answers.js";
import { element, limitText } from "../elements.js";

const reach_px = 14;  // from the route

function wordsOf(page, site, limit) {
  const answer = answerAt(page, site, limit);
  const lines = [`Site ${site}, ${page.sites.route_m[site].toFixed(0)} m along the route`,
    `within ${limitText(page.limits_m[limit])}: ${answerText(answer)}`,
    `predicted error ${(100 * answer.mean_m).toFixed(1)} cm, P(error within the limit) ${(100 * answer.probability).toFixed(0)} %`];
  const kind = kindOfPlace(page, site);
  if (kind) lines.push(kind);
  const levels_m = protectionOf(page, site);
  if (levels_m) lines.push(`protection level forward ${levels_m[0].toFixed(2)} m`);
  return element("div", {}, ...lines.map((line) => element("div", { textContent: line })));
}

// limit(): the index of the limit that is shown.
export function showAnswers(page, map, finder, limit) {
  const tip = L.tooltip({ className: "answer-tip", direction: "top", offset: [0, -8] });
  const place = (site) => L.latLng(page.sites.y_m[site], page.sites.x_m[site]);
  map.on("mousemove", (event) => {
    const { site } = finder.nearest(event.latlng.lng, event.latlng.lat);
    if (map.latLngToContainerPoint(place(site)).distanceTo(event.containerPoint) > reach_px) {
      tip.remove();
      return;
    }
    tip.setLatLng(place(site)).setContent(wordsOf(page, site, limit())).addTo(map);
  });
  map.on("mouseout", () => tip.remove());
}
