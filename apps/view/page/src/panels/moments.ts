// The moments of a run, kept while another task is looked at.
const most = 256 * 1024 * 1024; // bytes

export interface Moment {
  time: number;
  values: Float32Array;
}

export class Moments {
  private kept: Moment[] = [];
  private bytes = 0;
  private stride = 1;
  private seen = 0;

  get all(): readonly Moment[] {
    return this.kept;
  }

  clear(): void {
    this.kept = [];
    this.bytes = 0;
    this.stride = 1;
    this.seen = 0;
  }

  /** Beyond the limit every other one is forgotten, and of those to come as well; the newest is always there. */
  add(moment: Moment): void {
    const onGrid = (this.seen - 1) % this.stride === 0;
    if (this.kept.length > 1 && !onGrid) this.bytes -= this.kept.pop()!.values.byteLength;
    this.kept.push(moment);
    this.bytes += moment.values.byteLength;
    this.seen += 1;
    if (this.bytes <= most || this.kept.length < 4) return;
    this.kept = this.kept.filter((_, i) => i % 2 === 0 || i === this.kept.length - 1);
    this.stride *= 2;
    this.bytes = this.kept.reduce((sum, m) => sum + m.values.byteLength, 0);
  }
}
