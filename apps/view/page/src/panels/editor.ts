// The filter curve over the spectrum, drawn and edited: drag a point or move it by the arrow keys, double-click to add one,
// Delete to remove it.
import { element } from '../dom';
import { Axis } from './axis';
import { Check, NumberField } from './controls';
import { meanGain, type Point } from './curve';
import { InHand } from './inhand';
import { clamped, neat, short } from './numbers';
import { button, drawing, row, write } from './parts';

export interface Spectrum {
  frequencies: ArrayLike<number>;
  cutoff: number;
  nyquist: number;
}

const height = 190;
const margin = { left: 32, right: 8, top: 10, bottom: 32 };
const tops = [2, 3, 5, 10, 20, 50, 100]; // gains at the upper edge
const keySteps = 100; // of the arrow keys across the chart

let editors = 0;

export class CurveEditor {
  readonly element: HTMLElement;
  private readonly chart: SVGSVGElement;
  private readonly back: SVGGElement;
  private readonly line: SVGPathElement;
  private readonly mean: SVGPathElement;
  private readonly shownLine: SVGLineElement;
  private readonly handles: SVGGElement;
  private readonly frequency: NumberField;
  private readonly gain: NumberField;
  private readonly remove: HTMLButtonElement;
  private readonly packet: HTMLElement;
  private readonly logarithmic: Check;
  private readonly hatch = `hatch-${(editors += 1)}`;

  private readonly hand: InHand;
  private points: Point[] = [
    [0, 1],
    [1, 1],
  ];
  private spectrum: Spectrum = { frequencies: [], cutoff: 0, nyquist: 1 };
  private shown: number | null = null; // frequency of the eigenfunction in the picture
  private chosen = 0;
  private top = tops[0];
  private width = 300;

  /** change: `last` when the user has let go. settled: whether the program has answered. */
  constructor(
    private readonly change: (curve: Point[], last: boolean) => void,
    settled: () => boolean,
  ) {
    this.hand = new InHand(settled);
    this.back = drawing('g', {});
    this.line = drawing('path', { class: 'curve' });
    this.mean = drawing('path', { class: 'mean' });
    this.shownLine = drawing('line', { class: 'shown', y1: margin.top, y2: height - margin.bottom });
    this.handles = drawing('g', {});
    const stripes = drawing('path', { d: 'M-1 7 7 -1M-1 1 1 -1M5 7 7 5', class: 'stripes' });
    this.chart = drawing(
      'svg',
      {
        class: 'editor',
        height,
        role: 'group',
        'aria-label': 'Filter curve: gain over frequency',
        'data-test': 'curve',
        ondblclick: (event: MouseEvent) => this.addAt(event),
      },
      drawing(
        'defs',
        {},
        drawing('pattern', { id: this.hatch, width: 6, height: 6, patternUnits: 'userSpaceOnUse' }, stripes),
      ),
      this.back,
      this.shownLine,
      this.mean,
      this.line,
      this.handles,
    );
    this.frequency = new NumberField({
      label: 'Frequency',
      test: 'curve-frequency',
      low: 0,
      change: (f) => this.moveTo(this.chosen, f, this.points[this.chosen][1], true),
    });
    this.gain = new NumberField({
      label: 'Gain',
      test: 'curve-gain',
      change: (g) => this.moveTo(this.chosen, this.points[this.chosen][0], g, true),
    });
    const add = button('Add', 'curve-add', () => this.addBehind(this.chosen), 'quiet');
    add.title = 'Add a point behind this one';
    this.remove = button('Remove', 'curve-remove', () => this.removeAt(this.chosen), 'quiet');
    this.logarithmic = new Check('Logarithmic axis', 'curve-logarithmic', false, () => this.draw());
    this.packet = element('p', { class: 'hint', 'data-test': 'curve-packet' });
    this.element = element(
      'div',
      { class: 'curve-editor' },
      this.chart,
      row(this.frequency.element, this.gain.element, add, this.remove),
      this.packet,
      this.logarithmic.element,
    );
    new ResizeObserver(([entry]) => {
      const width = Math.round(entry.contentRect.width);
      if (width === 0 || width === this.width) return;
      this.width = width;
      this.draw();
    }).observe(this.chart);
    this.draw();
  }

