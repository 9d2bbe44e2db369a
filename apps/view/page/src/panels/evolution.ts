// The panel of a simulation in time: values are placed on vertices, a run makes frames, frames go under the scrubber. Heat
// and waves differ in what is placed and in a few words.
import { element } from '../dom';
import type { Arrays, FrameMessage, Request, StateMessage } from '../protocol';
import type { Hit, LivePlot, Marker, Tool } from '../viewer';
import { NumberField } from './controls';
import { Keep } from './keep';
import { Moments } from './moments';
import { counted, short } from './numbers';
import { button, group, row, write } from './parts';
import { floats, type Context, type Panel } from './panel';
import { Places } from './places';
import { bounded, markerColor, markerUnder, moved, onClick, selectedColor, touches } from './touch';
import { Work } from './work';

export interface Kind {
  task: 'heat' | 'wave';
  noun: string; // of what is placed
  value: number; // that is placed first
  field: string; // name of what is computed
  hint: string;
  csv: string;
  place(vertex: number, value: number | null): Request;
  set(what: { time?: number; steps?: number }): Request;
  read(state: StateMessage): { places: [number, number][]; time: number; steps: number };
  /** Controls that only this kind has. */
  extra?: { element: HTMLElement; update(state: StateMessage): void };
}

export class Evolution implements Panel {
  readonly work: Work;
  private readonly value: NumberField;
  private readonly vertex: NumberField;
  private readonly time: NumberField;
  private readonly steps: NumberField;
  private readonly list: Places;
  private readonly clear: HTMLButtonElement;
  private readonly run: HTMLButtonElement;
  private readonly pause: HTMLButtonElement;
  private readonly resume: HTMLButtonElement;
  private readonly cancel: HTMLButtonElement;
  private readonly energy: LivePlot;
  private readonly keep: Keep;

  private readonly moments = new Moments();
  private lastStep = Infinity;
  private newRun = 0; // id of a run of which no frame has come yet
  private places: [number, number][] = [];
  private selected: number | null = null;
  private dragged: { from: number; to: number } | null = null;

  constructor(
    private readonly kind: Kind,
    private readonly context: Context,
    host: HTMLElement,
  ) {
    const { task } = kind;
    const { shell } = context;
    this.work = new Work(task);
    this.value = new NumberField({
      label: 'Value',
      test: `${task}-value`,
      value: kind.value,
      enter: () => this.addTyped(),
    });
    this.vertex = new NumberField({
      label: 'Vertex',
      test: `${task}-vertex`,
      low: 0,
      whole: true,
      enter: () => this.addTyped(),
    });
    this.list = new Places({
      test: task,
      nothing: `No ${kind.noun} yet.`,
      change: (vertex, value) => this.place(vertex, value),
      remove: (vertex) => this.place(vertex, null),
      select: (vertex) => this.select(vertex),
    });
    this.clear = button('Remove all', `${task}-clear`, () => context.send({ do: 'clear' }), 'quiet');

    const set = (what: { time?: number; steps?: number }) => context.send(kind.set(what));
    this.time = new NumberField({
      label: 'Total time',
      test: `${task}-time`,
      low: Number.MIN_VALUE,
      change: (time) => set({ time }),
    });
    this.steps = new NumberField({
      label: 'Steps',
      test: `${task}-steps`,
      low: 1,
      whole: true,
      change: (steps) => set({ steps }),
    });

    this.run = button('Run', `${task}-run`, () => this.start(), 'primary');
    this.pause = button('Pause', `${task}-pause`, () => context.send({ do: 'pause' }));
    this.resume = button('Resume', `${task}-resume`, () => context.send({ do: 'resume' }), 'primary');
    this.cancel = button('Cancel', `${task}-cancel`, () => context.send({ do: 'cancel' }));
    this.energy = shell.livePlot({ title: 'Energy', across: 'time', lines: ['energy'], height: 130 });
    this.keep = new Keep(
      task,
      kind.csv,
      (request) => context.send(request),
      () => (this.moments.all.length > 0 ? shell.timeline.shown?.step : undefined),
    );

    host.append(
      element('p', { class: 'hint' }, kind.hint),
      group(
        `${kind.noun[0].toUpperCase()}${kind.noun.slice(1)}s`,
        row(
          this.value.element,
          this.vertex.element,
          button('Add', `${task}-add`, () => this.addTyped()),
        ),
        this.list.element,
        this.clear,
      ),
      group(
        'Run',
        row(this.time.element, this.steps.element),
        ...(kind.extra === undefined ? [] : [kind.extra.element]),
        row(this.run, this.pause, this.resume, this.cancel),
        this.work.element,
        this.energy.element,
      ),
      this.keep.element,
    );
    this.setRunning(null);
  }

  update(state: StateMessage): void {
    const { kind } = this;
    const { places, time, steps } = kind.read(state);
    this.places = places;
    this.time.set(time);
    this.steps.set(steps);
    this.vertex.limits(0, this.context.shell.viewer.mesh.vertices - 1);
    this.clear.hidden = places.length === 0;
    write(this.clear, `Remove all ${counted(places.length)}`);
    kind.extra?.update(state);
    this.setRunning(state.running);
    if (state.task === kind.task) this.keep.command(state.command);
    this.refresh();
  }

