// The fields of the file, or of a report: asked for once, then kept, and shown as they are meant.
import { rangeWithoutOutliers } from '../colour/colour_scale';
import type { Arrays, FieldMessage, MeshMessage } from '../protocol';
import type { SceneViewer } from '../scene/scene_viewer';
import type { FieldSource } from './look_panel';

interface Known {
  message: FieldMessage;
  values: Float32Array;
}

export class Fields implements FieldSource {
  private readonly known = new Map<string, Known>();
  private wanted: string | null = null;
  private readonly waiters: { name: string; done: () => void }[] = [];

  /** `ask`: of the program; null where all comes by itself. */
  constructor(
    private readonly viewer: SceneViewer,
    private readonly mesh: MeshMessage,
    private readonly ask: ((name: string) => void) | null,
  ) {}

  get names(): string[] {
    return this.ask ? this.mesh.fields.map(({ name }) => name) : [...this.known.keys()];
  }

  choose(name: string): void {
    this.wanted = name;
    const known = this.known.get(name);
    if (known) this.show(known);
    else if (name === '') this.showNone();
    else this.ask?.(name);
  }

  receive(message: FieldMessage, arrays: Arrays): void {
    const { values } = arrays;
    if (!(values instanceof Float32Array)) return;
    this.known.set(message.name, { message, values });
    if (this.wanted === message.name) this.show({ message, values });
    for (const waiter of this.waiters.splice(0)) {
      if (waiter.name === message.name) waiter.done();
      else this.waiters.push(waiter);
    }
  }

  /** When there is a choice to make and nobody has made one. */
  showFirst(): void {
    const [first] = this.known.keys();
    if (first !== undefined && this.wanted === null) this.choose(first);
  }

  async whenShown(name: string): Promise<void> {
    if (!this.known.has(name))
      await new Promise<void>((done) => this.waiters.push({ name, done }) && this.choose(name));
    this.choose(name);
  }

  private showNone(): void {
    this.viewer.showVectors('', null);
    this.viewer.showPlain();
  }

  private show({ message, values }: Known): void {
    const { viewer } = this;
    const { name, columns } = message;
    viewer.showVectors(name, message.as === 'vectors' && columns === 3 ? values : null);
    if (message.as === 'colors' && columns >= 3)
      viewer.showColors(name, columns === 3 ? values : leading(values, columns, 3));
    else if (message.as === 'scalar' && columns === 1) this.showScalar(name, values);
    else this.showScalar(name, lengths(values, columns));
  }

  private showScalar(name: string, values: Float32Array): void {
    this.viewer.showScalar(name, values, { range: rangeWithoutOutliers(values) ?? undefined });
  }
}

/** Of each vertex's numbers the first ones. */
function leading(values: Float32Array, columns: number, wanted: number): Float32Array {
  const out = new Float32Array((values.length / columns) * wanted);
  for (let i = 0; i < out.length; ++i) out[i] = values[Math.floor(i / wanted) * columns + (i % wanted)];
  return out;
}

/** Of more than one column the length is shown. */
export function lengths(values: Float32Array, columns: number): Float32Array {
  const out = new Float32Array(values.length / columns);
  for (let v = 0; v < out.length; ++v) {
    let square = 0;
    for (let k = 0; k < columns; ++k) square += values[v * columns + k] ** 2;
    out[v] = Math.sqrt(square);
  }
  return out;
}
