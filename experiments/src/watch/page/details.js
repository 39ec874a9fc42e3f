// Words and numbers: the header, the alarm and what one agent counts.

function showHeader() {
  const [doc, metrics] = [town(), metricsNow()];
  const run = doc?.seed ?? state.run;
  const title = doc?.scenario ? `${doc.scenario} · seed ${run}` : run ? `seed ${run}` : 'csat watch';
  setText('title', title);
  const name = `${title} · csat watch`;
  if (document.title !== name) document.title = name;
  setText('time', isNumber(state.time) ? ofDuration(doc) : '–');
  const [headline] = columns()?.headline ?? [];
  const known = metrics?.[headline];
  setText('headline-name', column(headline)?.name ?? '');
  setText('headline', isNumber(known) ? inUnit(known, column(headline)?.unit) : '–');
  const violations = metrics?.violations;
  setText('violations', isNumber(violations) ? String(violations) : '–');
  byId('violations-box').classList.toggle('loud', violations > 0);
  const alarm = byId('alarm');
  alarm.hidden = !(violations > 0);
  setText('alarm', violations > 0
    ? `VIOLATED ${violations === 1 ? 'once' : `${violations} times`}: what is guaranteed (see the monitor's events) did not hold.`
    : '');
  setText('attribution', doc?.attribution ?? '');
  const stations = stationCount();
  const shown = [`knowledge of ${nameOf(state.agent)}`, `time ${state.time ?? '–'} s`,
    `${agentCount() - stations} UAVs`, ...(stations ? [`${stations} stations`] : []), `${column(headline)?.name ?? ''} ${isNumber(known) ? inUnit(known, column(headline)?.unit) : '–'}`];
  byId('fleet').setAttribute('aria-label', `Map of the region: ${shown.join(', ')}`);
}

function ofDuration(doc) {
  const digits = Number.isInteger((doc?.period_s ?? 0.5) * 10) ? 1 : 2;
  const now = state.time.toFixed(digits);
  return isNumber(doc?.duration_s) ? `${now} of ${+doc.duration_s.toFixed(1)} s` : `${now} s`;
}

// A number of an agent with its unit; a count of targets as a part of all.
function inUnit(value, unit) {
  if (unit === 'targets') return `${value} of ${targetCount() ?? '?'}`;
  if (Number.isInteger(value)) return `${value} ${unit}`;
  return `${value.toFixed(1)} ${unit}`;
}

// What the chosen agent says of itself.
function showDetails() {
  const agent = state.agent;
  const condition = isDown(agent) ? ': crashed' : isLate(agent) ? ': late' : '';
  setText('details-title', `${nameOf(agent)}${condition}`);
  const [pose, stats] = [view(agent, 'pose'), view(agent, 'stats')];
  const rows = [];
  const place = placeOf(agent);
  if (place) {
    const [x, y, z] = place;
    const heading = ((90 - (pose.yaw_rad * 180) / Math.PI) % 360 + 360) % 360;
    rows.push(['position', inWords(x, y, 0)], ['altitude', `${z.toFixed(0)} m`]);
    if (isNumber(heading) && !isStation(agent)) rows.push(['course', `${heading.toFixed(0)}°`]);
    if (pose.incarnation > 0) rows.push(['restarted', times(pose.incarnation)]);
  }
  if (stats) {
    for (const { key, name, unit } of columns()?.columns ?? []) {
      if (isNumber(stats[key])) rows.push([name, inUnit(stats[key], unit)]);
    }
    rows.push(['sent', short(stats.bytes_sent, 'B')]);
    if (stats.withheld > 0) rows.push(['steps withheld', String(stats.withheld)]);
    for (const [reason, count] of Object.entries(stats.rejected ?? {})) {
      rows.push([`rejected: ${reason}`, String(count)]);
    }
  }
  for (const { src, delivered, lost } of heardBy(agent)) {
    const losses = [...lost].map(([name, count]) => `${count} ${outcomeOf(name).words}`);
    const got = delivered ? [`${delivered} arrived`] : [];
    rows.push([`from ${shortName(src)}`, [...got, ...losses].join(', ')]);
  }
  const box = byId('details');
  while (box.children.length > rows.length * 2) box.lastChild.remove();
  rows.forEach((row, index) => row.forEach((text, side) => {
    const at = index * 2 + side;
    if (!box.children[at]) box.append(document.createElement(side ? 'dd' : 'dt'));
    if (box.children[at].textContent !== text) box.children[at].textContent = text;
  }));
}

const inWords = (x, y, digits) =>
  `${Math.abs(x).toFixed(digits)} m ${x < 0 ? 'W' : 'E'}, ${Math.abs(y).toFixed(digits)} m ${y < 0 ? 'S' : 'N'}`;

const times = (count) => (count === 1 ? 'once' : `${count} times`);

// How the page hears, as words and a shape.
function showConnection(kind, words) {
  const pill = byId('connection');
  pill.className = `pill ${kind}`;
  setText('connection', words);
}

// What became of a mission that is over, with the time between two documents of it.
function endInWords(period_s) {
  const duration = town()?.duration_s;
  const isComplete = !isNumber(duration) || state.time + period_s + 1e-6 >= duration;
  return isComplete ? 'the mission ended' : 'the mission ended early';
}

function showEmpty(words) {
  byId('empty').hidden = !words;
  setText('empty', words ?? '');
}
