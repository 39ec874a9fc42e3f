// A recording: the moment that is shown follows the slider, the keys and the clock of playing.

const recorded = { times: [], wanted: 0, asking: false, clock: 0, frame: null };

const recordedSpan = () => {
  const { times } = recorded;
  return times.length ? [times[0], times[times.length - 1]] : [0, 1];
};

async function ask(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status} ${(await answer.text()).trim()}`);
  return answer.json();
}

async function startRecorded() {
  try {
    const [meta, series] = await Promise.all([ask('/recording'), ask('/series')]);
    recorded.times = meta.times_s;
    takeSeries(series);
    byId('slider').max = Math.max(0, recorded.times.length - 1);
    if (!recorded.times.length) return showEmpty('Nothing flies in this recording: expected documents below view/.');
    // The end shows most.
    recorded.wanted = recorded.times.length - 1;
    await catchUp();
    fit();
  } catch (error) {
    showConnection('bad', 'not connected');
    showEmpty(`The recording cannot be read: ${error.message}. Is csat watch still running?`);
  }
}

// Shows the wanted moment; while one is on its way, only the newest wish counts.
async function catchUp() {
  if (recorded.asking) return;
  recorded.asking = true;
  try {
    let [shown, agent] = [null, null];
    while (shown !== recorded.wanted || agent !== state.agent) {
      [shown, agent] = [recorded.wanted, state.agent];
      const query = `time_s=${recorded.times[shown]}&agent=${agent}&town=${!town()}`;
      const documents = await ask(`/at?${query}`);
      // A moment in the past has fewer documents.
      const known = town();
      state.docs = known ? { 'truth/town': known } : {};
      takeDocuments(documents);
      state.time = recorded.times[shown];
      showRecorded(shown);
      redraw('all');
    }
  } catch (error) {
    pause();
    showConnection('bad', 'not connected');
  } finally {
    recorded.asking = false;
  }
}

// At its last moment the recording says what became of the mission.
function showRecorded(shown) {
  const { times } = recorded;
  const last = times.length - 1;
  const end = shown === last ? `: ${endInWords(times[last] - (times[last - 1] ?? times[last]))}` : '';
  showConnection(state.playing ? 'good' : 'held', `recorded${end}`);
}

function goTo(index) {
  recorded.wanted = Math.min(Math.max(index, 0), recorded.times.length - 1);
  catchUp();
}

function stepBy(count) {
  pause();
  goTo(recorded.wanted + count);
}

// The last step at or before a time.
function indexAt(time) {
  let [low, high] = [0, recorded.times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (recorded.times[middle] <= time + 1e-6) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

function seek(time) {
  recorded.clock = time;
  goTo(indexAt(time));
}

function play() {
  const [first, last] = recordedSpan();
  recorded.clock = recorded.times[recorded.wanted] ?? first;
  if (recorded.clock >= last) recorded.clock = first;
  state.playing = true;
  let before = performance.now();
  const tick = (now) => {
    if (!state.playing) return;
    recorded.clock += ((now - before) / 1000) * Number(byId('speed').value);
    before = now;
    goTo(indexAt(recorded.clock));
    if (recorded.clock >= last) return pause();
    recorded.frame = requestAnimationFrame(tick);
  };
  recorded.frame = requestAnimationFrame(tick);
  showTransport();
}

function pause() {
  state.playing = false;
  if (recorded.frame) cancelAnimationFrame(recorded.frame);
  showTransport();
  redraw('fleet');
}
