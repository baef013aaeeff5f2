// Numbers, states and names as people read them.
export const STATES = { opening: 'being opened', ready: 'ready', failed: 'failed', queued: 'waiting', running: 'running', done: 'done', cancelled: 'cancelled' };
export const ENDED = ['done', 'failed', 'cancelled'];

// A figure that has no meaning, as the uniformity of darkness, is a dash.
export function number(value, digits = 3) {
  if (value === null || value === undefined) return '–';
  return Number(value.toPrecision(digits)).toLocaleString('en', { maximumSignificantDigits: digits });
}

export function size(bytes) {
  return bytes < 1e6 ? `${number(bytes / 1e3)} kB` : bytes < 1e9 ? `${number(bytes / 1e6)} MB` : `${number(bytes / 1e9)} GB`;
}

export function nameOf(job) {
  return job.sceneName ? `${job.number}. ${job.kind} of ${job.sceneName}` : `${job.number}. ${job.kind}`;
}
