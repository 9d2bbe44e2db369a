// The pointer over the canvas: a tool gets it first, then the camera; without a drag it hovers, at most once a frame and
// where that takes long less often.
import type { Hit, Tool } from '../viewer';

/** Of a surface that moves it takes long to find what lies under the pointer: time without, for each time with. */
const hoverRest = 6;

export interface PointerHost {
  canvas: HTMLCanvasElement;
  pick(x: number, y: number): Hit | null;
  /** Whether a drag turns the camera. */
  leaveCamera(free: boolean): void;
  hover(hit: Hit | null, x: number, y: number): void;
}

export class Pointer {
  private tool: Tool | null = null;
  private dragging: number | null = null; // the pointer that the tool has taken
  private waiting: PointerEvent | null = null;
  private turning = false;
  private restUntil = 0;

  constructor(private readonly host: PointerHost) {
    const { canvas } = host;
    // Before the camera's listeners, which are on the canvas: capturing listeners of the parent come first.
    const before = canvas.parentElement ?? canvas;
    before.addEventListener('pointerdown', (event) => this.down(event), { capture: true });
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', (event) => this.up(event));
    canvas.addEventListener('pointerleave', () => {
      this.waiting = null;
      if (this.dragging === null) host.hover(null, 0, 0);
    });
  }

  setTool(tool: Tool | null): void {
    this.tool = tool;
    this.host.canvas.style.cursor = tool?.cursor ?? '';
  }

  private down(event: PointerEvent): void {
    if (event.target !== this.host.canvas) return;
    this.turning = true;
    if (!this.tool || this.dragging !== null || event.button !== 0) return;
    if (!this.tool.down(this.host.pick(event.clientX, event.clientY), event)) return;
    event.stopPropagation();
    event.preventDefault();
    this.host.leaveCamera(false);
    this.host.canvas.setPointerCapture(event.pointerId);
    this.dragging = event.pointerId;
  }

  private move(event: PointerEvent): void {
    if (this.dragging !== null ? event.pointerId !== this.dragging : this.turning) return;
    if (!this.waiting) this.soon();
    this.waiting = event;
  }

  private soon(): void {
    const early = this.dragging === null && performance.now() < this.restUntil;
    requestAnimationFrame(() => (early ? this.soon() : this.settle()));
  }

  private settle(): void {
    const event = this.waiting;
    this.waiting = null;
    if (!event) return;
    const { clientX: x, clientY: y } = event;
    if (this.dragging !== null) {
      let hit: Hit | null | undefined;
      this.tool?.move(() => (hit = this.host.pick(x, y)), event);
      // Otherwise what the drag began with is still meant.
      if (hit !== undefined) this.host.hover(hit, x, y);
      return;
    }
    const start = performance.now();
    this.host.hover(this.host.pick(x, y), x, y);
    this.restUntil = start + hoverRest * (performance.now() - start);
  }

  private up(event: PointerEvent): void {
    this.turning = false;
    if (event.pointerId !== this.dragging) return;
    // The place where the drag ends counts, however short the last frame was.
    this.settle();
    this.dragging = null;
    this.host.leaveCamera(true);
    this.tool?.up(event);
  }
}
