// What lies on the map, each drawn tile by tile: only what is in the window is unpacked and drawn, and
// less of it the farther away one looks.

import L from "leaflet";
import { css, isDark } from "./colours.js";
import { greysOf, numbers } from "./data.js";

const tilePixels = 256;
const routePixels = 5;  // of its width

// Pixels of a canvas for each of the window.
const sharpness = () => Math.max(1, devicePixelRatio) * 1.25;

// A layer whose tiles are canvases. draw(context, box, scale) draws in map metres, y up, scale in pixels a
// metre; it may be asynchronous.
const CanvasLayer = L.GridLayer.extend({
  initialize(draw, options) {
    this.drawTile = draw;
    // Of itself a layer of tiles ends at one pixel a metre, which is zoom 0 here.
    L.GridLayer.prototype.initialize.call(this, { tileSize: tilePixels, keepBuffer: 1, minZoom: -Infinity, ...options });
  },
  createTile(coords, done) {
    const canvas = document.createElement("canvas");
    const fine = sharpness();
    canvas.width = canvas.height = Math.round(tilePixels * fine);
    const side_m = tilePixels / 2 ** coords.z;
    const box = { low_x_m: coords.x * side_m, high_x_m: (coords.x + 1) * side_m, high_y_m: -coords.y * side_m, low_y_m: -(coords.y + 1) * side_m };
    const scale = canvas.width / side_m;
    const context = canvas.getContext("2d");
    context.setTransform(scale, 0, 0, -scale, -box.low_x_m * scale, box.high_y_m * scale);
    Promise.resolve(this.drawTile(context, box, scale)).then(() => done(null, canvas), (error) => { console.error(error); done(error, canvas); });
    return canvas;
  },
});

// Tiles of the page by key, those that a box touches.
export function tileFinder(tiles, tile_m) {
  const byKey = new Map(tiles.map((tile) => [`${tile.x},${tile.y}`, tile]));
  return (box, margin_m) => {
    const found = [];
    const first = (low_m) => Math.floor((low_m - margin_m) / tile_m);
    const last = (high_m) => Math.floor((high_m + margin_m) / tile_m);
    for (let x = first(box.low_x_m); x <= last(box.high_x_m); ++x) {
      for (let y = first(box.low_y_m); y <= last(box.high_y_m); ++y) {
        const tile = byKey.get(`${x},${y}`);
        if (tile) found.push(tile);
      }
    }
    return found;
  };
}

// Heights over the road to greys of the page: ground nearly paper, walls and roofs clearly not.
function tintOf(relief) {
  const [ground, high] = isDark() ? [44, 150] : [226, 120];
  const tints = new Uint8Array(256);
  for (let value = 1; value < 256; ++value) {
    const height_m = relief.lowest_m + relief.step_m * (value - 1);
    const share = Math.min(Math.max((height_m - 0.3) / 5, 0), 1);
    tints[value] = Math.round(ground + share ** 0.6 * (high - ground));
  }
  return tints;
}

