// Where messages come from: the program, through a socket, or the page itself, which holds those of a report.
import { decodeParcel, decodeText, type Received, type Request } from './protocol';

export interface Source {
  readonly live: boolean;
  start(): void;
}

type Listener = (received: Received) => void;
type Say = (text: string, error?: boolean) => void;

/** How long an answer took: milliseconds of the page's clock. */
export interface Latency {
  id: number;
  do: Request['do'];
  sent: number;
  received: number;
  painted: number;
}

/** Requests of a hand, which a frame answers. */
const touches: ReadonlySet<Request['do']> = new Set([
  'paint.fix',
  'paint.set',
  'poke.hold',
  'poke.release',
  'harmonics.show',
  'harmonics.filter',
] as const);

/** From a request to the picture that shows its answer. */
export class Latencies {
  readonly measured: Latency[] = [];
  /** Pictures that showed a frame which none had shown before. */
  shown = 0;
  private newer = false;
  private readonly waiting = new Map<number, { do: Request['do']; sent: number }>();
  private unpainted: Latency[] = [];
  private static readonly most = 10_000;

  /** A frame will answer what was asked within the last `patience` milliseconds. */
  awaited(patience: number): boolean {
    const since = performance.now() - patience;
    return [...this.waiting.values()].some((request) => request.sent > since && touches.has(request.do));
  }

  sent(id: number, what: Request['do']): void {
    this.waiting.set(id, { do: what, sent: performance.now() });
  }

  /** A frame that answers `id`, and with it all that was asked before. */
  answered(id: number): void {
    this.newer = true;
    const request = this.waiting.get(id);
    if (!request) return;
    this.unpainted.push({ id, ...request, received: performance.now(), painted: NaN });
    for (const earlier of this.waiting.keys()) {
      if (earlier > id) break;
      this.waiting.delete(earlier);
    }
  }

  /** A picture has been drawn that shows everything received so far. */
  painted(): void {
    if (this.newer) ++this.shown;
    this.newer = false;
    if (this.unpainted.length === 0) return;
    const shown = this.unpainted;
    this.unpainted = [];
    // A task of its own comes after the browser has taken the picture.
    setTimeout(() => {
      const now = performance.now();
      for (const latency of shown) this.measured.push({ ...latency, painted: now });
      this.measured.splice(0, this.measured.length - Latencies.most);
    });
  }
}

const firstPause = 250; // ms before the connection is tried again; doubles
const longestPause = 5000;

export class LiveSource implements Source {
  readonly live = true;
  readonly latencies = new Latencies();
  connected = false;
  private socket: WebSocket | null = null;
  private id = 0;
  private pause = firstPause;
  private everOpen = false;

  constructor(
    private readonly listener: Listener,
    private readonly say: Say,
    private readonly onConnected: (connected: boolean) => void,
  ) {}

  start(): void {
    const address = new URL('socket', location.href);
    address.protocol = address.protocol.replace('http', 'ws');
    address.hash = address.search = '';
    const socket = new WebSocket(address);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      if (this.everOpen) this.say('Connected again.');
      this.everOpen = this.connected = true;
      this.pause = firstPause;
      this.onConnected(true);
    };
    socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) =>
      this.listener(typeof data === 'string' ? decodeText(data) : decodeParcel(data));
    socket.onclose = ({ reason }) => {
      if (this.connected) this.onConnected(false);
      this.connected = false;
      this.socket = null;
      this.say(
        (this.everOpen ? 'The connection to Beltrami is lost' : 'Beltrami does not answer') +
          `${reason ? ` (${reason})` : ''}; trying again. What you see stays.`,
        true,
      );
      setTimeout(() => this.start(), this.pause);
      this.pause = Math.min(2 * this.pause, longestPause);
    };
    this.socket = socket;
  }

  /** Gives the request the next id; what is asked while there is no connection is lost. */
  send(request: Request): number {
    const id = ++this.id;
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.latencies.sent(id, request.do);
      this.socket.send(JSON.stringify({ ...request, id }));
    }
    return id;
  }

  sendBytes(bytes: Blob): void {
    this.socket?.send(bytes);
  }
}

const selector = 'script.beltrami-message';
const smallText = 1 << 16; // characters

export class ReportSource implements Source {
  readonly live = false;

  /** Whether this page holds a report. */
  static here(): boolean {
    return document.querySelector(selector) !== null;
  }

  constructor(
    private readonly listener: Listener,
    private readonly say: Say,
    private readonly whenAll: () => void,
  ) {}

  start(): void {
    void this.read();
  }

  private async read(): Promise<void> {
    try {
      const scripts = [...document.querySelectorAll(selector)];
      // The report is small and is read while the arrays are unpacked, wherever in the page it stands.
      for (const script of scripts) {
        if ((script.textContent ?? '').length < smallText) await this.take(script, (kind) => kind === 'report');
      }
      for (const script of scripts) {
        if (script.isConnected) await this.take(script, () => true);
      }
    } catch (error) {
      this.say(`This report is damaged: ${error instanceof Error ? error.message : String(error)}`, true);
    }
    this.whenAll();
  }

  private async take(script: Element, wanted: (kind: string) => boolean): Promise<void> {
    const received = decodeStored(await inflate(script.textContent ?? ''));
    if (!wanted(received.message.kind)) return;
    script.remove(); // its text is as large again as the data
    this.listener(received);
  }
}

async function inflate(base64: string): Promise<Uint8Array<ArrayBuffer>> {
  const text = atob(base64.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** 'T' and a JSON text, or 'P', three bytes of padding and a parcel. */
function decodeStored(bytes: Uint8Array<ArrayBuffer>): Received {
  const kind = String.fromCharCode(bytes[0]);
  if (kind === 'T') return decodeText(new TextDecoder().decode(bytes.subarray(1)));
  if (kind === 'P') return decodeParcel(bytes.slice(4).buffer);
  throw new Error(`a message begins with ${JSON.stringify(kind)}`);
}
