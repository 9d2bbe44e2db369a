// Elements in a line: element('button', { class: 'quiet', title: 'Fit', onclick: fit }, 'Fit').

type Child = Node | string | number | null | undefined | false;
type Attributes = Record<string, string | number | boolean | null | undefined | ((event: never) => void)>;

/** Attributes that are functions become listeners (`onclick`); false, null and undefined are left out; true is ''. */
export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') {
      made.addEventListener(name.replace(/^on/, ''), value as EventListener);
    } else if (value !== false && value !== null && value !== undefined) {
      made.setAttribute(name, value === true ? '' : String(value));
    }
  }
  for (const child of children) {
    if (child !== null && child !== undefined && child !== false)
      made.append(child instanceof Node ? child : String(child));
  }
  return made;
}

/** Sets what differs, as in put(input, { value: '1' }): the browser works for every write, and what is read aloud is not read
 * twice. */
export function put<T extends object>(on: T, values: Partial<T>): void {
  for (const name of Object.keys(values) as (keyof T)[]) {
    const value = values[name];
    if (value !== undefined && on[name] !== value) on[name] = value;
  }
}

const svgNamespace = 'http://www.w3.org/2000/svg';

/** A 16 x 16 line drawing, hidden from screen readers: what it stands for says the label of its button. */
export function icon(path: string): SVGSVGElement {
  const drawing = document.createElementNS(svgNamespace, 'svg');
  drawing.setAttribute('viewBox', '0 0 16 16');
  drawing.setAttribute('class', 'icon');
  drawing.setAttribute('aria-hidden', 'true');
  const stroke = document.createElementNS(svgNamespace, 'path');
  stroke.setAttribute('d', path);
  drawing.append(stroke);
  return drawing;
}

/** Leaves a file in the user's downloads. */
export function download(name: string, content: Blob): void {
  const address = URL.createObjectURL(content);
  const link = element('a', { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
