// What moves: agents, where they look and mean to fly, cars, and the names of sets.

function drawFleet(context, now) {
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, context.canvas.width, context.canvas.height);
  context.setTransform(camera.dpr, 0, 0, camera.dpr, 0, 0);
  const agents = Array.from({ length: agentCount() }, (_, agent) => agent);
  // The chosen one lies on top.
  agents.sort((a, b) => (a === state.agent) - (b === state.agent));
  const running = agents.filter((agent) => !isDown(agent));
  if (layerShown('footprints')) running.forEach((agent) => drawFootprint(context, agent));
  if (layerShown('paths')) agents.forEach((agent) => drawPath(context, agent));
  if (layerShown('plans')) running.forEach((agent) => drawPlan(context, agent));
  const fading = layerShown('links') ? drawLinks(context, agents, now) : false;
  if (layerShown('cars')) drawCars(context);
  const taken = agents.map((agent) => drawAgent(context, agent)).filter(Boolean);
  drawNames(context, taken);
  return fading;
}

function line(context, points) {
  context.beginPath();
  points.forEach((point, index) => {
    const [x, y] = toPixel(point);
    if (index) context.lineTo(x, y);
    else context.moveTo(x, y);
  });
}

function drawFootprint(context, agent) {
  const ring = view(agent, 'pose')?.footprint;
  if (!ring?.length) return;
  context.save();
  line(context, ring);
  context.closePath();
  context.globalAlpha = agent === state.agent ? 0.12 : 0.05;
  context.fillStyle = uavColour(agent);
  context.fill();
  context.globalAlpha = 0.9;
  context.strokeStyle = uavColour(agent);
  context.lineWidth = agent === state.agent ? 1.8 : 1.1;
  context.setLineDash([6, 4]);
  context.stroke();
  context.restore();
}

function drawPath(context, agent) {
  const path = state.paths.get(agent);
  if (!path?.length || isStation(agent)) return;
  const count = countUntil(path, (point) => point[0]);
  if (!count) return;
  const points = path.slice(0, count).map(([, x, y]) => [x, y]);
  const here = placeOf(agent);
  if (here && !isDown(agent)) points.push(here);
  context.save();
  line(context, points);
  context.lineJoin = 'round';
  context.strokeStyle = '#ffffff';
  context.globalAlpha = 0.65;
  context.lineWidth = agent === state.agent ? 4.5 : 3.2;
  context.stroke();
  context.globalAlpha = agent === state.agent ? 1 : 0.75;
  context.strokeStyle = uavColour(agent);
  context.lineWidth = agent === state.agent ? 2.4 : 1.5;
  context.stroke();
  const [x, y] = toPixel(points[0]);
  context.beginPath();
  context.arc(x, y, 3.5, 0, 7);
  context.fillStyle = '#ffffff';
  context.fill();
  context.lineWidth = 1.5;
  context.stroke();
  context.restore();
}

function drawPlan(context, agent) {
  const poses = view(agent, 'plan')?.poses;
  const here = placeOf(agent);
  if (!poses?.length || !here) return;
  context.save();
  context.strokeStyle = context.fillStyle = uavColour(agent);
  context.lineWidth = 1.6;
  context.setLineDash([1.5, 3.5]);
  line(context, [here, ...poses.map((pose) => pose.p_world)]);
  context.stroke();
  for (const pose of poses) {
    const [x, y] = toPixel(pose.p_world);
    context.beginPath();
    context.arc(x, y, 2, 0, 7);
    context.fill();
  }
  context.restore();
}

// Squares: full when the chosen agent knows the car.
function drawCars(context) {
  const known = targetsOf(state.agent);
  for (const { target, location } of state.docs['truth/targets']?.targets ?? []) {
    const [x, y] = toPixel(location);
    context.fillStyle = known.has(target) ? '#000000' : '#ffffff';
    context.strokeStyle = known.has(target) ? '#ffffff' : '#000000';
    context.lineWidth = 1.4;
    context.fillRect(x - 4, y - 4, 8, 8);
    context.strokeRect(x - 4, y - 4, 8, 8);
  }
}

const ARROW = [[12, 0], [-8, 7], [-4, 0], [-8, -7]];
const MAST = [[0, -10], [9, 7], [-9, 7]];

// An arrowhead, or a mast for a station; a cross for who crashed. Gives the box that its name takes.
function drawAgent(context, agent) {
  const pose = view(agent, 'pose');
  const place = placeOf(agent);
  if (!place) return null;
  const [x, y] = toPixel(place);
  const [chosen, down] = [agent === state.agent, isDown(agent)];
  const size = chosen ? 1.25 : 1;
  context.save();
  context.translate(x, y);
  context.lineJoin = 'round';
  if (down) {
    context.lineCap = 'round';
    for (const [colour, width] of [['#ffffff', 7], [COLOUR.down, 3.5]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      for (const [a, b] of [[-7, -7], [-7, 7]]) {
        context.moveTo(a, b);
        context.lineTo(-a, -b);
      }
      context.stroke();
    }
  } else {
    if (!isStation(agent)) context.rotate(-(pose.yaw_rad ?? 0));
    context.scale(size, size);
    context.beginPath();
    (isStation(agent) ? MAST : ARROW).forEach(([a, b]) => context.lineTo(a, b));
    context.closePath();
    context.fillStyle = uavColour(agent);
    context.strokeStyle = '#ffffff';
    context.lineWidth = 3;
    context.stroke();
    context.fill();
    if (chosen) {
      context.strokeStyle = '#000000';
      context.lineWidth = 1;
      context.stroke();
    }
  }
  context.restore();
  const name = down ? `${shortName(agent)} crashed` : shortName(agent);
  const width = name.length * 7.5;
  label(context, name, [x, y - 15], { colour: down ? COLOUR.down : uavColour(agent), size: chosen ? 14 : 12 });
  return [x - width / 2, y - 28, width, 40];
}

// The agent at a pixel.
function agentAt([px, py]) {
  let best = null;
  for (let agent = 0; agent < agentCount(); agent++) {
    const place = placeOf(agent);
    if (!place) continue;
    const [x, y] = toPixel(place);
    const distance = Math.hypot(x - px, y - py);
    if (distance < 22 && (!best || distance < best.distance)) best = { agent, distance };
  }
  return best?.agent ?? null;
}
