/** Stills and films of what the picture shows, as downloads. */

const stamp = () => new Date().toISOString().slice(0, 19).replaceAll(":", "-");

/**
 * @param {Blob} blob
 * @param {string} name
 */
function download(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/**
 * Save the canvas as it is; it must have been drawn in this very turn of the event loop.
 * @param {HTMLCanvasElement} canvas
 */
export function saveStill(canvas) {
  canvas.toBlob((blob) => blob && download(blob, `taut-${stamp()}.png`), "image/png");
}

/** A film while it is being taken: `stop()` saves it, with one picture at least. */
export class Film {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    const type = ["video/mp4;codecs=avc1.640028", "video/webm;codecs=vp9", "video/webm"].find((kind) => MediaRecorder.isTypeSupported(kind));
    if (!type) throw new Error("this browser cannot record films");
    /** @type {Blob[]} */
    const parts = [];
    this.recorder = new MediaRecorder(canvas.captureStream(60), { mimeType: type, videoBitsPerSecond: 12_000_000 });
    // A busy machine has encoded nothing yet when a short film is to end; a file without a picture is none.
    this.encoded = false;
    this.ending = false;
    this.recorder.ondataavailable = ({ data }) => {
      parts.push(data);
      this.encoded ||= data.size > 0;
      if (this.ending) this.stop();
    };
    this.recorder.onstop = () => {
      const kind = type.split(";")[0];
      download(new Blob(parts, { type: kind }), `taut-${stamp()}.${kind.split("/")[1]}`);
    };
    this.recorder.start(100);
  }

  stop() {
    this.ending = true;
    if (this.encoded && this.recorder.state !== "inactive") this.recorder.stop();
  }
}
