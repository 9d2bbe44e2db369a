// The panel of the poke: a point of the surface is held and moved, the surface gives way around it.
import { element } from '../dom';
import type { Arrays, FrameMessage, Request, StateMessage } from '../protocol';
import type { LivePlot, Tool, Vec3 } from '../viewer';
import { Check, NumberField, Slider } from './controls';
import { Finger } from './finger';
import { Keep } from './keep';
import { normalAt } from './normal';
import { counted, duration, short } from './numbers';
import { floats, type Context, type Panel } from './panel';
import { button, group, row, write } from './parts';
import { difference, pixel, restOf, touches } from './touch';
import { Work } from './work';

interface Skin {
  vertices: Uint32Array;
  displacement: Float32Array;
  levels: Uint32Array;
  force: Vec3 | null;
  at: Vec3 | null;
}

export class Poke implements Panel {
  readonly work = new Work('poke');
  private readonly depth: Slider;
  private readonly vertex: NumberField;
  private readonly domain: Check;
  private readonly press: HTMLButtonElement;
  private readonly release: HTMLButtonElement;
  private readonly clear: HTMLButtonElement;
  private readonly path: HTMLElement;
  private readonly facts: Record<'force' | 'active' | 'rate' | 'step' | 'late', HTMLElement>;
  private readonly plots: { force: LivePlot; active: LivePlot; step: LivePlot };
  private readonly keep: Keep;
  private readonly finger: Finger;

  private newest: Skin | null = null;
  private largest = 0; // force, that the arrow is measured by
  private start: number | null = null; // time of the first frame of this touch; null: at rest
  private late = 0;
  private depthSet = false;
  private readonly let = (event: KeyboardEvent) => {
    if (event.key === 'Escape') this.finger.release();
  };

  constructor(
    private readonly context: Context,
    host: HTMLElement,
  ) {
    const { shell } = context;
    const send = (request: Request) => context.send(request);
    this.finger = new Finger(send);
    this.depth = new Slider({
      label: 'Depth, along the normal',
      test: 'poke-depth',
      low: -0.05,
      high: 0.1,
      value: 0.02,
      change: (depth) => this.finger.reach(depth),
    });
    this.vertex = new NumberField({
      label: 'Vertex',
      test: 'poke-vertex',
      low: 0,
      whole: true,
      enter: () => this.pressTyped(),
    });
    this.press = button('Press', 'poke-press', () => this.pressTyped());
    this.release = button('Release', 'poke-release', () => this.finger.release());
    this.domain = new Check('Show what is solved for', 'poke-domain', true, () => this.present());
    this.clear = button('Forget the path', 'poke-clear', () => send({ do: 'clear' }), 'quiet');
    this.path = element('p', { class: 'hint', 'data-test': 'poke-path' });
    const fact = (name: string) => element('dd', { 'data-test': `poke-${name}` }, '–');
    this.facts = {
      force: fact('force'),
      active: fact('active'),
      rate: fact('rate'),
      step: fact('step'),
      late: fact('late'),
    };
    // One above the other: the axis of the last is that of all.
    const plot = (title: string, line: string, across = '') =>
      shell.livePlot({ title, across, lines: [line], height: across === '' ? 84 : 102 });
    this.plots = {
      force: plot('Force', 'force'),
      active: plot('Vertices solved for', 'vertices'),
      step: plot('A step, ms', 'ms', 'time, s'),
    };
    this.keep = new Keep('poke', 'the path of the poke', send);

    host.append(
      element(
        'p',
        { class: 'hint' },
        'Press on the surface, hold and drag. With shift, up and down go along the normal. A negative depth pulls.',
      ),
      group('Touch', this.depth.element, row(this.vertex.element, this.press, this.release), this.domain.element),
      group(
        'What the surface does',
        element(
          'dl',
          {},
          ...(
            [
              ['Force', this.facts.force],
              ['Vertices solved for', this.facts.active],
              ['Steps a second', this.facts.rate],
              ['A step takes', this.facts.step],
              ['Late steps', this.facts.late],
            ] as const
          ).flatMap(([name, place]) => [element('dt', {}, name), place]),
        ),
        this.plots.force.element,
        this.plots.active.element,
        this.plots.step.element,
        this.work.element,
      ),
      group('Path', this.path, this.clear),
      this.keep.element,
    );
  }

