// Moments of a simulation under a scrubber. The newest is shown as it comes, unless the user holds another.
import { shortNumber } from '../colour/ticks';
import { element, icon } from '../dom';
import type { Timeline } from '../viewer';

export interface Moment {
  time: number;
  values: Float32Array;
}

const paths = {
  play: 'M4.5 3v10l8-5z',
  pause: 'M5 3v10M11 3v10',
  back: 'M11.5 3.5 6 8l5.5 4.5zM4.5 3.5v9',
  next: 'M4.5 3.5 10 8l-5.5 4.5zM11.5 3.5v9',
};

const mostBytes = 512 * 2 ** 20;
const playSeconds = 6; // from the first moment to the last
const slowest = 8; // moments a second, at least

export class MomentTimeline implements Timeline {
  readonly element: HTMLElement;
  /** Fields of several moments look alike only on one scale. */
  show: (name: string, moment: Moment) => void = () => {};

  private name = '';
  private moments: Moment[] = [];
  private at = -1;
  private holding = false;
  private timer = 0;
  private keep = 1; // of the moments that come, each keep-th
  private seen = 0;

  private readonly slider = element('input', {
    type: 'range',
    min: 0,
    max: 0,
    step: 1,
    value: 0,
    'aria-label': 'Moment',
    oninput: () => this.hold(Number(this.slider.value)),
  });
  private readonly playButton = element('button', {
    class: 'quiet',
    type: 'button',
    onclick: () => this.toggle(),
  });
  private readonly label = element('output', { class: 'time' });

  constructor() {
    const step = (by: number, path: string, title: string): HTMLElement =>
      element(
        'button',
        { class: 'quiet', type: 'button', title, 'aria-label': title, onclick: () => this.step(by) },
        icon(path),
      );
    this.element = element(
      'div',
      { class: 'timeline', role: 'group', 'aria-label': 'Time', hidden: true },
      step(-1, paths.back, 'Moment before (left arrow)'),
      this.playButton,
      step(1, paths.next, 'Next moment (right arrow)'),
      this.slider,
      this.label,
    );
    this.update();
  }

  get count(): number {
    return this.moments.length;
  }
  get index(): number {
    return this.at;
  }
  get visible(): boolean {
    return !this.element.hidden;
  }

  reset(name: string): void {
    this.stop();
    this.name = name;
    this.moments = [];
    this.at = -1;
    this.holding = false;
    this.keep = 1;
    this.seen = 0;
    this.update();
  }

  /** Many at once, of which the last is shown. */
  addAll(moments: Moment[]): void {
    this.moments = moments;
    this.seen = moments.length;
    this.toggleElement(moments.length > 1);
    this.hold(moments.length - 1);
  }

  add(time: number, values: Float32Array): void {
    // Whatever is dropped, the newest is there: it takes the place of one that was not to be kept.
    const replaces = (this.seen - 1) % this.keep !== 0 && this.moments.length > 1;
    if (replaces) this.moments.pop();
    this.moments.push({ time, values });
    ++this.seen;
    if (this.moments.length > 16 && this.moments.length * values.byteLength > mostBytes) this.thin();
    if (!this.holding) this.go(this.moments.length - 1);
    this.toggleElement(this.moments.length > 1);
    this.update();
  }

  hide(): void {
    this.stop();
    this.toggleElement(false);
  }

  /** A user's choice: what comes later does not change it, unless it is the last. */
  hold(index: number): void {
    this.stop();
    this.holding = index < this.moments.length - 1;
    this.go(index);
  }

  step(by: number): void {
    if (this.visible) this.hold(Math.min(Math.max(this.at + by, 0), this.moments.length - 1));
  }

  toggle(): void {
    if (!this.visible) return;
    if (this.timer) {
      this.stop();
      return;
    }
    if (this.at >= this.moments.length - 1) this.go(0);
    this.holding = true;
    const start = performance.now();
    const from = this.at;
    const speed = Math.max((this.moments.length - 1) / playSeconds, slowest) / 1000;
    const tick = (): void => {
      const index = Math.min(Math.floor(from + (performance.now() - start) * speed), this.moments.length - 1);
      if (index !== this.at) this.go(index);
      if (index < this.moments.length - 1) this.timer = requestAnimationFrame(tick);
      else {
        this.holding = false;
        this.stop();
      }
    };
    this.timer = requestAnimationFrame(tick);
    this.update();
  }

  private stop(): void {
    cancelAnimationFrame(this.timer);
    this.timer = 0;
    this.update();
  }

  private go(index: number): void {
    if (!this.moments[index]) return;
    this.at = index;
    this.show(this.name, this.moments[index]);
    this.update();
  }

  private thin(): void {
    const last = this.moments.length - 1;
    const held = this.moments[this.at];
    this.moments = this.moments.filter((moment, i) => i % 2 === 0 || i === last || moment === held);
    this.at = this.moments.indexOf(held);
    this.keep *= 2;
  }

  private toggleElement(visible: boolean): void {
    if (this.visible === visible) return;
    this.element.hidden = !visible;
  }

  private update(): void {
    const playing = this.timer !== 0;
    const title = playing ? 'Pause (space)' : 'Play (space)';
    this.slider.max = String(Math.max(this.moments.length - 1, 0));
    this.slider.value = String(Math.max(this.at, 0));
    this.playButton.replaceChildren(icon(playing ? paths.pause : paths.play));
    this.playButton.title = title;
    this.playButton.setAttribute('aria-label', title);
    const moment = this.moments[this.at];
    const text = moment ? `t = ${shortNumber(moment.time)}` : '';
    this.label.textContent = text;
    this.slider.setAttribute('aria-valuetext', text);
  }
}
