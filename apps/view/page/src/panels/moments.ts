// The moments of a run, kept while another task is looked at.
import type { Moment } from '../viewer';

export class Moments {
  private kept: Moment[] = [];
  private every = 1;

  get all(): readonly Moment[] {
    return this.kept;
  }

  clear(): void {
    this.kept = [];
    this.every = 1;
  }

  /** `every`: what the program keeps, which bounds their memory. Of others it could save no file. */
  add(moment: Moment, every: number): void {
    if (every > this.every) this.kept = this.kept.filter(({ step }) => step % every === 0);
    this.every = every;
    this.kept.push(moment);
  }
}
