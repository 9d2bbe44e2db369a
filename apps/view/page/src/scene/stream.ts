// A vertex attribute that changes often. Where few vertices have changed, only runs of them go to the graphics card.
import * as three from 'three';

const gap = 32; // unchanged vertices that are cheaper to send along than to start anew
const mostRuns = 64;

export class StreamedAttribute extends three.BufferAttribute {
  private whole = false;

  constructor(
    readonly numbers: Float32Array,
    columns: number,
  ) {
    super(numbers, columns);
    this.setUsage(three.DynamicDrawUsage);
    this.onUpload(() => (this.whole = false));
  }

  changed(): void {
    this.whole = true;
    this.clearUpdateRanges();
    this.needsUpdate = true;
  }

  /** `vertices` ascend. */
  changedAt(vertices: Uint32Array): void {
    if (vertices.length === 0) return;
    this.needsUpdate = true;
    if (this.whole) return;
    const runs: [number, number][] = [];
    for (const v of vertices) {
      const last = runs[runs.length - 1];
      if (last && v - last[1] <= gap) last[1] = v;
      else if (runs.push([v, v]) > mostRuns) return this.changed();
    }
    for (const [first, last] of runs) this.addUpdateRange(first * this.itemSize, (last - first + 1) * this.itemSize);
  }
}
