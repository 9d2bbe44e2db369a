// The panel of interpolation: values are fixed on vertices, by clicks or a brush, and the field between them follows.
import { element } from '../dom';
import type { Arrays, FrameMessage, PaintMode, Request, StateMessage } from '../protocol';
import type { Hit, Marker, Tool, Vec3 } from '../viewer';
import { mostTouched, Stroke } from './brush';
import { Choice, NumberField, Slider } from './controls';
import { InHand } from './inhand';
import { Keep } from './keep';
import { counted } from './numbers';
import { floats, type Context, type Panel } from './panel';
import { button, group, row, write } from './parts';
import { Places } from './places';
import { Ring } from './ring';
import { Stream } from './stream';
import {
  bounded,
  difference,
  edgeOf,
  markerColor,
  markerUnder,
  moved,
  onClick,
  restOf,
  selectedColor,
  touches,
} from './touch';
import { hexOf, read, Value } from './value';
import { Weights } from './weights';
import { Work } from './work';

type Means = 'point' | 'brush' | 'erase';
const hand = 160; // px of a vertical drag that go through the scale

interface Frame {
  mode: PaintMode;
  values: Float32Array;
}

export class Paint implements Panel {
  readonly work = new Work('paint');
  private readonly mode: Choice<PaintMode>;
  private readonly means: Choice<Means>;
  private readonly radius: Slider;
  private readonly value: Value;
  private readonly vertex: NumberField;
  private readonly list: Places;
  private readonly clear: HTMLButtonElement;
  private readonly note: HTMLElement;
  private readonly whose: HTMLElement;
  private readonly hint: HTMLElement;
  private readonly weights: Weights;
  private readonly keep: Keep;
  private readonly ring: Ring;
  private readonly stream: Stream;

  /** Of values that are dragged. */
  private readonly hand: InHand;
  private dragged: { vertex: number; value: number[] } | null = null;
  private fixed = new Map<number, number[]>();
  private selected: number | null = null;
  private painted: PaintMode = 'scalar'; // as the program has it; the choice may be ahead of it
  private newest: Frame | null = null;
  private displaced = false;
  private radiusSet = false;
  private chose = false; // a value, by hand

  constructor(
    private readonly context: Context,
    host: HTMLElement,
  ) {
    const send = (request: Request) => context.send(request);
    this.stream = new Stream(send);
    this.hand = new InHand(() => this.stream.settled);
    this.mode = new Choice<PaintMode>({
      label: 'What is painted',
      test: 'paint-mode',
      values: [
        ['scalar', 'Scalar'],
        ['colors', 'Colours'],
        ['displacement', 'Displacement'],
      ],
      value: 'scalar',
      change: (mode) => send({ do: 'paint.set', mode }),
    });
    this.means = new Choice<Means>({
      label: 'How',
      test: 'paint-tool',
      values: [
        ['point', 'Point'],
        ['brush', 'Brush'],
        ['erase', 'Erase'],
      ],
      value: 'point',
      change: () => {
        // A brush has a value of its own: it is not that of a vertex.
        this.select(null);
        this.describe();
      },
    });
    this.radius = new Slider({
      label: 'Brush radius',
      test: 'paint-radius',
      low: 0.01,
      high: 1,
      least: 0,
      logarithmic: true,
      value: 0.1,
      change: () => {},
    });
    this.value = new Value((value, last) => this.valueChosen(value, last));
    this.vertex = new NumberField({
      label: 'Vertex',
      test: 'paint-vertex',
      low: 0,
      whole: true,
      enter: () => this.fixTyped(),
    });
    this.list = new Places({
      test: 'paint',
      nothing: 'Nothing is fixed yet.',
      remove: (vertex) => this.fix([vertex], null),
      select: (vertex) => this.select(vertex),
    });
    this.clear = button('Remove all', 'paint-clear', () => send({ do: 'clear' }), 'quiet');
    this.hint = element('p', { class: 'hint' });
    this.whose = element('p', { class: 'hint', 'data-test': 'paint-whose' });
    this.note = element('p', { class: 'hint', role: 'status', 'data-test': 'paint-note' });
    this.weights = new Weights(send, new Stream(send));
    this.keep = new Keep('paint', 'the fixed values', send);
    this.ring = new Ring(
      () => context.shell.viewer,
      () => (this.means.value === 'point' ? null : this.radius.value),
    );

    host.append(
      this.mode.element,
      this.hint,
      group(
        'Fixed values',
        this.means.element,
        this.radius.element,
        this.value.element,
        this.whose,
        row(
          this.vertex.element,
          button('Fix', 'paint-add', () => this.fixTyped()),
        ),
        this.list.element,
        this.note,
        this.clear,
      ),
      this.weights.element,
      this.work.element,
      this.keep.element,
    );
    this.describe();
  }

