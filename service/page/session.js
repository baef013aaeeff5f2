// Who is signed in on this tab, and what the service has for everybody.
import { Api } from './api.js';
import { find, make } from './elements.js';
import { size } from './words.js';

export const session = { api: null, materials: [], spectra: [] };

export async function open(api) {
  session.api = api;
  await showUser();
  const [{ requirements }, { materials }, { spectra }] = await Promise.all(['/requirements', '/materials', '/spectra'].map((path) => api.get(path)));
  Object.assign(session, { materials, spectra });
  find('requirements').replaceChildren(...requirements.map((each) => make('option', { value: each.key, label: each.title })));
}

export async function showUser() {
  const user = await session.api.get('/me');
  find('who').textContent = `${user.name}, ${size(user.disk)} of ${size(user.quota.disk)}`;
}

export function close() {
  Api.forget();
  session.api = null;
  find('who').textContent = '';
}
