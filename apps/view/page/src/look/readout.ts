// What the pointer is over: a ring on the vertex, its number, place and value; and the labels of markers.
import { counted, shortNumber } from '../colour/ticks';
import { element, put } from '../dom';
import type { SceneViewer } from '../scene/scene_viewer';
import type { Hit } from '../viewer';

const reach = 11; // pixels around a marker

/** A name and what it says; '': neither. */
class Row {
  readonly name = element('dt');
  readonly text = element('dd');
  say(name: string, text: string): void {
    put(this.name, { textContent: name, hidden: text === '' });
    put(this.text, { textContent: text, hidden: text === '' });
  }
}

export class Readout {
  private readonly rows = { vertex: new Row(), at: new Row(), value: new Row() };
  private readonly sheet = element(
    'dl',
    { class: 'readout', hidden: true, 'aria-hidden': true },
    ...Object.values(this.rows).flatMap(({ name, text }) => [name, text]),
  );
  private readonly ring = element('div', { class: 'pointed', hidden: true, 'aria-hidden': true });
  private readonly label = element('div', { class: 'marker-label', hidden: true, 'aria-hidden': true });
  private hit: Hit | null = null;
  private pointer: [number, number] = [0, 0]; // in pixels of the canvas, as all here

  constructor(
    private readonly viewer: SceneViewer,
    host: HTMLElement,
  ) {
    host.append(this.ring, this.label, this.sheet);
    viewer.onHover((hit, x, y) => {
      const { left, top } = host.getBoundingClientRect();
      this.hit = hit;
      this.pointer = [x - left, y - top];
      this.update();
    });
    // What is pointed at may change without the pointer: frames come, the camera turns.
    viewer.stage.afterRender(() => this.hit && this.update());
  }

  private update(): void {
    const { hit, viewer, rows } = this;
    put(this.sheet, { hidden: hit === null });
    this.place(this.ring, hit && viewer.canvasOf(hit.vertex));
    this.updateLabel();
    if (!hit) return;
    const numbers = (list: number[], digits: number): string => list.map((x) => shortNumber(x, digits)).join(', ');
    const value = viewer.valueAt(hit.vertex);
    const { shown } = viewer;
    rows.vertex.say('vertex', counted(viewer.vertexOf?.[hit.vertex] ?? hit.vertex));
    rows.at.say('at', numbers(viewer.positionOf(hit.vertex), 4));
    rows.value.say(shown.kind === 'plain' ? '' : shown.name, value ? numbers(value, 5) : '');
  }

  private updateLabel(): void {
    let nearest = reach;
    let text = '';
    let place: [number, number] | null = null;
    for (const marker of this.hit ? this.viewer.markers.all : []) {
      const at = this.viewer.canvasOf(marker.vertex);
      if (!at || marker.label === '') continue;
      const away = Math.hypot(at[0] - this.pointer[0], at[1] - this.pointer[1]);
      if (away >= nearest) continue;
      nearest = away;
      text = marker.label;
      place = [at[0] + 13, at[1] - 26];
    }
    put(this.label, { textContent: text });
    this.place(this.label, place);
  }

  private place(what: HTMLElement, at: [number, number] | null): void {
    put(what, { hidden: at === null });
    if (at) put(what.style, { transform: `translate(${at[0]}px, ${at[1]}px)` });
  }
}
