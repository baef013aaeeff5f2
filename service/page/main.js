// The page: signing in, scenes with their edits, jobs with their progress, and rooms to walk through.
import { Api } from './api.js';
import { loadRoom, Room } from './room.js';

const find = (id) => document.getElementById(id);
const STATES = { opening: 'being opened', ready: 'ready', failed: 'failed', queued: 'waiting', running: 'running', done: 'done', cancelled: 'cancelled' };
const ENDED = ['done', 'failed', 'cancelled'];
const WAIT = 1000;

let api = null;
let jobs = new Map();
const followed = new Map();
let rooms = [];
let walked = null;
let view = { top: 1, interval: 0, isLight: false };

// ---- small helpers ----

function make(tag, options = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(options)) {
    if (key === 'on') for (const [event, handler] of Object.entries(value)) element.addEventListener(event, guard(handler));
    else if (key in element) element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

function say(text, isBad = false) {
  find('said').textContent = text;
  find('said').className = isBad ? 'bad' : '';
}

// What goes wrong in a handler is told, whatever it is.
function guard(handler) {
  return async (event) => {
    try {
      await handler(event);
    } catch (error) {
      if (error.status === 401) signOut();
      say(error.message, true);
    }
  };
}

const pause = (time) => new Promise((resolve) => setTimeout(resolve, time));

function number(value, digits = 3) {
  return Number(value.toPrecision(digits)).toLocaleString('en', { maximumSignificantDigits: digits });
}

function size(bytes) {
  return bytes < 1e6 ? `${number(bytes / 1e3)} kB` : bytes < 1e9 ? `${number(bytes / 1e6)} MB` : `${number(bytes / 1e9)} GB`;
}

function nameOf(job) {
  return job.sceneName ? `${job.number}. ${job.kind} of ${job.sceneName}` : `${job.number}. ${job.kind}`;
}

function go(place) {
  for (const main of document.querySelectorAll('main')) main.hidden = main.id !== place;
  for (const button of document.querySelectorAll('[data-place]')) button.setAttribute('aria-pressed', button.dataset.place === place);
  if (place !== 'walk') closeRooms();
}

// ---- signing in ----

async function signIn(next) {
  api = next;
  await showUser();
  find('places').hidden = find('leave').hidden = false;
  say('');
  const { requirements } = await api.get('/requirements');
  find('requirements').replaceChildren(...requirements.map((each) => make('option', { value: each.key, label: each.title })));
  await Promise.all([showScenes(), showJobs()]);
  go('scenes');
}

async function showUser() {
  const user = await api.get('/me');
  find('who').textContent = `${user.name}, ${size(user.disk)} of ${size(user.quota.disk)}`;
}

function signOut() {
  Api.forget();
  api = null;
  for (const stop of followed.values()) stop.abort();
  followed.clear();
  find('places').hidden = find('leave').hidden = true;
  find('who').textContent = '';
  go('sign-in');
}

// ---- scenes ----

async function showScenes(chosen) {
  const { scenes } = await api.get('/scenes');
  find('scene-list').replaceChildren(
    ...scenes.map((scene) =>
      make('li', { className: scene.id === chosen ? 'chosen' : '' },
        make('div', { className: 'row' },
          make('span', { className: 'name', textContent: scene.name }),
          make('span', { textContent: STATES[scene.state] }),
          scene.state === 'ready' ? make('button', { type: 'button', textContent: 'Open', on: { click: () => openScene(scene.id) } }) : null,
          make('button', { type: 'button', textContent: 'Remove', on: { click: () => removeScene(scene) } })),
        scene.note ? make('p', { className: 'note', textContent: scene.note }) : null)),
  );
  return scenes;
}

async function removeScene(scene) {
  if (!confirm(`Remove '${scene.name}' with all its results?`)) return;
  await api.send('DELETE', `/scenes/${scene.id}`);
  find('scene').hidden = true;
  await Promise.all([showScenes(), showJobs()]);
}

async function upload(event) {
  event.preventDefault();
  const [file] = find('file').files;
  const bar = find('sent');
  bar.hidden = false;
  try {
    const scene = await api.upload(`/scenes?name=${encodeURIComponent(file.name)}`, file, (share) => { bar.value = share; });
    say(`${file.name} is being opened`);
    await waitForScene(scene.id);
  } finally {
    bar.hidden = true;
  }
}

async function waitForScene(id) {
  for (;;) {
    const scene = (await showScenes()).find((each) => each.id === id);
    if (!scene || scene.state === 'failed') return say(scene ? scene.note : '', true);
    if (scene.state === 'ready') {
      say('');
      return openScene(id);
    }
    await pause(WAIT);
  }
}

async function openScene(id) {
  const scene = await api.get(`/scenes/${id}`);
  const edits = { lights: {}, ...structuredClone(scene.edits) };
  const save = guard(async () => {
    const kept = Object.fromEntries(Object.entries(edits.lights).filter(([, changes]) => Object.keys(changes).length));
    const sent = { ...edits, lights: kept };
    if (!Object.keys(kept).length) delete sent.lights;
    await api.send('PUT', `/scenes/${id}/edits`, sent);
    say('changes are kept; they hold for jobs that are ordered from now on');
  });
  find('scene').replaceChildren(
    make('h2', { textContent: scene.name }),
    ...scene.content.problems.map((text) => make('p', { className: 'note', textContent: text })),
    orderForm(scene),
    make('h3', { textContent: 'Lights' }),
    make('div', { className: 'scroll' }, lightTable(scene, edits, save)),
    make('h3', { textContent: `Hidden objects` }),
    hiddenChoice(scene, edits, save),
  );
  find('scene').hidden = false;
  await showScenes(id);
}

function lightTable(scene, edits, save) {
  const rows = scene.content.lights.map((light) => {
    const changes = (edits.lights[light.name] ??= {});
    const change = (key, value) => {
      if (value === null) delete changes[key];
      else changes[key] = value;
      save();
    };
    const field = (key, least, most, shown, isEnabled = true) =>
      make('input', {
        type: 'number', min: least, max: most, step: 'any', placeholder: shown, disabled: !isEnabled,
        value: changes[key] ?? '', 'aria-label': `${key} of ${light.name}`,
        on: { change: (event) => event.target.reportValidity() && change(key, event.target.value === '' ? null : Number(event.target.value)) },
      });
    return make('tr', {},
      make('td', { textContent: light.count > 1 ? `${light.name} (×${light.count})` : light.name }),
      make('td', { className: 'number', textContent: `${number(light.amount)} ${light.unit}` }),
      make('td', {}, field('flux', 0, 1e9, 'as it is', light.unit === 'lm')),
      make('td', {}, field('dimming', 0, 1, '1')),
      make('td', {}, field('temperature', 500, 40000, 'as it is')),
      make('td', {}, make('input', {
        type: 'checkbox', checked: changes.is_on ?? light.is_on, 'aria-label': `${light.name} is on`,
        on: { change: (event) => change('is_on', event.target.checked === light.is_on ? null : event.target.checked) },
      })));
  });
  const heads = ['Light', 'Gives', 'Flux, lm', 'Dimming', 'Temperature, K', 'On'].map((text) => make('th', { textContent: text }));
  return make('table', {}, make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows));
}

