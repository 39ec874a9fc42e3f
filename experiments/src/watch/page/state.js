// What the page knows: the newest document of each topic, paths and curves.

const LIVE = document.documentElement.dataset.mode === 'live';
const MAX_POINTS = 8192;
const MAX_AGENTS = 1024;

const state = {
  docs: {},            // topic -> document, as it is shown now
  paths: new Map(),    // agent -> [[time_s, x, y], ...]
  metrics: [],         // documents of truth/metrics, by time
  time: null,          // simulated seconds that are shown
  agent: 0,            // whose knowledge is drawn
  run: '',
  lost: 0,
  playing: LIVE,
  arrived: new Map(),  // agent -> when its links document came, ms of the page
};

const byId = (id) => document.getElementById(id);
const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
const view = (agent, name) => state.docs[`view/${agent}/${name}`];
const town = () => state.docs['truth/town'];
// Where an agent is, [x, y, z] in metres.
function placeOf(agent) {
  const place = view(agent, 'pose')?.p_world;
  return Array.isArray(place) && place.length === 3 && place.every(isNumber) ? place : null;
}
const metricsNow = () => state.docs['truth/metrics'];

function forgetAll() {
  state.docs = {};
  state.paths.clear();
  state.metrics = [];
  state.time = null;
  state.arrived.clear();
}

// Paths and curves of the past, from /series.
function takeSeries(series) {
  state.paths = new Map(Object.entries(series.paths).map(([agent, path]) => [Number(agent), path]));
  state.metrics = series.metrics;
}

// Adds newer documents to what is shown.
function takeDocuments(documents) {
  let newest = state.time ?? -Infinity;
  for (const [topic, doc] of Object.entries(documents)) {
    const [root, agent, name] = topic.split('/');
    if (name === 'links' && doc.step !== state.docs[topic]?.step) {
      state.arrived.set(Number(agent), performance.now());
    }
    state.docs[topic] = doc;
    if (!isNumber(doc.time_s)) continue;
    if (root === 'view' || topic === 'truth/metrics') newest = Math.max(newest, doc.time_s);
    if (name === 'pose' && LIVE) growPath(Number(agent), doc);
    if (topic === 'truth/metrics' && LIVE) grow(state.metrics, doc, (point) => point.time_s);
  }
  if (newest > -Infinity) state.time = newest;
  if (takeStyles()) makeLayers();
}

function growPath(agent, pose) {
  if (!placeOf(agent)) return;
  if (!state.paths.has(agent)) state.paths.set(agent, []);
  const [x, y] = pose.p_world;
  grow(state.paths.get(agent), [pose.time_s, x, y], (point) => point[0]);
}

// Appends to a series by time; a long one loses every second point.
function grow(series, point, timeOf) {
  if (series.length && timeOf(point) <= timeOf(series[series.length - 1])) return;
  series.push(point);
  if (series.length > MAX_POINTS) {
    const kept = series.filter((_, index) => index % 2 === 0);
    series.length = 0;
    series.push(...kept);
  }
}

// Number of entries of a series that are not after the time that is shown.
function countUntil(series, timeOf) {
  const time = (state.time ?? Infinity) + 1e-6;
  let [low, high] = [0, series.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timeOf(series[middle]) <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

// UAVs are numbered first, ground stations after them.
const uavCount = () => (isNumber(town()?.agents) ? town().agents : null);
const stationCount = () => (Array.isArray(town()?.stations) ? town().stations.length : 0);
const isStation = (agent) => uavCount() !== null && agent >= uavCount() && agent < uavCount() + stationCount();
const nameOf = (agent) => `${isStation(agent) ? 'station' : 'UAV'} ${agent}`;
const shortName = (agent) => `${isStation(agent) ? 'S' : 'U'}${agent}`;

// Agents 0..n-1: as many as the town says or as were heard.
function agentCount() {
  let count = (uavCount() ?? 0) + stationCount();
  for (const topic of Object.keys(state.docs)) {
    const [root, agent] = topic.split('/');
    const number = root === 'view' ? Number(agent) : NaN;
    if (number < MAX_AGENTS) count = Math.max(count, number + 1);
  }
  return Math.min(count, MAX_AGENTS);
}

function targetCount() {
  return town()?.targets ?? state.docs['truth/targets']?.targets?.length ?? null;
}

// Who does not run: what the truth says, and who is new has not begun.
function isDown(agent) {
  return metricsNow()?.alive?.[agent] === false;
}

// Who runs and has not told of this step in time: in real time nobody waits for whoever is slow.
function isLate(agent) {
  return metricsNow()?.late?.[agent] === true;
}

// A value made from a document once, as long as the document lives.
const made = new WeakMap();
function fromDocument(doc, name, make) {
  if (!made.has(doc)) made.set(doc, new Map());
  const values = made.get(doc);
  if (!values.has(name)) values.set(name, make(doc));
  return values.get(name);
}
