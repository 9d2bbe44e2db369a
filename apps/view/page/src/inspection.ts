import type { PageShell } from './look/shell';
import type { FrameMessage, StateMessage } from './protocol';
import type { SceneViewer } from './scene/scene_viewer';
import { LiveSource, type Latency, type Source } from './source';
import type { Hit, Vec3 } from './viewer';

/**
 * window.beltrami: the page as tests and scripts see it. Everything is read, nothing is changed by it.
 *
 * | ready                | the mesh is there and has been drawn; of a report, all of it                              |
 * | live, connected      | whether the page talks to the program; whether it does at this moment                    |
 * | mesh                 | the MeshMessage                                                                          |
 * | state, lastFrame     | the last StateMessage and FrameMessage, null before the first (without their arrays)     |
 * | frameCount           | frame messages received                                                                  |
 * | framesShown          | pictures that showed a frame which none had shown before                                 |
 * | renders, idle        | pictures drawn; whether none is about to be                                              |
 * | renderTime           | milliseconds of the page for the last picture                                            |
 * | shown                | kind 'plain', 'scalar' or 'colors', name, range [low, high] and colour map, vectors      |
 * | valueAt(v)           | numbers shown at a vertex, or null                                                       |
 * | positionOf(v)        | where it is now                                                                          |
 * | screenOf(v)          | client pixels, or null behind the camera; visible(v): whether the surface is not before it |
 * | hitAt(x, y)          | the Hit under client pixels, or null                                                     |
 * | domainSize()         | {inside, ring}                                                                           |
 * | markers()            | those that are set                                                                       |
 * | camera()             | {up, eye, target}, in the scene's coordinates                                            |
 * | display              | isolines, wireframe and the like                                                         |
 * | timeline             | {count, index, visible}                                                                  |
 * | latencies()          | for each request that a frame answered: {id, do, sent, received, painted}, milliseconds  |
 * | said                 | the status line                                                                          |
 * | renderer             | {name, software, pixelRatio, triangles, calls, programs}                                 |
 */
export interface Inspection {
  readonly ready: boolean;
  readonly live: boolean;
  readonly connected: boolean;
  readonly mesh: SceneViewer['mesh'] | null;
  readonly state: StateMessage | null;
  readonly lastFrame: FrameMessage | null;
  readonly frameCount: number;
  readonly framesShown: number;
  readonly renders: number;
  readonly idle: boolean;
  readonly renderTime: number;
  readonly shown: {
    kind: string;
    name: string;
    range: [number, number] | null;
    map: string | null;
    vectors: string;
  } | null;
  readonly display: SceneViewer['display'] | null;
  readonly timeline: { count: number; index: number; visible: boolean };
  readonly said: string;
  readonly renderer: Record<string, unknown> | null;
  valueAt(v: number): number[] | null;
  positionOf(v: number): Vec3 | null;
  screenOf(v: number): [number, number] | null;
  visible(v: number): boolean;
  hitAt(x: number, y: number): Hit | null;
  domainSize(): { inside: number; ring: number };
  markers(): readonly { vertex: number; color: string; label: string }[];
  camera(): unknown;
  latencies(): Latency[];
}

declare global {
  interface Window {
    beltrami: Inspection;
  }
}

interface Parts {
  shell: PageShell;
  source: Source;
  viewer: () => SceneViewer | null;
}

/** What main tells. */
export interface Seen {
  state: StateMessage | null;
  noteFrame(frame: FrameMessage): void;
  ready(): void;
}

export function inspect({ shell, source, viewer }: Parts): Seen {
  let isReady = false;
  let lastFrame: FrameMessage | null = null;
  let frameCount = 0;
  const seen: Seen = {
    state: null,
    noteFrame(frame) {
      lastFrame = frame;
      ++frameCount;
    },
    ready() {
      viewer()?.stage.afterRender(() => (isReady = true));
      viewer()?.stage.invalidate();
    },
  };
  window.beltrami = {
    get ready() {
      return isReady;
    },
    live: source.live,
    get connected() {
      return source instanceof LiveSource && source.connected;
    },
    get mesh() {
      return viewer()?.mesh ?? null;
    },
    get state() {
      return seen.state;
    },
    get lastFrame() {
      return lastFrame;
    },
    get frameCount() {
      return frameCount;
    },
    get framesShown() {
      return source instanceof LiveSource ? source.latencies.shown : 0;
    },
    get renders() {
      return viewer()?.stage.renders ?? 0;
    },
    get idle() {
      return !(viewer()?.stage.waiting ?? false);
    },
    get renderTime() {
      return viewer()?.stage.renderTime ?? 0;
    },
    get shown() {
      const scene = viewer();
      if (!scene) return null;
      const { shown, scale, vectorsShown } = scene;
      return {
        kind: shown.kind,
        name: shown.kind === 'plain' ? '' : shown.name,
        range: scale ? ([scale.low, scale.high] as [number, number]) : null,
        map: scale?.map.name ?? null,
        vectors: vectorsShown,
      };
    },
    get display() {
      return viewer()?.display ?? null;
    },
    get timeline() {
      const { count, index, visible } = shell.timeline;
      return { count, index, visible };
    },
    get said() {
      return shell.said;
    },
    get renderer() {
      const stage = viewer()?.stage;
      if (!stage) return null;
      const { render, programs } = stage.renderer.info;
      return {
        name: stage.rendererName,
        software: stage.software,
        pixelRatio: stage.pixelRatio,
        triangles: render.triangles,
        calls: render.calls,
        programs: programs?.length ?? 0,
      };
    },
    valueAt: (v) => viewer()?.valueAt(v) ?? null,
    positionOf: (v) => viewer()?.positionOf(v) ?? null,
    screenOf: (v) => viewer()?.screenOf(v) ?? null,
    visible: (v) => {
      const scene = viewer();
      const at = scene?.screenOf(v);
      const hit = scene && at ? scene.pick(...at) : null;
      return hit !== null && hit.corners.includes(v);
    },
    hitAt: (x, y) => viewer()?.pick(x, y) ?? null,
    domainSize: () => viewer()?.domainSize ?? { inside: 0, ring: 0 },
    markers: () => viewer()?.markers.all ?? [],
    camera: () => viewer()?.stage.state ?? null,
    latencies: () => (source instanceof LiveSource ? [...source.latencies.measured] : []),
  };
  return seen;
}
