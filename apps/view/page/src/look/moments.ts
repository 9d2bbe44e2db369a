// Time series on the timeline: those that a report brings, and those that the tasks add as they run.
import { finiteRange } from '../colour/colour_scale';
import type { Arrays, MomentMessage } from '../protocol';
import type { SceneViewer } from '../scene/scene_viewer';
import { lengths } from './fields';
import type { Moment, MomentTimeline } from './timeline';

export class Moments {
  private name: string | null = null;
  /** What a report brings is on one scale from the start. */
  private range: [number, number] | null = null;
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
      this.range = null;
      this.displaced = 'displacement' in arrays;
      this.gathered = [];
      this.timeline.reset(message.name);
    }
    const [low, high] = finiteRange(
      this.displaced ? lengths(values, 3) : message.columns === 1 ? values : lengths(values, message.columns),
    );
    this.range = this.range ? [Math.min(this.range[0], low), Math.max(this.range[1], high)] : [low, high];
    this.gathered.push({ time: message.time, values });
  }

  /** No moment will come any more: the last one is shown on the scale of all. */
  complete(): void {
    if (this.gathered.length > 0) this.timeline.addAll(this.gathered);
  }

  private show(name: string, { values }: Moment): void {
    const { viewer } = this;
    const vertices = viewer.rest.length / 3;
    const mine = name === this.name;
    const columns = values.length / vertices;
    if (mine && this.displaced) {
      const positions = new Float32Array(values.length);
      for (let i = 0; i < values.length; ++i) positions[i] = viewer.rest[i] + values[i];
      viewer.setPositions(positions);
    }
    const scalar = columns === 1 ? values : lengths(values, columns);
    viewer.showScalar(name, scalar, mine && this.range ? { range: this.range } : { growing: true });
  }
}
