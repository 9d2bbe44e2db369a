// Controls: each has an element, says what the user chose, and takes what the program says unless the user has it in hand.
import { element } from '../dom';
import { InHand } from './inhand';
import { clamped, parsed, short } from './numbers';

interface NumberOptions {
  label: string;
  test: string;
  value?: number;
  low?: number;
  high?: number;
  whole?: boolean;
  /** Called when the user has entered a number. */
  change?: (value: number) => void;
  /** Enter was pressed; the number has been taken. */
  enter?: () => void;
}

/** A number that is typed. What is no number is put back, what is out of range is brought into it. */
export class NumberField {
  readonly element: HTMLLabelElement;
  readonly input: HTMLInputElement;
  private readonly hand = new InHand();
  private current: number;

  constructor(private readonly options: NumberOptions) {
    this.current = options.value ?? 0;
    this.input = element('input', {
      type: options.whole ? 'number' : 'text',
      inputmode: options.whole ? 'numeric' : 'decimal',
      step: options.whole ? 1 : false,
      autocomplete: 'off',
      'data-test': options.test,
      oninput: () => this.hand.take(),
      onchange: () => this.take(),
      onblur: () => this.take(),
      onkeydown: (event: KeyboardEvent) => {
        if (event.key === 'Enter') {
          this.take();
          options.enter?.();
        } else if (event.key === 'Escape') {
          this.input.value = this.text(this.current);
          this.hand.leave();
        }
      },
    });
    this.element = element('label', { class: 'labelled' }, element('span', {}, options.label), this.input);
    this.limits(options.low ?? -Infinity, options.high ?? Infinity);
    this.input.value = this.text(this.current);
  }

  /** What is being typed counts: a click on the picture may come before the field loses the focus. */
  get value(): number {
    return (this.hand.now ? this.typed() : null) ?? this.current;
  }

  set(value: number): void {
    this.hand.pass(() => {
      this.current = value;
      const text = this.text(value);
      if (this.input.value !== text) this.input.value = text;
    });
  }

  limits(low: number, high: number): void {
    this.options.low = low;
    this.options.high = high;
    if (this.options.whole) {
      if (Number.isFinite(low)) this.input.min = String(low);
      if (Number.isFinite(high)) this.input.max = String(high);
    }
  }

  private text(value: number): string {
    return this.options.whole ? String(value) : short(value, 6);
  }

  private typed(): number | null {
    const value = parsed(this.input.value);
    if (value === null) return null;
    const { low = -Infinity, high = Infinity, whole } = this.options;
    return clamped(whole ? Math.round(value) : value, low, high);
  }

  private take(): void {
    if (!this.hand.now) return; // nothing was typed since
    const typed = this.typed();
    if (typed !== null) {
      this.current = typed;
      this.options.change?.(typed);
    }
    this.input.value = this.text(this.current);
    this.hand.leave();
  }
}

interface SliderOptions {
  label: string;
  test: string;
  low: number;
  high: number;
  /** Equal ways are equal factors. With `zero` the left end is 0. */
  logarithmic?: boolean;
  zero?: boolean;
  /** The number may be typed beyond the slider's ends, within these. */
  least?: number;
  most?: number;
  value: number;
  /** `last`: the user has let go. */
  change: (value: number, last: boolean) => void;
  /** Whether the program has answered. */
  settled?: () => boolean;
}

const ways = 1000; // positions of a slider

/** A number that is dragged or typed. */
export class Slider {
  readonly element: HTMLElement;
  private readonly range: HTMLInputElement;
  private readonly number: NumberField;
  private readonly hand: InHand;
  private current: number;

  constructor(private readonly options: SliderOptions) {
    this.current = options.value;
    this.hand = new InHand(options.settled);
    this.range = element('input', {
      type: 'range',
      min: 0,
      max: ways,
      step: 1,
      'aria-label': options.label,
      'data-test': options.test,
      oninput: () => {
        this.hand.take();
        this.current = this.valueAt(Number(this.range.value));
        this.number.set(this.current);
        this.describe();
        options.change(this.current, false);
      },
      onchange: () => {
        options.change(this.current, true);
        this.hand.leave();
      },
      onblur: () => this.hand.leave(),
    });
    this.number = new NumberField({
      label: options.label,
      test: `${options.test}-number`,
      value: options.value,
      low: options.least ?? -Infinity,
      high: options.most ?? Infinity,
      change: (value) => {
        this.current = value;
        this.place();
        options.change(value, true);
      },
    });
    this.element = element('div', { class: 'slider' }, this.number.element, this.range);
    this.place();
  }

