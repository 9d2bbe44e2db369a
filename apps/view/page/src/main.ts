// Puts the page together: a source of messages, the frame of the page, the picture, and the tabs.
import './style.css';
import { inspect } from './inspection';
import { HelpSheet, listen, type Shortcut } from './look/keys';
import { LookPanel } from './look/look_panel';
import { Moments } from './look/moments';
import { Fields } from './look/fields';
import { Readout } from './look/readout';
import { compose } from './look/screenshot';
import { PageShell, type Tab } from './look/shell';
import { download } from './dom';
import { Panels } from './panels/panels';
import type {
  FrameMessage,
  MeshMessage,
  Received,
  ReportMessage,
  Request,
  ShootMessage,
  StateMessage,
  Task,
} from './protocol';
import { showReport } from './report/report_panel';
import { SceneViewer } from './scene/scene_viewer';
import { viewNames } from './scene/camera';
import { Stage } from './scene/stage';
import { LiveSource, ReportSource } from './source';

const tasks = ['heat', 'wave', 'paint', 'poke', 'harmonics'] as const;
const live = !ReportSource.here();
const patience = 1000; // ms that the picture in full waits for an answer

let viewer: SceneViewer | null = null;
let panels: Panels | null = null;
let look: LookPanel | null = null;
let fields: Fields | null = null;
let moments: Moments | null = null;
let report: ReportMessage | null = null;
/** What the user turned to, until the program says that it has. */
let turning: { to: Task; id: number } | null = null;
/** Came before the mesh. */
const early: Received[] = [];
/** Frames that newer ones replace, until a picture is drawn. */
const unseen = new Map<string, Received>();

const shortcuts: Shortcut[] = [
  { keys: ['f'], shown: 'f', what: 'fit the mesh into the picture', act: () => fit() },
  {
    keys: ['1', '2', '3', '4', '5', '6', '7'],
    shown: '1 \u2013 7',
    what: viewNames.join(', '),
    act: (key) => look?.view(viewNames[Number(key) - 1]),
  },
  { keys: ['w'], shown: 'w', what: 'wireframe', act: () => look?.toggle('wireframe') },
  { keys: ['b'], shown: 'b', what: 'boundary edges', act: () => look?.toggle('boundary') },
  { keys: ['n'], shown: 'n', what: 'non-manifold edges', act: () => look?.toggle('nonManifold') },
  { keys: ['i'], shown: 'i', what: 'isolines', act: () => look?.toggle('isolines') },
  { keys: ['v'], shown: 'v', what: 'arrows of a vector field', act: () => look?.toggle('vectors') },
  { keys: [' '], shown: 'space', what: 'play and pause', act: () => shell.timeline.toggle() },
  { keys: ['ArrowLeft'], shown: '\u2190', what: 'the moment before', act: () => shell.timeline.step(-1) },
  { keys: ['ArrowRight'], shown: '\u2192', what: 'the next moment', act: () => shell.timeline.step(1) },
  { keys: ['d'], shown: 'd', what: 'light or dark', act: () => shell.theme.toggle() },
  { keys: ['s'], shown: 's', what: 'save the picture', act: () => void saveScreenshot() },
  { keys: ['c'], shown: 'c', what: 'show or hide the controls', act: () => shell.toggleSide() },
  { keys: ['?'], shown: '?', what: 'this sheet', act: () => help.toggle() },
];
const help = new HelpSheet(shortcuts);
const shell = new PageShell(live ? ['look', ...tasks] : ['report', 'look'], {
  fit: () => fit(),
  screenshot: () => void saveScreenshot(),
  help: () => help.toggle(),
});
const say = (text: string, error?: boolean): void => shell.say(text, error);

const source = live
  ? new LiveSource(receive, say, (connected) => {
      document.body.classList.toggle('apart', !connected);
      turning = null;
    })
  : new ReportSource(receive, say, () => endOfReport());
const send = (request: Request): number => (source instanceof LiveSource ? source.send(request) : 0);

const seen = inspect({ shell, source, viewer: () => viewer });

function receive(received: Received): void {
  const { message } = received;
  if (message.kind === 'mesh') {
    if (viewer) restart(viewer, message);
    else begin(message, received);
  } else if (message.kind === 'report') {
    report = message;
    if (viewer) tellReport();
  } else if (!viewer) {
    if (message.kind === 'progress') shell.excuse(message.phase);
    early.push(received);
  } else {
    handle(received);
  }
}

