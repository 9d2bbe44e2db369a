// Moments of a simulation under a scrubber. The newest is shown as it comes, unless the user holds another.
import { shortNumber } from '../colour/ticks';
import { element, icon } from '../dom';
import type { Moment, Timeline } from '../viewer';

const paths = {
  play: 'M4.5 3v10l8-5z',
  pause: 'M5 3v10M11 3v10',
  back: 'M11.5 3.5 6 8l5.5 4.5zM4.5 3.5v9',
  next: 'M4.5 3.5 10 8l-5.5 4.5zM11.5 3.5v9',
};

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
  private every = 1;

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
  get shown(): Moment | null {
    return this.moments[this.at] ?? null;
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
    this.every = 1;
    this.update();
  }

  /** Many at once, of which the last is shown. */
  addAll(moments: Moment[]): void {
    this.moments = moments;
    this.toggleElement(moments.length > 1);
    this.hold(moments.length - 1);
  }

  add(moment: Moment, every: number): void {
    if (every > this.every) this.thin(every);
    this.moments.push(moment);
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

  /** Where the moment that is held goes, the one before it is shown. */
  private thin(every: number): void {
    const held = this.shown;
    this.every = every;
    this.moments = this.moments.filter(({ step }) => step % every === 0);
    if (held === null) return;
    this.at = this.moments.filter(({ step }) => step <= held.step).length - 1;
    if (this.shown !== held) this.go(this.at);
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
