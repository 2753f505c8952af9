// Makes the report's figures and map answer; without it the page has its still pictures.

import "leaflet/dist/leaflet.css";
import "uplot/dist/uPlot.min.css";
import "./live.css";
import { readPage } from "./data.js";
import { letFiguresAnswer } from "./figures.js";
import { drawMap } from "./map_view.js";
import { followLinks, select, siteOfAddress } from "./selection.js";
import { drawSitePanel } from "./site_panel.js";

// A typical site: its range errs like the median on the drive that judged; else the one in the middle.
function firstSite(page) {
  if (!page.judged) return Math.floor(page.sites.count / 2);
  const ranges = page.ranges_m.length;
  const map = page.judged.rules.indexOf("map");
  const chosen = (i) => page.judged.chosen[map * page.judged.site.length + i];
  const errs = (i) => page.judged.error_m[i * ranges + chosen(i)];
  const order = Array.from(page.judged.site, (_, i) => i).sort((a, b) => errs(a) - errs(b) || a - b);
  return page.judged.site[order[Math.floor(order.length / 2)]];
}

async function start() {
  const page = await readPage();
  const figure = document.getElementById("figure-11");
  figure.classList.add("is-live");
  const place = figure.querySelector(".live");
  const map = drawMap(page, place);
  drawSitePanel(page, place);
  letFiguresAnswer(page);
  select(siteOfAddress(page.sites.count) ?? firstSite(page), true);
  followLinks(page.sites.count);
  // For tests and for people at the console.
  window.sightlineReport = { page, select, map };
  document.documentElement.dataset.ready = "yes";
}

start();
