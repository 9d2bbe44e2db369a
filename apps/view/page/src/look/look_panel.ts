// The tab that is about looking: which field, how it is coloured, what lies over the surface, from where.
import { mapTitles } from '../colour/colour_map';
import { finiteRange } from '../colour/colour_scale';
import { counted, shortNumber } from '../colour/ticks';
import { element, put } from '../dom';
import type { Axis } from '../scene/camera';
import { viewNames } from '../scene/camera';
import { type Display, plainDisplay, type SceneViewer } from '../scene/scene_viewer';
import { recall, remember } from './memory';
import type { PageShell } from './shell';

/** What the panel's list of fields may hold besides fields. */
const plainName = '';

export interface FieldSource {
  names: string[];
  /** Shows it, now or when it has come. */
  choose(name: string): void;
}

export class LookPanel {
  private readonly field = element('select', { 'data-test': 'look-field', onchange: () => this.chooseField() });
  private readonly map = element('select', {
    'data-test': 'look-map',
    onchange: () => this.set({ map: this.map.value as Display['map'] }),
  });
  private readonly low = this.rangeEnd('Lowest value', 'look-low');
  private readonly high = this.rangeEnd('Highest value', 'look-high');
  private readonly automatic = this.check('Automatic', 'look-automatic', (on) => this.setAutomatic(on));
  private readonly isolines = this.check('Isolines', 'look-isolines', (isolines) => this.set({ isolines }));
  private readonly isolineCount = this.slider('Number of isolines', 'look-isoline-count', 3, 60, (isolineCount) =>
    this.set({ isolineCount }),
  );
  private readonly wireframe = this.check('Wireframe', 'look-wireframe', (wireframe) => this.set({ wireframe }));
  private readonly boundary: HTMLLabelElement;
  private readonly nonManifold: HTMLLabelElement;
  private readonly facets = this.check('Facets', 'look-facets', (facets) => this.set({ facets }));
  private readonly vectors = this.check('Arrows', 'look-vectors', (vectors) => this.set({ vectors }));
  private readonly vectorCount = this.slider('Number of arrows', 'look-vector-count', 100, 6000, (vectorCount) =>
    this.set({ vectorCount }),
  );
  private readonly vectorLength = this.slider('Length of arrows', 'look-vector-length', 0.2, 4, (vectorLength) =>
    this.set({ vectorLength }),
  );
  private readonly vectorGroup: HTMLElement;
  private readonly up = element('select', {
    'data-test': 'look-up',
    'aria-label': 'Axis that is up',
    onchange: () => this.view('front', this.up.value as Axis),
  });
  private readonly theme = element('select', {
    'data-test': 'look-theme',
    onchange: () =>
      this.shell.theme.choose(this.theme.value === 'system' ? null : (this.theme.value as 'light' | 'dark')),
  });
  private readonly beyond = element('p', { class: 'hint', 'data-test': 'look-beyond', hidden: true });
  /** Of the field of the file that is shown. */
  private extent: { values: Float32Array | null; ends: [number, number] } = { values: null, ends: [0, 0] };
  private readonly appearance: HTMLElement;
  private readonly drawer: HTMLDetailsElement;
  private readonly fieldGroup: HTMLElement;
  private chosen = plainName;

  constructor(
    private readonly shell: PageShell,
    private readonly viewer: SceneViewer,
    host: HTMLElement,
    private readonly fields: FieldSource,
  ) {
    const { boundary, nonManifold, mesh } = viewer;
    this.boundary = this.check(`Boundary edges (${counted(boundary.length / 2)})`, 'look-boundary', (on) =>
      this.set({ boundary: on }),
    );
    this.nonManifold = this.check(
      `Non-manifold edges (${counted(nonManifold.length / 2)})`,
      'look-non-manifold',
      (on) => this.set({ nonManifold: on }),
    );
    (this.boundary.control as HTMLInputElement).disabled = boundary.length === 0;
    (this.nonManifold.control as HTMLInputElement).disabled = nonManifold.length === 0;
    this.map.append(
      option('automatic', 'As the values need it'),
      ...Object.entries(mapTitles).map(([value, text]) => option(value, text)),
    );
    this.up.append(...['x', 'y', 'z'].map((axis) => option(axis, `${axis} up`)));
    this.theme.append(option('system', 'As the system'), option('light', 'Light'), option('dark', 'Dark'));
    this.vectorGroup = group('Vectors', this.vectors, this.vectorCount.element, this.vectorLength.element);
    const onSurface = mesh.cells === 'triangles' || mesh.cells === 'tetrahedra';
    host.classList.add('panel');
    this.appearance = element(
      'div',
      { class: 'appearance' },
      group(
        'Colour',
        labelled('Colour map', this.map),
        element(
          'div',
          { class: 'look-range' },
          this.low,
          element('span', { 'aria-hidden': true }, '\u2013'),
          this.high,
          this.automatic,
        ),
        this.beyond,
        this.isolines,
        this.isolineCount.element,
      ),
      this.vectorGroup,
      group(
        'Surface',
        element(
          'div',
          { class: 'checks' },
          ...(onSurface ? [this.wireframe, this.facets] : []),
          this.boundary,
          this.nonManifold,
        ),
      ),
      group(
        'View',
        element(
          'div',
          { class: 'views', role: 'group', 'aria-label': 'Views' },
          ...viewNames.map((name, i) =>
            element(
              'button',
              {
                type: 'button',
                title: `${name} (${i + 1})`,
                'data-test': `view-${name}`,
                onclick: () => this.view(name),
              },
              name,
            ),
          ),
        ),
        element('div', { class: 'row' }, labelled('Axis', this.up), labelled('Background', this.theme)),
        element(
          'button',
          { type: 'button', 'data-test': 'look-reset', onclick: () => this.reset() },
          'Reset how it looks',
        ),
      ),
    );
    this.drawer = element(
      'details',
      { class: 'drawer', 'data-test': 'look-drawer' },
      element('summary', {}, 'How it looks'),
    );
    this.fieldGroup = group('Field', this.field);
    this.field.setAttribute('aria-label', 'Field');
    host.append(this.fieldGroup, this.appearance, meshReport(viewer));
    viewer.onChange(() => this.update());
    shell.theme.onChange(() => this.update());
    this.listFields();
    this.restore();
  }

