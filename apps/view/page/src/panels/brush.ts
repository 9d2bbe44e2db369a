// Which vertices a brush touches.
import type { Vec3 } from '../viewer';

/** Most vertices that one sample of a brush takes; a request stays far below what the program accepts. */
export const mostTouched = 20_000;
const mostSent = 50_000;

export interface Touched {
  vertices: number[];
  within: number; // the radius; more than vertices where there were too many
}

/** Squared distance to the way from a to b. */
function away(x: number, y: number, z: number, a: Vec3, b: Vec3): number {
  const along = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
  const length = along[0] ** 2 + along[1] ** 2 + along[2] ** 2;
  const dot = (x - a[0]) * along[0] + (y - a[1]) * along[1] + (z - a[2]) * along[2];
  const t = length > 0 ? Math.min(Math.max(dot / length, 0), 1) : 0;
  return (x - a[0] - t * along[0]) ** 2 + (y - a[1] - t * along[1]) ** 2 + (z - a[2] - t * along[2]) ** 2;
}

/** Of the vertices at rest, those no further than `radius` from the way of the pointer, the nearest first where they are
 * too many. */
export function touchedBy(rest: Float32Array, a: Vec3, b: Vec3, radius: number, among?: Iterable<number>): Touched {
  const found: [number, number][] = [];
  const limit = radius * radius;
  const look = (vertex: number) => {
    const d = away(rest[3 * vertex], rest[3 * vertex + 1], rest[3 * vertex + 2], a, b);
    if (d <= limit) found.push([d, vertex]);
  };
  if (among === undefined) for (let vertex = 0; 3 * vertex < rest.length; vertex += 1) look(vertex);
  else for (const vertex of among) look(vertex);
  if (found.length > mostTouched) found.sort((p, q) => p[0] - q[0]);
  return { vertices: found.slice(0, mostTouched).map(([, vertex]) => vertex), within: found.length };
}

/** One stroke: each vertex is sent once. */
export class Stroke {
  private readonly touched = new Set<number>();
  private fresh: number[] = [];
  private last: Vec3 | null = null;

  constructor(
    private readonly rest: Float32Array,
    private readonly radius: number,
    private readonly among?: Iterable<number>,
  ) {}

  get count(): number {
    return this.touched.size;
  }

  /** How many vertices were within the radius, and left out. */
  sample(at: Vec3): number {
    const { vertices, within } = touchedBy(this.rest, this.last ?? at, at, this.radius, this.among);
    this.last = at;
    for (const vertex of vertices) {
      if (this.touched.has(vertex)) continue;
      this.touched.add(vertex);
      this.fresh.push(vertex);
    }
    return within - vertices.length;
  }

  /** The pointer left the surface: where it comes back, nothing is touched in between. */
  lift(): void {
    this.last = null;
  }

  /** What was not sent yet. */
  take(): number[] {
    return this.fresh.splice(0, mostSent);
  }

  get waiting(): boolean {
    return this.fresh.length > 0;
  }
}
