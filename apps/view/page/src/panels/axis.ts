// The frequency axis of the curve editor, and round numbers along it.

export class Axis {
  /** `least`: where a logarithmic axis begins. */
  constructor(
    readonly most: number,
    readonly least: number,
    readonly logarithmic: boolean,
    private readonly left: number,
    private readonly right: number,
  ) {}

  place(frequency: number): number {
    const part = this.logarithmic
      ? Math.log(Math.max(frequency, this.least) / this.least) / Math.log(this.most / this.least)
      : frequency / this.most;
    return this.left + Math.min(Math.max(part, 0), 1) * (this.right - this.left);
  }

  /** The left end stands for 0 on both kinds. */
  frequency(x: number): number {
    const part = Math.min(Math.max((x - this.left) / (this.right - this.left), 0), 1);
    if (part === 0) return 0;
    return this.logarithmic ? this.least * (this.most / this.least) ** part : part * this.most;
  }

  /** Four or so round numbers; on a logarithmic axis powers of ten and, where there are few, 2 and 5 times them. */
  numbers(): number[] {
    if (!this.logarithmic) {
      const step = roundStep(this.most / 4);
      return Array.from({ length: Math.floor(this.most / step) + 1 }, (_, i) => i * step);
    }
    const decades = Math.log10(this.most / this.least);
    const steps = decades < 2 ? [1, 2, 5] : [1];
    const found: number[] = [];
    for (let power = Math.floor(Math.log10(this.least)); 10 ** power <= this.most; power += 1) {
      for (const step of steps) found.push(step * 10 ** power);
    }
    return found.filter((f) => f >= this.least && f <= this.most);
  }
}

function roundStep(step: number): number {
  const power = 10 ** Math.floor(Math.log10(step));
  const lead = step / power;
  return (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10) * power;
}