  /** What a task shows can be coloured while it is looked at: the controls go with the tab, folded under the task's own. */
  goTo(host: HTMLElement | null): void {
    if (host) {
      this.drawer.append(this.appearance);
      host.append(this.drawer);
    } else {
      this.fieldGroup.after(this.appearance);
    }
  }

  /** The field that was chosen here comes back after a task. */
  showAgain(): void {
    this.showField(this.chosen);
  }

  /** The field that was looked at before a reload, if it is there; false: none. */
  recallField(): boolean {
    const name = recall('field', plainName);
    const known = this.fields.names.includes(name);
    if (known) this.showField(name);
    return known;
  }

  /** Fields have come, or which one is shown has changed. */
  listFields(): void {
    this.field.replaceChildren(
      option(plainName, 'None: the plain surface'),
      ...this.fields.names.map((name) => option(name, name)),
    );
    this.update();
  }

  /** A field by its name, as if the user had chosen it. */
  showField(name: string): void {
    this.chosen = name;
    this.fields.choose(name);
    this.update();
  }

  private chooseField(): void {
    remember('field', this.field.value);
    this.showField(this.field.value);
  }

  view(name: string, up: Axis = this.viewer.stage.upAxis): void {
    this.viewer.fit(name, up);
    this.rememberCamera();
    this.update();
  }

  set(change: Partial<Display>): void {
    this.viewer.display = { ...this.viewer.display, ...change };
    remember('display', this.viewer.display);
  }

  toggle(name: 'isolines' | 'wireframe' | 'boundary' | 'nonManifold' | 'facets' | 'vectors'): void {
    this.set({ [name]: !this.viewer.display[name] });
  }

  rememberCamera(): void {
    remember('camera', this.viewer.stage.state);
  }

  private restore(): void {
    const { viewer } = this;
    // Names may have been added since it was stored.
    viewer.display = { ...plainDisplay, ...recall<Partial<Display>>('display', {}) };
    const camera = recall<typeof viewer.stage.state | null>('camera', null);
    viewer.fit('iso', 'y');
    if (camera) viewer.stage.state = camera;
    viewer.stage.onCamera(() => this.rememberCamera());
  }

  private reset(): void {
    this.shell.theme.choose(null);
    this.viewer.display = { ...plainDisplay };
    remember('display', plainDisplay);
    this.view('iso', 'y');
  }

  private setAutomatic(on: boolean): void {
    const { scale } = this.viewer;
    if (on || !scale) this.set({ range: null });
    else this.setRange(scale.low, scale.high);
  }

  private setRange(low: number, high: number): void {
    const { shown } = this.viewer;
    if (shown.kind === 'scalar') this.set({ range: { of: shown.name, ends: [low, high] } });
  }

  private takeRange(): void {
    const low = parsed(this.low.value);
    const high = parsed(this.high.value);
    if (low === null || high === null || low > high) {
      this.shell.say('A range goes from a number to one that is not smaller.', true);
      this.update();
    } else {
      this.setRange(low, high);
    }
  }

