// Makes the report's figures and map answer; without it the page has its still pictures.

import "leaflet/dist/leaflet.css";
import "uplot/dist/uPlot.min.css";
import "./live.css";
import { typicalSite } from "./answers.js";
import { readPage } from "./data.js";
import { letFiguresAnswer } from "./figures.js";
import { drawMap } from "./map_view.js";
import { followLinks, select, siteOfAddress } from "./selection.js";
import { drawSitePanel } from "./site_panel.js";

async function start() {
  const page = await readPage();
  const figure = document.getElementById("figure-11");
  figure.classList.add("is-live");
  const place = figure.querySelector(".live");
  drawSitePanel(page, document.getElementById("map"));  // first: it takes its width from the map
  const map = drawMap(page, place);
  letFiguresAnswer(page);
  select(siteOfAddress(page.sites.count) ?? typicalSite(page), true);
  followLinks(page.sites.count);
  // For tests and for people at the console.
  window.sightlineReport = { page, select, map };
  document.documentElement.dataset.ready = "yes";
}

start();
