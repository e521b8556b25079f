/** The socket: what comes is unpacked and handed on, orders go back; it opens again when it was lost. */

const TYPES = { float32: Float32Array, int32: Int32Array };

/** A header with the arrays that follow it, under their names; taut/view/wire.py describes the message. */
export function unpack(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  let at = 4 + size;
  const arrays = {};
  for (const { name, type, shape } of header.arrays) {
    const count = shape.reduce((product, part) => product * part, 1);
    arrays[name] = new TYPES[type](buffer, at, count);
    at += 4 * count;
  }
  return { ...header, arrays };
}

export class Wire {
  /** `handlers`: layout, picture, status, refused, lost; each is given a message. */
  constructor(handlers) {
    this.handlers = handlers;
    this.pause = 250;
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/socket`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => {
      const message = typeof data === "string" ? JSON.parse(data) : unpack(data);
      this.pause = 250;
      this.handlers[message.type]?.(message);
    };
    this.socket.onclose = () => {
      this.handlers.lost();
      setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(4000, 2 * this.pause);
    };
  }

  /** Send an order, if there is a connection. */
  send(type, fields = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ type, ...fields }));
  }
}
