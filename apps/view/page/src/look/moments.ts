// Time series on the timeline: those that a report brings, and those that the tasks add as they run.
import type { Arrays, MomentMessage } from '../protocol';
import type { SceneViewer } from '../scene/scene_viewer';
import type { Moment } from '../viewer';
import { lengths } from './fields';
import { SeriesScale } from './series_scale';
import type { MomentTimeline } from './timeline';

export class Moments {
  private name: string | null = null;
  private scale = new SeriesScale();
  private scaled = new WeakSet<Float32Array>();
  private displaced = false;
  private gathered: Moment[] = [];

  constructor(
    private readonly viewer: SceneViewer,
    private readonly timeline: MomentTimeline,
  ) {
    timeline.show = (name, moment) => this.show(name, moment);
  }

  add(message: MomentMessage, arrays: Arrays): void {
    const values = arrays.values ?? arrays.displacement;
    if (!(values instanceof Float32Array)) return;
    if (this.name !== message.name) {
      this.name = message.name;
      this.displaced = 'displacement' in arrays;
      this.gathered = [];
      this.timeline.reset(message.name);
      this.newScale();
    }
    this.onScale(values);
    this.gathered.push({ step: this.gathered.length, time: message.time, values });
  }

  /** No moment will come any more: the last one is shown on the scale of all. */
  complete(): void {
    if (this.gathered.length > 0) this.timeline.addAll(this.gathered);
  }

  private newScale(): void {
    this.scale = new SeriesScale();
    this.scaled = new WeakSet();
  }

  /** One number a vertex, counted once in the scale. */
  private onScale(values: Float32Array): Float32Array {
    const columns = (3 * values.length) / this.viewer.rest.length;
    const scalar = columns === 1 ? values : lengths(values, columns);
    if (!this.scaled.has(values)) this.scale.add(scalar);
    this.scaled.add(values);
    return scalar;
  }

  private show(name: string, { values }: Moment): void {
    const { viewer } = this;
    if (name === this.name && this.displaced) {
      const positions = new Float32Array(values.length);
      for (let i = 0; i < values.length; ++i) positions[i] = viewer.rest[i] + values[i];
      viewer.setPositions(positions);
    }
    // The first moment of a task that runs again.
    if (this.timeline.count === 1 && !this.scaled.has(values)) this.newScale();
    const scalar = this.onScale(values);
    viewer.showScalar(name, scalar, { range: this.scale.range ?? undefined });
  }
}
