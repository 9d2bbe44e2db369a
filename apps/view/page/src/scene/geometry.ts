// Loops over the numbers of a mesh. Plain typed arrays: these run for each frame.

/** Which cells meet at each vertex: those of v are list[start[v]] .. list[start[v + 1] - 1]. */
export interface Adjacency {
  start: Uint32Array;
  list: Uint32Array;
}

/** `corners`: of a cell, 3 of triangles and 2 of segments. */
export function adjacencyOf(cells: Uint32Array, corners: number, vertices: number): Adjacency {
  const start = new Uint32Array(vertices + 1);
  for (let i = 0; i < cells.length; ++i) ++start[cells[i] + 1];
  for (let v = 0; v < vertices; ++v) start[v + 1] += start[v];
  const next = start.slice(0, vertices);
  const list = new Uint32Array(cells.length);
  for (let i = 0; i < cells.length; ++i) list[next[cells[i]]++] = (i / corners) | 0;
  return { start, list };
}

/** Normals of the vertices: those of the triangles around, weighted by area. Zero where there is none. */
export function computeNormals(positions: Float32Array, triangles: Uint32Array, normals: Float32Array): void {
  normals.fill(0);
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i];
    const b = 3 * triangles[i + 1];
    const c = 3 * triangles[i + 2];
    const ax = positions[a];
    const ay = positions[a + 1];
    const az = positions[a + 2];
    const ux = positions[b] - ax;
    const uy = positions[b + 1] - ay;
    const uz = positions[b + 2] - az;
    const vx = positions[c] - ax;
    const vy = positions[c + 1] - ay;
    const vz = positions[c + 2] - az;
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    normals[a] += nx;
    normals[a + 1] += ny;
    normals[a + 2] += nz;
    normals[b] += nx;
    normals[b + 1] += ny;
    normals[b + 2] += nz;
    normals[c] += nx;
    normals[c + 1] += ny;
    normals[c + 2] += nz;
  }
  for (let i = 0; i < normals.length; i += 3) normalise(normals, i);
}

function normalise(vectors: Float32Array, i: number): void {
  const x = vectors[i];
  const y = vectors[i + 1];
  const z = vectors[i + 2];
  const length = Math.sqrt(x * x + y * y + z * z);
  const inverse = length > 0 ? 1 / length : 0;
  vectors[i] = x * inverse;
  vectors[i + 1] = y * inverse;
  vectors[i + 2] = z * inverse;
}

/** The same for some vertices only. */
export function computeNormalsOf(
  vertices: ArrayLike<number>,
  count: number,
  positions: Float32Array,
  triangles: Uint32Array,
  adjacency: Adjacency,
  normals: Float32Array,
): void {
  const { start, list } = adjacency;
  for (let k = 0; k < count; ++k) {
    const v = vertices[k];
    let x = 0;
    let y = 0;
    let z = 0;
    for (let j = start[v]; j < start[v + 1]; ++j) {
      const i = 3 * list[j];
      const a = 3 * triangles[i];
      const b = 3 * triangles[i + 1];
      const c = 3 * triangles[i + 2];
      const ux = positions[b] - positions[a];
      const uy = positions[b + 1] - positions[a + 1];
      const uz = positions[b + 2] - positions[a + 2];
      const vx = positions[c] - positions[a];
      const vy = positions[c + 1] - positions[a + 1];
      const vz = positions[c + 2] - positions[a + 2];
      x += uy * vz - uz * vy;
      y += uz * vx - ux * vz;
      z += ux * vy - uy * vx;
    }
    normals[3 * v] = x;
    normals[3 * v + 1] = y;
    normals[3 * v + 2] = z;
    normalise(normals, 3 * v);
  }
}

/** Each edge of the triangles once: 2 vertex numbers an edge, the smaller first. */
export function edgesOf(triangles: Uint32Array, vertices: number): Uint32Array {
  // Edges are sorted into buckets by their lower end; a bucket is short, so repeats are found by looking through it.
  const start = new Uint32Array(vertices + 1);
  const corner = [1, 2, 0];
  for (let i = 0; i < triangles.length; ++i) {
    const j = i - (i % 3) + corner[i % 3];
    ++start[Math.min(triangles[i], triangles[j]) + 1];
  }
  for (let v = 0; v < vertices; ++v) start[v + 1] += start[v];
  const filled = start.slice(0, vertices);
  const upper = new Uint32Array(triangles.length);
  let count = 0;
  for (let i = 0; i < triangles.length; ++i) {
    const p = triangles[i];
    const q = triangles[i - (i % 3) + corner[i % 3]];
    const low = p < q ? p : q;
    const high = p < q ? q : p;
    if (low === high) continue;
    let at = start[low];
    while (at < filled[low] && upper[at] !== high) ++at;
    if (at < filled[low]) continue;
    upper[filled[low]++] = high;
    ++count;
  }
  const edges = new Uint32Array(2 * count);
  let k = 0;
  for (let v = 0; v < vertices; ++v) {
    for (let at = start[v]; at < filled[v]; ++at) {
      edges[k++] = v;
      edges[k++] = upper[at];
    }
  }
  return edges;
}

export interface Box {
  low: [number, number, number];
  high: [number, number, number];
}

/** The bounding box of finite positions. */
export function boxOf(positions: Float32Array): Box {
  const low: Box['low'] = [Infinity, Infinity, Infinity];
  const high: Box['high'] = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < 3; ++k) {
    let least = Infinity;
    let most = -Infinity;
    for (let i = k; i < positions.length; i += 3) {
      const x = positions[i];
      if (x < least) least = x;
      if (x > most) most = x;
    }
    low[k] = least;
    high[k] = most;
  }
  return low[0] <= high[0] ? { low, high } : { low: [0, 0, 0], high: [0, 0, 0] };
}

