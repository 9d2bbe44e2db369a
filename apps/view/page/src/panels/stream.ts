// Requests of a drag: the newest at most once an animation frame, and only when the one before was answered or has had its
// time. The program is never given more than it can do, and never an old place after a newer one.
import type { Request } from '../protocol';

export class Stream {
  private make: (() => Request | null) | null = null;
  private frame = 0;
  private sent = 0; // id
  private at = -Infinity;
  private open = true; // the last one was answered

  /** patience: ms after which the next is sent without an answer. */
  constructor(
    private readonly send: (request: Request) => number,
    private readonly patience = 50,
  ) {}

  /** The request is made when it is sent; null: nothing is left to send. */
  offer(make: () => Request | null): void {
    this.make = make;
    if (this.frame === 0) this.tick();
  }

  /** The end of a drag: what waits goes out now. */
  flush(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.go();
  }

  /** What waits is forgotten. */
  drop(): void {
    this.make = null;
  }

  /** A frame came with this id. */
  answered(id: number): void {
    if (id >= this.sent) this.open = true;
  }

  /** Nothing waits, and the last one was answered. */
  get settled(): boolean {
    return this.make === null && this.open;
  }

  private schedule(): void {
    if (this.frame === 0) this.frame = requestAnimationFrame(() => this.tick());
  }

  private tick(): void {
    this.frame = 0;
    if (this.make === null) return;
    // The next frame is waited for either way: it is the soonest time for the next request.
    this.schedule();
    if (this.open || performance.now() - this.at >= this.patience) this.go();
  }

  private go(): void {
    const request = this.make?.() ?? null;
    this.make = null;
    if (request === null) return;
    this.at = performance.now();
    this.open = false;
    this.sent = this.send(request);
  }
}
