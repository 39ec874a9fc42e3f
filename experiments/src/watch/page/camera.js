// From metres of the world (east, north) to pixels, by pan and zoom.

const camera = { x: 0, y: 0, scale: 1, width: 1, height: 1, dpr: 1, touched: false };

const toPixel = ([x, y]) =>
  [camera.width / 2 + (x - camera.x) * camera.scale, camera.height / 2 - (y - camera.y) * camera.scale];
const toWorld = ([px, py]) =>
  [camera.x + (px - camera.width / 2) / camera.scale, camera.y - (py - camera.height / 2) / camera.scale];

// World to device pixels.
function worldMatrix() {
  const { x, y, scale, width, height, dpr } = camera;
  const s = scale * dpr;
  return new DOMMatrix([s, 0, 0, -s, dpr * width / 2 - x * s, dpr * height / 2 + y * s]);
}

// The rectangle that is worth seeing: the region, and UAVs that fly beside it.
function extent() {
  const size = town()?.size_m;
  let [west, south, east, north] = [Infinity, Infinity, -Infinity, -Infinity];
  const include = ([x, y]) => {
    [west, east] = [Math.min(west, x), Math.max(east, x)];
    [south, north] = [Math.min(south, y), Math.max(north, y)];
  };
  const reach = size ? [size[0] * 0.65, size[1] * 0.65] : [Infinity, Infinity];
  if (size) [[-0.5, -0.5], [0.5, 0.5]].forEach(([a, b]) => include([a * size[0], b * size[1]]));
  for (const path of state.paths.values()) {
    for (const [, x, y] of path) if (Math.abs(x) < reach[0] && Math.abs(y) < reach[1]) include([x, y]);
  }
  return west < east && south < north ? [west, south, east, north] : [-250, -250, 250, 250];
}

function fit() {
  const [west, south, east, north] = extent();
  const room = Math.min(camera.width, camera.height) * 0.04 + 8;
  camera.scale = Math.min(
    (camera.width - 2 * room) / (east - west), (camera.height - 2 * room) / (north - south));
  [camera.x, camera.y] = [(west + east) / 2, (south + north) / 2];
  camera.touched = false;
  redraw('all');
}

function zoomAt(pixel, factor) {
  const before = toWorld(pixel);
  camera.scale = Math.min(200, Math.max(0.01, camera.scale * factor));
  const after = toWorld(pixel);
  camera.x += before[0] - after[0];
  camera.y += before[1] - after[1];
  camera.touched = true;
  redraw('all');
}

function panBy(dx, dy) {
  camera.x -= dx / camera.scale;
  camera.y += dy / camera.scale;
  camera.touched = true;
  redraw('all');
}

// Fits until the user chose a place.
function resizeMap() {
  const box = byId('map').getBoundingClientRect();
  camera.dpr = Math.min(window.devicePixelRatio || 1, 3);
  [camera.width, camera.height] = [Math.max(box.width, 1), Math.max(box.height, 1)];
  for (const id of ['ground', 'fleet']) {
    byId(id).width = Math.round(camera.width * camera.dpr);
    byId(id).height = Math.round(camera.height * camera.dpr);
  }
  if (camera.touched) redraw('all');
  else fit();
}

// One pointer pans, two zoom; a tap chooses the UAV beneath it.
function listenToPointers(canvas, tapped) {
  const pointers = new Map();
  let moved = 0;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], length: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  };
  canvas.addEventListener('pointerdown', (event) => {
    if (event.button > 0) return;
    canvas.setPointerCapture(event.pointerId);
    moved = pointers.size ? Infinity : 0;
    pointers.set(event.pointerId, at(event));
    canvas.classList.add('dragged');
  });
  canvas.addEventListener('pointermove', (event) => {
    const now = at(event);
    showWhere(event.pointerType === 'mouse' ? toWorld(now) : null);
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const before = pointers.size === 2 ? spread() : null;
    pointers.set(event.pointerId, now);
    moved += Math.hypot(now[0] - last[0], now[1] - last[1]);
    if (before) {
      const after = spread();
      panBy(after.middle[0] - before.middle[0], after.middle[1] - before.middle[1]);
      if (before.length > 0) zoomAt(after.middle, after.length / before.length);
    } else if (pointers.size === 1 && moved > 3) {
      panBy(now[0] - last[0], now[1] - last[1]);
    }
  });
  const released = (event) => {
    if (event.type === 'pointerup' && pointers.has(event.pointerId) && moved <= 3) tapped(at(event));
    pointers.delete(event.pointerId);
    if (!pointers.size) canvas.classList.remove('dragged');
  };
  canvas.addEventListener('pointerup', released);
  canvas.addEventListener('pointercancel', released);
  canvas.addEventListener('pointerleave', () => showWhere(null));
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;
    zoomAt(at(event), Math.exp(-Math.max(-240, Math.min(240, event.deltaY * lines)) / 400));
  }, { passive: false });
}

function showWhere(point) {
  byId('where').textContent = point ? inWords(point[0], point[1], 1) : '';
}
