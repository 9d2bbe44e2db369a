// Clicks and markers under the pointer.
import type { Hit, Marker, Vec3, Viewer } from '../viewer';

const still = 5; // px that a click may move
const reach = 14; // px around a marker

/** Calls `act` where the pointer comes up without having moved: the camera turns with the same button. */
export function onClick(start: PointerEvent, act: () => void): void {
  const end = (event: PointerEvent) => {
    if (event.pointerId !== start.pointerId) return;
    window.removeEventListener('pointerup', end, true);
    window.removeEventListener('pointercancel', end, true);
    if (event.type === 'pointerup' && !moved(start, event)) act();
  };
  window.addEventListener('pointerup', end, true);
  window.addEventListener('pointercancel', end, true);
}

export function moved(start: PointerEvent, now: PointerEvent): boolean {
  return Math.hypot(now.clientX - start.clientX, now.clientY - start.clientY) > still;
}

/** Only the main button and the first finger touch; the others are the camera's. */
export function touches(event: PointerEvent): boolean {
  return event.isPrimary && event.button === 0;
}

export function restOf(viewer: Viewer, vertex: number): Vec3 {
  const at = 3 * vertex;
  return [viewer.rest[at], viewer.rest[at + 1], viewer.rest[at + 2]];
}

export function distance(a: Vec3, b: Vec3): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

export function difference(a: Vec3, b: Vec3): Vec3 {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** Of the mesh on average; of points without edges, what one would be. */
export function edgeOf(viewer: Viewer): number {
  return viewer.mesh.mean_edge || viewer.diagonal / 100 || 1;
}

/** Of a pixel, in the plane through `at` that faces the camera. */
export function pixel(viewer: Viewer, at: Vec3, x: number, y: number): number {
  return distance(viewer.onPlane(at, x, y), viewer.onPlane(at, x + 1, y));
}

/** The marker under the pointer, if any. One that lies behind the surface is not meant. */
export function markerUnder(
  viewer: Viewer,
  vertices: Iterable<number>,
  hit: Hit | null,
  event: PointerEvent,
): number | null {
  const far = hit === null ? Infinity : 3 * reach * pixel(viewer, hit.point, event.clientX, event.clientY);
  let found: number | null = null;
  let best = reach;
  for (const vertex of vertices) {
    const at = viewer.screenOf(vertex);
    if (at === null) continue;
    const away = Math.hypot(at[0] - event.clientX, at[1] - event.clientY);
    if (away >= best || (hit !== null && distance(restOf(viewer, vertex), hit.rest) > far)) continue;
    best = away;
    found = vertex;
  }
  return found;
}

export const markerColor = '#2f6fde';
export const selectedColor = '#ee8a1d';
const most = 3000; // markers that are drawn
const labelled = 60; // markers with a label

/** At most so many that the picture stays quick and legible; the selected one is always among them. */
export function bounded(markers: Marker[], selected: number | null): Marker[] {
  const shown = markers.length <= most ? markers : markers.filter((m, i) => i < most || m.vertex === selected);
  if (markers.length <= labelled) return shown;
  return shown.map((marker) => (marker.vertex === selected ? marker : { ...marker, label: '' }));
}

/** The picture as it is without a task. */
export function plain(viewer: Viewer): void {
  viewer.setTool(null);
  viewer.setMarkers([]);
  viewer.setArrow(null);
  viewer.showDomain(null);
  viewer.atRest();
  viewer.setNormals(null);
  viewer.showPlain();
}