function begin(mesh: MeshMessage, received: Received): void {
  try {
    viewer = new SceneViewer(new Stage(shell.stage, say), mesh, received.arrays);
  } catch (error) {
    shell.excuse(`There is no picture: ${error instanceof Error ? error.message : String(error)}. It needs WebGL 2.`);
    tellReport(mesh);
    return;
  }
  const scene = viewer;
  shell.attach(scene);
  new Readout(scene, shell.stage);
  fields = new Fields(scene, mesh, live ? (name) => void send({ do: 'field', name }) : null);
  moments = new Moments(scene, shell.timeline);
  look = new LookPanel(shell, scene, shell.hosts.look, fields);
  if (live) {
    const { heat, wave, paint, poke, harmonics } = shell.hosts;
    panels = new Panels(shell, send, { heat, wave, paint, poke, harmonics });
  } else {
    tellReport(mesh);
  }
  shell.onTab = (tab: Tab) => {
    if (tab === 'report' || !live) return;
    turnTo(tab);
    say(''); // of the task before
    turning = { to: tab, id: send({ do: 'task', task: tab }) };
  };
  scene.stage.atFirst(() => {
    const newest = [...unseen.values()];
    unseen.clear();
    for (const frame of newest) panels?.receive(frame);
  });
  if (source instanceof LiveSource) {
    const { latencies } = source;
    scene.stage.afterRender(() => latencies.painted());
    scene.stage.expects = () => latencies.awaited(patience);
  }
  // The first pick waits for a tree: it is built while nobody waits, but where it takes long only when it is needed.
  if (received.arrays.triangles?.length < 1.5e6) whenIdle(() => scene.preparePicking());
  for (const message of early.splice(0)) handle(message);
  if (!live) return;
  whenIdle(() => scene.rehearseField());
  if (shell.tab === 'look') look.recallField();
  seen.ready();
  say('Drag to turn, right drag to move, wheel to come nearer; ? shows the keys.');
}

function handle(received: Received): void {
  const { message, arrays } = received;
  if (!viewer || !fields || !moments || !look) return;
  switch (message.kind) {
    case 'shoot':
      void shoot(viewer, message);
      return;
    case 'moment':
      moments.add(message, arrays);
      return;
    case 'field':
      fields.receive(message, arrays);
      look.listFields();
      break;
    case 'state':
      follow(message);
      break;
    case 'frame':
      noteFrame(message);
      // Each moment of heat and waves is kept; of what follows a hand only the newest counts.
      if (message.task === 'heat' || message.task === 'wave') break;
      unseen.set(`${message.task} ${message.on ?? ''}`, received);
      return;
  }
  panels?.receive(received);
}

function follow(state: StateMessage): void {
  seen.state = state;
  // It may have been under way when the user chose another task.
  if (turning && state.task !== turning.to && (state.id ?? Infinity) < turning.id) return;
  turning = null;
  if (state.task === shell.tab) return;
  shell.choose(state.task, false);
  turnTo(state.task);
}

/** The picture is of another task. */
function turnTo(task: Task): void {
  viewer?.showVectors('', null);
  look?.goTo(task === 'look' ? null : shell.hosts[task]);
  panels?.activate(task);
  if (task === 'look') look?.showAgain();
}

function noteFrame(frame: FrameMessage): void {
  seen.noteFrame(frame);
  panels?.answered(frame);
  if (source instanceof LiveSource) source.latencies.answered(frame.id);
  // It counts as painted with the next picture, also where it changes nothing.
  viewer?.stage.invalidate();
}

/** The program sends the mesh whenever the page connects. */
function restart(scene: SceneViewer, mesh: MeshMessage): void {
  const same =
    mesh.name === scene.mesh.name && mesh.vertices === scene.mesh.vertices && mesh.brief === scene.mesh.brief;
  if (!same) location.reload();
}

function tellReport(mesh: MeshMessage | null = viewer?.mesh ?? null): void {
  if (report && shell.hosts.report) showReport(shell.hosts.report, report, mesh, shell.theme, say);
}

function endOfReport(): void {
  if (!viewer) shell.excuse('This report has no mesh.');
  tellReport();
  if (!look?.recallField()) fields?.showFirst();
  moments?.complete();
  look?.listFields();
  seen.ready();
  say('Everything is in this file. ? shows the keys.');
}

function fit(): void {
  viewer?.fit();
  look?.rememberCamera();
}

async function saveScreenshot(): Promise<void> {
  if (!viewer) return;
  const [width, height] = viewer.stage.size;
  const scale = Math.max(viewer.stage.pixelRatio, 2);
  try {
    const size = { width: Math.round(width * scale), height: Math.round(height * scale), scale };
    const picture = await compose(viewer, shell.legend, shell.theme.palette, size);
    download(`${viewer.mesh.name.replace(/\.[^.]*$/, '') || 'mesh'}.png`, picture);
    say('The picture is in your downloads.');
  } catch (error) {
    say(`There is no picture: ${error instanceof Error ? error.message : String(error)}`, true);
  }
}

async function shoot(scene: SceneViewer, wanted: ShootMessage): Promise<void> {
  const { width, height } = wanted;
  shell.theme.choose(wanted.dark ? 'dark' : 'light', false);
  const range = wanted.range && { of: wanted.field, ends: wanted.range };
  scene.display = { ...scene.display, wireframe: wanted.edges, isolines: wanted.isolines, range };
  if (wanted.field && fields) await fields.whenShown(wanted.field);
  const legend = scene.shown.kind === 'plain' ? 0 : 40;
  scene.stage.insets = () => ({ top: 0, right: 0, bottom: legend, left: 0 });
  scene.stage.fitFor(width, height, () => scene.fit(wanted.view, wanted.up, width / height));
  const picture = await compose(scene, shell.legend, shell.theme.palette, { width, height, scale: 1 });
  if (source instanceof LiveSource) source.sendBytes(picture);
}

function whenIdle(work: () => void): void {
  if ('requestIdleCallback' in window) requestIdleCallback(work, { timeout: 2000 });
  else setTimeout(work, 300);
}

listen(shortcuts);
source.start();
