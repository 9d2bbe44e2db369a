// Which vertices a brush touches.
import type { Hit, Vec3, Viewer } from '../viewer';

/** Most vertices that one sample of a brush takes; a request stays far below what the program accepts. */
export const mostTouched = 20_000;
const mostSent = 50_000;

/** Squared distance to the way from a to b. */
function away(x: number, y: number, z: number, a: Vec3, b: Vec3): number {
  const along = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
  const length = along[0] ** 2 + along[1] ** 2 + along[2] ** 2;
  const dot = (x - a[0]) * along[0] + (y - a[1]) * along[1] + (z - a[2]) * along[2];
  const t = length > 0 ? Math.min(Math.max(dot / length, 0), 1) : 0;
  return (x - a[0] - t * along[0]) ** 2 + (y - a[1] - t * along[1]) ** 2 + (z - a[2] - t * along[2]) ** 2;
}

/** Of too many those at the least distances. */
function nearest(vertices: number[], distances: number[]): number[] {
  if (vertices.length <= mostTouched) return vertices;
  const farthest = Float64Array.from(distances).sort()[mostTouched - 1];
  return vertices.filter((_, i) => distances[i] <= farthest).slice(0, mostTouched);
}

/** One stroke: each vertex is sent once. A thin wall has two sides, of which the brush touches the one that the pointer is
 * on: what edges connect to it, within the radius all the way. */
export class Stroke {
  private readonly touched = new Set<number>();
  private fresh: number[] = [];
  private last: Hit | null = null;
  private samples = 0;
  private readonly seen: Uint32Array; // of each vertex the last sample that has come upon it

  /** among: only these are touched. */
  constructor(
    private readonly viewer: Viewer,
    private readonly radius: number,
    private readonly among?: ReadonlySet<number>,
  ) {
    this.seen = new Uint32Array(viewer.rest.length / 3);
  }

  get count(): number {
    return this.touched.size;
  }

  /** How many vertices were within the radius, and left out. */
  sample(hit: Hit): number {
    const { vertices, distances } = this.reached(this.last ?? hit, hit);
    this.last = hit;
    for (const vertex of nearest(vertices, distances)) {
      if (this.touched.has(vertex)) continue;
      this.touched.add(vertex);
      this.fresh.push(vertex);
    }
    return Math.max(vertices.length - mostTouched, 0);
  }

  /** Vertices near the way of the pointer at rest, and their squared distances to it. */
  private reached(a: Hit, b: Hit): { vertices: number[]; distances: number[] } {
    const { viewer, seen, among } = this;
    const { rest } = viewer;
    const vertices: number[] = [];
    const distances: number[] = [];
    const open: number[] = [];
    const limit = this.radius * this.radius;
    const sample = ++this.samples;
    const look = (vertex: number) => {
      if (seen[vertex] === sample) return;
      seen[vertex] = sample;
      const d = away(rest[3 * vertex], rest[3 * vertex + 1], rest[3 * vertex + 2], a.rest, b.rest);
      if (d > limit) return;
      open.push(vertex);
      if (among && !among.has(vertex)) return;
      vertices.push(vertex);
      distances.push(d);
    };
    // Points have no edges: all that are near.
    const points = viewer.mesh.cells === 'points';
    const start = points ? seen.keys() : [...a.corners, ...b.corners];
    for (const vertex of start) {
      look(vertex);
      // Of a triangle larger than the brush no corner may be within, and yet one behind its edge.
      viewer.neighbours(vertex, look);
    }
    for (let vertex = open.pop(); vertex !== undefined; vertex = open.pop()) viewer.neighbours(vertex, look);
    return { vertices, distances };
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