  get value(): number {
    return this.number.value;
  }

  set(value: number): void {
    this.hand.pass(() => {
      this.current = value;
      this.number.set(value);
      this.place();
    });
  }

  /** Other ends; not while it is dragged. */
  ends(low: number, high: number): void {
    if (this.hand.now || (low === this.options.low && high === this.options.high)) return;
    this.options.low = low;
    this.options.high = high;
    this.place();
  }

  private valueAt(position: number): number {
    const { low, high, logarithmic, zero } = this.options;
    if (!logarithmic) return rounded(low + ((high - low) * position) / ways, (high - low) / ways);
    if (zero && position === 0) return 0;
    const value = low * (high / low) ** (position / ways);
    return Number(value.toPrecision(3));
  }

  private positionOf(value: number): number {
    const { low, high, logarithmic } = this.options;
    const part = logarithmic
      ? Math.log(Math.max(value, low) / low) / Math.log(high / low)
      : (value - low) / (high - low);
    const position = clamped(Math.round(part * ways), 0, ways);
    // 0 alone is at the left end where it has one.
    return this.options.zero && value > 0 ? Math.max(position, 1) : position;
  }

  private place(): void {
    this.range.value = String(this.positionOf(this.current));
    this.describe();
  }

  private describe(): void {
    this.range.setAttribute('aria-valuetext', short(this.current));
    this.range.style.setProperty('--part', `${Number(this.range.value) / (ways / 100)}%`);
  }
}

/** To as many digits as a step of the slider can tell apart. */
function rounded(value: number, step: number): number {
  const digits = clamped(1 - Math.floor(Math.log10(step)), 0, 12);
  return Number(value.toFixed(digits));
}

interface ChoiceOptions<Value extends string> {
  label: string;
  test: string;
  values: [Value, string][]; // and what to call it
  value: Value;
  change: (value: Value) => void;
}

let groups = 0;

/** One of a few, beside each other: radio buttons, so that arrow keys go through them. */
export class Choice<Value extends string> {
  readonly element: HTMLElement;
  private readonly inputs = new Map<Value, HTMLInputElement>();

  constructor(options: ChoiceOptions<Value>) {
    const name = `choice-${(groups += 1)}`;
    const labels = options.values.map(([value, text]) => {
      const input = element('input', {
        type: 'radio',
        name,
        value,
        checked: value === options.value,
        'data-test': `${options.test}-${value}`,
        onchange: () => options.change(value),
      });
      this.inputs.set(value, input);
      return element('label', {}, input, element('span', {}, text));
    });
    this.element = element(
      'div',
      { class: 'choice', role: 'radiogroup', 'aria-label': options.label, 'data-test': options.test },
      ...labels,
    );
  }

  get value(): Value {
    for (const [value, input] of this.inputs) if (input.checked) return value;
    throw new Error('a choice without a value');
  }

  set(value: Value): void {
    const input = this.inputs.get(value);
    if (input !== undefined) input.checked = true;
  }

  /** What cannot be chosen is not there. */
  offer(value: Value, offered: boolean): void {
    const label = this.inputs.get(value)?.parentElement;
    if (label) label.hidden = !offered;
  }
}

/** On or off. */
export class Check {
  readonly element: HTMLLabelElement;
  readonly input: HTMLInputElement;

  constructor(label: string, test: string, on: boolean, change: (on: boolean) => void) {
    this.input = element('input', {
      type: 'checkbox',
      checked: on,
      'data-test': test,
      onchange: () => change(this.input.checked),
    });
    this.element = element('label', { class: 'check' }, this.input, element('span', {}, label));
  }

  get on(): boolean {
    return this.input.checked;
  }

  set(on: boolean): void {
    this.input.checked = on;
  }
}