async function tinted(relief, image) {
  const { grey, width, height } = await greysOf(image);
  const tints = tintOf(relief);
  const pixels = new ImageData(width, height);
  for (let i = 0; i < grey.length; ++i) {
    pixels.data.fill(tints[grey[i]], 4 * i, 4 * i + 3);
    pixels.data[4 * i + 3] = grey[i] === 0 ? 0 : 255;
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}

// Tinted pictures, the last few hundred that were looked at.
function tintedStore(relief) {
  const most = 400;
  const store = new Map();
  return (image) => {
    const key = `${isDark()}${image.length}${image.slice(-64, -8)}${image.slice(40, 120)}`;
    const found = store.get(key) ?? tinted(relief, image);
    store.delete(key);
    store.set(key, found);
    if (store.size > most) store.delete(store.keys().next().value);
    return found;
  };
}

function drawPicture(context, picture, low_x_m, high_y_m, width_m, height_m) {
  context.save();
  context.translate(low_x_m, high_y_m);
  context.scale(1, -1);
  context.drawImage(picture, 0, 0, width_m, height_m);
  context.restore();
}

function surfaceLayer(relief) {
  const tilesIn = tileFinder(relief.tiles, relief.tile_m);
  const pictureOf = tintedStore(relief);
  return new CanvasLayer(async (context, box, scale) => {
    const { overview } = relief;
    if (scale * overview.pixel_m < 1.6) {
      const picture = await pictureOf(overview.image);
      drawPicture(context, picture, overview.low_x_m, overview.high_y_m, picture.width * overview.pixel_m, picture.height * overview.pixel_m);
      return;
    }
    const tiles = tilesIn(box, 0);
    const pictures = await Promise.all(tiles.map((tile) => pictureOf(tile.image)));
    tiles.forEach((tile, i) => drawPicture(context, pictures[i], tile.x * relief.tile_m, (tile.y + 1) * relief.tile_m, relief.tile_m, relief.tile_m));
  }, { zIndex: 1, opacity: 0.35 });
}

export const kindColours = { 1: "orange", 2: "blue", 3: "green", 4: "grey" };
const lying = 4;

// NDs of a tile, the lying ones first, then from below to above.
async function paintingOrder(tile) {
  if (!tile.order) {
    const [height, kind] = await Promise.all([numbers(tile.height), numbers(tile.kind)]);
    tile.order = Uint32Array.from({ length: tile.count }, (_, i) => i)
      .sort((a, b) => (kind[b] === lying) - (kind[a] === lying) || height[a] - height[b]);
  }
  return tile.order;
}

async function drawNds(context, tile, tile_m, scale, stride) {
  const [place, radius, turn, kind, order] = await Promise.all(
    [numbers(tile.place_m), numbers(tile.radius), numbers(tile.turn), numbers(tile.kind), paintingOrder(tile)]);
  const colours = Object.fromEntries(Object.entries(kindColours).map(([each, name]) => [each, css(name)]));
  const least_m = 0.7 / scale;
  for (let k = 0; k < order.length; k += stride) {
    const i = order[k];
    const x_m = tile.x * tile_m + (place[2 * i] * tile_m) / 65535;
    const y_m = tile.y * tile_m + (place[2 * i + 1] * tile_m) / 65535;
    context.globalAlpha = kind[i] === lying ? 0.25 : 0.7;
    context.fillStyle = colours[kind[i]];
    context.beginPath();
    context.ellipse(x_m, y_m, Math.max(radius[2 * i] / 1000, least_m), Math.max(radius[2 * i + 1] / 1000, least_m), (turn[i] * Math.PI) / 256, 0, 2 * Math.PI);
    context.fill();
  }
  context.globalAlpha = 1;
}

const farthestStride = 16;
const farthestOverSurface = 3;  // from farther away the surface shows as much, and is drawn at once

function ndLayer(nds, hasSurface) {
  const tilesIn = tileFinder(nds.tiles, nds.tile_m);
  return new CanvasLayer(async (context, box, scale) => {
    // A cell of less than two pixels cannot be distinguished from its neighbours: one for each such square is drawn, and
    // none from so far that unpacking them all would be for nothing: there the surface shows enough.
    const stride = Math.max(1, Math.ceil((2 / (nds.cell_m * scale)) ** 2));
    if (stride > (hasSurface ? farthestOverSurface : farthestStride)) return;
    for (const tile of tilesIn(box, nds.cell_m)) await drawNds(context, tile, nds.tile_m, scale, stride);
  }, { zIndex: 2 });
}

function movedLayer(moved) {
  const tilesIn = tileFinder(moved.tiles, moved.tile_m);
  return new CanvasLayer(async (context, box, scale) => {
    context.fillStyle = css("purple");
    const side_m = Math.max(moved.voxel_m, 1 / scale);
    const stride = Math.max(1, Math.ceil((0.7 / (moved.voxel_m * scale)) ** 2));
    if (stride > 4 * farthestStride) return;
    for (const tile of tilesIn(box, 0)) {
      const [cell, height] = await Promise.all([numbers(tile.cell), numbers(tile.height)]);
      for (let i = 0; i < tile.count; i += stride) {
        context.globalAlpha = Math.min(1, 0.35 + 0.15 * height[i]);
        context.fillRect(tile.x * moved.tile_m + cell[2 * i] * moved.voxel_m, tile.y * moved.tile_m + cell[2 * i + 1] * moved.voxel_m, side_m, side_m);
      }
    }
    context.globalAlpha = 1;
  }, { zIndex: 3 });
}

const changeColours = ["orange", "blue", "purple"];  // added, removed, moved

// NDs that differ from the older map, sorted by x so that a tile finds its own.
function changeLayer(nds) {
  const order = Uint32Array.from(nds.x_m, (_, i) => i).sort((a, b) => nds.x_m[a] - nds.x_m[b]);
  const firstFrom = (x_m) => {
    let [low, high] = [0, order.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (nds.x_m[order[middle]] < x_m) low = middle + 1;
      else high = middle;
    }
    return low;
  };
  return new CanvasLayer((context, box, scale) => {
    const radius_m = Math.max(0.5, 2 / scale);
    const colours = changeColours.map(css);
    for (let k = firstFrom(box.low_x_m - radius_m); k < order.length && nds.x_m[order[k]] < box.high_x_m + radius_m; ++k) {
      const i = order[k];
      if (nds.y_m[i] < box.low_y_m - radius_m || nds.y_m[i] > box.high_y_m + radius_m) continue;
      context.fillStyle = colours[nds.change[i]];
      context.beginPath();
      context.arc(nds.x_m[i], nds.y_m[i], radius_m, 0, 2 * Math.PI);
      context.fill();
    }
  }, { zIndex: 3 });
}

// From halfway to the site before to halfway to the next, `step` sites away each.
function tracePiece(context, sites, i, step) {
  const halfway = (j) => (j >= 0 && j < sites.count && sites.run[j] === sites.run[i]
    ? [(sites.x_m[i] + sites.x_m[j]) / 2, (sites.y_m[i] + sites.y_m[j]) / 2] : [sites.x_m[i], sites.y_m[i]]);
  context.beginPath();
  context.moveTo(...halfway(i - step));
  context.lineTo(sites.x_m[i], sites.y_m[i]);
  context.lineTo(...halfway(i + step));
  context.stroke();
}

function routeLayer(page, finder) {
  const layer = new CanvasLayer((context, box, scale) => {
    const width_m = (routePixels * sharpness()) / scale;
    // From afar one piece for each two pixels of way.
    const step = Math.max(1, Math.floor(2 / (page.site_spacing_m * scale)));
    const margin_m = width_m + step * page.site_spacing_m;
    const found = finder.inBox(box.low_x_m - margin_m, box.low_y_m - margin_m, box.high_x_m + margin_m, box.high_y_m + margin_m)
      .filter((i) => i % step === 0);
    const colourOf = layer.paint();
    // From afar a piece stands for several sites: it stands out where one of them does.
    const standsOut = (i) => {
      for (let j = i; j < Math.min(i + step, page.sites.count); ++j) if (layer.filter.isWanted(j)) return true;
      return false;
    };
    const wanted = layer.filter?.isOn() ? found.filter(standsOut) : found;
    context.lineCap = "round";
    context.lineJoin = "round";
    if (wanted !== found) {
      context.strokeStyle = css("faint");
      context.lineWidth = width_m / 2;
      for (const i of found) tracePiece(context, page.sites, i, step);
    }
    context.lineWidth = width_m;
    for (const i of wanted) {
      context.strokeStyle = colourOf(i);
      tracePiece(context, page.sites, i, step);
    }
  }, { zIndex: 4 });
  layer.paint = () => () => css("grey");
  return layer;
}

export function layersOf(page, finder) {
  const route = routeLayer(page, finder);
  const layers = [];
  if (page.relief?.overview) layers.push({ label: "surface", layer: surfaceLayer(page.relief), isOn: true });
  layers.push({ label: "NDs", layer: ndLayer(page.nds, Boolean(page.relief?.overview)), isOn: false });
  if (page.moved) layers.push({ label: "removed as moving", layer: movedLayer(page.moved), isOn: false });
  if (page.diff) layers.push({ label: "NDs added (orange), removed (blue), moved (purple)", layer: changeLayer(page.diff.nds), isOn: true });
  layers.push({ label: "route", layer: route, isOn: true });
  return { layers, route };
}
