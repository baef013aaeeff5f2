// Materials of a scene, in whose place others can be put: of the library, or of the scene itself.
import { button, make } from './elements.js';
import { session } from './session.js';

export function materialChoice(scene, edits) {
  const names = scene.content.materials;
  if (!names.length) return make('p', { className: 'note', textContent: 'The scene has no materials.' });
  const option = (value, text) => make('option', { value, textContent: text });
  const material = make('select', { 'aria-label': 'Material' }, ...names.map((name) => option(name, name)));
  const place = make('select', { 'aria-label': 'Material in its place' },
    make('optgroup', { label: 'Library' }, ...session.materials.map((each) => option(JSON.stringify(each.name), each.title))),
    make('optgroup', { label: 'Of the scene' }, ...names.map((name) => option(JSON.stringify({ scene: name }), name))));
  const list = make('ul', { className: 'list' });
  const change = async (alter) => {
    await edits.change(alter);
    show();
  };
  const show = () => {
    list.replaceChildren(...Object.entries(edits.kept.materials).map(([name, wanted]) =>
      make('li', { className: 'row' },
        make('span', { className: 'name', textContent: `${name} → ${titleOf(wanted)}` }),
        button('As it was', () => change((edited) => { delete edited.materials[name]; })))));
  };
  show();
  return make('div', {},
    make('form', {
      on: {
        submit: async (event) => {
          event.preventDefault();
          await change((edited) => { edited.materials[material.value] = JSON.parse(place.value); });
        },
      },
    }, material, make('span', { textContent: 'becomes' }), place, make('button', { textContent: 'Replace' })),
    list);
}

function titleOf(wanted) {
  if (typeof wanted === 'object') return `${wanted.scene} (of the scene)`;
  return session.materials.find((each) => each.name === wanted)?.title ?? wanted;
}
