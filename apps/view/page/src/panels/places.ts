// The list of what was placed on vertices: select, edit, remove. Rows stay where they are while the list changes, so that
// the one that has the focus keeps it.
import { element } from '../dom';
import { NumberField } from './controls';
import { counted } from './numbers';
import { button, write } from './parts';

export interface Place {
  vertex: number;
  /** A number that can be edited, or how the value reads. */
  value: number | string;
  color?: string; // CSS, of the dot
}

interface Options {
  test: string; // 'heat' makes heat-place-12, heat-value-12, heat-remove-12
  nothing: string; // what an empty list says
  change?: (vertex: number, value: number) => void;
  remove: (vertex: number) => void;
  select: (vertex: number | null) => void;
}

interface Row {
  element: HTMLElement;
  dot: HTMLElement;
  name: HTMLButtonElement;
  text: HTMLElement;
  field: NumberField | null;
}

const most = 100; // rows

export class Places {
  readonly element: HTMLElement;
  private readonly list: HTMLElement;
  private readonly more: HTMLElement;
  private readonly rows = new Map<number, Row>();
  private chosen: number | null = null;

  constructor(private readonly options: Options) {
    this.list = element('ul', { 'data-test': `${options.test}-places` });
    this.more = element('p', { class: 'hint', 'data-test': `${options.test}-places-more` });
    this.element = element('div', { class: 'places' }, this.list, this.more);
    this.set([], null);
  }

  set(places: Place[], selected: number | null): void {
    const shown = places.slice(0, most);
    const chosen = places.find((place) => place.vertex === selected);
    if (chosen !== undefined && !shown.includes(chosen)) shown.unshift(chosen);

    const kept = new Set(shown.map((place) => place.vertex));
    for (const [vertex, row] of this.rows) {
      if (kept.has(vertex)) continue;
      row.element.remove();
      this.rows.delete(vertex);
    }
    shown.forEach((place, i) => {
      const row = this.rows.get(place.vertex) ?? this.add(place);
      if (this.list.children[i] !== row.element) this.list.insertBefore(row.element, this.list.children[i] ?? null);
      if (typeof place.value === 'number') row.field?.set(place.value);
      else write(row.text, place.value);
      row.dot.style.background = place.color ?? '';
      const isChosen = place.vertex === selected;
      row.element.classList.toggle('selected', isChosen);
      row.name.setAttribute('aria-pressed', String(isChosen));
    });
    // A vertex that was picked in the picture is brought into view, but the list does not move on its own after that.
    if (selected !== this.chosen && selected !== null) {
      this.rows.get(selected)?.element.scrollIntoView({ block: 'nearest' });
    }
    this.chosen = selected;

    const hidden = places.length - shown.length;
    write(this.more, places.length === 0 ? this.options.nothing : hidden > 0 ? `and ${counted(hidden)} more` : '');
    this.more.hidden = this.more.textContent === '';
  }

  private add(place: Place): Row {
    const { vertex } = place;
    const { test, change } = this.options;
    const dot = element('span', { class: 'dot' });
    const name = button(`vertex ${vertex}`, `${test}-place-${vertex}`, () =>
      this.options.select(this.chosen === vertex ? null : vertex),
    );
    name.className = 'name';
    name.prepend(dot);
    const text = element('span', { class: 'value' });
    const field =
      typeof place.value === 'number' && change !== undefined
        ? new NumberField({
            label: `Value at vertex ${vertex}`,
            test: `${test}-value-${vertex}`,
            change: (x) => change(vertex, x),
          })
        : null;
    field?.element.classList.add('bare');
    const remove = button('×', `${test}-remove-${vertex}`, () => this.options.remove(vertex), 'quiet remove');
    remove.setAttribute('aria-label', `Remove vertex ${vertex}`);
    const made = element('li', {}, name, field?.element ?? text, remove);
    const row = { element: made, dot, name, text, field };
    this.rows.set(vertex, row);
    return row;
  }
}
