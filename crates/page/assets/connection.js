// The connection to the program: it is made again when it is lost, and measures the difference of the clocks.

const PING_EVERY_MS = 1000;
const RETRY_MS = 700;

export class Connection {
  /** `on` has a function for each kind of message, and `opened`, `lost` and `denied`. */
  constructor(on) {
    this.on = on;
    this.offset = 0; // host's clock minus ours, s
    this.roundTrip = Infinity;
    this.open();
    setInterval(() => this.send({ ping: performance.now() / 1000 }), PING_EVERY_MS);
  }

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.socket = new WebSocket(`${scheme}://${location.host}/ws${location.search}`);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => { this.roundTrip = Infinity; this.send({ ping: performance.now() / 1000 }); this.on.opened(); };
    this.socket.onmessage = event => this.take(event.data);
    this.socket.onclose = () => { this.on.lost(); this.askWhy(); setTimeout(() => this.open(), RETRY_MS); };
  }

  /** Asks why the connection was refused, if it was. */
  async askWhy() {
    const answer = await fetch(`access${location.search}`).catch(() => null);
    if (answer?.status === 403) this.on.denied(await answer.text());
  }

  send(request) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(request));
    return true;
  }

  take(data) {
    if (typeof data !== 'string') { this.on.fields(data); return; }
    for (const [kind, value] of Object.entries(JSON.parse(data))) {
      if (kind === 'pong') this.measure(value); else this.on[kind]?.(value);
    }
  }

  /** The shortest round trip tells best how far the clocks are apart. */
  measure({ sent, now_s }) {
    const now = performance.now() / 1000, roundTrip = now - sent;
    if (roundTrip < 1.5 * this.roundTrip) {
      this.roundTrip = Math.min(roundTrip, this.roundTrip);
      this.offset = now_s - (sent + roundTrip / 2);
    }
  }

  /** The host's time, s. */
  now() { return performance.now() / 1000 + this.offset; }
}
