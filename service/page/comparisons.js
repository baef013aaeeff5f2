// Baked rooms side by side, with one eye and one place that is read in all of them.
import { find, make, say } from './elements.js';
import { drawPanel } from './panel.js';
import { go, places } from './places.js';
import { loadRoom, Room } from './room.js';
import { session } from './session.js';
import { nameOf, number } from './words.js';

export const comparison = { rooms: [], first: null, view: { top: 1, interval: 0, isLight: false } };

export async function compare(...jobs) {
  const loaded = [];
  for (const job of jobs) loaded.push(await loadRoom(session.api, job, (share) => say(`loading, ${Math.round(100 * share)} %`)));
  say('');
  closeRooms();
  go('walk');
  const largest = Math.max(...loaded.flatMap((each) => each.report.quantities.map((row) => row.maximum)));
  comparison.view = { top: roundUp(largest), interval: 0, isLight: false };
  for (const each of loaded) comparison.rooms.push(addRoom(each));
  [comparison.first] = jobs;
  // All have the room that is left to them now, and not only when the browser comes to tell them.
  for (const room of comparison.rooms) room.resize();
  drawPanel(comparison);
}

function closeRooms() {
  for (const room of comparison.rooms) room.close();
  comparison.rooms = [];
}

places.addEventListener('left', (event) => event.detail === 'walk' && closeRooms());

function addRoom(loaded) {
  const host = make('div', { className: 'room' });
  const probe = make('output', { className: 'probe' });
  find('rooms').append(host);
  const room = new Room(host, loaded, {
    watch: (found) => {
      if (found) for (const each of comparison.rooms) each.tell(each === room ? found : each.at(found.place));
      else room.tell(null);
    },
    moved: (mover) => {
      for (const each of comparison.rooms) if (each !== mover) each.follow(mover);
    },
  });
  host.append(make('span', { className: 'title', textContent: nameOf(loaded.job) }), probe);
  room.tell = (found) => {
    room.last = found;
    room.point(found?.place);
    probe.textContent = tellProbe(room, found);
    probe.title = found ? tellPlace(found) : '';
  };
  return room;
}

function tellProbe(room, found) {
  if (!found) return '';
  if (!found.isCovered) return `${found.object}: not computed here`;
  const bound = room.isMixed ? 'at most ' : '';
  return `${found.object}: ${number(found.lux, 4)} lx ± ${bound}${number(found.error, 2)} lx`;
}

// Metres as Blender counts them, and where the number stands in the job's files.
function tellPlace({ place, page, column, row }) {
  const [x, y, z] = [place.x, -place.z, place.y].map((value) => value.toFixed(3));
  return `at ${x}, ${y}, ${z} m; lumel ${column}, ${row} of page ${page + 1}`;
}

function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value || 1));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= value);
}
