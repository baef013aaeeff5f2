// The page for people: signing in, and the ways between its places.
import { Api } from './api.js';
import { comparison } from './comparisons.js';
import { find, guard, refusals, say } from './elements.js';
import { forgetJobs, showJobs } from './jobs.js';
import { go, showPlaces } from './places.js';
import { showScenes } from './scenes.js';
import { close, open, showUser } from './session.js';
import { upload } from './uploads.js';

async function signIn(api) {
  await open(api);
  await Promise.all([showScenes(), showJobs()]);
  showPlaces(true);
  say('');
  go('scenes');
}

function signOut() {
  close();
  forgetJobs();
  comparison.first = null;
  showPlaces(false);
  go('sign-in');
}

find('sign-in').querySelector('form').addEventListener('submit', guard(async (event) => {
  event.preventDefault();
  await signIn(Api.keep(find('token').value.trim()));
}));
find('upload').addEventListener('submit', guard(upload));
find('leave').addEventListener('click', signOut);
refusals.addEventListener('token', signOut);
for (const button of document.querySelectorAll('[data-place]')) {
  button.addEventListener('click', guard(async () => {
    await Promise.all([showUser(), button.dataset.place === 'scenes' ? showScenes() : showJobs()]);
    go(button.dataset.place);
  }));
}
go('sign-in');
const kept = Api.kept();
if (kept) guard(() => signIn(kept))();
