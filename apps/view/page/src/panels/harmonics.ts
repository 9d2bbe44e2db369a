// The panel of manifold harmonics: a basis is computed and certified, its functions are looked at, and the mesh is filtered by
// a curve over its spectrum.
import { element } from '../dom';
import type { Arrays, FilterTarget, FrameMessage, Request, SpectrumMessage, StateMessage } from '../protocol';
import { Check, Choice, NumberField } from './controls';
import { presetCurve, presets, type Point } from './curve';
import { CurveEditor } from './editor';
import { Keep } from './keep';
import { Modes } from './modes';
import { duration, short } from './numbers';
import { floats, type Context, type Panel } from './panel';
import { button, group, row, write } from './parts';
import { Stream } from './stream';
import { edgeOf } from './touch';
import { Work } from './work';

export class Harmonics implements Panel {
  readonly work = new Work('harmonics');
  private readonly count: NumberField;
  private readonly compute: HTMLButtonElement;
  private readonly cancel: HTMLButtonElement;
  private readonly certificate: HTMLElement;
  private readonly modes: Modes;
  private readonly filter: HTMLElement;
  private readonly filtering: Check;
  private readonly on: Choice<FilterTarget>;
  private readonly editor: CurveEditor;
  private readonly result: HTMLElement;
  private readonly keep: Keep;
  private readonly browse: Stream;
  private readonly stream: Stream;

  private spectrumNow: { cutoff: number; nyquist: number } = { cutoff: 0, nyquist: 1 };
  private shown: number | null = null;
  private active = false; // the curve is applied
  private target: FilterTarget = 'positions';
  private mode: { k: number; values: Float32Array } | null = null;
  private filtered: { on: FilterTarget; values: Float32Array } | null = null;
  private picture: FilterTarget | 'none' = 'none'; // what the filter has changed in it

  constructor(
    private readonly context: Context,
    host: HTMLElement,
  ) {
    const send = (request: Request) => context.send(request);
    this.browse = new Stream(send);
    this.stream = new Stream(send);
    this.count = new NumberField({
      label: 'Functions',
      test: 'harmonics-count',
      value: 100,
      low: 1,
      whole: true,
      enter: () => this.start(),
    });
    this.compute = button('Compute', 'harmonics-compute', () => this.start(), 'primary');
    this.cancel = button('Cancel', 'harmonics-cancel', () => send({ do: 'cancel' }));
    this.certificate = element('ul', { class: 'certificate', 'data-test': 'harmonics-certificate' });
    this.modes = new Modes(
      (k, last) => {
        this.browse.offer(() => ({ do: 'harmonics.show', k }));
        if (last) this.browse.flush();
      },
      () => this.browse.settled,
    );
    this.filtering = new Check('Filter the mesh', 'harmonics-filter', false, (on) => {
      if (on) this.apply(true);
      else {
        this.stream.drop();
        send({ do: 'harmonics.filter', curve: null, on: this.on.value });
      }
    });
    this.on = new Choice<FilterTarget>({
      label: 'What is filtered',
      test: 'harmonics-on',
      values: [
        ['positions', 'Positions'],
        ['normals', 'Normals'],
        ['colors', 'Colours'],
      ],
      value: 'positions',
      change: (on) => send({ do: 'harmonics.filter', curve: this.filtering.on ? this.editor.curve : null, on }),
    });
    this.editor = new CurveEditor(
      (_, last) => this.apply(last),
      () => this.stream.settled,
    );
    const shapes = presets.map((preset) =>
      button(preset, `curve-preset-${preset}`, () => {
        this.editor.replace(presetCurve(preset, this.spectrumNow.cutoff, this.spectrumNow.nyquist));
      }),
    );
    this.result = element('p', { class: 'hint', 'data-test': 'harmonics-result' });
    this.filter = group(
      'Filter',
      row(this.filtering.element),
      this.on.element,
      element('div', { class: 'presets', role: 'group', 'aria-label': 'Curves to start from' }, ...shapes),
      this.editor.element,
      this.result,
    );
    this.keep = new Keep('harmonics', 'the curve', send);

    host.append(
      element(
        'p',
        { class: 'hint' },
        'The eigenfunctions of the Laplacian are the vibrations of the shape. With a basis of them it can be filtered by frequency, as sound is.',
      ),
      group('Basis', row(this.count.element, this.compute, this.cancel), this.work.element, this.certificate),
      this.modes.element,
      this.filter,
      this.keep.element,
    );
    this.setRunning(null);
  }

