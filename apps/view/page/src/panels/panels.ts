// The panels of the tasks. They are a function of what the program says: it holds what the user did, so a page that is
// loaded again finds all of it.
//
//     const panels = new Panels(shell, send, hosts);
//     panels.receive(received);      // every message but mesh, field, report, moment and shoot
//     panels.activate('heat');       // the panel whose task the picture shows
import './panels.css';
import type { FrameMessage, Received, Request, Task } from '../protocol';
import type { Shell, Viewer } from '../viewer';
import { Harmonics } from './harmonics';
import { heatPanel } from './heat';
import { give } from './keep';
import { Paint } from './paint';
import type { Context, Panel } from './panel';
import { Poke } from './poke';
import { plain } from './touch';
import { wavePanel } from './wave';
import { outcomeOf } from './work';

type Worked = Exclude<Task, 'look'>;

export class Panels implements Context {
  active: Task = 'look';
  private readonly panels: Record<Worked, Panel> & { harmonics: Harmonics };
  private viewer: Viewer | null = null; // that `active` was shown in
  private phase = '';

  constructor(
    readonly shell: Shell,
    readonly send: (request: Request) => number,
    hosts: Record<Worked, HTMLElement>,
  ) {
    for (const host of Object.values(hosts)) host.classList.add('panel');
    this.panels = {
      heat: heatPanel(this, hosts.heat),
      wave: wavePanel(this, hosts.wave),
      paint: new Paint(this, hosts.paint),
      poke: new Poke(this, hosts.poke),
      harmonics: new Harmonics(this, hosts.harmonics),
    };
  }

  receive({ message, arrays }: Received): void {
    switch (message.kind) {
      case 'state':
        for (const panel of Object.values(this.panels)) panel.update(message);
        break;
      case 'frame':
        this.of(message.task)?.frame(message, arrays);
        break;
      case 'spectrum':
        this.panels.harmonics.spectrum(message, arrays);
        break;
      case 'progress':
        this.of(message.task)?.work.progress(message);
        // Once for each phase: the line is read aloud.
        if (message.phase !== this.phase) this.shell.say(message.phase);
        this.phase = message.phase;
        break;
      case 'done': {
        this.of(message.task)?.work.done(message);
        const [text, look] = outcomeOf(message);
        this.phase = '';
        this.shell.say(message.hint === '' ? text : `${text} (${message.hint})`, look === 'failed');
        break;
      }
      case 'refused':
        this.of(this.active)?.work.refused(message);
        this.shell.say(message.hint === '' ? message.what : `${message.what} (${message.hint})`, true);
        break;
      case 'saved':
        void give(message, this.shell);
        break;
      default: // of the shell
        break;
    }
  }

  answered(frame: FrameMessage): void {
    this.of(frame.task)?.answered?.(frame);
  }

  activate(task: Task): void {
    const { viewer } = this.shell;
    if (task === this.active && viewer === this.viewer) return;
    this.of(this.active)?.hide();
    this.active = task;
    this.viewer = viewer;
    plain(viewer);
    this.of(task)?.show();
  }

  private of(task: Task): Panel | null {
    return task === 'look' ? null : this.panels[task];
  }
}