  get curve(): Point[] {
    return this.points;
  }

  setSpectrum(spectrum: Spectrum): void {
    // Of a large mesh a basis holds the first few frequencies only: a linear axis would have no room for them.
    const other = spectrum.cutoff !== this.spectrum.cutoff || spectrum.nyquist !== this.spectrum.nyquist;
    if (other) this.logarithmic.set(spectrum.frequencies.length > 2 && spectrum.cutoff < 0.3 * spectrum.nyquist);
    this.spectrum = spectrum;
    this.draw();
  }

  /** By the program: not while the user drags. */
  setCurve(curve: Point[]): void {
    this.hand.pass(() => this.take(curve));
  }

  /** By a preset. */
  replace(curve: Point[]): void {
    this.top = tops[0];
    this.take(curve);
    this.say(true);
  }

  setShown(frequency: number | null): void {
    this.shown = frequency;
    this.drawShown();
  }

  setActive(active: boolean): void {
    this.chart.classList.toggle('idle', !active);
  }

  private take(curve: Point[]): void {
    this.points = curve.map(([f, g]) => [f, g]);
    this.chosen = Math.min(this.chosen, curve.length - 1);
    const highest = Math.max(...curve.map(([, gain]) => gain));
    this.top = Math.max(this.top, tops.find((top) => top >= highest) ?? highest);
    this.draw();
  }

  private get axis(): Axis {
    const { frequencies, nyquist } = this.spectrum;
    let least = nyquist / 1000;
    for (let k = 0; k < frequencies.length; k += 1) {
      if (frequencies[k] <= nyquist * 1e-6) continue; // constants
      least = frequencies[k] / 2;
      break;
    }
    return new Axis(nyquist, least, this.logarithmic.on, margin.left, this.width - margin.right);
  }

  private get bottom(): number {
    return height - margin.bottom;
  }

  private y(gain: number): number {
    return this.bottom - (clamped(gain, 0, this.top) / this.top) * (this.bottom - margin.top);
  }

  private gainOf(y: number): number {
    return clamped(((this.bottom - y) / (this.bottom - margin.top)) * this.top, 0, this.top);
  }

  private draw(): void {
    this.drawBack();
    this.drawCurve();
    this.drawShown();
  }

  private drawBack(): void {
    const axis = this.axis;
    const { frequencies, cutoff, nyquist } = this.spectrum;
    const { bottom } = this;
    const right = this.width - margin.right;
    const start = axis.place(cutoff);
    const parts: SVGElement[] = [];
    const words = (x: number, y: number, text: string, anchor: string, look = '') =>
      drawing('text', { x, y, 'text-anchor': anchor, class: look }, text);

    if (frequencies.length > 0 && cutoff < nyquist) {
      const width = right - start;
      parts.push(
        drawing('rect', { x: start, y: margin.top, width, height: bottom - margin.top, fill: `url(#${this.hatch})` }),
      );
      if (width > 90) parts.push(words((start + right) / 2, margin.top + 12, 'one wave packet', 'middle', 'quiet'));
    }
    for (const gain of [0, 1, this.top]) {
      const y = this.y(gain);
      parts.push(drawing('line', { x1: margin.left, x2: right, y1: y, y2: y, class: gain === 1 ? 'one' : 'grid' }));
      parts.push(words(margin.left - 11, y + 3.5, String(gain), 'end'));
    }
    // The left end of a logarithmic axis stands for 0.
    for (const number of axis.logarithmic ? [0, ...axis.numbers()] : axis.numbers()) {
      const x = axis.place(number);
      if (x > right - 4 || (number > 0 && x < margin.left + 22)) continue;
      parts.push(drawing('line', { x1: x, x2: x, y1: bottom, y2: bottom + 4, class: 'grid' }));
      parts.push(words(x, bottom + 15, short(number, 3), 'middle'));
    }
    parts.push(words(right, height - 3, 'frequency, rad per length', 'end', 'quiet'));
    let ticks = '';
    let last = -1;
    for (let k = 0; k < frequencies.length; k += 1) {
      const x = Math.round(2 * axis.place(frequencies[k])) / 2;
      if (x === last) continue; // a line that is there already
      ticks += `M${x} ${bottom}v-7`;
      last = x;
    }
    parts.push(drawing('path', { d: ticks, class: 'ticks' }));
    this.back.replaceChildren(...parts);
  }

