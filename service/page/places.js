// The places of the page, of which one is seen at a time.
import { find } from './elements.js';

// Hears of `left` with the place that was seen until now.
export const places = new EventTarget();

export function go(place) {
  for (const main of document.querySelectorAll('main')) {
    if (!main.hidden && main.id !== place) places.dispatchEvent(new CustomEvent('left', { detail: main.id }));
    main.hidden = main.id !== place;
  }
  for (const each of document.querySelectorAll('[data-place]')) each.setAttribute('aria-pressed', each.dataset.place === place);
}

export function showPlaces(isSignedIn) {
  find('places').hidden = find('leave').hidden = !isSignedIn;
}
