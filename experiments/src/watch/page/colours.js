// Colours and signs of what is the same for all missions: those of map.svg, Okabe and Ito's where something must be told apart; hatching,
// dashes and letters say the same again.

const UAV_COLOURS =
  ['#0072B2', '#D55E00', '#CC79A7', '#111111', '#56B4E9', '#8C510A', '#E69F00', '#5D3A9B'];
const uavColour = (agent) => UAV_COLOURS[agent % UAV_COLOURS.length];

const COLOUR = {
  paper: '#F4F4F1', region: '#FFFFFF', border: '#333333', road: '#E0E0DC',
  empty: '#D7E8F3', buildingEdge: '#4A4A4A', delivered: '#2B4A6B', down: '#595959',
};

// What became of a message, with the letter that its loss bears on the map.
const OUTCOMES = {
  outage: { sign: 'O', colour: '#111111', words: 'outage' },
  partition: { sign: 'P', colour: '#5D3A9B', words: 'partition' },
  range: { sign: 'R', colour: '#D55E00', words: 'out of range' },
  propagation: { sign: 'W', colour: '#8C510A', words: 'walls' },
  jamming: { sign: 'J', colour: '#CC79A7', words: 'jammed', dark: true },
  loss: { sign: 'L', colour: '#0072B2', words: 'lost' },
  queue: { sign: 'Q', colour: '#E69F00', words: 'queue full', dark: true },
  corrupted: { sign: 'C', colour: '#009E73', words: 'damaged' },
};
const UNKNOWN_OUTCOME = { sign: '?', colour: '#595959', words: 'not known' };
const outcomeOf = (name) =>
  Object.hasOwn(OUTCOMES, name) ? OUTCOMES[name] : { ...UNKNOWN_OUTCOME, words: String(name) };

// Bands of height, or of other values: the higher, the darker.
const BANDS = 5;
const bandAlpha = (band) => 0.25 + 0.7 * (band / (BANDS - 1));
