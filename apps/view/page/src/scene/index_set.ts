// Some of the numbers 0 .. size - 1, each once: quicker than a Set where there are thousands for each frame.
export class IndexSet {
  private readonly marks: Uint8Array;
  private readonly list: Uint32Array;
  private count = 0;

  constructor(size: number) {
    this.marks = new Uint8Array(size);
    this.list = new Uint32Array(size);
  }

  get size(): number {
    return this.count;
  }
  /** In the order in which they came; valid until the next change. */
  get values(): Uint32Array {
    return this.list.subarray(0, this.count);
  }
  get sorted(): Uint32Array {
    return this.values.slice().sort();
  }

  add(i: number): void {
    if (this.marks[i] === 1) return;
    this.marks[i] = 1;
    this.list[this.count++] = i;
  }
  clear(): void {
    for (const i of this.values) this.marks[i] = 0;
    this.count = 0;
  }
}
