// Going through the eigenfunctions.
import { element } from '../dom';
import { Check } from './controls';
import { InHand } from './inhand';
import { clamped, short } from './numbers';
import { button, group, row, write } from './parts';

export class Modes {
  readonly element: HTMLElement;
  private readonly check: Check;
  private readonly range: HTMLInputElement;
  private readonly words: HTMLElement;
  private readonly hand: InHand;
  private frequencies: ArrayLike<number> = [];
  private edge = 0;

  /** show: null hides. `last`: the user has let go. settled: whether the program has answered. */
  constructor(
    private readonly show: (k: number | null, last: boolean) => void,
    settled: () => boolean,
  ) {
    this.hand = new InHand(settled);
    this.check = new Check('Show one', 'harmonics-show', false, (on) => show(on ? this.k : null, true));
    this.range = element('input', {
      type: 'range',
      min: 0,
      max: 0,
      step: 1,
      value: 0,
      'aria-label': 'Eigenfunction',
      'data-test': 'harmonics-k',
      oninput: () => {
        this.hand.take();
        this.choose(this.k, false);
      },
      onchange: () => {
        this.choose(this.k, true);
        this.hand.leave();
      },
      onblur: () => this.hand.leave(),
    });
    const previous = button('‹', 'harmonics-previous', () => this.step(-1));
    previous.setAttribute('aria-label', 'Previous eigenfunction');
    const next = button('›', 'harmonics-next', () => this.step(1));
    next.setAttribute('aria-label', 'Next eigenfunction');
    this.words = element('p', { class: 'hint', 'data-test': 'harmonics-frequency' });
    this.element = group('Eigenfunctions', this.check.element, row(previous, this.range, next), this.words);
    this.element.hidden = true;
  }

  get k(): number {
    return Number(this.range.value);
  }

  frequency(k: number): number | null {
    return this.frequencies[k] ?? null;
  }

  setFrequencies(frequencies: ArrayLike<number>, edge: number): void {
    this.frequencies = frequencies;
    this.edge = edge;
    this.describe();
  }

  update(computed: number, shown: number | null): void {
    this.element.hidden = computed === 0;
    this.range.max = String(Math.max(computed - 1, 0));
    this.hand.pass(() => {
      this.check.set(shown !== null);
      if (shown !== null) this.range.value = String(shown);
      this.describe();
    });
  }

  private step(by: number): void {
    const k = clamped(this.k + (this.check.on ? by : 0), 0, Number(this.range.max));
    this.range.value = String(k);
    this.hand.take();
    this.choose(k, true);
    this.hand.leave();
  }

  private choose(k: number, last: boolean): void {
    this.check.set(true);
    this.describe();
    this.show(k, last);
  }

  private describe(): void {
    const frequency = this.frequency(this.k);
    const number = `No. ${this.k} of 0 to ${this.range.max}`;
    this.range.setAttribute('aria-valuetext', number);
    if (frequency === null) write(this.words, `${number}.`);
    else if (!(frequency > 0)) write(this.words, `${number}: frequency 0, constant on each piece.`);
    else {
      const wave = (2 * Math.PI) / frequency;
      write(
        this.words,
        `${number}: frequency ${short(frequency)}, wavelength ${short(wave, 3)}, which is ${short(wave / this.edge, 3)} edges.`,
      );
    }
  }
}
