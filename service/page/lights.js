// Lights of a scene, with what can be changed of them.
import { guard, make, table } from './elements.js';
import { session } from './session.js';
import { number } from './words.js';

export function lightTable(scene, edits) {
  const heads = ['Light', 'Gives', 'Flux, lm', 'Dimming', 'Temperature, K', 'Spectrum', 'On'];
  return table(heads, scene.content.lights.map((light) => lightRow(light, edits)));
}

function lightRow(light, edits) {
  const fields = {
    flux: numberField(`flux of ${light.name}`, 0, 1e9, 'as it is'),
    dimming: numberField(`dimming of ${light.name}`, 0, 1, '1'),
    temperature: numberField(`temperature of ${light.name}`, 500, 40000, 'as it is'),
  };
  fields.flux.disabled = light.unit !== 'lm';
  const spectrum = spectrumField(light.name);
  const isOn = make('input', { type: 'checkbox', 'aria-label': `${light.name} is on` });
  const show = () => {
    const changes = edits.light(light.name);
    for (const [key, field] of Object.entries(fields)) field.value = changes[key] ?? '';
    spectrum.show(changes.spectrum);
    isOn.checked = changes.is_on ?? light.is_on;
  };
  const change = async (changes) => {
    try {
      await edits.changeLight(light.name, changes);
    } finally {
      // What is kept, whether that is what was asked for or not.
      show();
    }
  };
  // A light has a temperature or a spectrum.
  const rivals = { temperature: { spectrum: null } };
  for (const [key, field] of Object.entries(fields)) {
    listen(field, () => change({ ...(field.value === '' ? {} : rivals[key]), [key]: field.value === '' ? null : Number(field.value) }));
  }
  spectrum.listen((value) => change({ ...(value === null ? {} : { temperature: null }), spectrum: value }));
  listen(isOn, () => change({ is_on: isOn.checked === light.is_on ? null : isOn.checked }));
  show();
  return [
    light.count > 1 ? `${light.name} (×${light.count})` : light.name,
    ['number', `${number(light.amount)} ${light.unit}`],
    fields.flux, fields.dimming, fields.temperature, ['spectrum', spectrum.element], isOn,
  ];
}

function numberField(label, least, most, shown) {
  return make('input', { type: 'number', min: least, max: most, step: 'any', placeholder: shown, 'aria-label': label });
}

function listen(field, changed) {
  field.addEventListener('change', guard(() => field.reportValidity() && changed()));
}

// An illuminant of the list, or a file of the user's, which goes to the service as it is.
function spectrumField(name) {
  const list = make('select', { 'aria-label': `spectrum of ${name}` });
  const file = make('input', { type: 'file', accept: '.csv,.txt,.spdx,.sp,.ti3,.ccss', className: 'aside', 'aria-label': `file of the spectrum of ${name}` });
  const column = make('input', { type: 'number', min: 1, max: 1000, step: 1, title: 'Column of values in the file', 'aria-label': `column of the spectrum of ${name}` });
  let kept;
  return {
    element: make('div', { className: 'row' }, list, make('label', { className: 'button' }, 'File', file), column),
    show(value) {
      kept = value;
      const isFile = typeof value === 'object';
      list.replaceChildren(
        make('option', { value: '', textContent: 'as it is' }),
        isFile ? make('option', { value: 'file', textContent: value.file }) : '',
        make('optgroup', { label: 'CIE illuminants' }, ...session.spectra.map((each) => make('option', { value: `cie ${each.name}`, textContent: title(each) }))),
      );
      list.value = value === undefined ? '' : isFile ? 'file' : `cie ${value}`;
      column.hidden = !isFile;
      column.value = isFile ? value.column ?? 1 : '';
      file.value = '';
    },
    listen(changed) {
      listen(list, () => list.value !== 'file' && changed(list.value === '' ? null : list.value.slice(4)));
      listen(column, () => changed({ ...kept, column: Number(column.value) }));
      listen(file, async () => file.files.length && changed({ file: file.files[0].name, text: await readText(file.files[0]) }));
    },
  };
}

function title({ name, temperature, rendering }) {
  return `${name}${temperature === null ? '' : `, ${Math.round(temperature)} K`}${rendering === null ? '' : `, Ra ${Math.round(rendering)}`}`;
}

// Spreadsheets write UTF-16, too, with a mark at the start.
async function readText(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const kinds = { '255,254': 'utf-16le', '254,255': 'utf-16be' };
  return new TextDecoder(kinds[String(bytes.slice(0, 2))] ?? 'utf-8').decode(bytes);
}
