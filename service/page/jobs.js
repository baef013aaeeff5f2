// Jobs of the user: their list with what is heard of them, and their files.
import { compare, comparison } from './comparisons.js';
import { button, find, make, pause } from './elements.js';
import { session } from './session.js';
import { ENDED, STATES, nameOf, size } from './words.js';

// Before a line that broke is opened again, and before what was downloaded is let go. [ms]
const WAIT = 1000;

let jobs = new Map();
const followed = new Map();

export async function showJobs() {
  const [{ jobs: found }, { scenes }] = await Promise.all([session.api.get('/jobs'), session.api.get('/scenes')]);
  const names = new Map(scenes.map((scene) => [scene.id, scene.name]));
  jobs = new Map(found.map((job) => [job.id, { ...job, sceneName: names.get(job.scene) }]));
  for (const job of jobs.values()) if (!ENDED.includes(job.state)) follow(job);
  listJobs();
}

export function addJob(job) {
  jobs.set(job.id, job);
  follow(job);
  listJobs();
}

export function forgetJobs() {
  for (const stop of followed.values()) stop.abort();
  followed.clear();
  jobs.clear();
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
        await session.api.follow(job.id, told, stop.signal);
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
  const isWalkable = job.kind === 'bake' && job.state === 'done';
  const { first } = comparison;
  const remove = async () => {
    await session.api.send('DELETE', `/jobs/${job.id}`);
    jobs.delete(job.id);
    listJobs();
  };
  return make('li', { id: `job-${job.id}` },
    make('div', { className: 'row' },
      make('span', { className: 'name', textContent: nameOf(job) }),
      make('span', { textContent: state }),
      isWalkable ? button('Walk', () => compare(job)) : null,
      isWalkable && first && first.id !== job.id ? button(`Beside ${first.number}`, () => compare(first, job)) : null,
      job.state === 'done' ? button('Files', () => showFiles(job)) : null,
      ENDED.includes(job.state) ? button('Remove', remove) : button('Cancel', () => session.api.send('POST', `/jobs/${job.id}/cancel`))),
    job.state === 'running' ? make('progress', { max: 1, value: job.progress?.share ?? 0 }) : null,
    job.note ? make('p', { className: 'note', textContent: job.note }) : null,
    make('div', { className: 'files' }));
}

async function showFiles(job) {
  const { files } = await session.api.get(`/jobs/${job.id}/files`);
  find(`job-${job.id}`).querySelector('.files').replaceChildren(...files.map((file) =>
    make('div', { className: 'row' },
      make('span', { className: 'name', textContent: file.name }),
      make('span', { textContent: size(file.bytes) }),
      button('Download', () => download(job, file.name)))));
}

async function download(job, name) {
  const place = URL.createObjectURL(new Blob([await session.api.file(job.id, name)]));
  make('a', { href: place, download: name.split('/').pop() }).click();
  setTimeout(() => URL.revokeObjectURL(place), WAIT);
}