function hiddenChoice(scene, edits, save) {
  const hidden = new Set(edits.hidden ?? []);
  const names = scene.content.surfaces;
  return make('details', {},
    make('summary', { textContent: hidden.size ? [...hidden].join(', ') : 'none' }),
    ...names.map((name) =>
      make('label', { className: 'row' },
        make('input', {
          type: 'checkbox', checked: hidden.has(name),
          on: {
            change: (event) => {
              if (event.target.checked) hidden.add(name);
              else hidden.delete(name);
              edits.hidden = [...hidden];
              if (!hidden.size) delete edits.hidden;
              save();
            },
          },
        }),
        make('span', { textContent: name }))));
}

function orderForm(scene) {
  const kind = make('select', { 'aria-label': 'Kind of job' },
    make('option', { value: 'bake', textContent: 'Lux maps' }),
    make('option', { value: 'render', textContent: 'Picture', disabled: !scene.content.has_camera }),
    make('option', { value: 'measure', textContent: 'Sensors', disabled: !scene.content.sensors.length }));
  const error = make('input', { type: 'number', min: 0.1, max: 50, step: 'any', value: 2, 'aria-label': 'Standard error in per cent' });
  const time = make('input', { type: 'number', min: 5, max: 86400, step: 'any', value: 300, 'aria-label': 'Seconds at most' });
  const density = make('input', { type: 'number', min: 0.1, max: 200, step: 'any', value: 8, 'aria-label': 'Lumels per metre' });
  const require = make('input', { placeholder: 'not judged', 'aria-label': 'Requirement' });
  // The property is read only.
  require.setAttribute('list', 'requirements');
  const form = make('form', {
    on: {
      submit: async (event) => {
        event.preventDefault();
        const options = { error: Number(error.value) / 100, time: Number(time.value) };
        if (kind.value === 'bake') Object.assign(options, { layers: 'groups', lumels_per_m: Number(density.value) });
        if (kind.value === 'render') options.false_colour = true;
        else if (require.value.trim()) options.require = require.value.trim();
        const job = await api.send('POST', `/scenes/${scene.id}/jobs`, { kind: kind.value, options }, { 'Idempotency-Key': crypto.randomUUID() });
        jobs.set(job.id, { ...job, sceneName: scene.name });
        follow(job);
        listJobs();
        go('jobs');
      },
    },
  }, kind, make('label', { textContent: 'to ' }, error, ' %'), make('label', { textContent: 'at most ' }, time, ' s'),
    make('label', { textContent: 'lumels per metre ' }, density), make('label', { textContent: 'by ' }, require),
    make('button', { textContent: 'Compute' }));
  return form;
}

