// Which site is looked at; everything that shows it listens.

export const selection = { site: null };
const listeners = [];

export function onSelect(listener) {
  listeners.push(listener);
}

export function select(site, isFirst = false) {
  selection.site = site;
  if (!isFirst) history.replaceState(null, "", `#site=${site}`);
  for (const listener of listeners) listener(site);
}

// Links in the page to a site (href="#site=40") show it on the map.
export function followLinks() {
  document.addEventListener("click", (event) => {
    const link = event.target.closest?.('a[href^="#site="]');
    if (!link) return;
    event.preventDefault();
    select(Number(link.hash.slice(6)));
    document.getElementById("figure-11").scrollIntoView();
  });
}

// The site that the address names, or null.
export function siteOfAddress(count) {
  const named = /^#site=(\d+)$/.exec(location.hash);
  return named && Number(named[1]) < count ? Number(named[1]) : null;
}