  private drawShown(): void {
    const x = this.shown === null ? 0 : this.axis.place(this.shown);
    this.shownLine.style.display = this.shown === null ? 'none' : '';
    this.shownLine.setAttribute('x1', String(x));
    this.shownLine.setAttribute('x2', String(x));
  }

  private drawCurve(): void {
    const axis = this.axis;
    const { cutoff, nyquist, frequencies } = this.spectrum;
    this.line.setAttribute('d', `M${this.way(axis).join('L')}`);

    const packet = meanGain(this.points, cutoff, nyquist);
    const there = frequencies.length > 0 && cutoff < nyquist;
    this.mean.setAttribute('d', there ? `M${axis.place(cutoff)} ${this.y(packet)}H${axis.place(nyquist)}` : '');
    write(
      this.packet,
      there
        ? `Above ${short(cutoff)} the basis ends: all that is finer is kept as one wave packet, with the mean gain ${short(packet, 3)}.`
        : '',
    );

    while (this.handles.childElementCount > this.points.length) this.handles.lastElementChild?.remove();
    while (this.handles.childElementCount < this.points.length)
      this.handles.append(this.handle(this.handles.childElementCount));
    this.points.forEach(([frequency, gain], i) => {
      const handle = this.handles.children[i];
      handle.setAttribute('transform', `translate(${axis.place(frequency)} ${this.y(gain)})`);
      handle.setAttribute('aria-valuenow', short(gain));
      handle.setAttribute('aria-valuetext', `gain ${short(gain, 3)} at frequency ${short(frequency, 3)}`);
      handle.setAttribute('aria-label', `Point ${i + 1} of ${this.points.length}`);
      handle.classList.toggle('chosen', i === this.chosen);
    });
    const [frequency, gain] = this.points[this.chosen];
    this.frequency.set(frequency);
    this.gain.set(gain);
    this.remove.disabled = this.points.length === 1;
  }

  /** From end to end of the axis. On a logarithmic one a line between two points is bent. */
  private way(axis: Axis): string[] {
    const { points } = this;
    const ends: Point[] = [[0, points[0][1]], ...points, [axis.most, points[points.length - 1][1]]];
    const places: string[] = [];
    ends.forEach(([f1, g1], i) => {
      const [f0, g0] = ends[Math.max(i - 1, 0)];
      const parts = axis.logarithmic && f1 > f0 && g1 !== g0 ? 24 : 1;
      for (let part = 1; part <= parts; part += 1) {
        const [x0, x1] = [axis.place(f0), axis.place(f1)];
        const x = x0 + ((x1 - x0) * part) / parts;
        const gain = part === parts ? g1 : g0 + ((g1 - g0) * (axis.frequency(x) - f0)) / (f1 - f0);
        places.push(`${x} ${this.y(gain)}`);
      }
    });
    return places;
  }

  private handle(i: number): SVGGElement {
    return drawing(
      'g',
      {
        class: 'handle',
        tabindex: 0,
        role: 'slider',
        'aria-valuemin': 0,
        'data-test': `curve-point-${i}`,
        onpointerdown: (event: PointerEvent) => this.grab(i, event),
        onkeydown: (event: KeyboardEvent) => this.key(i, event),
        onfocus: () => this.choose(i),
        ondblclick: (event: Event) => event.stopPropagation(),
      },
      drawing('circle', { r: 14, class: 'reach' }),
      drawing('circle', { r: 5 }),
    );
  }

  private choose(i: number): void {
    if (this.chosen === i) return;
    this.chosen = i;
    this.drawCurve();
  }

