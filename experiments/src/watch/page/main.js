// The parts together: what is drawn when, buttons and keys.

const STILL = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
const stale = { ground: true, fleet: true, curves: true, words: true };
let scheduled = false;

// Draws a part ('ground', 'fleet', 'curves', 'words' or 'all') at the next frame.
function redraw(part) {
  for (const name of Object.keys(stale)) if (part === 'all' || part === name) stale[name] = true;
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(drawStale);
}

function drawStale(now) {
  scheduled = false;
  let fading = false;
  const parts = {
    words: () => [showHeader, showAgents, showScales, showDetails, showTransport].forEach(attempt),
    ground: () => drawGround(byId('ground').getContext('2d')),
    fleet: () => (fading = drawFleet(byId('fleet').getContext('2d'), now)),
    curves: drawCurves,
  };
  const wanted = Object.keys(stale).filter((name) => stale[name]);
  for (const name of wanted) stale[name] = false;
  wanted.forEach((name) => attempt(parts[name]));
  if (fading) redraw('fleet');
}

// A document that is not what it should be must not keep the rest from showing.
function attempt(draw) {
  try {
    draw();
  } catch (error) {
    console.error(error);
  }
}

function showTransport() {
  const button = byId('play');
  setText('play', state.playing ? 'Pause' : LIVE ? 'Resume' : 'Play');
  button.setAttribute('aria-pressed', String(!state.playing));
  if (LIVE) return;
  byId('slider').value = recorded.wanted;
  byId('slider').setAttribute('aria-valuetext', `${state.time ?? 0} s`);
  const [, last] = recordedSpan();
  setText('moment', isNumber(state.time) ? `${state.time.toFixed(1)} / ${last.toFixed(1)} s` : '');
}

function chooseAgent(agent) {
  if (agent === state.agent || agent >= agentCount()) return;
  state.agent = agent;
  redraw('all');
  if (LIVE) {
    live.step = true;
    listenToEvents();
  } else {
    catchUp();
  }
}

function togglePlaying() {
  if (!LIVE) return state.playing ? pause() : play();
  state.playing = !state.playing;
  if (state.playing) resume();
  showTransport();
  showLive();
}

// One step on: of a fleet that flies, to what it is now.
function step(count) {
  if (!LIVE) return stepBy(count);
  if (state.playing || count < 0) return;
  resume().then(showLive);
}

const KEYS = {
  ' ': togglePlaying,
  ArrowLeft: () => step(-1),
  ArrowRight: () => step(1),
  Home: () => !LIVE && (pause(), goTo(0)),
  End: () => !LIVE && (pause(), goTo(Infinity)),
  f: fit, F: fit,
  '+': () => zoomAt([camera.width / 2, camera.height / 2], 1.4),
  '=': () => zoomAt([camera.width / 2, camera.height / 2], 1.4),
  '-': () => zoomAt([camera.width / 2, camera.height / 2], 1 / 1.4),
};

function listenToKeys() {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const on = event.target;
    // Whoever has the keyboard needs its own keys: a select its arrows, buttons and boxes space.
    if (on.tagName === 'SELECT') return;
    if (event.key === ' ' && ['BUTTON', 'SUMMARY', 'INPUT'].includes(on.tagName) && on.type !== 'range') return;
    if (/^[0-9]$/.test(event.key)) chooseAgent(Number(event.key));
    else if (Object.hasOwn(KEYS, event.key)) KEYS[event.key]();
    else return;
    event.preventDefault();
  });
}

function listenToButtons() {
  // Who clicked with a pointer still plays with the space bar.
  document.addEventListener('click', (event) => {
    const on = document.activeElement;
    if (event.detail > 0 && on?.matches('button, summary, [type="checkbox"]')) on.blur();
  });
  byId('play').addEventListener('click', togglePlaying);
  byId('back').addEventListener('click', () => step(-1));
  byId('forward').addEventListener('click', () => step(1));
  byId('slider').addEventListener('input', () => {
    // First the wish: whatever draws the slider draws it where the wish is.
    goTo(Number(byId('slider').value));
    pause();
  });
  byId('fit').addEventListener('click', fit);
  byId('zoom-in').addEventListener('click', KEYS['+']);
  byId('zoom-out').addEventListener('click', KEYS['-']);
}

function start() {
  takeStyles();
  makeLayers();
  makeCurves(seek);
  listenToButtons();
  listenToKeys();
  listenToPointers(byId('fleet'), (pixel) => {
    const agent = agentAt(pixel);
    if (agent !== null) chooseAgent(agent);
  });
  const wide = window.matchMedia('(min-width: 761px)');
  const collapse = () => ['layers-box', 'details-box'].forEach((id) => (byId(id).open = wide.matches));
  wide.addEventListener('change', collapse);
  collapse();
  new ResizeObserver(() => {
    resizeMap();
    redraw('all');
  }).observe(byId('map'));
  resizeMap();
  if (LIVE) startLive();
  else startRecorded();
}

start();
