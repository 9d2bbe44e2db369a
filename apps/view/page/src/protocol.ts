// What the program and the page say to each other. The program's side is apps/view/session.cpp (live) and
// apps/program/report.cpp (a file that was left by --report); both send the same messages.
//
// Page to program: JSON texts, type Request. Program to page: a JSON text (type Message), or, where arrays go with it, a
// binary parcel:
//
//     u32 length of the header | header: JSON, padded with blanks to a multiple of 4 | the arrays' bytes
//
// all little-endian; the header is a Message whose `arrays` says of each array its type, the byte where it starts
// (counted from the end of the header) and how many numbers it has. Vertices are numbered as in the user's file.

export type Task = 'look' | 'heat' | 'wave' | 'paint' | 'poke' | 'harmonics';

export interface ArrayPlace {
  type: 'f32' | 'u32';
  at: number;
  count: number;
}
export type Arrays = Record<string, Float32Array | Uint32Array>;

/** The mesh, sent once. Arrays: positions (3 a vertex); triangles, segments, points (vertex numbers; what is drawn: of
 * tetrahedra the boundary); boundary, non_manifold (2 an edge). Where `decimated`, the vertices are a selection, and the array
 * `vertex_of` has the number of each in the file. */
export interface MeshMessage {
  kind: 'mesh';
  name: string;
  cells: 'points' | 'segments' | 'triangles' | 'tetrahedra';
  vertices: number; // that are sent
  decimated: boolean;
  decimation: string; // a sentence, '' where there is none
  brief: string; // one line of the mesh report
  full: string; // the mesh report, a line for each fact
  report: Record<string, unknown>;
  fields: FieldName[]; // what the file carries
  mean_edge: number;
}
export interface FieldName {
  name: string;
  columns: number;
}

/** A field to look at. Array: values, columns a vertex. `as`: how it is meant. */
export interface FieldMessage {
  kind: 'field';
  name: string;
  columns: number;
  as: 'scalar' | 'vectors' | 'colors';
}

/** Everything that the user did, complete; sent when a page connects and after every change. */
export interface StateMessage {
  kind: 'state';
  id?: number; // of the newest request that it knows of
  task: Task;
  heat: { sources: [number, number][]; time: number; steps: number };
  wave: { impulses: [number, number][]; time: number; steps: number; beta_2: number };
  paint: {
    mode: PaintMode;
    fixed: [number, ...number[]][]; // vertex, then 1 value or 3
    gamma_1: number;
    gamma_2: number; // in length^2
    bounded: boolean;
  };
  poke: { rate: number; waypoints: number }; // waypoints: recorded since the last clear
  harmonics: {
    computed: number; // pairs that there are
    shown: number | null; // the eigenfunction that is shown
    on: FilterTarget;
    curve: [number, number][] | null; // frequency (ascending), gain; null: not filtering
  };
  running: { task: Task; paused: boolean } | null;
  command: string[]; // command lines that do what the current task shows
}
export type PaintMode = 'scalar' | 'colors' | 'displacement';
export type FilterTarget = 'positions' | 'normals' | 'colors';

/** A result. `id`: of the newest request that it answers.
 *
 * | task      | arrays                                                                                               |
 * | heat,wave | values (1 a vertex), at `step` of `steps`, with `time` and `energy`; of the moments before, those    |
 * |           | whose step is no multiple of `every` are given up                                                    |
 * | paint     | values (1 a vertex for scalars, 3 for colours in [0, 1] and displacements)                           |
 * | poke      | vertices and, for each, displacement (3) and level (u32: 2 solved for, 1 ring around): all other     |
 * |           | vertices are at rest and outside; with `active`, `force` and `at` (3 numbers, null where released),  |
 * |           | `step_seconds`, `late`                                                                               |
 * | harmonics | values (1 a vertex: eigenfunction `shown` of `frequency`), or positions, normals or colors (3), with |
 * |           | `roughness`: the energy of what is filtered, sum of u^T K u over its columns, relative to before     |
 */
export interface FrameMessage {
  kind: 'frame';
  task: Task;
  id: number;
  seconds: number; // that the program took
  note: string; // a line about the solve
  step?: number;
  steps?: number;
  every?: number;
  time?: number;
  energy?: number;
  mode?: PaintMode;
  active?: number;
  force?: [number, number, number] | null;
  at?: [number, number, number] | null;
  step_seconds?: number;
  late?: boolean;
  shown?: number;
  frequency?: number;
  on?: FilterTarget;
  roughness?: number;
}

