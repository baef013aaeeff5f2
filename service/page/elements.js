// Elements of the page: made, found, and guarded, so that what goes wrong in a handler is told.
export const find = (id) => document.getElementById(id);

export const pause = (time) => new Promise((resolve) => setTimeout(resolve, time));

// make('button', { type: 'button', on: { click } }, child, ...); attributes that are no properties are set as attributes.
export function make(tag, options = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(options)) {
    if (key === 'on') for (const [event, handler] of Object.entries(value)) element.addEventListener(event, guard(handler));
    // The property of that name is read only.
    else if (key in element && key !== 'list') element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

export function button(text, click) {
  return make('button', { type: 'button', textContent: text, on: { click } });
}

// Rows are arrays of texts and elements; a cell that is an array is a class with what is in it.
export function table(heads, rows) {
  const cell = (each) => (Array.isArray(each) ? make('td', { className: each[0] }, each[1]) : make('td', {}, each));
  return make('div', { className: 'scroll' }, make('table', {},
    make('thead', {}, make('tr', {}, ...heads.map((text) => make('th', { textContent: text })))),
    make('tbody', {}, ...rows.map((row) => make('tr', {}, ...row.map(cell))))));
}

export function say(text, isBad = false) {
  find('said').textContent = text;
  find('said').className = isBad ? 'bad' : '';
}

// Whoever listens to `refusals` hears of tokens that are worth nothing any more.
export const refusals = new EventTarget();

export function guard(handler) {
  return async (event) => {
    try {
      await handler(event);
    } catch (error) {
      if (error.status === 401) refusals.dispatchEvent(new Event('token'));
      say(error.message, true);
    }
  };
}
