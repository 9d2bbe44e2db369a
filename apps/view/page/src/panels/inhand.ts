// Keeps what the program says from a control while the user has it in hand, and until its last request was answered: the
// answers to those before are still on their way and would make it jump back.
const moment = 300; // ms, at least
const longest = 3000; // ms, whether there was an answer or not

export class InHand {
  private held = false;
  private timer: number | undefined;
  private waiting: (() => void) | null = null;

  /** settled: whether the program has answered. */
  constructor(private readonly settled: () => boolean = () => true) {}

  get now(): boolean {
    return this.held;
  }

  /** In hand, or just let go. */
  get busy(): boolean {
    return this.held || this.timer !== undefined;
  }

  take(): void {
    this.held = true;
    window.clearTimeout(this.timer);
    this.timer = undefined;
  }

  leave(): void {
    if (!this.held) return;
    this.held = false;
    this.wait(performance.now());
  }

  /** Does it now, or, of several, the last one when the control is free. */
  pass(apply: () => void): void {
    if (this.busy) this.waiting = apply;
    else apply();
  }

  private wait(left: number): void {
    this.timer = window.setTimeout(() => {
      if (!this.settled() && performance.now() - left < longest) {
        this.wait(left);
        return;
      }
      this.timer = undefined;
      const apply = this.waiting;
      this.waiting = null;
      apply?.();
    }, moment);
  }
}
