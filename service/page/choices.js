// A choice of some of many names, behind a line that tells it; with many, those are shown that have a text in them.
import { make } from './elements.js';

// Rows at once.
const MOST = 100;

// tell() gives the line, isChosen(name) what is shown, and changed(name, isChosen) may refuse by an error.
export function makeChoice(names, { label, tell, isChosen, changed }) {
  const summary = make('summary', { textContent: tell() });
  const part = make('input', { type: 'search', placeholder: 'part of a name', 'aria-label': `Part of a name: ${label}`, on: { input: () => list() } });
  const rows = make('div', { className: 'choices', role: 'group', 'aria-label': label });
  const row = (name) => {
    const box = make('input', {
      type: 'checkbox', checked: isChosen(name),
      on: {
        change: async () => {
          try {
            await changed(name, box.checked);
          } finally {
            box.checked = isChosen(name);
            summary.textContent = tell();
          }
        },
      },
    });
    return make('label', { className: 'row' }, box, make('span', { textContent: name }));
  };
  const list = () => {
    const found = names.filter((name) => name.toLowerCase().includes(part.value.toLowerCase()));
    rows.replaceChildren(...found.slice(0, MOST).map(row));
    if (found.length > MOST) rows.append(make('p', { className: 'note', textContent: `and ${found.length - MOST} more` }));
  };
  list();
  return make('details', {}, summary, names.length > MOST / 5 ? part : '', rows);
}
