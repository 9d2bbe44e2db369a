// What holds a point of the surface: where it is at rest, how far it is moved sideways, and how deep it is pressed.
import type { Request } from '../protocol';
import type { Vec3 } from '../viewer';
import { Stream } from './stream';

const press = 120; // ms in which a press reaches its depth: a jump would ring through the mesh

interface Hold {
  rest: Vec3;
  normal: Vec3;
  sideways: Vec3;
  depth: number; // against the normal
  from: number; // depth that the press starts with
  to: number; // depth that the press goes to
  since: number;
}

export class Finger {
  private hold: Hold | null = null;
  private readonly stream: Stream;

  constructor(private readonly send: (request: Request) => number) {
    // Each animation frame: the program steps a thousand times a second, whether it answers each hold or not.
    this.stream = new Stream(send, 0);
  }

  get holds(): boolean {
    return this.hold !== null;
  }

  press(rest: Vec3, normal: Vec3, sideways: Vec3, depth: number): void {
    this.hold = { rest, normal, sideways, depth: 0, from: 0, to: depth, since: performance.now() };
    this.follow();
  }

  slide(way: Vec3): void {
    if (this.hold === null) return;
    this.hold.sideways = this.hold.sideways.map((x, i) => x + way[i]) as Vec3;
    this.follow();
  }

  /** Deeper by so much, at once. */
  deepen(by: number): void {
    if (this.hold === null) return;
    this.hold.from += by;
    this.hold.to += by;
    this.follow();
  }

  /** To this depth, in a moment. */
  reach(depth: number): void {
    if (this.hold === null) return;
    this.hold = { ...this.hold, from: this.hold.depth, to: depth, since: performance.now() };
    this.follow();
  }

  release(): void {
    if (this.hold === null) return;
    this.stream.flush();
    this.hold = null;
    this.send({ do: 'poke.release' });
  }

  private follow(): void {
    this.stream.offer(() => {
      const hold = this.hold;
      if (hold === null) return null;
      const part = Math.min((performance.now() - hold.since) / press, 1);
      hold.depth = hold.from + part * (hold.to - hold.from);
      if (part < 1) queueMicrotask(() => this.follow());
      const displacement = hold.sideways.map((x, i) => x - hold.depth * hold.normal[i]) as Vec3;
      return { do: 'poke.hold', point: hold.rest, displacement };
    });
  }
}
