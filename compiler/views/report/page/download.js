// The numbers of every place as a table of comma-separated values, for other programs.

import { answerAt, answerText, kindOfPlace, protectionOf } from "./answers.js";
import { chosenRange, measuredError } from "./data.js";
import { element } from "./elements.js";

const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
const fieldOf = (value) => (value === null || Number.isNaN(value) ? "" : quoted(typeof value === "number" ? String(+value.toPrecision(8)) : value));

// [name, value of a site] each.
function columnsOf(page) {
  const { sites } = page;
  const columns = [["site", (site) => site], ["run", (site) => sites.run[site]], ["along_run_m", (site) => sites.s_m[site]]];
  ["x", "y", "z"].forEach((axis, i) => columns.push([`${axis}_world_m`, (site) => sites[`${axis}_m`][site] + page.origin_world_m[i]]));
  if (page.places.kind) columns.push(["place_kind", (site) => kindOfPlace(page, site)]);
  if (page.places.protection_m) {
    ["forward", "left", "up"].forEach((axis, i) => columns.push([`protection_${axis}_m`, (site) => protectionOf(page, site)?.[i] ?? null]));
  }
  page.limits_m.forEach((limit_m, limit) => {
    const name = (what) => `${what}_${+(100 * limit_m).toPrecision(6)}cm`;
    columns.push([name("answer"), (site) => answerText(answerAt(page, site, limit))],
      [name("predicted_error_m"), (site) => answerAt(page, site, limit).mean_m],
      [name("probability"), (site) => answerAt(page, site, limit).probability],
      [name("range_m"), (site) => page.ranges_m[chosenRange(page, site, limit)]]);
    if (page.judged) columns.push([name("measured_error_at_range_m"), (site) => measuredError(page, site, chosenRange(page, site, limit))]);
  });
  return columns;
}

export function tableOfPlaces(page) {
  const columns = columnsOf(page);
  const rows = [columns.map(([name]) => name).join(",")];
  for (let site = 0; site < page.sites.count; ++site) rows.push(columns.map(([, valueOf]) => fieldOf(valueOf(site))).join(","));
  return `${rows.join("\n")}\n`;
}

export function downloadButton(page) {
  const made = element("button", { type: "button", className: "download", textContent: "Download all places (CSV)" });
  made.addEventListener("click", () => {
    const address = URL.createObjectURL(new Blob([tableOfPlaces(page)], { type: "text/csv" }));
    element("a", { href: address, download: "places.csv" }).click();
    URL.revokeObjectURL(address);
  });
  return made;
}
