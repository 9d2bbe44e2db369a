// Which way a surface faces at a vertex that may be out of sight.
import type { Vec3, Viewer } from '../viewer';
import { difference, distance, edgeOf, restOf } from './touch';

export function normalAt(viewer: Viewer, vertex: number): Vec3 {
  const screen = viewer.screenOf(vertex);
  const hit = screen === null ? null : viewer.pick(...screen);
  const at = restOf(viewer, vertex);
  if (hit !== null && distance(hit.rest, at) < 2 * edgeOf(viewer)) return hit.normal;
  return across(neighbours(viewer.rest, at, 3 * edgeOf(viewer)), at, centre(viewer.rest));
}

function centre(points: Float32Array): Vec3 {
  const sum: Vec3 = [0, 0, 0];
  for (let i = 0; i < points.length; i += 1) sum[i % 3] += points[i];
  return sum.map((x) => (3 * x) / points.length) as Vec3;
}

function neighbours(rest: Float32Array, at: Vec3, radius: number): Vec3[] {
  const found: Vec3[] = [];
  for (let i = 0; i < rest.length; i += 3) {
    const to: Vec3 = [rest[i] - at[0], rest[i + 1] - at[1], rest[i + 2] - at[2]];
    if (Math.hypot(...to) <= radius) found.push(to);
  }
  return found;
}

/** The direction in which the neighbours spread least, away from the middle of the mesh. */
function across(spread: Vec3[], at: Vec3, middle: Vec3): Vec3 {
  const out = difference(at, middle);
  const mean = spread.reduce<Vec3>((sum, v) => [sum[0] + v[0], sum[1] + v[1], sum[2] + v[2]], [0, 0, 0]);
  const rows: Vec3[] = [
    [0, 0, 0],
    [0, 0, 0],
    [0, 0, 0],
  ];
  for (const v of spread) {
    const d = v.map((x, i) => x - mean[i] / spread.length);
    for (let i = 0; i < 3; i += 1) for (let j = 0; j < 3; j += 1) rows[i][j] += d[i] * d[j];
  }
  // Powers of (trace I - C) turn any vector to the eigenvector of C's least eigenvalue.
  const trace = rows[0][0] + rows[1][1] + rows[2][2];
  let normal: Vec3 = Math.hypot(...out) > 0 ? out : [0, 0, 1];
  for (let power = 0; power < 60 && trace > 0; power += 1) {
    const next = normal.map((x, i) => trace * x - dot(rows[i], normal)) as Vec3;
    const length = Math.hypot(...next);
    if (!(length > 0)) break;
    normal = next.map((x) => x / length) as Vec3;
  }
  const length = Math.hypot(...normal);
  const sign = dot(normal, out) < 0 ? -1 : 1;
  return normal.map((x) => (sign * x) / length) as Vec3;
}

export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