  update(state: StateMessage): void {
    const { paint } = state;
    const { viewer } = this.context.shell;
    this.vertex.limits(0, viewer.mesh.vertices - 1);
    this.radius.ends(edgeOf(viewer), Math.max(viewer.diagonal / 4, 2 * edgeOf(viewer)));
    if (!this.radiusSet) {
      this.radius.set(Number((viewer.diagonal / 40).toPrecision(2)));
      this.radiusSet = true;
    }
    this.weights.update(paint, viewer);
    this.work.running(state.running);
    if (state.task === 'paint') this.keep.command(state.command);
    this.take(paint);
    this.hand.pass(() => {
      if (this.dragged === null) return;
      this.dragged = null;
      this.take(paint);
    });
  }

  private take(paint: StateMessage['paint']): void {
    const otherMode = paint.mode !== this.painted;
    this.painted = paint.mode;
    if (otherMode) {
      this.selected = null;
      write(this.note, '');
    }
    this.fixed = new Map(paint.fixed.map(([vertex, ...value]) => [vertex, value]));
    const { dragged } = this;
    if (dragged !== null && !otherMode && this.fixed.has(dragged.vertex)) this.fixed.set(dragged.vertex, dragged.value);
    this.mode.set(paint.mode);
    this.value.setMode(paint.mode);
    if (paint.mode === 'scalar') {
      let [low, high] = [0, 1];
      for (const [x] of this.fixed.values()) [low, high] = [Math.min(low, x), Math.max(high, x)];
      this.value.setEnds(low, high);
    }
    const chosen = this.selected === null ? undefined : this.fixed.get(this.selected);
    if (chosen !== undefined) this.value.set(chosen);
    this.clear.hidden = this.fixed.size === 0;
    write(this.clear, `Remove all ${counted(this.fixed.size)}`);
    this.describe();
    this.refresh();
    if (otherMode || this.fixed.size === 0) this.present();
  }

  answered(frame: FrameMessage): void {
    this.stream.answered(frame.id);
    this.weights.answered(frame.id);
  }

  frame(frame: FrameMessage, arrays: Arrays): void {
    const mode = frame.mode ?? 'scalar';
    const columns = mode === 'scalar' ? 1 : 3;
    const values = floats(arrays, 'values', columns * this.context.shell.viewer.mesh.vertices);
    if (values === null) return;
    this.newest = { mode, values };
    this.work.note(frame.note);
    this.present();
  }

  show(): void {
    this.displaced = false;
    this.context.shell.viewer.setTool(this.tool());
    this.ring.show();
    this.refresh();
    this.present();
  }

  hide(): void {
    this.hand.leave();
    this.ring.hide();
  }

  /** The newest field, if it is of what is painted now. */
  private present(): void {
    if (this.context.active !== 'paint') return;
    const { viewer } = this.context.shell;
    const frame = this.newest;
    const there = frame !== null && frame.mode === this.painted && this.fixed.size > 0;
    const displaces = there && frame.mode === 'displacement';
    if (!displaces && this.displaced) viewer.atRest();
    this.displaced = displaces;
    if (!there) viewer.showPlain();
    else if (frame.mode === 'scalar')
      viewer.showScalar('value', frame.values, { range: this.level(frame.values), growing: this.hand.now });
    else if (frame.mode === 'colors') viewer.showColors('colours', frame.values);
    else {
      viewer.showPlain();
      viewer.setPositions(viewer.rest.map((x, i) => x + frame.values[i]));
    }
  }

  /** Where the field is one value but for rounding, that value; its colours would be those of noise. */
  private level(values: Float32Array): [number, number] | undefined {
    const [first = 0] = this.fixed.values().next().value ?? [];
    let largest = 1e-12;
    for (const [x] of this.fixed.values()) largest = Math.max(largest, Math.abs(x));
    return values.every((x) => Math.abs(x - first) <= 1e-6 * largest) ? [first, first] : undefined;
  }

  private fix(vertices: number[], value: number[] | null): void {
    this.context.send({ do: 'paint.fix', vertices, value });
  }

  /** Two points of one value make no field: until the user has chosen a value, the second has the other end's. */
  private nextValue(): number[] {
    const [only, ...others] = this.fixed.values();
    const plain = this.painted === 'scalar' && !this.chose && only !== undefined && others.length === 0;
    return plain && only[0] === this.value.value[0] ? [only[0] === 1 ? 0 : 1] : this.value.value;
  }

  private fixTyped(): void {
    this.chose = true;
    this.selected = this.vertex.value;
    this.fix([this.vertex.value], this.value.value);
  }

  private valueChosen(value: number[], last: boolean): void {
    this.chose = true;
    const vertex = this.selected;
    // Otherwise it is what is painted next.
    if (vertex === null || !this.fixed.has(vertex) || this.means.value !== 'point') return;
    this.hand.take();
    this.follow(vertex, value);
    if (!last) return;
    this.stream.flush();
    this.hand.leave();
  }

  /** A value that is being dragged goes to the program as fast as it takes it. */
  private follow(vertex: number, value: number[]): void {
    this.dragged = { vertex, value };
    this.fixed.set(vertex, value);
    this.refresh();
    this.stream.offer(() => ({ do: 'paint.fix', vertices: [vertex], value }));
  }

  private select(vertex: number | null): void {
    this.selected = vertex;
    const value = vertex === null ? undefined : this.fixed.get(vertex);
    if (value !== undefined) this.value.set(value);
    this.refresh();
  }