  update(state: StateMessage): void {
    const { harmonics } = state;
    const { mesh } = this.context.shell.viewer;
    this.count.limits(1, mesh.vertices);
    this.modes.update(harmonics.computed, harmonics.shown);
    this.on.offer(
      'colors',
      mesh.fields.some((field) => field.name === 'color'),
    );
    this.on.set(harmonics.on);
    this.filtering.set(harmonics.curve !== null);
    this.editor.setActive(harmonics.curve !== null);
    if (harmonics.curve !== null) this.editor.setCurve(harmonics.curve);
    this.filter.hidden = harmonics.computed === 0;
    if (harmonics.computed === 0) this.certificate.replaceChildren();
    this.setRunning(state.running);
    if (state.task === 'harmonics') this.keep.command(state.command);

    const changed =
      this.shown !== harmonics.shown || this.active !== (harmonics.curve !== null) || this.target !== harmonics.on;
    this.shown = harmonics.shown;
    this.active = harmonics.curve !== null;
    this.target = harmonics.on;
    if (!this.active) write(this.result, '');
    if (changed) this.present();
  }

  spectrum(message: SpectrumMessage, arrays: Arrays): void {
    const frequencies = floats(arrays, 'frequencies', message.count) ?? new Float32Array(0);
    const { cutoff, nyquist } = message;
    const first = this.spectrumNow.nyquist !== nyquist;
    this.spectrumNow = { cutoff, nyquist };
    this.modes.setFrequencies(frequencies, edgeOf(this.context.shell.viewer));
    this.editor.setSpectrum({ frequencies, cutoff, nyquist });
    if (first && !this.active) this.editor.setCurve(presetCurve('identity', cutoff, nyquist));
    this.certificate.replaceChildren(
      ...message.certificate.map((line) => element('li', {}, line)),
      ...(message.complete ? [] : [element('li', { class: 'failed' }, 'Not complete: pairs may be missing.')]),
    );
    this.present();
  }

  answered(frame: FrameMessage): void {
    (frame.on === undefined ? this.browse : this.stream).answered(frame.id);
  }

  frame(frame: FrameMessage, arrays: Arrays): void {
    const { vertices } = this.context.shell.viewer.mesh;
    if (frame.on === undefined) {
      const values = floats(arrays, 'values', vertices);
      if (values !== null && frame.shown !== undefined) this.mode = { k: frame.shown, values };
    } else {
      const values = floats(arrays, frame.on, 3 * vertices);
      if (values !== null) this.filtered = { on: frame.on, values };
      const roughness = frame.roughness === undefined ? '' : `Roughness ${short(frame.roughness, 3)} of what it was. `;
      write(this.result, `${roughness}The last update took ${duration(frame.seconds)}.`);
    }
    this.present();
  }

  show(): void {
    this.picture = 'none';
    this.present();
  }

  hide(): void {
    this.stream.flush();
  }

  private present(): void {
    if (this.context.active !== 'harmonics') return;
    const { viewer } = this.context.shell;
    const { filtered, mode } = this;
    const applied = this.active && filtered !== null && filtered.on === this.target ? filtered : null;
    if (applied?.on !== 'positions' && this.picture === 'positions') viewer.atRest();
    if (applied?.on !== 'normals' && this.picture === 'normals') viewer.setNormals(null);
    this.picture = applied?.on ?? 'none';
    if (applied?.on === 'positions') viewer.setPositions(applied.values);
    if (applied?.on === 'normals') viewer.setNormals(applied.values);

    const shown = mode !== null && mode.k === this.shown ? mode : null;
    this.editor.setShown(this.shown === null ? null : this.modes.frequency(this.shown));
    if (applied?.on === 'colors') viewer.showColors('filtered colours', applied.values);
    else if (shown !== null) {
      const most = shown.values.reduce((high, x) => Math.max(high, Math.abs(x)), 0) || 1;
      viewer.showScalar(`eigenfunction ${shown.k}`, shown.values, { range: [-most, most] });
    } else if (this.shown === null) viewer.showPlain();
  }

  private start(): void {
    this.work.begin();
    this.context.send({ do: 'harmonics.compute', count: this.count.value });
  }

  /** The curve as it is now, as fast as the program takes it. */
  private apply(last: boolean): void {
    this.filtering.set(true);
    this.editor.setActive(true);
    this.stream.offer(() => {
      const curve: Point[] = this.editor.curve.map(([f, g]) => [f, g]);
      return { do: 'harmonics.filter', curve, on: this.on.value };
    });
    if (last) this.stream.flush();
  }

  private setRunning(running: StateMessage['running']): void {
    const own = running?.task === 'harmonics';
    const focused = document.activeElement;
    this.compute.hidden = own;
    this.cancel.hidden = !own;
    if (own && focused === this.compute) this.cancel.focus();
    if (!own && focused === this.cancel) this.compute.focus();
    this.work.running(running);
  }
}