  private at(event: MouseEvent): [x: number, y: number] {
    const box = this.chart.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  private grab(i: number, down: PointerEvent): void {
    if (down.button !== 0) return;
    down.preventDefault(); // no selection of text; the focus is given here
    const handle = this.handles.children[i] as SVGGElement;
    handle.focus();
    this.choose(i);
    handle.setPointerCapture(down.pointerId);
    this.hand.take();
    // The point stays where it was taken hold of, and does not jump to the pointer.
    const [x0, y0] = this.at(down);
    const axis = this.axis;
    const [dx, dy] = [axis.place(this.points[i][0]) - x0, this.y(this.points[i][1]) - y0];
    const move = (event: PointerEvent) => {
      const [x, y] = this.at(event);
      this.moveTo(i, axis.frequency(x + dx), this.gainOf(y + dy), false);
    };
    const end = () => {
      handle.removeEventListener('pointermove', move);
      handle.removeEventListener('pointerup', end);
      handle.removeEventListener('pointercancel', end);
      // At the upper edge there is more to come.
      if (this.points[i][1] >= this.top) this.top = tops.find((top) => top > this.top) ?? 2 * this.top;
      this.draw();
      this.say(true);
    };
    handle.addEventListener('pointermove', move);
    handle.addEventListener('pointerup', end);
    handle.addEventListener('pointercancel', end);
  }

  private key(i: number, event: KeyboardEvent): void {
    const axis = this.axis;
    const [frequency, gain] = this.points[i];
    const many = event.shiftKey ? 5 : 1;
    const dx = (many * (this.width - margin.left - margin.right)) / keySteps;
    const dg = (many * this.top) / keySteps;
    const x = axis.place(frequency);
    switch (event.key) {
      case 'ArrowLeft':
        this.moveTo(i, axis.frequency(x - dx), gain, true);
        break;
      case 'ArrowRight':
        this.moveTo(i, axis.frequency(x + dx), gain, true);
        break;
      case 'ArrowUp':
        this.moveTo(i, frequency, gain + dg, true);
        break;
      case 'ArrowDown':
        this.moveTo(i, frequency, gain - dg, true);
        break;
      case 'Delete':
      case 'Backspace':
        this.removeAt(i);
        break;
      case 'Insert':
      case '+':
        this.addBehind(i);
        break;
      default:
        return;
    }
    event.preventDefault();
  }

  /** Points keep their order. */
  private moveTo(i: number, frequency: number, gain: number, last: boolean): void {
    const low = this.points[i - 1]?.[0] ?? 0;
    const high = this.points[i + 1]?.[0] ?? Math.max(this.spectrum.nyquist, low);
    this.points[i] = [clamped(neat(frequency), low, high), Math.max(neat(gain), 0)];
    if (gain > this.top) this.top = tops.find((top) => top >= gain) ?? gain;
    if (last) this.draw();
    else this.drawCurve();
    this.say(last);
  }

  private addAt(event: MouseEvent): void {
    const [x, y] = this.at(event);
    if (y > this.bottom + 6) return;
    const frequency = neat(this.axis.frequency(x));
    const behind = this.points.findIndex(([f]) => f > frequency);
    this.insert(behind === -1 ? this.points.length : behind, [frequency, neat(this.gainOf(y))]);
  }

  private addBehind(i: number): void {
    const axis = this.axis;
    const [f0, g0] = this.points[i];
    const [f1, g1] = this.points[i + 1] ?? [this.spectrum.nyquist, g0];
    this.insert(i + 1, [neat(axis.frequency((axis.place(f0) + axis.place(f1)) / 2)), (g0 + g1) / 2]);
  }

  private insert(i: number, point: Point): void {
    this.points.splice(i, 0, point);
    this.settle(i);
  }

  private removeAt(i: number): void {
    if (this.points.length === 1) return;
    this.points.splice(i, 1);
    this.settle(Math.min(i, this.points.length - 1));
  }

  private settle(chosen: number): void {
    this.chosen = chosen;
    this.draw();
    (this.handles.children[chosen] as SVGGElement).focus();
    this.say(true);
  }

  private say(last: boolean): void {
    this.hand.take();
    this.change(this.points, last);
    if (last) this.hand.leave();
  }
}