  frame(frame: FrameMessage, arrays: Arrays): void {
    const { viewer, timeline } = this.context.shell;
    const values = floats(arrays, 'values', viewer.mesh.vertices);
    if (values === null) return;
    const step = frame.step ?? this.lastStep + 1;
    const time = frame.time ?? step;
    const first = step <= this.lastStep || (this.newRun > 0 && frame.id >= this.newRun);
    if (first) {
      this.newRun = 0;
      this.moments.clear();
      this.energy.clear();
    }
    this.lastStep = step;
    if (frame.steps !== undefined) this.work.stepped(step, frame.steps);
    const moment = { step, time, values };
    const every = frame.every ?? 1;
    this.moments.add(moment, every);
    if (frame.energy !== undefined) this.energy.add(time, [frame.energy]);
    if (this.context.active === this.kind.task) {
      if (first) timeline.reset(this.kind.field);
      timeline.add(moment, every);
    }
  }

  show(): void {
    const { viewer, timeline } = this.context.shell;
    viewer.setTool(this.tool());
    this.refresh();
    if (this.moments.all.length === 0) {
      timeline.hide();
      return;
    }
    timeline.reset(this.kind.field);
    for (const moment of this.moments.all) timeline.add(moment, 1);
  }

  hide(): void {
    this.dragged = null;
    this.context.shell.timeline.hide();
  }

  private start(): void {
    this.work.begin();
    this.newRun = this.context.send({ do: 'run' });
  }

  private place(vertex: number, value: number | null): void {
    if (value === null && this.selected === vertex) this.selected = null;
    this.context.send(this.kind.place(vertex, value));
  }

  private addTyped(): void {
    this.selected = this.vertex.value;
    this.place(this.vertex.value, this.value.value);
  }

  private select(vertex: number | null): void {
    this.selected = vertex;
    this.refresh();
  }

  private setRunning(running: StateMessage['running']): void {
    const own = running?.task === this.kind.task;
    const buttons: [HTMLButtonElement, boolean][] = [
      [this.run, !own],
      [this.pause, own && !running.paused],
      [this.resume, own && running.paused],
      [this.cancel, own],
    ];
    // Who works by keyboard stays on the buttons when the one that was pressed goes.
    const focused = buttons.find(([made]) => made === document.activeElement);
    for (const [made, there] of buttons) made.hidden = !there;
    if (focused !== undefined && !focused[1]) buttons.find(([, there]) => there)?.[0].focus();
    this.work.running(running);
  }

  /** List and markers. */
  private refresh(): void {
    this.list.set(
      this.places.map(([vertex, value]) => ({ vertex, value })),
      this.selected,
    );
    if (this.context.active !== this.kind.task) return;
    const markers: Marker[] = this.places.map(([vertex, value]) => ({
      vertex: this.dragged?.from === vertex ? this.dragged.to : vertex,
      color: vertex === this.selected ? selectedColor : markerColor,
      label: short(value),
    }));
    this.context.shell.viewer.setMarkers(bounded(markers, this.dragged?.to ?? this.selected));
  }

  private tool(): Tool {
    let start: PointerEvent | null = null;
    return {
      cursor: 'crosshair',
      down: (hit, event) => {
        if (!touches(event)) return false;
        const { viewer } = this.context.shell;
        const marker = markerUnder(
          viewer,
          this.places.map(([vertex]) => vertex),
          hit,
          event,
        );
        if (marker !== null) {
          if (event.shiftKey) {
            this.place(marker, null);
            return true;
          }
          start = event;
          this.dragged = { from: marker, to: marker };
          return true;
        }
        onClick(event, () => (hit === null ? this.select(null) : this.placeAt(hit)));
        return false;
      },
      move: (under, event) => {
        if (this.dragged === null || start === null) return;
        if (this.dragged.to === this.dragged.from && !moved(start, event)) return;
        const hit = under();
        if (hit === null) return;
        this.dragged.to = hit.vertex;
        this.refresh();
      },
      up: () => {
        const { dragged } = this;
        this.dragged = null;
        start = null;
        if (dragged === null) return;
        if (dragged.from === dragged.to) this.select(this.selected === dragged.from ? null : dragged.from);
        else this.moveTo(dragged.from, dragged.to);
      },
    };
  }

  private placeAt(hit: Hit): void {
    this.selected = hit.vertex;
    this.place(hit.vertex, this.value.value);
  }

  private moveTo(from: number, to: number): void {
    const value = this.places.find(([vertex]) => vertex === from)?.[1];
    if (value === undefined) return;
    // Until the program answers the marker stays where it was dropped.
    this.places = this.places.filter(([vertex]) => vertex !== from && vertex !== to).concat([[to, value]]);
    this.selected = to;
    this.place(to, value);
    this.place(from, null);
    this.refresh();
  }
}
