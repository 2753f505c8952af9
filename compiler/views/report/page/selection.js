// Which site is looked at, and which one is pointed at; everything that shows them listens.

export const selection = { site: null };
const listeners = [];
const pointListeners = [];

export function onSelect(listener) {
  listeners.push(listener);
}

export function select(site, isFirst = false) {
  selection.site = site;
  if (!isFirst) history.replaceState(null, "", `#site=${site}`);
  for (const listener of listeners) listener(site);
}

// The listener takes a site, or null where the pointer has left.
export function onPoint(listener) {
  pointListeners.push(listener);
}

export function pointAt(site) {
  for (const listener of pointListeners) listener(site);
}

function showOnMap(site, behavior) {
  select(site);
  document.querySelector(".first-screen > #map").scrollIntoView({ behavior });
}

// The site that an address names, or null.
export function siteOfAddress(count, hash = location.hash) {
  const named = /^#site=(\d+)$/.exec(hash);
  return named && Number(named[1]) < count ? Number(named[1]) : null;
}

// Links to a site (#site=40), in the page or its address, show the site and scroll to it.
export function followLinks(count) {
  document.addEventListener("click", (event) => {
    const link = event.target.closest?.('a[href^="#site="]');
    const site = link ? siteOfAddress(count, link.hash) : null;
    if (site === null) return;
    event.preventDefault();
    showOnMap(site, "smooth");
  });
  const follow = () => {
    const site = siteOfAddress(count);
    if (site !== null) showOnMap(site, "instant");
  };
  window.addEventListener("hashchange", follow);
  follow();
}
