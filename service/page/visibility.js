// Objects of a scene, which can be hidden: they cast no shadow then, and nothing is computed of them.
import { make } from './elements.js';

// Rows at once; more are found by parts of their names.
const MOST = 100;

export function visibilityChoice(scene, edits) {
  // A light is switched off in its own row.
  const lights = new Set(scene.content.lights.map((light) => light.name));
  const names = scene.content.objects.filter((name) => !lights.has(name) || edits.kept.hidden.includes(name));
  const summary = make('summary');
  const part = make('input', { type: 'search', placeholder: 'part of a name', 'aria-label': 'Part of the name of an object', on: { input: () => list() } });
  const rows = make('div');
  const tell = () => {
    summary.textContent = edits.kept.hidden.length ? `Hidden: ${edits.kept.hidden.join(', ')}` : 'None is hidden';
  };
  const list = () => {
    const found = names.filter((name) => name.toLowerCase().includes(part.value.toLowerCase()));
    rows.replaceChildren(...found.slice(0, MOST).map(row));
    if (found.length > MOST) rows.append(make('p', { className: 'note', textContent: `and ${found.length - MOST} more` }));
  };
  const row = (name) => {
    const box = make('input', {
      type: 'checkbox', checked: !edits.kept.hidden.includes(name),
      on: {
        change: async () => {
          const isHidden = !box.checked;
          try {
            await edits.change((wanted) => {
              wanted.hidden = wanted.hidden.filter((each) => each !== name).concat(isHidden ? [name] : []);
            });
          } finally {
            box.checked = !edits.kept.hidden.includes(name);
            tell();
          }
        },
      },
    });
    return make('label', { className: 'row' }, box, make('span', { textContent: name }));
  };
  tell();
  list();
  return make('details', {}, summary, names.length > MOST ? part : '', rows);
}
