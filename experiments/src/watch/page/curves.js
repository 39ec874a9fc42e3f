// The curves below the map, which truth/columns lists, and the time that is shown in them.

// What each mission has, whatever else it measures.
const SENT = { title: 'Sent per step', unit: 'B', curves: [{ key: 'bytes_sent', name: '', colour: '#5D3A9B' }] };
let curves = [];
let curvesOf = '';     // the document that `curves` is made from, as text
let hovered = null;

const columns = () => state.docs['truth/columns'];
const column = (key) => columns()?.columns?.find((one) => one.key === key);

// Makes the figures anew when another mission says what it measures.
function makeCurves(seek) {
  const doc = columns();
  const text = JSON.stringify(doc ?? null);
  if (text === curvesOf) return;
  curvesOf = text;
  curves = [...(doc?.panels ?? []), SENT].map((panel) => makeCurve(panel, seek));
  byId('curves').replaceChildren(...curves.map((curve) => curve.figure));
}

function makeCurve(panel, seek) {
  const figure = document.createElement('figure');
  figure.className = 'curve';
  const caption = document.createElement('figcaption');
  const name = document.createElement('span');
  name.textContent = panel.title;
  const drawn = panel.curves.map(({ key, name: of }, index) =>
    [index ? 'dashed: ' : '', of, column(key)?.meaning].filter(Boolean).join(of ? ' ' : ''));
  name.title = [panel.title, ...drawn.filter(Boolean)].join('; ');
  const output = document.createElement('output');
  caption.append(name, output);
  const canvas = document.createElement('canvas');
  canvas.setAttribute('role', 'img');
  figure.append(caption, canvas);
  listenToCurve(canvas, seek);
  return { ...panel, figure, output, canvas };
}

function listenToCurve(canvas, seek) {
  const timeAt = (event) => {
    const box = canvas.getBoundingClientRect();
    const plot = plotBox(box.width, box.height);
    const [from, to] = timeSpan();
    const share = (event.clientX - box.left - plot.left) / plot.width;
    return from + Math.min(1, Math.max(0, share)) * (to - from);
  };
  canvas.addEventListener('pointerdown', (event) => {
    if (LIVE) return;
    canvas.setPointerCapture(event.pointerId);
    seek(timeAt(event));
  });
  canvas.addEventListener('pointermove', (event) => {
    if (event.buttons && !LIVE) return seek(timeAt(event));
    hovered = event.pointerType === 'mouse' ? timeAt(event) : null;
    redraw('curves');
  });
  canvas.addEventListener('pointerleave', () => {
    hovered = null;
    redraw('curves');
  });
}

const plotBox = (width, height) => ({ left: 30, top: 6, width: width - 36, height: height - 22 });

// All of a recording; of a fleet that flies what was heard.
function timeSpan() {
  const first = state.metrics[0]?.time_s ?? 0;
  const last = state.metrics[state.metrics.length - 1]?.time_s ?? 0;
  const span = LIVE ? [first, last] : recordedSpan();
  return span[1] > span[0] ? span : [span[0], span[0] + 1];
}

// The next 1, 2 or 5 times a power of ten.
function roundUp(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((f) => f * power).find((f) => f >= value * 0.999);
}

function short(value, unit) {
  if (!isNumber(value)) return '–';
  let [number, of] = [value, unit];
  if (unit === 'B' && Math.abs(value) >= 1e6) [number, of] = [value / 1e6, 'MB'];
  else if (unit === 'B' && Math.abs(value) >= 1e3) [number, of] = [value / 1e3, 'kB'];
  const digits = Number.isInteger(number) || Math.abs(number) >= 100 ? 0 : 1;
  return of ? `${number.toFixed(digits)} ${of}` : number.toFixed(digits);
}

function drawCurves() {
  makeCurves(seek);
  const until = LIVE && state.playing ? state.metrics.length : countUntil(state.metrics, (m) => m.time_s);
  for (const curve of curves) drawCurve(curve, until);
}

