// What stands beside the rooms: the scale, light groups, verdicts and figures; of several rooms each says whose it is.
import { find, make, table } from './elements.js';
import { nameOf, number } from './words.js';

export function drawPanel({ rooms, view }) {
  const sections = [groupSliders, verdicts, figures].flatMap((draw) => rooms.map((room) => draw(room, titleOf(room, rooms))));
  find('panel').replaceChildren(legend(rooms, view), ...sections.filter(Boolean));
}

function titleOf(room, rooms) {
  return (text) => make('h3', {}, text, rooms.length > 1 ? make('span', { className: 'of', textContent: nameOf(room.loaded.job) }) : '');
}

function legend(rooms, view) {
  const bar = make('div', { className: 'legend' });
  const ticks = make('div', { className: 'ticks' });
  const draw = () => {
    const colours = view.isLight ? ['#000', '#fff'] : rooms[0].colours;
    bar.style.background = `linear-gradient(to right, ${colours.join(', ')})`;
    ticks.replaceChildren(...[0, 0.25, 0.5, 0.75, 1].map((share) => make('span', { textContent: `${number(share * view.top)}${share === 1 ? ' lx' : ''}` })));
    for (const room of rooms) room.show(view);
  };
  const change = (key, value) => {
    view[key] = value;
    draw();
  };
  draw();
  return make('section', {},
    make('h3', { textContent: 'Illuminance' }), bar, ticks,
    make('label', { className: 'row' }, make('span', { textContent: 'Top' }), make('input', {
      type: 'number', id: 'top', min: 0.001, step: 'any', value: view.top,
      on: { change: (event) => event.target.reportValidity() && change('top', Number(event.target.value)) },
    }), 'lx'),
    make('label', { className: 'row' }, make('span', { textContent: 'Isolux lines each' }), make('input', {
      type: 'number', id: 'interval', min: 0, step: 'any', placeholder: 'none',
      on: { change: (event) => event.target.reportValidity() && change('interval', Number(event.target.value || 0)) },
    }), 'lx'),
    make('label', { className: 'row' }, make('input', { type: 'checkbox', on: { change: (event) => change('isLight', event.target.checked) } }), 'as grey light'));
}

function groupSliders(room, title) {
  if (!room.factors.size) return null;
  return make('section', {}, title('Light groups'),
    ...[...room.factors.keys()].map((name) => {
      const told = make('output', { textContent: '100 %' });
      const mix = (event) => {
        told.textContent = `${Math.round(100 * event.target.value)} %`;
        room.mix(name, Number(event.target.value));
        if (room.last) room.tell(room.at(room.last.place));
      };
      return make('label', { className: 'row' },
        make('span', { className: 'name', textContent: name }),
        make('input', { type: 'range', min: 0, max: 2, step: 0.01, value: 1, 'aria-label': name, on: { input: mix } }), told);
    }));
}

// What maps say of the requirement that was asked for; as computed, whatever the sliders say.
function verdicts(room, title) {
  const { verdicts: asked } = room.loaded;
  if (!asked) return null;
  const words = { met: 'met', 'not met': 'missed' };
  const rows = asked.areas.flatMap((area) => area.limits.map((limit) => [
    area.object,
    `${limit.name} ${limit.is_most ? '≤' : '≥'} ${number(limit.limit)}`,
    ['number', limit.value === null ? '' : `${number(limit.value)} (${number(limit.range[0])} to ${number(limit.range[1])})`],
    [words[limit.state] ?? 'open', limit.state],
  ]));
  return make('section', { className: 'verdicts' }, title(`${asked.key}: ${asked.title}, ${asked.standard}`),
    table(['Surface', 'Asked', 'Found', 'Verdict'], rows));
}

function figures(room, title) {
  const rows = room.loaded.report.quantities.map((row) => [
    row.name,
    ['number', `${number(row.mean)} ± ${number(row.mean_standard_error ?? 0, 2)}`],
    ...[number(row.minimum), number(row.maximum), number(row.uniformity, 2)].map((text) => ['number', text]),
  ]);
  return make('section', {}, title('As computed'),
    table(['Surface', 'Mean, lx', 'Least', 'Largest', 'Uo'], rows),
    ...room.loaded.report.notes.map((text) => make('p', { className: 'note', textContent: text })));
}
