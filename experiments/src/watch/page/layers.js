// What an agent knows, layer by layer, as the document truth/layers says.

// The layers of recordings that do not say theirs.
const OLD_LAYERS = {{layers}};

// The layers of the mission, from the bottom up.
let styles = [];

const isStyle = (style) => /^[a-z0-9_-]+$/.test(style?.key) && Object.hasOwn(DRAWN, style.kind);

// Takes the layers of the documents that are shown; gives whether they are others than before.
function takeStyles() {
  const said = state.docs['truth/layers']?.layers;
  const next = (Array.isArray(said) ? said : OLD_LAYERS).filter(isStyle);
  if (JSON.stringify(next) === JSON.stringify(styles)) return false;
  styles = next;
  return true;
}

const switchOf = (style) => `view-${style.key}`;
const isShown = (style) => layerShown(switchOf(style));
const ofKind = (...kinds) => styles.filter((style) => kinds.includes(style.kind));

// Draws the layers that buildings cover, or the others.
function drawLayers(context, isGround) {
  for (const style of styles) {
    if (Boolean(style.ground) !== isGround || style.kind === 'heights' || !isShown(style)) continue;
    const doc = view(state.agent, style.key);
    if (doc) DRAWN[style.kind](context, style, doc);
  }
}

const DRAWN = {
  areas(context, style, doc) {
    for (const { path, properties } of fromDocument(doc, 'paths', pathsOfFeatures)) {
      paint(context, path, lookOf(context, style, properties));
    }
  },
  cells(context, style, doc) {
    paint(context, fromDocument(doc, 'path', pathOfRuns), lookOf(context, style, {}));
  },
  heights(context, style, doc) {
    const highest = highestDm(doc);
    const paths = fromDocument(doc, `heights ${highest}`, () => pathsOfHeights(doc, highest));
    drawBands(context, style, paths);
  },
  heat(context, style, doc) {
    drawBands(context, style, fromDocument(doc, 'bands', pathsOfHeat));
  },
  points(context, style, doc) {
    for (const { geometry, properties } of doc.features ?? []) {
      if (geometry?.type === 'Point') drawPoint(context, toPixel(geometry.coordinates), lookOf(context, style, properties));
    }
  },
};

function drawBands(context, style, paths) {
  paths.forEach((path, band) =>
    paint(context, path, { fill: colourOf(style.colour, {}), fillAlpha: bandAlpha(band) }));
}

// Cells that are known to be empty lie below everything, buildings as known lie on the true ones.
function drawHeights(context, isEmpty) {
  for (const style of ofKind('heights').filter(isShown)) {
    const doc = view(state.agent, style.key);
    if (!doc) continue;
    if (isEmpty) paint(context, fromDocument(doc, 'empty', () => pathOfRuns(doc.empty)), { fill: COLOUR.empty });
    else DRAWN.heights(context, style, doc);
  }
}

function drawPoint(context, [x, y], { fill, stroke }, dpr = camera.dpr) {
  context.save();
  context.setTransform(dpr, 0, 0, dpr, 0, 0);
  context.beginPath();
  context.arc(x, y, 5, 0, 7);
  context.fillStyle = fill;
  context.fill();
  context.strokeStyle = stroke ?? '#ffffff';
  context.lineWidth = 1.4;
  context.stroke();
  context.restore();
}

// A fixed colour, or that of the palette with the index that a property says.
function colourOf(colour, properties) {
  if (typeof colour?.fixed === 'string') return colour.fixed;
  const index = properties?.[colour?.by];
  return uavColour(Number.isInteger(index) && index >= 0 ? index : 0);
}

// How an area with these properties is painted.
function lookOf(context, style, properties, dpr = camera.dpr, follow = true) {
  const colour = colourOf(style.colour, properties);
  const { plain, hatch: lines } = style.fill ?? {};
  const look = { fill: style.kind === 'points' ? colour : null };
  if (plain) [look.fill, look.fillAlpha] = [colour, plain.opacity];
  if (lines) look.fill = hatch(context, { colour, ...lines }, dpr, follow);
  if (style.line) [look.stroke, look.width] = [colourOf(style.line.colour, properties), style.line.width_px];
  return look;
}