/** About `wanted` vertices spread evenly over the mesh: of each cell of a grid the one nearest to the cell's middle. */
export function evenSubset(positions: Float32Array, wanted: number): { vertices: Uint32Array; spacing: number } {
  const { low, high } = boxOf(positions);
  const size = [0, 1, 2].map((k) => high[k] - low[k]);
  const longest = Math.max(...size) || 1;
  const vertices = positions.length / 3;
  // A surface of the box's size meets about as many cells as the sides of the box have.
  const area = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
  const spacing = Math.max(Math.sqrt((0.5 * area || longest * longest) / Math.max(wanted, 1)), longest / 512);
  const cells = size.map((s) => Math.floor(s / spacing) + 1);
  const best = new Map<number, number>();
  const distance = new Map<number, number>();
  for (let v = 0; v < vertices; ++v) {
    let cell = 0;
    let away = 0;
    for (let k = 0; k < 3; ++k) {
      const p = (positions[3 * v + k] - low[k]) / spacing;
      const c = Math.floor(p);
      cell = cell * cells[k] + c;
      away += (p - c - 0.5) ** 2;
    }
    const known = distance.get(cell);
    if (known === undefined || away < known) {
      distance.set(cell, away);
      best.set(cell, v);
    }
  }
  return { vertices: Uint32Array.from(best.values()), spacing };
}

/** Which side of its triangles a closed surface turns outward: 1 their front, -1 their back, in all of its components; 0
 * where neighbours disagree or components do. Each edge must have two triangles. */
export function outwardSide(positions: Float32Array, triangles: Uint32Array): 1 | -1 | 0 {
  if (triangles.length === 0) return 0;
  // Neighbours agree if each edge is gone through once either way: then the sum of a hash of it, there plus, back minus,
  // is zero.
  let balance = 0;
  const parent = new Uint32Array(positions.length / 3).map((_, v) => v);
  const root = (v: number): number => {
    while (parent[v] !== v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (let i = 0; i < triangles.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const p = triangles[i + k];
      const q = triangles[i + ((k + 1) % 3)];
      const low = p < q ? p : q;
      const high = p < q ? q : p;
      const mixed = Math.imul(Math.imul(low + 1, 0x9e3779b1) ^ (high + 0x7f4a7c15), 0x85ebca6b);
      const hash = mixed ^ (mixed >>> 15);
      balance = (p < q ? balance + hash : balance - hash) | 0;
      const a = root(p);
      const b = root(q);
      if (a !== b) parent[a] = b;
    }
  }
  if (balance !== 0) return 0;
  const { low } = boxOf(positions);
  const volume = new Map<number, number>();
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i];
    const b = 3 * triangles[i + 1];
    const c = 3 * triangles[i + 2];
    const x = (v: number, k: number): number => positions[v + k] - low[k];
    const six =
      x(a, 0) * (x(b, 1) * x(c, 2) - x(b, 2) * x(c, 1)) +
      x(a, 1) * (x(b, 2) * x(c, 0) - x(b, 0) * x(c, 2)) +
      x(a, 2) * (x(b, 0) * x(c, 1) - x(b, 1) * x(c, 0));
    const component = root(triangles[i]);
    volume.set(component, (volume.get(component) ?? 0) + six);
  }
  const signs = [...volume.values()].map(Math.sign);
  return signs.every((sign) => sign === 1) ? 1 : signs.every((sign) => sign === -1) ? -1 : 0;
}

/** The same surface with fewer triangles, their corners still vertices of the mesh: of each cell of a grid that has about
 * `wanted` cells on the surface one vertex stands for all. */
export function coarser(positions: Float32Array, triangles: Uint32Array, wanted: number): Uint32Array {
  const { low, high } = boxOf(positions);
  const spacing = Math.sqrt((1.7 * areaOf(positions, triangles)) / Math.max(wanted, 1));
  const longest = Math.max(...low.map((x, k) => high[k] - x));
  if (!(spacing > longest / 2000)) return triangles;
  const [nx, ny] = low.map((x, k) => Math.floor((high[k] - x) / spacing) + 1);
  const vertices = positions.length / 3;
  const standIn = new Uint32Array(vertices);
  const first = new Map<number, number>();
  const away = new Float32Array(vertices); // of a stand-in from the middle of its cell
  const cells = new Float64Array(vertices);
  for (let v = 0; v < vertices; ++v) {
    let distance = 0;
    let cell = 0;
    for (let k = 2; k >= 0; --k) {
      const p = (positions[3 * v + k] - low[k]) / spacing;
      const c = Math.floor(p);
      cell = cell * (k === 1 ? ny : k === 0 ? nx : 1) + c;
      distance += (p - c - 0.5) ** 2;
    }
    cells[v] = cell;
    away[v] = distance;
    const known = first.get(cell);
    if (known === undefined || distance < away[known]) first.set(cell, v);
  }
  for (let v = 0; v < vertices; ++v) standIn[v] = first.get(cells[v]) ?? v;
  const kept = new Uint32Array(triangles.length);
  let count = 0;
  for (let i = 0; i < triangles.length; i += 3) {
    const a = standIn[triangles[i]];
    const b = standIn[triangles[i + 1]];
    const c = standIn[triangles[i + 2]];
    if (a === b || b === c || c === a) continue;
    kept[count] = a;
    kept[count + 1] = b;
    kept[count + 2] = c;
    count += 3;
  }
  return kept.slice(0, count);
}

function areaOf(positions: Float32Array, triangles: Uint32Array): number {
  let twice = 0;
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i];
    const b = 3 * triangles[i + 1];
    const c = 3 * triangles[i + 2];
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    twice += Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
  }
  return twice / 2;
}
