// What panels are put together from.
import { element, put } from '../dom';

export type Child = Node | string;
type Attributes = Record<string, string | number | boolean | ((event: never) => void)>;

export function button(text: string, test: string, press: () => void, look = ''): HTMLButtonElement {
  return element('button', { type: 'button', class: look, 'data-test': test, onclick: press }, text);
}

/** A titled part of a panel. */
export function group(title: string, ...children: Child[]): HTMLElement {
  return element('section', { class: 'group', 'aria-label': title }, element('h3', {}, title), ...children);
}

/** Things beside each other. */
export function row(...children: Child[]): HTMLElement {
  return element('div', { class: 'row' }, ...children);
}

export function write(place: Element, text: string): void {
  put(place, { textContent: text });
}

export function drawing<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[Tag] {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') made.addEventListener(name.replace(/^on/, ''), value as EventListener);
    else made.setAttribute(name, String(value));
  }
  made.append(...children);
  return made;
}