function drawCurve(curve, until) {
  const { canvas } = curve;
  const [width, height, dpr] = [canvas.clientWidth, canvas.clientHeight, camera.dpr];
  if (!width || !height) return;
  if (canvas.width !== Math.round(width * dpr)) canvas.width = Math.round(width * dpr);
  if (canvas.height !== Math.round(height * dpr)) canvas.height = Math.round(height * dpr);
  const context = canvas.getContext('2d');
  context.setTransform(dpr, 0, 0, dpr, 0, 0);
  context.clearRect(0, 0, width, height);
  const plot = plotBox(width, height);
  const [from, to] = timeSpan();
  let most = 0;
  for (const point of state.metrics) for (const { key } of curve.curves) if (point[key] > most) most = point[key];
  const top = (curve.unit === 'targets' ? targetCount() : curve.top) ?? roundUp(most);
  const x = (time) => plot.left + ((time - from) / (to - from)) * plot.width;
  const y = (value) => plot.top + (1 - value / top) * plot.height;
  drawAxes(context, plot, top, curve.unit, from, to);
  curve.curves.forEach(({ key, colour }, index) => {
    const pen = { colour, dash: index ? [3, 3] : [] };
    drawSeries(context, key, x, y, until, pen);
  });
  drawMoments(context, plot, x, until);
  const time = hovered ?? state.time;
  const value = valueAt(curve.curves[0].key, time);
  const unit = curve.unit === 'targets' ? '' : curve.unit;
  curve.output.textContent = short(value, unit);
  canvas.setAttribute('aria-label', `${curve.title}: ${short(value, unit)}`);
  if (isNumber(time) && state.metrics.length) drawCursor(context, plot, x(time), isNumber(value) ? y(value) : null);
}

function drawAxes(context, plot, top, unit, from, to) {
  context.font = '10px system-ui, "DejaVu Sans", sans-serif';
  context.fillStyle = '#595959';
  context.strokeStyle = '#e2e2e2';
  context.lineWidth = 1;
  context.textAlign = 'right';
  context.textBaseline = 'middle';
  for (const share of [0, 0.5, 1]) {
    const y = Math.round(plot.top + (1 - share) * plot.height) + 0.5;
    context.beginPath();
    context.moveTo(plot.left, y);
    context.lineTo(plot.left + plot.width, y);
    context.stroke();
    const text = unit === 'B' ? short(share * top, 'B').replace(/ ?B$/, '').replace(' k', 'k').replace(' M', 'M') : String(+(share * top).toPrecision(3));
    if (share !== 0.5 || plot.height > 50) context.fillText(text, plot.left - 4, y);
  }
  context.textBaseline = 'alphabetic';
  context.textAlign = 'left';
  context.fillText(`${+from.toFixed(1)}`, plot.left, plot.top + plot.height + 13);
  context.textAlign = 'right';
  context.fillText(`${+to.toFixed(1)} s`, plot.left + plot.width, plot.top + plot.height + 13);
}

// What lies ahead in a recording is pale.
function drawSeries(context, key, x, y, until, { colour, dash }) {
  const stroke = (from, to, alpha) => {
    context.save();
    context.beginPath();
    let open = false;
    for (let i = from; i < to; i++) {
      const { time_s, [key]: value } = state.metrics[i];
      if (isNumber(value)) context[open ? 'lineTo' : 'moveTo'](x(time_s), y(value));
      open = isNumber(value);
    }
    context.globalAlpha = alpha;
    context.strokeStyle = colour;
    context.lineWidth = 1.7;
    context.lineJoin = 'round';
    context.setLineDash(dash);
    context.stroke();
    context.restore();
  };
  stroke(0, until, 1);
  if (!LIVE) stroke(Math.max(until - 1, 0), state.metrics.length, 0.3);
}

// Violations (red lines) and crashes (crosses) when they happened.
function drawMoments(context, plot, x, until) {
  for (let i = 0; i < until; i++) {
    const [before, now] = [state.metrics[i - 1], state.metrics[i]];
    if ((now.violations ?? 0) > (before?.violations ?? 0)) {
      context.fillStyle = '#B33A00';
      context.fillRect(x(now.time_s) - 1, plot.top, 2, plot.height);
    }
    if (Array.isArray(now.alive) && now.alive.some((alive, agent) => !alive && before?.alive?.[agent] !== false)) {
      context.strokeStyle = '#222222';
      context.lineWidth = 1.5;
      const [px, py] = [x(now.time_s), plot.top + plot.height];
      context.beginPath();
      for (const [a, b] of [[-3, -3], [-3, 3]]) {
        context.moveTo(px + a, py + b);
        context.lineTo(px - a, py - b);
      }
      context.stroke();
    }
  }
}

function drawCursor(context, plot, x, y) {
  context.strokeStyle = '#222222';
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(Math.round(x) + 0.5, plot.top - 4);
  context.lineTo(Math.round(x) + 0.5, plot.top + plot.height);
  context.stroke();
  if (y === null) return;
  context.beginPath();
  context.arc(x, y, 3, 0, 7);
  context.fillStyle = '#222222';
  context.fill();
}

// The last value of a series at a time.
function valueAt(key, time) {
  if (!isNumber(time)) return null;
  let found = null;
  for (const point of state.metrics) {
    if (point.time_s > time + 1e-6) break;
    found = point[key];
  }
  return found;
}