  private update(): void {
    const { viewer } = this;
    const { display, scale, shown } = viewer;
    // What a task shows is not in the list of the file's fields.
    const name = shown.kind === 'plain' ? viewer.vectorsShown || plainName : shown.name;
    const listed = name === plainName || this.fields.names.includes(name);
    const task = this.field.querySelector<HTMLOptionElement>('option[data-task]');
    if (listed || task?.value !== name) task?.remove();
    if (!listed && task?.value !== name) {
      const made = option(name, `${name} (of the task)`);
      made.dataset.task = '';
      this.field.append(made);
    }
    put(this.field, { value: name });
    put(this.map, { value: display.map });
    const edited = document.activeElement;
    for (const [input, value] of [
      [this.low, scale?.low],
      [this.high, scale?.high],
    ] as const) {
      put(input, { disabled: value === undefined });
      if (input !== edited) put(input, { value: value === undefined ? '' : String(Number(value.toPrecision(6))) });
    }
    this.tellBeyond(listed);
    tick(this.automatic, viewer.typedRange === null);
    tick(this.isolines, display.isolines);
    put(this.isolineCount.element, { hidden: !display.isolines });
    this.isolineCount.show(display.isolineCount);
    tick(this.wireframe, display.wireframe);
    tick(this.boundary, display.boundary && viewer.boundary.length > 0);
    tick(this.nonManifold, display.nonManifold && viewer.nonManifold.length > 0);
    tick(this.facets, display.facets);
    tick(this.vectors, display.vectors);
    put(this.vectorGroup, { hidden: viewer.vectorsShown === '' });
    this.vectorCount.show(display.vectorCount);
    this.vectorLength.show(display.vectorLength);
    put(this.up, { value: viewer.stage.upAxis });
    put(this.theme, { value: this.shell.theme.choice ?? 'system' });
  }

  /** Values outside of the scale have the colours of its ends. */
  private tellBeyond(listed: boolean): void {
    const { shown, scale } = this.viewer;
    const known = listed && shown.kind === 'scalar' && scale !== null;
    if (!known) {
      put(this.beyond, { hidden: true });
      return;
    }
    if (this.extent.values !== shown.values) this.extent = { values: shown.values, ends: finiteRange(shown.values) };
    const [low, high] = this.extent.ends;
    put(this.beyond, {
      hidden: low >= scale.low && high <= scale.high,
      textContent: `Some values are outside: they go from ${shortNumber(low)} to ${shortNumber(high)}.`,
    });
  }

  private check(text: string, test: string, change: (on: boolean) => void): HTMLLabelElement {
    const input = element('input', { type: 'checkbox', 'data-test': test, onchange: () => change(input.checked) });
    return element('label', { class: 'check' }, input, element('span', {}, text));
  }

  private rangeEnd(label: string, test: string): HTMLInputElement {
    return element('input', {
      type: 'text',
      inputmode: 'decimal',
      'aria-label': label,
      autocomplete: 'off',
      'data-test': test,
      onchange: () => this.takeRange(),
    });
  }

  /** Equal ways are equal factors. */
  private slider(
    label: string,
    test: string,
    low: number,
    high: number,
    change: (value: number) => void,
  ): { element: HTMLElement; show(value: number): void } {
    const steps = 200;
    const whole = low >= 1;
    const output = element('output');
    const input = element('input', {
      type: 'range',
      min: 0,
      max: steps,
      'data-test': test,
      oninput: () => {
        const value = low * (high / low) ** (Number(input.value) / steps);
        change(whole ? Math.round(value) : Number(value.toPrecision(3)));
      },
    });
    return {
      element: element('label', { class: 'look-slider' }, element('span', {}, label), output, input),
      show: (value) => {
        put(output, { textContent: shortNumber(value, 4) });
        if (document.activeElement !== input)
          put(input, { value: String(Math.round((steps * Math.log(value / low)) / Math.log(high / low))) });
      },
    };
  }
}

const option = (value: string, text: string): HTMLOptionElement => element('option', { value }, text);

const labelled = (text: string, control: HTMLElement): HTMLElement =>
  element('label', { class: 'labelled' }, element('span', {}, text), control);

const group = (title: string, ...children: Node[]): HTMLElement =>
  element('section', { class: 'group', 'aria-label': title }, element('h3', {}, title), ...children);

function tick(label: HTMLLabelElement, on: boolean): void {
  put(label.control as HTMLInputElement, { checked: on });
}

/** Number, with either minus sign; a comma is no point. */
function parsed(text: string): number | null {
  const cleaned = text.trim().replace('\u2212', '-');
  const value = Number(cleaned);
  return cleaned !== '' && Number.isFinite(value) ? value : null;
}

/** What is known of the mesh: a line, and all of it on demand. */
function meshReport(viewer: SceneViewer): HTMLElement {
  const { brief, full, decimated, decimation } = viewer.mesh;
  return element(
    'section',
    { class: 'group mesh-report', 'aria-label': 'Mesh' },
    element('h3', {}, 'Mesh'),
    element('p', { 'data-test': 'mesh-brief' }, brief),
    decimated && element('p', { class: 'hint', 'data-test': 'decimation' }, decimation),
    element(
      'details',
      {},
      element('summary', {}, 'Everything that was found'),
      element('pre', { 'data-test': 'mesh-full' }, full),
    ),
  );
}
