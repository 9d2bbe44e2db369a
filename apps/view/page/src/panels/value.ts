// The value that is painted: a number, a colour or a displacement.
import { element } from '../dom';
import type { PaintMode } from '../protocol';
import { NumberField, Slider } from './controls';
import { InHand } from './inhand';
import { clamped, short } from './numbers';
import { row } from './parts';

export class Value {
  readonly element: HTMLElement;
  private readonly scalar: Slider;
  private readonly color: HTMLInputElement;
  private readonly colorHand = new InHand();
  private readonly parts: NumberField[];
  private readonly hosts: Record<PaintMode, HTMLElement>;
  private mode: PaintMode = 'scalar';
  /** What is painted next, in each mode. */
  private readonly current: Record<PaintMode, number[]> = {
    scalar: [1],
    colors: [0.85, 0.25, 0.2],
    displacement: [0, 0, 0],
  };
  private ends: [number, number] = [0, 1];

  constructor(private readonly change: (value: number[], last: boolean) => void) {
    this.scalar = new Slider({
      label: 'Value',
      test: 'paint-value',
      low: 0,
      high: 1,
      value: 1,
      change: (x, last) => this.chose([x], last),
    });
    this.color = element('input', {
      type: 'color',
      'data-test': 'paint-color',
      value: hexOf(this.current.colors),
      oninput: () => {
        this.colorHand.take();
        this.chose(rgbOf(this.color.value), false);
      },
      onchange: () => {
        this.chose(rgbOf(this.color.value), true);
        this.colorHand.leave();
      },
    });
    this.parts = ['x', 'y', 'z'].map(
      (axis, i) =>
        new NumberField({
          label: axis,
          test: `paint-displacement-${axis}`,
          change: (x) =>
            this.chose(
              this.current.displacement.map((old, j) => (j === i ? x : old)),
              true,
            ),
        }),
    );
    this.hosts = {
      scalar: this.scalar.element,
      colors: element('label', { class: 'labelled' }, element('span', {}, 'Colour'), this.color),
      displacement: row(...this.parts.map((part) => part.element)),
    };
    this.element = element('div', {}, ...Object.values(this.hosts));
    this.setMode('scalar');
  }

  get value(): number[] {
    return this.current[this.mode];
  }

  /** The width of the scale, which a drag over the height of a hand goes through. */
  get span(): number {
    return this.ends[1] - this.ends[0];
  }

  setMode(mode: PaintMode): void {
    this.mode = mode;
    for (const [name, host] of Object.entries(this.hosts)) host.hidden = name !== mode;
  }

  setEnds(low: number, high: number): void {
    this.ends = [low, high];
    this.scalar.ends(low, high);
  }

  set(value: number[]): void {
    if (value.length !== this.value.length) return;
    if (this.mode === 'scalar') this.scalar.set(value[0]);
    else if (this.mode === 'colors') this.colorHand.pass(() => (this.color.value = hexOf(value)));
    else this.parts.forEach((part, i) => part.set(value[i]));
    this.current[this.mode] = value;
  }

  private chose(value: number[], last: boolean): void {
    this.current[this.mode] = value;
    this.change(value, last);
  }
}

export function hexOf(rgb: number[]): string {
  const part = (x: number) =>
    Math.round(255 * clamped(x, 0, 1))
      .toString(16)
      .padStart(2, '0');
  return `#${rgb.map(part).join('')}`;
}

function rgbOf(hex: string): number[] {
  return [1, 3, 5].map((at) => Number((parseInt(hex.slice(at, at + 2), 16) / 255).toFixed(4)));
}

/** As a label. */
export function read(value: number[], mode: PaintMode): string {
  if (mode === 'colors') return hexOf(value);
  return value.map((x) => short(x, 3)).join(', ');
}