// What the styles say to write beside areas and points, a little aside when something is there already.
function drawNames(context, taken) {
  for (const style of ofKind('areas', 'points').filter((style) => style.label && isShown(style))) {
    for (const feature of view(state.agent, style.key)?.features ?? []) drawName(context, style, feature, taken);
  }
}

function drawName(context, style, feature, taken) {
  const highest = fromDocument(feature, 'highest', highestPoint);
  const said = feature.properties?.[style.label];
  if (!highest || said === undefined) return;
  const [x, y] = toPixel(highest);
  const name = feature.properties[style.mark] === true ? `${said} ◉` : `${said}`;
  const width = name.length * 8 + 4;
  const places = [[0, -5], [0, 22], [22, 8], [-22, 8], [26, -12], [-26, -12]];
  const boxAt = ([dx, dy]) => [x + dx - width / 2, y + dy - 12, width, 15];
  const free = places.find((place) => !taken.some((box) => overlap(box, boxAt(place)))) ?? places[0];
  taken.push(boxAt(free));
  const colour = colourOf(style.line?.colour ?? style.colour, feature.properties);
  label(context, name, [x + free[0], y + free[1]], { colour, size: 13 });
}

// The northernmost point of a feature.
function highestPoint(feature) {
  const { type, coordinates } = feature.geometry ?? {};
  const points = type === 'Point' ? [coordinates] : (coordinates ?? []).flat(2);
  return points.reduce((best, point) => (best && best[1] >= point[1] ? best : point), null);
}

// The targets that the layers of an agent name.
function targetsOf(agent) {
  const features = ofKind('areas', 'points').flatMap((style) => view(agent, style.key)?.features ?? []);
  return new Set(features.map((feature) => feature.properties?.target));
}

// The legend of a layer.
function sampleOf(style) {
  if (style.kind === 'heights' || style.kind === 'heat') return bandsSample(style);
  return (context, dpr) => {
    const { fill, fillAlpha = 1, stroke } = lookOf(context, style, {}, dpr, false);
    if (style.kind === 'points') return drawPoint(context, [14, 8], { fill, stroke }, dpr);
    context.save();
    // Patterns count in device pixels.
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = fillAlpha;
    context.fillStyle = fill ?? '#ffffff';
    context.fillRect(0, 0, 28 * dpr, 16 * dpr);
    context.restore();
    context.strokeStyle = stroke;
    if (stroke) context.strokeRect(0.5, 0.5, 27, 15);
  };
}

function bandsSample(style) {
  return (context) => {
    context.fillStyle = style.kind === 'heights' ? COLOUR.empty : '#ffffff';
    context.fillRect(0, 0, 8, 16);
    context.fillStyle = colourOf(style.colour, {});
    for (let band = 0; band < BANDS; band++) {
      context.globalAlpha = bandAlpha(band);
      context.fillRect(8 + band * 4, 0, 4, 16);
    }
    context.globalAlpha = 1;
  };
}

// What a layer is called, with the values that its colours reach to.
function wordsOf(style) {
  const doc = view(state.agent, style.key);
  if (style.kind === 'heights') {
    const highest_m = doc ? Math.round(highestDm(doc) / 10) : 0;
    return `${style.title}: empty${highest_m > 0 ? `, up to ${highest_m} m` : ''}`;
  }
  if (style.kind === 'heat' && isNumber(doc?.maximum)) {
    return `${style.title}: up to ${+doc.maximum.toPrecision(3)} ${style.unit ?? ''}`.trimEnd();
  }
  return style.mark ? `${style.title} (◉ ${style.mark})` : `${style.title}`;
}