/** Arrays: frequencies (sqrt of the eigenvalues), ascending. */
export interface SpectrumMessage {
  kind: 'spectrum';
  count: number;
  complete: boolean;
  certificate: string[]; // a line for each fact
  cutoff: number; // the frequency up to which the basis holds every function
  nyquist: number; // pi / mean edge
}

export interface ProgressMessage {
  kind: 'progress';
  task: Task;
  phase: string;
  fraction: number; // negative: not known
}
/** Work has ended; `cancelled` by the user, or `error` and `hint`. */
export interface DoneMessage {
  kind: 'done';
  task: Task;
  id: number;
  text: string;
  cancelled: boolean;
  error: string;
  hint: string;
}
/** A request that was refused. */
export interface RefusedMessage {
  kind: 'refused';
  what: string;
  hint: string;
}
/** A file is ready at `path`, relative to the page. */
export interface SavedMessage {
  kind: 'saved';
  name: string;
  path: string;
}

/** The page of --report: what the JSON summary says, the command line, and charts. */
export interface ReportMessage {
  kind: 'report';
  command: string; // as typed
  summary: Record<string, unknown>;
  charts: ChartData[];
}
export interface ChartData {
  title: string;
  across: string;
  up: string;
  logarithmic: boolean;
  lines: { name: string; x: (number | null)[]; y: (number | null)[] }[];
}
/** A moment of a time series in a report. Arrays: values (columns a vertex), or displacement (3 a vertex). */
export interface MomentMessage {
  kind: 'moment';
  name: string;
  time: number;
  columns: number;
}

/** With view --screenshot: draw this, send the PNG as a binary message, and be done. */
export interface ShootMessage {
  kind: 'shoot';
  width: number;
  height: number;
  view: string; // front, back, left, right, top, bottom, iso, or "x,y,z"
  up: 'x' | 'y' | 'z';
  field: string; // '' for none
  range: [number, number] | null; // of the field's colour scale
  isolines: boolean;
  edges: boolean;
  dark: boolean;
}

export type Message =
  | MeshMessage
  | FieldMessage
  | StateMessage
  | FrameMessage
  | SpectrumMessage
  | ProgressMessage
  | DoneMessage
  | RefusedMessage
  | SavedMessage
  | ReportMessage
  | MomentMessage
  | ShootMessage;

/** `id` is the page's own count, ascending. */
export type Request = { id?: number } & (
  | { do: 'task'; task: Task }
  | { do: 'field'; name: string }
  | { do: 'heat.source'; vertex: number; value: number | null } // null: let go
  | { do: 'heat.set'; time?: number; steps?: number }
  | { do: 'wave.impulse'; vertex: number; value: number | null }
  | { do: 'wave.set'; time?: number; steps?: number; beta_2?: number }
  | { do: 'run' } // of the task heat or wave; frames follow
  | { do: 'pause' }
  | { do: 'resume' }
  | { do: 'cancel' }
  | { do: 'clear' } // what was placed in the current task
  | { do: 'paint.fix'; vertices: number[]; value: number[] | null }
  | { do: 'paint.set'; mode?: PaintMode; gamma_1?: number; gamma_2?: number; bounded?: boolean }
  | { do: 'poke.hold'; point: [number, number, number]; displacement: [number, number, number] } // point: of the surface at rest
  | { do: 'poke.release' }
  | { do: 'harmonics.compute'; count: number }
  | { do: 'harmonics.show'; k: number | null }
  | { do: 'harmonics.filter'; curve: [number, number][] | null; on: FilterTarget }
  // csv: what was placed, or the path of a poke. step: of heat and waves, a moment that is kept; without it the last.
  | { do: 'save'; format: 'ply' | 'obj' | 'vtu' | 'csv'; step?: number }
);

/** A message with its arrays. */
export interface Received {
  message: Message;
  arrays: Arrays;
}

export function decodeText(text: string): Received {
  return { message: JSON.parse(text) as Message, arrays: {} };
}

export function decodeParcel(buffer: ArrayBuffer, start = 0): Received {
  const length = new DataView(buffer).getUint32(start, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, start + 4, length))) as Message & {
    arrays: Record<string, ArrayPlace>;
  };
  const base = start + 4 + length;
  const arrays: Arrays = {};
  for (const [name, place] of Object.entries(header.arrays)) {
    arrays[name] =
      place.type === 'f32'
        ? new Float32Array(buffer, base + place.at, place.count)
        : new Uint32Array(buffer, base + place.at, place.count);
  }
  return { message: header, arrays };
}
