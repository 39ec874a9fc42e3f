// Messages: a line when they arrive, which fades; a dashed one with the letter of the reason when
// they are lost.

const FADE_MS = 1500;
const LEAST = 0.3;
// Larger fleets show the links of the chosen agent only: all of them would hide the map.
const MANY = 6;

// What became of messages from each sender to `agent` in its newest step.
function heardBy(agent) {
  const doc = view(agent, 'links');
  if (!doc) return [];
  return fromDocument(doc, 'by sender', () => {
    const senders = new Map();
    for (const { src, outcome, count = 1 } of doc.heard ?? []) {
      if (!senders.has(src)) senders.set(src, { src, delivered: 0, lost: new Map() });
      const sender = senders.get(src);
      if (outcome === 'delivered') sender.delivered += count;
      else sender.lost.set(outcome, (sender.lost.get(outcome) ?? 0) + count);
    }
    return [...senders.values()];
  });
}

// Draws links; gives whether some still fade.
function drawLinks(context, agents, now) {
  let fading = false;
  const marks = [];
  // Who crashed hears nothing; its last words are from before.
  for (const agent of agents.filter((i) => !isDown(i))) {
    const age = now - (state.arrived.get(agent) ?? -Infinity);
    // Who stopped to look wants to see them.
    const alpha = STILL || !state.playing ? 0.9 : Math.max(LEAST, 1 - age / FADE_MS);
    for (const sender of heardBy(agent)) {
      const isChosens = agent === state.agent || sender.src === state.agent;
      if (agents.length > MANY && !isChosens) continue;
      const ends = [sender.src, agent].map(placeOf);
      if (!ends[0] || !ends[1]) continue;
      marks.push(...drawLink(context, ends.map(toPixel), sender, alpha));
      fading ||= !STILL && state.playing && age < FADE_MS;
    }
  }
  marks.forEach(([place, name, alpha]) => drawReason(context, place, outcomeOf(name), 8, alpha));
  return fading;
}

// A link, a little to the right of its direction so that the way back is beside it. Gives the marks
// of losses.
function drawLink(context, [from, to], sender, alpha) {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length < 30) return [];
  const [ux, uy] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
  const place = (along) => [from[0] + ux * along - uy * 3.5, from[1] + uy * along + ux * 3.5];
  const [start, end] = [place(14), place(length - 16)];
  const reasons = [...sender.lost.keys()];
  context.save();
  context.globalAlpha = sender.delivered ? alpha : Math.max(alpha, 0.6);
  context.strokeStyle = context.fillStyle =
    sender.delivered ? COLOUR.delivered : outcomeOf(reasons[0]).colour;
  context.lineWidth = sender.delivered ? 1.6 : 1.4;
  context.setLineDash(sender.delivered ? [] : [7, 5]);
  context.beginPath();
  context.moveTo(...start);
  context.lineTo(...end);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  for (const [along, across] of [[0, 0], [-7, 3.5], [-7, -3.5]]) {
    context.lineTo(end[0] + ux * along - uy * across, end[1] + uy * along + ux * across);
  }
  context.fill();
  context.restore();
  // Nearer to who did not get it, so that both directions stay apart.
  return reasons.map((name, index) => [place(length * 0.64 - index * 19), name, Math.max(alpha, 0.75)]);
}

function drawReason(context, [x, y], { sign, colour, dark }, radius, alpha = 1) {
  context.save();
  context.globalAlpha = alpha;
  context.beginPath();
  context.arc(x, y, radius, 0, 7);
  context.fillStyle = colour;
  context.strokeStyle = '#ffffff';
  context.lineWidth = 2.5;
  context.stroke();
  context.fill();
  context.fillStyle = dark ? '#000000' : '#ffffff';
  context.font = `700 ${Math.round(radius * 1.35)}px system-ui, "DejaVu Sans", sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(sign, x, y + 0.5);
  context.restore();
}
