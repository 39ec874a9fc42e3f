// What lies on the ground: the truth and what one agent knows, from the bottom up.

function drawGround(context) {
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = COLOUR.paper;
  context.fillRect(0, 0, context.canvas.width, context.canvas.height);
  const size = town()?.size_m;
  const region = size && regionPath(size);
  if (region) paint(context, region, { fill: COLOUR.region });
  context.save();
  if (region) context.clip(inPixels(region));
  drawHeights(context, true);
  if (layerShown('roads')) drawRoads(context);
  drawLayers(context, true);
  if (layerShown('buildings')) drawBuildings(context);
  drawHeights(context, false);
  drawLayers(context, false);
  context.restore();
  if (region) paint(context, region, { stroke: COLOUR.border, width: 1.2 });
  context.setTransform(camera.dpr, 0, 0, camera.dpr, 0, 0);
  drawScale(context);
}

function regionPath([width, depth]) {
  const path = new Path2D();
  path.rect(-width / 2, -depth / 2, width, depth);
  return path;
}

function drawRoads(context) {
  const doc = town();
  if (!doc) return;
  const path = fromDocument(doc, 'roads', () => {
    const roads = new Path2D();
    for (const { geometry, properties } of doc.features ?? []) {
      if (properties?.kind !== 'road') continue;
      const lines = geometry.type === 'LineString' ? [geometry.coordinates] : geometry.coordinates;
      for (const line of lines) {
        line.forEach(([x, y], index) => (index ? roads.lineTo(x, y) : roads.moveTo(x, y)));
      }
    }
    return roads;
  });
  paint(context, path, { stroke: COLOUR.road, width: Math.max(6 * camera.scale, 1.5), alpha: 0.8 });
}

// Darker when higher.
function drawBuildings(context) {
  const doc = town();
  if (!doc) return;
  const bands = fromDocument(doc, 'buildings', () => {
    const buildings = (doc.features ?? []).filter((f) => f.properties?.kind === 'building');
    const highest = Math.max(1, ...buildings.map((f) => f.properties.height_m));
    return Array.from({ length: BANDS }, (_, band) => pathOfFeatures(buildings.filter((f) =>
      Math.min(BANDS - 1, Math.floor((f.properties.height_m / highest) * BANDS)) === band)));
  });
  bands.forEach((path, band) => {
    const grey = Math.round(212 - (band * 70) / (BANDS - 1));
    paint(context, path, { fill: `rgb(${grey},${grey},${grey})`, stroke: COLOUR.buildingEdge, width: 0.9 });
  });
}

// A bar of a round length, and north.
function drawScale(context) {
  const wanted = Math.min(160, camera.width / 4) / camera.scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length_m = [5, 2, 1].map((f) => f * power).find((length) => length <= wanted);
  const length = length_m * camera.scale;
  const [x, y] = [14, camera.height - 16];
  context.fillStyle = '#ffffffd9';
  context.fillRect(x - 6, y - 20, Math.max(length + 12, 60), 28);
  context.fillStyle = '#222222';
  context.fillRect(x, y, length, 3);
  context.fillRect(x, y - 4, 1.5, 7);
  context.fillRect(x + length - 1.5, y - 4, 1.5, 7);
  context.textAlign = 'left';
  context.font = '12px system-ui, "DejaVu Sans", sans-serif';
  context.fillText(length_m >= 1000 ? `${length_m / 1000} km` : `${length_m} m`, x, y - 7);
  context.beginPath();
  [[20, 12], [27, 32], [20, 27], [13, 32]].forEach(([a, b]) => context.lineTo(a, b));
  context.fill();
  context.font = '650 11px system-ui, "DejaVu Sans", sans-serif';
  context.textAlign = 'center';
  context.fillText('N', 20, 45);
}
