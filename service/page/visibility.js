// Objects of a scene, which can be hidden: they cast no shadow then, and nothing is computed of them.
import { makeChoice } from './choices.js';

export function visibilityChoice(scene, edits) {
  // A light is switched off in its own row.
  const lights = new Set(scene.content.lights.map((light) => light.name));
  const names = scene.content.objects.filter((name) => !lights.has(name) || edits.kept.hidden.includes(name));
  return makeChoice(names, {
    label: 'Objects that are there',
    tell: () => (edits.kept.hidden.length ? `Hidden: ${edits.kept.hidden.join(', ')}` : 'None is hidden'),
    isChosen: (name) => !edits.kept.hidden.includes(name),
    changed: (name, isThere) => edits.change((wanted) => {
      wanted.hidden = wanted.hidden.filter((each) => each !== name).concat(isThere ? [] : [name]);
    }),
  });
}
