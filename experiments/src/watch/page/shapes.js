// Paths in metres of the world, made once per document, and how they are painted.

function addRing(path, ring) {
  ring.forEach(([x, y], index) => (index ? path.lineTo(x, y) : path.moveTo(x, y)));
  path.closePath();
}

// The area of a GeoJSON geometry.
function addGeometry(path, geometry) {
  const { type, coordinates } = geometry ?? {};
  const polygons = type === 'Polygon' ? [coordinates] : type === 'MultiPolygon' ? coordinates : [];
  for (const rings of polygons) rings.forEach((ring) => addRing(path, ring));
  return path;
}

// The areas of GeoJSON features, together.
function pathOfFeatures(features) {
  const path = new Path2D();
  for (const feature of features ?? []) addGeometry(path, feature.geometry);
  return path;
}

// The areas of a GeoJSON document, one by one.
const pathsOfFeatures = (doc) => (doc.features ?? []).map(({ geometry, properties }) =>
  ({ path: addGeometry(new Path2D(), geometry), properties }));

// The cells of a raster, as runs.
function pathOfRuns(cells) {
  const path = new Path2D();
  const [x, y] = cells?.origin_m ?? [0, 0];
  const side = cells?.cell_m ?? 0;
  for (const [row, from, to] of cells?.runs ?? []) {
    path.rect(x + from * side, y + row * side, (to - from) * side, side);
  }
  return path;
}

// The occupied cells of an occupancy-elevation map: a path per band of height.
function pathsOfHeights(oem, highest_dm) {
  const paths = Array.from({ length: BANDS }, () => new Path2D());
  const [x, y] = oem.origin_m ?? [0, 0];
  const side = oem.cell_m;
  for (const [column, row, height_dm] of oem.occupied ?? []) {
    const band = Math.min(BANDS - 1, Math.floor((height_dm * BANDS) / (highest_dm + 1)));
    paths[band].rect(x + column * side, y + row * side, side, side);
  }
  return paths;
}

// The cells of a raster of values: a path per band up to its maximum; cells of 0 are in none.
function pathsOfHeat(heat) {
  const paths = Array.from({ length: BANDS }, () => new Path2D());
  const [x, y] = heat.origin_m ?? [0, 0];
  const { cell_m: side, columns, maximum } = heat;
  (heat.values ?? []).forEach((value, index) => {
    const band = Math.min(BANDS, Math.ceil((value / maximum) * BANDS)) - 1;
    paths[band]?.rect(x + (index % columns) * side, y + Math.floor(index / columns) * side, side, side);
  });
  return paths;
}

// The height that the darkest band ends at: the town's highest, so that colours stay as they are
// while the map grows.
function highestDm(oem) {
  const doc = town();
  if (doc) {
    const highest = fromDocument(doc, 'highest', () =>
      Math.max(0, ...(doc.features ?? []).map((f) => f.properties?.height_m ?? 0)));
    if (highest > 0) return highest * 10;
  }
  return fromDocument(oem, 'highest', () =>
    (oem.occupied ?? []).reduce((most, cell) => Math.max(most, cell[2]), 1));
}

function inPixels(path) {
  const pixels = new Path2D();
  pixels.addPath(path, worldMatrix());
  return pixels;
}

// Paints a path of the world; widths are in pixels of the page, whatever the zoom.
function paint(context, path, { fill, fillAlpha, stroke, width = 1, dash = [], alpha = 1 }) {
  const pixels = inPixels(path);
  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  if (fill) {
    context.globalAlpha = fillAlpha ?? alpha;
    context.fillStyle = fill;
    context.fill(pixels, 'evenodd');
  }
  if (stroke) {
    context.globalAlpha = alpha;
    context.strokeStyle = stroke;
    context.lineWidth = width * camera.dpr;
    context.lineJoin = 'round';
    context.setLineDash(dash.map((length) => length * camera.dpr));
    context.stroke(pixels);
  }
  context.restore();
}

// Hatching that stays with the ground when the map is moved.
const tiles = new Map();
function hatch(context, { colour, spacing_px, width_px, falling }, dpr, follow) {
  const key = [colour, spacing_px, width_px, falling, dpr].join();
  if (!tiles.has(key)) {
    const side = Math.min(200, Math.max(2, Math.round(spacing_px * Math.SQRT2 * dpr) || 0));
    const tile = new OffscreenCanvas(side, side);
    const pen = tile.getContext('2d');
    pen.strokeStyle = colour;
    pen.lineWidth = width_px * dpr;
    // The corners belong to the lines of the neighbours.
    for (const shift of [-side, 0, side]) {
      pen.beginPath();
      pen.moveTo(shift - 2, falling ? -2 : side + 2);
      pen.lineTo(shift + side + 2, falling ? side + 2 : -2);
      pen.stroke();
    }
    tiles.set(key, tile);
  }
  const pattern = context.createPattern(tiles.get(key), 'repeat');
  if (follow) {
    const [x, y] = toPixel([0, 0]);
    pattern.setTransform(new DOMMatrix([1, 0, 0, 1, x * dpr, y * dpr]));
  }
  return pattern;
}

// Words on a white halo.
function label(context, text, [x, y], { colour = '#222222', size = 12, bold = true } = {}) {
  context.font = `${bold ? '650 ' : ''}${size}px system-ui, "DejaVu Sans", sans-serif`;
  context.textAlign = 'center';
  context.lineJoin = 'round';
  context.lineWidth = 3.5;
  context.strokeStyle = '#ffffff';
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

// Whether two boxes [x, y, width, height] overlap.
const overlap = (a, b) =>
  a[0] < b[0] + b[2] && b[0] < a[0] + a[2] && a[1] < b[1] + b[3] && b[1] < a[1] + a[3];
