/** A button that has to be held: too much hangs on it for a touch by mistake, and nobody should have to answer a question. */

import { Component, html } from "./vendor.js";

export const HOLD_MS = 600;

/**
 * Fires after being held, by pointer or by Space or Enter. A click without a press before it comes from assistive
 * technology, which cannot hold, and fires at once.
 */
export class HoldButton extends Component {
  /** @param {{label: any, name: string, kind?: string, how?: string, longer?: string, disabled?: boolean, onFire: () => void}} props
   *  `how` to press it, and what is said when that was too short */
  constructor(props) {
    super(props);
    this.props = props;
    this.timer = 0;
    this.begun_ms = 0;
    this.pressed = false;
    this.state = { holding: false, hint: false };
  }

  componentWillUnmount() {
    clearTimeout(this.timer);
  }

  /** @param {Event} event */
  begin(event) {
    if (this.props.disabled || this.timer) return;
    this.pressed = true;
    this.begun_ms = event.timeStamp;
    this.setState({ holding: true, hint: false });
    this.timer = setTimeout(() => this.fire(), HOLD_MS);
  }

  fire() {
    clearTimeout(this.timer);
    this.timer = 0;
    this.setState({ holding: false });
    this.props.onFire();
  }

  /** A page that is busy hears late that time is up, after the button was let go: the fingers' own time counts. @param {Event} event */
  end(event) {
    if (!this.timer) return;
    if (event.timeStamp - this.begun_ms >= HOLD_MS) {
      this.fire();
      return;
    }
    clearTimeout(this.timer);
    this.timer = 0;
    this.setState({ holding: false, hint: true });
    setTimeout(() => this.setState({ hint: false }), 2500);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault(); // or the browser clicks when the key is let go
    if (event.type === "keydown") this.begin(event);
    else this.end(event);
  }

  click() {
    if (!this.pressed) this.props.onFire();
    this.pressed = false;
  }

  render() {
    const { label, name, kind = "", how = "Press and hold", longer = "Press longer", disabled } = this.props;
    const { holding, hint } = this.state;
    const end = (/** @type {Event} */ event) => this.end(event);
    return html`<button type="button" class=${`hold ${kind}`} data-holding=${holding ? "" : null} disabled=${disabled}
      aria-label=${name} title=${how} onPointerDown=${(/** @type {PointerEvent} */ event) => {
        if (event.button === 0) this.begin(event);
      }} onPointerUp=${end} onPointerLeave=${end} onPointerCancel=${end}
      onKeyDown=${(/** @type {KeyboardEvent} */ event) => this.key(event)}
      onKeyUp=${(/** @type {KeyboardEvent} */ event) => this.key(event)} onBlur=${end}
      onContextMenu=${(/** @type {Event} */ event) => event.preventDefault()} onClick=${() => this.click()}>
      <span>${hint ? longer : label}</span></button>`;
  }
}
