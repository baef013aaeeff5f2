// A scene that is uploaded, until it is open.
import { find, pause, say } from './elements.js';
import { openScene, showScenes } from './scenes.js';
import { session } from './session.js';
import { size } from './words.js';

// Between two questions whether it is open. [ms]
const WAIT = 1000;

export async function upload(event) {
  event.preventDefault();
  const [file] = find('file').files;
  const { largest_upload: most } = await session.api.get('/me');
  if (file.size > most) throw new Error(`${file.name} has ${size(file.size)}; you may upload ${size(most)} now`);
  const bar = find('sent');
  bar.hidden = false;
  try {
    const scene = await session.api.upload(`/scenes?name=${encodeURIComponent(file.name)}`, file, (share) => { bar.value = share; });
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