  update(state: StateMessage): void {
    const { viewer } = this.context.shell;
    const { rate, waypoints } = state.poke;
    this.depth.ends(-0.05 * viewer.diagonal, 0.1 * viewer.diagonal);
    if (!this.depthSet) {
      this.depth.set(Number((0.02 * viewer.diagonal).toPrecision(2)));
      this.depthSet = true;
    }
    this.vertex.limits(0, viewer.mesh.vertices - 1);
    write(this.path, waypoints === 0 ? 'No path is recorded yet.' : `${counted(waypoints, 'waypoint')} recorded.`);
    write(this.facts.rate, counted(rate));
    this.clear.hidden = waypoints === 0;
    this.work.running(state.running);
    if (state.task === 'poke') this.keep.command(state.command);
  }

  frame(frame: FrameMessage, arrays: Arrays): void {
    const { vertices, level } = arrays;
    if (!(vertices instanceof Uint32Array) || !(level instanceof Uint32Array)) return;
    const displacement = floats(arrays, 'displacement', 3 * vertices.length);
    if (displacement === null) return;
    const force = frame.force ?? null;
    this.newest = { vertices, displacement, levels: level, force, at: frame.at ?? null };
    this.plot(frame, force === null ? 0 : Math.hypot(...force));
    this.present();
  }

  show(): void {
    const { viewer } = this.context.shell;
    viewer.setTool(this.tool());
    window.addEventListener('keydown', this.let);
    this.present();
  }

  hide(): void {
    this.finger.release();
    window.removeEventListener('keydown', this.let);
  }

  private present(): void {
    if (this.context.active !== 'poke' || this.newest === null) return;
    const { viewer } = this.context.shell;
    const { vertices, displacement, levels, force, at } = this.newest;
    viewer.displace(vertices, displacement);
    viewer.showDomain(this.domain.on && vertices.length > 0 ? { vertices, levels } : null);
    if (force === null || at === null || this.largest === 0) viewer.setArrow(null);
    else {
      const scale = (0.15 * viewer.diagonal) / this.largest;
      viewer.setArrow({ at, vector: force.map((x) => scale * x) as Vec3 });
    }
  }

  private plot(frame: FrameMessage, force: number): void {
    const now = frame.time ?? performance.now() / 1e3;
    if (this.start === null) {
      this.start = now;
      this.late = 0;
      for (const plot of Object.values(this.plots)) plot.clear();
    }
    const time = now - this.start;
    const active = frame.active ?? 0;
    this.largest = Math.max(this.largest, force);
    this.late += frame.late ? 1 : 0;
    this.plots.force.add(time, [force]);
    this.plots.active.add(time, [active]);
    if (frame.step_seconds !== undefined) this.plots.step.add(time, [1e3 * frame.step_seconds]);
    write(this.facts.force, short(force, 3));
    write(this.facts.active, `${counted(active)} of ${counted(this.context.shell.viewer.mesh.vertices)}`);
    if (frame.step_seconds !== undefined) write(this.facts.step, duration(frame.step_seconds));
    write(this.facts.late, counted(this.late));
    // At rest again: the next touch begins its own plots.
    if (active === 0 && frame.force == null && !this.finger.holds) this.start = null;
  }

  private pressTyped(): void {
    const { viewer } = this.context.shell;
    const vertex = this.vertex.value;
    this.finger.press(restOf(viewer, vertex), normalAt(viewer, vertex), [0, 0, 0], this.depth.value);
  }

  private tool(): Tool {
    let from: { point: Vec3; x: number; y: number } | null = null;
    return {
      cursor: 'grab',
      down: (hit, event) => {
        if (!touches(event) || hit === null) return false;
        from = { point: hit.point, x: event.clientX, y: event.clientY };
        // The surface may still be moving: what is taken hold of stays under the pointer.
        this.finger.press(hit.rest, hit.normal, difference(hit.point, hit.rest), this.depth.value);
        return true;
      },
      move: (_, event) => {
        if (from === null) return;
        const { viewer } = this.context.shell;
        const [x, y] = [event.clientX, event.clientY];
        if (event.shiftKey) this.finger.deepen((y - from.y) * pixel(viewer, from.point, x, y));
        else
          this.finger.slide(difference(viewer.onPlane(from.point, x, y), viewer.onPlane(from.point, from.x, from.y)));
        from = { ...from, x, y };
      },
      up: () => {
        from = null;
        this.finger.release();
      },
    };
  }
}
