// How fine drafts are: as fine as lets pictures follow the hand on the machine that draws them.

export interface DraftSize {
  pixels: number; // at most
  vertices: number; // of the surface, about
}

const sizes: readonly DraftSize[] = [
  { pixels: 100_000, vertices: 4_000 },
  { pixels: 160_000, vertices: 6_000 },
  { pixels: 250_000, vertices: 8_000 },
  { pixels: 400_000, vertices: 12_000 },
];

// Milliseconds from the wish for a picture to the picture; the browser alone waits up to 16 of them for the screen. So far
// apart that a change after the one does not lead to the other.
const slow = 34;
const quick = 22;
// So many drafts in a row are looked at: coming back may wait, for the machine may have other work now and then.
const fewSlow = 12;
const manyQuick = 40;

const median = (numbers: number[]): number => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];

export class DraftPace {
  private at = 2;
  private taken: number[] = [];

  get size(): DraftSize {
    return sizes[this.at];
  }

  /** A draft was drawn, so many milliseconds after it was wanted. */
  drawn(milliseconds: number): void {
    this.taken.push(milliseconds);
    if (this.taken.length > manyQuick) this.taken.shift();
    if (this.taken.length >= fewSlow && median(this.taken.slice(-fewSlow)) > slow) this.go(this.at - 1);
    else if (this.taken.length === manyQuick && median(this.taken) < quick) this.go(this.at + 1);
  }

  private go(to: number): void {
    this.at = Math.min(Math.max(to, 0), sizes.length - 1);
    this.taken = [];
  }
}
