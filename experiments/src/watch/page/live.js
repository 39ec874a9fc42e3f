// A fleet that flies: batches of the newest documents, about ten a second.

const live = { events: null, generation: null, held: {}, heard: null, ended: false, step: false, done: Promise.resolve() };
// Quiet for longer than this, a fleet is not taken for flying.
const QUIET_MS = 3000;

function startLive() {
  listenToEvents();
  setInterval(showLive, 1000);
}

// Opens the stream for the agent that is drawn; the browser comes back by itself when it breaks.
function listenToEvents() {
  live.events?.close();
  live.events = new EventSource(`/events?agent=${state.agent}`);
  live.events.addEventListener('batch', (event) => {
    // One after the other: the first of a mission waits for its past.
    live.done = live.done.then(() => takeBatch(JSON.parse(event.data))).catch(console.error);
  });
  live.events.addEventListener('open', showLive);
  live.events.addEventListener('error', showLive);
}

async function takeBatch(batch) {
  const isNew = batch.generation !== live.generation || batch.run !== state.run;
  if (isNew) {
    live.generation = batch.generation;
    forgetAll();
    live.held = {};
    camera.touched = false;
    state.run = batch.run;
    if (batch.generation > 0) await loadSeries();
  }
  state.lost = batch.lost;
  live.ended = batch.ended;
  if (Object.keys(batch.documents).length) live.heard = performance.now();
  if (state.playing || live.step || isNew) {
    live.step = false;
    const hadTown = town();
    takeDocuments({ ...live.held, ...batch.documents });
    live.held = {};
    if (!camera.touched && town() !== hadTown) fit();
    redraw('all');
  } else {
    Object.assign(live.held, batch.documents);
  }
  showLive();
}

// Paths and curves from before this page, or from while it was paused.
async function loadSeries() {
  try {
    takeSeries(await ask('/series'));
  } catch {
    // The curves begin now then; the stream says whether the server is there.
  }
}

function behind() {
  const times = Object.values(live.held).map((doc) => doc.time_s).filter(isNumber);
  return times.length ? Math.max(...times) - (state.time ?? 0) : 0;
}

async function resume() {
  await loadSeries();
  takeDocuments(live.held);
  live.held = {};
  redraw('all');
}

function showLive() {
  const open = live.events.readyState === EventSource.OPEN;
  const quiet = live.heard === null ? null : performance.now() - live.heard;
  if (!open) showConnection('bad', live.heard === null ? 'connecting' : 'connection lost, trying again');
  else if (quiet === null) showConnection('', 'waiting');
  else if (!state.playing && behind() > 0) showConnection('held', 'paused');
  else if (live.ended) showConnection('held', endInWords(town()?.period_s ?? 0));
  else if (!state.playing) showConnection('held', 'paused');
  else if (quiet > QUIET_MS) showConnection('', `quiet for ${Math.round(quiet / 1000)} s`);
  else showConnection('good', 'live');
  const held = state.playing ? 0 : behind();
  const lost = state.lost ? `${state.lost} documents missed` : '';
  setText('moment', held > 0 ? `${held.toFixed(1)} s behind` : lost);
  showEmpty(quiet === null && open
    ? 'No fleet is heard yet. Its UAVs show here as soon as they fly; csat watch reaches them with --connect ENDPOINT.'
    : null);
}
