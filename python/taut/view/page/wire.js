/** The socket: what comes is unpacked and handed on, orders go back; it opens again when it was lost. */

/** @typedef {{ name: string, type: keyof typeof TYPES, shape: number[] }} Listed */

const TYPES = { float32: Float32Array, int32: Int32Array };

/**
 * A header with the arrays that follow it, under their names; taut/view/wire.py describes the message.
 * @param {ArrayBuffer} buffer
 */
export function unpack(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  let at = 4 + size;
  /** @type {Arrays} */
  const arrays = {};
  for (const { name, type, shape } of /** @type {Listed[]} */ (header.arrays)) {
    const count = shape.reduce((product, part) => product * part, 1);
    arrays[name] = new TYPES[type](buffer, at, count);
    at += 4 * count;
  }
  return { ...header, arrays };
}

export class Wire {
  /**
   * `handlers`: layout, picture, status, refused, lost; each is given a message.
   * @param {Handlers} handlers
   */
  constructor(handlers) {
    this.handlers = handlers;
    this.pause = 250;
    this.socket = this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      const message = typeof data === "string" ? JSON.parse(data) : unpack(data);
      this.pause = 250;
      /** @type {Record<string, (message: any) => void>} */ (/** @type {object} */ (this.handlers))[message.type]?.(message);
    };
    socket.onclose = () => {
      this.handlers.lost();
      setTimeout(() => (this.socket = this.open()), this.pause);
      this.pause = Math.min(4000, 2 * this.pause);
    };
    return socket;
  }

  /**
   * Send an order, if there is a connection.
   * @param {string} type
   * @param {object} fields
   */
  send(type, fields = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ type, ...fields }));
  }
}
