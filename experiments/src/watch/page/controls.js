// Layers, which are the legend too, and the choice of an agent.

const LAYERS = [
  { group: 'what it knows' },
  { id: 'unexplored', words: 'X̄ unexplored: other cars can only be here', on: true, sample: boxSample(COLOUR.unexplored, COLOUR.unexploredEdge) },
  { id: 'targets', words: 'Xⱼ: the identified car j is in it (◉ seen now)', on: true, sample: boxSample('rgba(0,158,115,0.55)', COLOUR.targetEdge) },
  { id: 'hidden', words: 'ground hidden and not seen since', on: true, sample: hatchSample(HIDDEN_HATCH) },
  { id: 'obstacles', words: 'X° obstacle margin: no car can be here', on: true, sample: hatchSample(MARGIN_HATCH, '#000000') },
  { id: 'oem', words: 'buildings as known (OEM)', on: true, sample: heightsSample, heights: true },
  { group: 'the fleet' },
  { id: 'paths', words: 'paths', on: true, sample: lineSample([], 2.4) },
  { id: 'footprints', words: 'footprints of the cameras', on: true, sample: lineSample([5, 3], 1.4) },
  { id: 'plans', words: 'plans', on: true, sample: lineSample([1.5, 3], 1.8) },
  { id: 'links', words: 'messages: arrived, or lost because of', on: true, sample: linkSample, reasons: true },
  { group: 'the truth' },
  { id: 'buildings', words: 'buildings, darker when higher', on: true, sample: boxSample('#B5B5B5', COLOUR.buildingEdge) },
  { id: 'roads', words: 'roads', on: true, sample: boxSample(COLOUR.road, COLOUR.road) },
  { id: 'cars', words: 'cars: known, not known', on: true, sample: carsSample },
];
const switches = new Map();
const layerShown = (id) => switches.get(id).checked;

function boxSample(fill, stroke) {
  return (context) => {
    context.fillStyle = fill;
    context.strokeStyle = stroke;
    context.fillRect(0.5, 0.5, 27, 15);
    context.strokeRect(0.5, 0.5, 27, 15);
  };
}

function hatchSample(style, stroke) {
  return (context, dpr) => {
    // Patterns count in device pixels.
    context.save();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = hatch(context, style, dpr, false);
    context.fillRect(0, 0, 28 * dpr, 16 * dpr);
    context.restore();
    if (stroke) context.strokeRect(0.5, 0.5, 27, 15);
  };
}

function lineSample(dash, width) {
  return (context) => {
    context.strokeStyle = uavColour(0);
    context.lineWidth = width;
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(1, 8);
    context.lineTo(27, 8);
    context.stroke();
  };
}

function linkSample(context) {
  context.strokeStyle = COLOUR.delivered;
  context.lineWidth = 1.6;
  context.beginPath();
  context.moveTo(1, 4);
  context.lineTo(27, 4);
  context.stroke();
  context.strokeStyle = OUTCOMES.range.colour;
  context.setLineDash([5, 4]);
  context.beginPath();
  context.moveTo(1, 12);
  context.lineTo(27, 12);
  context.stroke();
}

function heightsSample(context) {
  context.fillStyle = COLOUR.oemEmpty;
  context.fillRect(0, 0, 8, 16);
  for (let band = 0; band < BANDS; band++) {
    context.fillStyle = oemColour(band);
    context.fillRect(8 + band * 4, 0, 4, 16);
  }
}

function carsSample(context) {
  for (const [x, fill, stroke] of [[4, '#000000', '#ffffff'], [17, '#ffffff', '#000000']]) {
    context.fillStyle = fill;
    context.strokeStyle = stroke;
    context.lineWidth = 1.4;
    context.fillRect(x, 4, 8, 8);
    context.strokeRect(x, 4, 8, 8);
  }
}

function sampleCanvas(width, height, draw) {
  const dpr = Math.min(window.devicePixelRatio || 1, 3);
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [width * dpr, height * dpr];
  const context = canvas.getContext('2d');
  context.scale(dpr, dpr);
  draw(context, dpr);
  return canvas;
}

function makeLayers() {
  for (const layer of LAYERS) {
    if (layer.group) {
      const title = document.createElement('h3');
      title.textContent = layer.group[0].toUpperCase() + layer.group.slice(1);
      byId('layers').append(title);
      continue;
    }
    const label = document.createElement('label');
    const input = document.createElement('input');
    [input.type, input.checked, input.id] = ['checkbox', layer.on, `layer-${layer.id}`];
    input.addEventListener('change', () => redraw('all'));
    const words = document.createElement('span');
    words.textContent = layer.words;
    words.id = `words-${layer.id}`;
    label.append(input, sampleCanvas(28, 16, layer.sample), words);
    byId('layers').append(label);
    switches.set(layer.id, input);
    if (layer.reasons) byId('layers').append(reasonList());
  }
}

function reasonList() {
  const list = document.createElement('ul');
  for (const outcome of Object.values(OUTCOMES)) {
    const item = document.createElement('li');
    item.append(sampleCanvas(16, 16, (context) => drawReason(context, [8, 8], outcome, 7)), outcome.words);
    list.append(item);
  }
  return list;
}

// The heights that the colours of the OEM reach to.
function showHeights() {
  const highest_m = Math.round(highestDm() / 10);
  setText('words-oem', `buildings as known (OEM): empty${highest_m > 0 ? `, up to ${highest_m} m` : ''}`);
}

// A button for each agent, with the first of its numbers.
function showAgents() {
  const box = byId('agents');
  const count = agentCount();
  while (box.children.length > count) box.lastChild.remove();
  while (box.children.length < count) box.append(agentButton(box.children.length));
  for (let agent = 0; agent < count; agent++) {
    const button = box.children[agent];
    const title = `What ${nameOf(agent)} knows${agent < 10 ? ` (key ${agent})` : ''}`;
    if (button.title !== title) [button.title, button.firstChild.textContent] = [title, shortName(agent)];
    const down = isDown(agent);
    const pressed = String(agent === state.agent);
    if (button.getAttribute('aria-pressed') !== pressed) button.setAttribute('aria-pressed', pressed);
    button.classList.toggle('down', down);
    const stats = view(agent, 'stats');
    const first = columns()?.columns?.find(({ key }) => isNumber(stats?.[key]));
    const text = down ? 'crashed' : first ? inUnit(stats[first.key], first.unit) : '–';
    if (button.lastChild.textContent !== text) button.lastChild.textContent = text;
  }
}

function agentButton(agent) {
  const button = document.createElement('button');
  button.type = 'button';
  button.style.setProperty('--of-uav', uavColour(agent));
  const name = document.createElement('span');
  button.append(name, document.createElement('small'));
  button.addEventListener('click', () => chooseAgent(agent));
  return button;
}

function setText(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}
