// What a panel is, and what it is given.
import type { Arrays, FrameMessage, Request, StateMessage, Task } from '../protocol';
import type { Shell } from '../viewer';
import type { Work } from './work';

export interface Context {
  readonly shell: Shell;
  send(request: Request): number;
  /** The task that is looked at. */
  readonly active: Task;
}

/** The page is a function of the state: update() and frame() come whether the panel is looked at or not, show() when it
 * begins to be and hide() when it ceases. Only a panel that is looked at touches the picture. answered() comes with each
 * frame at once, frame() where newer ones replace it only for the newest before a picture is drawn. */
export interface Panel {
  readonly work: Work;
  update(state: StateMessage): void;
  answered?(frame: FrameMessage): void;
  frame(frame: FrameMessage, arrays: Arrays): void;
  show(): void;
  hide(): void;
}

/** Arrays by name, as what they were sent. */
export function floats(arrays: Arrays, name: string, count: number): Float32Array | null {
  const found = arrays[name];
  return found instanceof Float32Array && found.length === count ? found : null;
}
