// The outline of the brush under the pointer.
import { element } from '../dom';
import type { Viewer } from '../viewer';
import { pixel } from './touch';

export class Ring {
  private readonly circle = element('div', { class: 'panel-ring', 'aria-hidden': 'true' });
  private waiting = 0;
  private readonly follow = (event: PointerEvent) => {
    cancelAnimationFrame(this.waiting);
    this.waiting = requestAnimationFrame(() => this.draw(event));
  };

  /** radius: null where there is no brush. */
  constructor(
    private readonly viewer: () => Viewer,
    private readonly radius: () => number | null,
  ) {}

  show(): void {
    this.circle.hidden = true;
    document.body.append(this.circle);
    window.addEventListener('pointermove', this.follow);
  }

  hide(): void {
    cancelAnimationFrame(this.waiting);
    this.circle.remove();
    window.removeEventListener('pointermove', this.follow);
  }

  private draw(event: PointerEvent): void {
    const radius = this.radius();
    const over = event.target instanceof HTMLCanvasElement && radius !== null;
    const hit = over ? this.viewer().pick(event.clientX, event.clientY) : null;
    this.circle.hidden = hit === null;
    if (hit === null || radius === null) return;
    const size = (2 * radius) / pixel(this.viewer(), hit.point, event.clientX, event.clientY);
    this.circle.style.width = this.circle.style.height = `${size}px`;
    this.circle.style.left = `${event.clientX}px`;
    this.circle.style.top = `${event.clientY}px`;
  }
}
