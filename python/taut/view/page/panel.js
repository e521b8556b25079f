/** The controls beside the picture, as the server lists them. */

/** @typedef {HTMLInputElement | HTMLSelectElement} Input */

/**
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {object} fields
 * @param {Node[]} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
const element = (tag, fields = {}, children = []) => {
  const made = Object.assign(document.createElement(tag), fields);
  made.append(...children);
  return made;
};

export class Controls {
  /**
   * `send`: gives a control a value.
   * @param {HTMLElement} place
   * @param {(control: string, value: number | string) => void} send
   */
  constructor(place, send) {
    this.place = place;
    this.send = send;
    /** @type {Map<string, { input: Input, output?: HTMLOutputElement }>} */
    this.shown = new Map();
    /** Whether somebody moves one of them. */
    this.moving = false;
  }

  /**
   * Show the controls with their values; one that is being moved is left alone.
   * @param {Control[]} controls
   */
  update(controls) {
    if (this.shown.size !== controls.length) this.build(controls);
    for (const control of controls) {
      const shown = this.shown.get(control.name);
      if (!shown) continue;
      const { input, output } = shown;
      if (input !== document.activeElement || control.choices.length || !this.moving) input.value = String(control.value);
      if (output) output.replaceChildren(figure(control.value, control));
    }
  }

  /** @param {Control[]} controls */
  build(controls) {
    this.shown.clear();
    /** @type {Map<string, HTMLElement>} */
    const groups = new Map();
    for (const control of controls) {
      const group = groups.get(control.group) ?? element("details", { open: true }, [element("summary", { textContent: control.group })]);
      groups.set(control.group, group);
      group.append(this.one(control));
    }
    this.place.replaceChildren(...groups.values());
  }

  /** @param {Control} control */
  one(control) {
    const id = `control-${control.name}`;
    const label = element("label", { textContent: control.label, htmlFor: id });
    if (control.choices.length) {
      const options = control.choices.map((word) => element("option", { value: word, textContent: word.replaceAll("_", " ") }));
      const input = element("select", { id }, options);
      input.onchange = () => this.send(control.name, input.value);
      this.shown.set(control.name, { input });
      return element("div", { className: "control" }, [label, input]);
    }
    const { low, high, step } = control;
    const input = element("input", { id, type: "range", min: low, max: high, step });
    const output = element("output");
    input.oninput = () => {
      this.moving = true;
      output.replaceChildren(figure(Number(input.value), control));
      this.send(control.name, Number(input.value));
    };
    input.onchange = () => (this.moving = false);
    this.shown.set(control.name, { input, output });
    return element("div", { className: "control" }, [label, input, output]);
  }
}

/**
 * @param {number | string} value
 * @param {Control} control
 */
function figure(value, { step, unit, name }) {
  if (name === "substeps") return Number(value) < 1 ? "auto" : String(value);
  const digits = step < 1 ? 1 : 0;
  return `${Number(value).toFixed(digits)} ${unit}`;
}
