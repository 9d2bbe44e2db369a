// What the pointer is over: a ring on the vertex, its number, place and value; and the labels of markers.
import { counted, shortNumber } from '../colour/ticks';
import { element } from '../dom';
import type { SceneViewer } from '../scene/scene_viewer';
import type { Hit } from '../viewer';

const reach = 11; // pixels around a marker

export class Readout {
  private readonly sheet = element('dl', { class: 'readout', hidden: true, 'aria-hidden': true });
  private readonly ring = element('div', { class: 'pointed', hidden: true, 'aria-hidden': true });
  private readonly label = element('div', { class: 'marker-label', hidden: true, 'aria-hidden': true });
  private hit: Hit | null = null;
  private pointer: [number, number] = [0, 0];

  constructor(
    private readonly viewer: SceneViewer,
    private readonly host: HTMLElement,
  ) {
    host.append(this.ring, this.label, this.sheet);
    viewer.onHover((hit, x, y) => {
      this.hit = hit;
      this.pointer = [x, y];
      this.update();
    });
    // What is pointed at may change without the pointer: frames come, the camera turns.
    viewer.stage.afterRender(() => this.hit && this.update());
  }

  private update(): void {
    const { hit } = this;
    this.sheet.hidden = this.ring.hidden = hit === null;
    this.updateLabel();
    if (!hit) return;
    this.place(this.ring, this.viewer.screenOf(hit.vertex));
    const number = this.viewer.vertexOf?.[hit.vertex] ?? hit.vertex;
    const rows: [string, string][] = [
      ['vertex', counted(number)],
      [
        'at',
        this.viewer
          .positionOf(hit.vertex)
          .map((x) => shortNumber(x, 4))
          .join(', '),
      ],
    ];
    const value = this.viewer.valueAt(hit.vertex);
    const { shown } = this.viewer;
    if (value && shown.kind !== 'plain') rows.push([shown.name, value.map((x) => shortNumber(x, 5)).join(', ')]);
    this.sheet.replaceChildren(...rows.flatMap(([name, text]) => [element('dt', {}, name), element('dd', {}, text)]));
  }

  private updateLabel(): void {
    let nearest = reach;
    this.label.hidden = true;
    if (!this.hit) return;
    for (const marker of this.viewer.markers.all) {
      const at = this.viewer.screenOf(marker.vertex);
      if (!at || marker.label === '') continue;
      const away = Math.hypot(at[0] - this.pointer[0], at[1] - this.pointer[1]);
      if (away >= nearest) continue;
      nearest = away;
      this.label.textContent = marker.label;
      this.label.hidden = false;
      this.place(this.label, [at[0] + 13, at[1] - 26]);
    }
  }

  private place(what: HTMLElement, at: [number, number] | null): void {
    what.hidden = at === null;
    if (!at) return;
    const { left, top } = this.host.getBoundingClientRect();
    what.style.transform = `translate(${at[0] - left}px, ${at[1] - top}px)`;
  }
}
