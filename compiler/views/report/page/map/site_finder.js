// Finds sites by place.

export function siteFinder(sites) {
  const cell_m = 16;
  const cells = new Map();
  const key = (column, row) => `${column},${row}`;
  for (let i = 0; i < sites.count; ++i) {
    const at = key(Math.floor(sites.x_m[i] / cell_m), Math.floor(sites.y_m[i] / cell_m));
    if (!cells.has(at)) cells.set(at, []);
    cells.get(at).push(i);
  }
  const isIn = (i, low_x_m, low_y_m, high_x_m, high_y_m) =>
    sites.x_m[i] >= low_x_m && sites.x_m[i] <= high_x_m && sites.y_m[i] >= low_y_m && sites.y_m[i] <= high_y_m;
  return {
    // Those in a box and perhaps a few beside it, ascending.
    inBox: (low_x_m, low_y_m, high_x_m, high_y_m) => {
      const found = [];
      if (((high_x_m - low_x_m) * (high_y_m - low_y_m)) / cell_m ** 2 > sites.count) {
        for (let i = 0; i < sites.count; ++i) if (isIn(i, low_x_m, low_y_m, high_x_m, high_y_m)) found.push(i);
        return found;
      }
      for (let i = Math.floor(low_x_m / cell_m); i <= Math.floor(high_x_m / cell_m); ++i) {
        for (let j = Math.floor(low_y_m / cell_m); j <= Math.floor(high_y_m / cell_m); ++j) found.push(...(cells.get(key(i, j)) ?? []));
      }
      return found.sort((a, b) => a - b);
    },
    nearest: (x_m, y_m) => {
      let best = 0;
      let bestApart_m = Infinity;
      for (let i = 0; i < sites.count; ++i) {
        const apart_m = Math.hypot(sites.x_m[i] - x_m, sites.y_m[i] - y_m);
        if (apart_m < bestApart_m) [best, bestApart_m] = [i, apart_m];
      }
      return { site: best, apart_m: bestApart_m };
    },
  };
}