// ---- jobs ----

async function showJobs() {
  const [{ jobs: found }, { scenes }] = await Promise.all([api.get('/jobs'), api.get('/scenes')]);
  const names = new Map(scenes.map((scene) => [scene.id, scene.name]));
  jobs = new Map(found.map((job) => [job.id, { ...job, sceneName: names.get(job.scene) }]));
  for (const job of jobs.values()) if (!ENDED.includes(job.state)) follow(job);
  listJobs();
}

function follow(job) {
  if (followed.has(job.id)) return;
  const stop = new AbortController();
  followed.set(job.id, stop);
  const told = (row) => {
    jobs.set(row.id, { ...jobs.get(row.id), ...row });
    listJobs();
  };
  const listen = async () => {
    // A line that breaks is opened again, until the job has ended.
    while (!stop.signal.aborted && !ENDED.includes(jobs.get(job.id)?.state)) {
      try {
        await api.follow(job.id, told, stop.signal);
      } catch (error) {
        if (stop.signal.aborted || error.status === 404) break;
        await pause(WAIT);
      }
    }
    followed.delete(job.id);
  };
  listen();
}

function listJobs() {
  const newest = [...jobs.values()].sort((a, b) => b.number - a.number);
  find('job-list').replaceChildren(...newest.map(jobRow));
}

function jobRow(job) {
  const state = job.state === 'running' && job.progress ? job.progress.text : STATES[job.state];
  const button = (text, click) => make('button', { type: 'button', textContent: text, on: { click } });
  const isWalkable = job.kind === 'bake' && job.state === 'done';
  return make('li', { id: `job-${job.id}` },
    make('div', { className: 'row' },
      make('span', { className: 'name', textContent: nameOf(job) }),
      make('span', { textContent: state }),
      isWalkable ? button('Walk', () => walk([job])) : null,
      isWalkable && walked && walked.id !== job.id ? button(`Beside ${walked.number}`, () => walk([walked, job])) : null,
      job.state === 'done' ? button('Files', () => showFiles(job)) : null,
      ENDED.includes(job.state)
        ? button('Remove', async () => {
          await api.send('DELETE', `/jobs/${job.id}`);
          jobs.delete(job.id);
          listJobs();
        })
        : button('Cancel', () => api.send('POST', `/jobs/${job.id}/cancel`))),
    job.state === 'running' ? make('progress', { max: 1, value: job.progress?.share ?? 0 }) : null,
    job.note ? make('p', { className: 'note', textContent: job.note }) : null,
    make('div', { className: 'files' }));
}

async function showFiles(job) {
  const { files } = await api.get(`/jobs/${job.id}/files`);
  const list = find(`job-${job.id}`).querySelector('.files');
  list.replaceChildren(...files.map((file) =>
    make('div', { className: 'row' },
      make('span', { className: 'name', textContent: file.name }),
      make('span', { textContent: size(file.bytes) }),
      make('button', { type: 'button', textContent: 'Download', on: { click: () => download(job, file.name) } }))));
}

async function download(job, name) {
  const place = URL.createObjectURL(new Blob([await api.file(job.id, name)]));
  make('a', { href: place, download: name.split('/').pop() }).click();
  setTimeout(() => URL.revokeObjectURL(place), WAIT);
}

// ---- rooms ----

function closeRooms() {
  for (const room of rooms) room.close();
  rooms = [];
}

async function walk(chosen) {
  const loaded = [];
  for (const job of chosen) loaded.push(await loadRoom(api, job, (share) => say(`loading, ${Math.round(100 * share)} %`)));
  say('');
  go('walk');
  closeRooms();
  const largest = Math.max(...loaded.flatMap((each) => each.report.quantities.map((row) => row.maximum)));
  view = { top: roundUp(largest), interval: 0, isLight: false };
  for (const each of loaded) rooms.push(addRoom(each));
  [walked] = chosen;
  // All have the room that is left to them now, and not only when the browser comes to tell them.
  for (const room of rooms) room.resize();
  drawPanel();
  showAll();
}

