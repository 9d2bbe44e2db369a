// From where the mesh is looked at: the views of apps/picture/camera.hpp, and how far away a view must be.
import { Vector3 } from 'three';

export type Axis = 'x' | 'y' | 'z';
export const viewNames = ['front', 'back', 'left', 'right', 'top', 'bottom', 'iso'] as const;
export type ViewName = (typeof viewNames)[number];

/** Unit vectors in the mesh's coordinates: right and up in the picture, and toward whoever looks. */
export interface Frame {
  right: Vector3;
  up: Vector3;
  toward: Vector3;
}

/** With y up, front looks from +z and right from +x; with z up, front looks from -y; with x up, front looks from +z. */
function frontWith(up: Axis): Frame {
  const x = new Vector3(1, 0, 0);
  const y = new Vector3(0, 1, 0);
  const z = new Vector3(0, 0, 1);
  if (up === 'z') return { right: x, up: z, toward: y.negate() };
  if (up === 'x') return { right: y.negate(), up: x, toward: z };
  return { right: x, up: y, toward: z };
}

export const upOf = (up: Axis): Vector3 => frontWith(up).up;

function directionOf(view: string): Vector3 | null {
  const numbers = view.split(',').map(Number);
  const direction = new Vector3(...numbers);
  return numbers.length === 3 && numbers.every(Number.isFinite) && direction.length() > 0
    ? direction.normalize()
    : null;
}

/** view: a ViewName, or the direction from which to look as "x,y,z"; anything else is as front. */
export function frameOf(view: string, up: Axis): Frame {
  const front = frontWith(up);
  const turned = (right: Vector3, upward: Vector3, toward: Vector3): Frame => ({
    right: right.clone(),
    up: upward.clone(),
    toward: toward.clone(),
  });
  const minus = (v: Vector3): Vector3 => v.clone().negate();
  if (view === 'back') return turned(minus(front.right), front.up, minus(front.toward));
  if (view === 'right') return turned(minus(front.toward), front.up, front.right);
  if (view === 'left') return turned(front.toward, front.up, minus(front.right));
  if (view === 'top') return turned(front.right, minus(front.toward), front.up);
  if (view === 'bottom') return turned(front.right, front.toward, minus(front.up));
  const toward =
    view === 'iso'
      ? new Vector3().add(front.right).add(front.up).add(front.toward).normalize()
      : view === 'front'
        ? null
        : directionOf(view);
  return toward ? lookingFrom(toward, front) : front;
}

/** The frame that looks from a direction, with as much of `front.up` up as there can be. */
function lookingFrom(toward: Vector3, front: Frame): Frame {
  const right = front.up.clone().cross(toward);
  // Straight from above or below nothing points up; be as top and bottom are.
  if (right.length() < 1e-9) right.copy(front.right);
  right.normalize();
  return { right, up: toward.clone().cross(right), toward };
}

/** Where the camera must be, and what it looks at, so that all positions are just seen. `tangents`: of half the angles
 * of view across and up that may be used. Exact: each side of the view touches a vertex, or its opposite does. */
export function fitted(
  positions: Float32Array,
  frame: Frame,
  tangents: [number, number],
): { eye: Vector3; target: Vector3 } {
  const { right, up, toward } = frame;
  const [tx, ty] = tangents;
  // A vertex (x, y, z) in this frame is inside of the right side of a camera at (ex, ey, ez) if x - ex <= (ez - z) tx.
  let east = -Infinity;
  let west = -Infinity;
  let north = -Infinity;
  let south = -Infinity;
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < positions.length; i += 3) {
    const px = positions[i];
    const py = positions[i + 1];
    const pz = positions[i + 2];
    const x = px * right.x + py * right.y + pz * right.z;
    const y = px * up.x + py * up.y + pz * up.z;
    const z = px * toward.x + py * toward.y + pz * toward.z;
    if (x + z * tx > east) east = x + z * tx;
    if (z * tx - x > west) west = z * tx - x;
    if (y + z * ty > north) north = y + z * ty;
    if (z * ty - y > south) south = z * ty - y;
    if (z < low) low = z;
    if (z > high) high = z;
  }
  const distance = Math.max((east + west) / (2 * tx), (north + south) / (2 * ty));
  const x = (east - west) / 2;
  const y = (north - south) / 2;
  const place = (z: number): Vector3 =>
    new Vector3().addScaledVector(right, x).addScaledVector(up, y).addScaledVector(toward, z);
  return { eye: place(distance), target: place((low + high) / 2) };
}
