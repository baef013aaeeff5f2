// Orders of jobs of a scene.
import { makeChoice } from './choices.js';
import { make } from './elements.js';
import { addJob } from './jobs.js';
import { go } from './places.js';
import { session } from './session.js';

export function orderForm(scene) {
  const kind = make('select', { 'aria-label': 'Kind of job' },
    make('option', { value: 'bake', textContent: 'Lux maps' }),
    make('option', { value: 'render', textContent: 'Picture', disabled: !scene.content.has_camera }),
    make('option', { value: 'measure', textContent: 'Sensors', disabled: !scene.content.sensors.length }));
  const field = (label, min, max, value) => make('input', { type: 'number', min, max, step: 'any', value, required: true, 'aria-label': label });
  const error = field('Standard error in per cent', 0.1, 50, 2);
  const time = field('Seconds at most', 5, 86400, 300);
  const density = field('Lumels per metre', 0.1, 200, 8);
  const require = make('input', { placeholder: 'not judged', list: 'requirements', 'aria-label': 'Requirement' });
  const chosen = new Set();
  const surfaces = makeChoice(scene.content.surfaces, {
    label: 'Surfaces of which lux maps are computed',
    tell: () => (chosen.size ? `Lux maps of ${[...chosen].join(', ')}` : 'Lux maps of all surfaces'),
    isChosen: (name) => chosen.has(name),
    changed: (name, isChosen) => (isChosen ? chosen.add(name) : chosen.delete(name)),
  });
  const order = async (event) => {
    event.preventDefault();
    const options = { error: Number(error.value) / 100, time: Number(time.value) };
    if (kind.value === 'bake') Object.assign(options, { layers: 'groups', lumels_per_m: Number(density.value) });
    if (kind.value === 'bake' && chosen.size) options.objects = [...chosen];
    if (kind.value === 'render') options.false_colour = true;
    else if (require.value.trim()) options.require = require.value.trim();
    const job = await session.api.send('POST', `/scenes/${scene.id}/jobs`, { kind: kind.value, options }, { 'Idempotency-Key': crypto.randomUUID() });
    addJob({ ...job, sceneName: scene.name });
    go('jobs');
  };
  const form = make('form', { on: { submit: order } }, kind,
    make('label', { textContent: 'to ' }, error, ' %'), make('label', { textContent: 'at most ' }, time, ' s'),
    make('label', { textContent: 'lumels per metre ' }, density), make('label', { textContent: 'by ' }, require),
    make('button', { textContent: 'Compute' }));
  return make('div', {}, form, surfaces);
}
