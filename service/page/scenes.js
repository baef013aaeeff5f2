// Scenes of the user: their list, and one of them with its edits and orders.
import { Edits } from './edits.js';
import { button, find, make } from './elements.js';
import { showJobs } from './jobs.js';
import { lightTable } from './lights.js';
import { materialChoice } from './materials.js';
import { orderForm } from './orders.js';
import { session } from './session.js';
import { visibilityChoice } from './visibility.js';
import { STATES } from './words.js';

export async function showScenes(chosen) {
  const { scenes } = await session.api.get('/scenes');
  find('scene-list').replaceChildren(...scenes.map((scene) => sceneRow(scene, scene.id === chosen)));
  return scenes;
}

function sceneRow(scene, isChosen) {
  return make('li', { className: isChosen ? 'chosen' : '' },
    make('div', { className: 'row' },
      make('span', { className: 'name', textContent: scene.name }),
      make('span', { textContent: STATES[scene.state] }),
      scene.state === 'ready' ? button('Open', () => openScene(scene.id)) : null,
      button('Remove', () => removeScene(scene))),
    scene.note ? make('p', { className: 'note', textContent: scene.note }) : null);
}

async function removeScene(scene) {
  if (!confirm(`Remove '${scene.name}' with all its results?`)) return;
  await session.api.send('DELETE', `/scenes/${scene.id}`);
  find('scene').hidden = true;
  await Promise.all([showScenes(), showJobs()]);
}

// Of the scene that is open.
let edits = null;

export async function openScene(id) {
  // What was changed until now is there when it is asked for, and nothing more is changed meanwhile.
  find('scene').hidden = true;
  await edits?.last;
  const scene = await session.api.get(`/scenes/${id}`);
  edits = new Edits(session.api, scene);
  const heading = (text) => make('h3', { textContent: text });
  find('scene').replaceChildren(
    make('h2', { textContent: scene.name }),
    ...scene.content.problems.map((text) => make('p', { className: 'note', textContent: text })),
    orderForm(scene),
    heading('Lights'), lightTable(scene, edits),
    heading('Materials'), materialChoice(scene, edits),
    heading('Objects'), visibilityChoice(scene, edits),
  );
  find('scene').hidden = false;
  await showScenes(id);
}
