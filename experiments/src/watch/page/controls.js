// Layers, which are the legend too, and the choice of an agent.

const COMMON_LAYERS = [
  { group: 'the fleet' },
  { id: 'paths', words: 'paths', sample: lineSample([], 2.4) },
  { id: 'footprints', words: 'footprints of the cameras', sample: lineSample([5, 3], 1.4) },
  { id: 'plans', words: 'plans', sample: lineSample([1.5, 3], 1.8) },
  { id: 'links', words: 'messages: arrived, or lost because of', sample: linkSample, reasons: true },
  { group: 'the truth' },
  { id: 'buildings', words: 'buildings, darker when higher', sample: boxSample('#B5B5B5', COLOUR.buildingEdge) },
  { id: 'roads', words: 'roads', sample: boxSample(COLOUR.road, COLOUR.road) },
  { id: 'cars', words: 'cars: known, not known', sample: carsSample },
];
let LAYERS = [];
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

// Makes the switches of the mission's layers and of the common ones; what was switched off stays off.
function makeLayers() {
  const own = styles.map((style) => ({ id: switchOf(style), words: wordsOf(style), sample: sampleOf(style) }));
  LAYERS = [...(own.length ? [{ group: 'what it knows' }, ...own] : []), ...COMMON_LAYERS];
  const off = new Set([...switches].filter(([, input]) => !input.checked).map(([id]) => id));
  switches.clear();
  byId('layers').replaceChildren(...LAYERS.flatMap((layer) => layer.group ? groupTitle(layer) : layerSwitch(layer, off)));
}

function groupTitle({ group }) {
  const title = document.createElement('h3');
  title.textContent = group[0].toUpperCase() + group.slice(1);
  return [title];
}

function layerSwitch(layer, off) {
  const label = document.createElement('label');
  const input = document.createElement('input');
  [input.type, input.checked, input.id] = ['checkbox', !off.has(layer.id), `layer-${layer.id}`];
  input.addEventListener('change', () => redraw('all'));
  const words = document.createElement('span');
  words.textContent = layer.words;
  words.id = `words-${layer.id}`;
  label.append(input, sampleCanvas(28, 16, layer.sample), words);
  switches.set(layer.id, input);
  return layer.reasons ? [label, reasonList()] : [label];
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

// The values that the colours of layers reach to.
function showScales() {
  for (const style of styles) setText(`words-${switchOf(style)}`, wordsOf(style));
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