  private describe(): void {
    const means = this.means.value;
    const drag = {
      scalar: ' Drag a marker up or down to change its value.',
      colors: '',
      displacement: ' Drag a marker to move the vertex.',
    }[this.painted];
    write(
      this.hint,
      {
        point: `Click the surface to fix a value, click a marker to select it, shift-click it to remove it.${drag}`,
        brush: 'Drag over the surface to fix all vertices within the radius; with shift, to let them go.',
        erase: 'Drag over the surface to let go of the fixed vertices within the radius.',
      }[means],
    );
    this.radius.element.hidden = means === 'point';
    this.value.element.hidden = means === 'erase';
    this.whose.hidden = means !== 'point';
  }

  /** List and markers. */
  private refresh(): void {
    const mode = this.painted;
    const markers: Marker[] = [];
    const places = [];
    for (const [vertex, value] of this.fixed) {
      const text = read(value, mode);
      const isSelected = vertex === this.selected;
      const color = mode === 'colors' ? hexOf(value) : isSelected ? selectedColor : markerColor;
      // A colour needs no words; the selected one is told by them.
      markers.push({ vertex, color, label: mode !== 'colors' ? text : isSelected ? `vertex ${vertex}` : '' });
      places.push({ vertex, value: text, color: mode === 'colors' ? color : undefined });
    }
    this.list.set(places, this.selected);
    const chosen = this.selected !== null && this.fixed.has(this.selected);
    write(
      this.whose,
      chosen
        ? `Of vertex ${this.selected}, which is selected. A click beside the mesh lets go of it.`
        : 'Of the next one.',
    );
    if (this.context.active === 'paint') this.context.shell.viewer.setMarkers(bounded(markers, this.selected));
  }

  private tool(): Tool {
    let drag: { move(hit: () => Hit | null, event: PointerEvent): void; up(): void } | null = null;
    return {
      cursor: 'crosshair',
      down: (hit, event) => {
        if (!touches(event)) return false;
        const means = this.means.value;
        if (means !== 'point') {
          if (hit === null) return false;
          drag = this.stroke(means === 'erase' || event.shiftKey);
          drag.move(() => hit, event);
          return true;
        }
        const marker = markerUnder(this.context.shell.viewer, this.fixed.keys(), hit, event);
        if (marker === null) {
          onClick(event, () => {
            if (hit === null) this.select(null);
            else {
              this.selected = hit.vertex;
              this.fix([hit.vertex], this.nextValue());
            }
          });
          return false;
        }
        if (event.shiftKey) this.fix([marker], null);
        else drag = this.dragOf(marker, event);
        return true;
      },
      move: (hit, event) => drag?.move(hit, event),
      up: () => {
        drag?.up();
        drag = null;
      },
    };
  }

  private stroke(erases: boolean) {
    const { viewer } = this.context.shell;
    const value = erases ? null : [...this.value.value];
    const stroke = new Stroke(viewer, this.radius.value, erases ? new Set(this.fixed.keys()) : undefined);
    const request = (): Request | null => {
      const vertices = stroke.take();
      return vertices.length === 0 ? null : { do: 'paint.fix', vertices, value };
    };
    return {
      move: (under: () => Hit | null) => {
        const hit = under();
        if (hit === null) {
          stroke.lift();
          return;
        }
        const leftOut = stroke.sample(hit);
        const done = `${counted(stroke.count, 'vertex', 'vertices')} ${erases ? 'let go' : 'fixed'}`;
        write(this.note, leftOut > 0 ? `${done}; the brush takes the nearest ${counted(mostTouched)}` : done);
        this.stream.offer(request);
      },
      up: () => {
        do {
          this.stream.offer(request);
          this.stream.flush();
        } while (stroke.waiting);
      },
    };
  }

  private dragOf(vertex: number, start: PointerEvent) {
    const from = [...(this.fixed.get(vertex) ?? this.value.value)];
    const mode = this.painted;
    const { viewer } = this.context.shell;
    const origin = mode === 'displacement' ? (restOf(viewer, vertex).map((x, i) => x + from[i]) as Vec3) : null;
    const grip = origin === null ? null : viewer.onPlane(origin, start.clientX, start.clientY);
    const span = this.value.span;
    const valueAt = (event: PointerEvent): number[] => {
      if (origin !== null && grip !== null) {
        const way = difference(viewer.onPlane(origin, event.clientX, event.clientY), grip);
        return from.map((x, i) => x + way[i]);
      }
      const value = from[0] + ((start.clientY - event.clientY) / hand) * span;
      return [Number(value.toPrecision(4))];
    };
    let went = false;
    return {
      move: (_: () => Hit | null, event: PointerEvent) => {
        went ||= moved(start, event);
        if (!went || mode === 'colors') return;
        if (this.selected !== vertex) this.selected = vertex;
        const value = valueAt(event);
        this.chose = true;
        this.hand.take();
        this.value.set(value);
        this.follow(vertex, value);
      },
      up: () => {
        if (went) {
          this.stream.flush();
          this.hand.leave();
        } else this.select(this.selected === vertex ? null : vertex);
      },
    };
  }
}