function addRoom(loaded) {
  const host = make('div', { className: 'room' });
  const probe = make('output', { className: 'probe' });
  find('rooms').append(host);
  const room = new Room(host, loaded, {
    watch: (found) => {
      if (found) for (const each of rooms) each.tell(each === room ? found : each.at(found.place));
      else room.tell(null);
    },
    moved: (mover) => {
      for (const each of rooms) if (each !== mover) each.follow(mover);
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

function showAll() {
  for (const room of rooms) room.show(view);
}

function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value || 1));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= value);
}

function drawPanel() {
  find('panel').replaceChildren(legend(), ...[groupSliders, verdicts, figures].flatMap((draw) => rooms.map(draw)).filter(Boolean));
}

function legend() {
  const bar = make('div', { className: 'legend' });
  const ticks = make('div', { className: 'ticks' });
  const draw = () => {
    const colours = view.isLight ? ['#000', '#fff'] : rooms[0].colours;
    bar.style.background = `linear-gradient(to right, ${colours.join(', ')})`;
    ticks.replaceChildren(...[0, 0.25, 0.5, 0.75, 1].map((share) => make('span', { textContent: `${number(share * view.top)}${share === 1 ? ' lx' : ''}` })));
    showAll();
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

function groupSliders(room) {
  if (!room.factors.size) return null;
  return make('section', {},
    make('h3', { textContent: rooms.length > 1 ? `Light groups: ${nameOf(room.loaded.job)}` : 'Light groups' }),
    ...[...room.factors.keys()].map((name) => {
      const told = make('output', { textContent: '100 %' });
      return make('label', { className: 'row' },
        make('span', { className: 'name', textContent: name }),
        make('input', {
          type: 'range', min: 0, max: 2, step: 0.01, value: 1, 'aria-label': name,
          on: {
            input: (event) => {
              told.textContent = `${Math.round(100 * event.target.value)} %`;
              room.mix(name, Number(event.target.value));
              if (room.last) room.tell(room.at(room.last.place));
            },
          },
        }), told);
    }));
}

// What maps say of the requirement that was asked for; as computed, whatever the sliders say.
function verdicts(room) {
  const { verdicts: asked } = room.loaded;
  if (!asked) return null;
  const words = { met: 'met', 'not met': 'missed' };
  const rows = asked.areas.flatMap((area) => area.limits.map((limit) =>
    make('tr', {},
      make('td', { textContent: area.object }),
      make('td', { textContent: `${limit.name} ${limit.is_most ? '≤' : '≥'} ${number(limit.limit)}` }),
      make('td', { className: 'number', textContent: limit.value === null ? '' : `${number(limit.value)} (${number(limit.range[0])} to ${number(limit.range[1])})` }),
      make('td', { className: words[limit.state] ?? 'open', textContent: limit.state }))));
  const heads = ['Surface', 'Asked', 'Found', 'Verdict'].map((text) => make('th', { textContent: text }));
  return make('section', { className: 'verdicts' },
    make('h3', { textContent: `${asked.key}: ${asked.title}, ${asked.standard}` }),
    make('div', { className: 'scroll' }, make('table', {}, make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows))));
}

function figures(room) {
  const rows = room.loaded.report.quantities.map((row) =>
    make('tr', {},
      make('td', { textContent: row.name }),
      make('td', { className: 'number', textContent: `${number(row.mean)} ± ${number(row.mean_standard_error ?? 0, 2)}` }),
      make('td', { className: 'number', textContent: number(row.minimum) }),
      make('td', { className: 'number', textContent: number(row.maximum) }),
      make('td', { className: 'number', textContent: number(row.uniformity, 2) })));
  const heads = ['Surface', 'Mean, lx', 'Least', 'Largest', 'Uo'].map((text) => make('th', { textContent: text }));
  return make('section', {},
    make('h3', { textContent: rooms.length > 1 ? `As computed: ${nameOf(room.loaded.job)}` : 'As computed' }),
    make('div', { className: 'scroll' }, make('table', {}, make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows))),
    ...room.loaded.report.notes.map((text) => make('p', { className: 'note', textContent: text })));
}

// ---- begin ----

find('sign-in').querySelector('form').addEventListener('submit', guard(async (event) => {
  event.preventDefault();
  await signIn(Api.keep(find('token').value.trim()));
}));
find('upload').addEventListener('submit', guard(upload));
find('leave').addEventListener('click', signOut);
for (const button of document.querySelectorAll('[data-place]')) {
  button.addEventListener('click', guard(async () => {
    await Promise.all([showUser(), button.dataset.place === 'scenes' ? showScenes() : showJobs()]);
    go(button.dataset.place);
  }));
}
go('sign-in');
const kept = Api.kept();
if (kept) guard(() => signIn(kept))();
