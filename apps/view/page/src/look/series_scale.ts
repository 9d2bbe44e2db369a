// One colour scale for all moments of a time series. Near a point source or an impulse few values are far above all others: the
// scale ends at the 99th percentile of the sizes, as that of the program's pictures does.
const part = 0.99;
const most = 1000; // values of a moment that are looked at

export class SeriesScale {
  private readonly sizes: number[] = [];
  private lowest = 0;
  private ends: [number, number] | null = null;
  private counted = 0; // sizes that `ends` are of

  add(values: ArrayLike<number>): void {
    const stride = Math.max(Math.floor(values.length / most), 1);
    for (let i = 0; i < values.length; i += stride) {
      if (!Number.isFinite(values[i])) continue;
      this.sizes.push(Math.abs(values[i]));
      this.lowest = Math.min(this.lowest, values[i]);
    }
  }

  /** Null while all is zero. */
  get range(): [number, number] | null {
    // Sorted anew when there is a tenth more.
    if (this.sizes.length > 1.1 * this.counted) {
      this.counted = this.sizes.length;
      const sorted = Float64Array.from(this.sizes).sort();
      const end = sorted[Math.floor(part * (sorted.length - 1))];
      this.ends = end > 0 ? [this.lowest < 0 ? -end : 0, end] : null;
    }
    return this.ends;
  }
}
