// What the field is to be like: the weights of gamma_1 K + gamma_2 K D K, and whether it stays within the given values.
import { element } from '../dom';
import type { Request, StateMessage } from '../protocol';
import type { Viewer } from '../viewer';
import { Check, Slider } from './controls';
import { short } from './numbers';
import { group, write } from './parts';
import { Stream } from './stream';
import { edgeOf } from './touch';

export class Weights {
  readonly element: HTMLElement;
  private readonly first: Slider;
  private readonly second: Slider;
  private readonly bounded: Check;
  private readonly meaning: HTMLElement;
  private state: StateMessage['paint'] | null = null;
  private edge = 0;

  constructor(
    send: (request: Request) => number,
    private readonly stream: Stream,
  ) {
    this.first = new Slider({
      label: 'Laplacian γ₁',
      test: 'paint-gamma-1',
      low: 0,
      high: 1,
      least: 0,
      value: 1,
      settled: () => stream.settled,
      change: (_, last) => this.weigh(last),
    });
    this.second = new Slider({
      label: 'bi-Laplacian γ₂',
      test: 'paint-gamma-2',
      low: 1e-4,
      high: 1,
      least: 0,
      logarithmic: true,
      zero: true,
      value: 0,
      settled: () => stream.settled,
      change: (_, last) => this.weigh(last),
    });
    this.bounded = new Check('Never beyond the given values', 'paint-bounded', false, (bounded) =>
      send({ do: 'paint.set', bounded }),
    );
    this.meaning = element('p', { class: 'hint', 'data-test': 'paint-meaning' });
    this.element = group('Smoothness', this.first.element, this.second.element, this.meaning, this.bounded.element);
  }

  update(paint: StateMessage['paint'], viewer: Viewer): void {
    this.state = paint;
    this.edge = edgeOf(viewer);
    // sqrt(gamma_2 / gamma_1) goes from a tenth of an edge to three times the whole mesh.
    this.second.ends(0.01 * this.edge ** 2, 10 * Math.max(viewer.diagonal, this.edge) ** 2);
    this.first.set(paint.gamma_1);
    this.second.set(paint.gamma_2);
    this.bounded.set(paint.bounded);
    this.explain(paint.gamma_1, paint.gamma_2);
  }

  answered(id: number): void {
    this.stream.answered(id);
  }

  private weigh(last: boolean): void {
    const gamma_1 = this.first.value;
    const gamma_2 = this.second.value;
    this.explain(gamma_1, gamma_2);
    if (gamma_1 === 0 && gamma_2 === 0) {
      // Nothing to solve: what the program has comes back when the slider is let go.
      if (this.state !== null) {
        this.first.set(this.state.gamma_1);
        this.second.set(this.state.gamma_2);
      }
      return;
    }
    this.stream.offer(() => ({ do: 'paint.set', gamma_1, gamma_2 }));
    if (last) this.stream.flush();
  }

  private explain(gamma_1: number, gamma_2: number): void {
    write(this.meaning, this.sentence(gamma_1, gamma_2));
  }

  private sentence(gamma_1: number, gamma_2: number): string {
    if (gamma_1 === 0 && gamma_2 === 0) return 'One of the two must be more than 0.';
    if (gamma_2 === 0) return 'As level as can be, with a spike at each given value.';
    if (gamma_1 === 0) return 'Smooth everywhere; it may overshoot the given values.';
    const length = Math.sqrt(gamma_2 / gamma_1);
    return `Smooth within √(γ₂/γ₁) = ${short(length, 3)} of a given value: ${short(length / this.edge, 3)} edges.`;
  }
}
